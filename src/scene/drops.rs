//! What is measured of drops alone.

use super::dimension::{Dimension, In};
use crate::base::Result;
use crate::mesh::Point;
use crate::sim::Simulation;
use std::f64::consts::PI;

/// The columns [`DROP`](Dimension::DROP) of structure number `k`, which encloses `enclosed` and is as long (in space: large) as `own`: size of the round
/// form of what is enclosed over its own, at most 1, and the mean velocity of what is inside.
///
/// That is taken over the interface, `int_S (x - c)_i u . n ds / enclosed`, which for a velocity without divergence is the mean of `u_i` for any `c`; it is NaN
/// for a drop that walls or periodic sides cut.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn row<const D: usize>(sim: &Simulation<D>, k: usize, [enclosed, own]: [f64; 2]) -> Result<Vec<f64>>
where
    In<D>: Dimension<D>,
{
    let round = if D == 2 { 2.0 * (PI * enclosed).sqrt() } else { (36.0 * PI * enclosed * enclosed).cbrt() };
    let (space, u) = (sim.space(), &sim.state().flow.u);
    let points = In::<D>::surface(space, &sim.level_set(k))?;
    let (mut flux, mut closed, mut middle) = (Point::<D>::zeros(), Point::<D>::zeros(), Point::<D>::zeros());
    points.iter().for_each(|p| middle += p.at.x * (p.at.weight / own));
    for p in &points {
        let through = space.value(u, p.at.cell, &p.at.barycentric).dot(&p.normal);
        flux += (p.at.x - middle) * (p.at.weight * through);
        closed += p.normal * p.at.weight;
    }
    // The normals of a closed interface add up to nothing.
    let whole = closed.norm() < 1e-3 * own;
    let velocity = flux.iter().map(|f| if whole { f / enclosed } else { f64::NAN });
    Ok(std::iter::once(if whole { round / own } else { f64::NAN }).chain(velocity).collect())
}
