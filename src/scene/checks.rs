//! Checks of a scene that need no mesh.

use super::Scene;
use super::schema::{Boundary, Condition};
use crate::base::{Error, Result, Warning};

/// Rejects a prescribed velocity, for which no flow is solved, and a flow without inertia whose
/// velocity is not fixed on any boundary: every side periodic, open or slip.
pub(super) fn check_flow(scene: &Scene) -> Result<()> {
    if scene.fluid.is_prescribed() {
        let e = Error::scene("the velocity is prescribed, and no flow is solved")
            .remedy("build the problem with `scene::problem`, or give the fluid a viscosity");
        return Err(scene.blame(&["fluid", "prescribed_velocity"], e));
    }
    let held = |b: &Boundary| matches!(b.condition, Condition::Velocity(_) | Condition::NoSlip);
    if scene.has_inertia()
        || scene.structures().iter().any(|s| s.traits().mass > 0.0)
        || scene.boundaries.iter().any(held)
    {
        return Ok(());
    }
    let e = Error::scene(
        "nothing fixes the velocity: without inertia a uniform motion or a rotation can be added \
         to the flow",
    )
    .value("density 0, and no boundary with a velocity or no_slip")
    .remedy("give a boundary a velocity or no_slip = true, or the fluid a density");
    Err(scene.blame(&["boundary"], e))
}

/// Warnings about profiles beyond the end of the run. They are no errors, so that a run shortened
/// with `--set time.end` still runs.
pub(super) fn unreached_profiles(scene: &Scene) -> impl Iterator<Item = Warning> + '_ {
    scene.output.profiles.iter().filter_map(|p| {
        let late: Vec<String> =
            p.times.iter().filter(|t| **t > scene.time.end).map(f64::to_string).collect();
        let what = format!(
            "profile `{}` is not written at t = {}: the run ends at {}",
            p.name,
            late.join(", "),
            scene.time.end
        );
        (!late.is_empty()).then(|| Warning::new(what, ""))
    })
}
