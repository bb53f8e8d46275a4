//! Remedies of errors of the layers below, in keys of the scene, by their cause.

use crate::base::{Cause, Error, Result};

/// Gives an error of a layer below the remedy that names the keys of the scene.
pub(super) fn with_keys<T>(result: Result<T>) -> Result<T> {
    result.map_err(|error| match error.cause().and_then(|cause| remedy(cause, &error)) {
        Some(remedy) => error.remedy(remedy),
        None => error,
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
        Cause::BlowUp => {
            "take a smaller time.step, coupling = \"implicit\", or a larger numerics.grad_div; \
             `immersa explain` prints the step limit"
        }
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
            let name = error.wrong_value().split(", ").next().unwrap_or_default();
            let rest = match name {
                "walls" => "add [boundary.walls] to the scene, such as no_slip = true".into(),
                _ => format!(
                    "add [boundary.{name}] to the scene, or [boundary.walls] no_slip = true, which \
                     holds for all that has no condition of its own"
                ),
            };
            return Some(rest);
        }
        Cause::CurvedBoundary => {
            "make the mesh finer where the boundary is curved, or correct mesh.geometry"
        }
    };
    Some(remedy.to_string())
}

/// The choice of a solver, in the words of the linear algebra and of the scene.
const SOLVER: [&str; 2] =
    ["let the solver be chosen by the memory", "numerics.solver = \"auto\" takes what fits"];

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
}
