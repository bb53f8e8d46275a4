//! Problems in time: immersed flow, advection in a given velocity, segmentation of an image. Knows
//! no files and no law of a structure.

mod advection;
mod budget;
mod carried;
mod checkpoint;
mod clock;
mod immersed;
mod segmentation;
mod state;
mod strain;
mod transfer;

pub use crate::flow::Fluid;
pub use crate::linalg::{Solving, Way};
pub use crate::structure::{Coupling, InitialFunction, LevelSet, REMAP, polygon_area, polygon_length};
pub use advection::Advection;
pub use budget::{Budget, Energies};
pub use carried::{Carried, Transport};
pub use clock::{Clock, Pacing};
pub use immersed::{Settings, Simulation};
pub use segmentation::Segmenting;
pub use state::{Factored, Pace, State};
pub use transfer::Transfer;
