//! Remedies of errors of the layers below, in keys of the scene, by their cause.

use super::keys::key;
use super::problem::Advice;
use super::schema::WALLS;
use crate::base::{Cause, Error, Result};

/// Gives an error of a layer below the remedy that names the keys of the scene.
pub(super) fn with_keys<T>(result: Result<T>) -> Result<T> {
    result.map_err(|error| match error.cause().and_then(|cause| remedy(cause, &error)) {
        Some(remedy) => error.remedy(remedy),
        None => error,
    })
}

/// The same for the result of a step of a problem with this advice.
pub(super) fn of_step<T>(result: Result<T>, advice: impl FnOnce() -> Advice) -> Result<T> {
    with_keys(result).map_err(|error| match error.cause() {
        Some(Cause::BlowUp) => error.remedy(format!("take {}", one_of(&advice().blow_up))),
        _ => error,
    })
}

/// The remedy in keys of the scene; `None` if that of the layer below is complete.
fn remedy(cause: Cause, error: &Error) -> Option<String> {
    let remedy = match cause {
        Cause::SolverMemory => {
            let ([own, key], advice) = (SOLVER, error.advice());
            return advice.contains(own).then(|| advice.replace(own, key));
        }
        Cause::SolverStalled => {
            "take a smaller time.step or a smaller numerics.grad_div, or numerics.solver = \
             \"direct\" where the memory suffices"
        }
        Cause::Inflow => "balance the velocities, or set open = true on an outlet",
        Cause::Checkpoint => {
            return Some(
                error.advice().replace("a new run", "a new one in another folder with --out"),
            );
        }
        Cause::ShortestStep => {
            "give a larger time.tolerance or a smaller time.step_min; an abrupt force or boundary \
             value has no short enough step"
        }
        Cause::ErrorControl => {
            "take time.order = 2 and a flow that is solved for, or leave out time.tolerance for \
             steps of one length"
        }
        // Depends on the scene: see `of_step`.
        Cause::BlowUp => return None,
        Cause::FirstOrder => "take time.order = 1, or coupling = \"implicit\"",
        Cause::Massless => "take densities above 0, or coupling = \"implicit\"",
        Cause::SharpForce => "take coupling = \"implicit\" or \"explicit\", or force = \"smeared\"",
        Cause::ShearForce => "take coupling = \"implicit\" or \"explicit\"",
        Cause::SeveralCurves => "give each curve a [[level_set]] of its own",
        Cause::ContourLost => "take a smaller image.length, or a start that crosses the objects",
        Cause::BareBoundary if error.wrong_value() == "unnamed" => {
            "this part has no name in the mesh: give it one (gmsh: Physical Curve or Surface), or \
             add [boundary.walls]"
        }
        Cause::BareBoundary => {
            let tables = tables_of(error.wrong_value());
            return Some(match error.wrong_value().split(", ").any(|name| name == WALLS) {
                true => format!("add {tables} to the scene, such as no_slip = true"),
                false => format!(
                    "add {tables} to the scene, or [boundary.walls] no_slip = true, which holds \
                     for all that has no condition of its own"
                ),
            });
        }
        Cause::CurvedBoundary => {
            "make the mesh finer where the boundary is curved, or correct mesh.geometry"
        }
    };
    Some(remedy.to_string())
}

/// The tables of boundaries whose names a text lists.
pub(super) fn tables_of(names: &str) -> String {
    let tables = names.split(", ").map(|name| format!("[boundary.{}]", key(name)));
    tables.collect::<Vec<_>>().join(", ")
}

/// The choice of a solver, in the words of the linear algebra and of the scene.
const SOLVER: [&str; 2] =
    ["let the solver be chosen by the memory", "numerics.solver = \"auto\" takes what fits"];

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

#[cfg(test)]
mod tests {
    use crate::base::Error;
    use crate::scene::{Scene, problem};
    use std::path::Path;

    fn scene(more: &[&str]) -> Scene {
        let text = "mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }
            fluid.viscosity = 1
            boundary.walls.no_slip = true
            time = { end = 1, step = 0.1 }";
        let more: Vec<String> = more.iter().map(ToString::to_string).collect();
        Scene::parse_with(text, Path::new("scene.toml"), &more).unwrap()
    }

    /// The layers below name no key, so that each of these words comes from here.
    #[track_caller]
    fn assert_remedy(e: Error, words: &[&str]) {
        assert!(words.iter().all(|w| e.advice().contains(w)), "{e}");
    }

    #[test]
    fn errors_of_the_layers_below_name_the_keys_of_the_scene() {
        let small = scene(&["numerics.solver=direct", "numerics.memory=1e-5"]);
        let e = problem(&small).unwrap().plan().unwrap_err();
        assert_remedy(e, &["would fit", "numerics.solver = \"auto\" takes what fits"]);
        let e = problem(&scene(&[])).unwrap().restore([&[], &[1, 2, 3]], 0, None).unwrap_err();
        assert_remedy(e, &["a new one in another folder with --out"]);
        let e = problem(&scene(&["time.order=1", "time.tolerance=1e-3"])).err();
        assert_remedy(e.unwrap(), &["time.order = 2", "time.tolerance"]);
    }

