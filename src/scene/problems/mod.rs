//! Problems described by scenes, each in its own file.

mod advected;
mod fields;
mod flow_advice;
mod flow_plan;
mod forces;
mod ground;
mod immersed;
mod interfaces;
mod resolution;
mod scales;
mod segmented;

pub use advected::Advected;
pub use immersed::ImmersedFlow;
pub use segmented::{Answer, Segmented};

use super::Scene;
use super::problem::Problem;
use super::remedies::with_keys;
use super::row::Row;
use crate::base::{Error, Result};
use std::collections::HashSet;

/// Builds the problem that a scene describes.
///
/// # Errors
/// Of kind `Scene` or `Input`: invalid values, with their position.
pub fn problem(scene: &Scene) -> Result<Box<dyn Problem>> {
    let problem = with_keys(match scene.dimension() {
        2 => problem_in::<2>(scene),
        _ => problem_in::<3>(scene),
    })?;
    check_columns(scene, &problem.row()?)?;
    Ok(problem)
}

/// Rejects a series with two columns of one name: readers by name would find one of them.
fn check_columns(scene: &Scene, row: &Row) -> Result<()> {
    let mut seen = HashSet::from(["time"]);
    let Some(twice) = row.names().iter().find(|name| !seen.insert(name)) else { return Ok(()) };
    // The name that a scene gives begins the names of its columns.
    let output = &scene.output;
    let given = output.probes.iter().map(|p| ("probes", &p.name));
    let given = given.chain(output.forces.iter().map(|f| ("forces", &f.name)));
    let given = given.chain(output.fluxes.iter().map(|f| ("fluxes", &f.name)));
    let given = given.chain(output.curves.iter().map(|c| ("curves", &c.name)));
    let of_it = |name: &str| {
        twice.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(['_', '.']))
    };
    let (list, name) = given
        .filter(|(_, name)| of_it(name))
        .max_by_key(|(_, name)| name.len())
        .map_or(("", ""), |(list, name)| (list, name));
    let e = Error::scene(format!("the series would have two columns `{twice}`"))
        .value(if name.is_empty() { twice.as_str() } else { name })
        .remedy("give it another name: `immersa explain` and the reference list the columns");
    Err(scene.blame(&["output", list, name], e))
}

fn problem_in<const D: usize>(scene: &Scene) -> Result<Box<dyn Problem>> {
    Ok(if scene.image.is_some() {
        Box::new(Segmented::<D>::new(scene)?)
    } else if scene.fluid.is_prescribed() {
        Box::new(Advected::<D>::new(scene)?)
    } else {
        Box::new(ImmersedFlow::<D>::new(scene)?)
    })
}
