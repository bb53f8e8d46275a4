//! The ellipse, with the exact distance to it.

use super::shape::{Placement, Shape, check_semi_axes};
use crate::base::Result;
use crate::mesh::Point;

/// An ellipse.
#[derive(Clone, Debug)]
pub struct Ellipse {
    placement: Placement<2>,
    semi_axes: Point<2>,
}

impl Ellipse {
    /// `semi_axes` along the axes of the frame, which is rotated by `angle` degrees
    /// counterclockwise.
    ///
    /// # Errors
    /// Semi-axes that are not positive or further than a factor of 1e6 apart, a centre or an angle
    /// that is not finite.
    pub fn new(centre: Point<2>, semi_axes: Point<2>, angle: f64) -> Result<Ellipse> {
        check_semi_axes("an ellipse", &semi_axes)?;
        Ok(Ellipse { placement: Placement::plane(centre, angle)?, semi_axes })
    }
}

impl Shape<2> for Ellipse {
    fn distance(&self, x: &Point<2>) -> f64 {
        let (y, e) = (self.placement.orthant(x), self.semi_axes);
        if e[0] >= e[1] {
            distance_in_quadrant(e[0], e[1], y[0], y[1])
        } else {
            distance_in_quadrant(e[1], e[0], y[1], y[0])
        }
    }
    fn bounds(&self) -> (Point<2>, Point<2>) {
        self.placement.bounds(|axis| self.semi_axes.component_mul(axis).norm())
    }
}

