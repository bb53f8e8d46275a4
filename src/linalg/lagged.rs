//! A lagged factor: it preconditions while the matrix changes, and is renewed when that is cheaper.

use super::direct::require_finite;
use super::engine::{Engine, SolverKind, SolverOptions};
use super::gmres::{Gmres, Iterated, RESTART};
use super::schur::Saddle;
use super::{Factor, FactorSize, Multipliers, Operator, Ordering, SolveReport, SymmetricMatrix};
use crate::base::{Cause, Error, Result};
use cpu_time::ProcessTime;

/// Change of the matrix since the factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The matrix is the factored one.
    None,
    /// The matrix has changed and stays for many solves: it is factored.
    Lasting,
    /// The matrix changes from solve to solve: the cheaper method is taken.
    Passing,
}

/// Report of a solve with [`LaggedFactor`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaggedReport {
    /// Accuracy; `iterations` includes those of abandoned trials, and is 0 after a direct solve.
    pub solve: SolveReport,
    /// True if the matrix was factored.
    pub refactored: bool,
    /// True if iterations with an older factor were abandoned first.
    pub given_up: bool,
    /// Number of substitutions with the factor; each reads it twice.
    pub substitutions: usize,
    /// Processor seconds of the factorisation.
    pub factoring: f64,
}

impl LaggedReport {
    /// Report of a direct solve, after a factorisation that took `factoring` seconds, if any.
    fn direct(solve: SolveReport, factoring: Option<f64>) -> LaggedReport {
        let substitutions = solve.iterations
            + if solve.iterations == 0 || factoring.is_some() { 1 + solve.refinements } else { 0 };
        LaggedReport {
            solve,
            refactored: factoring.is_some(),
            given_up: false,
            substitutions,
            factoring: factoring.unwrap_or_default(),
        }
    }
}

/// Costs that decide between iterations and a factorisation. Only counts enter: the decision is the
/// same in every run of a scene, on any machine and for any number of threads.
///
/// The unit is one iteration. A factorisation costs [`Factor::cost`], and the solve with it one
/// more. After each solve its cost is compared with the mean cost of the solves since the last
/// factorisation, that one included. As soon as it is larger, the mean is minimal and the next
/// solve factors (the optimal replacement rule).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveCost {
    /// Number of solves since the last factorisation, that one included.
    pub solves: f64,
    /// Their total cost.
    pub spent: f64,
    /// Cost of the last solve.
    pub last: f64,
    /// Number of solves that still factor without a trial, after failed trials.
    pub hold: f64,
    /// Number of consecutive periods that saved nothing.
    pub failures: f64,
}

/// Longest series of solves without a trial.
const LONGEST_HOLD: f64 = 64.0;
/// Cost in iterations below which a factorisation is never delayed.
const LEAST_COST: f64 = 3.0;
/// Largest fraction of the cost of factoring in every solve at which a period of iterations counts
/// as a saving.
const WORTHWHILE: f64 = 0.95;
/// Cost of a direct solve, in iterations.
const DIRECT_SOLVE: f64 = 1.0;
/// Default relative residual of iterations with a factor of the matrix itself.
const OWN_TOLERANCE: f64 = 1e-10;

impl SolveCost {
    fn should_factor(&self) -> bool {
        self.hold > 0.0 || self.last * self.solves > self.spent
    }
    /// Starts a period after a factorisation, preceded by `wasted` iterations; its own solve costs
    /// `own`. A period that saved nothing is a failure; the next trials follow 0, 1, 3, 7, ...
    /// further factorisations.
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
        *self = SolveCost { solves: 1.0, spent: direct, last: 0.0, hold, failures: self.failures };
    }
    fn iterated(&mut self, iterations: usize) {
        self.last = iterations as f64;
        self.spent += self.last;
        self.solves += 1.0;
    }
}

/// A factor that is used while the matrix changes: as preconditioner of GMRES, as long as this
/// costs less than factoring. If GMRES does not converge, the matrix is factored and solved
/// directly.
///
/// A factor in double precision solves its own matrix directly. A factor in single precision and
/// the scalar factors of the Schur solver precondition GMRES for it as well, to the same tolerance
/// (1e-10 if it is 0); a solve that does not reach it is an error.
pub struct LaggedFactor {
    engine: Engine,
    krylov: Gmres,
    solve_cost: SolveCost,
    /// Relative residual at which iterations stop; 0 factors every matrix.
    tolerance: f64,
    /// Cost of a factorisation, in iterations.
    cost: f64,
}

