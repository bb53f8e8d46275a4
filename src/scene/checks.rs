//! What can be said against a scene before its mesh is known.

use super::Scene;
use super::schema::{Boundary, Condition};
use crate::base::{Error, Result, Warning};

/// Refuses a flow whose velocity is prescribed, or that has no inertia and no boundary that holds its
/// velocity: every side periodic or open, or slipping.
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
        "nothing fixes the velocity: without inertia a uniform motion or a rotation can be added to the flow",
    )
    .value("density 0, and no boundary with a velocity or no_slip")
    .remedy("give a boundary a velocity or no_slip = true, or the fluid a density");
    Err(scene.blame(&["boundary"], e))
}

/// Warnings about profiles that the run will not reach: a run that was shortened with `--set time.end` still runs.
pub(super) fn unreached_profiles(scene: &Scene) -> impl Iterator<Item = Warning> + '_ {
    scene.output.profiles.iter().filter_map(|p| {
        let late: Vec<String> = p.times.iter().filter(|t| **t > scene.time.end).map(f64::to_string).collect();
        let what = format!(
            "profile `{}` is not written at t = {}: the run ends at {}",
            p.name,
            late.join(", "),
            scene.time.end
        );
        (!late.is_empty()).then(|| Warning::new(what, ""))
    })
}
