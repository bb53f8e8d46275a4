//! Line charts as SVG.
//!
//! Text takes the colour of the page around it (`currentColor`), lines and marks have colours that
//! colour-blind readers can tell apart and that show on white and on black: one chart serves a
//! light and a dark page.

mod axis;
mod cut;
mod data;
mod layout;
mod legend;
mod slope;
mod style;
mod svg;
#[cfg(test)]
mod tests;
mod text;

pub use slope::Slope;

use axis::Axis;
use layout::{HEIGHT, LABEL, LEADING, Layout, TITLE, WIDTH};
use style::Style;
pub use svg::OF_CHART;
use svg::{Anchor, Canvas};

/// Manner of drawing a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stroke {
    /// A full line.
    #[default]
    Line,
    /// A dashed line: references and slopes.
    Dashed,
    /// Marks: measured or published values.
    Points,
    /// Marks joined by a line: a row of runs.
    Marked,
}

impl Stroke {
    fn has_marks(self) -> bool {
        matches!(self, Stroke::Points | Stroke::Marked)
    }
}

/// A curve of a chart. Points with a coordinate that is not finite, or not positive on a
/// logarithmic axis, leave a gap. A curve without a name is not in the legend and looks like the
/// named one of its colour before it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Curve<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Abscissas.
    pub x: &'a [f64],
    /// Ordinates.
    pub y: &'a [f64],
    /// Line, dashes or marks.
    pub stroke: Stroke,
    /// Number of its colour; its place among the curves without it.
    pub colour: Option<usize>,
}

/// A chart of one or more curves.
#[derive(Clone, Debug, Default)]
pub struct Chart<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Label of the horizontal axis, with the unit if there is one.
    pub x_label: &'a str,
    /// Label of the vertical axis, with the unit if there is one.
    pub y_label: &'a str,
    /// True if the horizontal axis is logarithmic.
    pub log_x: bool,
    /// True if the vertical axis is logarithmic.
    pub log_y: bool,
    /// The curves.
    pub curves: Vec<Curve<'a>>,
    /// True if the range is that without the beginning of the curves, where it dwarfs the rest;
    /// a note then says what is cut off. For lines on linear axes.
    pub cut_start: bool,
    /// Slope triangles; drawn where both axes are logarithmic.
    pub slopes: Vec<Slope>,
}

/// A line of more points is thinned; no screen shows more.
const MOST_POINTS: usize = 4000;

/// Points of a curve without a gap.
type Piece = Vec<[f64; 2]>;

