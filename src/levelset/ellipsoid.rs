//! The ellipsoid, with the exact distance to it.

use super::shape::{Placement, Shape, check_semi_axes};
use crate::base::Result;
use crate::mesh::Point;
use nalgebra::SVector;

/// An ellipsoid.
#[derive(Clone, Debug)]
pub struct Ellipsoid {
    placement: Placement<3>,
    semi_axes: Point<3>,
}

impl Ellipsoid {
    /// `semi_axes` along x, y and z of the frame, which is rotated by `turn`: the axis of the
    /// rotation times its angle in degrees (right-hand rule; zero for none).
    ///
    /// # Errors
    /// Semi-axes that are not positive or further than a factor of 1e6 apart, a centre or a
    /// rotation that is not finite.
    pub fn new(centre: Point<3>, semi_axes: Point<3>, turn: SVector<f64, 3>) -> Result<Ellipsoid> {
        check_semi_axes("an ellipsoid", &semi_axes)?;
        Ok(Ellipsoid { placement: Placement::space(centre, turn)?, semi_axes })
    }
}

impl Shape<3> for Ellipsoid {
    fn distance(&self, x: &Point<3>) -> f64 {
        distance_in_octant(&self.semi_axes, &self.placement.orthant(x))
    }
    fn bounds(&self) -> (Point<3>, Point<3>) {
        self.placement.bounds(|axis| self.semi_axes.component_mul(axis).norm())
    }
}

