//! What a scene comes to, told before it runs, whatever its dimension.

use super::Scene;
use super::diagnostics::Diagnostics;
use super::dimension::{Dimension, In};
use super::model::Model;
use crate::base::{Result, Warning};

/// What a run of a scene would have, known from its model at time 0.
#[derive(Clone, Debug)]
pub struct Survey {
    /// The columns of its series, without `time`.
    pub columns: Vec<String>,
    /// The half-width of the bands.
    pub thickness: Option<f64>,
    /// Shortest and longest edge in the bands.
    pub band_edges: Option<[f64; 2]>,
    /// Largest stable step of the explicit coupling (1.54), if there is one.
    pub explicit_limit: Option<f64>,
}

impl Survey {
    /// Builds the model of a scene and looks at it.
    ///
    /// # Errors
    /// Those of [`Model::new`] and [`Diagnostics::new`].
    pub fn of(scene: &Scene) -> Result<Survey> {
        match scene.dimension() {
            2 => survey::<2>(scene),
            _ => survey::<3>(scene),
        }
    }
}

fn survey<const D: usize>(scene: &Scene) -> Result<Survey>
where
    In<D>: Dimension<D>,
{
    let model = Model::<D>::new(scene)?;
    let columns = Diagnostics::new(scene, &model)?.columns();
    let Model { thickness, band_edges, explicit_limit, .. } = model;
    Ok(Survey { columns, thickness, band_edges, explicit_limit })
}

/// The plan of a scene as plain text, and what the user should know beside it.
///
/// # Errors
/// Those of [`Model::new`] and [`Model::plan`].
pub fn explain(scene: &Scene) -> Result<(String, Vec<Warning>)> {
    match scene.dimension() {
        2 => explain_in::<2>(scene),
        _ => explain_in::<3>(scene),
    }
}

fn explain_in<const D: usize>(scene: &Scene) -> Result<(String, Vec<Warning>)>
where
    In<D>: Dimension<D>,
{
    let mut model = Model::<D>::new(scene)?;
    let plan = model.plan(scene)?;
    Ok((plan, model.warnings))
}
