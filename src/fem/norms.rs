//! Norms of errors with respect to exact expressions.

use super::assembly::{Basis, Cells, integrate};
use super::quadrature::Rule;
use super::space::Space;
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Norms of a difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// L2 norm.
    pub l2: f64,
    /// L2 norm of the gradient.
    pub h1: f64,
}

/// Degree of the rule used for norms: the square of a P2 function and four degrees of the exact
/// expression.
const DEGREE: usize = 8;

/// Norms of `u - exact` for a vector function; `exact` gives value and gradient (row `i`: gradient
/// of component `i`).
pub fn vector_errors<const D: usize>(
    space: &Arc<Space<D>>,
    u: &[SVector<f64, D>],
    exact: impl Fn(&Point<D>) -> (SVector<f64, D>, SMatrix<f64, D, D>) + Sync,
) -> Errors {
    let basis = Basis::new(space, &Arc::new(Rule::simplex(D, DEGREE)));
    let [l2, h1] = integrate(&basis, Cells::All, |at| {
        let (v, g) = exact(&at.x);
        [(basis.value(at, u) - v).norm_squared(), (basis.jacobian(at, u) - g).norm_squared()]
    });
    Errors { l2: l2.sqrt(), h1: h1.sqrt() }
}

/// Norms of `f - exact` for a scalar function; `exact` gives value and gradient.
pub fn scalar_errors<const D: usize>(
    space: &Arc<Space<D>>,
    f: &[f64],
    exact: impl Fn(&Point<D>) -> (f64, SVector<f64, D>) + Sync,
) -> Errors {
    let basis = Basis::new(space, &Arc::new(Rule::simplex(D, DEGREE)));
    let [l2, h1] = integrate(&basis, Cells::All, |at| {
        let (v, g) = exact(&at.x);
        [(basis.value(at, f) - v).powi(2), (basis.gradient(at, f) - g).norm_squared()]
    });
    Errors { l2: l2.sqrt(), h1: h1.sqrt() }
}
