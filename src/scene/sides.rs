//! Checks of what drives a flow, on its mesh: values that stay finite, sides with two conditions,
//! gravity that something holds.

use super::Scene;
use super::expression::Expression;
use super::points::coordinates;
use super::schema::{Boundary, Condition};
use super::site::{Site, vector};
use crate::base::{Error, Result, Warning, rounded};
use crate::fem::{self, condition_of_facets};
use crate::mesh::Point;
use nalgebra::SVector;
use std::collections::BTreeSet;
use std::slice;

/// Number of times, beside the start, at which values are looked at.
const TIMES: usize = 256;
/// Number of points at which they are looked at after the start.
const POINTS: usize = 50;
/// Component of gravity along a side, over gravity, that counts.
const ALONG: f64 = 1e-6;

/// Checks boundaries, forces and velocities; warnings about conditions and gravity.
///
/// # Errors
/// A value that is not finite at the start or at a later time of the run.
pub(super) fn check<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> Result<Vec<Warning>> {
    let nodes = site.space.nodes();
    for b in &scene.boundaries {
        let (v, key) = match &b.condition {
            Condition::Velocity(v) => (v.as_slice(), "velocity"),
            Condition::Traction(t) => (t.as_slice(), "traction"),
            Condition::Pressure(p) => (slice::from_ref(p), "pressure"),
            Condition::TotalPressure(p) => (slice::from_ref(p), "total_pressure"),
            _ => continue,
        };
        let facets = site.mesh.boundary(&b.name)?;
        let on = |f: &u32| site.space.facet_nodes(&site.mesh.facets()[*f as usize]);
        let points: Vec<_> = facets.iter().flat_map(on).map(|n| nodes[n as usize]).collect();
        check_finite(scene, (v, &points), &["boundary", &b.name, key])?;
    }
    check_finite(scene, (&scene.fluid.force, nodes), &["fluid", "force"])?;
    let initial = &scene.fluid.initial_velocity;
    check_finite(scene, (initial, nodes), &["fluid", "initial_velocity"])?;
    if let Some(v) = &scene.fluid.prescribed_velocity {
        check_finite(scene, (v, nodes), &["fluid", "prescribed_velocity"])?;
    }
    check_forms(scene, site)?;
    let mut warnings = conflicts(scene, site)?;
    warnings.extend(unheld(scene, site)?);
    Ok(warnings)
}

/// Rejects a function that is not finite at time 0 somewhere, or later at some of the points.
fn check_finite<const D: usize>(
    scene: &Scene,
    (v, points): (&[Expression], &[Point<D>]),
    keys: &[&str],
) -> Result<()> {
    let f = vector::<D>(v);
    let wrong = |x: &Point<D>, t: f64| (!f(x, t).iter().all(|c| c.is_finite())).then_some((*x, t));
    let later = || {
        let some = points.iter().step_by(points.len().div_ceil(POINTS).max(1));
        some.flat_map(|x| times(scene).map(move |t| (x, t)))
    };
    let timed = v.iter().any(Expression::depends_on_time);
    let at_start = points.iter().find_map(|x| wrong(x, 0.0));
    let found = match (at_start, timed) {
        (None, true) => later().find_map(|(x, t)| wrong(x, t)),
        (found, _) => found,
    };
    let Some((x, t)) = found else { return Ok(()) };
    let (what, remedy) = match t > 0.0 {
        true => ("is not finite at all times", "that is finite from t = 0 to time.end"),
        false => ("has no finite value everywhere", "that is finite on the whole mesh at t = 0"),
    };
    let e = Error::scene(format!("`{}` {what}", keys.join(".")))
        .value(format!(
            "{:?} at {:?}, t = {}",
            &f(&x, t).as_slice()[..v.len()],
            x.as_slice(),
            rounded(t, 6)
        ))
        .remedy(format!("write an expression {remedy}, such as if(t > 0, ..., 0)"));
    Err(scene.blame(keys, e))
}

/// The ends of the steps, or of a long run some times that are in phase with no oscillation, and
/// the end.
fn times(scene: &Scene) -> impl Iterator<Item = f64> + '_ {
    let time = &scene.time;
    let steps = time.end / time.step;
    let all = time.tolerance.is_none() && steps <= TIMES as f64;
    let count = if all { steps.round() as usize } else { TIMES };
    let at = move |k: usize| match all {
        true => k as f64 * time.step,
        false => time.end * spread(k),
    };
    (1..=count).map(at).chain([time.end])
}

/// Number `k` of a sequence in [0, 1) that is in phase with no oscillation: a multiple of the golden
/// ratio.
pub(super) fn spread(k: usize) -> f64 {
    (k as f64 * 0.618_033_988_749_895).fract()
}