impl LaggedFactor {
    /// Finds the pattern of the factor, as [`Factor::analyse`].
    ///
    /// # Errors
    /// As [`Factor::analyse`].
    pub fn analyse(
        matrix: &SymmetricMatrix,
        ordering: Ordering,
        tolerance: f64,
    ) -> Result<LaggedFactor> {
        Ok(LaggedFactor::with(Engine::Whole(Factor::analyse(matrix, ordering)?), tolerance))
    }
    /// Chooses the solver of a saddle point with these multipliers by the available memory: direct,
    /// factor in single precision, or Schur. `saddle` is called only for the last.
    ///
    /// # Errors
    /// Computation, if no solver that `options` allows fits.
    pub fn choose(
        matrix: &SymmetricMatrix,
        multipliers: impl Into<Multipliers>,
        options: SolverOptions,
        tolerance: f64,
        saddle: impl FnOnce() -> Result<Saddle>,
    ) -> Result<LaggedFactor> {
        Ok(LaggedFactor::with(
            Engine::choose(matrix, multipliers.into(), options, saddle)?,
            tolerance,
        ))
    }
    fn with(engine: Engine, tolerance: f64) -> LaggedFactor {
        let cost = engine.size().cost();
        LaggedFactor {
            engine,
            krylov: Gmres::default(),
            solve_cost: SolveCost::default(),
            tolerance,
            cost,
        }
    }
    /// The factor of the whole matrix; `None` for the Schur solver.
    pub fn factor(&self) -> Option<&Factor> {
        match &self.engine {
            Engine::Whole(factor) => Some(factor),
            Engine::Schur(_) => None,
        }
    }
    /// The solver.
    pub fn kind(&self) -> SolverKind {
        self.engine.kind()
    }
    /// Size of the factor, or of all factors.
    pub fn size(&self) -> FactorSize {
        self.engine.size()
    }
    /// True if the matrix of the factor is solved iteratively too, so that a good initial guess
    /// helps.
    pub fn always_iterates(&self) -> bool {
        self.kind() != SolverKind::Direct
    }
    /// The operators on the multipliers, to be filled before a solve with a changed matrix; empty
    /// but for the Schur solver.
    pub fn operators_mut(&mut self) -> &mut [SymmetricMatrix] {
        match &mut self.engine {
            Engine::Whole(_) => &mut [],
            Engine::Schur(schur) => schur.operators_mut(),
        }
    }
    /// True if a matrix that changes from solve to solve may be solved by iterations.
    pub fn may_iterate(&self) -> bool {
        self.tolerance > 0.0 && self.cost >= LEAST_COST
    }
    /// Makes the next solve factor its matrix.
    pub fn invalidate(&mut self) {
        self.solve_cost = SolveCost { hold: 1.0, ..SolveCost::default() };
    }
    /// Cost of a factorisation, in iterations.
    pub fn cost(&self) -> f64 {
        self.cost
    }
    /// Bytes of the factor with all working space.
    pub fn bytes(&self) -> usize {
        let most = if self.may_iterate() { self.most_iterations() } else { 0 };
        let vectors = if most > 0 { 2 * most.min(RESTART) + 2 } else { 0 };
        let own = vectors * self.engine.size().unknowns * size_of::<f64>();
        match self.kind() {
            SolverKind::Direct => {
                self.factor().map_or(self.engine.size().bytes, Factor::bytes) + own
            }
            kind => {
                self.engine.size().bytes
                    + own.saturating_sub(kind.vector_bytes(self.engine.size().unknowns))
            }
        }
    }
    /// Costs since the last factorisation.
    pub fn solve_cost(&self) -> SolveCost {
        self.solve_cost
    }
    /// Computes the factor of an interrupted run again, from its matrix and its costs.
    ///
    /// # Errors
    /// As [`Factor::refactor`].
    pub fn restore<'a>(
        &mut self,
        operator: impl Into<Operator<'a>>,
        solve_cost: SolveCost,
    ) -> Result<()> {
        self.engine.refactor(&operator.into())?;
        self.solve_cost = solve_cost;
        Ok(())
    }

    /// Largest number of iterations with an old factor: no more than a factorisation costs.
    fn most_iterations(&self) -> usize {
        match self.kind() {
            SolverKind::Direct | SolverKind::Lu | SolverKind::Single => {
                (self.cost + DIRECT_SOLVE) as usize
            }
            kind @ SolverKind::Schur => self.cost as usize + kind.most_iterations(),
        }
    }

    /// Solves `A x = rhs`; `x` holds the initial guess.
    ///
    /// # Errors
    /// Those of [`Factor::refactor`] and [`Factor::solve`]; no convergence of iterations with a
    /// factor of the matrix itself.
    pub fn solve<'a>(
        &mut self,
        operator: impl Into<Operator<'a>>,
        change: Change,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<LaggedReport> {
        let operator = &mut operator.into();
        if change == Change::None && self.engine.is_valid() {
            return Ok(LaggedReport::direct(self.solve_own(operator, rhs, x)?, None));
        }
        let try_krylov = change == Change::Passing
            && self.may_iterate()
            && self.engine.is_valid()
            && !self.solve_cost.should_factor();
        let mut wasted = 0;
        if try_krylov {
            let done = self.iterate(operator, rhs, x, (self.tolerance, self.most_iterations()));
            if done.converged {
                self.solve_cost.iterated(done.iterations);
                let solve = SolveReport {
                    residual: done.residual,
                    refinements: 0,
                    iterations: done.iterations,
                };
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
        self.engine.refactor(operator)?;
        let factoring = start.elapsed().as_secs_f64();
        let solve = self.solve_own(operator, rhs, x)?;
        self.solve_cost.factored(self.cost, DIRECT_SOLVE.max(solve.iterations as f64), wasted);
        let solve = SolveReport { iterations: wasted + solve.iterations, ..solve };
        Ok(LaggedReport { given_up: wasted > 0, ..LaggedReport::direct(solve, Some(factoring)) })
    }

    /// Solves with the factor of the operator itself.
    fn solve_own(
        &mut self,
        operator: &mut Operator<'_>,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<SolveReport> {
        if let (SolverKind::Direct, Engine::Whole(factor)) = (self.kind(), &mut self.engine)
            && operator.addition.is_none()
        {
            return factor.solve(operator.matrix, rhs, x);
        }
        require_finite(rhs)?;
        if !x.iter().all(|v| v.is_finite()) {
            x.fill(0.0);
        }
        let tolerance = match self.kind() {
            // Its iterations are few.
            SolverKind::Lu => self.tolerance.min(OWN_TOLERANCE),
            _ => self.tolerance,
        };
        let tolerance = if tolerance > 0.0 { tolerance } else { OWN_TOLERANCE };
        let most = self.kind().most_iterations();
        let done = self.iterate(operator, rhs, x, (tolerance, most));
        if done.converged {
            return Ok(SolveReport {
                residual: done.residual,
                refinements: 0,
                iterations: done.iterations,
            });
        }
        Err(Error::computation("the iterations for a linear system did not converge")
            .at(format!("{} unknowns, {}", rhs.len(), self.kind()))
            .value(format!(
                "relative residual {:.1e} after {} iterations, asked for {tolerance:e}",
                done.residual, done.iterations
            ))
            .remedy(
                "take a shorter step or a smaller grad-div weight, or a direct solver where the \
                 memory suffices",
            )
            .because(Cause::SolverStalled))
    }

    fn iterate(
        &mut self,
        operator: &mut Operator<'_>,
        rhs: &[f64],
        x: &mut [f64],
        limits: (f64, usize),
    ) -> Iterated {
        let (engine, matrix) = (&mut self.engine, operator.matrix);
        self.krylov.solve(operator, |v| engine.precondition(matrix, v), rhs, x, limits)
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

    /// Viscosities that grow by 2 % from solve to solve: the solutions are those of factoring each,
    /// to the tolerance, with far fewer factorisations, and the residual that is reported is the
    /// true one.
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
            assert!(
                (size(&r) / scale - report.solve.residual).abs() < 1e-13,
                "{k}: {:e}",
                size(&r) / scale
            );
            let scale = size(&exact);
            r.iter_mut().zip(x.iter().zip(&exact)).for_each(|(r, (x, e))| *r = x - e);
            assert!(size(&r) / scale < 1e-8, "{k}: {:e}", size(&r) / scale);
            factored += usize::from(report.refactored);
            iterations += report.solve.iterations;
        }
        assert!(
            (1..=10).contains(&factored) && iterations > 20,
            "{factored} factorisations, {iterations} iterations"
        );
    }

    #[test]
    fn what_does_not_converge_is_factored_and_solved_directly_and_trials_become_rare() {
        let mut lagged = lagged(1e-10);
        let rhs = scattered(lagged.size().unknowns);
        let mut x = vec![0.0; rhs.len()];
        let mut trials = 0;
        for k in 0..12 {
            // Heavy and viscous fluids in turn: the factor of the one is of no use for the other.
            let (matrix, _) =
                if k % 2 == 0 { stokes(16, 1e4, 1e-2, 0.0) } else { stokes(16, 1.0, 1.0, 0.0) };
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
            assert_eq!(
                (report.refactored, report.solve.iterations),
                (change == Change::Lasting, 0)
            );
        }
    }

    /// Solves that cost 1, 2, 3, ... after a factorisation of 8 and its solve of 2: the mean over a
    /// period of n solves, (10 + n (n - 1)/2)/n, is least for n = 4 and 5, both 4.
    #[test]
    fn a_factor_is_renewed_where_the_mean_cost_is_least() {
        let mut solve_cost = SolveCost::default();
        solve_cost.factored(8.0, 1.0, 0);
        let mut solves = 1;
        while !solve_cost.should_factor() {
            solve_cost.iterated(solves);
            solves += 1;
        }
        assert!((5..=6).contains(&solves), "{solves}");
    }
}
