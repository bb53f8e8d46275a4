//! All that changes in time; a checkpoint holds it.

use super::immersed::{Budget, Clock, Energies};
use crate::base::{Error, Result};
use crate::flow::FlowState;
use crate::linalg::SolveCost;
use crate::structure::Fields;
use nalgebra::SVector;

/// Position of a run whose steps follow the error.
#[derive(Clone, Debug, PartialEq)]
pub struct Pace<const D: usize> {
    /// Lengths of steps.
    pub clock: Clock,
    /// Velocity two steps earlier.
    pub earliest_u: Vec<SVector<f64, D>>,
}

/// Ingredients of the matrix whose factor is kept while the matrix changes: with them a resumed run
/// has the same factor, and continues with the same bits.
#[derive(Clone, Debug, PartialEq)]
pub struct Factored<const D: usize> {
    /// Fields of the structures.
    pub fields: Fields<D>,
    /// Coefficient of the new velocity in the discrete time derivative, over the step.
    pub weight: f64,
    /// The step.
    pub dt: f64,
    /// Statistics of the choice between iterations and a factorisation.
    pub solve_cost: SolveCost,
}

/// All that changes in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<const D: usize> {
    /// Steps taken.
    pub steps: u64,
    /// The time.
    pub time: f64,
    /// Position of steps that follow the error; `None` with steps of one length.
    pub pace: Option<Pace<D>>,
    /// Velocity and pressure; no pressure where the velocity is prescribed.
    pub flow: FlowState<D>,
    /// Velocity one step earlier; empty where the velocity is prescribed.
    pub earlier_u: Vec<SVector<f64, D>>,
    /// Fields of the structures.
    pub fields: Fields<D>,
    /// Ingredients of the factor of the flow, where it outlives its matrix.
    pub factored: Option<Factored<D>>,
    /// Energies now.
    pub energies: Energies,
    /// The energy budget.
    pub budget: Budget,
}

impl<const D: usize> State<D> {
    /// Checks that `other` is a state of the same simulation.
    ///
    /// # Errors
    /// Names or sizes that differ.
    pub(super) fn check_fits(&self, other: &State<D>) -> Result<()> {
        let flow = |s: &State<D>| [s.flow.u.len(), s.flow.p.len(), s.earlier_u.len()];
        let same_fields = self.fields.fits(&other.fields);
        if same_fields && flow(self) == flow(other) && self.pace.is_some() == other.pace.is_some() {
            return Ok(());
        }
        let sizes = |s: &State<D>| format!("{:?}, {:?}", flow(s), s.fields.sizes());
        Err(Error::input("the checkpoint does not belong to this scene")
            .value(format!("{} instead of {}", sizes(other), sizes(self)))
            .remedy(
                "resume with the scene that the run was started with, or start afresh in another \
                 folder with --out",
            ))
    }
}
