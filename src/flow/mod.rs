//! Incompressible flow with P2-P1 Taylor-Hood elements. Structures act on it through
//! [`MomentumTerm`](term::MomentumTerm) and [`Block`](block::Block) only.

mod backflow;
pub mod block;
mod boundary;
mod coefficient;
mod convection;
mod opening;
mod pressure;
mod solenoidal;
mod solver;
mod step;
pub mod term;
mod wake;

pub use backflow::Backflow;
pub use boundary::{Load, flux, kinetic_outflow, nodal_traction, stress_size, traction};
pub use coefficient::{Coefficient, Fluid};
pub use convection::{Convection, ConvectionScheme, STABILISED};
pub use opening::{GivenStress, GradientForm};
pub use pressure::nodal_pressure;
pub use solenoidal::solenoidal;
pub use solver::FlowSolver;
pub use step::{BodyForce, FlowState, History, Step, StepReport};
pub use wake::Wake;
