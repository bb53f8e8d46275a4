//! Remedies of the alarms of a flow, in keys that the scene can take.

use crate::elastic::Band;
use crate::scene::Scene;
use crate::scene::problem::Advice;
use crate::scene::schema::Condition;
use crate::scene::structures::{StructureKind, Traits, band_of};
use crate::sim::Coupling;
use crate::transport::Method;

/// Remedies of alarms and failures.
pub(super) fn advice(scene: &Scene) -> Advice {
    let (finer, shorter) = ("a finer mesh".to_string(), "a smaller time.step".to_string());
    let open = scene.boundaries.iter().filter(|b| b.condition == Condition::Open);
    let open: Vec<String> = open.map(|b| format!("boundary.{}", b.name)).collect();
    let away = (!open.is_empty()).then(|| {
        let sides = open.join(" and ");
        format!("a domain with {sides} farther away where fluid comes back in there")
    });
    let of_first = [Coupling::FullyExplicit, Coupling::SemiImplicit];
    let free = !of_first.contains(&scene.numerics.coupling);
    let order = (scene.time.order == 1 && free).then(|| "time.order = 2".to_string());
    let choices = |lists: [&[String]; 4]| -> Vec<String> { lists.concat() };
    let away = away.as_slice();
    if scene.acting().next().is_none() {
        let flow = choices([&[shorter.clone()], &[finer.clone()], away, &[]]);
        return Advice {
            loss: choices([order.as_slice(), &[shorter], &[finer.clone()], away]),
            energy: flow.clone(),
            area: vec![finer],
            blow_up: flow,
        };
    }
    let (forces, weight) = (of_forces(scene), "a larger numerics.grad_div".to_string());
    let sharp = of_bands(scene);
    let is_implicit = |f: &&String| f.starts_with("numerics.coupling");
    let implicit: Vec<String> = forces.iter().filter(is_implicit).cloned().collect();
    // Sharp forces have a large weight by default; steps and cells are what is left.
    let banded = scene.acting().any(|s| !s.traits().on_interface);
    let energy = match banded {
        true => choices([&sharp, &[weight.clone()], &forces, &[shorter.clone()]]),
        false => choices([&forces, &[shorter.clone()], &[finer.clone()], &[weight.clone()]]),
    };
    let limit = "a smaller time.step (`immersa explain` prints the step limit)".to_string();
    let slower = if scene.numerics.coupling.is_explicit() { limit } else { shorter.clone() };
    Advice {
        energy: choices([&energy, away, &[], &[]]),
        loss: choices([&sharp, order.as_slice(), &[shorter.clone(), finer.clone()], away]),
        area: vec![weight.clone(), finer.clone()],
        blow_up: choices([&[slower], &implicit, &[weight, finer], away]),
    }
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
