//! Problems in time: immersed flow, advection in a prescribed velocity, segmentation of an image.
//! Independent of files and of constitutive laws.

mod advection;
mod balance;
mod carried;
mod checkpoint;
mod clock;
mod immersed;
mod outlets;
mod segmentation;
mod state;
mod strain;
mod transfer;

pub use crate::flow::ConvectionScheme;
pub use crate::flow::Fluid;
pub use crate::linalg::{SolverKind, SolverOptions};
pub use crate::structure::{
    Coupling, InitialFunction, LevelSet, REMAP, polygon_area, polygon_length,
};
pub use advection::Advection;
pub use balance::{Energies, EnergyBalance};
pub use carried::{Carried, Transport, When};
pub use clock::{Clock, Pacing};
pub use immersed::{Simulation, SimulationSettings};
pub use segmentation::Segmenting;
pub use state::{Factored, State};
pub use transfer::Transfer;
