//! Input and output of a step of the flow.

use super::block::Block;
use super::convection::Convection;
use super::term::MomentumTerm;
use crate::linalg::SolveReport;
use crate::mesh::Point;
use crate::transport::Feet;
use nalgebra::SVector;

/// Velocity (one vector per P2 node) and pressure (one number per node of its element).
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

/// An earlier velocity in the discrete time derivative, taken at the feet of characteristics.
#[derive(Clone, Copy)]
pub struct History<'a, const D: usize> {
    /// Its coefficient: `(weight0 u - sum weight u_k o X_k) / dt`.
    pub weight: f64,
    /// The velocity.
    pub u: &'a [SVector<f64, D>],
    /// Feet of the quadrature points of the flow's rule; `None` for no convection.
    pub feet: Option<&'a Feet>,
}

/// Data of one step:
/// `rho (weight0 u - sum_k weight_k u_k o X_k)/dt - div(2 mu D(u)) + grad p = force`, `div u = 0`;
/// (3.20), (3.21).
pub struct Step<'a, const D: usize> {
    /// The new time.
    pub time: f64,
    /// Its length.
    pub dt: f64,
    /// Coefficient of the new velocity in the discrete time derivative: 1 (BDF1), 3/2 (BDF2), 0
    /// (Stokes).
    pub weight: f64,
    /// Earlier velocities; empty for Stokes.
    pub history: &'a [History<'a, D>],
    /// Convection, if it is not along the characteristics of the history.
    pub convection: Convection<'a, D>,
    /// Forces of structures.
    pub terms: &'a [&'a dyn MomentumTerm<D>],
    /// Blocks of unknowns of structures.
    pub blocks: &'a [&'a dyn Block<D>],
    /// The velocity that the explicit forces of implicit terms were computed with; `None` for zero.
    pub predicted: Option<&'a [SVector<f64, D>]>,
    /// Force per volume as a function of position and new time.
    pub body_force: Option<&'a BodyForce<D>>,
    /// Force per mass (gravity).
    pub gravity: SVector<f64, D>,
}

impl<'a, const D: usize> Step<'a, D> {
    /// A step of backward Euler from `history`, without forces; set other fields with struct update
    /// syntax.
    pub fn backward_euler(time: f64, dt: f64, history: &'a [History<'a, D>]) -> Step<'a, D> {
        Step {
            time,
            dt,
            weight: 1.0,
            history,
            convection: Convection::InHistory,
            terms: &[],
            blocks: &[],
            predicted: None,
            body_force: None,
            gravity: SVector::zeros(),
        }
    }
}

/// Cost and accuracy of a step.
#[derive(Clone, Copy, Debug)]
pub struct StepReport {
    /// The linear solve.
    pub solve: SolveReport,
    /// True if the matrix was factored.
    pub refactored: bool,
    /// True if iterations with an older factor were abandoned first.
    pub given_up: bool,
}
