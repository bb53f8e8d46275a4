//! Shapes with a true signed distance: the trait, balls, rounded boxes, and the check that a shape
//! fits its domain.

use crate::base::{Error, Result, parallel};
use crate::fem::Space;
use crate::mesh::Point;
use nalgebra::{Rotation, SVector};

/// A closed set with a signed distance to its boundary.
///
/// # Examples
/// ```
/// use immersa::levelset::{Circle, Shape};
/// use immersa::mesh::Point;
///
/// let circle = Circle::new(Point::<2>::new(1.0, 1.0), 2.0)?;
/// assert_eq!(circle.distance(&Point::<2>::new(4.0, 5.0)), 3.0);
/// assert_eq!(circle.distance(&Point::<2>::new(1.0, 1.0)), -2.0);
/// # Ok::<(), immersa::base::Error>(())
/// ```
pub trait Shape<const D: usize>: Send + Sync {
    /// Signed Euclidean distance from `x` to the boundary, negative inside.
    fn distance(&self, x: &Point<D>) -> f64;
    /// Lower and upper corner of the smallest axis-aligned box around the shape.
    fn bounds(&self) -> (Point<D>, Point<D>);
}

/// The signed distance of `shape` at the nodes of `space`. Multiply by the initial stretch to get
/// the initial `phi`.
pub fn signed_distance<const D: usize>(space: &Space<D>, shape: &dyn Shape<D>) -> Vec<f64> {
    let mut phi = vec![0.0; space.len()];
    parallel::fill(&mut phi, 1, |first, part| {
        for (v, x) in part.iter_mut().zip(&space.nodes()[first..]) {
            *v = shape.distance(x);
        }
    });
    phi
}

/// Rejects a shape that is nearer than `margin` to the sides of the domain.
///
/// `bounds` are those of the shape, `domain` is the bounding box of the mesh, `margin` is usually
/// the half-width of the band: a band cut by a wall loses part of its weight.
///
/// # Errors
/// Names the side, the box of the shape and the distance by which it has to move or shrink.
pub fn check_inside<const D: usize>(
    bounds: (Point<D>, Point<D>),
    domain: (Point<D>, Point<D>),
    margin: f64,
) -> Result<()> {
    for axis in 0..D {
        let excess =
            [domain.0[axis] + margin - bounds.0[axis], bounds.1[axis] - domain.1[axis] + margin];
        for (side, excess) in ["lower", "upper"].into_iter().zip(excess) {
            if excess > 0.0 || excess.is_nan() {
                let name = ["x", "y", "z"][axis.min(2)];
                return Err(Error::scene("the shape does not lie inside the domain")
                    .at(format!("{side} side in {name}"))
                    .value(format!(
                        "the shape spans {name} = {} to {}, the domain {} to {}, and a margin of \
                         {margin} is kept free",
                        bounds.0[axis], bounds.1[axis], domain.0[axis], domain.1[axis]
                    ))
                    .remedy(format!("move or shrink the shape by {excess}, or enlarge the mesh")));
            }
        }
    }
    Ok(())
}

/// Rejects a point that is not finite.
pub(super) fn check_point<const D: usize>(what: &str, x: &Point<D>) -> Result<()> {
    if x.iter().all(|c| c.is_finite()) {
        return Ok(());
    }
    Err(Error::scene(format!("{what} must be finite numbers")).value(format!("{:?}", x.as_slice())))
}

/// Rejects lengths that are not positive and finite.
pub(super) fn check_lengths(what: &str, lengths: &[f64]) -> Result<()> {
    if lengths.iter().all(|&l| l > 0.0 && l.is_finite()) {
        return Ok(());
    }
    Err(Error::scene(format!("{what} must be positive"))
        .value(format!("{lengths:?}"))
        .remedy("give finite lengths > 0, in the units of the mesh"))
}

