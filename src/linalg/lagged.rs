//! A factor that is kept while the matrix changes: it preconditions, and is made anew when that is cheaper.

use super::direct::require_finite;
use super::engine::{Engine, Solving, Way};
use super::gmres::{Gmres, Iterated, RESTART};
use super::schur::Saddle;
use super::{Factor, FactorSize, Multipliers, Ordering, SolveReport, SymmetricMatrix};
use crate::base::{Cause, Error, Result};
use cpu_time::ProcessTime;

/// What the factor has to do with the matrix of a solve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The factor is that of this matrix.
    None,
    /// The matrix has changed and will stay for many solves: it is factored.
    Lasting,
    /// The matrix changes from solve to solve: the cheaper way is taken.
    Passing,
}

/// What a solve of [`LaggedFactor`] was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaggedReport {
    /// Its quality; `iterations` counts those that were given up too, and is 0 after a direct solve.
    pub solve: SolveReport,
    /// Whether the matrix was factored.
    pub refactored: bool,
    /// Whether iterations with an older factor were given up before.
    pub given_up: bool,
    /// How often the factor was read, each time twice.
    pub substitutions: usize,
    /// Seconds of all processors in the factorisation.
    pub factoring: f64,
}

impl LaggedReport {
    /// Of a solve with the factor of the matrix, after a factorisation that took these seconds or none.
    fn direct(solve: SolveReport, factoring: Option<f64>) -> LaggedReport {
        let substitutions =
            solve.iterations + if solve.iterations == 0 || factoring.is_some() { 1 + solve.refinements } else { 0 };
        LaggedReport {
            solve,
            refactored: factoring.is_some(),
            given_up: false,
            substitutions,
            factoring: factoring.unwrap_or_default(),
        }
    }
}

/// The books of the choice between iterations and a factorisation. Counts alone: the choice is the same in every run of a scene,
/// on any machine and for any number of threads.
///
/// The unit is one iteration. A factorisation costs [`Factor::cost`] of them, and the solve with it one more. After each solve the cost of that solve is
/// held against the mean cost of the solves since the last factorisation, that one included: as soon as it is larger, the mean is
/// at its least, and the next solve factors (the rule for replacing what wears out).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Solves since the last factorisation, the one with it included.
    pub solves: f64,
    /// What they cost.
    pub spent: f64,
    /// What the last of them cost.
    pub last: f64,
    /// Solves that still factor without a trial, because trials have failed.
    pub hold: f64,
    /// How many periods in a row saved nothing.
    pub failures: f64,
}

/// Longest series of solves without a trial.
const LONGEST_HOLD: f64 = 64.0;
/// A factorisation that costs fewer iterations than this is never put off: that many are needed at least.
const LEAST_COST: f64 = 3.0;
/// Part of the cost of factoring each time that a period of iterations may have, to count as one that saves.
const WORTHWHILE: f64 = 0.95;
/// What a solve with the factor of the matrix costs, in iterations.
const DIRECT_SOLVE: f64 = 1.0;
/// Relative residual of iterations with a factor of the matrix itself, where no other is given.
const OWN_TOLERANCE: f64 = 1e-10;

impl Ledger {
    fn wants_factor(&self) -> bool {
        self.hold > 0.0 || self.last * self.solves > self.spent
    }
    /// A factorisation begins another period, `wasted` iterations after the last one; the solve with it cost `own`. A period that saved nothing is a failure, and the
    /// next trials come after 0, 1, 3, 7, ... further factorisations.
    fn factored(&mut self, cost: f64, own: f64, wasted: usize) {
        let direct = cost + own;
        let tried = self.solves > 1.0 || wasted > 0;
        if tried && self.spent + wasted as f64 > WORTHWHILE * direct * self.solves {
            self.failures = (self.failures + 1.0).min(LONGEST_HOLD.log2() + 1.0);
            self.hold = (self.failures - 1.0).exp2();
        } else if tried {
            self.failures = 0.0;
        }
        let hold = (self.hold - 1.0).max(0.0);
        *self = Ledger { solves: 1.0, spent: direct, last: 0.0, hold, failures: self.failures };
    }
    fn iterated(&mut self, iterations: usize) {
        self.last = iterations as f64;
        self.spent += self.last;
        self.solves += 1.0;
    }
}

