//! Forces on boundaries, and their coefficients.

use crate::base::{Error, Result, Warning, rounded};
use crate::fem::{Conditions, condition_of_facets};
use crate::flow::{Load, Wake, stress_size, traction};
use crate::mesh::{Mesh, Point};
use crate::scene::Scene;
use crate::scene::keys::Named;
use crate::scene::measure::force_columns;
use crate::scene::points::point;
use crate::scene::problem::{DRAG, Gap};
use crate::scene::row::Row;
use crate::scene::schema::{Force, Reference};
use crate::sim::Simulation;
use nalgebra::SVector;
use std::collections::HashSet;

/// What the forces of a scene need of a mesh.
pub(super) struct Site<const D: usize> {
    /// The line behind a body whose force has a reference.
    wake: Option<Wake<D>>,
    /// True on an open side, where there is no residual.
    open: bool,
}

/// The sites of the forces of a scene.
///
/// # Errors
/// A boundary that the mesh does not have.
pub(super) fn sites<const D: usize>(
    scene: &Scene,
    (mesh, conditions): (&Mesh<D>, &Conditions<D>),
) -> Result<Vec<Site<D>>> {
    let is_open = |(_, k): &(u32, Option<usize>)| k.is_some_and(|k| conditions[k].1.is_open());
    let open = condition_of_facets(mesh, conditions)?.into_iter().filter(is_open);
    let open: HashSet<u32> = open.map(|c| c.0).collect();
    let of = |f: &Named<Force>| {
        let wake = f.reference.as_ref().map(|reference| {
            let [stream, _] = reference.directions(D);
            Wake::new(mesh, &f.boundary, &point::<D>(&stream))
        });
        let open = mesh.boundary(&f.boundary)?.iter().any(|facet| open.contains(facet));
        Ok(Site { wake: wake.transpose()?.flatten(), open })
    };
    scene.output.forces.iter().map(of).collect()
}

/// Measures the forces on boundaries, from the residual and from the stress.
///
/// # Errors
/// A boundary that the mesh does not have.
pub(super) fn measure<const D: usize>(
    sim: &Simulation<D>,
    (scene, sites): (&Scene, &[Site<D>]),
    row: &mut Row,
) -> Result<()> {
    let (space, pressure, state) = (sim.space(), sim.flow().pressure().space(), sim.state());
    for (f, site) in scene.output.forces.iter().zip(sites) {
        let about = f.about.as_deref().map_or(Point::<D>::zeros(), point);
        let residual = sim.reaction(&f.boundary, &about)?.unwrap_or(Load::NAN);
        let stress = match state.has_pressure() {
            true => traction(space, pressure, sim.viscosity(), &state.flow, &f.boundary, &about)?,
            false => Load::NAN,
        };
        let methods = [("", &residual), (STRESS, &stress)];
        for (method, load) in methods {
            let prefix = format!("{}_{method}", f.name);
            row.put_all(&prefix, force_columns(D, false).iter().zip(load.force.iter().copied()));
        }
        for (method, load) in methods.into_iter().filter(|_| f.about.is_some()) {
            // In the plane a moment has only the last component.
            let moment = load.moment.iter().copied().skip(if D == 2 { 2 } else { 0 });
            row.put_all(&format!("{}_{method}", f.name), force_columns(D, true).iter().zip(moment));
        }
        if let Some(reference) = &f.reference {
            let values = coefficients(reference, scene.outside().density, &residual.force);
            row.put_all(&format!("{}_", f.name), COEFFICIENTS.into_iter().zip(values));
        }
        if let Some(wake) = &site.wake {
            row.put(format!("{}_recirculation", f.name), wake.recirculation(space, &state.flow.u));
        }
    }
    Ok(())
}

/// How far the forces by the residual and by the stress are apart in a row, by name; none on open
/// sides, which have no residual.
///
/// # Errors
/// A boundary that the mesh does not have.
pub(super) fn gaps<const D: usize>(
    sim: &Simulation<D>,
    (scene, sites): (&Scene, &[Site<D>]),
    row: &Row,
) -> Result<Vec<(String, Gap)>> {
    let (spaces, columns) =
        ([&**sim.space(), &**sim.flow().pressure().space()], force_columns(D, false));
    let mut gaps = Vec::new();
    for (f, _) in scene.output.forces.iter().zip(sites).filter(|(_, site)| !site.open) {
        let [residual, stress] = ["", STRESS].map(|method| {
            SVector::<f64, D>::from_fn(|i, _| {
                row.get(&format!("{}_{method}{}", f.name, columns[i])).unwrap_or(f64::NAN)
            })
        });
        let difference = (residual - stress).norm();
        if difference.is_finite() {
            let force = residual.norm().max(stress.norm());
            let stresses = stress_size(spaces, sim.viscosity(), &sim.state().flow, &f.boundary)?;
            gaps.push((f.name.clone(), Gap { difference, force, stresses }));
            // A lift that is far larger would hide an error of the drag.
            if let Some(reference) = &f.reference {
                let stream = point::<D>(&reference.directions(D)[0]).normalize();
                let difference = (residual - stress).dot(&stream).abs();
                let force = residual.dot(&stream).abs().max(stress.dot(&stream).abs());
                gaps.push((format!("{}{DRAG}", f.name), Gap { difference, force, stresses }));
            }
        }
    }
    Ok(gaps)
}

/// What stands before the suffix of a force by the stress.
const STRESS: &str = "stress_";
/// Suffixes of the columns of the coefficients, after the name of the force and `_`.
const COEFFICIENTS: [&str; 2] = ["drag", "lift"];

/// Coefficients of drag and lift: `2 F / (rho U^2 L)`, in space with the area in place of `L`.
fn coefficients<const D: usize>(
    reference: &Reference,
    density: f64,
    force: &SVector<f64, D>,
) -> [f64; 2] {
    let Reference { speed, length, .. } = *reference;
    let size = if D == 2 { length } else { reference.area.unwrap_or(length * length) };
    let pressure = 0.5 * reference.density.unwrap_or(density) * speed * speed;
    let [stream, lift] = reference.directions(D);
    [stream, lift].map(|direction| force.dot(&point::<D>(&direction)) / (pressure * size))
}

/// Warnings of series too sparse for a Strouhal number.
pub(super) fn warnings(scene: &Scene) -> impl Iterator<Item = Warning> + '_ {
    scene.output.forces.iter().filter_map(|f| {
        let reference = f
            .reference
            .as_ref()
            .filter(|r| !r.is_resolved_by(scene.output.every.max(scene.time.step)))?;
        let longest = rounded(reference.longest_between_rows(), 3);
        let what = format!(
            "rows of the series are too far apart for the Strouhal number of `{}`, which is left \
             out",
            f.name
        );
        Some(Warning::new(
            what,
            format!("give output.every and time.step <= {longest}, a quarter of length / speed"),
        ))
    })
}

/// Rejects coefficients of forces in a fluid without density.
///
/// # Errors
/// A reference without density.
pub(super) fn check(scene: &Scene) -> Result<()> {
    let lacks = |r: &Reference| r.density.is_none() && scene.outside().density == 0.0;
    match scene.output.forces.iter().find(|f| f.reference.as_ref().is_some_and(lacks)) {
        None => Ok(()),
        Some(f) => {
            let e =
                Error::scene("the coefficients of a force need a density, and the fluid has none")
                    .value("density = 0")
                    .remedy("give one: reference = { speed = 1, length = 0.1, density = 1000 }");
            Err(scene.blame(&["output", "forces", &f.name, "reference"], e))
        }
    }
}
