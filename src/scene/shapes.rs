//! Shapes of a scene as signed distances.

use super::points::{coordinates, point};
use super::schema::Shape;
use crate::base::{Error, Result, same};
use crate::levelset::{
    Circle, Ellipse, Ellipsoid, LevelFunction, LevelSolid, Polygon, RoundedBox, Shape as Distance,
    SolidUnion, Torus, Union,
};
use crate::mesh::Point;

/// The shape that a scene describes in `D` dimensions; `domain` is the bounding box of the mesh.
///
/// # Errors
/// One that cannot be, or that belongs to another number of dimensions.
pub(super) fn shape<const D: usize>(shape: &Shape, domain: (Point<D>, Point<D>)) -> Result<Box<dyn Distance<D>>> {
    let found = match (same(domain), same(domain)) {
        (Some(domain), _) => same(plane(shape, domain)?),
        (_, Some(domain)) => same(solid(shape, domain)?),
        _ => None,
    };
    found.ok_or_else(|| other_dimension(shape, D))
}

/// The error for a shape that belongs to another number of dimensions.
fn other_dimension(shape: &Shape, dimension: usize) -> Error {
    let what = format!("the shape does not belong into {dimension} dimensions");
    Error::scene(what).value(shape.write())
}

/// A shape of the plane.
fn plane(shape: &Shape, domain: (Point<2>, Point<2>)) -> Result<Box<dyn Distance<2>>> {
    Ok(match shape {
        Shape::Circle { centre, radius } => Box::new(Circle::new(point(centre), *radius)?),
        Shape::Ellipse { centre, semi_axes, angle } => Box::new(Ellipse::new(point(centre), point(semi_axes), *angle)?),
        Shape::RoundedBox { centre, half_size, radius, angle } => {
            Box::new(RoundedBox::new(point(centre), point(half_size), *radius, *angle)?)
        }
        Shape::Polygon(points) => Box::new(Polygon::new(points.iter().map(|p| point(p)).collect())?),
        Shape::Union(parts) => {
            let parts = parts.iter().map(|p| plane(p, domain)).collect::<Result<_>>()?;
            Box::new(Union::new(parts)?)
        }
        Shape::Expression(e) => {
            let e = e.clone();
            Box::new(LevelFunction::new(move |x: &Point<2>| e.eval(coordinates(x), 0.0), domain)?)
        }
        Shape::Sphere { .. } | Shape::Ellipsoid { .. } | Shape::Torus { .. } | Shape::RoundedBlock { .. } => {
            return Err(other_dimension(shape, 2));
        }
    })
}

/// A shape in space.
fn solid(shape: &Shape, domain: (Point<3>, Point<3>)) -> Result<Box<dyn Distance<3>>> {
    Ok(match shape {
        Shape::Sphere { centre, radius } => Box::new(Circle::<3>::new(point(centre), *radius)?),
        Shape::Ellipsoid { centre, semi_axes, rotation } => {
            Box::new(Ellipsoid::new(point(centre), point(semi_axes), point(rotation))?)
        }
        Shape::Torus { centre, axis, major, minor } => {
            Box::new(Torus::new(point(centre), point(axis), *major, *minor)?)
        }
        Shape::RoundedBlock { centre, half_size, radius, rotation } => {
            Box::new(RoundedBox::turned(point(centre), point(half_size), *radius, point(rotation))?)
        }
        Shape::Union(parts) => {
            let parts = parts.iter().map(|p| solid(p, domain)).collect::<Result<_>>()?;
            Box::new(SolidUnion::new(parts)?)
        }
        Shape::Expression(e) => {
            let e = e.clone();
            Box::new(LevelSolid::new(move |x: &Point<3>| e.eval(coordinates(x), 0.0), domain)?)
        }
        Shape::Circle { .. } | Shape::Ellipse { .. } | Shape::RoundedBox { .. } | Shape::Polygon(_) => {
            return Err(other_dimension(shape, 3));
        }
    })
}
