//! Remedies of the alarms of a flow, in keys that the scene can take.

use crate::elastic::Band;
use crate::scene::Scene;
use crate::scene::problem::Advice;
use crate::scene::schema::Condition;
use crate::scene::structures::{StructureKind, Traits, band_of};
use crate::sim::Coupling;
use crate::transport::Method;

/// Remedies of alarms.
pub(super) fn advice(scene: &Scene) -> Advice {
    let (numerics, time) = (&scene.numerics, &scene.time);
    let mut energy = vec!["a larger numerics.grad_div".to_string()];
    let smeared: Vec<_> = scene.acting().filter(|s| !s.traits().on_interface).collect();
    if !smeared.is_empty() {
        energy.push("a larger numerics.thickness over the edges of the mesh".into());
    }
    let renormalised =
        |s: &&dyn StructureKind| band_of(numerics, s.traits().constant_tension) != Band::Carried;
    if smeared.iter().any(renormalised) {
        energy.push("numerics.band = \"carried\"".into());
    }
    let acts = scene.acting().next().is_some();
    if acts && numerics.coupling != Coupling::Implicit {
        energy.push("numerics.coupling = \"implicit\"".into());
    }
    if numerics.transport == Method::Projected {
        energy.push("numerics.transport = \"nodal\"".into());
    }
    energy.push("a smaller time.step".into());
    if acts && smeared.is_empty() {
        // Sharp forces have a large weight by default; steps and cells are what is left.
        energy.rotate_left(1);
        energy.insert(energy.len() - 1, "a finer mesh".into());
    }
    let mut loss = vec!["a smaller time.step".to_string(), "a finer mesh".into()];
    let elastic = |t: &Traits| t.stretches && !t.on_interface && !t.constant_tension;
    for s in scene.acting().filter(|s| elastic(&s.traits())) {
        let sharp = format!("force = \"sharp\" for `{}`", s.name());
        [&mut energy, &mut loss].into_iter().for_each(|list| list.insert(0, sharp.clone()));
    }
    if time.order == 1 {
        loss.insert(0, "time.order = 2".into());
    }
    let open = scene.boundaries.iter().filter(|b| b.condition == Condition::Open);
    let open: Vec<String> = open.map(|b| format!("boundary.{}", b.name)).collect();
    if !open.is_empty() {
        let away = format!(
            "a domain with {} farther away where fluid comes back in there",
            open.join(" and ")
        );
        [&mut energy, &mut loss].into_iter().for_each(|list| list.push(away.clone()));
    }
    Advice {
        energy: one_of(&energy),
        loss: one_of(&loss),
        area: "a larger numerics.grad_div or a finer mesh".into(),
    }
}

/// Alternatives in words.
pub(super) fn one_of(choices: &[impl AsRef<str>]) -> String {
    let choices: Vec<&str> = choices.iter().map(AsRef::as_ref).collect();
    match choices.split_last() {
        Some((last, [])) => last.to_string(),
        Some((last, [one])) => format!("{one} or {last}"),
        Some((last, rest)) => format!("{}, or {last}", rest.join(", ")),
        None => String::new(),
    }
}