/// Rejects semi-axes that are not positive, or too different; `what` is the shape with its article.
pub(super) fn check_semi_axes<const D: usize>(what: &str, axes: &Point<D>) -> Result<()> {
    check_lengths(&format!("the semi-axes of {what}"), axes.as_slice())?;
    if axes.max() <= 1e6 * axes.min() {
        return Ok(());
    }
    Err(Error::scene(format!(
        "the semi-axes of {what} are too different: no mesh resolves its ends"
    ))
    .value(format!("{:?}", axes.as_slice())))
}

/// Position and orientation of a shape.
#[derive(Clone, Debug)]
pub(super) struct Placement<const D: usize> {
    centre: Point<D>,
    rotation: Rotation<f64, D>,
}

impl Placement<2> {
    /// `angle` in degrees, counterclockwise.
    pub(super) fn plane(centre: Point<2>, angle: f64) -> Result<Placement<2>> {
        let all = SVector::<f64, 3>::new(centre[0], centre[1], angle);
        check_point("the centre and the angle of a shape", &all)?;
        Ok(Placement { centre, rotation: Rotation::<f64, 2>::new(angle.to_radians()) })
    }
}

impl Placement<3> {
    /// `turn` is the axis of the rotation times its angle in degrees, by the right-hand rule.
    pub(super) fn space(centre: Point<3>, turn: SVector<f64, 3>) -> Result<Placement<3>> {
        check_point("the centre of a shape", &centre)?;
        check_point("the rotation of a shape", &turn)?;
        Ok(Placement { centre, rotation: Rotation::<f64, 3>::new(turn.map(f64::to_radians)) })
    }
}

impl<const D: usize> Placement<D> {
    /// Absolute values of the coordinates of `x` along the axes of the shape, which is symmetric in
    /// each of them.
    pub(super) fn orthant(&self, x: &Point<D>) -> Point<D> {
        self.rotation.matrix().tr_mul(&(x - self.centre)).abs()
    }
    /// The box around the set whose support function along its own axes is `support`.
    pub(super) fn bounds(&self, support: impl Fn(&Point<D>) -> f64) -> (Point<D>, Point<D>) {
        let half = Point::<D>::from_fn(|axis, _| {
            let axis = Point::<D>::from_fn(|i, _| if i == axis { 1.0 } else { 0.0 });
            support(&self.rotation.matrix().tr_mul(&axis).abs())
        });
        (self.centre - half, self.centre + half)
    }
}

/// A disc (2-D) or ball (3-D).
#[derive(Clone, Debug)]
pub struct Circle<const D: usize> {
    centre: Point<D>,
    radius: f64,
}

impl<const D: usize> Circle<D> {
    /// # Errors
    /// A centre that is not finite, a radius that is not positive.
    pub fn new(centre: Point<D>, radius: f64) -> Result<Circle<D>> {
        check_point("the centre of a circle", &centre)?;
        check_lengths("the radius of a circle", &[radius])?;
        Ok(Circle { centre, radius })
    }
}

impl<const D: usize> Shape<D> for Circle<D> {
    fn distance(&self, x: &Point<D>) -> f64 {
        (x - self.centre).norm() - self.radius
    }
    fn bounds(&self) -> (Point<D>, Point<D>) {
        (self.centre.add_scalar(-self.radius), self.centre.add_scalar(self.radius))
    }
}

/// A rectangle or block with corners and edges rounded by arcs and parts of spheres.
#[derive(Clone, Debug)]
pub struct RoundedBox<const D: usize> {
    placement: Placement<D>,
    half_size: Point<D>,
    radius: f64,
}

impl RoundedBox<2> {
    /// `half_size` is half the width and height including the rounding, `radius` that of the
    /// corners (0: sharp), `angle` in degrees, counterclockwise.
    ///
    /// # Errors
    /// Sizes that are not positive, a radius that is negative or larger than the smaller half size.
    pub fn new(
        centre: Point<2>,
        half_size: Point<2>,
        radius: f64,
        angle: f64,
    ) -> Result<RoundedBox<2>> {
        check_rounding(["rounded box", "corner", "smaller"], &half_size, radius)?;
        Ok(RoundedBox { placement: Placement::plane(centre, angle)?, half_size, radius })
    }
}

