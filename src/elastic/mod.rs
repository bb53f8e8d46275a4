//! Elastic structures that act on the flow: one law per file.

mod area_law;
mod membrane;
mod predictor;
mod sharp;

pub use area_law::AreaLaw;
pub use membrane::{Band, Membrane, explicit_step_limit};
pub use predictor::Predictor;
pub use sharp::{Cut, Force, SharpMembrane};
