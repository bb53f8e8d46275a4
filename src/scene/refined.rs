//! Refinement of a mesh file, with the boundary projected onto the curves given in the scene.

use super::script::Script;
use super::shapes::shape;
use crate::base::{Error, Result};
use crate::levelset::Shape;
use crate::mesh::{Mesh, Point, refine};

/// Number of projection steps onto the boundary of a shape; the first one is exact up to the
/// rounding error of its gradient.
const STEPS: usize = 3;
/// Largest distance of a boundary point from its shape, as a fraction of its facet; beyond it the
/// shape does not describe the boundary.
const OFF: f64 = 0.05;

/// The mesh refined `times` times, with new points of the boundaries in `geometry` projected onto
/// their shapes.
///
/// # Errors
/// A boundary that the mesh does not have or that does not lie on its shape; an inverted cell.
pub(super) fn refined<const D: usize>(
    script: &Script,
    mesh: Mesh<D>,
    times: usize,
    geometry: &[(String, super::schema::Shape)],
) -> Result<Mesh<D>> {
    let mut curves: Vec<(&str, Box<dyn Shape<D>>)> = Vec::new();
    let (low, high) = mesh.bounding_box();
    let room = (high - low) * 0.05;
    for (name, curve) in geometry {
        let place = |e| script.blame(&["mesh", "geometry", name], e);
        let curve = shape(curve, (low - room, high + room)).map_err(place)?;
        check_lies_on(&mesh, name, curve.as_ref()).map_err(place)?;
        curves.push((name, curve));
    }
    let onto = |name: &str, x: &Point<D>| {
        curves.iter().find(|c| c.0 == name).map(|(_, curve)| nearest(curve.as_ref(), *x))
    };
    (0..times)
        .try_fold(mesh, |mesh, _| refine(&mesh, onto))
        .map_err(|e| script.blame(&["mesh", "refine"], e))
}

fn check_lies_on<const D: usize>(mesh: &Mesh<D>, name: &str, curve: &dyn Shape<D>) -> Result<()> {
    for &f in mesh.boundary(name)? {
        let facet = &mesh.facets()[f as usize];
        let (_, size) = mesh.facet_normal(facet);
        let length = size.powf(1.0 / (D as f64 - 1.0));
        for v in mesh.facet_points(facet) {
            let x = &mesh.points()[v as usize];
            let off = curve.distance(x).abs();
            if off > OFF * length {
                return Err(Error::scene(format!(
                    "the boundary `{name}` does not lie on the curve that the scene gives it"
                ))
                .value(format!("the point {:?} is {off:.3e} away from it", x.as_slice()))
                .remedy(
                    "give the curve that the mesh was made from, or leave it out: straight parts \
                     need none",
                ));
            }
        }
    }
    Ok(())
}

/// The boundary point of a shape nearest to `x`, which is close to it: along the gradient of the
/// distance.
fn nearest<const D: usize>(curve: &dyn Shape<D>, mut x: Point<D>) -> Point<D> {
    let h = 1e-5 * curve.bounds().1.metric_distance(&curve.bounds().0);
    for _ in 0..STEPS {
        let along = |d: Point<D>| (curve.distance(&(x + d)) - curve.distance(&(x - d))) / (2.0 * h);
        let axis = |i: usize| Point::<D>::from_fn(|k, _| if k == i { h } else { 0.0 });
        let gradient = Point::<D>::from_fn(|i, _| along(axis(i)));
        let length = gradient.norm_squared();
        if length > 0.25 {
            x -= gradient * (curve.distance(&x) / length);
        }
    }
    x
}
