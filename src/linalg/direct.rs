//! The direct solver: supernodal LDL^T without pivoting, with iterative refinement. Only this
//! module and the orderings use faer.

use faer::Par;
use faer::dyn_stack::{MemBuffer, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltError;
use faer::sparse::linalg::cholesky::{SymbolicCholesky, SymbolicCholeskyRaw};

use super::single::Single;
use super::size::{FactorSize, Precision};
use super::substitution::Supernodes;
use super::{Addition, Ordering, SymmetricMatrix};
use crate::base::{Error, Result, available_memory, readable_bytes};

mod kernel;
mod lu;

use kernel::{numeric, supernodes, symbolic_factor, view_of_pattern};
use lu::Lu;

/// Relative residual above which a solution is refused.
const TOLERANCE: f64 = 1e-9;
/// Relative residual above which a solution is refined: plain substitution reaches 3e-16 in a good
/// order.
const REFINED: f64 = 1e-13;
const MOST_REFINEMENTS: usize = 3;

/// Accuracy and cost of a linear solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveReport {
    /// `|b - A x| / |b|` in the 2-norm after the last refinement; the largest over all right-hand
    /// sides.
    pub residual: f64,
    /// Number of steps of iterative refinement; 0 if the substitution was accurate, and after an
    /// iterative solve.
    pub refinements: usize,
    /// Number of Krylov iterations; 0 for a direct solve.
    pub iterations: usize,
}

/// The values of a factor; none before the first numeric factorisation.
enum Values {
    Double(Vec<f64>),
    Single(Single),
    Unsymmetric(Box<Lu>),
}

/// The factorisation `P A P^T = L D L^T` of a symmetric matrix that needs no pivoting: positive
/// definite, or a saddle point in the order of [`Ordering::saddle_point`]. With a part that is not
/// symmetric it is `L D U` on the same pattern, in single precision.
///
/// Sequential, so that results do not depend on the number of threads.
pub struct Factor {
    symbolic: SymbolicCholesky<usize>,
    supernodes: Supernodes,
    pattern: u64,
    values: Values,
    is_valid: bool,
    scratch: MemBuffer,
    matrix_entries: usize,
    residual: Vec<f64>,
    /// A right-hand side or solution in the order of elimination.
    permuted: Vec<f64>,
}

impl Factor {
    /// Symbolic factorisation: computes the pattern of the factor, and with it its size; allocates
    /// only what this takes.
    ///
    /// # Errors
    /// Computation, if the factor does not fit into the available memory; internal, if the ordering
    /// does not belong to the matrix.
    pub fn analyse(matrix: &SymmetricMatrix, ordering: Ordering) -> Result<Factor> {
        Factor::analyse_within(matrix, ordering, available_memory())
    }

    /// [`analyse`](Factor::analyse) with a limit on the bytes that the factor may take, `None` for
    /// no limit.
    ///
    /// # Errors
    /// As [`analyse`](Factor::analyse).
    pub fn analyse_within(
        matrix: &SymmetricMatrix,
        ordering: Ordering,
        limit: Option<usize>,
    ) -> Result<Factor> {
        let factor = Factor::plan(matrix, ordering)?;
        match limit {
            Some(limit) if factor.bytes() > limit => Err(factor.too_large(Some(limit))),
            _ => Ok(factor),
        }
    }

    /// [`analyse`](Factor::analyse) without a limit: computes the size of the factor and allocates
    /// no memory for it.
    ///
    /// # Errors
    /// Internal, if the ordering does not belong to the matrix.
    pub fn plan(matrix: &SymmetricMatrix, ordering: Ordering) -> Result<Factor> {
        let symbolic = symbolic_factor(matrix, &ordering)?;
        Ok(Factor {
            supernodes: supernodes(&symbolic)?,
            symbolic,
            pattern: matrix.pattern(),
            values: Values::Double(Vec::new()),
            is_valid: false,
            scratch: MemBuffer::new(StackReq::EMPTY),
            matrix_entries: matrix.nonzeros(),
            residual: vec![0.0; matrix.order()],
            permuted: vec![0.0; matrix.order()],
        })
    }

    /// The same factor in another precision, without values.
    pub fn with_precision(self, precision: Precision) -> Factor {
        let values = match precision {
            Precision::Double => Values::Double(Vec::new()),
            Precision::Single => Values::Single(Single::default()),
        };
        Factor { values, is_valid: false, scratch: MemBuffer::new(StackReq::EMPTY), ..self }
    }

    /// The factor `L D U`, for matrices with a part that is not symmetric, without values.
    pub fn unsymmetric(self) -> Factor {
        let values = Values::Unsymmetric(Box::default());
        Factor { values, is_valid: false, scratch: MemBuffer::new(StackReq::EMPTY), ..self }
    }

