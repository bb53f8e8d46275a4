//! What goes into a step of the flow and what comes out.

use super::block::Block;
use super::term::MomentumTerm;
use crate::linalg::SolveReport;
use crate::mesh::Point;
use crate::transport::Feet;
use nalgebra::SVector;

/// Velocity (one vector a P2 node) and pressure (one number a P1 node).
#[derive(Debug, Default, PartialEq)]
pub struct FlowState<const D: usize> {
    /// Velocity.
    pub u: Vec<SVector<f64, D>>,
    /// Pressure; of zero mean when no boundary is open.
    pub p: Vec<f64>,
}

impl<const D: usize> Clone for FlowState<D> {
    fn clone(&self) -> Self {
        FlowState { u: self.u.clone(), p: self.p.clone() }
    }
    fn clone_from(&mut self, other: &Self) {
        self.u.clone_from(&other.u);
        self.p.clone_from(&other.p);
    }
}

/// Force per volume as a function of position and time.
pub type BodyForce<const D: usize> = dyn Fn(&Point<D>, f64) -> SVector<f64, D> + Send + Sync;

/// An earlier velocity, followed along the characteristics, in the discrete time derivative.
#[derive(Clone, Copy)]
pub struct History<'a, const D: usize> {
    /// Its coefficient: `(weight0 u - sum weight u_k o X_k) / dt`.
    pub weight: f64,
    /// The velocity.
    pub u: &'a [SVector<f64, D>],
    /// Feet of the quadrature points of the flow's rule; `None` takes the velocity where it is (no convection).
    pub feet: Option<&'a Feet>,
}

/// What one step solves: `rho (weight0 u - sum_k weight_k u_k o X_k)/dt - div(2 mu D(u)) + grad p = force`, `div u = 0`.
pub struct Step<'a, const D: usize> {
    /// The new time.
    pub time: f64,
    /// Its length.
    pub dt: f64,
    /// Coefficient of the new velocity in the discrete time derivative: 1 (BDF1), 3/2 (BDF2), 0 (Stokes).
    pub weight: f64,
    /// Earlier velocities; empty for Stokes.
    pub history: &'a [History<'a, D>],
    /// What acts on the flow.
    pub terms: &'a [&'a dyn MomentumTerm<D>],
    /// Unknowns of structures.
    pub blocks: &'a [&'a dyn Block<D>],
    /// The velocity that explicit forces of implicit terms were made with; `None` stands for zero.
    pub predicted: Option<&'a [SVector<f64, D>]>,
    /// Force per volume at position and new time.
    pub body_force: Option<&'a BodyForce<D>>,
    /// Force per mass (gravity).
    pub gravity: SVector<f64, D>,
}

impl<'a, const D: usize> Step<'a, D> {
    /// A step of backward Euler from `history`, without forces: fill in the rest with struct update syntax.
    pub fn backward_euler(time: f64, dt: f64, history: &'a [History<'a, D>]) -> Step<'a, D> {
        Step {
            time,
            dt,
            weight: 1.0,
            history,
            terms: &[],
            blocks: &[],
            predicted: None,
            body_force: None,
            gravity: SVector::zeros(),
        }
    }
}

/// What a step cost and how good its solve was.
#[derive(Clone, Copy, Debug)]
pub struct StepReport {
    /// The linear solve.
    pub solve: SolveReport,
    /// Whether the matrix was factored anew.
    pub refactored: bool,
    /// Whether iterations with an older factor were given up before.
    pub given_up: bool,
}
