//! Choice of the solver of a saddle point by the available memory.

use super::gmres::RESTART;
use super::schur::{Saddle, Schur};
use super::{Factor, FactorSize, Multipliers, Operator, Ordering, Precision, SymmetricMatrix};
use crate::base::{Cause, Error, Result, available_memory, readable_bytes, rounded};
use std::fmt;

/// Solver of a saddle point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SolverKind {
    /// Direct: factor of the whole matrix in double precision.
    Direct,
    /// The same for a matrix with a part that is not symmetric: GMRES preconditioned by an older
    /// factor `L D U` of the whole in single precision.
    Lu,
    /// GMRES preconditioned by the factor of the whole matrix in single precision: half the memory,
    /// 2 to 3 iterations.
    Single,
    /// GMRES preconditioned by scalar factors of the components and an approximate Schur
    /// complement: a fifth of the memory, 20 to 80 iterations.
    Schur,
}

impl SolverKind {
    /// Name in a scene (`numerics.solver`).
    pub fn name(self) -> &'static str {
        match self {
            SolverKind::Direct | SolverKind::Lu => "direct",
            SolverKind::Single => "single",
            SolverKind::Schur => "schur",
        }
    }
    /// Largest number of iterations of a solve.
    pub(super) fn most_iterations(self) -> usize {
        match self {
            SolverKind::Direct => 0,
            SolverKind::Lu | SolverKind::Single => 40,
            SolverKind::Schur => 400,
        }
    }
    /// Bytes of the Krylov vectors.
    pub(super) fn vector_bytes(self, unknowns: usize) -> usize {
        let directions = match self {
            SolverKind::Direct => 0,
            SolverKind::Single => 5,
            SolverKind::Lu => 20,
            SolverKind::Schur => RESTART,
        };
        (2 * directions + 2) * unknowns * size_of::<f64>()
    }
}

impl fmt::Display for SolverKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SolverKind::Direct => "a factor of the whole matrix (direct)",
            SolverKind::Lu => "GMRES with an older LU factor in single precision (direct)",
            SolverKind::Single => "GMRES with a factor in single precision (single)",
            SolverKind::Schur => "GMRES with scalar factors and a Schur complement (schur)",
        })
    }
}

/// Allowed solvers, and memory of their factors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolverOptions {
    /// The solver; `None` takes the first that fits, in the order of [`SolverKind`].
    pub kind: Option<SolverKind>,
    /// Largest number of bytes of the factors with all working space; `None` for the memory
    /// available when they are planned.
    pub memory: Option<usize>,
    /// True if a part that is not symmetric is added to the matrix.
    pub unsymmetric: bool,
}

/// Exponent of the number of unknowns in the bytes of a factor, for the size that an error message
/// suggests: nested dissection in space.
const GROWTH: f64 = 4.0 / 3.0;

/// A factor, or a preconditioner in its place.
#[allow(clippy::large_enum_variant, reason = "there is one, and it is not moved about")]
pub(super) enum Engine {
    Whole(Factor),
    Schur(Box<Schur>),
}

impl Engine {
    /// The first solver that fits.
    ///
    /// # Errors
    /// Computation, if none does.
    pub fn choose(
        matrix: &SymmetricMatrix,
        multipliers: Multipliers,
        options: SolverOptions,
        saddle: impl FnOnce() -> Result<Saddle>,
    ) -> Result<Engine> {
        let limit = options.memory.or_else(available_memory);
        let whole = if options.unsymmetric { SolverKind::Lu } else { SolverKind::Direct };
        let allowed = options.kind.map(|k| if k == SolverKind::Direct { whole } else { k });
        let mut tried = Vec::new();
        if allowed != Some(SolverKind::Schur) {
            let mut factor = Factor::plan(matrix, Ordering::saddle_point(matrix, multipliers)?)?;
            for kind in [whole, SolverKind::Single] {
                factor = match kind {
                    SolverKind::Lu => factor.unsymmetric(),
                    SolverKind::Single => factor.with_precision(Precision::Single),
                    _ => factor.with_precision(Precision::Double),
                };
                let engine = Engine::Whole(factor);
                if allowed.is_none_or(|allowed| allowed == kind) && engine.fits(limit, &mut tried) {
                    return Ok(engine);
                }
                let Engine::Whole(back) = engine else { break };
                factor = back;
            }
        }
        if allowed.is_none_or(|allowed| allowed == SolverKind::Schur) {
            let engine = Engine::Schur(Box::new(Schur::plan(matrix, saddle()?)?));
            if engine.fits(limit, &mut tried) {
                return Ok(engine);
            }
        }
        Err(refusal(matrix.order(), limit, &tried))
    }

