//! The direct solver: supernodal LDL^T without pivoting and iterative refinement. The only module that names faer.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use super::memory::{available, readable};
use super::{Ordering, SymmetricMatrix};
use crate::base::{Error, Result};

/// Relative residual above which a solution is refused.
const TOLERANCE: f64 = 1e-9;
const MOST_REFINEMENTS: usize = 3;

/// How well a linear system was solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// `|b - A x| / |b|` in the 2-norm after the last refinement; of several right-hand sides the largest.
    pub residual: f64,
    /// Number of steps of iterative refinement, at least one.
    pub refinements: usize,
}

/// The factorisation `P A P^T = L D L^T` of a symmetric matrix that needs no pivoting: positive definite, or a saddle
/// point in the order of [`Ordering::saddle_point`].
///
/// Sequential, so that results do not depend on the number of threads.
pub struct Factor {
    symbolic: SymbolicCholesky<usize>,
    pattern: u64,
    /// Empty before the first numeric factorisation.
    values: Vec<f64>,
    is_valid: bool,
    scratch: MemBuffer,
    scratch_bytes: usize,
    residual: Vec<f64>,
}

impl Factor {
    /// Finds the pattern of the factor, and with it its size; allocates only what this takes.
    ///
    /// # Errors
    /// Computation, if the factor would not fit into the memory that the machine can give at the moment; internal, if
    /// the ordering is not one of this matrix.
    pub fn analyse(matrix: &SymmetricMatrix, ordering: Ordering) -> Result<Factor> {
        Factor::analyse_within(matrix, ordering, available())
    }

