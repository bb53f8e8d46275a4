//! Incompressible flow with P2-P1 Taylor-Hood elements. Knows velocity and pressure only; whatever is immersed in it
//! acts through a [`MomentumTerm`](term::MomentumTerm).

mod boundary;
mod coefficient;
mod solver;
pub mod term;

pub use boundary::{Load, flux, kinetic_outflow, traction};
pub use coefficient::Coefficient;
pub use solver::{BodyForce, FlowSolver, FlowState, History, Step, StepReport};
