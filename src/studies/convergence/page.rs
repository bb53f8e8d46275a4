//! The tables, charts and sentences of a convergence study.

use super::ladder::Ladder;
use super::sequence::{Basis, WHOLE};
use super::{Convergence, Limit, Meaning, Observation};
use crate::output::{Cell, Chart, Curve, Figure, KeyNumber, Page, Slope, Stroke, Table, rounded};
use crate::scene::Scene;
use crate::studies::{End, Outcome};

/// What a study came to.
pub(super) struct Study<'a> {
    pub scene: &'a Scene,
    pub settings: &'a Convergence,
    pub ladder: &'a Ladder,
    /// Of the levels, then of the checks.
    pub outcomes: &'a [Outcome],
    pub sizes: &'a [f64],
    pub rows: &'a [Observation],
}

/// Digits of values that people are shown.
const DIGITS: usize = 7;
/// Curves that a chart can tell apart.
const MOST_CURVES: usize = 6;
/// Numbers at the top of the page.
const HEADLINES: usize = 4;
/// A fall of the order from one level to the next that is remarked.
const FALL: f64 = 0.5;

/// All that is shown.
pub(super) fn findings(study: &Study<'_>) -> Page {
    let mut tables = vec![study.runs(), study.convergence()];
    tables.extend(study.limits());
    let mut charts = study.changes();
    charts.extend(study.towards_zero());
    Page {
        title: format!("Convergence: {}", study.scene.title),
        subtitle: study.what_is_halved(),
        statements: study.statements(),
        notes: study.notes(),
        key_numbers: study.headline(),
        tables,
        details: vec![study.by_time()],
        charts,
        ..Page::default()
    }
}

