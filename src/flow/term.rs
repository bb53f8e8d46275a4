//! What acts on the flow.

use crate::fem::{At, Cells, SurfacePoint, VectorForm};
use nalgebra::{SMatrix, SVector};

/// A force on the flow, integrated weakly.
///
/// A stress `sigma` acts through `F(v) = -(sigma, grad v)`, that is `f0 = 0`, `f1 = -sigma`. A term that can tell how its force
/// changes with the velocity of the new time level adds a symmetric positive semi-definite form `C(u, v)` to the matrix:
/// with `u` the new velocity and `u*` the one that the explicit part was made with, the force is `F(v) - C(u - u*, v)`.
pub trait MomentumTerm<const D: usize>: Sync {
    /// The cells where the term does not vanish.
    fn cells(&self) -> Cells<'_>;
    /// The explicit force at a quadrature point of the flow's rule: the pair tested with `(v, grad v)`.
    fn force(&self, at: &At<D>) -> VectorForm<D>;
    /// Whether [`stiffness`](Self::stiffness) is to be put into the matrix.
    fn is_implicit(&self) -> bool;
    /// `C(u, v)` at a quadrature point of any cell (zero outside [`cells`](Self::cells)): the tensor that is tested with `grad v`,
    /// linear in `grad_u`.
    fn stiffness(&self, at: &At<D>, grad_u: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D>;
    /// Points of a surface on which the term acts too, or instead, those of a cell one after the other.
    fn surface(&self) -> &[SurfacePoint<D>] {
        &[]
    }
    /// The explicit force per area of the surface, as [`force`](Self::force).
    fn surface_force(&self, _: &SurfacePoint<D>) -> VectorForm<D> {
        (SVector::zeros(), SMatrix::zeros())
    }
    /// `C(u, v)` per area of the surface, as [`stiffness`](Self::stiffness).
    fn surface_stiffness(&self, _: &SurfacePoint<D>, _grad_u: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        SMatrix::zeros()
    }
}
