//! Problems in time: immersed flow, advection in a prescribed velocity, segmentation of an image.
//! Independent of files and of constitutive laws.

mod advection;
mod carried;
mod checkpoint;
mod immersed;
mod segmentation;
mod state;
mod strain;
mod transfer;

pub use crate::flow::Fluid;
pub use crate::linalg::{SolverKind, SolverOptions};
pub use crate::structure::{Coupling, InitialFunction, LevelSet, REMAP, polygon_area, polygon_length};
pub use advection::Advection;
pub use carried::{Carried, Transport};
pub use immersed::{Clock, Energies, EnergyBalance, Pacing, Simulation, SimulationSettings};
pub use segmentation::Segmenting;
pub use state::{Factored, Pace, State};
pub use transfer::Transfer;
