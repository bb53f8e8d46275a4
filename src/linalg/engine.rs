//! What solves for a saddle point, or preconditions: chosen by what fits into the memory.

use super::gmres::RESTART;
use super::memory::{available, readable};
use super::schur::{Saddle, Schur};
use super::{Factor, FactorSize, Multipliers, Ordering, Precision, SymmetricMatrix};
use crate::base::{Cause, Error, Result};
use std::fmt;

/// A way of solving for a saddle point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// With the factor of the whole matrix in double precision.
    Direct,
    /// By GMRES with the factor of the whole matrix in single precision, half as large: 2 to 3 iterations.
    Single,
    /// By GMRES with scalar factors for the components and a Schur complement that is approximated: a fifth of the memory, 20 to 80 iterations.
    Schur,
}

impl Way {
    /// The word for it in a scene.
    pub fn word(self) -> &'static str {
        match self {
            Way::Direct => "direct",
            Way::Single => "single",
            Way::Schur => "schur",
        }
    }
    /// Iterations after which a solve has failed.
    pub(super) fn most_iterations(self) -> usize {
        match self {
            Way::Direct => 0,
            Way::Single => 40,
            Way::Schur => 400,
        }
    }
    /// Bytes of the directions that the iterations keep.
    pub(super) fn vector_bytes(self, unknowns: usize) -> usize {
        let directions = match self {
            Way::Direct => 0,
            Way::Single => 5,
            Way::Schur => RESTART,
        };
        (2 * directions + 2) * unknowns * size_of::<f64>()
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Way::Direct => "a factor of the whole matrix (direct)",
            Way::Single => "GMRES with a factor in single precision (single)",
            Way::Schur => "GMRES with scalar factors and a Schur complement (schur)",
        })
    }
}

/// Which ways of solving are allowed, and how much memory their factors may take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Solving {
    /// The way; `None` takes the first that fits, in the order of [`Way`].
    pub way: Option<Way>,
    /// Bytes that the factors may take with all working space; `None` stands for what the machine can give when they are planned.
    pub memory: Option<usize>,
}

/// Exponent of the unknowns in the bytes of a factor, for what a refusal says would fit: that of nested dissection in space.
const GROWTH: f64 = 4.0 / 3.0;

/// A factor or what stands for it.
#[allow(clippy::large_enum_variant, reason = "there is one, and it is not moved about")]
pub(super) enum Engine {
    Whole(Factor),
    Schur(Box<Schur>),
}

impl Engine {
    /// The first way that fits.
    ///
    /// # Errors
    /// Computation, if none does.
    pub fn choose(
        matrix: &SymmetricMatrix,
        multipliers: Multipliers,
        solving: Solving,
        saddle: impl FnOnce() -> Result<Saddle>,
    ) -> Result<Engine> {
        let limit = solving.memory.or_else(available);
        let mut tried = Vec::new();
        if solving.way != Some(Way::Schur) {
            let mut factor = Factor::plan(matrix, Ordering::saddle_point(matrix, multipliers)?)?;
            for (way, precision) in [(Way::Direct, Precision::Double), (Way::Single, Precision::Single)] {
                factor = factor.with_precision(precision);
                let engine = Engine::Whole(factor);
                if solving.way.is_none_or(|asked| asked == way) && engine.fits(limit, &mut tried) {
                    return Ok(engine);
                }
                let Engine::Whole(back) = engine else { break };
                factor = back;
            }
        }
        if solving.way.is_none_or(|asked| asked == Way::Schur) {
            let engine = Engine::Schur(Box::new(Schur::plan(matrix, saddle()?)?));
            if engine.fits(limit, &mut tried) {
                return Ok(engine);
            }
        }
        Err(refusal(matrix.order(), limit, &tried))
    }

    /// Whether it fits; notes what it takes.
    fn fits(&self, limit: Option<usize>, tried: &mut Vec<(Way, usize)>) -> bool {
        let bytes = self.size().bytes;
        tried.push((self.way(), bytes));
        limit.is_none_or(|limit| bytes <= limit)
    }

    pub fn way(&self) -> Way {
        match self {
            Engine::Whole(factor) if factor.precision() == Precision::Single => Way::Single,
            Engine::Whole(_) => Way::Direct,
            Engine::Schur(_) => Way::Schur,
        }
    }

    /// Of all factors, with the directions of the iterations.
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
        FactorSize { bytes: size.bytes + self.way().vector_bytes(size.unknowns), ..size }
    }

    pub fn is_valid(&self) -> bool {
        match self {
            Engine::Whole(factor) => factor.is_valid(),
            Engine::Schur(schur) => schur.is_valid(),
        }
    }

    pub fn refactor(&mut self, matrix: &SymmetricMatrix) -> Result<()> {
        match self {
            Engine::Whole(factor) => factor.refactor(matrix),
            Engine::Schur(schur) => schur.refactor(matrix),
        }
    }

    pub fn precondition(&mut self, matrix: &SymmetricMatrix, v: &mut [f64]) {
        match self {
            Engine::Whole(factor) => factor.substitute(v),
            Engine::Schur(schur) => schur.apply(matrix, v),
        }
    }
}

fn refusal(unknowns: usize, limit: Option<usize>, tried: &[(Way, usize)]) -> Error {
    let limit = limit.unwrap_or(usize::MAX);
    let needed: Vec<String> =
        tried.iter().map(|(way, bytes)| format!("{} by {}", readable(*bytes), way.word())).collect();
    let fitting = tried.iter().map(|(way, bytes)| {
        let share = (limit as f64 / *bytes as f64).powf(1.0 / GROWTH);
        format!("about {:.2e} unknowns by {}", share * unknowns as f64, way.word())
    });
    let fitting: Vec<String> = fitting.collect();
    let (cause, other) = match tried {
        [(Way::Schur, _)] | [_, _, ..] => (None, ""),
        _ => (Some(Cause::SolverMemory), ", let the solver be chosen by the memory"),
    };
    let error = Error::computation("the factors of a matrix do not fit into the memory")
        .at(format!("{unknowns} unknowns"))
        .value(format!("{} are needed, {} may be taken", needed.join(", "), readable(limit)))
        .remedy(format!(
            "use a coarser mesh ({} would fit){other}, close other programs, or use a machine with more memory",
            fitting.join(", ")
        ));
    match cause {
        Some(cause) => error.because(cause),
        None => error,
    }
}

#[cfg(test)]
mod tests;
