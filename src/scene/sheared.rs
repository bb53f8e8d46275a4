//! Membranes that resist shear: their start from a scene.

use super::Scene;
use super::dimension::{Dimension, In, coordinates};
use super::expression::Expression;
use super::model::{Draft, band_of};
use super::schema::Membrane;
use crate::base::{Error, Result};
use crate::elastic::{RestMap, ShearMembrane, SurfaceLaw, SurfaceStrain};
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
    for (k, m) in scene.membranes.iter().enumerate().filter(|_| periodic) {
        if !m.map.is_empty() {
            return refuse(k, "map", "a map to the place at rest");
        }
        if m.mapped {
            return refuse(k, "level_set", "a level set taken from the map");
        }
        if m.surface.is_some() && scene.numerics.transport == Method::Composed {
            return refuse(k, "shear", "shear with composed transport");
        }
    }
    Ok(())
}
