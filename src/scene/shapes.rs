//! Shapes of a scene as signed distances.

use super::keys::Tabled;
use super::points::{coordinates, point};
use super::schema::{Oval, OvalCurve, Shape};
use crate::base::{Error, Result, same};
use crate::levelset::{
    Circle, Ellipse, Ellipsoid, LevelFunction, LevelSolid, Polygon, RoundedBox, Shape as Distance,
    SolidUnion, Torus, Union, reduced_cassini, reduced_ellipse, reduced_spheroid,
};
use crate::mesh::Point;

/// The shape described by a scene in `D` dimensions; `domain` is the bounding box of the mesh.
///
/// # Errors
/// A degenerate shape, or one for another dimension.
pub(super) fn shape<const D: usize>(
    shape: &Shape,
    domain: (Point<D>, Point<D>),
) -> Result<Box<dyn Distance<D>>> {
    let found = match (same(domain), same(domain)) {
        (Some(domain), _) => same(plane(shape, domain)?),
        (_, Some(domain)) => same(solid(shape, domain)?),
        _ => None,
    };
    found.ok_or_else(|| other_dimension(shape, D))
}

/// The error for a shape of another dimension.
fn other_dimension(shape: &Shape, dimension: usize) -> Error {
    let what = format!("the shape does not belong into {dimension} dimensions");
    Error::scene(what).value(shape.inline())
}

/// A shape of the plane.
fn plane(shape: &Shape, domain: (Point<2>, Point<2>)) -> Result<Box<dyn Distance<2>>> {
    Ok(match shape {
        Shape::Circle(s) => Box::new(Circle::new(point(&s.centre), s.radius)?),
        Shape::Ellipse(s) => {
            Box::new(Ellipse::new(point(&s.centre), point(&s.semi_axes), s.angle)?)
        }
        Shape::Oval(s) => oval(s, domain)?,
        Shape::RoundedBox(s) => {
            Box::new(RoundedBox::new(point(&s.centre), point(&s.half_size), s.radius, s.angle)?)
        }
        Shape::Polygon(s) => Box::new(Polygon::new(s.points.iter().map(|p| point(p)).collect())?),
        Shape::Union(parts) => {
            let parts = parts.iter().map(|p| plane(p, domain)).collect::<Result<_>>()?;
            Box::new(Union::new(parts)?)
        }
        Shape::Expression(e) => {
            let e = e.clone();
            Box::new(LevelFunction::new(move |x: &Point<2>| e.eval(coordinates(x), 0.0), domain)?)
        }
        Shape::Sphere(_) | Shape::Ellipsoid(_) | Shape::Spheroid(_) | Shape::Torus(_) => {
            return Err(other_dimension(shape, 2));
        }
    })
}

/// An oval of its radius and reduced area.
fn oval(s: &Oval, domain: (Point<2>, Point<2>)) -> Result<Box<dyn Distance<2>>> {
    if s.curve == OvalCurve::Ellipse {
        let axes = reduced_ellipse(s.reduced_area).map(|a| a * s.radius);
        return Ok(Box::new(Ellipse::new(point(&s.centre), point(&axes), s.angle)?));
    }
    let [focus, size] = reduced_cassini(s.reduced_area).map(|a| a * s.radius);
    let (centre, (sine, cosine)) = (point::<2>(&s.centre), s.angle.to_radians().sin_cos());
    let focus = Point::<2>::new(cosine, sine) * focus;
    let level = move |x: &Point<2>| {
        let d = x - centre;
        ((d - focus).norm() * (d + focus).norm()).sqrt() - size
    };
    Ok(Box::new(LevelFunction::new(level, domain)?))
}

/// A shape in space.
fn solid(shape: &Shape, domain: (Point<3>, Point<3>)) -> Result<Box<dyn Distance<3>>> {
    Ok(match shape {
        Shape::Sphere(s) => Box::new(Circle::<3>::new(point(&s.centre), s.radius)?),
        Shape::Ellipsoid(s) => {
            Box::new(Ellipsoid::new(point(&s.centre), point(&s.semi_axes), point(&s.rotation))?)
        }
        Shape::Spheroid(s) => {
            let [along, across] = reduced_spheroid(s.reduced_volume, s.oblate);
            let axes = [across, across, along].map(|a| a * s.radius);
            Box::new(Ellipsoid::new(point(&s.centre), point(&axes), point(&s.rotation))?)
        }
        Shape::Torus(s) => {
            Box::new(Torus::new(point(&s.centre), point(&s.axis), s.major, s.minor)?)
        }
        Shape::RoundedBox(s) => Box::new(RoundedBox::turned(
            point(&s.centre),
            point(&s.half_size),
            s.radius,
            point(&s.rotation),
        )?),
        Shape::Union(parts) => {
            let parts = parts.iter().map(|p| solid(p, domain)).collect::<Result<_>>()?;
            Box::new(SolidUnion::new(parts)?)
        }
        Shape::Expression(e) => {
            let e = e.clone();
            Box::new(LevelSolid::new(move |x: &Point<3>| e.eval(coordinates(x), 0.0), domain)?)
        }
        Shape::Circle(_) | Shape::Ellipse(_) | Shape::Oval(_) | Shape::Polygon(_) => {
            return Err(other_dimension(shape, 3));
        }
    })
}
