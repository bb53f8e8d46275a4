//! The charts of a convergence study.

use super::page::Study;
use super::{Limit, Meaning, Observation};
use crate::output::{Chart, Curve, Figure, Slope, Stroke};

/// Curves that a chart can tell apart.
const MOST_CURVES: usize = 6;

impl Study<'_> {
    /// A chart a time: what tends to zero, over the size.
    pub(super) fn changes(&self) -> Vec<Figure> {
        let times = self.times();
        let draw = |&time: &f64| {
            let rows: Vec<&Observation> = self.rows.iter().filter(|r| r.time == time).collect();
            let drawn = |r: &&Observation| r.shrinking().iter().any(|v| *v > 0.0);
            let rows: Vec<&Observation> =
                rows.into_iter().filter(drawn).take(MOST_CURVES).collect();
            let y: Vec<Vec<f64>> = rows.iter().map(|r| r.shrinking()).collect();
            let curves = rows.iter().zip(&y).map(|(r, y)| Curve {
                name: &r.quantity.name,
                x: self.sizes,
                y,
                stroke: Stroke::Marked,
                ..Curve::default()
            });
            let title = format!("Change from level to level at t = {time}");
            let title = if rows.iter().all(|r| r.quantity.meaning == Meaning::Error) {
                format!("Error at t = {time}")
            } else {
                title
            };
            let chart = Chart {
                title: &title,
                x_label: self.size_name(),
                y_label: "error, or change from the level before",
                log_x: true,
                log_y: true,
                curves: curves.collect(),
                slopes: slopes(self.sizes, &y, rows.iter().map(|r| r.order())),
                ..Chart::default()
            };
            let caption = "Errors against the exact solution; of other quantities the change from \
                the level before, which falls with the same order and needs no limit. The \
                triangles have the slope of the whole orders nearest to those seen.";
            Figure::chart(format!("convergence-t{time}"), title.as_str(), chart.svg(), caption)
        };
        times.iter().map(draw).collect()
    }

    /// A chart for each quantity of a study of the thickness: its values over the thickness, and
    /// the limits with their bars.
    pub(super) fn towards_zero(&self) -> Vec<Figure> {
        if !self.settings.halved.thickness {
            return Vec::new();
        }
        let mut names: Vec<&str> = Vec::new();
        for row in self.rows.iter().filter(|r| r.limit.is_some()) {
            if !names.contains(&row.quantity.name.as_str()) {
                names.push(&row.quantity.name);
            }
        }
        names.iter().map(|name| self.over_thickness(name)).collect()
    }

    fn over_thickness(&self, name: &str) -> Figure {
        let of: Vec<&Observation> =
            self.rows.iter().filter(|r| r.quantity.name == name).take(MOST_CURVES / 2).collect();
        let names: Vec<String> = of.iter().map(|r| format!("t = {}", r.time)).collect();
        // The limit and its bar, and the line from the finest level that leads there.
        let limits: Vec<(usize, [f64; 2], [f64; 2], Limit)> = of
            .iter()
            .enumerate()
            .filter_map(|(k, r)| {
                let limit = r.limit?;
                let finest = r.sequence.values.iter().rposition(|v| v.is_finite())?;
                Some((
                    k,
                    [0.0, self.sizes[finest]],
                    [limit.value, r.sequence.values[finest]],
                    limit,
                ))
            })
            .collect();
        let bars: Vec<[f64; 2]> =
            limits.iter().map(|l| [l.3.value - l.3.bar, l.3.value + l.3.bar]).collect();
        let mut curves: Vec<Curve<'_>> = Vec::new();
        for (k, (row, name)) in of.iter().zip(&names).enumerate() {
            let (x, y) = (self.sizes, row.sequence.values.as_slice());
            curves.push(Curve { name, x, y, stroke: Stroke::Marked, colour: Some(k) });
        }
        for ((k, x, y, _), bar) in limits.iter().zip(&bars) {
            let part = |x, y, stroke| Curve { name: "", x, y, stroke, colour: Some(*k) };
            curves.push(part(x, y, Stroke::Dashed));
            curves.push(part(&x[..1], &y[..1], Stroke::Points));
            curves.push(part(&[0.0, 0.0], bar, Stroke::Line));
        }
        let title = format!("{name} over the thickness");
        let svg =
            Chart { title: &title, x_label: "eps", y_label: name, curves, ..Chart::default() }
                .svg();
        let caption = "At eps = 0 the sharp-interface limits, each with its error bar.";
        Figure::chart(format!("limit-{name}"), title.as_str(), svg, caption)
    }
}

/// Triangles for the highest of the whole orders that are seen, below the curves at the fine end,
/// and for the lowest, above them at the coarse end.
fn slopes(sizes: &[f64], y: &[Vec<f64>], seen: impl Iterator<Item = f64>) -> Vec<Slope> {
    let mut orders: Vec<f64> = seen.filter(|p| p.is_finite()).map(|p| p.round().max(1.0)).collect();
    orders.sort_by(f64::total_cmp);
    orders.dedup();
    let positive = || y.iter().flatten().copied().filter(|v| v.is_finite() && *v > 0.0);
    let (low, high) = positive().fold((f64::INFINITY, 0.0), |(a, b), v| (v.min(a), v.max(b)));
    let drawn: Vec<f64> = sizes
        .iter()
        .enumerate()
        .filter(|(k, _)| y.iter().any(|y| y[*k] > 0.0))
        .map(|s| *s.1)
        .collect();
    let ([coarse, second, ..], [.., last, fine]) = (&drawn[..], &drawn[..]) else {
        return Vec::new();
    };
    let mut slopes = Vec::new();
    if let Some(&order) = orders.last() {
        slopes.push(Slope { x: [*fine, *last], y: low / 2.5, order, above: false });
    }
    if let (true, Some(&order)) = (orders.len() > 1, orders.first()) {
        let y = 2.5 * high * (second / coarse).powf(order);
        slopes.push(Slope { x: [*second, *coarse], y, order, above: true });
    }
    slopes
}
