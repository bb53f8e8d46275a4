//! The lattice of the P2 nodes: the mesh of half the edge length with these vertices.

use crate::fem::{EDGES, Element, Space};
use crate::levelset::contour::{CORNERS, LATTICE};
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};

/// A simplex of the lattice.
pub(super) struct Part<const D: usize> {
    /// Its vertices by the local P2 nodes of the cell, `0..=D`.
    pub nodes: [usize; 4],
    /// Its volume.
    pub volume: f64,
    /// The gradients of its barycentric coordinates, `0..=D`.
    gradients: [SVector<f64, D>; 4],
}

impl<const D: usize> Part<D> {
    fn new(space: &Space<D>, c: usize, nodes: [usize; 4]) -> Option<Part<D>> {
        let cell = space.cell_nodes(c);
        let x = |k: usize| space.nodes()[cell[nodes[k]] as usize];
        let mut edges = SMatrix::<f64, D, D>::zeros();
        (0..D).for_each(|k| edges.set_column(k, &(x(k + 1) - x(0))));
        let inverse = edges.try_inverse()?;
        let mut gradients = [SVector::zeros(); 4];
        for k in 0..D {
            gradients[k + 1] = inverse.row(k).transpose();
            gradients[0] -= gradients[k + 1];
        }
        Some(Part { nodes, volume: space.mesh().map(c).volume / (1 << D) as f64, gradients })
    }
    /// Weight of the edge between its vertices `i` and `j` in the linear finite-element Laplacian:
    /// minus the entry of the stiffness matrix.
    pub fn weight(&self, i: usize, j: usize) -> f64 {
        -self.volume * self.gradients[i].dot(&self.gradients[j])
    }
    /// The gradient of the linear function with these values at the local P2 nodes.
    pub fn gradient(&self, values: &[f64]) -> SVector<f64, D> {
        (0..=D).fold(SVector::zeros(), |g, k| g + self.gradients[k] * values[self.nodes[k]])
    }
}

/// The simplices of the lattice in cell `c` of a P2 space, all of the same volume.
///
/// The octahedron in a tetrahedron is divided along the diagonal between the midpoints of its edges
/// 02 and 13, with vertices sorted by their numbers (Bey 1995): the cells of a box then have the
/// seven-point Laplacian on their lattice, those of squares the five-point one.
pub(super) fn parts<const D: usize>(space: &Space<D>, c: usize) -> impl Iterator<Item = Part<D>> {
    let mut all = [[0; 4]; 8];
    if D == 2 {
        all[..4].copy_from_slice(&LATTICE.map(|[a, b, c]| [a, b, c, 0]));
    } else {
        all[..4].copy_from_slice(&CORNERS);
        let cell = space.mesh().cell(c);
        let mut order = [0, 1, 2, D];
        order.sort_unstable_by_key(|&k| cell[k]);
        let middle = |i: usize, j: usize| {
            let ends = (order[i], order[j]);
            4 + EDGES.iter().position(|&(a, b)| (a, b) == ends || (b, a) == ends).unwrap_or(0)
        };
        let ring = [middle(0, 1), middle(1, 2), middle(2, 3), middle(3, 0)];
        for i in 0..4 {
            all[4 + i] = [middle(0, 2), middle(1, 3), ring[i], ring[(i + 1) % 4]];
        }
    }
    all.into_iter().take(1 << D).filter_map(move |nodes| Part::new(space, c, nodes))
}

/// Barycentric coordinates of the point at parameter `t` between two local P2 nodes.
pub(super) fn between(d: usize, a: usize, b: usize, t: f64) -> [f64; 4] {
    let (la, lb) = (Element::P2.node(a, d), Element::P2.node(b, d));
    std::array::from_fn(|k| la[k] + t * (lb[k] - la[k]))
}

/// The vector between two local P2 nodes of a cell.
pub(super) fn edge<const D: usize>(space: &Space<D>, c: usize, a: usize, b: usize) -> Point<D> {
    let nodes = space.cell_nodes(c);
    space.nodes()[nodes[b] as usize] - space.nodes()[nodes[a] as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, Mesh, box_mesh, rectangle};
    use std::collections::BTreeMap;
    use std::sync::Arc;

    /// The weights of the edges from the node at `x`, by their vectors.
    fn stencil<const D: usize>(mesh: Mesh<D>, x: &Point<D>) -> BTreeMap<Vec<i64>, f64> {
        let space = Space::new(&Arc::new(mesh), Element::P2);
        let mut sums = BTreeMap::new();
        for c in 0..space.mesh().cell_count() {
            let nodes = space.cell_nodes(c);
            let near = |a: usize| (space.nodes()[nodes[a] as usize] - x).norm() < 1e-12;
            let mut volume = 0.0;
            for part in parts(&space, c) {
                volume += part.volume;
                for (i, j) in
                    (0..=D).flat_map(|i| (0..=D).map(move |j| (i, j))).filter(|(i, j)| i != j)
                {
                    if near(part.nodes[i]) {
                        let e = edge(&space, c, part.nodes[i], part.nodes[j]);
                        let key = e.iter().map(|e| (e * 1000.0).round() as i64).collect();
                        *sums.entry(key).or_insert(0.0) += part.weight(i, j);
                    }
                }
            }
            assert!((volume - space.mesh().map(c).volume).abs() < 1e-14);
        }
        sums.retain(|_, w: &mut f64| w.abs() > 1e-12);
        sums
    }

    #[test]
    fn squares_have_the_five_point_laplacian_and_boxes_the_seven_point_one() {
        let plane = || rectangle([0.0; 2], [2.0; 2], [5, 5], Diagonals::Right).unwrap();
        for x in [[0.8, 0.8], [0.6, 0.8], [0.6, 1.0]] {
            let found = stencil(plane(), &Point::<2>::from(x));
            assert_eq!(found.len(), 4, "{found:?}");
            assert!(found.values().all(|w| (w - 1.0).abs() < 1e-12), "{found:?}");
        }
        let solid = || box_mesh([0.0; 3], [2.0; 3], [5, 5, 5]).unwrap();
        for x in [[0.8, 0.8, 0.8], [0.6, 0.8, 0.8], [0.6, 1.0, 0.6], [1.0, 1.0, 0.8]] {
            let found = stencil(solid(), &Point::<3>::from(x));
            assert_eq!(found.len(), 6, "{found:?}");
            assert!(found.values().all(|w| (w - 0.2).abs() < 1e-12), "{found:?}");
        }
    }
}
