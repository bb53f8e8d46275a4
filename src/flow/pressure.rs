//! The pressure at the points of the mesh, for output.

use crate::fem::{Element, Space};

/// The pressure `p`, a function of `space`, at the points of the mesh; where it jumps, the
/// volume-weighted mean over the cells of a point.
pub fn nodal_pressure<const D: usize>(space: &Space<D>, p: &[f64]) -> Vec<f64> {
    let mesh = space.mesh();
    let points = mesh.points().len();
    let mut nodal = p[..points].to_vec();
    if space.element() != Element::P1P0 {
        return nodal;
    }
    let mut sums = vec![[0.0; 2]; points];
    for c in 0..mesh.cell_count() {
        let (constant, volume) = (p[points + c], mesh.map(c).volume);
        for &v in mesh.cell(c) {
            let [sum, weight] = &mut sums[v as usize];
            (*sum, *weight) = (*sum + volume * constant, *weight + volume);
        }
    }
    nodal
        .iter_mut()
        .zip(sums)
        .filter(|(_, [_, weight])| *weight > 0.0)
        .for_each(|(p, [sum, weight])| *p += sum / weight);
    nodal
}