    /// The settings of the command line that carry out a choice; `None` for one without a key.
    fn settings(scene: &Scene, choice: &str) -> Option<Vec<String>> {
        let worded = [
            ("a smaller time.step", format!("time.step={}", 0.5 * scene.time.step)),
            ("a larger numerics.grad_div", "numerics.grad_div=100".to_string()),
            ("a larger numerics.thickness", "numerics.thickness=0.39".to_string()),
            ("a finer mesh", finer(scene)),
        ];
        let said = worded.iter().find(|(words, _)| choice.starts_with(words));
        if let Some((_, setting)) = said {
            return Some(vec![setting.clone()]);
        }
        if let Some(name) = choice.strip_prefix("force = \"sharp\" for `") {
            let name = name.trim_end_matches('`');
            let k = scene.structures().iter().position(|s| s.name() == name).unwrap();
            let [list, number] = scene.structure_keys(k);
            return Some(vec![format!("{list}.{number}.force=\"sharp\"")]);
        }
        let is_key = |key: &str| key.chars().all(|c| c.is_ascii_lowercase() || "._".contains(c));
        let (key, value) = choice.split_once(" = ")?;
        is_key(key).then(|| vec![format!("{key}={value}")])
    }

    fn finer(scene: &Scene) -> String {
        match scene.dimension() {
            2 => "mesh.rectangle.cells=[24, 24]".into(),
            _ => "mesh.box.cells=[12, 12, 12]".into(),
        }
    }

    /// Each alarm and failure, for scenes of each kind: what is advised can be done, and no scene
    /// without structures is told of their keys.
    #[test]
    fn what_is_advised_is_taken_by_the_scene() {
        let flow = "mesh.rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }
            fluid.viscosity = 0.1
            boundary.walls.no_slip = true
            time = { end = 1, step = 0.1 }";
        let driven = flow.replace("walls.no_slip", "right.open = true\nboundary.walls.slip");
        let pushed = driven.replace("right.open = true", "right.pressure = 1");
        let carried = "mesh.rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }
            fluid.prescribed_velocity = [\"1 - y\", \"x - 1\"]
            time = { end = 1, step = 0.1 }";
        let solid = "mesh.box = { min = [0, 0, 0], max = [2, 2, 2], cells = [4, 4, 4] }
            fluid.viscosity = 0.1
            boundary.walls.no_slip = true
            time = { end = 1, step = 0.1 }";
        let circle = "shape.circle = { centre = [1, 1], radius = 0.6 }";
        let ball = "shape.sphere = { centre = [1, 1, 1], radius = 0.6 }";
        let membrane = format!("[[membrane]]\n{circle}\narea.linear.modulus = 1");
        let in_space = format!("[[membrane]]\n{ball}\narea.linear.modulus = 1");
        let sheared = format!("{in_space}\nshear.linear.modulus = 1");
        let tense = format!("[[drop]]\n{circle}\ntension = 1");
        let passive = format!("[[level_set]]\n{circle}");
        let none = String::new();
        let smeared = "membrane.0.force=\"smeared\"";
        let cases: [(&str, &String, &[&str]); 21] = [
            (flow, &none, &[]),
            (&driven, &none, &["time.order=1"]),
            (&pushed, &none, &[]),
            (solid, &none, &[]),
            (flow, &passive, &[]),
            (flow, &membrane, &[]),
            (flow, &membrane, &["time.order=1"]),
            (flow, &membrane, &["numerics.coupling=\"implicit\""]),
            (flow, &membrane, &[smeared, "numerics.thickness=0.3"]),
            (flow, &membrane, &[smeared, "numerics.transport=\"projected\""]),
            (flow, &membrane, &[smeared, "numerics.band=\"carried\""]),
            (flow, &membrane, &["membrane.0.mass=0.5"]),
            (flow, &tense, &[]),
            (
                flow,
                &tense,
                &["drop.0.force=\"smeared\"", "numerics.surface_tension=\"brackbill1992\""],
            ),
            (flow, &tense, &["time.order=1", "numerics.coupling=\"fully-explicit\""]),
            (solid, &in_space, &[]),
            (solid, &sheared, &[]),
            (solid, &sheared, &[smeared, "mesh.box.cells=[10, 10, 10]", "numerics.thickness=0.35"]),
            (carried, &passive, &[]),
            (carried, &passive, &["numerics.transport=\"projected\""]),
            (
                carried,
                &passive,
                &[
                    "fluid.prescribed_velocity=[\"w*(0.5-y)\", \"w*(x-0.5)\"]",
                    "constants={ w = 6.28 }",
                    "numerics.transport=\"projected\"",
                ],
            ),
        ];
        let (mut tried, mut keys) = (0, std::collections::BTreeSet::new());
        for (base, structures, changes) in cases {
            let made = |more: &[String]| {
                let changes = changes.iter().map(ToString::to_string);
                let all: Vec<String> = changes.chain(more.iter().cloned()).collect();
                let text = format!("{base}\n{structures}");
                Scene::parse_with(&text, Path::new("scene.toml"), &all)
            };
            let scene = made(&[]).unwrap();
            let advice = problem(&scene).unwrap().advice();
            let alone = scene.acting().next().is_none();
            for choice in
                [&advice.energy, &advice.loss, &advice.area, &advice.blow_up].into_iter().flatten()
            {
                let of_forces = ["grad_div", "coupling", "thickness", "band", "force ="];
                let foreign = of_forces.iter().find(|word| choice.contains(*word));
                assert!(!(alone && foreign.is_some()), "{choice}, without a structure");
                let Some(settings) = settings(&scene, choice) else { continue };
                let taken = made(&settings).and_then(|s| problem(&s).map(|_| ()));
                assert!(taken.is_ok(), "{changes:?}: `{choice}`: {}", taken.unwrap_err());
                tried += 1;
                keys.insert(settings[0].split('=').next().unwrap().to_string());
            }
        }
        assert!(tried > 100 && keys.len() >= 9, "{tried}: {keys:?}");
    }
}
