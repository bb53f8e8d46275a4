//! A P2 function on a straight line, a quadratic polynomial, and its zeros.

use crate::fem::Space;
use nalgebra::SVector;

/// A quadratic polynomial `c[0] + c[1] s + c[2] s^2`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quadratic([f64; 3]);

impl Quadratic {
    /// From the values at 0, 1/2 and 1.
    pub(super) fn through(v0: f64, v_half: f64, v1: f64) -> Quadratic {
        Quadratic([v0, 4.0 * v_half - 3.0 * v0 - v1, 2.0 * (v0 + v1) - 4.0 * v_half])
    }
    /// `phi` on the line `x + s step` in cell `c`, where `l` are the barycentric coordinates of
    /// `x`.
    pub(super) fn on_line<const D: usize>(
        space: &Space<D>,
        phi: &[f64],
        c: usize,
        l: &[f64; 4],
        step: &SVector<f64, D>,
    ) -> Quadratic {
        let dl = barycentric_direction(space, c, step);
        let at = |s: f64| space.value(phi, c, &std::array::from_fn(|k| l[k] + s * dl[k]));
        Quadratic::about(at(-1.0), at(0.0), at(1.0))
    }
    /// From the values at -1, 0 and 1.
    pub(super) fn about(minus: f64, zero: f64, plus: f64) -> Quadratic {
        Quadratic([zero, 0.5 * (plus - minus), 0.5 * (plus + minus) - zero])
    }
    /// The real roots, the one nearer to 0 first; infinite where there are none.
    pub(super) fn roots(&self) -> [f64; 2] {
        let [c, b, a] = self.0;
        let discriminant = b * b - 4.0 * a * c;
        if discriminant < 0.0 || discriminant.is_nan() {
            return [f64::INFINITY; 2];
        }
        // No cancellation: q has the larger modulus of the two.
        let q = -0.5 * (b + discriminant.sqrt().copysign(b));
        let near = if c == 0.0 { 0.0 } else { c / q };
        let far = q / a;
        [near, far].map(|s| if s.is_finite() { s } else { f64::INFINITY })
    }
    /// The root between 0 and 1, where the values have different signs.
    pub(super) fn crossing(&self) -> f64 {
        let [near, far] = self.roots();
        let outside = |s: f64| (s - s.clamp(0.0, 1.0)).abs();
        let s = if outside(near) <= outside(far) { near } else { far };
        // Rounding may hide the root; then it lies at the end with the smaller value.
        let end = if self.0[0].abs() <= self.0.iter().sum::<f64>().abs() { 0.0 } else { 1.0 };
        if s.is_finite() { s.clamp(0.0, 1.0) } else { end }
    }
}

/// Barycentric coordinates of a vector: those of `x + v` less those of `x`.
pub(super) fn barycentric_direction<const D: usize>(
    space: &Space<D>,
    c: usize,
    v: &SVector<f64, D>,
) -> [f64; 4] {
    let d = space.mesh().map(c).inverse * v;
    let mut l = [0.0; 4];
    for k in 0..D {
        l[0] -= d[k];
        l[k + 1] = d[k];
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn degenerate_polynomials_have_the_roots_that_exist() {
        let none = f64::INFINITY;
        assert_eq!(Quadratic([1.0, 0.0, 1.0]).roots(), [none, none]);
        assert_eq!(Quadratic([1.0, 2.0, 0.0]).roots(), [-0.5, none]);
        assert_eq!(Quadratic([0.0, 2.0, 1.0]).roots(), [0.0, -2.0]);
        assert_eq!(Quadratic([3.0, 0.0, 0.0]).roots(), [none, none]);
        assert_eq!(Quadratic([f64::NAN, 1.0, 0.0]).roots(), [none, none]);
    }

    proptest! {
        #[test]
        fn roots_are_accurate_however_far_apart(near in -1.0..1.0f64, ratio in 1.0..1e9f64, scale in 0.1..10.0f64) {
            let far = near * ratio;
            let roots = Quadratic([scale * near * far, -scale * (near + far), scale]).roots();
            // Double roots keep half the digits.
            let tolerance = 1e-14 * (1.0 + ratio / (ratio - 1.0)) + if ratio < 1.01 { 1e-6 } else { 0.0 };
            prop_assert!((roots[0] - near).abs() <= tolerance * near.abs() && (roots[1] - far).abs() <= tolerance * far.abs());
        }

        #[test]
        fn a_change_of_sign_has_a_crossing(a in -1.0..1.0f64, b in 0.0..1.0f64, half in -3.0..3.0f64) {
            let (v0, v1) = (a, -a.signum() * b);
            let q = Quadratic::through(v0, half, v1);
            let s = q.crossing();
            prop_assert!((0.0..=1.0).contains(&s));
            prop_assert!((q.0[0] + s * (q.0[1] + s * q.0[2])).abs() < 1e-14);
        }
    }
}
