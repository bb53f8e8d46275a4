//! Phase diagrams: what the structures of a scene do over parameters.

use super::axis::{Axis, Choice, assignments, combinations, in_words};
use crate::base::{Error, Result};
use crate::output::{Cell, Page, Table};
use crate::studies::{Campaign, End, Trial};
use serde_json::Value;
use std::collections::BTreeSet;

/// A phase diagram.
#[derive(Clone, Debug)]
pub struct Phases {
    /// The parameters; the values of the first are the columns of the diagram.
    pub axes: Vec<Axis>,
}

/// What was found at a combination.
struct Point {
    combination: Vec<Choice>,
    /// By structure and name, such as `vesicle.motion`.
    findings: Vec<(String, Value)>,
    /// Why there are none.
    reason: String,
    alarms: usize,
}

impl Point {
    /// The words of the findings, which name the phase.
    fn phase(&self) -> String {
        let words = self.findings.iter().filter_map(|(_, value)| value.as_str());
        let phase = words.collect::<Vec<_>>().join(", ");
        let mark = if self.alarms > 0 { " (alarms)" } else { "" };
        if phase.is_empty() { self.reason.clone() } else { format!("{phase}{mark}") }
    }
}

impl Phases {
    /// Runs all combinations; the result is a page with the diagram and all findings.
    ///
    /// # Errors
    /// Values that the scene does not take; a scene whose structures have no findings; as for
    /// [`Campaign::run`]. A run that fails or is refused is a result.
    pub fn conduct(&self, campaign: &mut Campaign<'_>) -> Result<Page> {
        let all = combinations(&self.axes);
        campaign.check(&self.axes, &[])?;
        let mut points = Vec::new();
        for (k, combination) in all.iter().enumerate() {
            let trial = Trial::new(in_words(combination), assignments(combination));
            let outcome = campaign.run(&trial, k + 1, all.len())?;
            let mut findings = Vec::new();
            for (structure, of) in &outcome.summary.findings {
                findings.extend(of.iter().map(|(k, v)| (format!("{structure}.{k}"), v.clone())));
            }
            let reason = match &outcome.end {
                End::Finished => "nothing found".to_string(),
                end => end.in_words(),
            };
            let alarms = outcome.summary.alarms.len();
            points.push(Point { combination: combination.clone(), findings, reason, alarms });
        }
        if points.iter().all(|p| p.findings.is_empty() && p.reason == "nothing found") {
            return Err(Error::scene("no structure of this scene has a motion that is recognised")
                .value("summary.json has no findings")
                .remedy("study a scene with a [[vesicle]] of the plane, with 6 rows in its series at least"));
        }
        let scene = campaign.scene();
        Ok(Page {
            title: format!("Phases: {}", scene.title),
            subtitle: format!(
                "{} combinations of values, each to t = {}",
                all.len(),
                scene.time.end
            ),
            statements: points.iter().map(sentence).collect(),
            tables: self.diagram(&points).into_iter().chain([self.table(&points)]).collect(),
            ..Page::default()
        })
    }

    /// The phases with the values of the first axis side by side.
    fn diagram(&self, points: &[Point]) -> Option<Table> {
        let [first, others @ ..] = &self.axes[..] else { return None };
        if others.is_empty() {
            return None;
        }
        let names = others.iter().map(|a| a.name.clone());
        let header = names.chain(first.choices.iter().map(|c| c.label.clone()));
        let mut table = Table::new("diagram", "Phases", header);
        for rest in combinations(others) {
            let at = |choice: &Choice| {
                let is_at =
                    |p: &&Point| p.combination[0] == *choice && p.combination[1..] == rest[..];
                Cell::text(points.iter().find(is_at).map_or_else(String::new, Point::phase))
            };
            let places = rest.iter().map(|c| Cell::text(&c.value));
            table.rows.push(places.chain(first.choices.iter().map(at)).collect());
        }
        Some(table)
    }

    fn table(&self, points: &[Point]) -> Table {
        let found: BTreeSet<&str> =
            points.iter().flat_map(|p| p.findings.iter().map(|(name, _)| name.as_str())).collect();
        let header = self.axes.iter().map(|a| a.name.as_str()).chain(found.iter().copied());
        let mut table = Table::new("findings", "Findings", header.chain(["alarms"]));
        for p in points {
            let places = p.combination.iter().map(|c| Cell::text(&c.value));
            let cell = |name: &&str| match p.findings.iter().find(|(n, _)| n == name) {
                Some((_, Value::String(word))) => Cell::text(word),
                Some((_, value)) => Cell::number(value.as_f64().unwrap_or(f64::NAN), 5),
                None => Cell::text(""),
            };
            let alarms = Cell::number(p.alarms as f64, 6);
            table.rows.push(places.chain(found.iter().map(cell)).chain([alarms]).collect());
        }
        table.caption =
            "From the second half of each run; summary.json of each run has the same.".into();
        table
    }
}

fn sentence(p: &Point) -> String {
    let angle =
        p.findings.iter().find_map(|(name, v)| Some((name.ends_with(".angle"), v.as_f64()?)));
    let angle = match angle {
        Some((true, angle)) => format!(" at {angle:.2} degrees"),
        _ => String::new(),
    };
    format!("{}: {}{angle}.", in_words(&p.combination), p.phase())
}
