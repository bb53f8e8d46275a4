//! Conversion of points: to the arguments of expressions, and from lists of numbers.

use crate::mesh::Point;

/// A point as three coordinates, the arguments of expressions.
pub(super) fn coordinates<const D: usize>(x: &Point<D>) -> [f64; 3] {
    std::array::from_fn(|i| if i < D { x[i] } else { 0.0 })
}

/// A list of numbers as a point.
pub(super) fn point<const D: usize>(x: &[f64]) -> Point<D> {
    Point::<D>::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0))
}