/// A factorisation that serves while the matrix changes: its matrix is solved for by GMRES with the old factor as preconditioner,
/// as long as this costs less than factoring; what does not converge is factored and solved with its own factor.
///
/// A factor in double precision solves its own matrix directly. One in single precision, and the scalar factors of the Schur route, precondition GMRES
/// for it as well, to the same tolerance (1e-10 where it is 0); a solve that does not reach it is an error.
pub struct LaggedFactor {
    engine: Engine,
    krylov: Gmres,
    ledger: Ledger,
    /// Relative residual at which iterations stop; 0 factors every matrix.
    tolerance: f64,
    /// What a factorisation costs, in iterations.
    cost: f64,
}

impl LaggedFactor {
    /// Finds the pattern of the factor, as [`Factor::analyse`].
    ///
    /// # Errors
    /// As [`Factor::analyse`].
    pub fn analyse(matrix: &SymmetricMatrix, ordering: Ordering, tolerance: f64) -> Result<LaggedFactor> {
        Ok(LaggedFactor::with(Engine::Whole(Factor::analyse(matrix, ordering)?), tolerance))
    }
    /// Finds the way of solving for a saddle point with these multipliers, by what fits into the memory: directly, with
    /// a factor in single precision, by the Schur route. `saddle` is asked for where the last comes into question.
    ///
    /// # Errors
    /// Computation, if nothing that `solving` allows fits.
    pub fn choose(
        matrix: &SymmetricMatrix,
        multipliers: impl Into<Multipliers>,
        solving: Solving,
        tolerance: f64,
        saddle: impl FnOnce() -> Result<Saddle>,
    ) -> Result<LaggedFactor> {
        Ok(LaggedFactor::with(Engine::choose(matrix, multipliers.into(), solving, saddle)?, tolerance))
    }
    fn with(engine: Engine, tolerance: f64) -> LaggedFactor {
        let cost = engine.size().cost();
        LaggedFactor { engine, krylov: Gmres::default(), ledger: Ledger::default(), tolerance, cost }
    }
    /// The factor of the whole matrix, where there is one.
    pub fn factor(&self) -> Option<&Factor> {
        match &self.engine {
            Engine::Whole(factor) => Some(factor),
            Engine::Schur(_) => None,
        }
    }
    /// The way of solving.
    pub fn way(&self) -> Way {
        self.engine.way()
    }
    /// What the factor, or all factors, take.
    pub fn size(&self) -> FactorSize {
        self.engine.size()
    }
    /// Whether the matrix of the factor is solved for by iterations too, so that a good start pays.
    pub fn always_iterates(&self) -> bool {
        self.way() != Way::Direct
    }
    /// The operators on the multipliers, to be filled before a solve whose matrix has changed; none but on the Schur route.
    pub fn operators_mut(&mut self) -> &mut [SymmetricMatrix] {
        match &mut self.engine {
            Engine::Whole(_) => &mut [],
            Engine::Schur(schur) => schur.operators_mut(),
        }
    }
    /// Whether a matrix that changes from solve to solve may be iterated for.
    pub fn may_iterate(&self) -> bool {
        self.tolerance > 0.0 && self.cost >= LEAST_COST
    }
    /// Makes the next solve factor its matrix.
    pub fn forget(&mut self) {
        self.ledger = Ledger { hold: 1.0, ..Ledger::default() };
    }
    /// What a factorisation costs, in iterations.
    pub fn cost(&self) -> f64 {
        self.cost
    }
    /// Bytes that the factor takes with all working space.
    pub fn bytes(&self) -> usize {
        let most = if self.may_iterate() { self.most_iterations() } else { 0 };
        let vectors = if most > 0 { 2 * most.min(RESTART) + 2 } else { 0 };
        let own = vectors * self.engine.size().unknowns * size_of::<f64>();
        match self.way() {
            Way::Direct => self.factor().map_or(self.engine.size().bytes, Factor::bytes) + own,
            way => self.engine.size().bytes + own.saturating_sub(way.vector_bytes(self.engine.size().unknowns)),
        }
    }
    /// The books.
    pub fn ledger(&self) -> Ledger {
        self.ledger
    }
    /// Makes the factor that an interrupted run had, from its matrix and its books.
    ///
    /// # Errors
    /// As [`Factor::refactor`].
    pub fn restore(&mut self, matrix: &SymmetricMatrix, ledger: Ledger) -> Result<()> {
        self.engine.refactor(matrix)?;
        self.ledger = ledger;
        Ok(())
    }

