//! Scales of a flow by its scene: velocity, grad-div weight, least energy.

use crate::scene::schema::Condition;
use crate::scene::sides::spread;
use crate::scene::site::{Site, vector};
use crate::scene::structures::Traits;
use crate::scene::{Expression, Scene};
use nalgebra::SVector;
use std::f64::consts::PI;

/// Default weight of the grad-div term over `rho U L`: for a flow with a membrane, to which
/// divergence errors add energy, and for a flow alone, where a larger weight reduces the accuracy
/// (driven cavity on 32 x 32, error of u_min: 6e-3 with a weight of 5, 2e-4 with 0.1).
const GRAD_DIV: [f64; 2] = [5.0, 0.1];
/// Default weight with a sharp membrane: the spurious currents around a drop at rest are inversely
/// proportional to it (n = 30: 9e-3 at 5, 9e-4 at 50).
const GRAD_DIV_SHARP: f64 = 50.0;
/// Default weight of the grad-div term over the viscosity in a flow without inertia: with a band,
/// and with a sharp membrane (lambda = 10, mu = 0.01, n = 20: 14 % spurious energy at 10, 2.8 % at
/// 500).
const GRAD_DIV_STOKES: [f64; 2] = [10.0, 500.0];
/// Rounding errors of energies, and errors of iterations, over the energies that could be in play.
const ROUNDING: f64 = 1e-10;
/// Strain of a membrane below which its energy is not judged.
const SMALL: f64 = 0.01;
/// Lengths of the domain that an error is carried before it has left or decayed.
const CROSSINGS: f64 = 2.0;
/// Number of times at which prescribed velocities are sampled for the velocity scale.
const SAMPLES: usize = 64;

/// Velocities that a scene gives: those of walls and inlets at some times, and the initial one.
#[derive(Clone, Copy)]
pub(super) struct Given {
    /// The largest speed.
    pub speed: f64,
    /// The largest difference of two of them at one time.
    pub difference: f64,
    /// The shorter side of the domain.
    pub side: f64,
}

/// The velocities that a scene gives; `initial` is that at time 0, at the nodes.
pub(super) fn given<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
    initial: &[SVector<f64, D>],
) -> Given {
    let mut speed = 0.0f64;
    // The least and the largest components at each time.
    let mut ranges = [None; SAMPLES];
    let mut see = |k: usize, u: SVector<f64, D>| {
        speed = speed.max(u.norm());
        let (low, high) = ranges[k].unwrap_or((u, u));
        ranges[k] = Some((low.inf(&u), high.sup(&u)));
    };
    initial.iter().take(site.mesh.points().len()).for_each(|u| see(0, *u));
    for b in &scene.boundaries {
        let v = match &b.condition {
            Condition::Velocity(v) => v.as_slice(),
            Condition::NoSlip => &[],
            _ => continue,
        };
        let (v, Ok(facets)) = (vector(v), site.mesh.boundary(&b.name)) else { continue };
        let nodes = |f: &u32| site.space.facet_nodes(&site.mesh.facets()[*f as usize]);
        for n in facets.iter().flat_map(|f| nodes(f).collect::<Vec<_>>()) {
            let x = &site.space.nodes()[n as usize];
            (0..SAMPLES).for_each(|k| see(k, v(x, scene.time.end * spread(k))));
        }
    }
    let differences = ranges.iter().flatten().map(|(low, high)| (high - low).norm());
    let difference = differences.fold(0.0, f64::max);
    Given { speed, difference, side: 2.0 * site.size() }
}

/// The time that an error of velocity stays: the whole run with structures, whose positions keep
/// it; in a flow alone that in which it is carried through the domain, at most the run.
pub(super) fn memory(scene: &Scene, [speed, length]: [f64; 2]) -> f64 {
    let alone = scene.structures().is_empty() && speed > 0.0;
    if alone { scene.time.end.min(CROSSINGS * length / speed) } else { scene.time.end }
}

/// Reynolds number `rho U L/mu` of the fluid outside; 0 without viscosity.
pub(super) fn reynolds(scene: &Scene, speed: f64, length: f64) -> f64 {
    let fluid = scene.outside();
    if fluid.viscosity > 0.0 { fluid.density * speed * length / fluid.viscosity } else { 0.0 }
}

/// The largest of the speeds due to walls, the initial state, gravity and the elastic waves of the
/// structures.
pub(super) fn velocity<const D: usize>(scene: &Scene, site: &Site<'_, D>, given: &Given) -> f64 {
    let (fluid, length) = (&scene.fluid, site.size());
    let (density, mut speed) = (heaviest(scene), given.speed);
    if density > 0.0 {
        for s in scene.acting() {
            speed = speed.max((s.traits().modulus / (density * length)).sqrt());
        }
        // A weight that is the same everywhere is held by the pressure, but at open sides.
        let drives = scene.fluids().any(|f| f.density != scene.outside().density)
            || scene.boundaries.iter().any(|b| b.condition.is_open());
        let gravity = SVector::<f64, D>::from_iterator(fluid.gravity.iter().copied()).norm();
        let gravity = if drives { gravity } else { 0.0 };
        speed = speed.max((gravity * length).sqrt());
        speed = speed.max((largest_force(scene, site) * length / density).sqrt());
        speed = speed.max((stress_difference(scene, site) / density).sqrt());
    }
    speed
}

