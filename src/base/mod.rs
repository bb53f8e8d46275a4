//! Facilities for all layers: errors as values, deterministic parallel loops, time by phase.

mod bandwidth;
pub mod bytes;
mod error;
mod hash;
mod memory;
pub mod parallel;
mod partition;
mod phases;
mod plain_file;
mod rounded;
mod same;

pub use bandwidth::copy_bandwidth;
pub use error::{Cause, Error, Kind, Result, Snippet, Warning};
pub use hash::fnv1a;
pub use memory::{available_memory, readable_bytes};
pub use partition::Partition;
pub use phases::{PHASES, Phase, Phases};
pub use plain_file::read_plain;
pub(crate) use rounded::trimmed;
pub use rounded::{length, rounded};
pub use same::same;

/// Version of the program, with the commit that it was built from where that is known.
pub const VERSION: &str = env!("IMMERSA_VERSION");
