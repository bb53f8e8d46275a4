//! Facilities for all layers: errors as values, deterministic parallel loops, time by phase.

mod bandwidth;
pub mod bytes;
mod error;
mod hash;
pub mod parallel;
mod partition;
mod phases;
mod same;

pub use bandwidth::copy_bandwidth;
pub use error::{Cause, Error, Kind, Result, Snippet, Warning};
pub use hash::fnv1a;
pub use partition::Partition;
pub use phases::{PHASES, Phase, Phases};
pub use same::same;

/// Version of the program, with the commit that it was built from where that is known.
pub const VERSION: &str = env!("IMMERSA_VERSION");
