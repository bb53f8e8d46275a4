//! Stability: the largest stable step of a scene, and which other values of it are stable at its
//! own step.
//!
//! A run is unstable when it fails, or when kinetic and elastic energy exceed the energy at the
//! start and the work put in by more than a tolerance ([`TOLERANCE`]): growth beyond the balance
//! (3.23), long before numbers overflow.

mod chart;
mod limit;
mod limits;
mod scan;
mod search;
mod verdict;

pub use limits::{LimitSearch, TOLERANCE};
pub use scan::Scan;
pub use search::{Bracket, largest_stable_step};
pub use verdict::Verdict;

use super::axis::{Axis, Choice, assignments, in_words};
use crate::base::{Error, Result};
use crate::output::Cell;
use crate::studies::{Campaign, Trial, per_cent};

/// Refuses values that the scene does not take, or that stand on two axes or on one and among the
/// keys that the study sets itself, before anything is computed.
fn check(campaign: &Campaign<'_>, axes: &[Axis], own: &[&str]) -> Result<()> {
    if campaign.scene().fluid.prescribed_velocity.is_some() {
        return Err(Error::scene(
            "no flow is solved in this scene, and what is carried has no energy that could grow",
        )
        .value("fluid.prescribed_velocity")
        .remedy("study its errors with `immersa study convergence`"));
    }
    campaign.check(axes, own)
}

/// The run of a combination with `steps` steps of length `dt`, each with its row in the series.
fn trial(combination: &[Choice], dt: f64, steps: usize) -> Trial {
    let mut set = assignments(combination);
    // The end must be a multiple of the step: both are set.
    set.extend([
        format!("time.step={dt}"),
        format!("time.end={}", dt * steps as f64),
        format!("output.every={dt}"),
    ]);
    let label = [in_words(combination), format!("dt = {dt}")];
    Trial::new(label.iter().filter(|l| !l.is_empty()).cloned().collect::<Vec<_>>().join(", "), set)
}

/// The names of the axes and what follows them in a table.
fn columns<'a>(axes: &'a [Axis], more: &'a [&str]) -> impl Iterator<Item = &'a str> {
    axes.iter().map(|a| a.name.as_str()).chain(more.iter().copied())
}

/// A combination as the first cells of a row.
fn cells(combination: &[Choice]) -> Vec<Cell> {
    combination
        .iter()
        .map(|c| c.number().map_or_else(|| Cell::text(&c.value), |v| Cell::number(v, 6)))
        .collect()
}

/// A combination as the beginning of a sentence.
fn heading(combination: &[Choice]) -> String {
    let words = in_words(combination);
    let mut letters = words.chars();
    match letters.next() {
        // The name of a key is written as it is.
        Some(first) if combination.first().is_some_and(|c| !c.label.contains('=')) => {
            format!("{}{}: ", first.to_uppercase(), letters.as_str())
        }
        Some(_) => format!("{words}: "),
        None => String::new(),
    }
}

/// Refused combinations, a line for each reason.
fn refusals<'a>(refused: impl Iterator<Item = (&'a [Choice], &'a str)>) -> Vec<String> {
    let mut reasons: Vec<(String, Vec<String>)> = Vec::new();
    for (combination, reason) in refused {
        let reason = reason.lines().map(str::trim).collect::<Vec<_>>().join("; ");
        match reasons.iter_mut().find(|r| r.0 == reason) {
            Some(known) => known.1.push(in_words(combination)),
            None => reasons.push((reason, vec![in_words(combination)])),
        }
    }
    let line = |(reason, of): (String, Vec<String>)| match &of[..] {
        [] => reason,
        [only] => format!("refused ({only}): {reason}"),
        [first, more @ ..] => format!("refused ({first} and {} more): {reason}", more.len()),
    };
    reasons.into_iter().map(line).collect()
}
