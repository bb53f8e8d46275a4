//! Remedies of the alarms of a flow, in keys that the scene can take.

use crate::elastic::Band;
use crate::scene::Scene;
use crate::scene::problem::Advice;
use crate::scene::schema::{Boundary, Condition};
use crate::scene::structures::{StructureKind, Traits, band_of};
use crate::sim::Coupling;
use crate::transport::Method;

/// Remedies of alarms and failures.
pub(super) fn advice(scene: &Scene) -> Advice {
    let (finer, shorter, weight) =
        ("a finer mesh", "a smaller time.step", "a larger numerics.grad_div");
    let coupling = scene.numerics.coupling;
    let of_first = matches!(coupling, Coupling::FullyExplicit | Coupling::SemiImplicit);
    let order: &[&str] = if scene.time.order == 1 && !of_first { &["time.order = 2"] } else { &[] };
    let away: Vec<String> =
        outlets_farther_away(scene).into_iter().chain(total_pressures(scene)).collect();
    let away: Vec<&str> = away.iter().map(String::as_str).collect();
    let choices = |lists: &[&[&str]]| lists.concat().into_iter().map(String::from).collect();
    if scene.acting().next().is_none() {
        return Advice {
            energy: choices(&[&[shorter, finer]]),
            loss: choices(&[order, &[shorter, finer]]),
            area: choices(&[&[finer]]),
            blow_up: choices(&[&[shorter, finer], &away]),
            inflow: choices(&[&away]),
        };
    }
    let [sharp, forces] = [of_bands(scene), of_forces(scene)];
    let [sharp, forces] = [&sharp, &forces].map(|f| f.iter().map(String::as_str).collect());
    let (sharp, forces): (Vec<&str>, Vec<&str>) = (sharp, forces);
    let is_implicit = |f: &&str| f.starts_with("numerics.coupling");
    let implicit: Vec<&str> = forces.iter().copied().filter(is_implicit).collect();
    let slower = match coupling.is_explicit() {
        true => "a smaller time.step (`immersa explain` prints the step limit)",
        false => shorter,
    };
    // Feet of characteristics are inexact where fluid with a structure moves fast.
    let along = scene.has_inertia() && scene.numerics.convection.is_none();
    let blocks = scene.acting().any(|s| s.traits().keeps_size);
    let schemes: &[&str] =
        if along && !blocks { &["numerics.convection = \"baker1982\""] } else { &[] };
    let banded = scene.acting().any(|s| !s.traits().on_interface);
    Advice {
        energy: match banded {
            true => choices(&[&sharp, &[weight], &forces, &[shorter]]),
            // Sharp forces have a large weight by default, which is the last to change.
            false => choices(&[&forces, &[shorter, finer], schemes, &[weight]]),
        },
        loss: choices(&[&sharp, order, &[shorter, finer]]),
        area: choices(&[&[weight, finer]]),
        blow_up: choices(&[&[slower], &implicit, &[weight, finer], &away]),
        inflow: choices(&[&away]),
    }
}

/// A longer domain, if the scene has open sides.
fn outlets_farther_away(scene: &Scene) -> Option<String> {
    let open = scene.boundaries.iter().filter(|b| b.condition.is_open());
    let open: Vec<String> = open.map(|b| format!("boundary.{}", b.name)).collect();
    let sides = open.join(" and ");
    let away = format!("a domain with {sides} farther away where fluid comes back in");
    (!open.is_empty()).then_some(away)
}

/// The total pressure in place of a pressure, for each side that has one.
fn total_pressures(scene: &Scene) -> impl Iterator<Item = String> + '_ {
    let given = |b: &&Boundary| matches!(b.condition, Condition::Pressure(_));
    scene
        .boundaries
        .iter()
        .filter(given)
        .map(|b| format!("total_pressure in place of pressure for boundary.{}", b.name))
}

/// The sharp force, for each structure that stretches in a band.
fn of_bands(scene: &Scene) -> Vec<String> {
    let elastic = |t: &Traits| t.stretches && !t.on_interface && !t.constant_tension;
    let banded = scene.acting().filter(|s| elastic(&s.traits()));
    banded.map(|s| format!("force = \"sharp\" for `{}`", s.name())).collect()
}

/// Choices of the forces and of their transport.
fn of_forces(scene: &Scene) -> Vec<String> {
    let (numerics, mut choices) = (&scene.numerics, Vec::new());
    let smeared: Vec<_> = scene.acting().filter(|s| !s.traits().on_interface).collect();
    if !smeared.is_empty() {
        choices.push("a larger numerics.thickness over the edges of the mesh".into());
    }
    let renormalised =
        |s: &&dyn StructureKind| band_of(numerics, s.traits().constant_tension) != Band::Carried;
    if smeared.iter().any(renormalised) {
        choices.push("numerics.band = \"carried\"".into());
    }
    if numerics.coupling != Coupling::Implicit && numerics.surface_tension.is_none() {
        choices.push("numerics.coupling = \"implicit\"".into());
    }
    if numerics.transport == Method::Projected {
        choices.push("numerics.transport = \"nodal\"".into());
    }
    choices
}
