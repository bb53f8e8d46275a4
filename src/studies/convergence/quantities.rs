//! The quantities and times of a convergence study.

use super::{Meaning, Observable};
use crate::base::{Error, Result};
use crate::scene::Scene;
use crate::scene::keys::advice;

/// The quantity that stands for the distances of all interfaces.
const INTERFACE: &str = "interface";
/// The ends of its columns.
pub(super) const DISTANCES: [&str; 2] = ["distance_mean", "distance_largest"];

/// The quantities that are asked for, or a choice of those that the scene has.
pub(super) fn quantities(
    scene: &Scene,
    asked: &[String],
    columns: &[String],
) -> Result<Vec<Observable>> {
    // Surfaces in space are not compared.
    let compared: Vec<&str> = match scene.dimension() {
        2 => scene.acting().map(|s| s.name()).collect(),
        _ => Vec::new(),
    };
    let distances = || compared.iter().flat_map(|name| DISTANCES.map(|d| format!("{name}.{d}")));
    let meaning = |name: &str| match name.starts_with("error_") {
        true => Meaning::Error,
        false if distances().any(|d| d == name) => Meaning::Change,
        false => Meaning::Value,
    };
    let mut names: Vec<String> = Vec::new();
    let chosen = if asked.is_empty() { choice(scene, columns) } else { asked.to_vec() };
    for name in chosen {
        let known = columns.contains(&name) || distances().any(|d| d == name);
        if name == INTERFACE && !compared.is_empty() {
            names.extend(distances());
        } else if known {
            names.push(name);
        } else {
            let interface = (!compared.is_empty()).then_some(INTERFACE);
            return Err(Error::scene("the runs of this scene have no such quantity")
                .at("--quantity")
                .value(&name)
                .remedy(advice(&name, columns.iter().map(String::as_str).chain(interface))));
        }
    }
    let mut unique: Vec<Observable> = Vec::new();
    for name in names {
        if !unique.iter().any(|q| q.name == name) {
            unique.push(Observable { meaning: meaning(&name), name });
        }
    }
    Ok(unique)
}

/// Errors where they are known; lengths, area and place of the interfaces; energies; what the scene
/// measures itself.
fn choice(scene: &Scene, columns: &[String]) -> Vec<String> {
    let mut names: Vec<String> =
        columns.iter().filter(|c| c.starts_with("error_")).cloned().collect();
    let (dimension, [enclosed, own]) = (scene.mesh.dimension(), scene.extents());
    for s in scene.structures().iter().filter(|s| s.shape().is_some()) {
        let (name, chords) = (s.name(), s.chords());
        if s.traits().acts && chords.is_empty() {
            names.extend((1..=dimension).map(|k| format!("{name}.axis_{k}")));
        }
        names.extend(chords.iter().map(|c| format!("{name}.{c}")));
        names.extend([own, enclosed].map(|c| format!("{name}.{c}")));
    }
    if columns.iter().any(|c| c == "energy_kinetic")
        && names.iter().all(|n| !n.starts_with("error_"))
    {
        names.push("energy_kinetic".into());
    }
    if scene.acting().next().is_some() {
        names.push("energy_elastic".into());
        names.extend((dimension == 2).then(|| INTERFACE.into()));
    }
    // Columns of forces, fluxes and probes come after those that every run has.
    let own = columns
        .iter()
        .skip_while(|c| *c != "step_over_limit")
        .skip(1)
        .filter(|c| !c.starts_with("error_"));
    names.extend(own.cloned());
    names
}

/// The times that are asked for, rising; the end of the scene without any.
pub(super) fn times(scene: &Scene, asked: &[f64]) -> Result<Vec<f64>> {
    if asked.is_empty() {
        return Ok(vec![scene.time.end]);
    }
    let mut times = asked.to_vec();
    times.sort_by(f64::total_cmp);
    times.dedup();
    for &t in &times {
        let steps = t / scene.time.step;
        if !(t.is_finite() && steps >= 0.5 && (steps - steps.round()).abs() < 1e-6) {
            return Err(Error::scene(
                "a time of the study is not reached by the steps of its coarsest level",
            )
            .at("--at")
            .value(t)
            .remedy(format!("give a multiple of the step, {}", scene.time.step)));
        }
    }
    Ok(times)
}

/// Assignments of all trials: they end at the last of the times, with rows, and fields if asked
/// for, at all of them.
pub(super) fn common(scene: &Scene, times: &[f64], fields: bool) -> Vec<String> {
    let step = scene.time.step;
    let end = times.last().copied().unwrap_or(scene.time.end);
    let whole = |interval: f64| {
        times.iter().all(|t| ((t / interval).round() * interval - t).abs() < 1e-9 * t.max(interval))
    };
    let every = if whole(scene.output.every) { scene.output.every } else { step };
    let mut set = vec![format!("time.end={end:?}"), format!("output.every={every:?}")];
    if fields {
        let steps = times.iter().map(|t| (t / step).round() as u64).fold(0, divisor);
        set.push(format!("output.fields={:?}", steps as f64 * step));
    }
    set
}

/// The greatest common divisor (Euclid).
fn divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { divisor(b, a % b) }
}