/// Signed distance from `(x, y)`, `x, y >= 0`, to the ellipse with semi-axes `a >= b`.
///
/// The closest point is `(r x / (t + r - 1), y / t)` with `r = (a/b)^2` and `t > 0` the largest
/// root of `G(t) = (r (x/a) / (t + r - 1))^2 + ((y/b) / t)^2 - 1` (D. Eberly, *Distance from a
/// point to an ellipse*; his `s` is `t - 1`, and `t` keeps its relative accuracy beside the long
/// axis, where `s` does not). `G` falls and is convex, so Newton's method from a point where
/// `G >= 0` rises to the root; a step that rounding spoils is replaced by a bisection.
fn distance_in_quadrant(a: f64, b: f64, x: f64, y: f64) -> f64 {
    let (u, v) = (x / a, y / b);
    let (r, r1) = ((a / b).powi(2), (a - b) * (a + b) / (b * b));
    if v == 0.0 {
        // On the long axis: up to the centre of curvature of the vertex the closest point lies
        // above, not at the vertex.
        let cosine = r * u / r1;
        if r1 > 0.0 && cosine < 1.0 {
            let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
            return -(a * cosine - x).hypot(b * sine);
        }
        return x - a;
    }
    let g = |t: f64| {
        let (p, q) = (r * u / (t + r1), v / t);
        (p * p + q * q - 1.0, -2.0 * (p * p / (t + r1) + q * q / t))
    };
    // Each term alone reaches 1 here, so G >= 0; and G <= 0 where both together cannot.
    let mut low = v.max(r * u - r1);
    let mut high = (r * u).hypot(v);
    let mut t = low;
    for _ in 0..200 {
        let (value, slope) = g(t);
        if value >= 0.0 {
            low = t
        } else {
            high = t
        }
        let mut next = t - value / slope;
        if !(next >= low && next <= high) {
            next = 0.5 * (low + high);
        }
        if (next - t).abs() <= 2.0 * f64::EPSILON * t {
            t = next;
            break;
        }
        t = next;
    }
    // Point minus closest point, with the common factor taken out: no cancellation, and the sign
    // comes with it.
    (t - 1.0) * (x / (t + r1)).hypot(y / t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn p(x: f64, y: f64) -> Point<2> {
        Point::<2>::new(x, y)
    }

    #[test]
    fn centre_axes_and_evolute_are_exact() {
        let e = Ellipse::new(p(1.0, 1.0), p(0.75, 0.5), 0.0).unwrap();
        assert!((e.distance(&p(1.0, 1.0)) + 0.5).abs() < 1e-15);
        assert!((e.distance(&p(2.0, 1.0)) - 0.25).abs() < 1e-15);
        assert!((e.distance(&p(1.0, 1.2)) + 0.3).abs() < 1e-15);
        assert!((e.distance(&p(1.0, 0.2)) - 0.3).abs() < 1e-15);
        // Between the vertex and its centre of curvature at (a^2 - b^2)/a = .41667 from the centre.
        assert!((e.distance(&p(1.6, 1.0)) + 0.15).abs() < 1e-15);
        // Inside of it: closest point (a^2 x / (a^2 - b^2), ..).
        let x: f64 = 0.2;
        let foot = (
            0.75f64.powi(2) * x / (0.75f64.powi(2) - 0.25),
            0.5 * (1.0 - (0.75 * x / 0.3125).powi(2)).sqrt(),
        );
        assert!((e.distance(&p(1.0 + x, 1.0)) + (foot.0 - x).hypot(foot.1)).abs() < 1e-15);
        // Continuous across the long axis.
        for x in [0.0, 0.2, 0.3125 / 0.75, 0.5, 0.75, 0.9] {
            for tiny in [1e-300, 1e-20, 1e-9] {
                let d = e.distance(&p(1.0 + x, 1.0)) - e.distance(&p(1.0 + x, 1.0 + tiny));
                assert!(d.abs() < 2.0 * tiny + 1e-15, "{x} {tiny} {d}");
            }
        }
        let (low, high) = Ellipse::new(p(0.0, 0.0), p(2.0, 1.0), 90.0).unwrap().bounds();
        assert!((low - p(-1.0, -2.0)).norm() + (high - p(1.0, 2.0)).norm() < 1e-15);
    }

    #[test]
    fn wrong_axes_are_refused() {
        for axes in [p(0.0, 1.0), p(1.0, -1.0), p(1.0, f64::NAN), p(1.0, 1e-200)] {
            assert!(
                Ellipse::new(p(0.0, 0.0), axes, 0.0).unwrap_err().to_string().contains("semi-axes")
            );
        }
    }

    #[test]
    fn a_needle_keeps_its_distances() {
        let e = Ellipse::new(p(0.0, 0.0), p(1.0, 1e-6), 0.0).unwrap();
        for (x, exact) in
            [((0.0, 0.5), 0.5 - 1e-6), ((2.0, 0.0), 1.0), ((4.0, 4.0), 5.0), ((0.0, 0.0), -1e-6)]
        {
            assert!(
                (e.distance(&p(x.0, x.1)) - exact).abs() < 1e-11,
                "{x:?} {}",
                e.distance(&p(x.0, x.1))
            );
        }
    }

    proptest! {
        /// A point at a known distance along the normal, less than the radius of curvature away
        /// inside.
        #[test]
        fn points_along_the_normal_keep_their_distance(
            a in 0.1..3.0f64, b in 0.1..3.0f64, angle in 0.0..2.0 * PI, s in -0.999..3.0f64, turn in -180.0..180.0f64,
        ) {
            let shape = Ellipse::new(p(0.3, -0.7), p(a, b), turn).unwrap();
            let (c, s_) = (angle.cos(), angle.sin());
            let normal = p(c / a, s_ / b).normalize();
            // Smallest radius of curvature: inside of it the foot is unique.
            let d = s * a.min(b).powi(2) / a.max(b);
            let local = p(a * c, b * s_) + normal * d;
            let x = p(0.3, -0.7) + nalgebra::Rotation2::new(turn.to_radians()) * local;
            prop_assert!((shape.distance(&x) - d).abs() < 1e-14 * (1.0 + 4.0 * a.max(b)), "{} {d}", shape.distance(&x));
        }

        #[test]
        fn it_agrees_with_sampling_and_is_lipschitz(
            a in 0.05..2.0f64, b in 0.05..2.0f64, x in -3.0..3.0f64, y in -3.0..3.0f64, x2 in -3.0..3.0f64, y2 in -3.0..3.0f64,
        ) {
            let shape = Ellipse::new(p(0.0, 0.0), p(a, b), 0.0).unwrap();
            let n = 20_000;
            let nearest = (0..n)
                .map(|k| 2.0 * PI * k as f64 / n as f64)
                .map(|t| (a * t.cos() - x).hypot(b * t.sin() - y))
                .fold(f64::INFINITY, f64::min);
            let d = shape.distance(&p(x, y));
            prop_assert!((d.abs() - nearest).abs() < 4e-4);
            prop_assert!(nearest - d.abs() > -1e-13, "a sample cannot be nearer than the distance");
            prop_assert_eq!(d < 0.0, (x / a).powi(2) + (y / b).powi(2) < 1.0);
            prop_assert!((d - shape.distance(&p(x2, y2))).abs() <= (x - x2).hypot(y - y2) + 1e-14);
        }

        #[test]
        fn a_round_ellipse_is_a_circle(x in -3.0..3.0f64, y in -3.0..3.0f64, turn in -180.0..180.0f64) {
            let shape = Ellipse::new(p(0.0, 0.0), p(0.7, 0.7), turn).unwrap();
            prop_assert!((shape.distance(&p(x, y)) - (x.hypot(y) - 0.7)).abs() < 1e-14);
        }

        #[test]
        fn turning_space_turns_the_ellipse(x in -2.0..2.0f64, y in -2.0..2.0f64, turn in -180.0..180.0f64) {
            let straight = Ellipse::new(p(0.0, 0.0), p(1.2, 0.4), 0.0).unwrap();
            let turned = Ellipse::new(p(0.0, 0.0), p(1.2, 0.4), turn).unwrap();
            let swapped = Ellipse::new(p(0.0, 0.0), p(0.4, 1.2), turn + 90.0).unwrap();
            let image = nalgebra::Rotation2::new(turn.to_radians()) * p(x, y);
            let d = straight.distance(&p(x, y));
            prop_assert!((turned.distance(&image) - d).abs() < 4e-15);
            prop_assert!((swapped.distance(&image) - d).abs() < 4e-15);
        }
    }
}
