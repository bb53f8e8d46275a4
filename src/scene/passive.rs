//! Level sets that act on nothing: their start, their markers, and scenes whose velocity is prescribed.

use super::Scene;
use super::adapt::Lengths;
use super::dimension::{Dimension, In};
use super::model::{Draft, Model, vector, wall_nodes};
use super::redistance::redistance;
use super::schema::Condition;
use crate::base::{Error, Result, Warning};
use crate::fem::{Conditions, Translation, image_shifts};
use crate::levelset::{check_inside, signed_distance};
use crate::mesh::{self, Mesh, Point};
use crate::sim::{InitialFunction, LevelSet, Simulation};
use crate::transport::Method;
use std::sync::Arc;

/// Times at which a velocity that depends on time is looked at before it is used.
const SAMPLES: usize = 16;
/// A normal velocity below this part of the largest speed is rounding, such as that of sin(pi).
const ROUNDING: f64 = 1e-9;

/// The signed distance of a shape at time 0.
pub(super) struct Placed<const D: usize> {
    /// At the nodes.
    pub nodal: Vec<f64>,
    /// Everywhere.
    pub function: Arc<InitialFunction<D>>,
}

impl<const D: usize> Draft<'_, D>
where
    In<D>: Dimension<D>,
{
    /// The signed distance of the shape written at `keys`.
    pub(super) fn placed(&self, shape: &super::schema::Shape, keys: &[&str]) -> Result<Placed<D>> {
        let domain = self.mesh.bounding_box();
        let place = |e| self.scene.blame(keys, e);
        let open = matches!(shape, super::schema::Shape::Expression(_));
        let shape = In::<D>::shape(shape, domain).map_err(place)?;
        let (mut low, mut high) = shape.bounds();
        // Through a periodic side it goes on at the other one.
        for axis in (0..D).filter(|&axis| self.pairs.iter().any(|p| p.shift[axis] != 0.0)) {
            (low[axis], high[axis]) = (low[axis].max(domain.0[axis]), high[axis].min(domain.1[axis]));
        }
        // What acts on nothing may end on walls, if it is described by a function, which goes on beyond them.
        let may_end = keys.first() == Some(&"level_set") && open;
        if !may_end {
            check_inside((low, high), domain, 0.0).map_err(place)?;
        }
        let shifts = image_shifts(&self.pairs);
        let nodal = self.with_images(signed_distance(self.space, shape.as_ref()), shape.as_ref(), &shifts);
        let nearest = move |x: &Point<D>| nearest_image(shifts.iter().map(|s| shape.distance(&(x + s))));
        Ok(Placed { nodal, function: Arc::new(nearest) })
    }

    /// All passive level sets at time 0.
    pub(super) fn level_sets(&self) -> Result<Vec<LevelSet<D>>> {
        let mut all = Vec::new();
        for (k, s) in self.scene.level_sets.iter().enumerate() {
            let k = k.to_string();
            let Placed { nodal, function } = self.placed(&s.shape, &["level_set", &k, "shape"])?;
            if In::<D>::surface(self.space, &nodal)?.is_empty() {
                let e = Error::scene("no part of the interface lies on the mesh")
                    .remedy("move the shape, or refine the mesh");
                return Err(self.scene.blame(&["level_set", &k, "shape"], e));
            }
            let markers = match s.markers {
                0 => Vec::new(),
                count => self
                    .markers(&nodal, &*function, count)
                    .map_err(|e| self.scene.blame(&["level_set", &k, "markers"], e))?,
            };
            all.push(LevelSet { name: s.name.clone(), phi: nodal, function: Some(function), markers });
        }
        Ok(all)
    }

    /// Points on an interface, which no periodic side may interrupt.
    fn markers(&self, phi: &[f64], distance: &InitialFunction<D>, count: usize) -> Result<Vec<Point<D>>> {
        if !self.pairs.is_empty() {
            return Err(Error::scene("markers do not pass through periodic sides")
                .value(count)
                .remedy("leave them out, or give walls to the mesh"));
        }
        In::<D>::markers(self.space, phi, distance, count)
    }
}

/// The signed distance to a shape and its images, from the distances to each: that of their union. Where all are negative the shape is the same in all
/// images, the half under a wave for example, and the nearest counts.
pub(super) fn nearest_image(distances: impl Iterator<Item = f64>) -> f64 {
    let (least, greatest) = distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, g), d| (l.min(d), g.max(d)));
    if greatest < 0.0 { greatest } else { least }
}

