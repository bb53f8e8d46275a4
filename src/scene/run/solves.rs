//! Statistics of the solves of linear systems.

use crate::flow::StepReport;
use serde::{Deserialize, Serialize};

/// Numbers of factorisations and iterations, in all sessions of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Solves {
    /// Numeric factorisations.
    pub factorisations: u64,
    /// Number of systems solved iteratively: with an older factor, or with an inexact one.
    pub krylov: u64,
    /// Number of systems whose iterations with an older factor did not converge, so that they were
    /// factored and solved directly.
    pub given_up: u64,
    /// Total number of iterations.
    pub iterations: u64,
    /// Mean number of iterations per system solved iteratively.
    pub mean_iterations: f64,
    /// Largest number of iterations of a system.
    pub most_iterations: u64,
    /// Largest accepted relative residual of direct solves and iterations.
    pub worst_residual: f64,
}

impl Solves {
    /// Adds the statistics of a step.
    pub(super) fn note(&mut self, report: &StepReport) {
        let (iterations, solve) = (report.solve.iterations as u64, &report.solve);
        self.factorisations += u64::from(report.refactored);
        self.iterations += iterations;
        self.worst_residual = self.worst_residual.max(solve.residual);
        match (report.given_up, iterations) {
            (_, 0) => {}
            (true, _) => self.given_up += 1,
            (false, _) => {
                let sum = self.mean_iterations * self.krylov as f64 + iterations as f64;
                self.krylov += 1;
                self.mean_iterations = sum / self.krylov as f64;
                self.most_iterations = self.most_iterations.max(iterations);
            }
        }
    }
}
