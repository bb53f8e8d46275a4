//! Adaptive time steps of a scene.

use super::script::Script;
use crate::sim::Pacing;

/// Bounds of the adaptive steps, and all times of output, which steps must end at.
pub(super) fn pacing(
    scene: &Script,
    [tolerance, memory]: [f64; 2],
    [speed, length]: [f64; 2],
) -> Pacing {
    let (time, output) = (&scene.time, &scene.output);
    let [least, most] = time.bounds();
    let mut instants = vec![time.end];
    for interval in [Some(output.every), output.fields, output.pictures].into_iter().flatten() {
        let count = (time.end / interval * (1.0 + ROUNDING)).floor() as usize;
        instants.extend((1..=count).map(|k| k as f64 * interval));
    }
    instants.extend(output.profiles.iter().flat_map(|p| p.times.iter().copied()));
    instants.retain(|&t| t > ROUNDING * time.end && t <= time.end * (1.0 + ROUNDING));
    instants.sort_by(f64::total_cmp);
    instants.dedup_by(|later, earlier| *later - *earlier <= ROUNDING * time.end);
    if let Some(last) = instants.last_mut() {
        *last = time.end;
    }
    Pacing { tolerance, memory, first: time.step, least, most, instants, speed, length }
}

/// Output times closer than this fraction of the end time are merged.
const ROUNDING: f64 = 1e-9;
