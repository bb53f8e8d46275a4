//! Problems described by scenes, each in its own file.

mod advected;
mod fields;
mod flow_advice;
mod flow_plan;
mod ground;
mod immersed;
mod resolution;
mod scales;
mod segmented;

pub use advected::Advected;
pub use immersed::ImmersedFlow;
pub use segmented::{Answer, Segmented};

use super::Scene;
use super::problem::Problem;
use super::remedies::with_keys;
use crate::base::{Result, Warning};

/// Builds the problem that a scene describes.
///
/// # Errors
/// Of kind `Scene` or `Input`: invalid values, with their position.
pub fn problem(scene: &Scene) -> Result<Box<dyn Problem>> {
    with_keys(match scene.dimension() {
        2 => problem_in::<2>(scene),
        _ => problem_in::<3>(scene),
    })
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

/// The plan of a scene as plain text, with warnings.
///
/// # Errors
/// Those of [`problem`] and [`Problem::plan`].
pub fn explain(scene: &Scene) -> Result<(String, Vec<Warning>)> {
    let mut problem = problem(scene)?;
    let plan = problem.plan()?;
    Ok((plan, problem.warnings().to_vec()))
}
