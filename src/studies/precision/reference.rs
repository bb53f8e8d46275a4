//! The reference values of a precision study, and errors against them.

use super::Truth;
use crate::base::{Error, Kind, Result};
use crate::output::Series;
use crate::studies::axis::{self, Axis};
use crate::studies::campaign::Campaign;
use crate::studies::trial::{Outcome, Trial};

/// The reference values and their own error.
#[derive(Clone, Debug, Default)]
pub(super) struct Reference {
    pub values: Vec<f64>,
    /// Estimated relative error of each value.
    pub own: Vec<f64>,
    /// Its origin.
    pub words: String,
    /// Notes on the estimate of its own error.
    pub notes: Vec<String>,
}

impl Reference {
    pub fn error(&self) -> f64 {
        self.own.iter().fold(0.0, |m: f64, e| m.max(*e))
    }
}

/// Refuses a reference run that has failed.
fn check_finished(fine: &Outcome) -> Result<()> {
    if !fine.finished() {
        return Err(Error::computation(format!("the reference run {}", fine.end.in_words()))
            .value(fine.end.reason())
            .remedy(
                "choose one that is stable with --reference: numerics.coupling=implicit, a \
                 smaller step, a finer mesh",
            ));
    }
    Ok(())
}

/// The reference values; a reference run is made, and runs that are coarser for its own error.
pub(super) fn reference(
    campaign: &mut Campaign<'_>,
    truth: &Truth,
    quantities: &[(String, f64)],
) -> Result<Reference> {
    let settings = match truth {
        Truth::Exact(values) => {
            let own = vec![0.0; values.len()];
            return Ok(Reference {
                values: values.clone(),
                own,
                words: "exact values".into(),
                notes: vec![],
            });
        }
        Truth::Reference(settings) => settings,
    };
    let mut set = settings.set.clone();
    let n = settings.cells.as_ref().and_then(|c| c.last()).copied();
    let cells =
        |n: usize| Ok::<_, Error>(axis::assignments(&Axis::cells(campaign.scene(), &[n])?.choices));
    let [chosen, coarser_mesh] =
        [n, n.map(|n| n / 2).filter(|n| *n > 0)].map(|n| n.map(cells).transpose());
    set.extend(chosen?.unwrap_or_default());
    set.extend(settings.steps.iter().flatten().last().map(|dt| format!("time.step={dt:?}")));
    let scene = campaign.scene().with(&set)?;
    let coarser_mesh = coarser_mesh?.map(|set| set.concat());
    let trial = |label: &str, more: Option<String>| {
        Trial::new(label, set.iter().cloned().chain(more).collect())
    };
    let fine = campaign.run(&trial("reference", None), 1, 1)?;
    check_finished(&fine)?;
    let values = measured(&fine.series, quantities)?;
    let mut found = Reference { own: vec![0.0; values.len()], values, ..Reference::default() };
    found.words = format!(
        "{}{}, dt = {:?}",
        if set.is_empty() { "the scene as it is: " } else { "" },
        set.join(" "),
        scene.time.step
    );
    // The error that halving takes away is 2^p - 1 times the one that is left.
    let step_order = scene.time.order as i32;
    let twice = format!("time.step={:?}", 2.0 * scene.time.step);
    let coarser =
        [("twice the step", Some(twice), step_order), ("half the cells", coarser_mesh, 2)];
    for (words, change, order) in coarser {
        let run = change
            .map(|c| campaign.run(&trial(&format!("reference, {words}"), Some(c)), 1, 1))
            .transpose();
        // A step that does not divide the end is no reason to stop.
        let run = run.or_else(|e| if e.kind() == Kind::Scene { Ok(None) } else { Err(e) })?;
        match run.filter(Outcome::finished).map(|o| measured(&o.series, quantities)).transpose()? {
            Some(coarse) => {
                let parts = relative(&coarse, &found.values)
                    .into_iter()
                    .map(|e| e / (2f64.powi(order) - 1.0));
                found.own.iter_mut().zip(parts).for_each(|(own, part)| *own += part);
                found.notes.push(format!("with {words} (order {order})"));
            }
            None => found.notes.push(format!("not with {words}: there is no such run")),
        }
    }
    Ok(found)
}

/// The quantities of a run that reached its end.
pub(super) fn measured(series: &Series, quantities: &[(String, f64)]) -> Result<Vec<f64>> {
    let value = |(column, t): &(String, f64)| {
        let missing = || {
            Error::scene(format!("the series has no row at t = {t:?}, where {column} is asked for"))
                .at("--quantity")
                .value(format!("{column}@{t:?}"))
                .remedy(
                    "choose a time that is a multiple of all steps and of output.every, or set \
                     --set output.every=...",
                )
        };
        let values = series.column(column)?;
        series.row_at(*t)?.and_then(|i| values.get(i)).copied().ok_or_else(missing)
    };
    quantities.iter().map(value).collect()
}

/// Differences over the right values; as they are where a right value is zero.
pub(super) fn relative(values: &[f64], right: &[f64]) -> Vec<f64> {
    let error = |(v, r): (&f64, &f64)| (v - r).abs() / if *r == 0.0 { 1.0 } else { r.abs() };
    values.iter().zip(right).map(error).collect()
}
