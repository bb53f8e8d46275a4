//! Markers: particles on an interface, a Lagrangian measure of its length.

use crate::mesh::Point;
use crate::transport::Tracer;
use nalgebra::SVector;

/// Length of the closed polygon of the markers.
pub fn polygon_length<const D: usize>(markers: &[Point<D>]) -> f64 {
    let next = markers.iter().cycle().skip(1);
    markers.iter().zip(next).map(|(a, b)| (b - a).norm()).sum()
}

/// Area of the polygon of markers in the plane, positive for either orientation.
pub fn polygon_area<const D: usize>(markers: &[Point<D>]) -> f64 {
    let next = markers.iter().cycle().skip(1);
    0.5 * markers.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs()
}

/// Moves markers over a step in which the P2 velocity changes linearly in time from `old` to `new`,
/// by `steps` steps of the classical Runge-Kutta rule. A marker outside the mesh does not move.
pub fn follow_markers<const D: usize>(
    markers: &mut [Point<D>],
    tracer: &Tracer<D>,
    [old, new]: [&[SVector<f64, D>]; 2],
    dt: f64,
    steps: usize,
) {
    let (space, tau) = (tracer.space(), dt / steps as f64);
    crate::base::parallel::fill(markers, 1, |_, part| {
        for x in part {
            for k in 0..steps {
                let Some(start) = tracer.locate(x) else { break };
                // The velocity at a displacement from the start, at a fraction of the step.
                let slope = |step: SVector<f64, D>, s: f64| {
                    let at = tracer.displaced(start, step);
                    let value =
                        |u: &[SVector<f64, D>]| space.value(u, at.cell as usize, &at.barycentric);
                    value(old) * (1.0 - s) + value(new) * s
                };
                let s = |half: f64| (k as f64 + half) / steps as f64;
                let a = slope(SVector::zeros(), s(0.0));
                let b = slope(a * (0.5 * tau), s(0.5));
                let c = slope(b * (0.5 * tau), s(0.5));
                let d = slope(c * tau, s(1.0));
                *x = space
                    .mesh()
                    .point_at(&tracer.displaced(start, (a + b * 2.0 + c * 2.0 + d) * (tau / 6.0)));
            }
        }
    });
}
