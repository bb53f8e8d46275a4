//! What every layer may use: errors as values and deterministic parallel loops.

mod error;
pub mod parallel;

pub use error::{Error, Kind, Result, Snippet, Warning};
