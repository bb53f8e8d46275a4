//! Terms of the momentum equation in addition to those of the fluid.

use crate::fem::{At, Cells, VectorForm};
use nalgebra::{SMatrix, SVector};

/// Support of a momentum term: the places where its forms are evaluated.
#[derive(Clone, Copy)]
pub enum Support<'a, const D: usize> {
    /// The quadrature points of the flow's rule in these cells.
    Cells(Cells<'a>),
    /// Points with weights of their own, those of a cell one after the other: a surface that cuts
    /// the cells, single points (weight 1), or a quadrature that follows an interface. `q` is the
    /// index of a point in the list.
    Points(&'a [At<D>]),
}

impl<'a, const D: usize> Support<'a, D> {
    /// The cells; none if the support is on points.
    pub fn cells(&self) -> Cells<'a> {
        match *self {
            Support::Cells(cells) => cells,
            Support::Points(_) => Cells::Some(&[]),
        }
    }
    /// The points; none if the support is in cells.
    pub fn points(&self) -> &'a [At<D>] {
        match *self {
            Support::Cells(_) => &[],
            Support::Points(points) => points,
        }
    }
}

/// A force on the flow, integrated weakly.
///
/// The force is the linear form `F(v) = sum w (f0 . v + f1 : grad v)` over the points of the
/// [`support`](Self::support) with weights `w`. A stress `sigma` has `f0 = 0`, `f1 = -sigma`; a
/// force per volume (or a force on a point) has `f1 = 0`.
///
/// An implicit term adds a symmetric positive semi-definite form `C(u, v)` to the matrix: with `u`
/// the new velocity and `u*` the velocity that the explicit part was computed with (zero in schemes
/// of order 1), the force is `F(v) - C(u - u*, v)`. A penalty has `F = 0` and `C(u, v) = (k u, v)`.
///
/// Every term counts in loads, reactions, the lift of boundary values and the power of walls.
///
/// # Examples
/// ```
/// use immersa::fem::{At, Cells, Condition, Element, Rule, Space, VectorForm};
/// use immersa::flow::term::{MomentumTerm, Support};
/// use immersa::flow::{Coefficient, FlowSolver, Step};
/// use immersa::mesh::{Diagonals, Point, rectangle};
/// use nalgebra::SMatrix;
/// use std::sync::Arc;
///
/// /// A constant force per volume.
/// struct Weight(Point<2>);
///
/// impl MomentumTerm<2> for Weight {
///     fn support(&self) -> Support<'_, 2> {
///         Support::Cells(Cells::All)
///     }
///     fn force(&self, _at: &At<2>) -> VectorForm<2> {
///         (self.0, SMatrix::zeros())
///     }
/// }
///
/// // In a closed box the pressure balances the force, and the fluid stays at rest.
/// let mesh = Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], Diagonals::UnionJack)?);
/// let [p2, p1] = [Element::P2, Element::P1].map(|e| Arc::new(Space::new(&mesh, e)));
/// let walls = vec![("walls".to_string(), Condition::NoSlip)];
/// let mut flow = FlowSolver::new(&p2, &p1, &Arc::new(Rule::simplex(2, 4)), &walls, 0.0)?;
/// flow.set_materials(Coefficient::Constant(0.0), Coefficient::Constant(1.0));
/// let mut state = flow.at_rest();
/// let weight = Weight(Point::<2>::new(0.0, -2.0));
/// let step = Step { weight: 0.0, terms: &[&weight], ..Step::backward_euler(0.1, 0.1, &[]) };
/// flow.step(&step, &mut state)?;
/// assert!(state.u.iter().all(|u| u.norm() < 1e-12));
/// for (p, x) in state.p.iter().zip(p1.nodes()) {
///     assert!((p - (1.0 - 2.0 * x[1])).abs() < 1e-11); // of zero mean
/// }
/// # Ok::<(), immersa::base::Error>(())
/// ```
pub trait MomentumTerm<const D: usize>: Sync {
    /// The places where the term does not vanish.
    fn support(&self) -> Support<'_, D>;
    /// The explicit force at a point of the support: the pair `(f0, f1)` tested with `(v, grad v)`.
    fn force(&self, at: &At<D>) -> VectorForm<D>;
    /// True if [`stiffness`](Self::stiffness) enters the matrix.
    fn is_implicit(&self) -> bool {
        false
    }
    /// `C(u, v)` at a point: the pair tested with `(v, grad v)`, linear in `u` and `grad_u`. A term
    /// on cells may be evaluated at points of any cell, and is zero outside its support.
    fn stiffness(
        &self,
        _at: &At<D>,
        _u: &SVector<f64, D>,
        _grad_u: &SMatrix<f64, D, D>,
    ) -> VectorForm<D> {
        (SVector::zeros(), SMatrix::zeros())
    }
}