    /// True for a factor `L D U`.
    pub fn is_unsymmetric(&self) -> bool {
        matches!(self.values, Values::Unsymmetric(_))
    }

    /// The precision of the factor.
    pub fn precision(&self) -> Precision {
        match self.values {
            Values::Double(_) => Precision::Double,
            Values::Single(_) | Values::Unsymmetric(_) => Precision::Single,
        }
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.symbolic.nrows()
    }

    /// Number of stored entries of the factor.
    pub fn nonzeros(&self) -> usize {
        self.symbolic.len_val()
    }

    /// True if the factor has values.
    pub(super) fn is_valid(&self) -> bool {
        self.is_valid
    }

    /// Operations of a numeric factorisation: the sum over the columns of the square of their
    /// lengths.
    pub fn operations(&self) -> f64 {
        let SymbolicCholeskyRaw::Supernodal(parts) = self.symbolic.raw() else { return 0.0 };
        let columns = parts.supernode_begin().iter().zip(parts.supernode_end());
        let lengths = columns.zip(parts.col_ptr_for_row_idx().windows(2));
        let squares = |((begin, end), rows): ((&usize, &usize), &[usize])| {
            let below = rows[1] - rows[0];
            (1..=end - begin).map(|k| ((k + below) as f64).powi(2)).sum::<f64>()
        };
        lengths.map(squares).sum()
    }

    /// Size of the factor, and an estimate of the time of a factorisation.
    pub fn size(&self) -> FactorSize {
        // L and U are each read once, L of a symmetric factor twice.
        let halves = if self.is_unsymmetric() { 2 } else { 1 };
        FactorSize {
            unknowns: self.order(),
            entries: halves * self.nonzeros(),
            read: self.nonzeros(),
            operations: halves as f64 * self.operations(),
            bytes: self.bytes(),
            precision: self.precision(),
        }
    }

    /// Cost of a numeric factorisation in iterations preconditioned by this factor: see
    /// [`FactorSize::cost`].
    pub fn cost(&self) -> f64 {
        self.size().cost()
    }

    /// Bytes of the factor with its working space; allocated at the first
    /// [`refactor`](Self::refactor).
    pub fn bytes(&self) -> usize {
        let (order, entries, nonzeros) = (self.order(), self.matrix_entries, self.nonzeros());
        let values = match self.values {
            Values::Double(_) => size_of::<f64>() * nonzeros,
            Values::Single(_) => size_of::<f32>() * nonzeros + Single::extra_bytes(order, entries),
            Values::Unsymmetric(_) => Lu::bytes(nonzeros, [order, entries]),
        };
        values + self.supernodes.bytes() + self.scratch_request().unaligned_bytes_required()
    }

