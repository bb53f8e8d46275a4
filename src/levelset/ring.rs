//! Waves of a surface around a ring.

use super::interface::Interface;
use crate::mesh::Point;
use nalgebra::SVector;
use std::f64::consts::PI;

/// Number of diameters of a ring.
const DIAMETERS: usize = 96;
/// Largest fraction of diameters without an interface: a zero may lie just inside a cell whose
/// nodes have one sign.
const MISSED: f64 = 0.05;

impl<const D: usize> Interface<'_, D> {
    /// In space: mean radius about `centre` in the plane with this normal, and amplitudes of the
    /// waves with the numbers `modes` around it, from the half-diameters in 96 directions. NaN if
    /// too little of the surface is found.
    pub fn waves(&self, centre: &Point<D>, normal: &SVector<f64, D>, modes: &[usize]) -> Vec<f64> {
        let normal: SVector<f64, 3> = normal.fixed_resize(0.0);
        let n = normal.normalize();
        let first = if n[0].abs() < 0.9 { Point::<3>::x() } else { Point::<3>::y() };
        let first = (first - n * n.dot(&first)).normalize();
        let second = n.cross(&first);
        let angle = |i: usize| PI * i as f64 / DIAMETERS as f64;
        let along = |i: usize| {
            let direction = first * angle(i).cos() + second * angle(i).sin();
            let direction: SVector<f64, D> = direction.fixed_resize(0.0);
            self.half_chord(centre, &direction).unwrap_or(f64::NAN)
        };
        let radii: Vec<f64> = (0..DIAMETERS).map(along).collect();
        let found: Vec<f64> = radii.iter().copied().filter(|r| r.is_finite()).collect();
        let mean = match found.len() as f64 {
            count if count >= (1.0 - MISSED) * DIAMETERS as f64 => {
                found.iter().sum::<f64>() / count
            }
            _ => f64::NAN,
        };
        // A missing diameter is replaced by the mean.
        let part = |f: &dyn Fn(f64) -> f64| {
            let term = |(i, r): (usize, &f64)| {
                if r.is_finite() { (r - mean) * f(angle(i)) } else { 0.0 }
            };
            radii.iter().enumerate().map(term).sum::<f64>() / DIAMETERS as f64
        };
        let mode = |m: usize| {
            let m = m as f64;
            2.0 * part(&|a| (m * a).cos()).hypot(part(&|a| (m * a).sin()))
        };
        // NaN if too little was found, since `hypot` of nothing is 0.
        let modes = modes.iter().map(|&m| if mean.is_nan() { mean } else { mode(m) });
        std::iter::once(mean).chain(modes).collect()
    }
}
