//! A simulation: its state, its time step, its energy budget, its checkpoint. Knows no files and prints nothing.

mod budget;
mod carrier;
mod checkpoint;
mod markers;
mod materials;
mod passive;
mod remesh;
mod setup;
mod step;
mod stretch;

pub use budget::{Budget, Energies};
pub use carrier::{InitialFunction, REMAP};
pub use markers::{polygon_area, polygon_length};
pub use remesh::Transfer;
pub use setup::{Contrast, Coupling, LevelSet, Materials, Settings, State, Structure};
pub use step::Simulation;