/// Signed distance from `y`, all `y_i >= 0`, to the ellipsoid with semi-axes `e`, of which `b` is
/// the smallest.
///
/// The closest point is `r_i y_i / (t + d_i)` with `r_i = (e_i/b)^2`, `d_i = r_i - 1`, and `t >= 0`
/// the largest root of `G(t) = sum_i (r_i (y_i/e_i) / (t + d_i))^2 - 1` (D. Eberly, *Distance from
/// a point to an ellipse, an ellipsoid, or a hyperellipsoid*; his parameter is `b^2 (t - 1)`). `G`
/// falls and is convex, so Newton's method from a point where `G >= 0` rises to the root; a step
/// that rounding spoils is replaced by a bisection. In the plane through the centre across the
/// smallest axis there may be no root: then `t = 0`, and the closest point lies above and below the
/// plane.
fn distance_in_octant(e: &Point<3>, y: &Point<3>) -> f64 {
    let b = e.min();
    let p = Point::<3>::from_fn(|i, _| (e[i] / b).powi(2) * (y[i] / e[i]));
    let d = e.map(|e| (e - b) * (e + b) / (b * b));
    // The part of the sum of squares that belongs to coordinates other than 0.
    let ratio = |i: usize, t: f64| if p[i] > 0.0 { p[i] / (t + d[i]) } else { 0.0 };
    let squares = |t: f64| (0..3).map(|i| ratio(i, t).powi(2)).sum::<f64>();
    let at_zero = squares(0.0);
    if at_zero < 1.0 {
        let flat = (0..3).map(|i| (ratio(i, 0.0) * e[i] - y[i]).powi(2)).sum::<f64>();
        return -(flat + b * b * (1.0 - at_zero)).sqrt();
    }
    let g = |t: f64| {
        let slope =
            (0..3).filter(|&i| p[i] > 0.0).map(|i| ratio(i, t).powi(2) / (t + d[i])).sum::<f64>();
        (squares(t) - 1.0, -2.0 * slope)
    };
    // Each term alone reaches 1 here, so G >= 0; and G <= 0 where all together cannot.
    let mut low = (p - d).max().max(0.0);
    let mut high = p.sum();
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
        let done = (next - t).abs() <= 2.0 * f64::EPSILON * t;
        t = next;
        if done {
            break;
        }
    }
    // Point minus closest point, with the common factor taken out: no cancellation, and the sign
    // comes with it.
    (t - 1.0)
        * (0..3).filter(|&i| p[i] > 0.0).map(|i| (y[i] / (t + d[i])).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levelset::Ellipse;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn p(x: f64, y: f64, z: f64) -> Point<3> {
        Point::<3>::new(x, y, z)
    }
    fn straight(a: f64, b: f64, c: f64) -> Ellipsoid {
        Ellipsoid::new(p(0.0, 0.0, 0.0), p(a, b, c), p(0.0, 0.0, 0.0)).unwrap()
    }

    #[test]
    fn centre_axes_and_focal_planes_are_exact() {
        for e in [
            straight(0.9, 0.6, 0.4),
            straight(0.4, 0.9, 0.6),
            straight(0.6, 0.6, 0.4),
            straight(0.4, 0.4, 0.4),
        ] {
            let axes = e.semi_axes;
            assert!((e.distance(&p(0.0, 0.0, 0.0)) + 0.4).abs() < 1e-15);
            for i in 0..3 {
                let unit = Point::<3>::from_fn(|k, _| if k == i { 1.0 } else { 0.0 });
                assert!((e.distance(&(unit * (axes[i] + 0.3))) - 0.3).abs() < 1e-15, "{axes} {i}");
                assert!(e.distance(&(unit * axes[i])).abs() < 1e-15);
            }
        }
        // Continuous across the planes of symmetry.
        let e = straight(0.9, 0.6, 0.4);
        for (x, y) in
            [(0.0, 0.0), (0.3, 0.2), (0.7, 0.0), (0.0, 0.3), (0.9, 0.6), (0.0, 0.6), (0.5, 1e-12)]
        {
            for tiny in [1e-300, 1e-20, 1e-9] {
                for (flat, near) in [
                    (p(x, y, 0.0), p(x, y, tiny)),
                    (p(x, 0.0, y), p(x, tiny, y)),
                    (p(0.0, x, y), p(tiny, x, y)),
                ] {
                    let d = e.distance(&flat) - e.distance(&near);
                    assert!(d.abs() < 2.0 * tiny + 1e-14, "{flat} {tiny} {d}");
                }
            }
        }
        let turned = Ellipsoid::new(p(1.0, 0.0, 0.0), p(3.0, 2.0, 1.0), p(0.0, 90.0, 0.0)).unwrap();
        assert!((turned.bounds().1 - p(2.0, 2.0, 3.0)).norm() < 1e-14);
    }

    #[test]
    fn wrong_axes_are_refused() {
        let o = p(0.0, 0.0, 0.0);
        for axes in
            [p(0.0, 1.0, 1.0), p(1.0, -1.0, 1.0), p(1.0, f64::NAN, 1.0), p(1.0, 1.0, 1e-200)]
        {
            assert!(Ellipsoid::new(o, axes, o).unwrap_err().to_string().contains("semi-axes"));
        }
        assert!(Ellipsoid::new(o, p(1.0, 1.0, 1.0), p(0.0, f64::INFINITY, 0.0)).is_err());
    }

    #[test]
    fn a_needle_and_a_disc_keep_their_distances() {
        let needle = straight(1.0, 1e-6, 1e-6);
        let disc = straight(1.0, 1e-6, 1.0);
        for (e, x, exact) in [
            (&needle, p(0.0, 0.3, 0.4), 0.5 - 1e-6),
            (&needle, p(4.0, 0.0, 4.0), 5.0),
            (&needle, p(0.0, 0.0, 0.0), -1e-6),
            (&disc, p(0.0, 0.5, 0.0), 0.5 - 1e-6),
            (&disc, p(3.0, 0.0, 4.0), 4.0),
        ] {
            assert!((e.distance(&x) - exact).abs() < 1e-11, "{x} {}", e.distance(&x));
        }
    }

    proptest! {
        /// A point at a known distance along the normal, less than the smallest radius of curvature
        /// away inside.
        #[test]
        fn points_along_the_normal_keep_their_distance(
            axes in prop::array::uniform3(0.1..3.0f64), t in 0.0..2.0 * PI, z in -1.0..1.0f64, s in -0.999..3.0f64,
            turn in prop::array::uniform3(-180.0..180.0f64),
        ) {
            let (axes, centre) = (Point::<3>::from(axes), p(0.3, -0.7, 0.2));
            let shape = Ellipsoid::new(centre, axes, turn.into()).unwrap();
            let rho = (1.0 - z * z).sqrt();
            let on = p(rho * t.cos(), rho * t.sin(), z);
            let d = s * axes.min().powi(2) / axes.max();
            let local = on.component_mul(&axes) + on.component_div(&axes).normalize() * d;
            let x = centre + nalgebra::Rotation3::new(Point::<3>::from(turn).map(f64::to_radians)) * local;
            prop_assert!((shape.distance(&x) - d).abs() < 2e-14 * (1.0 + 4.0 * axes.max()), "{} {d}", shape.distance(&x));
        }

        #[test]
        fn it_agrees_with_sampling_and_is_lipschitz(
            axes in prop::array::uniform3(0.05..2.0f64), x in prop::array::uniform3(-3.0..3.0f64), x2 in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let shape = straight(axes[0], axes[1], axes[2]);
            let (axes, x, x2) = (Point::<3>::from(axes), Point::<3>::from(x), Point::<3>::from(x2));
            let n = 20_000;
            // A Fibonacci lattice on the sphere.
            let on = |k: usize| {
                let z = 1.0 - (2.0 * k as f64 + 1.0) / n as f64;
                let (s, c) = (k as f64 * PI * (3.0 - 5f64.sqrt())).sin_cos();
                p((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
            };
            let nearest = (0..n).map(|k| (on(k).component_mul(&axes) - x).norm()).fold(f64::INFINITY, f64::min);
            let d = shape.distance(&x);
            prop_assert!(nearest >= d.abs() - 1e-13, "a sample cannot be nearer than the distance");
            prop_assert!(nearest - d.abs() < 0.04, "{} {}", nearest, d);
            prop_assert_eq!(d < 0.0, x.component_div(&axes).norm() < 1.0);
            prop_assert!((d - shape.distance(&x2)).abs() <= (x - x2).norm() + 1e-14);
        }

        /// In the plane of the two larger axes (outside) and on an ellipsoid of revolution the
        /// distance is that to an ellipse.
        #[test]
        fn an_ellipsoid_of_revolution_is_an_ellipse_in_its_meridian(x in prop::array::uniform3(-2.0..2.0f64), a in 0.1..1.5f64, c in 0.1..1.5f64) {
            let ellipse = Ellipse::new(Point::<2>::zeros(), Point::<2>::new(a, c), 0.0).unwrap();
            let d = straight(a, a, c).distance(&x.into());
            prop_assert!((d - ellipse.distance(&Point::<2>::new(x[0].hypot(x[1]), x[2]))).abs() < 1e-14);
        }
    }
}
