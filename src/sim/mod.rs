//! A simulation: its state, its time step, its energy budget, its checkpoint. Knows no files and prints nothing.

mod budget;
mod checkpoint;
mod step;

pub use budget::{Budget, Energies};
pub use step::{Coupling, Materials, Settings, Simulation, State, Structure, TwoFluids};
