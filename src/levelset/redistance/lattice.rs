//! The lattice of the P2 nodes as a mesh of small simplices.

use super::super::contour::{CORNERS, LATTICE};
use crate::fem::Space;
use crate::mesh::Point;

/// The octahedron between the corner tetrahedra: the ends of a diagonal, and the four other nodes
/// around it.
const DIAGONALS: [([usize; 2], [usize; 4]); 3] =
    [([4, 9], [6, 7, 8, 5]), ([6, 8], [7, 4, 5, 9]), ([7, 5], [4, 6, 9, 8])];

/// A simplex of the lattice by its nodes, of which there are `D + 1`.
pub(super) type Small = [u32; 4];

/// The small simplices of a space, and those about each unknown.
pub(super) struct Lattice {
    pub simplices: Vec<Small>,
    /// Start of the list of each unknown in `about`.
    first: Vec<u32>,
    about: Vec<u32>,
}

impl Lattice {
    /// Divides every triangle into four, every tetrahedron into eight, the inner ones about the
    /// shortest diagonal. `unknowns` are one number per node, equal for nodes that periodic sides
    /// identify, and their count.
    pub(super) fn new<const D: usize>(space: &Space<D>, unknowns: &(Vec<u32>, usize)) -> Lattice {
        let mut simplices = Vec::with_capacity(space.mesh().cell_count() << D);
        for c in 0..space.mesh().cell_count() {
            push::<D>(space.cell_nodes(c), space.nodes(), &mut simplices);
        }
        let (numbers, count) = unknowns;
        let unknown = |n: u32| numbers[n as usize] as usize;
        let mut first = vec![0u32; count + 1];
        simplices.iter().flat_map(|s| &s[..=D]).for_each(|&n| first[unknown(n) + 1] += 1);
        (0..*count).for_each(|u| first[u + 1] += first[u]);
        let (mut next, mut about) = (first.clone(), vec![0; simplices.len() * (D + 1)]);
        for (k, simplex) in simplices.iter().enumerate() {
            for &n in &simplex[..=D] {
                let place = &mut next[unknown(n)];
                about[*place as usize] = k as u32;
                *place += 1;
            }
        }
        Lattice { simplices, first, about }
    }
    /// The numbers of the simplices that an unknown belongs to.
    pub(super) fn about(&self, unknown: usize) -> &[u32] {
        &self.about[self.first[unknown] as usize..self.first[unknown + 1] as usize]
    }
}

fn push<const D: usize>(nodes: &[u32], points: &[Point<D>], out: &mut Vec<Small>) {
    if D == 2 {
        out.extend(LATTICE.map(|[a, b, c]| [nodes[a], nodes[b], nodes[c], nodes[c]]));
        return;
    }
    let at = |a: usize| points[nodes[a] as usize];
    let length = |[a, b]: [usize; 2]| (at(a) - at(b)).norm_squared();
    let mut best = &DIAGONALS[0];
    for other in &DIAGONALS[1..] {
        // A diagonal shorter by rounding only is not taken: of equal ones the first.
        if length(other.0) < length(best.0) * (1.0 - 1e-12) {
            best = other;
        }
    }
    let ([p, q], ring) = *best;
    out.extend(CORNERS.map(|s| s.map(|a| nodes[a])));
    out.extend((0..4).map(|k| [p, q, ring[k], ring[(k + 1) % 4]].map(|a| nodes[a])));
}
