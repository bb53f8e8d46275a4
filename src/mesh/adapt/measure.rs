//! Lengths and qualities in a metric.

use super::tensor::Tensor;
use crate::mesh::Point;
use robust::{Coord, orient2d};

/// Area over the square of the longest side below which a triangle is flat.
const FLAT: f64 = 1e-10;
/// Relative difference below which lengths are averaged: the logarithm would lose accuracy.
const ALIKE: f64 = 1e-3;

/// Length of the edge from `a` to `b` when the size along it changes geometrically: with the
/// lengths `l_a`, `l_b` in the metrics of its ends, `(l_a - l_b)/ln(l_a/l_b)`.
#[inline]
pub(super) fn length(a: &Point<2>, m: &Tensor, b: &Point<2>, n: &Tensor) -> f64 {
    let e = b - a;
    let (p, q) = (m.square(&e).sqrt(), n.square(&e).sqrt());
    if (p - q).abs() <= ALIKE * (p + q) { 0.5 * (p + q) } else { (p - q) / (p / q).ln() }
}

/// Parameter of the point, from `a`, that halves this length.
pub(super) fn middle(a: &Point<2>, m: &Tensor, b: &Point<2>, n: &Tensor) -> f64 {
    let e = b - a;
    let r = 0.5 * (n.square(&e) / m.square(&e)).ln();
    if r.abs() < 1e-6 { 0.5 } else { (0.5 * (1.0 + r.exp())).ln() / r }
}

/// Quality of a triangle in the mean of the metrics of its vertices,
/// `4 sqrt 3 area / (sum of squared sides)`: 1 if it is equilateral in the metric, 0 if it is flat
/// or inverted.
#[inline]
pub(super) fn quality(points: [&Point<2>; 3], metrics: [&Tensor; 3]) -> f64 {
    let area = 0.5 * doubled_area(points);
    let [a, b, c] = points;
    let sides = [b - a, c - b, a - c];
    let longest = sides.iter().map(|e| e.norm_squared()).fold(0.0, f64::max);
    if area <= FLAT * longest {
        return 0.0;
    }
    let m = *metrics[0] + *metrics[1] + *metrics[2];
    let sum: f64 = sides.iter().map(|e| m.square(e)).sum();
    4.0 * 3f64.sqrt() * area * m.determinant().max(0.0).sqrt() / sum
}

/// Twice the area, with the right sign.
#[inline]
fn doubled_area(points: [&Point<2>; 3]) -> f64 {
    let [a, b, c] = points.map(|p| Coord { x: p[0], y: p[1] });
    orient2d(a, b, c)
}
