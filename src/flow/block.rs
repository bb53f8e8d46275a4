//! Unknowns of a structure in addition to velocity and pressure.

use crate::fem::{At, VectorForm};

/// Unknowns `l` that a structure adds to the system of the flow, and their equations.
///
/// With velocity and pressure the system is, for all velocities `v` and all test values `m`,
///
/// ```text
/// a(u, v) - (p, div v) + b(l, v) = F(v),    b(m, u) + d(l, m) = g(m),
/// ```
///
/// where every form is a sum over [`points`](Self::points) with their weights. The unknowns are
/// traces of P1 or P2 functions on cut cells (tension, moment of a vesicle) or a few that couple
/// with all points (pressure of a vesicle, velocity of a rigid body). `d` is symmetric: negative
/// semi-definite for multipliers (stabilisation), positive definite for velocities of bodies.
///
/// The matrix is factored without pivoting: these unknowns are eliminated after all velocities
/// they couple with, and that suffices where `b` has full rank or `d` makes up for it.
pub trait Block<const D: usize>: Sync {
    /// Number of unknowns.
    fn len(&self) -> usize;
    /// True if there are no unknowns.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
    /// Points where the forms are evaluated, those of a cell one after the other; `q` is the index
    /// of a point in the list.
    fn points(&self) -> &[At<D>];
    /// Cells that the pattern of the matrix allows for, ascending: those of the points and others
    /// that the structure may come to, so that the pattern lasts for some steps. `None` for those of
    /// the points.
    fn cells(&self) -> Option<&[u32]> {
        None
    }
    /// Appends the unknowns that couple in `cell` to `out`, each once.
    fn unknowns(&self, cell: usize, out: &mut Vec<u32>);
    /// `b(l, v)` at a point for `l = 1` at local unknown `k` (in the order of
    /// [`unknowns`](Self::unknowns)) and 0 at the others: the pair tested with `(v, grad v)`.
    fn coupling(&self, at: &At<D>, k: usize) -> VectorForm<D>;
    /// `d(l, m)` at a point between the local unknowns `j` and `k`; symmetric.
    fn own(&self, _at: &At<D>, _j: usize, _k: usize) -> f64 {
        0.0
    }
    /// `g(m)` at a point for local unknown `k`.
    fn source(&self, _at: &At<D>, _k: usize) -> f64 {
        0.0
    }
}
