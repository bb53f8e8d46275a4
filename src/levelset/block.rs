//! Shapes in space with a closed formula for the distance, and their local frame.

use super::shape::{Shape, check_lengths, check_point};
use crate::base::{Error, Result};
use crate::mesh::Point;
use nalgebra::{Rotation3, SVector};

/// The local frame of a shape in space: centre and rotation.
#[derive(Clone, Debug)]
pub(super) struct SpaceFrame {
    centre: Point<3>,
    rotation: Rotation3<f64>,
}

impl SpaceFrame {
    /// `turn` is the axis of the rotation times its angle in degrees, by the right-hand rule.
    pub(super) fn new(centre: Point<3>, turn: SVector<f64, 3>) -> Result<SpaceFrame> {
        check_point("the centre of a shape", &centre)?;
        check_point("the rotation of a shape", &turn)?;
        Ok(SpaceFrame { centre, rotation: Rotation3::new(turn.map(f64::to_radians)) })
    }
    /// Absolute values of the coordinates of `x` in the frame: the shapes here have all three
    /// symmetries.
    pub(super) fn octant(&self, x: &Point<3>) -> Point<3> {
        self.rotation.inverse_transform_vector(&(x - self.centre)).abs()
    }
    /// The box around the set whose support function in the frame is `support`.
    pub(super) fn bounds(&self, support: impl Fn(&Point<3>) -> f64) -> (Point<3>, Point<3>) {
        let half = Point::<3>::from_fn(|axis, _| {
            let axis = Point::<3>::from_fn(|i, _| if i == axis { 1.0 } else { 0.0 });
            support(&self.rotation.inverse_transform_vector(&axis).abs())
        });
        (self.centre - half, self.centre + half)
    }
}

/// A box in space with edges and corners rounded by arcs and parts of spheres.
#[derive(Clone, Debug)]
pub struct RoundedBlock {
    frame: SpaceFrame,
    half_size: Point<3>,
    radius: f64,
}

impl RoundedBlock {
    /// `half_size` is half the three sides including the rounding, `radius` that of the edges (0:
    /// sharp), `turn` the axis of the rotation times its angle in degrees (right-hand rule; zero:
    /// none).
    ///
    /// # Errors
    /// Sizes that are not positive, a radius that is negative or larger than the smallest half
    /// size.
    pub fn new(centre: Point<3>, half_size: Point<3>, radius: f64, turn: SVector<f64, 3>) -> Result<RoundedBlock> {
        check_lengths("the half sizes of a rounded block", half_size.as_slice())?;
        if !(radius >= 0.0 && radius <= half_size.min()) {
            return Err(Error::scene(
                "the edge radius of a rounded block must lie between 0 and its smallest half size",
            )
            .value(radius)
            .remedy(format!("give a radius in [0, {}]", half_size.min())));
        }
        Ok(RoundedBlock { frame: SpaceFrame::new(centre, turn)?, half_size, radius })
    }
}

impl Shape<3> for RoundedBlock {
    fn distance(&self, x: &Point<3>) -> f64 {
        let q = self.frame.octant(x) - self.half_size.add_scalar(-self.radius);
        q.sup(&Point::<3>::zeros()).norm() + q.max().min(0.0) - self.radius
    }
    fn bounds(&self) -> (Point<3>, Point<3>) {
        let core = self.half_size.add_scalar(-self.radius);
        self.frame.bounds(|axis| core.dot(axis) + self.radius)
    }
}

/// A torus: the points nearer than `minor` to a circle of radius `major`.
#[derive(Clone, Debug)]
pub struct Torus {
    centre: Point<3>,
    axis: SVector<f64, 3>,
    major: f64,
    minor: f64,
}

impl Torus {
    /// `axis`, of any length, is normal to the plane of the circle.
    ///
    /// # Errors
    /// Radii that are not positive, `minor > major`, an axis of length zero, a centre that is not
    /// finite.
    pub fn new(centre: Point<3>, axis: SVector<f64, 3>, major: f64, minor: f64) -> Result<Torus> {
        check_point("the centre of a torus", &centre)?;
        check_point("the axis of a torus", &axis)?;
        check_lengths("the radii of a torus", &[major, minor])?;
        let Some(axis) = axis.try_normalize(0.0).filter(|_| minor <= major) else {
            return Err(Error::scene("a torus needs an axis with a length, and a minor radius up to the major one")
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
        assert!(RoundedBlock::new(o, sizes, 0.6, o).unwrap_err().to_string().contains("[0, 0.5]"));
        assert!(RoundedBlock::new(o, p(1.0, -0.5, 1.0), 0.0, o).is_err());
        assert!(RoundedBlock::new(o, sizes, 0.0, p(f64::NAN, 0.0, 0.0)).unwrap_err().to_string().contains("rotation"));
        assert!(Torus::new(o, o, 1.0, 0.5).is_err());
        assert!(Torus::new(o, sizes, 0.4, 0.5).unwrap_err().to_string().contains("minor = 0.5"));
    }

    #[test]
    fn a_block_has_the_distances_of_its_faces_edges_and_corners() {
        let o = p(0.0, 0.0, 0.0);
        let block = RoundedBlock::new(p(1.0, 0.0, 0.0), p(1.0, 0.5, 2.0), 0.25, o).unwrap();
        for (x, d) in [
            (p(1.0, 0.0, 0.0), -0.5),
            (p(1.0, 0.0, 2.5), 0.5),
            (p(1.0, 1.25, 2.75), 2f64.sqrt() - 0.25),
            (p(2.75, 1.25, -2.75), 3f64.sqrt() - 0.25),
        ] {
            assert!((block.distance(&x) - d).abs() < 1e-15, "{x} {d}");
        }
        // A quarter turn about z exchanges the sides.
        let turned = RoundedBlock::new(o, p(1.0, 0.5, 2.0), 0.25, p(0.0, 0.0, 90.0)).unwrap();
        assert!((turned.bounds().1 - p(0.5, 1.0, 2.0)).norm() < 1e-15);
        assert!((turned.distance(&p(0.0, 1.5, 0.0)) - 0.5).abs() < 1e-15);
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