    /// More iterations with an old factor than the factorisation is worth are not made.
    fn most_iterations(&self) -> usize {
        match self.way() {
            Way::Direct | Way::Single => (self.cost + DIRECT_SOLVE) as usize,
            way @ Way::Schur => self.cost as usize + way.most_iterations(),
        }
    }

    /// Solves `A x = rhs`; `x` holds the start of an iteration.
    ///
    /// # Errors
    /// As [`Factor::refactor`] and [`Factor::solve`]; an iteration with a factor of the matrix itself that does not converge.
    pub fn solve(
        &mut self,
        matrix: &SymmetricMatrix,
        change: Change,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<LaggedReport> {
        if change == Change::None && self.engine.is_valid() {
            return Ok(LaggedReport::direct(self.solve_own(matrix, rhs, x)?, None));
        }
        let try_krylov =
            change == Change::Passing && self.may_iterate() && self.engine.is_valid() && !self.ledger.wants_factor();
        let mut wasted = 0;
        if try_krylov {
            let done = self.iterate(matrix, rhs, x, (self.tolerance, self.most_iterations()));
            if done.converged {
                self.ledger.iterated(done.iterations);
                let solve = SolveReport { residual: done.residual, refinements: 0, iterations: done.iterations };
                return Ok(LaggedReport {
                    solve,
                    refactored: false,
                    given_up: false,
                    substitutions: done.iterations,
                    factoring: 0.0,
                });
            }
            wasted = done.iterations;
        }
        let start = ProcessTime::now();
        self.engine.refactor(matrix)?;
        let factoring = start.elapsed().as_secs_f64();
        let solve = self.solve_own(matrix, rhs, x)?;
        self.ledger.factored(self.cost, DIRECT_SOLVE.max(solve.iterations as f64), wasted);
        let solve = SolveReport { iterations: wasted + solve.iterations, ..solve };
        Ok(LaggedReport { given_up: wasted > 0, ..LaggedReport::direct(solve, Some(factoring)) })
    }

    /// Solves with the factor of this very matrix.
    fn solve_own(&mut self, matrix: &SymmetricMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport> {
        if let (Way::Direct, Engine::Whole(factor)) = (self.way(), &mut self.engine) {
            return factor.solve(matrix, rhs, x);
        }
        require_finite(rhs)?;
        if !x.iter().all(|v| v.is_finite()) {
            x.fill(0.0);
        }
        let tolerance = if self.tolerance > 0.0 { self.tolerance } else { OWN_TOLERANCE };
        let most = self.way().most_iterations();
        let done = self.iterate(matrix, rhs, x, (tolerance, most));
        if done.converged {
            return Ok(SolveReport { residual: done.residual, refinements: 0, iterations: done.iterations });
        }
        Err(Error::computation("the iterations for a linear system did not converge")
            .at(format!("{} unknowns, {}", rhs.len(), self.way()))
            .value(format!(
                "relative residual {:.1e} after {} iterations, asked for {tolerance:e}",
                done.residual, done.iterations
            ))
            .remedy("take a shorter step or a smaller grad-div weight, or a direct solver where the memory suffices")
            .because(Cause::SolverStalled))
    }

    fn iterate(&mut self, matrix: &SymmetricMatrix, rhs: &[f64], x: &mut [f64], limits: (f64, usize)) -> Iterated {
        let engine = &mut self.engine;
        self.krylov.solve(matrix, |v| engine.precondition(matrix, v), rhs, x, limits)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{scattered, stokes};
    use super::*;

    const MASS: f64 = 100.0;

    fn lagged(tolerance: f64) -> LaggedFactor {
        let (matrix, first_pressure) = stokes(16, MASS, 1.0, 0.0);
        let ordering = Ordering::saddle_point(&matrix, first_pressure).unwrap();
        LaggedFactor { cost: 15.0, ..LaggedFactor::analyse(&matrix, ordering, tolerance).unwrap() }
    }

    /// Viscosities that grow by 2 % from solve to solve: the solutions are those of factoring each, to the tolerance, with far fewer
    /// factorisations, and the residual that is reported is the true one.
    #[test]
    fn an_old_factor_solves_a_matrix_that_creeps_away_from_it() {
        let (mut old, mut direct) = (lagged(1e-10), lagged(0.0));
        assert!(old.may_iterate() && !direct.may_iterate());
        let rhs = scattered(old.size().unknowns);
        let (mut x, mut exact) = (vec![0.0; rhs.len()], vec![0.0; rhs.len()]);
        let (mut factored, mut iterations) = (0, 0);
        for k in 0..20 {
            let (matrix, _) = stokes(16, MASS, 1.02f64.powi(k), 0.0);
            let report = old.solve(&matrix, Change::Passing, &rhs, &mut x).unwrap();
            assert!(report.solve.residual <= 1e-10);
            assert!(direct.solve(&matrix, Change::Passing, &rhs, &mut exact).unwrap().refactored);
            let mut r = vec![0.0; rhs.len()];
            matrix.multiply(&x, &mut r);
            let size = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
            r.iter_mut().zip(&rhs).for_each(|(r, b)| *r -= b);
            let scale = size(&rhs);
            assert!((size(&r) / scale - report.solve.residual).abs() < 1e-13, "{k}: {:e}", size(&r) / scale);
            let scale = size(&exact);
            r.iter_mut().zip(x.iter().zip(&exact)).for_each(|(r, (x, e))| *r = x - e);
            assert!(size(&r) / scale < 1e-8, "{k}: {:e}", size(&r) / scale);
            factored += usize::from(report.refactored);
            iterations += report.solve.iterations;
        }
        assert!((1..=10).contains(&factored) && iterations > 20, "{factored} factorisations, {iterations} iterations");
    }

    #[test]
    fn what_does_not_converge_is_factored_and_solved_directly_and_trials_become_rare() {
        let mut lagged = lagged(1e-10);
        let rhs = scattered(lagged.size().unknowns);
        let mut x = vec![0.0; rhs.len()];
        let mut trials = 0;
        for k in 0..12 {
            // Heavy and viscous fluids in turn: the factor of the one is of no use for the other.
            let (matrix, _) = if k % 2 == 0 { stokes(16, 1e4, 1e-2, 0.0) } else { stokes(16, 1.0, 1.0, 0.0) };
            let report = lagged.solve(&matrix, Change::Passing, &rhs, &mut x).unwrap();
            assert!(report.refactored && report.solve.residual < 1e-11, "{report:?}");
            trials += usize::from(report.solve.iterations > 0);
        }
        assert!((2..=4).contains(&trials), "{trials} trials");
    }

    #[test]
    fn a_matrix_that_stays_is_factored_once() {
        let mut lagged = lagged(1e-10);
        let (matrix, _) = stokes(16, MASS, 1.0, 0.0);
        let rhs = scattered(lagged.size().unknowns);
        let mut x = vec![0.0; rhs.len()];
        for change in [Change::Lasting, Change::None, Change::None] {
            let report = lagged.solve(&matrix, change, &rhs, &mut x).unwrap();
            assert_eq!((report.refactored, report.solve.iterations), (change == Change::Lasting, 0));
        }
    }

    /// Solves that cost 1, 2, 3, ... after a factorisation of 8 and its solve of 2: the mean over a period of n solves,
    /// (10 + n (n - 1)/2)/n, is least for n = 4 and 5, both 4.
    #[test]
    fn a_factor_is_renewed_where_the_mean_cost_is_least() {
        let mut ledger = Ledger::default();
        ledger.factored(8.0, 1.0, 0);
        let mut solves = 1;
        while !ledger.wants_factor() {
            ledger.iterated(solves);
            solves += 1;
        }
        assert!((5..=6).contains(&solves), "{solves}");
    }
}
