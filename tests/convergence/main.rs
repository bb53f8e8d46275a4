//! The evidence: orders of convergence, FreeFEM, published and exact numbers, and failures where
//! they are predicted.
//!
//! README.md beside this file holds the table of what was measured; `cargo test --release --test
//! convergence -- --nocapture` prints it anew. Every order is asserted with its absolute error.
#![allow(
    clippy::print_stdout,
    reason = "the measured figures are printed for the table of README.md"
)]

#[path = "../suite/case.rs"]
#[allow(dead_code, reason = "scenes of the suite are measured in more ways")]
mod case;
mod exact;
mod membrane;
mod tools;

mod body;
mod capillary;
mod contours;
mod drop_modes;
mod energy;
mod explicit_limit;
mod failures;
mod freefem;
mod geometry;
mod prosperetti;
mod redistance;
mod relaxation;
mod semi_implicit;
mod sharp;
mod space_in_3d;
mod space_order;
mod static_drop;
mod study;
mod surface;
mod tension_stability;
mod time_order;
mod transport;
mod transport_in_3d;
mod virtual_work;
mod vortex;
