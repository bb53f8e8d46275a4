//! The convergence study: a scene on finer and finer levels, and what its numbers tend to.

mod charts;
mod interface;
mod ladder;
mod page;
mod quantities;
mod sequence;
mod tables;

pub use interface::{Distance, distance};
pub use ladder::Halved;
pub use sequence::{Basis, Limit, Sequence, orders_of_changes, orders_of_errors};

use super::{Campaign, Outcome};
use crate::base::{Error, Kind, Result};
use crate::output::{Page, Snapshot};
use crate::scene::schema::MeshSource;
use crate::scene::{Scene, problem};
use interface::fields_at;
use ladder::Ladder;
use quantities::{DISTANCES, common, quantities, times};
use std::path::PathBuf;

/// Options of a convergence study.
#[derive(Clone, Debug, Default)]
pub struct Convergence {
    /// The parameters that are halved.
    pub halved: Halved,
    /// Levels, the scene being the coarsest one.
    pub levels: usize,
    /// Mesh files, from coarse to fine, instead of halving.
    pub meshes: Vec<PathBuf>,
    /// Columns of the series, or `interface` for the distances of the interfaces from level to
    /// level; a choice if empty.
    pub quantities: Vec<String>,
    /// Times at which they are taken, multiples of the scene's step; its end if empty.
    pub times: Vec<f64>,
    /// The order that theory gives, where it does: extrapolation is with that one.
    pub order: Option<f64>,
    /// Adds runs on the coarsest level with the parameters halved that the levels keep, to measure
    /// their effect.
    pub checks: bool,
}

/// Kind of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Meaning {
    /// A number that tends to a limit that is not known.
    Value,
    /// A norm of an error, which tends to zero.
    Error,
    /// A distance between neighbouring levels, which tends to zero.
    Change,
}

/// A quantity that is studied.
#[derive(Clone, Debug, PartialEq)]
struct Observable {
    name: String,
    meaning: Meaning,
}

/// A quantity at a time, on all levels.
#[derive(Clone, Debug)]
struct Observation {
    quantity: Observable,
    time: f64,
    sequence: Sequence,
    /// The order seen on each level and those before it.
    orders: Vec<f64>,
    limit: Option<Limit>,
    /// By how much each check moves it.
    checks: Vec<f64>,
}

/// Runs the levels of a study; the result is its page.
///
/// # Errors
/// A quantity or a time that the scene does not have; whatever [`Campaign::run`] gives. A level
/// that fails is left out.
pub fn convergence(campaign: &mut Campaign<'_>, settings: &Convergence) -> Result<Page> {
    let scene = campaign.scene().clone();
    // The model of the coarsest level knows the columns, and the band that the mesh would choose.
    let coarsest = problem(&scene)?;
    let (columns, thickness) = (coarsest.row()?.names().to_vec(), coarsest.limits().thickness);
    let quantities = quantities(&scene, &settings.quantities, &columns)?;
    let times = times(&scene, &settings.times)?;
    let common = common(&scene, &times, quantities.iter().any(|q| q.meaning == Meaning::Change));
    if !settings.meshes.is_empty() && !matches!(scene.mesh, MeshSource::File { .. }) {
        return Err(Error::scene("a list of meshes needs a scene with a mesh file")
            .at("--meshes")
            .remedy(
                "write mesh.file in the scene; its other keys then fit every mesh of the list",
            ));
    }
    let ladder = Ladder::new(&scene, settings, thickness, &common)?;
    let trials: Vec<_> =
        ladder.levels.iter().chain(ladder.checks.iter().map(|c| &c.1)).cloned().collect();
    // The checks come first: they are cheap.
    let order: Vec<usize> =
        (ladder.levels.len()..trials.len()).chain(0..ladder.levels.len()).collect();
    let mut outcomes: Vec<Option<Outcome>> = trials.iter().map(|_| None).collect();
    for (k, &i) in order.iter().enumerate() {
        outcomes[i] = Some(campaign.run(&trials[i], k + 1, trials.len())?);
    }
    let outcomes: Vec<Outcome> = outcomes.into_iter().flatten().collect();
    let (levels, checks) = outcomes.split_at(ladder.levels.len());
    let sizes = sizes(&scene, settings, &ladder, levels);
    let mut rows = Vec::new();
    for &time in &times {
        let apart = distances(campaign, &scene, &quantities, levels, time)?;
        for quantity in &quantities {
            let values = match quantity.meaning {
                Meaning::Change => apart
                    .iter()
                    .map(|of| of.iter().find(|d| d.0 == quantity.name).map_or(f64::NAN, |d| d.1))
                    .collect(),
                _ => levels
                    .iter()
                    .map(|o| o.value(&quantity.name, time))
                    .collect::<Result<Vec<f64>>>()?,
            };
            let moved = |o: &Outcome| {
                Ok(o.value(&quantity.name, time)? - values.first().copied().unwrap_or(f64::NAN))
            };
            let checks = match quantity.meaning {
                Meaning::Change => vec![f64::NAN; checks.len()],
                _ => checks.iter().map(moved).collect::<Result<_>>()?,
            };
            rows.push(Observation::new(
                quantity.clone(),
                time,
                Sequence { sizes: sizes.clone(), values },
                checks,
                known(settings),
            ));
        }
    }
    Ok(page::page(&page::Study {
        scene: &scene,
        settings,
        ladder: &ladder,
        outcomes: &outcomes,
        sizes: &sizes,
        rows: &rows,
    }))
}

