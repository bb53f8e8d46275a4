//! Symmetric 2 x 2 tensors and their functions, in closed form.

use crate::mesh::Point;
use nalgebra::SMatrix;
use std::ops::{Add, Mul};

/// A symmetric tensor `[xx, xy; xy, yy]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tensor {
    pub xx: f64,
    pub xy: f64,
    pub yy: f64,
}

impl Add for Tensor {
    type Output = Tensor;
    fn add(self, o: Tensor) -> Tensor {
        Tensor { xx: self.xx + o.xx, xy: self.xy + o.xy, yy: self.yy + o.yy }
    }
}

impl Mul<f64> for Tensor {
    type Output = Tensor;
    fn mul(self, s: f64) -> Tensor {
        Tensor { xx: self.xx * s, xy: self.xy * s, yy: self.yy * s }
    }
}

impl Tensor {
    /// The symmetric part of a matrix.
    pub fn of(m: &SMatrix<f64, 2, 2>) -> Tensor {
        Tensor { xx: m[(0, 0)], xy: 0.5 * (m[(0, 1)] + m[(1, 0)]), yy: m[(1, 1)] }
    }
    pub fn matrix(&self) -> SMatrix<f64, 2, 2> {
        SMatrix::<f64, 2, 2>::new(self.xx, self.xy, self.xy, self.yy)
    }
    /// `e^T M e`.
    #[inline]
    pub fn square(&self, e: &Point<2>) -> f64 {
        self.xx * e[0] * e[0] + 2.0 * self.xy * e[0] * e[1] + self.yy * e[1] * e[1]
    }
    #[inline]
    pub fn determinant(&self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }
    /// The eigenvalues, the larger first.
    pub fn eigenvalues(&self) -> [f64; 2] {
        let (m, d) = self.mean_and_radius();
        [m + d, m - d]
    }
    /// `f(M)`: the same eigenvectors, `f` of the eigenvalues (the larger first).
    pub fn map(&self, f: impl FnOnce([f64; 2]) -> [f64; 2]) -> Tensor {
        let (m, d) = self.mean_and_radius();
        let [a, b] = f([m + d, m - d]);
        let (mean, slope) = (0.5 * (a + b), if d > 0.0 { 0.5 * (a - b) / d } else { 0.0 });
        // M - m, without its trace, which is zero.
        let half = 0.5 * (self.xx - self.yy);
        Tensor { xx: mean + slope * half, xy: slope * self.xy, yy: mean - slope * half }
    }
    /// Mean of the eigenvalues and half their difference.
    fn mean_and_radius(&self) -> (f64, f64) {
        (0.5 * (self.xx + self.yy), (0.5 * (self.xx - self.yy)).hypot(self.xy))
    }
    /// The logarithm of a positive tensor.
    pub fn ln(&self) -> Tensor {
        self.map(|[a, b]| [a.ln(), b.ln()])
    }
    /// The exponential: always positive.
    #[inline]
    pub fn exp(&self) -> Tensor {
        self.map(|[a, b]| [a.exp(), b.exp()])
    }
    /// The smallest tensor (largest unit ellipse) above both of two positive ones, by simultaneous
    /// reduction: with `M = L L^T` and `L^-1 N L^-T = Q diag(mu) Q^T` it is
    /// `L Q diag(max(1, mu)) Q^T L^T`.
    pub fn intersection(&self, other: &Tensor) -> Tensor {
        let a = self.xx.sqrt();
        let b = self.xy / a;
        let c = (self.yy - b * b).max(f64::MIN_POSITIVE).sqrt();
        // L = [a, 0; b, c], K = L^-1 = [1/a, 0; -b/(a c), 1/c].
        let (p, q, r) = (1.0 / a, -b / (a * c), 1.0 / c);
        let reduced = Tensor {
            xx: p * p * other.xx,
            xy: p * (q * other.xx + r * other.xy),
            yy: q * q * other.xx + 2.0 * q * r * other.xy + r * r * other.yy,
        };
        let s = reduced.map(|mu| mu.map(|m| m.max(1.0)));
        Tensor {
            xx: a * a * s.xx,
            xy: a * (b * s.xx + c * s.xy),
            yy: b * b * s.xx + 2.0 * b * c * s.xy + c * c * s.yy,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn positive() -> impl Strategy<Value = Tensor> {
        (-6.0..6.0f64, -6.0..6.0f64, 0.0..3.2f64).prop_map(|(a, b, angle)| {
            let (s, c) = angle.sin_cos();
            let (a, b) = (a.exp(), b.exp());
            Tensor { xx: a * c * c + b * s * s, xy: (a - b) * c * s, yy: a * s * s + b * c * c }
        })
    }

    proptest! {
        #[test]
        fn the_exponential_undoes_the_logarithm(m in positive()) {
            let back = m.ln().exp();
            let size = m.xx + m.yy;
            prop_assert!((back.xx - m.xx).abs() < 1e-9 * size && (back.xy - m.xy).abs() < 1e-9 * size);
            prop_assert!((back.determinant() - (m.ln().xx + m.ln().yy).exp()).abs() < 1e-6 * size * size);
        }

        #[test]
        fn an_intersection_asks_for_at_least_what_both_ask_for_and_no_more(m in positive(), n in positive(), angle in 0.0..3.2f64) {
            let (both, swapped) = (m.intersection(&n), n.intersection(&m));
            let e = Point::<2>::new(angle.cos(), angle.sin());
            let (l, a, b) = (both.square(&e), m.square(&e), n.square(&e));
            prop_assert!(l >= a.max(b) * (1.0 - 1e-8) && l <= (a + b) * (1.0 + 1e-8), "{l} {a} {b}");
            prop_assert!((l - swapped.square(&e)).abs() < 1e-6 * l);
            let same = m.intersection(&m);
            prop_assert!((same.square(&e) - a).abs() < 1e-8 * (m.xx + m.yy));
        }
    }
}
