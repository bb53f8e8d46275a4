//! TEMPORARY.
use crate::fem::Space;
use nalgebra::{SMatrix, SVector};
/// TEMPORARY until recovery is merged.
pub fn mean_curvature<const D: usize>(space: &Space<D>, phi: &[f64], near: impl Fn(usize) -> bool) -> Vec<f64> {
    let mesh = space.mesh();
    let mut n = vec![(SVector::<f64, D>::zeros(), 0.0); space.len()];
    for c in 0..mesh.cell_count() {
        let v = mesh.map(c).volume;
        for (a, &k) in space.cell_nodes(c).iter().enumerate() {
            let g = space.gradient(phi, c, &space.element().node(a, D));
            n[k as usize].0 += g * v;
            n[k as usize].1 += v;
        }
    }
    let n: Vec<SVector<f64, D>> = n.iter().map(|(g, v)| (g / *v).normalize()).collect();
    let mut h = vec![(0.0, 0.0); mesh.points().len()];
    for c in (0..mesh.cell_count()).filter(|&c| near(c)) {
        let v = mesh.map(c).volume;
        for (a, &k) in mesh.cell(c).iter().enumerate() {
            let j: SMatrix<f64, D, D> = space.jacobian(&n, c, &space.element().node(a, D));
            h[k as usize].0 += j.trace() * v;
            h[k as usize].1 += v;
        }
    }
    h.iter().map(|(s, v)| if *v > 0.0 { s / v } else { 0.0 }).collect()
}
