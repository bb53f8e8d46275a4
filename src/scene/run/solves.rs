//! How the linear systems of a run were solved.

use crate::flow::StepReport;
use serde::{Deserialize, Serialize};

/// Counts of factorisations and iterations, of all sessions of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Solves {
    /// Numeric factorisations.
    pub factorisations: u64,
    /// Systems that were solved by iterations: with an older factor, or with one that is not exact.
    pub krylov: u64,
    /// Systems whose iterations with an older factor were given up: factored, and solved with their own.
    pub given_up: u64,
    /// Iterations in all.
    pub iterations: u64,
    /// Mean number of iterations of a system that was solved by them.
    pub mean_iterations: f64,
    /// Largest such number.
    pub most_iterations: u64,
    /// Largest relative residual that was accepted, of direct solves and iterations.
    pub worst_residual: f64,
}

impl Solves {
    /// Counts a step.
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