impl RoundedBox<3> {
    /// `half_size` is half the three sides including the rounding, `radius` that of the edges (0:
    /// sharp), `turn` the axis of the rotation times its angle in degrees (right-hand rule; zero:
    /// none).
    ///
    /// # Errors
    /// Sizes that are not positive, a radius that is negative or larger than the smallest half
    /// size.
    pub fn turned(
        centre: Point<3>,
        half_size: Point<3>,
        radius: f64,
        turn: SVector<f64, 3>,
    ) -> Result<RoundedBox<3>> {
        check_rounding(["rounded block", "edge", "smallest"], &half_size, radius)?;
        Ok(RoundedBox { placement: Placement::space(centre, turn)?, half_size, radius })
    }
}

/// Refuses half sizes that are not positive, and a radius of rounding that does not fit into them;
/// the words name the shape, its rounded part and its decisive half size.
fn check_rounding<const D: usize>(
    [what, part, least]: [&str; 3],
    half_size: &Point<D>,
    radius: f64,
) -> Result<()> {
    check_lengths(&format!("the half sizes of a {what}"), half_size.as_slice())?;
    if radius >= 0.0 && radius <= half_size.min() {
        return Ok(());
    }
    Err(Error::scene(format!(
        "the {part} radius of a {what} must lie between 0 and its {least} half size"
    ))
    .value(radius)
    .remedy(format!("give a radius in [0, {}]", half_size.min())))
}

