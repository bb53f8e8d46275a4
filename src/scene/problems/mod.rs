//! The problems that a scene can describe, each in a file of its own.

mod advected;
mod fields;
mod flow_plan;
mod ground;
mod immersed;
mod segmented;

pub use advected::Advected;
pub use immersed::ImmersedFlow;
pub use segmented::{Answer, Segmented};