/// The order that is known beforehand: that of the thickness is one.
fn known(settings: &Convergence) -> Option<f64> {
    settings.order.or(settings.halved.thickness.then_some(1.0))
}

impl Observation {
    fn new(
        quantity: Observable,
        time: f64,
        sequence: Sequence,
        checks: Vec<f64>,
        known: Option<f64>,
    ) -> Observation {
        let (orders, limit) = match quantity.meaning {
            Meaning::Value => (sequence.orders(), sequence.limit(known)),
            Meaning::Error => (orders_of_errors(&sequence.sizes, &sequence.values), None),
            Meaning::Change => (orders_of_changes(&sequence.sizes, &sequence.values), None),
        };
        Observation { quantity, time, sequence, orders, limit, checks }
    }

    /// The order seen on the finest level that gave a value; NaN if none is.
    fn order(&self) -> f64 {
        self.sequence
            .values
            .iter()
            .rposition(|v| v.is_finite())
            .and_then(|k| self.orders.get(k))
            .copied()
            .unwrap_or(f64::NAN)
    }

    /// The value on the finest level that gave one.
    fn finest(&self) -> f64 {
        self.sequence.values.iter().rev().find(|v| v.is_finite()).copied().unwrap_or(f64::NAN)
    }

    /// The values that tend to zero with the level: the error, or the change from the level before.
    fn shrinking(&self) -> Vec<f64> {
        match self.quantity.meaning {
            Meaning::Value => self.sequence.changes().into_iter().map(f64::abs).collect(),
            _ => self.sequence.values.clone(),
        }
    }
}

/// Mesh size, step or thickness of each level.
fn sizes(scene: &Scene, settings: &Convergence, ladder: &Ladder, levels: &[Outcome]) -> Vec<f64> {
    let halving = |first: f64| (0..levels.len()).map(|k| first / 2f64.powi(k as i32)).collect();
    if settings.halved.thickness {
        return halving(ladder.thickness.unwrap_or(f64::NAN));
    }
    if !settings.halved.space {
        return halving(scene.time.step);
    }
    let edges: Vec<f64> = levels.iter().map(|o| o.summary.edge.unwrap_or(f64::NAN)).collect();
    if settings.meshes.is_empty() {
        return edges;
    }
    // The longest edge of a mesh of a generator is a matter of chance; the mean size of its cells
    // is not.
    let power = -1.0 / scene.mesh.dimension() as f64;
    let sizes: Vec<f64> = levels
        .iter()
        .map(|o| o.summary.cells.map_or(f64::NAN, |n| (n as f64).powf(power)))
        .collect();
    let scale =
        edges.iter().zip(&sizes).map(|(e, s)| e / s).find(|s| s.is_finite()).unwrap_or(f64::NAN);
    sizes.iter().map(|s| s * scale).collect()
}

/// By level, the distances of the interfaces from those one level before, with the names of their
/// quantities.
fn distances(
    campaign: &Campaign<'_>,
    scene: &Scene,
    quantities: &[Observable],
    levels: &[Outcome],
    time: f64,
) -> Result<Vec<Vec<(String, f64)>>> {
    let mut all = Vec::new();
    let mut before: Option<Snapshot<2>> = None;
    for outcome in levels {
        let mut found = Vec::new();
        let mut now = None;
        if outcome.finished() && quantities.iter().any(|q| q.meaning == Meaning::Change) {
            let fields = fields_at(&campaign.folder_of(&outcome.trial)?, time)?;
            for s in scene.acting().filter(|_| before.is_some()) {
                let apart = before.as_ref().map(|b| distance(b, &fields, s.name())).transpose();
                match apart {
                    Ok(Some(d)) => found.extend(
                        DISTANCES
                            .map(|n| format!("{}.{n}", s.name()))
                            .into_iter()
                            .zip([d.mean, d.largest]),
                    ),
                    Ok(None) => {}
                    // An interface that is gone has no distance.
                    Err(e) if e.kind() == Kind::Computation => {}
                    Err(e) => return Err(e),
                }
            }
            now = Some(fields);
        }
        all.push(found);
        before = now;
    }
    Ok(all)
}