impl<'a> Chart<'a> {
    /// The chart as an SVG document that scales to the width of its page.
    pub fn svg(&self) -> String {
        let (curves, parts) = self.drawn();
        let has_place = |s: &&Slope| self.log_x && self.log_y && s.is_sound();
        let slopes: Vec<&Slope> = self.slopes.iter().filter(has_place).collect();
        let cut = self.cut_start.then(|| cut::start(&parts)).flatten();
        let Some(axes) = self.axes(&parts, &slopes, cut.as_ref()) else { return self.empty() };
        let styles = style::styles(&curves);
        let named = curves.iter().zip(&styles).filter(|(c, _)| !c.name.is_empty());
        let mut names: Vec<(&str, Style)> = named.map(|(c, s)| (c.name, *s)).collect();
        if self.curves.len() < 2 {
            names.clear();
        }
        let note = cut.as_ref().map_or("", |c| &c.note);
        let layout = Layout::new(axes, [self.title, note], [self.x_label, self.y_label], &names);
        let mut canvas = Canvas::default();
        layout.draw(&mut canvas);
        let ends = axes[1].ends();
        for (style, pieces) in styles.iter().zip(&parts) {
            canvas.group("curve", |canvas| {
                let shown = |piece: &Piece| match cut {
                    Some(_) => cut::clipped(piece, ends),
                    None => vec![piece.clone()],
                };
                for piece in pieces.iter().flat_map(shown) {
                    let points: Piece = piece.iter().map(|p| layout.frame.place(*p)).collect();
                    style.draw(canvas, &points);
                }
            });
        }
        slopes.iter().for_each(|s| s.draw(&mut canvas, &layout.frame));
        let data = data::json(self, &layout.frame, &curves, (&styles, &parts));
        canvas.document(layout.size, &self.name(), &data)
    }
    /// The curves that have a point, with their colours, and the runs of points of each.
    fn drawn(&self) -> (Vec<Curve<'a>>, Vec<Vec<Piece>>) {
        let coloured = |(k, c): (usize, &Curve<'a>)| Curve { colour: c.colour.or(Some(k)), ..*c };
        let all = self.curves.iter().enumerate().map(coloured).map(|c| (c, self.pieces(&c)));
        all.filter(|(_, pieces)| !pieces.is_empty()).unzip()
    }
    fn axes(
        &self,
        parts: &[Vec<Piece>],
        slopes: &[&Slope],
        cut: Option<&cut::Cut>,
    ) -> Option<[Axis; 2]> {
        let corners: Piece = slopes.iter().flat_map(|s| s.corners()).collect();
        let all = |k: usize| parts.iter().flatten().flatten().chain(&corners).map(move |p| p[k]);
        let y: Vec<f64> = cut.map_or_else(|| all(1).collect(), |cut| cut.range.to_vec());
        // Lines may touch the ends of the plot, marks would pass them.
        let only_lines = self.curves.iter().all(|c| !c.stroke.has_marks());
        let margin = if only_lines && !self.log_x { 0.0 } else { 0.04 };
        Some([Axis::of(all(0), self.log_x, margin)?, Axis::of(y.into_iter(), self.log_y, 0.05)?])
    }
    /// The name for readers who cannot see the drawing.
    fn name(&self) -> String {
        match self.title {
            "" => format!("{} over {}", self.y_label, self.x_label),
            title => title.into(),
        }
    }
    /// The runs of points that can be drawn.
    fn pieces(&self, curve: &Curve) -> Vec<Piece> {
        let good = |v: f64, log: bool| v.is_finite() && (!log || v > 0.0);
        let mut pieces = vec![Piece::new()];
        for (&x, &y) in curve.x.iter().zip(curve.y) {
            match pieces.last_mut() {
                Some(last) if good(x, self.log_x) && good(y, self.log_y) => last.push([x, y]),
                Some(last) if !last.is_empty() => pieces.push(Piece::new()),
                _ => {}
            }
        }
        pieces.retain(|p| !p.is_empty());
        let whole = curve.stroke.has_marks();
        pieces.into_iter().map(|p| if whole { p } else { thinned(p) }).collect()
    }
    /// A drawing in place of a chart without a point.
    fn empty(&self) -> String {
        let mut canvas = Canvas::default();
        let mut y = TITLE;
        let title = text::wrap(self.title, TITLE, 0.95 * WIDTH).into_iter().map(|l| (l, TITLE));
        for (line, size) in title.chain([("no values that can be drawn".to_string(), LABEL)]) {
            y += LEADING * size;
            canvas.text(&line, [0.5 * WIDTH, y], Anchor::Middle, size);
        }
        canvas.document([WIDTH, 0.35 * HEIGHT], &self.name(), "")
    }
}

/// At most [`MOST_POINTS`] of the points of a line: from every bin the lowest and the highest, so
/// that no peak is lost.
fn thinned(points: Piece) -> Piece {
    if points.len() <= MOST_POINTS {
        return points;
    }
    let bin = points.len().div_ceil(MOST_POINTS / 2 - 1);
    let mut keep = vec![0, points.len() - 1];
    for start in (0..points.len()).step_by(bin) {
        let of_bin = || start..(start + bin).min(points.len());
        keep.extend(of_bin().min_by(|&a, &b| points[a][1].total_cmp(&points[b][1])));
        keep.extend(of_bin().max_by(|&a, &b| points[a][1].total_cmp(&points[b][1])));
    }
    keep.sort_unstable();
    keep.dedup();
    keep.into_iter().map(|i| points[i]).collect()
}
