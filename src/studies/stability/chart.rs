//! The limits over a value that was varied.

use super::limit::{StepLimit, is_scheme};
use crate::output::{Chart, Curve, Figure, Stroke};
use crate::studies::axis::{Axis, Choice, in_words};

/// The limits over axis number `k`, if it has two numbers or more: over the edge of the mesh for
/// the number of cells.
pub(super) fn chart(axes: &[Axis], k: usize, limits: &[StepLimit]) -> Option<Figure> {
    let axis = axes.get(k)?;
    if is_scheme(&axis.name) || axis.choices.iter().filter(|c| c.number().is_some()).count() < 2 {
        return None;
    }
    let view = View { name: &axis.name, k };
    let mut rows = measured(limits, &view);
    rows.extend(formulas(limits, &view, &rows));
    let lines: Vec<(String, Vec<f64>, Vec<f64>)> = rows.iter_mut().map(CurvePoints::line).collect();
    let curves = rows.iter().zip(&lines).map(|(row, (name, x, y))| Curve {
        name,
        x,
        y,
        stroke: row.stroke,
        colour: Some(row.colour),
    });
    let (title, x_label) = match view.is_mesh() {
        true => ("the edge of the mesh", "shortest edge in the band"),
        false => (view.name, view.name),
    };
    let title = format!("Largest stable step over {title}");
    let chart = Chart {
        title: &title,
        x_label,
        y_label: "time step",
        log_x: true,
        log_y: true,
        curves: curves.collect(),
        ..Chart::default()
    };
    let name = format!("limit-over-{}", view.name.replace('.', "-"));
    let caption = "Marks: measured. Dashed: the formula (1.54) at the start. \"up to\": stable at \
        the largest step tried.";
    Some(Figure::chart(name, title.as_str(), chart.svg(), caption))
}

/// The axis that a chart is over.
struct View<'a> {
    name: &'a str,
    k: usize,
}

impl View<'_> {
    fn is_mesh(&self) -> bool {
        self.name == "n"
    }
    fn abscissa(&self, l: &StepLimit) -> Option<f64> {
        if self.is_mesh() { l.edge } else { l.combination.get(self.k).and_then(Choice::number) }
    }
    /// The values on the other axes.
    fn others(&self, l: &StepLimit) -> Vec<Choice> {
        l.combination.iter().filter(|c| c.name != self.name).cloned().collect()
    }
}

/// A curve in the making.
struct CurvePoints {
    key: Vec<Choice>,
    stroke: Stroke,
    colour: usize,
    points: Vec<[f64; 2]>,
    /// True if no step was found unstable at any of its points.
    open: bool,
}

impl CurvePoints {
    /// Its name and its points from left to right.
    fn line(&mut self) -> (String, Vec<f64>, Vec<f64>) {
        self.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let words = in_words(&self.key);
        let name = match (self.stroke, self.open) {
            (Stroke::Dashed, _) if words.is_empty() => "(1.54)".into(),
            (Stroke::Dashed, _) => format!("(1.54), {words}"),
            (_, true) => format!("{words}: up to"),
            (_, false) => words,
        };
        (
            name,
            self.points.iter().map(|p| p[0]).collect(),
            self.points.iter().map(|p| p[1]).collect(),
        )
    }
}

/// The row with this key, made if there is none.
fn row(rows: &mut Vec<CurvePoints>, key: Vec<Choice>, stroke: Stroke) -> &mut CurvePoints {
    let at = rows.iter().position(|r| r.key == key).unwrap_or(rows.len());
    if at == rows.len() {
        rows.push(CurvePoints { key, stroke, colour: at, points: Vec::new(), open: true });
    }
    &mut rows[at]
}

fn measured(limits: &[StepLimit], view: &View) -> Vec<CurvePoints> {
    let mut rows = Vec::new();
    for l in limits {
        let row = row(&mut rows, view.others(l), Stroke::Marked);
        if let (Some(x), Some(y)) = (view.abscissa(l), l.limit()) {
            row.points.push([x, y]);
            row.open &= l.bracket.unstable.is_none();
        }
    }
    rows
}

/// The formula, once for all schemes and in the colour of the first.
fn formulas(limits: &[StepLimit], view: &View, measured: &[CurvePoints]) -> Vec<CurvePoints> {
    let physics = |key: &[Choice]| -> Vec<Choice> {
        key.iter().filter(|c| !is_scheme(&c.name)).cloned().collect()
    };
    let mut rows = Vec::new();
    for l in limits {
        let row = row(&mut rows, physics(&view.others(l)), Stroke::Dashed);
        if let (Some(x), Some(y)) = (view.abscissa(l), l.formula)
            && !row.points.contains(&[x, y])
        {
            row.points.push([x, y]);
        }
    }
    for row in &mut rows {
        row.colour = measured.iter().position(|m| physics(&m.key) == row.key).unwrap_or(0);
    }
    rows
}
