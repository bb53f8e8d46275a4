//! How the initial velocity fits the conditions on the boundary and a fluid that keeps its volume.

use super::Scene;
use super::points::coordinates;
use super::schema::Condition;
use super::site::{Site, vector};
use crate::base::{Result, Warning};
use crate::fem::condition_of_facets;
use crate::mesh::Point;
use nalgebra::SVector;

/// Differences below this fraction of the largest velocity or gradient are errors of constants such
/// as 3.14.
const SMALL: f64 = 0.01;

/// The start of a flow.
pub(super) struct Start {
    /// Misfits of the initial velocity that change its energy at once.
    pub warnings: Vec<Warning>,
    /// True if the first step changes the velocity at once: a fluid at rest, or an initial velocity
    /// that does not fit.
    pub impulsive: bool,
}

/// Compares the initial velocity `u` at the nodes with the conditions on the boundary, and takes the
/// divergence of one that is given by expressions.
///
/// A velocity along a wall that differs from that of the wall makes an impulsive start, but no
/// warning: a fluid that is set in motion by its walls begins so.
///
/// # Errors
/// A name that the mesh does not have.
pub(super) fn start<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
    u: &[SVector<f64, D>],
) -> Result<Start> {
    let fastest = u.iter().map(SVector::norm).fold(0.0, f64::max);
    if fastest == 0.0 {
        return Ok(Start { warnings: Vec::new(), impulsive: true });
    }
    let (mut warnings, slides) = at_walls(scene, site, (u, fastest))?;
    warnings.extend(at_periodic_sides(scene, site, (u, fastest)));
    if scene.initial.is_none() {
        warnings.extend(divergence(scene, site));
    }
    let impulsive = slides || !warnings.is_empty();
    Ok(Start { warnings, impulsive })
}

/// Velocity at the nodes, and the largest one.
type Velocity<'a, const D: usize> = (&'a [SVector<f64, D>], f64);

/// A warning for each boundary through which the velocity goes as it should not, and whether it
/// differs from that of a wall at all.
fn at_walls<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
    (u, fastest): Velocity<'_, D>,
) -> Result<(Vec<Warning>, bool)> {
    let (mesh, nodes) = (&site.mesh, site.space.nodes());
    let (mut worst, mut slides) = (vec![(0.0, Point::<D>::zeros()); scene.boundaries.len()], false);
    for (f, k) in condition_of_facets(mesh, &site.conditions)? {
        let Some(k) = k else { continue };
        let wall = match &scene.boundaries[k].condition {
            Condition::Velocity(v) => v.as_slice(),
            Condition::NoSlip | Condition::Slip => &[],
            _ => continue,
        };
        let (wall, slips) = (vector(wall), scene.boundaries[k].condition == Condition::Slip);
        let facet = &mesh.facets()[f as usize];
        let (n, _) = mesh.facet_normal(facet);
        // The mean over the facet, by its vertices and the middles of its edges: a velocity along a
        // curved wall crosses its straight facets forth and back.
        let [vertex, middle] = if D == 2 { [1.0 / 6.0, 4.0 / 6.0] } else { [0.0, 1.0 / 3.0] };
        let mut through = 0.0;
        for (a, node) in site.space.facet_nodes(facet).enumerate() {
            let jump = u[node as usize] - wall(&nodes[node as usize], 0.0);
            through += if a < D { vertex } else { middle } * jump.dot(&n);
            slides |= !slips && jump.norm() > SMALL * fastest;
        }
        if through.abs() > worst[k].0 {
            let points = mesh.facet_points(facet).map(|p| mesh.points()[p as usize]);
            worst[k] = (through.abs(), points.sum::<Point<D>>() / D as f64);
        }
    }
    let found = scene.boundaries.iter().zip(worst).filter(|(_, (v, _))| *v > SMALL * fastest);
    let warnings = found.map(|(b, (v, x))| {
        let what = format!(
            "the initial velocity goes through boundary `{}`: at {:.4?} its normal part differs \
             by {v:.3} from that of the boundary",
            b.name,
            x.as_slice()
        );
        misfit(scene, what, &format!("fits boundary.{}", b.name))
    });
    Ok((warnings.collect(), slides))
}

/// A warning if the velocity is not the same on both of two periodic sides.
fn at_periodic_sides<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
    (u, fastest): Velocity<'_, D>,
) -> Option<Warning> {
    let nodes = site.space.nodes();
    let on = |facet: u32| {
        let facet = &site.mesh.facets()[facet as usize];
        site.space.facet_nodes(facet).map(|n| n as usize).collect::<Vec<_>>()
    };
    let jumps = site.pairs.iter().flat_map(|p| {
        let partners = on(p.partner);
        on(p.facet).into_iter().filter_map(move |a| {
            let off = |b: &usize| (nodes[a] + p.shift - nodes[*b]).norm();
            let b = partners.iter().copied().min_by(|b, c| off(b).total_cmp(&off(c)))?;
            Some((a, b, (u[a] - u[b]).norm()))
        })
    });
    let (a, b, jump) = jumps.max_by(|a, b| a.2.total_cmp(&b.2))?;
    (jump > SMALL * fastest).then(|| {
        let what = format!(
            "the initial velocity is not periodic: it differs by {jump:.3} at {:.4?} and {:.4?}",
            nodes[a].as_slice(),
            nodes[b].as_slice()
        );
        misfit(scene, what, "is the same on both sides")
    })
}

/// A warning if the velocity has a divergence.
fn divergence<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> Option<Warning> {
    let slopes = site.space.nodes().iter().map(|x| {
        let of = |e: &super::Expression| e.eval_with_gradient(coordinates(x), 0.0).1;
        let rows: Vec<_> = scene.fluid.initial_velocity.iter().map(of).collect();
        let trace: f64 = rows.iter().enumerate().map(|(i, row)| row[i]).sum();
        let square: f64 = rows.iter().flatten().map(|v| v * v).sum();
        (x, trace, square.sqrt())
    });
    // At a kink or a pole a gradient has no value.
    let slopes: Vec<_> = slopes.filter(|s| s.1.is_finite() && s.2.is_finite()).collect();
    let steepest = slopes.iter().map(|s| s.2).fold(0.0, f64::max);
    let (x, trace, _) = slopes.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    (trace.abs() > SMALL * steepest).then(|| {
        let what = format!(
            "the initial velocity is not free of divergence: div u = {trace:.3} at {:.4?}",
            x.as_slice()
        );
        misfit(scene, what, "has div u = 0, such as the derivatives (d/dy, -d/dx) of one function")
    })
}

fn misfit(scene: &Scene, what: String, fitting: &str) -> Warning {
    let other = match scene.initial {
        Some(_) => "start from a run whose velocity",
        None => "give a fluid.initial_velocity that",
    };
    let remedy = format!(
        "the first step changes it at once, and its energy with it: {other} {fitting}, unless such \
         a start is meant"
    );
    Warning::new(what, remedy)
}