impl<const D: usize> Shape<D> for RoundedBox<D> {
    fn distance(&self, x: &Point<D>) -> f64 {
        let q = self.placement.orthant(x) - self.half_size.add_scalar(-self.radius);
        q.sup(&Point::<D>::zeros()).norm() + q.max().min(0.0) - self.radius
    }
    fn bounds(&self) -> (Point<D>, Point<D>) {
        let core = self.half_size.add_scalar(-self.radius);
        self.placement.bounds(|axis| core.dot(axis) + self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation2;
    use proptest::prelude::*;

    fn p(x: f64, y: f64) -> Point<2> {
        Point::<2>::new(x, y)
    }

    #[test]
    fn wrong_sizes_are_refused_with_the_value() {
        assert!(Circle::new(p(0.0, 0.0), 0.0).unwrap_err().to_string().contains("positive"));
        assert!(Circle::new(p(f64::NAN, 0.0), 1.0).unwrap_err().to_string().contains("NaN"));
        assert!(
            RoundedBox::new(p(0.0, 0.0), p(1.0, 0.5), 0.6, 0.0)
                .unwrap_err()
                .to_string()
                .contains("[0, 0.5]")
        );
        assert!(RoundedBox::new(p(0.0, 0.0), p(1.0, -0.5), 0.0, 0.0).is_err());
        assert!(RoundedBox::new(p(0.0, 0.0), p(1.0, 0.5), 0.0, f64::INFINITY).is_err());
    }

    #[test]
    fn a_shape_near_a_wall_is_refused_with_the_side_and_the_excess() {
        let domain = (p(0.0, 0.0), p(2.0, 1.0));
        let shape = Circle::new(p(1.0, 0.5), 0.375).unwrap();
        assert!(check_inside(shape.bounds(), domain, 0.125).is_ok());
        let text = check_inside(shape.bounds(), domain, 0.25).unwrap_err().to_string();
        assert!(text.contains("in y") && text.contains("0.125"), "{text}");
        assert!(check_inside((p(f64::NAN, 0.0), p(1.0, 1.0)), domain, 0.0).is_err());
    }

    #[test]
    fn a_sphere_in_space() {
        let ball = Circle::<3>::new(Point::<3>::new(0.0, 0.0, 1.0), 2.0).unwrap();
        assert_eq!(ball.distance(&Point::<3>::new(2.0, 2.0, 0.0)), 1.0);
        assert_eq!(ball.bounds().0, Point::<3>::new(-2.0, -2.0, -1.0));
    }

    #[test]
    fn a_block_has_the_distances_of_its_faces_edges_and_corners() {
        let p = Point::<3>::new;
        let o = p(0.0, 0.0, 0.0);
        assert!(
            RoundedBox::turned(o, p(1.0, 0.5, 2.0), 0.6, o)
                .unwrap_err()
                .to_string()
                .contains("[0, 0.5]")
        );
        assert!(RoundedBox::turned(o, p(1.0, -0.5, 1.0), 0.0, o).is_err());
        let e = RoundedBox::turned(o, p(1.0, 0.5, 2.0), 0.0, p(f64::NAN, 0.0, 0.0)).unwrap_err();
        assert!(e.to_string().contains("rotation"));
        let block = RoundedBox::turned(p(1.0, 0.0, 0.0), p(1.0, 0.5, 2.0), 0.25, o).unwrap();
        for (x, d) in [
            (p(1.0, 0.0, 0.0), -0.5),
            (p(1.0, 0.0, 2.5), 0.5),
            (p(1.0, 1.25, 2.75), 2f64.sqrt() - 0.25),
            (p(2.75, 1.25, -2.75), 3f64.sqrt() - 0.25),
        ] {
            assert!((block.distance(&x) - d).abs() < 1e-15, "{x} {d}");
        }
        // A quarter turn about z exchanges the sides.
        let turned = RoundedBox::turned(o, p(1.0, 0.5, 2.0), 0.25, p(0.0, 0.0, 90.0)).unwrap();
        assert!((turned.bounds().1 - p(0.5, 1.0, 2.0)).norm() < 1e-15);
        assert!((turned.distance(&p(0.0, 1.5, 0.0)) - 0.5).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn a_box_agrees_with_its_sampled_boundary(
            x in -2.0..2.0f64, y in -2.0..2.0f64, hx in 0.2..1.0f64, hy in 0.2..1.0f64, r in 0.0..1.0f64, angle in -180.0..180.0f64,
        ) {
            let radius = r * hx.min(hy);
            let shape = RoundedBox::new(p(0.1, -0.2), p(hx, hy), radius, angle).unwrap();
            let (core, turn) = (p(hx - radius, hy - radius), Rotation2::new(angle.to_radians()));
            let (n, mut nearest) = (4000, f64::INFINITY);
            let mut see = |q: Point<2>| nearest = nearest.min((turn * q + p(0.1, -0.2) - p(x, y)).norm());
            for k in 0..=n {
                let s = 2.0 * k as f64 / n as f64 - 1.0;
                let a = s * std::f64::consts::PI;
                for sign in [1.0, -1.0] {
                    see(p(s * core[0], sign * hy));
                    see(p(sign * hx, s * core[1]));
                }
                see(p(a.cos().signum() * core[0] + radius * a.cos(), a.sin().signum() * core[1] + radius * a.sin()));
            }
            prop_assert!((shape.distance(&p(x, y)).abs() - nearest).abs() < 2e-3);
            let far = shape.bounds();
            prop_assert!(shape.distance(&p(far.1[0] + 0.1, 0.0)) > 0.0);
            prop_assert!(shape.distance(&p(0.1, -0.2)) < 0.0);
        }

        #[test]
        fn the_bounds_of_a_box_touch_it(hx in 0.2..1.0f64, hy in 0.2..1.0f64, r in 0.0..1.0f64, angle in -180.0..180.0f64) {
            let shape = RoundedBox::new(p(0.0, 0.0), p(hx, hy), r * hx.min(hy), angle).unwrap();
            let half = shape.bounds().1;
            // The distance from a far point on the axis to the supporting line is the smallest
            // along that line.
            for axis in 0..2 {
                let nearest = (0..4000)
                    .map(|k| {
                        let mut q = p(0.0, 0.0);
                        q[axis] = half[axis];
                        q[1 - axis] = 3.0 * (k as f64 / 2000.0 - 1.0);
                        shape.distance(&q)
                    })
                    .fold(f64::INFINITY, f64::min);
                prop_assert!((0.0..2e-3).contains(&(nearest + 1e-12)), "{nearest}");
            }
        }
    }
}