/// Rejects two open sides that meet with different forms of the stress, which no condition joins.
fn check_forms<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> Result<()> {
    let has = |gradient| {
        let of = |c: &fem::Condition<D>| c.is_open() && c.has_gradient() == gradient;
        site.conditions.iter().any(|(_, c)| of(c))
    };
    if !has(true) || !has(false) {
        return Ok(());
    }
    let mut kinds = vec![[None; 2]; site.space.len()];
    let mut held = vec![false; site.space.len()];
    // What has no condition is told by the flow.
    for (f, k) in condition_of_facets(&site.mesh, &site.conditions).unwrap_or_default() {
        let Some((k, condition)) = k.map(|k| (k, &site.conditions[k].1)) else { continue };
        for n in site.space.facet_nodes(&site.mesh.facets()[f as usize]) {
            match condition.is_open() {
                true => kinds[n as usize][usize::from(condition.has_gradient())] = Some(k),
                false => held[n as usize] |= !matches!(condition, fem::Condition::Periodic(_)),
            }
        }
    }
    for (kinds, held) in kinds.iter().zip(held) {
        if let ([Some(a), Some(b)], false) = (kinds, held) {
            let [a, b] = [a, b].map(|k| &scene.boundaries[*k].name);
            let what = format!(
                "boundary.{a} and boundary.{b} meet, and their conditions are of different forms: \
                 one gives 2 mu D(u) - p, the other mu grad u - p"
            );
            let e = Error::scene(what).remedy(format!(
                "give both the same form: open = \"gradient\", pressure and total_pressure go \
                 together, and so do open = true and traction; or put a wall between `{a}` and `{b}`"
            ));
            return Err(scene.blame(&["boundary", b], e));
        }
    }
    Ok(())
}

/// A warning for each pair of conditions on the same facets, which are none of the union of all
/// sides.
fn conflicts<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> Result<Vec<Warning>> {
    let mut warnings = Vec::new();
    let named: Vec<(&Boundary, BTreeSet<u32>)> = scene
        .boundaries
        .iter()
        .filter(|b| b.name != "walls")
        .map(|b| Ok((b, site.mesh.boundary(&b.name)?.iter().copied().collect())))
        .collect::<Result<_>>()?;
    for (k, (a, of_a)) in named.iter().enumerate() {
        for (b, of_b) in &named[k + 1..] {
            let both = of_a.intersection(of_b).count();
            if both == 0 || a.condition == b.condition {
                continue;
            }
            // As fem::condition_of_facets has it: fewer facets first, then the later one.
            let wins = if of_a.len() < of_b.len() { a } else { b };
            let what = format!(
                "boundary.{} and boundary.{} have conditions for the same {both} facets: that of \
                 boundary.{} applies there",
                a.name, b.name, wins.name
            );
            let remedy = "the smaller part wins, of equal ones the later: give each facet one name";
            warnings.push(Warning::new(what, remedy));
        }
    }
    Ok(warnings)
}

/// A warning if nothing holds the fluid against gravity: no wall at all, or an open side along
/// which it acts.
fn unheld<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> Result<Option<Warning>> {
    let g = SVector::<f64, D>::from_iterator(scene.fluid.gravity.iter().copied());
    if g.norm() == 0.0 || scene.fluid.is_prescribed() || scene.fluid.boussinesq {
        return Ok(None);
    }
    let heavy = scene.fluids().any(|f| f.density > 0.0);
    let none = |b: &Boundary| matches!(b.condition, Condition::Periodic(_));
    if heavy && !scene.boundaries.is_empty() && scene.boundaries.iter().all(none) {
        return Ok(Some(Warning::new(
            "all sides are periodic: nothing holds the fluid against gravity, and it falls freely",
            "give a fluid.force that holds the weight, (0, density*g) for gravity (0, -g), or a wall",
        )));
    }
    let density = scene.outside().density;
    for b in scene.boundaries.iter().filter(|b| heavy && b.condition.is_open()) {
        // The pressure that the side gives.
        let given = |x: &Point<D>, n: &SVector<f64, D>| match &b.condition {
            Condition::Pressure(p) | Condition::TotalPressure(p) => p.eval(coordinates(x), 0.0),
            Condition::Traction(t) => -vector::<D>(t)(x, 0.0).dot(n),
            _ => 0.0,
        };
        let along = |f: &u32| {
            let facet = &site.mesh.facets()[*f as usize];
            let (n, _) = site.mesh.facet_normal(facet);
            let ends: Vec<_> =
                site.mesh.facet_points(facet).map(|p| site.mesh.points()[p as usize]).collect();
            ends[1..].iter().any(|x| {
                let (step, length) = (x - ends[0], (x - ends[0]).norm());
                let weight = density * g.dot(&step);
                let missing = weight - (given(x, &n) - given(&ends[0], &n));
                g.dot(&step).abs() > ALONG * g.norm() * length && missing.abs() > 0.5 * weight.abs()
            })
        };
        if site.mesh.boundary(&b.name)?.iter().any(along) {
            let what = format!(
                "gravity acts along the open side boundary.{}, whose pressure does not hold the \
                 weight: the fluid pours out below and comes in above",
                b.name
            );
            let remedy = "give it the pressure of the column, pressure = \"density*g*(height - \
                y)\" for gravity (0, -g), or a fluid.force that holds the weight, or \
                fluid.boussinesq = true, or make the side a wall";
            return Ok(Some(Warning::new(what, remedy)));
        }
    }
    Ok(None)
}