    /// [`analyse`](Factor::analyse) with a limit on the bytes that the factor may take, `None` for no limit.
    ///
    /// # Errors
    /// As [`analyse`](Factor::analyse).
    pub fn analyse_within(matrix: &SymmetricMatrix, ordering: Ordering, limit: Option<usize>) -> Result<Factor> {
        let symbolic = symbolic_factor(matrix, &ordering)?;
        let numeric = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let request = numeric.or(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        let mut factor = Factor {
            symbolic,
            pattern: matrix.pattern(),
            values: Vec::new(),
            is_valid: false,
            scratch: MemBuffer::new(StackReq::EMPTY),
            scratch_bytes: request.unaligned_bytes_required(),
            residual: vec![0.0; matrix.order()],
        };
        if limit.is_some_and(|limit| factor.bytes() > limit) {
            return Err(factor.too_large(limit));
        }
        factor.scratch = MemBuffer::try_new(request).map_err(|_| factor.too_large(limit))?;
        Ok(factor)
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.symbolic.nrows()
    }

    /// Number of stored entries of the factor.
    pub fn nonzeros(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Bytes that the factor takes with its working space, all of them after the first [`refactor`](Factor::refactor).
    pub fn bytes(&self) -> usize {
        8 * self.nonzeros() + self.scratch_bytes
    }

    /// Factorises the matrix, whose values may have changed but not its pattern. Allocates at the first call only.
    ///
    /// # Errors
    /// Computation, if an entry is not finite, if a pivot is zero, or if the memory does not suffice; internal, if the
    /// pattern is another one.
    pub fn refactor(&mut self, matrix: &SymmetricMatrix) -> Result<()> {
        self.is_valid = false;
        self.require_pattern_of(matrix)?;
        if let Some(k) = matrix.values().iter().position(|v| !v.is_finite()) {
            return Err(not_finite("an entry of the matrix", matrix.values()[k], column_of_entry(matrix, k)));
        }
        if self.values.is_empty() {
            let length = self.nonzeros();
            self.values.try_reserve_exact(length).map_err(|_| self.too_large(None))?;
            self.values.resize(length, 0.0);
        }
        let factored = self.symbolic.factorize_numeric_ldlt(
            &mut self.values,
            SparseColMatRef::new(view_of_pattern(matrix, matrix.upper().indptr().raw_storage()), matrix.values()),
            Side::Upper,
            LdltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Default::default(),
        );
        if let Err(LdltError::ZeroPivot { index }) = factored {
            return Err(self.zero_pivot(index));
        }
        self.is_valid = true;
        Ok(())
    }

    /// Solves `A x = rhs` for one right-hand side or for several, one after another in `rhs` and `x`.
    ///
    /// At least one step of iterative refinement, and up to three until `|b - A x| <= 1e-9 |b|`. Allocates only when
    /// there are more right-hand sides than ever before.
    ///
    /// # Errors
    /// Computation, if the right-hand side is not finite or the residual stays above 1e-9; internal, if there is no
    /// valid factor, the pattern is another one, or the lengths are wrong.
    pub fn solve(&mut self, matrix: &SymmetricMatrix, rhs: &[f64], x: &mut [f64]) -> Result<SolveReport> {
        self.require_pattern_of(matrix)?;
        let n = self.order();
        if !self.is_valid || rhs.len() != x.len() || n == 0 || rhs.len() % n != 0 {
            return Err(Error::internal("a linear solve is called wrongly").value(format!(
                "factor valid: {}, order {n}, right-hand side {}, solution {}",
                self.is_valid,
                rhs.len(),
                x.len()
            )));
        }
        if let Some(k) = rhs.iter().position(|v| !v.is_finite()) {
            return Err(not_finite("the right-hand side", rhs[k], k % n));
        }
        self.require_space(rhs.len())?;
        x.copy_from_slice(rhs);
        self.substitute(x);
        let mut refinements = 0;
        let mut residual = self.update_residual(matrix, rhs, x);
        while refinements == 0 || (refinements < MOST_REFINEMENTS && !(residual <= TOLERANCE)) {
            let mut correction = std::mem::take(&mut self.residual);
            self.substitute(&mut correction[..rhs.len()]);
            x.iter_mut().zip(&correction).for_each(|(x, d)| *x += d);
            self.residual = correction;
            refinements += 1;
            residual = self.update_residual(matrix, rhs, x);
        }
        if residual <= TOLERANCE { Ok(SolveReport { residual, refinements }) } else { Err(self.inaccurate(residual)) }
    }

    /// Replaces each right-hand side in `x` by its solution, without refinement.
    fn substitute(&mut self, x: &mut [f64]) {
        let n = self.order();
        let columns = x.len() / n;
        LdltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(x, n, columns),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
    }

    /// Sets the residuals `b - A x` and returns the largest relative one.
    fn update_residual(&mut self, matrix: &SymmetricMatrix, rhs: &[f64], x: &[f64]) -> f64 {
        let n = self.order();
        let mut largest = 0.0_f64;
        for ((b, x), r) in rhs.chunks_exact(n).zip(x.chunks_exact(n)).zip(self.residual.chunks_exact_mut(n)) {
            matrix.multiply(x, r);
            r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
            let (error, scale) = (norm(r), norm(b));
            let relative = if error == 0.0 { 0.0 } else { error / scale };
            // `f64::max` would drop a NaN.
            largest = if relative <= largest { largest } else { relative };
        }
        largest
    }

    fn require_space(&mut self, length: usize) -> Result<()> {
        if self.residual.len() < length {
            let columns = length / self.order();
            let request = self.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq);
            let bytes = request.unaligned_bytes_required();
            if bytes > self.scratch_bytes {
                self.scratch = MemBuffer::try_new(request).map_err(|_| self.too_large(None))?;
                self.scratch_bytes = bytes;
            }
            self.residual.resize(length, 0.0);
        }
        Ok(())
    }

    fn require_pattern_of(&self, matrix: &SymmetricMatrix) -> Result<()> {
        if self.pattern == matrix.pattern() {
            return Ok(());
        }
        Err(Error::internal("a factor is used with a matrix of another pattern than the one it was made for")
            .value(format!("{} unknowns, factor of {}", matrix.order(), self.order())))
    }

    fn too_large(&self, limit: Option<usize>) -> Error {
        let free = limit.map_or(String::new(), |limit| format!(", {} are free", readable(limit)));
        Error::computation("the factor of a matrix does not fit into the memory")
            .at(format!("{} unknowns, {} entries in the factor", self.order(), self.nonzeros()))
            .value(format!("{} are needed{free}", readable(self.bytes())))
            .remedy("use a coarser mesh, close other programs, or use a machine with more memory")
    }

    fn zero_pivot(&self, position: usize) -> Error {
        let unknown = self.symbolic.perm().and_then(|p| p.arrays().0.get(position).copied()).unwrap_or(position);
        Error::computation("a matrix is singular: elimination met a pivot that is zero or not finite")
            .at(format!("unknown {unknown} of {}", self.order()))
            .remedy("check the boundary conditions (is every field fixed somewhere?) and the coefficients")
    }

    fn inaccurate(&self, residual: f64) -> Error {
        Error::computation("a linear system could not be solved accurately")
            .at(format!("{} unknowns", self.order()))
            .value(format!("relative residual {residual:.1e} after {MOST_REFINEMENTS} refinements, allowed {TOLERANCE:e}"))
            .remedy("the matrix is nearly singular: check boundary conditions, mesh quality and coefficients of very different size")
    }
}

fn symbolic_factor(matrix: &SymmetricMatrix, ordering: &Ordering) -> Result<SymbolicCholesky<usize>> {
    let n = matrix.order();
    if ordering.unknowns().len() != n {
        let sizes = format!("{} unknowns, ordering of {}", n, ordering.unknowns().len());
        return Err(Error::internal("an ordering does not belong to the matrix").value(sizes));
    }
    let pointers = matrix.upper().indptr();
    let permutation = faer::perm::PermRef::new_checked(ordering.unknowns(), ordering.positions(), n);
    let params = CholeskySymbolicParams {
        // Faster than the simplicial method from a few hundred unknowns on.
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    let pattern = view_of_pattern(matrix, pointers.raw_storage());
    factorize_symbolic_cholesky(pattern, Side::Upper, SymmetricOrdering::Custom(permutation), params).map_err(|error| {
        Error::computation("the factor of a matrix could not be planned")
            .at(format!("{n} unknowns, {} entries", matrix.nonzeros()))
            .value(error)
            .remedy("use a coarser mesh or a machine with more memory")
    })
}

fn view_of_pattern<'a>(matrix: &'a SymmetricMatrix, pointers: &'a [usize]) -> SymbolicSparseColMatRef<'a, usize> {
    let n = matrix.order();
    SymbolicSparseColMatRef::new_checked(n, n, pointers, None, matrix.upper().indices())
}

fn not_finite(what: &str, value: f64, unknown: usize) -> Error {
    Error::computation(format!("{what} of a linear system is not a finite number"))
        .at(format!("unknown {unknown}"))
        .value(value)
        .remedy("the computation has blown up before: use a smaller time step, or check expressions and coefficients")
}

fn column_of_entry(matrix: &SymmetricMatrix, entry: usize) -> usize {
    matrix.upper().indptr().raw_storage().partition_point(|&start| start <= entry).saturating_sub(1)
}

/// The 2-norm, without overflow for large entries.
fn norm(v: &[f64]) -> f64 {
    let largest = v.iter().fold(0.0_f64, |m, a| if a.abs() <= m { m } else { a.abs() });
    if largest == 0.0 { 0.0 } else { largest * v.iter().map(|a| (a / largest).powi(2)).sum::<f64>().sqrt() }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::testing::{laplacian, scattered, stokes};
    use super::*;
    use crate::base::Kind;

    fn factored(matrix: &SymmetricMatrix, ordering: Ordering) -> Factor {
        let mut factor = Factor::analyse(matrix, ordering).unwrap();
        factor.refactor(matrix).unwrap();
        factor
    }

    /// The relative residual of the bare substitution, and the report of the refined solution.
    fn residuals(matrix: &SymmetricMatrix, factor: &mut Factor) -> (f64, SolveReport) {
        let exact = scattered(matrix.order());
        let mut b = vec![0.0; matrix.order()];
        matrix.multiply(&exact, &mut b);
        let mut x = b.clone();
        factor.substitute(&mut x);
        let bare = factor.update_residual(matrix, &b, &x);
        (bare, factor.solve(matrix, &b, &mut x).unwrap())
    }

    #[test]
    fn the_laplacian_is_solved_to_rounding() {
        for n in [1, 2, 3, 30] {
            let a = laplacian(n, 0.0);
            let mut factor = factored(&a, Ordering::plain(&a).unwrap());
            let (bare, report) = residuals(&a, &mut factor);
            assert!(bare < 1e-13, "{n}: {bare:e}");
            assert!(report.residual < 1e-14 && report.refinements == 1, "{n}: {report:?}");
        }
    }

    #[test]
    fn the_solution_is_the_discrete_eigenfunction() {
        // The five-point Laplacian of sin(pi i h) sin(pi j h), h = 1 / (n + 1), is 8 sin^2(pi h / 2) times itself.
        let n = 25;
        let h = std::f64::consts::PI / (n as f64 + 1.0);
        let mode: Vec<f64> =
            (0..n * n).map(|k| ((k % n + 1) as f64 * h).sin() * ((k / n + 1) as f64 * h).sin()).collect();
        let a = laplacian(n, 0.0);
        let mut x = vec![0.0; n * n];
        factored(&a, Ordering::plain(&a).unwrap()).solve(&a, &mode, &mut x).unwrap();
        let eigenvalue = 8.0 * (0.5 * h).sin().powi(2);
        assert!(x.iter().zip(&mode).all(|(x, m)| (x * eigenvalue - m).abs() < 1e-13));
    }

    #[test]
    fn saddle_points_need_no_refinement_in_their_own_ordering() {
        for (mass, viscosity) in [(200.0, 0.01), (0.0, 1.0), (1e4, 1e-5)] {
            for penalty in [1e-6, 1e-10, 1e-14, 0.0] {
                let (a, first) = stokes(24, mass, viscosity, penalty);
                let mut factor = factored(&a, Ordering::saddle_point(&a, first).unwrap());
                let (bare, report) = residuals(&a, &mut factor);
                assert!(bare < 1e-13, "mass {mass}, viscosity {viscosity}, penalty {penalty:e}: {bare:e}");
                assert!(report.residual < 1e-13 && report.refinements == 1, "{report:?}");
            }
        }
    }

    #[test]
    fn a_saddle_point_in_a_plain_ordering_loses_digits_and_refinement_brings_them_back() {
        let (a, _) = stokes(24, 200.0, 0.01, 1e-10);
        let mut factor = factored(&a, Ordering::plain(&a).unwrap());
        let (bare, report) = residuals(&a, &mut factor);
        assert!(bare > 1e-12, "the test shows nothing: {bare:e}");
        assert!(report.residual < 1e-10, "{report:?}");
    }

    #[test]
    fn a_new_factorisation_of_the_same_values_has_the_same_bits() {
        let (a, first) = stokes(10, 1.0, 0.1, 1e-10);
        let mut factor = factored(&a, Ordering::saddle_point(&a, first).unwrap());
        let bits = |factor: &Factor| factor.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let before = bits(&factor);
        let mut other = a.clone();
        other.values_mut().iter_mut().for_each(|v| *v *= 1.5);
        factor.refactor(&other).unwrap();
        assert_ne!(bits(&factor), before);
        factor.refactor(&a).unwrap();
        assert_eq!(bits(&factor), before);
        assert_eq!(bits(&factored(&a, Ordering::saddle_point(&a, first).unwrap())), before);
    }

    #[test]
    fn several_right_hand_sides_are_solved_at_once() {
        let a = laplacian(12, 0.5);
        let n = a.order();
        let mut factor = factored(&a, Ordering::plain(&a).unwrap());
        let rhs = scattered(3 * n);
        let mut together = vec![0.0; 3 * n];
        let report = factor.solve(&a, &rhs, &mut together).unwrap();
        assert!(report.residual < 1e-14);
        for k in 0..3 {
            let mut alone = vec![0.0; n];
            factor.solve(&a, &rhs[k * n..(k + 1) * n], &mut alone).unwrap();
            assert!(alone.iter().zip(&together[k * n..]).all(|(x, y)| (x - y).abs() < 1e-13));
        }
        let mut x = vec![1.0; n];
        let report = factor.solve(&a, &vec![0.0; n], &mut x).unwrap();
        assert_eq!((report.residual, x), (0.0, vec![0.0; n]));
    }

    #[test]
    fn a_slightly_stale_factor_still_solves_and_a_wrong_one_is_refused() {
        let a = laplacian(10, 1.0);
        let mut factor = factored(&a, Ordering::plain(&a).unwrap());
        let rhs = scattered(100);
        let mut x = vec![0.0; 100];
        let report = factor.solve(&laplacian(10, 1.0 + 1e-3), &rhs, &mut x).unwrap();
        assert!(report.refinements > 1 && report.residual <= TOLERANCE, "{report:?}");
        let error = factor.solve(&laplacian(10, 3.0), &rhs, &mut x).unwrap_err();
        assert_eq!(error.kind(), Kind::Computation);
        for part in ["100 unknowns", "relative residual", "remedy"] {
            assert!(error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn wrong_patterns_and_lengths_are_errors() {
        let (a, b) = (laplacian(5, 1.0), laplacian(6, 1.0));
        let ordering = Ordering::plain(&a).unwrap();
        assert!(Factor::analyse(&b, ordering.clone()).is_err());
        let mut factor = Factor::analyse(&a, ordering).unwrap();
        let mut x = vec![0.0; 25];
        assert_eq!(factor.solve(&a, &[1.0; 25], &mut x).unwrap_err().kind(), Kind::Internal, "not factorised");
        assert_eq!(factor.refactor(&b).unwrap_err().kind(), Kind::Internal);
        factor.refactor(&a).unwrap();
        assert!(factor.solve(&b, &[1.0; 25], &mut x).is_err());
        assert!(factor.solve(&a, &[1.0; 24], &mut x[..24]).is_err());
        assert!(factor.solve(&a, &[1.0; 50], &mut x).is_err());
    }

    #[test]
    fn what_is_not_finite_or_singular_is_an_error() {
        let a = laplacian(5, 1.0);
        let mut factor = factored(&a, Ordering::plain(&a).unwrap());
        let mut x = vec![0.0; 25];
        let mut rhs = vec![1.0; 25];
        rhs[7] = f64::NAN;
        assert_eq!(factor.solve(&a, &rhs, &mut x).unwrap_err().place(), "unknown 7");
        let mut broken = a.clone();
        broken.add_group(&[9], &[f64::INFINITY]).unwrap();
        let error = factor.refactor(&broken).unwrap_err();
        assert_eq!((error.kind(), error.place()), (Kind::Computation, "unknown 9"));
        assert!(factor.solve(&a, &[1.0; 25], &mut x).is_err(), "the factor is no longer valid");
        let mut singular = a.clone();
        singular.zero();
        let error = factor.refactor(&singular).unwrap_err();
        assert!(error.what().contains("singular"), "{error}");
        factor.refactor(&a).unwrap();
        assert!(factor.solve(&a, &[1.0; 25], &mut x).is_ok());
    }

    #[test]
    fn a_factor_that_does_not_fit_is_refused_with_its_size() {
        let a = laplacian(30, 0.0);
        let ordering = Ordering::plain(&a).unwrap();
        let bytes = Factor::analyse_within(&a, ordering.clone(), None).unwrap().bytes();
        assert!(bytes > 8 * 900 && bytes < 1_000_000, "{bytes}");
        assert!(Factor::analyse_within(&a, ordering.clone(), Some(bytes)).is_ok());
        let error = Factor::analyse_within(&a, ordering, Some(bytes - 1)).err().unwrap();
        assert_eq!(error.kind(), Kind::Computation);
        for part in ["900 unknowns", "kB are needed", "remedy"] {
            assert!(error.to_string().contains(part), "{error}");
        }
    }

    #[test]
    fn norms_of_large_vectors_do_not_overflow() {
        assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
        assert_eq!(norm(&[]), 0.0);
        assert!(norm(&[1.0, f64::NAN]).is_nan());
    }

    /// A random `[A, B^T; B, -C]` with `A` and `C` diagonally dominant, and the number of rows of `A`.
    fn quasi_definite() -> impl Strategy<Value = (SymmetricMatrix, usize)> {
        (1_usize..60, 0_usize..40).prop_flat_map(|(m, k)| {
            let n = m + k;
            let links = proptest::collection::vec((0..n as u32, 0..n as u32, -1.0..1.0), 0..4 * n);
            links.prop_map(move |links| {
                let groups = || links.iter().map(|&(i, j, _)| [i, j]);
                let mut a = SymmetricMatrix::from_groups(n, groups()).unwrap();
                for &(i, j, v) in links.iter().filter(|&&(i, j, _)| i != j) {
                    // Inside a diagonal block, keep the dominance; across blocks anything goes.
                    let sign = |i: u32| if (i as usize) < m { 1.0 } else { -1.0 };
                    let d: f64 = if sign(i) == sign(j) { v } else { 0.0 };
                    a.add_group(&[i, j], &[sign(i) * d.abs(), v, v, sign(j) * d.abs()]).unwrap();
                }
                for i in 0..n {
                    a.add_group(&[i as u32], &[if i < m { 1.0 } else { -0.1 }]).unwrap();
                }
                (a, m)
            })
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn quasi_definite_matrices_are_solved_in_any_ordering((a, first) in quasi_definite()) {
            for ordering in [Ordering::plain(&a).unwrap(), Ordering::saddle_point(&a, first).unwrap()] {
                let (bare, report) = residuals(&a, &mut factored(&a, ordering));
                prop_assert!(bare < 1e-11, "{bare:e}");
                prop_assert!(report.residual < 1e-13, "{report:?}");
            }
        }
    }
}
