//! The tables, charts and sentences of a convergence study.

use super::ladder::Ladder;
use super::sequence::{Basis, WHOLE};
use super::{Convergence, Limit, Meaning, Observation};
use crate::output::{KeyNumber, Page, rounded};
use crate::scene::Scene;
use crate::studies::{End, Outcome};

/// Results of a study.
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
pub(super) const DIGITS: usize = 7;
/// Numbers at the top of the page.
const HEADLINES: usize = 4;
/// A fall of the order from one level to the next that is remarked.
const FALL: f64 = 0.5;

/// The page.
pub(super) fn page(study: &Study<'_>) -> Page {
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
    pub(super) fn levels(&self) -> &[Outcome] {
        &self.outcomes[..self.ladder.levels.len()]
    }

    /// The name of the size that is halved.
    pub(super) fn size_name(&self) -> &'static str {
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
        let parts: Vec<&str> =
            [(h.thickness, "thickness"), (h.space, "mesh size"), (h.time, "time step")]
                .into_iter()
                .filter_map(|(on, name)| on.then_some(name))
                .collect();
        format!("{} levels, halving {}", self.settings.levels, parts.join(", "))
    }

    fn statements(&self) -> Vec<String> {
        let limit = match (self.settings.halved.thickness, self.size_name()) {
            (true, _) => "sharp-interface limit".to_string(),
            (false, size) => format!("limit {size} -> 0"),
        };
        let say = |row: &Observation| {
            let (name, order, at) = (&row.quantity.name, row.order(), format!("t = {}", row.time));
            let seen = if order.is_nan() {
                "no order seen".to_string()
            } else {
                format!("order {order:.2}")
            };
            match (row.quantity.meaning, row.limit) {
                (Meaning::Value, Some(l)) => {
                    format!("{name} at {at}: {limit} {}, {seen}.", with_bar(&l))
                }
                (Meaning::Value, None)
                    if self.levels().iter().filter(|o| o.finished()).count() < 3 =>
                {
                    format!("{name} at {at}: an order and a limit need three levels.")
                }
                (Meaning::Value, None) => {
                    format!("{name} at {at}: {seen}, and no limit: the changes do not fall.")
                }
                (Meaning::Error, _) => {
                    format!(
                        "{name} at {at}: {} on the finest level, {seen}.",
                        rounded(row.finest(), 3)
                    )
                }
                (Meaning::Change, _) => {
                    format!(
                        "{name} at {at}: {} between the two finest levels, {seen}.",
                        rounded(row.finest(), 3)
                    )
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
            note: if row.order().is_nan() {
                "no order seen".into()
            } else {
                format!("order {:.2}", row.order())
            },
        };
        self.rows.iter().filter(|r| r.time == last).take(HEADLINES).map(show).collect()
    }

    /// Constant parameters, failed runs, and errors that limit the study.
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
                "the half-width of the band stays {eps} on all levels: its error, of first order, \
                 is in the limits"
            ));
        }
        for o in self.outcomes.iter().filter(|o| !o.finished()) {
            let what = if matches!(o.end, End::Refused { .. }) {
                "is left out"
            } else {
                "counts up to there"
            };
            notes.push(format!(
                "{} {}, and {what}: {}",
                o.trial.label,
                o.end.in_words(),
                o.end.reason()
            ));
        }
        if self.levels().iter().filter(|o| o.finished()).count() < 3 {
            notes.push("values show an order on three levels that finished, not on fewer".into());
        }
        notes.extend(
            self.ladder.checks.iter().enumerate().filter_map(|(k, c)| self.outweighed(k, c.0)),
        );
        notes.extend(self.rows.iter().filter_map(|r| self.not_yet(r)));
        notes.extend(self.rows.iter().filter_map(|r| self.flattening(r)));
        notes
    }

    /// Quantities that a check moves by more than their error bars.
    fn outweighed(&self, check: usize, name: &str) -> Option<String> {
        let mut moved = Vec::new();
        for row in self.rows {
            let by = row.checks.get(check).copied().unwrap_or(f64::NAN);
            let believed = if row.quantity.meaning == Meaning::Error {
                Some(row.finest())
            } else {
                row.limit.map(|l| l.bar)
            };
            if believed.is_some_and(|b| by.abs() > b) {
                moved.push(format!(
                    "{} at t = {} (by {})",
                    row.quantity.name,
                    row.time,
                    rounded(by, 2)
                ));
            }
        }
        (!moved.is_empty()).then(|| {
            format!(
                "with the {name}, the coarsest level moves by more than the error bar, or the \
                 error on the finest level, in {}: there, that error is larger than the one that \
                 is studied",
                moved.join(", ")
            )
        })
    }

    /// That the order which is known beforehand is not seen yet.
    fn not_yet(&self, row: &Observation) -> Option<String> {
        let (Some(Basis::Whole(taken)), seen) = (row.limit.map(|l| l.basis), row.order()) else {
            return None;
        };
        ((seen - taken).abs() > WHOLE).then(|| {
            format!(
                "{} at t = {}: the order seen is {seen:.2}; limit and bar assume that order \
                 {taken} sets in on finer levels",
                row.quantity.name, row.time
            )
        })
    }

    /// That the order of an error falls on the finest level.
    fn flattening(&self, row: &Observation) -> Option<String> {
        let orders: Vec<f64> = row.orders.iter().copied().filter(|p| p.is_finite()).collect();
        let (Meaning::Error, [.., before, after]) = (row.quantity.meaning, &orders[..]) else {
            return None;
        };
        (before - after > FALL).then(|| {
            format!(
                "{} at t = {}: its order falls from {before:.1} to {after:.1} on the finest \
                 level, where another error begins to show",
                row.quantity.name, row.time
            )
        })
    }

    pub(super) fn times(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.rows.iter().map(|r| r.time).collect();
        times.dedup();
        times
    }
}

/// `0.7157 +- 0.0005`.
fn with_bar(limit: &Limit) -> String {
    format!("{} ± {}", rounded(limit.value, digits(limit)), rounded(limit.bar, 2))
}

/// Digits that show a limit down to its bar.
pub(super) fn digits(limit: &Limit) -> usize {
    let spread = (limit.value.abs() / limit.bar).log10();
    if spread.is_finite() { (spread.ceil() + 2.0).clamp(2.0, 12.0) as usize } else { DIGITS }
}
