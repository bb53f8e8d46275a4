//! Half-chords: how far the contour lies from a point along a line.

use super::contour::Contour;
use super::quadratic::Quadratic;
use crate::fem::Space;
use crate::mesh::Point;
use nalgebra::SVector;

/// How far, as a fraction of its length, a segment is prolonged, so that a line through a common end meets one of the two.
const OVERLAP: f64 = 1e-9;

impl Contour {
    /// Half the distance between the first zeros of `phi` on both sides of `point` on the line along `direction` (of any
    /// length): the semi-axis of a centred shape along that line.
    ///
    /// The crossing with the contour gives the cell; in it `phi` on the line is quadratic and its zero exact. `phi` must be
    /// the function that the contour was made from. `None` if there is no contour on one of the sides.
    pub fn half_chord(
        &self,
        space: &Space<2>,
        phi: &[f64],
        point: &Point<2>,
        direction: &SVector<f64, 2>,
    ) -> Option<f64> {
        let along = direction.try_normalize(0.0)?;
        let normal = SVector::<f64, 2>::new(-along[1], along[0]);
        let (mut before, mut after) = (f64::NEG_INFINITY, f64::INFINITY);
        for segment in self.segments() {
            let height = segment.points.map(|p| (p - point).dot(&normal));
            // The parabola stays within twice the spread of its three heights.
            let (low, high) = (height[0].min(height[1]).min(height[2]), height[0].max(height[1]).max(height[2]));
            if low - (high - low) > 0.0 || high + (high - low) < 0.0 {
                continue;
            }
            for t in Quadratic::through(height[0], height[1], height[2]).roots() {
                if !(-OVERLAP..=1.0 + OVERLAP).contains(&t) {
                    continue;
                }
                let l = segment.barycentric_at(t);
                let step = along * (segment.points[2] - segment.points[0]).norm();
                let correction = Quadratic::on_line(space, phi, segment.cell as usize, &l, &step).roots()[0];
                let mut s = (segment.point(t) - point).dot(&along);
                if correction.abs() < 0.1 {
                    s += correction * step.norm();
                }
                if s >= 0.0 {
                    after = after.min(s);
                }
                if s <= 0.0 {
                    before = before.max(s);
                }
            }
        }
        let half = 0.5 * (after - before);
        half.is_finite().then_some(half)
    }
}
