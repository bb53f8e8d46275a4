//! The state of a simulation, as stored in a checkpoint.

use super::balance::{Energies, EnergyBalance};
use super::clock::Clock;
use crate::base::{Cause, Error, Result};
use crate::flow::FlowState;
use crate::linalg::SolveCost;
use crate::structure::Fields;
use nalgebra::SVector;

/// Data of the matrix whose factor is kept while the matrix changes: a resumed run computes the
/// same factor and continues bit-identically.
#[derive(Clone, Debug, PartialEq)]
pub struct Factored<const D: usize> {
    /// Fields of the structures.
    pub fields: Fields<D>,
    /// Rates of the fluid that comes in through open sides.
    pub backflow: Vec<f64>,
    /// Velocity of implicit convection; empty without.
    pub wind: Vec<SVector<f64, D>>,
    /// Coefficient of the new velocity in the discrete time derivative, over the step.
    pub weight: f64,
    /// The step.
    pub dt: f64,
    /// Costs that decide between iterations and a factorisation.
    pub solve_cost: SolveCost,
}

/// All quantities that change in time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<const D: usize> {
    /// Steps taken.
    pub steps: u64,
    /// The time.
    pub time: f64,
    /// State of adaptive time steps; `None` with constant steps.
    pub pace: Option<Clock>,
    /// Velocity and pressure; no pressure where the velocity is prescribed.
    pub flow: FlowState<D>,
    /// Velocity one step earlier; empty where the velocity is prescribed.
    pub earlier_u: Vec<SVector<f64, D>>,
    /// Velocity two steps earlier, with adaptive steps and in order 3; empty without.
    pub earliest_u: Vec<SVector<f64, D>>,
    /// Fields of the structures.
    pub fields: Fields<D>,
    /// Data of the factor of the flow, if it is kept while the matrix changes.
    pub factored: Option<Factored<D>>,
    /// Current energies.
    pub energies: Energies,
    /// The energy balance.
    pub balance: EnergyBalance,
}

impl<const D: usize> State<D> {
    /// True if there is a pressure: it comes with a step, and before the first there is none unless
    /// the state was taken from elsewhere.
    pub fn has_pressure(&self) -> bool {
        self.steps > 0 || self.flow.p.iter().any(|p| *p != 0.0)
    }
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
            .remedy("resume with the scene that the run was started with, or start a new run")
            .because(Cause::Checkpoint))
    }
}
