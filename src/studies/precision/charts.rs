//! The charts of a precision study.

use super::{CostPoint, Reference, offers};
use crate::output::{Chart, Curve, Figure, Stroke};
use crate::studies::front::front;
use crate::studies::per_cent;

/// Grey, the colour of programs other than this one.
pub(super) const GREY: usize = 6;

/// A method's points, with a gap between one mesh and the next.
pub(super) struct MethodCurve<'a> {
    pub name: &'a str,
    pub points: Vec<Option<&'a CostPoint>>,
    pub colour: usize,
}

/// The rows in the order of `methods`, and then of the points.
pub(super) fn rows<'a>(points: &'a [CostPoint], methods: &[&str]) -> Vec<MethodCurve<'a>> {
    let mut order: Vec<&CostPoint> = points.iter().collect();
    order.sort_by_key(|p| methods.iter().position(|m| *m == p.method).unwrap_or(methods.len()));
    let mut rows: Vec<MethodCurve<'_>> = Vec::new();
    for p in order {
        if rows.iter().all(|r| r.name != p.method) {
            let ours = rows.iter().filter(|r| r.colour != GREY).count();
            rows.push(MethodCurve {
                name: &p.method,
                points: vec![],
                colour: if p.ours { ours % GREY } else { GREY },
            });
        }
        let Some(row) = rows.iter_mut().find(|r| r.name == p.method) else { continue };
        if row.points.last().copied().flatten().is_some_and(|last| last.family != p.family) {
            row.points.push(None);
        }
        row.points.push(Some(p));
    }
    rows
}

pub(super) fn charts(
    points: &[CostPoint],
    methods: &[&str],
    what: &str,
    reference: &Reference,
) -> Vec<Figure> {
    let known = match reference.error() {
        e if e > 0.0 => format!(" The reference is known to {}.", per_cent(e)),
        _ => String::new(),
    };
    let lines = "Each line is a method on one mesh, each mark a time step.";
    let work = format!(
        "{lines} The dashed line joins the runs that no other beats in both error and CPU \
         time.{known}"
    );
    let against = format!("{lines}{known}");
    let mut all = vec![chart(
        ["work", "Error against CPU time.", "CPU seconds of the time steps", what, &work],
        points,
        methods,
        |p| p.cpu,
        true,
    )];
    // On one mesh there is nothing to be seen in them.
    if points.iter().any(|p| p.family != points[0].family) {
        let words = ["unknowns", "Error against unknowns.", "unknowns", what, &against];
        all.push(chart(words, points, methods, |p| p.unknowns, false));
        let words = ["memory", "Error against memory.", "memory in MB", what, &against];
        all.push(chart(words, points, methods, |p| p.memory / 1e6, false));
    }
    all
}

/// A chart of the errors; `words` are its name, title, horizontal axis, quantities and caption.
fn chart(
    words: [&str; 5],
    points: &[CostPoint],
    methods: &[&str],
    cost: impl Fn(&CostPoint) -> f64,
    with_front: bool,
) -> Figure {
    let [name, title, x_label, what, caption] = words;
    let values = |row: &MethodCurve, f: &dyn Fn(&CostPoint) -> f64| -> Vec<f64> {
        row.points.iter().map(|p| p.map_or(f64::NAN, f)).collect()
    };
    let rows = rows(points, methods);
    let columns: Vec<[Vec<f64>; 2]> =
        rows.iter().map(|r| [values(r, &cost), values(r, &CostPoint::usable)]).collect();
    let best: Vec<&CostPoint> = front(&offers(points)).iter().map(|&i| &points[i]).collect();
    let (x, y): (Vec<f64>, Vec<f64>) = best.iter().map(|p| (cost(p), p.usable())).unzip();
    let mut curves: Vec<Curve<'_>> = Vec::new();
    if with_front && best.len() > 1 {
        curves.push(Curve {
            name: "not beaten",
            x: &x,
            y: &y,
            stroke: Stroke::Dashed,
            colour: Some(GREY),
        });
    }
    curves.extend(rows.iter().zip(&columns).map(|(row, [x, y])| {
        let stroke = Stroke::Marked;
        Curve { name: row.name, x, y, stroke, colour: Some(row.colour) }
    }));
    // What an error is of stands in the subtitle of the page when it is long.
    let y_label = if what.len() > 40 { "relative error" } else { what };
    let y_label = if y_label == what { format!("error of {what}") } else { y_label.to_string() };
    let chart =
        Chart { x_label, y_label: &y_label, log_x: true, log_y: true, curves, ..Chart::default() };
    Figure::chart(name, title, chart.svg(), caption)
}
