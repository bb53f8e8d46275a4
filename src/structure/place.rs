//! Arguments of a structure's functions: before, during and after a step.

use super::carrier::Carrier;
use super::fields::Fields;
use crate::base::Result;
use crate::fem::{Basis, Space, Translation, VelocityFunction};
use crate::flow::{Coefficient, FlowSolver};
use crate::transport::AdvectingVelocity;
use nalgebra::SVector;
use std::sync::Arc;

/// The discretisation that a structure is built on.
pub struct Host<'a, const D: usize> {
    /// P2 space of velocity and level sets.
    pub space: &'a Arc<Space<D>>,
    /// Velocity basis at the points of the flow's rule; `None` where the velocity is prescribed.
    pub basis: Option<&'a Basis<D>>,
    /// Pairs of facets on periodic sides.
    pub translations: &'a [Translation<D>],
}

/// Fields and flow data for which structures prepare their forces.
pub struct Place<'a, const D: usize> {
    /// P2 space of velocity and level sets.
    pub space: &'a Space<D>,
    /// Velocity basis at the points of the flow's rule.
    pub basis: &'a Basis<D>,
    /// Density of the fluid at the points of that rule.
    pub density: &'a Coefficient,
    /// Fields at which forces are evaluated.
    pub fields: &'a Fields<D>,
    /// Fields at the start of the step, and the same transported over the step by the velocity
    /// there; present if some coupling [is semi-implicit](super::Coupling::SemiImplicit).
    pub drift: Option<[&'a Fields<D>; 2]>,
    /// Length of the step; `None` if only the size of the force is needed.
    pub step: Option<f64>,
    /// Time.
    pub time: f64,
}

impl<'a, const D: usize> Place<'a, D> {
    /// Outside of a step: for the size of the forces and their energies.
    pub fn new(
        space: &'a Space<D>,
        flow: &'a FlowSolver<D>,
        fields: &'a Fields<D>,
        time: f64,
    ) -> Place<'a, D> {
        let (basis, density) = (flow.velocity(), flow.density());
        Place { space, basis, density, fields, drift: None, step: None, time }
    }
}

/// The velocity over a step.
#[derive(Clone, Copy)]
pub enum Velocity<'a, const D: usize> {
    /// Nodal values at the start and the end of the step, and the velocity of the transport.
    Computed {
        /// At the start and at the end.
        ends: [&'a [SVector<f64, D>]; 2],
        /// The velocity of the transport.
        mean: &'a [SVector<f64, D>],
    },
    /// A function of position and time.
    Given {
        /// The function.
        velocity: &'a VelocityFunction<D>,
        /// Time at the start of the step.
        start: f64,
        /// Largest Courant number in the step.
        courant: f64,
    },
}

impl<'a, const D: usize> Velocity<'a, D> {
    /// The velocity for the transport, over a step of length `dt`.
    pub fn advecting(&self, dt: f64) -> AdvectingVelocity<'a, D> {
        match *self {
            Velocity::Computed { mean, .. } => AdvectingVelocity::Nodal(mean),
            Velocity::Given { velocity, start, courant } => {
                AdvectingVelocity::Given { velocity, arrival: start + dt, courant }
            }
        }
    }
}

/// A step after the transport of the convected fields.
pub struct Moved<'a, const D: usize> {
    /// The transport.
    pub carrier: &'a mut Carrier<D>,
    /// The velocity.
    pub velocity: Velocity<'a, D>,
    /// All fields at the start of the step.
    pub before: &'a Fields<D>,
    /// Values of the unknowns of the blocks of this structure, one list per block.
    pub blocks: &'a [Vec<f64>],
    /// Length of the step.
    pub dt: f64,
    /// Time at its end.
    pub time: f64,
    /// True for a prediction.
    pub ahead: bool,
}

impl<const D: usize> Moved<'_, D> {
    /// Transports nodal values from the start over the step, as convected fields.
    ///
    /// # Errors
    /// A projection that fails.
    pub fn convect(&mut self, values: &[f64]) -> Result<Vec<f64>> {
        let mut moved = vec![0.0; values.len()];
        self.carrier.find_feet(&self.velocity.advecting(self.dt), self.dt);
        self.carrier.carry_scalar(values, &mut moved)?;
        Ok(moved)
    }
}
