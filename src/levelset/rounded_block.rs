//! The box with rounded edges in space.

use super::shape::{Shape, check_lengths, check_point};
use crate::base::{Error, Result};
use crate::mesh::Point;
use nalgebra::{Rotation3, SVector, Unit};

/// A box with edges rounded by circular cylinders, and corners by balls.
#[derive(Clone, Debug)]
pub struct RoundedBlock {
    centre: Point<3>,
    rotation: Rotation3<f64>,
    half_size: Point<3>,
    radius: f64,
}

impl RoundedBlock {
    /// `half_size` is half the extents including the rounding, `radius` that of the edges (0: sharp); turned by `angle` degrees about
    /// `axis`, of any length but 0, by the right-hand rule.
    ///
    /// # Errors
    /// Sizes that are not positive, a radius that is negative or larger than the smallest half size, an axis without a direction.
    pub fn new(
        centre: Point<3>,
        half_size: Point<3>,
        radius: f64,
        axis: SVector<f64, 3>,
        angle: f64,
    ) -> Result<RoundedBlock> {
        check_lengths("the half sizes of a rounded box", half_size.as_slice())?;
        check_point("the centre of a shape", &centre)?;
        if !(radius >= 0.0 && radius <= half_size.min()) {
            return Err(Error::scene("the edge radius of a rounded box must lie between 0 and its smallest half size")
                .value(radius)
                .remedy(format!("give a radius in [0, {}]", half_size.min())));
        }
        Ok(RoundedBlock { centre, rotation: rotation(axis, angle)?, half_size, radius })
    }
}

/// The rotation by `angle` degrees about `axis`.
///
/// # Errors
/// An axis without a direction, an angle that is not finite.
pub(super) fn rotation(axis: SVector<f64, 3>, angle: f64) -> Result<Rotation3<f64>> {
    match Unit::try_new(axis, 0.0) {
        Some(axis) if angle.is_finite() && axis.iter().all(|c| c.is_finite()) => {
            Ok(Rotation3::from_axis_angle(&axis, angle.to_radians()))
        }
        _ => Err(Error::scene("a shape cannot be turned so")
            .value(format!("{angle} degrees about {:?}", axis.as_slice()))
            .remedy("give an axis such as [0, 0, 1], and a finite angle")),
    }
}

impl Shape<3> for RoundedBlock {
    fn distance(&self, x: &Point<3>) -> f64 {
        let octant = self.rotation.inverse_transform_vector(&(x - self.centre)).abs();
        let q = octant - self.half_size.add_scalar(-self.radius);
        q.sup(&Point::<3>::zeros()).norm() + q.max().min(0.0) - self.radius
    }
    fn bounds(&self) -> (Point<3>, Point<3>) {
        let core = self.half_size.add_scalar(-self.radius);
        // The support function of the core along each axis of space.
        let half = (self.rotation.matrix().abs() * core).add_scalar(self.radius);
        (self.centre - half, self.centre + half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(x: f64, y: f64, z: f64) -> Point<3> {
        Point::<3>::new(x, y, z)
    }

    #[test]
    fn faces_edges_and_corners_have_their_distances() {
        let block = RoundedBlock::new(p(1.0, 0.0, 0.0), p(2.0, 1.0, 0.5), 0.25, p(0.0, 0.0, 1.0), 0.0).unwrap();
        assert_eq!(block.distance(&p(1.0, 0.0, 2.0)), 1.5, "above a face");
        assert_eq!(block.distance(&p(1.0, 0.0, 0.0)), -0.5, "in the middle");
        let edge = block.distance(&p(1.0 + 1.75 + 3.0, 0.75 + 4.0, 0.0));
        assert!((edge - 4.75).abs() < 1e-14, "beside an edge: {edge}");
        let corner = block.distance(&p(1.0 + 1.75 + 2.0, 0.75 + 3.0, 0.25 + 6.0));
        assert!((corner - 6.75).abs() < 1e-14, "beyond a corner: {corner}");
    }

    #[test]
    fn a_turned_block_is_the_block_of_exchanged_sizes() {
        let turned = RoundedBlock::new(p(0.0, 0.0, 0.0), p(2.0, 1.0, 0.5), 0.2, p(0.0, 3.0, 0.0), 90.0).unwrap();
        let plain = RoundedBlock::new(p(0.0, 0.0, 0.0), p(0.5, 1.0, 2.0), 0.2, p(0.0, 0.0, 1.0), 0.0).unwrap();
        for k in 0..200 {
            let x = p((k as f64).sin(), (2.3 * k as f64).sin(), (3.7 * k as f64).sin()) * 3.0;
            assert!((turned.distance(&x) - plain.distance(&x)).abs() < 1e-14);
        }
        assert!((turned.bounds().1 - p(0.5, 1.0, 2.0)).norm() < 1e-14, "{:?}", turned.bounds());
    }

    #[test]
    fn blocks_that_cannot_be_are_refused() {
        let new = |half, radius, axis| RoundedBlock::new(p(0.0, 0.0, 0.0), half, radius, axis, 30.0);
        assert!(new(p(1.0, 0.0, 1.0), 0.0, p(1.0, 0.0, 0.0)).unwrap_err().what().contains("positive"));
        assert!(new(p(1.0, 0.4, 1.0), 0.5, p(1.0, 0.0, 0.0)).unwrap_err().advice().contains("[0, 0.4]"));
        assert!(new(p(1.0, 1.0, 1.0), 0.5, p(0.0, 0.0, 0.0)).unwrap_err().what().contains("turned"));
    }
}