/// The largest body force at the start; where there is none then, that at some times.
fn largest_force<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> f64 {
    let force = vector(&scene.fluid.force);
    let largest =
        |t: f64| site.mesh.points().iter().map(|x| force(x, t).norm()).fold(0.0, f64::max);
    let at_start = largest(0.0);
    if at_start > 0.0 || !scene.fluid.force.iter().any(Expression::depends_on_time) {
        return at_start;
    }
    (0..SAMPLES).map(|k| largest(scene.time.end * spread(k))).fold(0.0, f64::max)
}

/// The largest difference of the stresses that open sides give, at one time.
fn stress_difference<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> f64 {
    let mut ranges = [None; SAMPLES];
    for b in scene.boundaries.iter().filter(|b| b.condition.is_open()) {
        let Ok(facets) = site.mesh.boundary(&b.name) else { continue };
        let of: &[Expression] = match &b.condition {
            Condition::Pressure(p) | Condition::TotalPressure(p) => std::slice::from_ref(p),
            Condition::Traction(t) => t,
            _ => &[],
        };
        let (traction, isotropic) = (vector::<D>(of), of.len() == 1);
        let facets = facets.iter().map(|f| &site.mesh.facets()[*f as usize]);
        for x in facets.flat_map(|f| site.mesh.facet_points(f)) {
            let x = &site.mesh.points()[x as usize];
            for (k, range) in ranges.iter_mut().enumerate() {
                let mut t = traction(x, scene.time.end * spread(k));
                if isotropic {
                    t[0] = -t[0];
                    t.fill(t[0]);
                }
                let (low, high) = range.unwrap_or((t, t));
                *range = Some((low.inf(&t), high.sup(&t)));
            }
        }
    }
    ranges.iter().flatten().map(|(low, high)| (high - low).amax()).fold(0.0, f64::max)
}

/// Energy that rounding errors reach: a fraction of that of the fluid at the velocity scale, of the
/// work of the body force over the length, and of what viscosity takes in the run.
pub(super) fn least_energy<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
    [speed, length]: [f64; 2],
) -> f64 {
    let viscosity = scene.fluids().map(|f| f.viscosity).fold(0.0, f64::max);
    let gravity = SVector::<f64, D>::from_iterator(scene.fluid.gravity.iter().copied()).norm();
    let densities = [
        heaviest(scene) * speed.powi(2),
        heaviest(scene) * gravity * length,
        largest_force(scene, site) * length,
        stress_difference(scene, site),
        viscosity * (speed / length).powi(2) * scene.time.end,
    ];
    ROUNDING * site.mesh.volume() * densities.into_iter().fold(0.0, f64::max)
}

/// Elastic energy of membranes as large as those of the scene, circles or spheres of these radii,
/// at a stretch of [`SMALL`]: what a membrane at rest seems to store is the error of the mesh in
/// its length.
pub(super) fn least_elastic_energy<const D: usize>(scene: &Scene, radii: &[f64]) -> f64 {
    let energy = |(traits, &radius): (Traits, &f64)| {
        let size = if D == 2 { 2.0 * PI * radius } else { 4.0 * PI * radius * radius };
        let counts = traits.stretches && size.is_finite();
        if counts { 0.5 * traits.modulus * size * SMALL.powi(2) } else { 0.0 }
    };
    scene.structures().iter().map(|s| s.traits()).zip(radii).map(energy).sum()
}

/// Weight of grad-div in units with `rho U L = 1`, at least the viscosity; `scales` are a speed and
/// a length.
pub(super) fn grad_div(scene: &Scene, [speed, length]: [f64; 2]) -> f64 {
    let viscosity = scene.fluids().map(|f| f.viscosity).fold(0.0, f64::max);
    let sharp = scene.acting().map(|s| s.traits()).any(|t| t.on_interface && !t.keeps_size);
    if !scene.has_inertia() {
        return GRAD_DIV_STOKES[usize::from(sharp)] * viscosity;
    }
    let alone = scene.acting().next().is_none();
    let weight = if sharp { GRAD_DIV_SHARP } else { GRAD_DIV[usize::from(alone)] };
    (weight * heaviest(scene) * speed * length).max(viscosity)
}

/// The largest density in the inertia: of all fluids, or in the Boussinesq form of that outside.
fn heaviest(scene: &Scene) -> f64 {
    let outside = scene.outside().density;
    match scene.fluid.boussinesq {
        true => outside,
        false => scene.fluids().map(|f| f.density).fold(outside, f64::max),
    }
}