impl Study<'_> {
    fn levels(&self) -> &[Outcome] {
        &self.outcomes[..self.ladder.levels.len()]
    }

    /// The name of what makes a level fine.
    fn size_name(&self) -> &'static str {
        match self.settings.halved {
            h if h.thickness => "eps",
            h if h.space => "h",
            _ => "dt",
        }
    }

    fn what_is_halved(&self) -> String {
        let h = self.settings.halved;
        if !self.settings.meshes.is_empty() {
            return format!("{} mesh files", self.settings.meshes.len());
        }
        let parts: Vec<&str> = [(h.thickness, "thickness"), (h.space, "mesh size"), (h.time, "time step")]
            .into_iter()
            .filter_map(|(on, name)| on.then_some(name))
            .collect();
        format!("{} levels, halving {}", self.settings.levels, parts.join(", "))
    }

    /// The runs, the checks last.
    fn runs(&self) -> Table {
        let header = ["level", "cells", "edge", "steps", "unknowns", "CPU", "end"];
        let mut table = Table::new("levels", "Runs", header).with_unit("CPU", "s");
        for o in self.outcomes {
            table.rows.push(vec![
                Cell::text(&o.trial.label),
                Cell::count(o.summary.cells),
                Cell::optional(o.summary.edge, 4),
                Cell::count(o.summary.steps),
                Cell::count((o.unknowns() > 0).then(|| o.unknowns())),
                Cell::number(o.cpu_seconds(), 3),
                Cell::text(o.end.in_words()),
            ]);
        }
        table
    }

    /// Every quantity on every level.
    fn convergence(&self) -> Table {
        let header = ["quantity", "time", self.size_name(), "value", "change", "error", "order"];
        let mut table = Table::new("convergence", "Level by level", header);
        for row in self.rows {
            let changes = row.sequence.changes();
            for (k, &size) in self.sizes.iter().enumerate() {
                let value = row.sequence.values[k];
                let (value, change, error) = match row.quantity.meaning {
                    Meaning::Value => (value, changes[k], row.limit.map_or(f64::NAN, |l| (value - l.value).abs())),
                    Meaning::Error => (f64::NAN, f64::NAN, value),
                    Meaning::Change => (f64::NAN, value, f64::NAN),
                };
                table.rows.push(vec![
                    Cell::text(&row.quantity.name),
                    Cell::number(row.time, 6),
                    Cell::number(size, 5),
                    Cell::number(value, DIGITS),
                    Cell::number(change, 3),
                    Cell::number(error, 3),
                    Cell::number(row.orders[k], 3),
                ]);
            }
        }
        table.caption = "Change: from the level before (of an interface: its distance from there). Error: against the exact \
                        solution, or else against the limit below. Order: from a level and those before it; - where none is seen."
            .into();
        table
    }

    /// The limits of all values; none if every quantity is an error or a distance.
    fn limits(&self) -> Option<Table> {
        let zero = format!("{} -> 0", self.size_name());
        let mut header = vec!["quantity", "time", "finest", "order", zero.as_str(), "error bar", "taken"];
        header.extend(self.ladder.checks.iter().map(|c| c.0));
        let mut table = Table::new("limits", "What the values tend to", header);
        for row in self.rows.iter().filter(|r| r.quantity.meaning == Meaning::Value) {
            let digits = row.limit.map_or(DIGITS, |l| digits(&l));
            let mut cells = vec![
                Cell::text(&row.quantity.name),
                Cell::number(row.time, 6),
                Cell::number(row.finest(), DIGITS),
                Cell::number(row.order(), 3),
                Cell::optional(row.limit.map(|l| l.value), digits),
                Cell::optional(row.limit.map(|l| l.bar), 2),
                Cell::text(row.limit.map_or("no limit seen".into(), |l| basis(&l))),
            ];
            cells.extend(row.checks.iter().map(|&moved| Cell::number(moved, 2)));
            table.rows.push(cells);
        }
        table.caption = "Extrapolated from the two finest levels with a whole order, the bar is the distance from the same \
                        extrapolation a level earlier, or with the order as seen; with an observed order that is no whole one, it is all that the extrapolation \
                        adds; where no order is seen but the values settle, the finest value stands, and the spread of the last three."
            .into();
        if !self.ladder.checks.is_empty() {
            table.caption += " The last columns: by how much halving what is not refined moves the coarsest level.";
        }
        (!table.rows.is_empty()).then_some(table)
    }

    /// Limits, bars, orders and finest values as numbers alone, a row a time.
    fn by_time(&self) -> Table {
        let times = self.times();
        let mut table = Table::new("by_time", "Page by time", ["time"]);
        table.rows = times.iter().map(|t| vec![Cell::number(*t, DIGITS)]).collect();
        for row in self.rows {
            let limit = row.limit.map_or([f64::NAN; 2], |l| [l.value, l.bar]);
            let columns = [("limit", limit[0]), ("bar", limit[1]), ("order", row.order()), ("finest", row.finest())];
            let skipped = if row.quantity.meaning == Meaning::Value { 0 } else { 2 };
            for (end, value) in columns.into_iter().skip(skipped) {
                let name = format!("{}.{end}", row.quantity.name);
                if table.position(&name).is_none() {
                    table.columns.push(name.into());
                }
                if let Some(k) = times.iter().position(|t| *t == row.time) {
                    table.rows[k].push(Cell::number(value, DIGITS));
                }
            }
        }
        table
    }

    fn statements(&self) -> Vec<String> {
        let limit = match (self.settings.halved.thickness, self.size_name()) {
            (true, _) => "sharp-interface limit".to_string(),
            (false, size) => format!("limit {size} -> 0"),
        };
        let say = |row: &Observation| {
            let (name, order, at) = (&row.quantity.name, row.order(), format!("t = {}", row.time));
            let seen = if order.is_nan() { "no order seen".to_string() } else { format!("order {order:.2}") };
            match (row.quantity.meaning, row.limit) {
                (Meaning::Value, Some(l)) => format!("{name} at {at}: {limit} {}, {seen}.", with_bar(&l)),
                (Meaning::Value, None) if self.levels().iter().filter(|o| o.finished()).count() < 3 => {
                    format!("{name} at {at}: an order and a limit need three levels.")
                }
                (Meaning::Value, None) => format!("{name} at {at}: {seen}, and no limit: the changes do not fall."),
                (Meaning::Error, _) => {
                    format!("{name} at {at}: {} on the finest level, {seen}.", rounded(row.finest(), 3))
                }
                (Meaning::Change, _) => {
                    format!("{name} at {at}: {} between the two finest levels, {seen}.", rounded(row.finest(), 3))
                }
            }
        };
        self.rows.iter().map(say).collect()
    }

    fn headline(&self) -> Vec<KeyNumber> {
        let last = self.rows.iter().map(|r| r.time).fold(f64::NEG_INFINITY, f64::max);
        let show = |row: &Observation| KeyNumber {
            label: format!("{} at t = {}", row.quantity.name, row.time),
            value: row.limit.map_or_else(|| rounded(row.finest(), 3), |l| with_bar(&l)),
            note: if row.order().is_nan() { "no order seen".into() } else { format!("order {:.2}", row.order()) },
        };
        self.rows.iter().filter(|r| r.time == last).take(HEADLINES).map(show).collect()
    }

    /// What is kept, what failed, and what limits the study.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let h = self.settings.halved;
        if !h.time {
            notes.push(format!(
                "the time step stays {} on all levels: its error is in the limits",
                self.scene.time.step
            ));
        }
        if !h.space && self.settings.meshes.is_empty() {
            notes.push("the mesh stays the same on all levels: its error is in the limits".into());
        }
        if let (Some(eps), false) = (self.ladder.thickness, h.thickness) {
            notes.push(format!(
                "the half-width of the band stays {eps} on all levels: its error, of first order, is in the limits"
            ));
        }
        for o in self.outcomes.iter().filter(|o| !o.finished()) {
            let what = if matches!(o.end, End::Refused { .. }) { "is left out" } else { "counts up to there" };
            notes.push(format!("{} {}, and {what}: {}", o.trial.label, o.end.in_words(), o.end.reason()));
        }
        if self.levels().iter().filter(|o| o.finished()).count() < 3 {
            notes.push("values show an order on three levels that finished, not on fewer".into());
        }
        notes.extend(self.ladder.checks.iter().enumerate().filter_map(|(k, c)| self.outweighed(k, c.0)));
        notes.extend(self.rows.iter().filter_map(|r| self.not_yet(r)));
        notes.extend(self.rows.iter().filter_map(|r| self.flattening(r)));
        notes
    }

    /// What a check moves by more than what is said of it allows.
    fn outweighed(&self, check: usize, name: &str) -> Option<String> {
        let mut moved = Vec::new();
        for row in self.rows {
            let by = row.checks.get(check).copied().unwrap_or(f64::NAN);
            let believed =
                if row.quantity.meaning == Meaning::Error { Some(row.finest()) } else { row.limit.map(|l| l.bar) };
            if believed.is_some_and(|b| by.abs() > b) {
                moved.push(format!("{} at t = {} (by {})", row.quantity.name, row.time, rounded(by, 2)));
            }
        }
        (!moved.is_empty()).then(|| {
            format!(
                "with the {name}, the coarsest level moves by more than the error bar, or the error on the finest level, in {}: \
                 there, that error is larger than the one that is studied",
                moved.join(", ")
            )
        })
    }

    /// That the order which is known beforehand is not seen yet.
    fn not_yet(&self, row: &Observation) -> Option<String> {
        let (Some(Basis::Whole(taken)), seen) = (row.limit.map(|l| l.basis), row.order()) else { return None };
        ((seen - taken).abs() > WHOLE).then(|| {
            format!(
                "{} at t = {}: the order seen is {seen:.2}; limit and bar assume that order {taken} sets in on finer levels",
                row.quantity.name, row.time
            )
        })
    }

    /// That the order of an error falls on the finest level.
    fn flattening(&self, row: &Observation) -> Option<String> {
        let orders: Vec<f64> = row.orders.iter().copied().filter(|p| p.is_finite()).collect();
        let (Meaning::Error, [.., before, after]) = (row.quantity.meaning, &orders[..]) else { return None };
        (before - after > FALL).then(|| {
            format!(
                "{} at t = {}: its order falls from {before:.1} to {after:.1} on the finest level, where another error begins to show",
                row.quantity.name, row.time
            )
        })
    }

    /// A chart a time: what tends to zero, over the size.
    fn changes(&self) -> Vec<Figure> {
        let times = self.times();
        let draw = |&time: &f64| {
            let rows: Vec<&Observation> = self.rows.iter().filter(|r| r.time == time).collect();
            let drawn = |r: &&Observation| r.shrinking().iter().any(|v| *v > 0.0);
            let rows: Vec<&Observation> = rows.into_iter().filter(drawn).take(MOST_CURVES).collect();
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
            };
            let caption = "Errors against the exact solution; of other quantities the change from the level before, which \
                           falls with the same order and needs no limit. The triangles have the slope of the whole orders \
                           nearest to those seen.";
            Figure::chart(format!("convergence-t{time}"), title.as_str(), chart.svg(), caption)
        };
        times.iter().map(draw).collect()
    }

    /// Where the thickness is refined, a chart a quantity: its values over the thickness, and the limits with their bars.
    fn towards_zero(&self) -> Vec<Figure> {
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
                Some((k, [0.0, self.sizes[finest]], [limit.value, r.sequence.values[finest]], limit))
            })
            .collect();
        let bars: Vec<[f64; 2]> = limits.iter().map(|l| [l.3.value - l.3.bar, l.3.value + l.3.bar]).collect();
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
        let svg = Chart { title: &title, x_label: "eps", y_label: name, curves, ..Chart::default() }.svg();
        let caption = "At eps = 0 the sharp-interface limits, each with its error bar.";
        Figure::chart(format!("limit-{name}"), title.as_str(), svg, caption)
    }

    fn times(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.rows.iter().map(|r| r.time).collect();
        times.dedup();
        times
    }
}

