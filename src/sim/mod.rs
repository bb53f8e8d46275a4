//! A simulation: its state, its time step, its energy budget, its checkpoint. Knows no files and prints nothing.

mod budget;
mod checkpoint;
mod setup;
mod step;

pub use budget::{Budget, Energies};
pub use setup::{Contrast, Coupling, Materials, Settings, State, Structure};
pub use step::Simulation;