/// Builds the model of a scene with a prescribed velocity.
///
/// # Errors
/// A velocity that has no finite value somewhere; as for the level sets.
pub(super) fn prescribed<const D: usize>(
    scene: &Scene,
    draft: Draft<'_, D>,
    conditions: Conditions<D>,
    quality: mesh::Quality<D>,
    lengths: Option<Lengths>,
) -> Result<Model<D>>
where
    In<D>: Dimension<D>,
{
    let Some(velocity) = &scene.fluid.prescribed_velocity else {
        return Err(Error::internal("no velocity is prescribed"));
    };
    draft.check_finite("prescribed_velocity", velocity)?;
    let (level_sets, settings) = (draft.level_sets()?, draft.settings(conditions, 0.0));
    let wall_nodes = wall_nodes(draft.space, &draft.pairs);
    let velocity = Arc::new(vector(velocity));
    let mut simulation = Simulation::prescribed(draft.mesh, settings, velocity, level_sets)?;
    simulation.compose(Vec::new(), scene.numerics.remap);
    redistance(scene, &mut simulation);
    if scene.output.backward_map {
        simulation.carry_backward_map();
    }
    Ok(Model {
        simulation,
        warnings: draft.warnings,
        explicit_limit: None,
        band_edges: None,
        thickness: None,
        velocity_scale: None,
        quality,
        wall_nodes,
        lengths,
    })
}

/// Refuses composed transport where fluid may come in: a particle that was outside at time 0 has no value there. Warns of
/// projected transport there, which amplifies what the characteristics bring in from the boundary.
pub(super) fn check_inflow<const D: usize>(
    scene: &Scene,
    mesh: &Mesh<D>,
    pairs: &[Translation<D>],
) -> Result<Option<Warning>> {
    let carried = scene.interfaces().next().is_some();
    if !carried || scene.numerics.transport == Method::Nodal {
        return Ok(None);
    }
    let Some(side) = inflow(scene, mesh, pairs) else { return Ok(None) };
    if scene.numerics.transport == Method::Composed {
        let e =
            Error::scene(format!("composed transport cannot be used where fluid comes in, as it may through {side}"))
                .value("transport = \"composed\"")
                .remedy("use transport = \"nodal\": a particle that was outside at time 0 has no value to bring along");
        return Err(scene.blame(&["numerics", "transport"], e));
    }
    let what = format!("projected transport is unstable where fluid comes in, as it may through {side}");
    Ok(Some(Warning::new(what, "use transport = \"nodal\" unless that side only moves along itself")))
}

/// A part of the boundary through which fluid may come in.
fn inflow<const D: usize>(scene: &Scene, mesh: &Mesh<D>, pairs: &[Translation<D>]) -> Option<String> {
    let enters = |facets: &[u32], v: &[super::Expression]| {
        let v = vector(v);
        let times = |k: usize| scene.time.end * k as f64 / (SAMPLES - 1) as f64;
        let mut fastest: f64 = 0.0;
        let mut inward: f64 = 0.0;
        for &f in facets {
            let facet = &mesh.facets()[f as usize];
            let (n, _) = mesh.facet_normal(facet);
            let ends: Vec<Point<D>> = mesh.facet_points(facet).map(|p| mesh.points()[p as usize]).collect();
            let middle = ends.iter().fold(Point::<D>::zeros(), |s, x| s + x) / ends.len() as f64;
            for x in ends.iter().chain([&middle]) {
                for u in (0..SAMPLES).map(|k| v(x, times(k))) {
                    fastest = fastest.max(u.norm());
                    inward = inward.max(-u.dot(&n));
                }
            }
        }
        inward > ROUNDING * fastest
    };
    if let Some(v) = &scene.fluid.prescribed_velocity {
        let mut wall = vec![true; mesh.facets().len()];
        pairs.iter().for_each(|p| wall[p.facet as usize] = false);
        let facets: Vec<u32> = (0..mesh.facets().len() as u32).filter(|&f| wall[f as usize]).collect();
        return enters(&facets, v).then(|| "the boundary of the mesh".to_string());
    }
    let lets_in = |b: &&super::schema::Boundary| match (&b.condition, mesh.boundary(&b.name)) {
        (Condition::Open, _) => true,
        (Condition::Velocity(v), Ok(facets)) => enters(facets, v),
        _ => false,
    };
    scene.boundaries.iter().find(lets_in).map(|b| format!("boundary `{}`", b.name))
}