    /// True if it fits; appends its size to `tried`.
    fn fits(&self, limit: Option<usize>, tried: &mut Vec<(SolverKind, usize)>) -> bool {
        let bytes = self.size().bytes;
        tried.push((self.kind(), bytes));
        limit.is_none_or(|limit| bytes <= limit)
    }

    pub fn kind(&self) -> SolverKind {
        match self {
            Engine::Whole(factor) if factor.is_unsymmetric() => SolverKind::Lu,
            Engine::Whole(factor) if factor.precision() == Precision::Single => SolverKind::Single,
            Engine::Whole(_) => SolverKind::Direct,
            Engine::Schur(_) => SolverKind::Schur,
        }
    }

    /// Size of all factors, with the Krylov vectors.
    pub fn size(&self) -> FactorSize {
        let size = match self {
            Engine::Whole(factor) => factor.size(),
            Engine::Schur(schur) => FactorSize {
                unknowns: schur.order(),
                entries: schur.nonzeros(),
                read: schur.entries_read(),
                operations: schur.operations(),
                bytes: schur.bytes(),
                precision: Precision::Single,
            },
        };
        FactorSize { bytes: size.bytes + self.kind().vector_bytes(size.unknowns), ..size }
    }

    pub fn is_valid(&self) -> bool {
        match self {
            Engine::Whole(factor) => factor.is_valid(),
            Engine::Schur(schur) => schur.is_valid(),
        }
    }

    pub fn refactor(&mut self, operator: &Operator<'_>) -> Result<()> {
        match self {
            Engine::Whole(factor) => {
                factor.refactor_with(operator.matrix, operator.addition.as_deref())
            }
            Engine::Schur(schur) => schur.refactor(operator.matrix),
        }
    }

    pub fn precondition(&mut self, matrix: &SymmetricMatrix, v: &mut [f64]) {
        match self {
            Engine::Whole(factor) => factor.substitute(v),
            Engine::Schur(schur) => schur.apply(matrix, v),
        }
    }
}

fn refusal(unknowns: usize, limit: Option<usize>, tried: &[(SolverKind, usize)]) -> Error {
    let limit = limit.unwrap_or(usize::MAX);
    let needed: Vec<String> = tried
        .iter()
        .map(|(kind, bytes)| format!("{} by {}", readable_bytes(*bytes), kind.name()))
        .collect();
    let fitting = tried.iter().map(|(kind, bytes)| {
        let share = (limit as f64 / *bytes as f64).powf(1.0 / GROWTH);
        format!("about {} unknowns by {}", rounded(share * unknowns as f64, 2), kind.name())
    });
    let fitting: Vec<String> = fitting.collect();
    let (cause, other) = match tried {
        [(SolverKind::Schur, _)] | [_, _, ..] => (None, ""),
        _ => (Some(Cause::SolverMemory), ", let the solver be chosen by the memory"),
    };
    let error = Error::computation("the factors of a matrix do not fit into the memory")
        .at(format!("{unknowns} unknowns"))
        .value(format!("{} are needed, {} may be taken", needed.join(", "), readable_bytes(limit)))
        .remedy(format!(
            "use a coarser mesh ({} would fit){other}, close other programs, or use a machine \
             with more memory",
            fitting.join(", ")
        ));
    match cause {
        Some(cause) => error.because(cause),
        None => error,
    }
}

#[cfg(test)]
mod tests;
