//! Scene keys related to an error of the lower layers, by its cause.

use crate::base::{Cause, Result};

/// Adds the keys of the scene to the remedy of an error.
pub(super) fn with_keys<T>(result: Result<T>) -> Result<T> {
    result.map_err(|error| match error.cause().map(|cause| keys(cause, error.wrong_value())) {
        None => error,
        Some(keys) if error.advice().ends_with(&keys) => error,
        Some(keys) => {
            let remedy = format!("{}: {keys}", error.advice());
            error.remedy(remedy)
        }
    })
}

/// The keys that control a cause; `value` is the invalid one.
fn keys(cause: Cause, value: &str) -> String {
    let keys = match cause {
        Cause::SolverMemory => "numerics.solver = \"auto\"",
        Cause::SolverStalled => {
            "a smaller time.step or numerics.grad_div, or numerics.solver = \"direct\""
        }
        Cause::Inflow => "open = true in a table [boundary.NAME]",
        Cause::Checkpoint => "in another folder with --out",
        Cause::ShortestStep => "a larger time.tolerance or a smaller time.step_min",
        Cause::ErrorControl => "time.order = 2, or no time.tolerance",
        Cause::BlowUp => {
            "a smaller time.step, numerics.coupling = \"implicit\", or a larger \
             numerics.grad_div; `immersa explain` prints the step limit"
        }
        Cause::FirstOrder => "time.order = 1, or numerics.coupling",
        Cause::Massless => "density of [fluid] and of the structures, or numerics.coupling",
        Cause::SharpForce => "numerics.coupling, or force = \"smeared\" of the membrane",
        Cause::ShearForce => "numerics.coupling = \"implicit\" or \"explicit\"",
        Cause::SeveralCurves => "a table [[level_set]] each",
        Cause::ContourLost => "image.length, image.start",
        Cause::BareBoundary if value == "unnamed" => "a table [boundary.walls]",
        Cause::BareBoundary => {
            return format!("a table [boundary.{}]", value.split(", ").next().unwrap_or(value));
        }
        Cause::CurvedBoundary => "mesh.geometry",
    };
    keys.to_string()
}
