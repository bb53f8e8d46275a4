//! Sparse symmetric matrices, fill-reducing orderings and direct solvers, independent of any mesh.
//!
//! Use: build a [`SymmetricMatrix`] from the groups of unknowns that couple, fill it, choose an
//! [`Ordering`], analyse it once with [`Factor::analyse`], call [`Factor::refactor`] when values
//! change, and [`Factor::solve`] as often as needed.

mod addition;
mod direct;
mod engine;
mod gmres;
mod lagged;
mod metis;
mod ordering;
mod schur;
mod single;
mod size;
mod substitution;
mod symmetric;

#[cfg(test)]
mod testing;

pub use addition::{Addition, Operator};
pub use direct::{Factor, SolveReport};
pub use engine::{SolverKind, SolverOptions};
pub use lagged::{Change, LaggedFactor, LaggedReport, SolveCost};
pub use ordering::{Multipliers, Ordering};
pub use schur::Saddle;
pub use size::{FactorSize, Precision};
pub use symmetric::{CONSTRAINED, SymmetricMatrix};
