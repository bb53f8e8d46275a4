//! Styles of curves: colours that colour-blind readers can tell apart, and dashes and marks that
//! tell curves apart without any colour.

use super::svg::{Canvas, Pen, SHAPES, Shape};
use super::{Curve, Stroke};

/// Okabe and Ito (2008), the blue a little brighter for dark pages, those with the least contrast
/// to white last, and grey.
pub const COLOURS: [&str; 7] = [
    "#1F82C0", // blue
    "#D55E00", // vermilion
    "#009E73", // bluish green
    "#CC79A7", // reddish purple
    "#E69F00", // orange
    "#56B4E9", // sky blue
    "#888888",
];
/// Neither a curve nor text; shows on white and on black.
pub const NEUTRAL: &str = COLOURS[6];
/// Patterns of dashed lines.
const DASHES: [&str; 4] = ["7 4", "3 3", "11 3 3 3", "14 5"];
/// Width of a curve in pixels.
const WIDTH: f64 = 1.8;
/// Radius of the marks of values.
const RADIUS: f64 = 3.8;
/// Radius of the marks by which full lines differ.
const SMALL: f64 = 2.8;
/// Distance of the marks on a full line.
const APART: f64 = 75.0;

/// Appearance of a curve.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    stroke: Stroke,
    colour: &'static str,
    dash: &'static str,
    /// The form of the marks, if there are any.
    shape: Option<Shape>,
    /// Distance from the beginning of a full line to its first mark.
    first: f64,
}

/// The styles of the curves of a chart. A curve without a name looks like the named one of its
/// colour before it. Several full lines have a small mark here and there, of another form each.
pub fn styles(curves: &[Curve<'_>]) -> Vec<Style> {
    let full = curves.iter().filter(|c| c.stroke == Stroke::Line && !c.name.is_empty()).count();
    // Colours whose last named curve has this form or pattern.
    let (mut marked, mut dashed) = (Vec::new(), Vec::new());
    let mut styles = Vec::new();
    for (k, curve) in curves.iter().enumerate() {
        let colour = curve.colour.unwrap_or(k) % COLOURS.len();
        let with_mark = match curve.stroke {
            Stroke::Points | Stroke::Marked => true,
            Stroke::Line => full > 1 && !curve.name.is_empty(),
            Stroke::Dashed => false,
        };
        let shape = with_mark.then(|| SHAPES[place(&mut marked, curve, colour) % SHAPES.len()]);
        let dash = match curve.stroke {
            Stroke::Dashed => DASHES[place(&mut dashed, curve, colour) % DASHES.len()],
            _ => "",
        };
        // Marks of lines that lie on each other must not.
        let first = APART * (0.2 + (0.382 * marked.len() as f64) % 0.8);
        styles.push(Style { stroke: curve.stroke, colour: COLOURS[colour], dash, shape, first });
    }
    styles
}

/// The place of a curve among the named ones in `of`, the colours of these; without a name, that of
/// the last of its colour.
fn place(of: &mut Vec<usize>, curve: &Curve<'_>, colour: usize) -> usize {
    if curve.name.is_empty() {
        return of.iter().rposition(|c| *c == colour).unwrap_or(of.len());
    }
    of.push(colour);
    of.len() - 1
}

impl Style {
    /// Draws a run of points without a gap.
    pub fn draw(&self, canvas: &mut Canvas, points: &[[f64; 2]]) {
        if self.stroke != Stroke::Points {
            canvas.line(points, self.pen());
        }
        let Some(shape) = self.shape else { return };
        if self.stroke != Stroke::Line {
            points.iter().for_each(|p| canvas.mark(shape, *p, RADIUS, self.colour));
            return;
        }
        let (mut from, mut distance) = (points.first().copied().unwrap_or_default(), self.first);
        for p in points {
            if (p[0] - from[0]).hypot(p[1] - from[1]) >= distance {
                canvas.mark(shape, *p, SMALL, self.colour);
                (from, distance) = (*p, APART);
            }
        }
    }
    /// Draws the sample of a legend, between two abscissas.
    pub fn draw_key(&self, canvas: &mut Canvas, [left, right]: [f64; 2], y: f64) {
        if self.stroke != Stroke::Points {
            canvas.line(&[[left, y], [right, y]], self.pen());
        }
        if let Some(shape) = self.shape {
            let radius = if self.stroke == Stroke::Line { SMALL } else { RADIUS };
            canvas.mark(shape, [0.5 * (left + right), y], radius, self.colour);
        }
    }
    /// Its colour and its dashes, and whether values have marks that are not joined.
    pub fn words(&self) -> (&'static str, &'static str, bool) {
        (self.colour, self.dash, self.stroke == Stroke::Points)
    }
    fn pen(&self) -> Pen<'static> {
        Pen { colour: self.colour, width: WIDTH, dash: self.dash, opacity: 1.0 }
    }
}
