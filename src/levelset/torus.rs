//! Tori.

use super::shape::{Shape, check_lengths, check_point};
use crate::base::{Error, Result};
use crate::mesh::Point;
use nalgebra::SVector;

/// A torus: the points nearer than `minor` to a circle of radius `major`.
#[derive(Clone, Debug)]
pub struct Torus {
    centre: Point<3>,
    axis: SVector<f64, 3>,
    major: f64,
    minor: f64,
}

impl Torus {
    /// `axis`, of any length, is perpendicular to the circle.
    ///
    /// # Errors
    /// Radii that are not positive, `minor > major`, an axis without length, a centre that is not
    /// finite.
    pub fn new(centre: Point<3>, axis: SVector<f64, 3>, major: f64, minor: f64) -> Result<Torus> {
        check_point("the centre of a torus", &centre)?;
        check_point("the axis of a torus", &axis)?;
        check_lengths("the radii of a torus", &[major, minor])?;
        let Some(axis) = axis.try_normalize(0.0).filter(|_| minor <= major) else {
            return Err(Error::scene(
                "a torus needs an axis with a length, and a minor radius up to the major one",
            )
            .value(format!("axis = {:?}, major = {major}, minor = {minor}", axis.as_slice())));
        };
        Ok(Torus { centre, axis, major, minor })
    }
}

impl Shape<3> for Torus {
    fn distance(&self, x: &Point<3>) -> f64 {
        let (d, height) = (x - self.centre, (x - self.centre).dot(&self.axis));
        ((d - self.axis * height).norm() - self.major).hypot(height) - self.minor
    }
    fn bounds(&self) -> (Point<3>, Point<3>) {
        let half = self.axis.map(|a| self.major * (1.0 - a * a).max(0.0).sqrt() + self.minor);
        (self.centre - half, self.centre + half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn p(x: f64, y: f64, z: f64) -> Point<3> {
        Point::<3>::new(x, y, z)
    }

    #[test]
    fn wrong_sizes_are_refused_with_the_value() {
        let (o, sizes) = (p(0.0, 0.0, 0.0), p(1.0, 0.5, 2.0));
        assert!(Torus::new(o, o, 1.0, 0.5).is_err());
        assert!(Torus::new(o, sizes, 0.4, 0.5).unwrap_err().to_string().contains("minor = 0.5"));
    }

    proptest! {
        /// A point at a known place beside the circle.
        #[test]
        fn a_torus_is_measured_from_its_circle(along in 0.0..6.3f64, around in 0.0..6.3f64, d in 0.0..0.9f64, a in prop::array::uniform3(-1.0..1.0f64)) {
            let axis = Point::<3>::from(a);
            prop_assume!(axis.norm() > 0.1);
            let axis = axis.normalize();
            let u = axis.cross(&if axis[0].abs() < 0.6 { Point::<3>::x() } else { Point::<3>::y() }).normalize();
            let out = u * along.cos() + axis.cross(&u) * along.sin();
            let centre = p(0.1, 0.2, -0.3);
            let torus = Torus::new(centre, axis * 3.0, 1.0, 0.4).unwrap();
            let x = centre + out + (out * around.cos() + axis * around.sin()) * d;
            prop_assert!((torus.distance(&x) - (d - 0.4)).abs() < 1e-14);
            let (low, high) = torus.bounds();
            let on = centre + out + (out * around.cos() + axis * around.sin()) * 0.4;
            prop_assert!((0..3).all(|i| low[i] - 1e-14 <= on[i] && on[i] <= high[i] + 1e-14));
        }
    }
}