    fn scratch_request(&self) -> StackReq {
        let symbolic = &self.symbolic;
        match self.values {
            Values::Double(_) => {
                symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default())
            }
            Values::Single(_) => {
                symbolic.factorize_numeric_ldlt_scratch::<f32>(Par::Seq, Default::default())
            }
            Values::Unsymmetric(_) => StackReq::EMPTY,
        }
    }

    /// Numeric factorisation of a matrix with the same pattern. Allocates at the first call only.
    ///
    /// # Errors
    /// Computation, if an entry is not finite, a pivot is zero, or the memory does not suffice;
    /// internal, if the pattern differs.
    pub fn refactor(&mut self, matrix: &SymmetricMatrix) -> Result<()> {
        self.refactor_with(matrix, None)
    }

    /// [`refactor`](Self::refactor) of a matrix with an addition, which only a factor `L D U`
    /// takes into account; other factors are those of the matrix.
    ///
    /// # Errors
    /// As [`refactor`](Self::refactor).
    pub fn refactor_with(
        &mut self,
        matrix: &SymmetricMatrix,
        addition: Option<&dyn Addition>,
    ) -> Result<()> {
        self.is_valid = false;
        self.require_pattern_of(matrix)?;
        if let Some(k) = matrix.values().iter().position(|v| !v.is_finite()) {
            return Err(not_finite(
                "an entry of the matrix",
                matrix.values()[k],
                column_of_entry(matrix, k),
            ));
        }
        self.reserve()?;
        let pointers = matrix.upper().indptr();
        let pattern = view_of_pattern(matrix, pointers.raw_storage());
        let (symbolic, scratch) = (&self.symbolic, &mut self.scratch);
        let factored = match &mut self.values {
            Values::Double(factor) => numeric(symbolic, pattern, matrix.values(), factor, scratch),
            Values::Single(single) => {
                single.take(matrix);
                numeric(symbolic, pattern, &single.matrix, &mut single.factor, scratch)
            }
            Values::Unsymmetric(lu) => {
                let [symmetric, skew] = lu.halves(matrix);
                addition.map_or(Ok(()), |n| n.add_halves(symmetric, skew))?;
                let none = Vec::new();
                let positions = symbolic.perm().map_or(&none[..], |p| p.arrays().1);
                lu.factor(&self.supernodes, positions)
                    .map_err(|index| LdltError::ZeroPivot { index })
            }
        };
        if let Err(LdltError::ZeroPivot { index }) = factored {
            return Err(self.zero_pivot(index));
        }
        self.is_valid = true;
        Ok(())
    }

    /// Allocates the storage of a numeric factorisation, once.
    fn reserve(&mut self) -> Result<()> {
        let (length, entries) = (self.nonzeros(), self.matrix_entries);
        let reserved = match &mut self.values {
            Values::Double(factor) => resize(factor, length),
            Values::Single(single) => {
                resize(&mut single.factor, length) && resize(&mut single.matrix, entries)
            }
            Values::Unsymmetric(lu) => lu.reserve(length, entries),
        };
        if !reserved {
            return Err(self.too_large(None));
        }
        if self.scratch.is_empty() {
            self.scratch =
                MemBuffer::try_new(self.scratch_request()).map_err(|_| self.too_large(None))?;
        }
        Ok(())
    }

    /// Solves `A x = rhs` for one right-hand side or for several, one after another in `rhs` and
    /// `x`.
    ///
    /// Takes a step of iterative refinement if `|b - A x| > 1e-13 |b|` (not needed in the orderings
    /// of this module), and up to three while it exceeds `1e-9 |b|`. Allocates only if there are
    /// more right-hand sides than in all calls before.
    ///
    /// # Errors
    /// Computation, if the right-hand side is not finite or the residual stays above 1e-9;
    /// internal, if there is no valid factor, the pattern is another one, or the lengths are wrong.
    pub fn solve(
        &mut self,
        matrix: &SymmetricMatrix,
        rhs: &[f64],
        x: &mut [f64],
    ) -> Result<SolveReport> {
        self.require_pattern_of(matrix)?;
        let n = self.order();
        if !self.is_valid || rhs.len() != x.len() || n == 0 || !rhs.len().is_multiple_of(n) {
            return Err(Error::internal("a linear solve is called wrongly").value(format!(
                "factor valid: {}, order {n}, right-hand side {}, solution {}",
                self.is_valid,
                rhs.len(),
                x.len()
            )));
        }
        rhs.chunks_exact(n).try_for_each(require_finite)?;
        self.residual.resize(rhs.len().max(self.residual.len()), 0.0);
        x.copy_from_slice(rhs);
        self.substitute(x);
        let mut refinements = 0;
        let mut residual = self.update_residual(matrix, rhs, x);
        while residual > if refinements == 0 { REFINED } else { TOLERANCE }
            && refinements < MOST_REFINEMENTS
        {
            let mut correction = std::mem::take(&mut self.residual);
            self.substitute(&mut correction[..rhs.len()]);
            x.iter_mut().zip(&correction).for_each(|(x, d)| *x += d);
            self.residual = correction;
            refinements += 1;
            residual = self.update_residual(matrix, rhs, x);
        }
        if residual <= TOLERANCE {
            Ok(SolveReport { residual, refinements, iterations: 0 })
        } else {
            Err(self.inaccurate(residual))
        }
    }

    /// Replaces each right-hand side in `x` by its solution, without refinement.
    pub(super) fn substitute(&mut self, x: &mut [f64]) {
        self.values.scale(x);
        let unknowns = self.symbolic.perm().map(|p| p.arrays().0);
        for x in x.chunks_exact_mut(self.symbolic.nrows()) {
            let Some(unknowns) = unknowns else {
                self.values.solve(&mut self.supernodes, x);
                continue;
            };
            self.permuted.iter_mut().zip(unknowns).for_each(|(v, &i)| *v = x[i]);
            self.values.solve(&mut self.supernodes, &mut self.permuted);
            self.permuted.iter().zip(unknowns).for_each(|(&v, &i)| x[i] = v);
        }
        self.values.scale(x);
    }

    /// Computes the residuals `b - A x` and returns the largest relative one; infinite if one is
    /// NaN.
    fn update_residual(&mut self, matrix: &SymmetricMatrix, rhs: &[f64], x: &[f64]) -> f64 {
        let n = self.order();
        let mut largest = 0.0_f64;
        for ((b, x), r) in
            rhs.chunks_exact(n).zip(x.chunks_exact(n)).zip(self.residual.chunks_exact_mut(n))
        {
            matrix.multiply(x, r);
            r.iter_mut().zip(b).for_each(|(r, b)| *r = b - *r);
            let (error, scale) = (norm(r), norm(b));
            let relative = if error == 0.0 { 0.0 } else { error / scale };
            largest = if relative.is_nan() { f64::INFINITY } else { largest.max(relative) };
        }
        largest
    }

    fn require_pattern_of(&self, matrix: &SymmetricMatrix) -> Result<()> {
        if self.pattern == matrix.pattern() {
            return Ok(());
        }
        Err(Error::internal(
            "a factor is used with a matrix of another pattern than the one it was made for",
        )
        .value(format!("{} unknowns, factor of {}", matrix.order(), self.order())))
    }

    fn too_large(&self, limit: Option<usize>) -> Error {
        let free =
            limit.map_or(String::new(), |limit| format!(", {} are free", readable_bytes(limit)));
        Error::computation("the factor of a matrix does not fit into the memory")
            .at(format!("{} unknowns, {} entries in the factor", self.order(), self.nonzeros()))
            .value(format!("{} are needed{free}", readable_bytes(self.bytes())))
            .remedy("use a coarser mesh, close other programs, or use a machine with more memory")
    }

    fn zero_pivot(&self, position: usize) -> Error {
        let unknown = self
            .symbolic
            .perm()
            .and_then(|p| p.arrays().0.get(position).copied())
            .unwrap_or(position);
        Error::computation(
            "a matrix is singular: elimination met a pivot that is zero or not finite",
        )
        .at(format!("unknown {unknown} of {}", self.order()))
        .remedy(
            "check the boundary conditions (is every field fixed somewhere?) and the coefficients",
        )
    }

    fn inaccurate(&self, residual: f64) -> Error {
        Error::computation("a linear system could not be solved accurately")
            .at(format!("{} unknowns", self.order()))
            .value(format!(
                "relative residual {residual:.1e} after {MOST_REFINEMENTS} refinements, allowed \
                 {TOLERANCE:e}"
            ))
            .remedy(
                "the matrix is nearly singular: check boundary conditions, mesh quality and \
                 coefficients of very different size",
            )
    }
}

