//! Membranes that resist shear: their start from a scene.

use super::Scene;
use super::dimension::{Dimension, In, coordinates};
use super::expression::Expression;
use super::model::{Draft, band_of};
use super::schema::Membrane;
use crate::base::{Error, Result};
use crate::elastic::{RestMap, ShearMembrane, SurfaceLaw, SurfaceStrain};
use crate::fem::Space;
use crate::mesh::Point;
use crate::sim::InitialFunction;
use crate::transport::Method;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

impl<const D: usize> Draft<'_, D>
where
    In<D>: Dimension<D>,
{
    /// The membrane that resists shear which a scene describes, on a band of half-width `eps`.
    pub(super) fn sheared(&self, m: &Membrane, law: SurfaceLaw, eps: f64) -> ShearMembrane<D> {
        let membrane = ShearMembrane::new(law, eps, m.stretch)
            .with_band(band_of(self.scene, m), m.stretch)
            .with_kernel(self.scene.numerics.kernel, self.scene.numerics.width)
            .with_area_from(m.area_from);
        if m.map.is_empty() { membrane } else { membrane.with_map(rest_map(&m.map)) }
    }
    /// The level set at time 0 of a membrane whose distance is `distance`: times the area stretch at the start, so that its slope on the
    /// membrane is `Z1`.
    pub(super) fn level_set_of(&self, m: &Membrane, distance: Arc<InitialFunction<D>>) -> Arc<InitialFunction<D>> {
        let stretch = m.stretch;
        if m.map.is_empty() {
            return Arc::new(move |x: &Point<D>| stretch * distance(x));
        }
        let (map, (low, high)) = (m.map.clone(), self.mesh.bounding_box());
        let h = 1e-6 * (high - low).norm();
        Arc::new(move |x: &Point<D>| {
            let along = |k: usize| {
                let mut step = Point::<D>::zeros();
                step[k] = h;
                distance(&(x + step)) - distance(&(x - step))
            };
            let gradient = SVector::<f64, D>::from_fn(|k, _| along(k));
            let grad_y = SMatrix::<f64, D, D>::from_fn(|i, j| map[i].eval_with_gradient(coordinates(x), 0.0).1[j]);
            let area = SurfaceStrain::new(&gradient.normalize(), &grad_y, stretch).z1;
            // In the middle of a shape its distance has no gradient.
            distance(x) * if area.is_finite() { area } else { stretch }
        })
    }
}

/// Refuses a map to the place at rest that has no finite value at a node, or no area or a mirrored one, or a hundred times as much or as little, where the
/// membrane `m` with the distances `distance` may be: within `eps` and on the cells that it cuts.
pub(super) fn check_rest_map<const D: usize>(
    scene: &Scene,
    (k, m): (usize, &Membrane),
    space: &Space<D>,
    phi: &[f64],
    distance: &[f64],
    eps: f64,
) -> Result<()> {
    if m.map.is_empty() {
        return Ok(());
    }
    let map = rest_map::<D>(&m.map);
    for (n, x) in space.nodes().iter().enumerate() {
        let (y, near) = (map(x), distance[n].abs() <= eps);
        let ratio = phi[n] / distance[n];
        let wrong_area = near && distance[n] != 0.0 && !(m.stretch / MOST..=m.stretch * MOST).contains(&ratio);
        if !y.iter().all(|v| v.is_finite()) || wrong_area {
            let what = match wrong_area {
                true => "the map to the place at rest has no area along the membrane, or too much",
                false => "the map to the place at rest has no finite value everywhere",
            };
            let e = Error::scene(what)
                .value(format!("{:?} at {:.4?}, area over that at rest {ratio:.3e}", y.as_slice(), x.as_slice()))
                .remedy("write a map that is finite on the whole mesh and keeps points of the membrane apart");
            return Err(scene.blame(&["membrane", &k.to_string(), "map"], e));
        }
    }
    Ok(())
}

/// The largest area over that at rest, and the inverse of the least, that a map may give.
const MOST: f64 = 100.0;

fn rest_map<const D: usize>(map: &[Expression]) -> Arc<RestMap<D>> {
    let map = map.to_vec();
    Arc::new(move |x: &Point<D>| Point::<D>::from_fn(|i, _| map[i].eval(coordinates(x), 0.0)))
}

/// Refuses what backward characteristics cannot have: a map to the place at rest, a level set taken from the map and composed
/// transport where particles pass periodic sides.
pub(super) fn check_map(scene: &Scene, periodic: bool) -> Result<()> {
    let refuse = |k: usize, key: &str, what: &str| {
        let e = Error::scene(format!("{what} cannot be had where particles pass periodic sides"))
            .remedy("give walls or prescribed velocities in place of periodic sides, or leave it out");
        Err(scene.blame(&["membrane", &k.to_string(), key], e))
    };
    let composed = scene.numerics.transport == Method::Composed;
    if scene.output.backward_map && composed && (periodic || scene.interfaces().next().is_none()) {
        let what = "composed transport tells the backward characteristics of a scene with interfaces and without periodic sides";
        let e = Error::scene(what).value("backward_map = true").remedy("take numerics.transport = \"nodal\"");
        return Err(scene.blame(&["output", "backward_map"], e));
    }
    for (k, m) in scene.membranes.iter().enumerate().filter(|_| periodic) {
        if !m.map.is_empty() {
            return refuse(k, "map", "a map to the place at rest");
        }
        if m.mapped {
            return refuse(k, "level_set", "a level set taken from the map");
        }
        if m.surface.is_some() && composed {
            return refuse(k, "shear", "shear with composed transport");
        }
    }
    Ok(())
}