/// Digits that show a limit down to its bar.
fn digits(limit: &Limit) -> usize {
    let spread = (limit.value.abs() / limit.bar).log10();
    if spread.is_finite() { (spread.ceil() + 2.0).clamp(2.0, 12.0) as usize } else { DIGITS }
}

/// `0.7157 +- 0.0005`.
fn with_bar(limit: &Limit) -> String {
    format!("{} ± {}", rounded(limit.value, digits(limit)), rounded(limit.bar, 2))
}

fn basis(limit: &Limit) -> String {
    match limit.basis {
        Basis::Whole(p) => format!("order {p}"),
        Basis::Observed(p) => format!("order {p:.2}, as seen"),
        Basis::Spread => "spread".into(),
    }
}

/// Triangles for the highest of the whole orders that are seen, below the curves at the fine end, and for the lowest, above them at
/// the coarse end.
fn slopes(sizes: &[f64], y: &[Vec<f64>], seen: impl Iterator<Item = f64>) -> Vec<Slope> {
    let mut orders: Vec<f64> = seen.filter(|p| p.is_finite()).map(|p| p.round().max(1.0)).collect();
    orders.sort_by(f64::total_cmp);
    orders.dedup();
    let positive = || y.iter().flatten().copied().filter(|v| v.is_finite() && *v > 0.0);
    let (low, high) = positive().fold((f64::INFINITY, 0.0), |(a, b), v| (v.min(a), v.max(b)));
    let drawn: Vec<f64> =
        sizes.iter().enumerate().filter(|(k, _)| y.iter().any(|y| y[*k] > 0.0)).map(|s| *s.1).collect();
    let ([coarse, second, ..], [.., last, fine]) = (&drawn[..], &drawn[..]) else { return Vec::new() };
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
