//! A simulation: its state, its time step, its energy budget, its checkpoint. Knows no files and prints nothing.

mod backward;
mod budget;
mod carrier;
mod checkpoint;
mod clock;
mod lagged;
mod markers;
mod materials;
mod passive;
mod redistance;
mod remesh;
mod segment;
mod setup;
mod step;
mod stepper;
mod stretch;

pub use crate::linalg::{Solving, Way};
pub use budget::{Budget, Energies};
pub use carrier::{InitialFunction, REMAP};
pub use clock::{Clock, Pacing};
pub use markers::{polygon_area, polygon_length};
pub use remesh::Transfer;
pub use setup::{Coupling, Factored, Fluid, LevelSet, Pace, Settings, State, Structure};
pub use step::Simulation;