impl Values {
    fn solve(&self, supernodes: &mut Supernodes, x: &mut [f64]) {
        match self {
            Values::Double(factor) => supernodes.solve([factor, factor], x),
            Values::Single(single) => supernodes.solve([&single.factor, &single.factor], x),
            Values::Unsymmetric(lu) => supernodes.solve([&lu.lower, &lu.upper], x),
        }
    }
    /// Multiplies right-hand sides or solutions by the scale of the factored matrix.
    fn scale(&self, x: &mut [f64]) {
        let scale = match self {
            Values::Double(_) => return,
            Values::Single(single) => single.scale(),
            Values::Unsymmetric(lu) => &lu.scale,
        };
        for x in x.chunks_exact_mut(scale.len()) {
            x.iter_mut().zip(scale).for_each(|(x, s)| *x *= s);
        }
    }
}

/// Resizes a list once; returns false if the memory does not suffice.
fn resize<T: Clone + Default>(list: &mut Vec<T>, length: usize) -> bool {
    let fits = list.len() == length || list.try_reserve_exact(length).is_ok();
    if fits {
        list.resize(length, T::default());
    }
    fits
}

/// # Errors
/// Computation, if an entry of a right-hand side is not finite.
pub(super) fn require_finite(rhs: &[f64]) -> Result<()> {
    match rhs.iter().position(|v| !v.is_finite()) {
        Some(k) => Err(not_finite("the right-hand side", rhs[k], k)),
        None => Ok(()),
    }
}

fn not_finite(what: &str, value: f64, unknown: usize) -> Error {
    Error::computation(format!("{what} of a linear system is not a finite number"))
        .at(format!("unknown {unknown}"))
        .value(value)
        .remedy(
            "the computation has blown up before: use a smaller time step, or check expressions \
             and coefficients",
        )
}

fn column_of_entry(matrix: &SymmetricMatrix, entry: usize) -> usize {
    matrix.upper().indptr().raw_storage().partition_point(|&start| start <= entry).saturating_sub(1)
}

/// The 2-norm, without overflow for large entries.
fn norm(v: &[f64]) -> f64 {
    let plain = v.iter().map(|a| a * a).sum::<f64>();
    if plain.is_normal() {
        return plain.sqrt();
    }
    let largest = v.iter().fold(0.0_f64, |m, a| if a.abs() <= m { m } else { a.abs() });
    if largest == 0.0 {
        0.0
    } else {
        largest * v.iter().map(|a| (a / largest).powi(2)).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests;
