//! Slope triangles on logarithmic axes.

use super::super::numbers::trimmed;
use super::layout::Frame;
use super::style::NEUTRAL;
use super::svg::{Anchor, Canvas, Pen};
use super::text::width;

/// Font size of the order.
const SIZE: f64 = 12.0;
/// Distance of the order from its triangle.
const GAP: f64 = 6.0;

/// A triangle that shows a slope on logarithmic axes, its order written at its upright side: a
/// power of `x` from `x[0]` to `x[1]` that is `y` at `x[0]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Left and right end.
    pub x: [f64; 2],
    /// The ordinate at the left end.
    pub y: f64,
    /// The power.
    pub order: f64,
    /// True if the triangle lies above its slope, for a place above the curves; else below.
    pub above: bool,
}

impl Slope {
    /// The ordinate at the right end.
    fn end(&self) -> f64 {
        self.y * (self.x[1] / self.x[0]).powf(self.order)
    }
    /// The ends of the slope and the corner with the right angle.
    pub(super) fn corners(&self) -> [[f64; 2]; 3] {
        let ([left, right], end) = (self.x, self.end());
        let corner = if self.above { [left, end] } else { [right, self.y] };
        [[left, self.y], [right, end], corner]
    }
    /// True if logarithmic axes have a place for it.
    pub(super) fn is_sound(&self) -> bool {
        self.corners().iter().flatten().all(|v| v.is_finite() && *v > 0.0)
    }
    /// Draws the triangle and its order.
    pub(super) fn draw(&self, canvas: &mut Canvas, frame: &Frame) {
        let [a, b, corner] = self.corners().map(|p| frame.place(p));
        let pen = Pen { colour: NEUTRAL, width: 1.2, dash: "", opacity: 1.0 };
        canvas.line(&[a, b, corner, a], pen);
        let order = trimmed(&format!("{:.1}", self.order));
        let y = 0.5 * (a[1] + b[1]) + 0.35 * SIZE;
        // Outside the triangle, unless the plot ends there.
        let (x, wide) = (corner[0], GAP + width(&order, SIZE));
        let left = if self.above { x - wide > frame.left } else { x + wide > frame.right };
        match left {
            true => canvas.text(&order, [x - GAP, y], Anchor::End, SIZE),
            false => canvas.text(&order, [x + GAP, y], Anchor::Start, SIZE),
        }
    }
}
