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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, Point};
    use std::sync::Arc;

    /// Two triangles of areas 1 and 3 that share an edge.
    #[test]
    fn constants_of_cells_are_weighed_by_their_volumes() {
        let points = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 3.0]].map(Point::<2>::from);
        let mesh = Arc::new(Mesh::new(points.to_vec(), vec![0, 1, 2, 1, 3, 2]).unwrap());
        assert!(
            (mesh.map(0).volume - 1.0).abs() < 1e-15 && (mesh.map(1).volume - 3.0).abs() < 1e-15
        );
        let linear = [1.0, 2.0, 3.0, 4.0];
        let continuous = Space::new(&mesh, Element::P1);
        assert_eq!(nodal_pressure(&continuous, &linear), linear);
        let jumping = Space::new(&mesh, Element::P1P0);
        let p = [&linear[..], &[10.0, -2.0]].concat();
        let expected = [1.0 + 10.0, 2.0 + 1.0, 3.0 + 1.0, 4.0 - 2.0];
        for (found, exact) in nodal_pressure(&jumping, &p).iter().zip(expected) {
            assert!((found - exact).abs() < 1e-14, "{found} {exact}");
        }
    }
}
