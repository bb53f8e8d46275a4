//! What every layer may use: errors as values and deterministic parallel loops.

pub mod bytes;
mod error;
mod hash;
pub mod parallel;

pub use error::{Error, Kind, Result, Snippet, Warning};
pub use hash::fnv1a;
