//! Fast marching on the lattice of the nodes.

use super::exact::Surface;
use super::lattice::{Lattice, Small};
use crate::fem::Space;
use crate::mesh::NONE;
use nalgebra::{Matrix3, Vector3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Distances at the nodes: exact in the cells that the interface crosses, then from node to node in
/// the order of the distance, each the least value of a linear function on a lattice simplex with
/// known values (Kimmel and Sethian 1998; Barth and Sethian 1998).
///
/// First order. Limits: in a lattice simplex with an obtuse angle the least value may come from a
/// node outside of it, and is found along an edge only.
pub(super) fn distances<const D: usize>(
    surface: &Surface<'_, D>,
    unknowns: &(Vec<u32>, usize),
) -> Vec<f64> {
    let space = surface.space;
    let (numbers, count) = (&unknowns.0, unknowns.1);
    let lattice = Lattice::new(space, unknowns);
    let mut front = Front {
        space,
        numbers,
        lattice: &lattice,
        value: vec![f64::INFINITY; count],
        heap: BinaryHeap::new(),
    };
    let mut accepted = vec![false; count];
    let mut nodes: Vec<u32> =
        surface.cells().iter().flat_map(|&c| space.cell_nodes(c as usize)).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    for &n in &nodes {
        let u = numbers[n as usize] as usize;
        front.value[u] = front.value[u].min(surface.distance(&space.nodes()[n as usize]));
        accepted[u] = true;
    }
    for &n in &nodes {
        front.spread(numbers[n as usize] as usize, &accepted);
    }
    while let Some(Reverse((_, u))) = front.heap.pop() {
        let u = u as usize;
        // An older and larger value of the same node.
        if accepted[u] {
            continue;
        }
        accepted[u] = true;
        front.spread(u, &accepted);
    }
    // A point of no cell has no distance.
    numbers.iter().map(|&u| if u == NONE { 0.0 } else { front.value[u as usize] }).collect()
}

struct Front<'a, const D: usize> {
    space: &'a Space<D>,
    numbers: &'a [u32],
    lattice: &'a Lattice,
    value: Vec<f64>,
    /// Distances as bits (which have the order of the numbers, since these are not negative), with
    /// their unknowns.
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

impl<const D: usize> Front<'_, D> {
    fn unknown(&self, node: u32) -> usize {
        self.numbers[node as usize] as usize
    }
    /// Updates the lattice simplices of an accepted unknown.
    fn spread(&mut self, from: usize, accepted: &[bool]) {
        for &k in self.lattice.about(from) {
            let simplex = self.lattice.simplices[k as usize];
            for i in 0..=D {
                let u = self.unknown(simplex[i]);
                if accepted[u] {
                    continue;
                }
                let value = self.through(&simplex, i, accepted);
                if value < self.value[u] {
                    self.value[u] = value;
                    self.heap.push(Reverse((value.to_bits(), u as u32)));
                }
            }
        }
    }
    /// The least distance of corner `i` that comes through a face, an edge or a corner of the
    /// simplex whose nodes are accepted.
    fn through(&self, simplex: &Small, i: usize, accepted: &[bool]) -> f64 {
        let x = self.space.nodes()[simplex[i] as usize];
        let (mut ways, mut values) = ([Vector3::zeros(); 3], Vector3::zeros());
        let mut known = 0;
        for j in (0..=D).filter(|&j| j != i && accepted[self.unknown(simplex[j])]) {
            let way = x - self.space.nodes()[simplex[j] as usize];
            ways[known] = Vector3::from_fn(|k, _| if k < D { way[k] } else { 0.0 });
            values[known] = self.value[self.unknown(simplex[j])];
            known += 1;
        }
        (1..1usize << known)
            .map(|subset| arrival(&ways, &values, subset))
            .fold(f64::INFINITY, f64::min)
    }
}

/// Arrival time of a plane front that passed the corners in `subset` (bits) at `values`; `ways` are
/// the vectors from them to the arrival point. Infinite if the front does not come from between
/// them.
fn arrival(ways: &[Vector3<f64>; 3], values: &Vector3<f64>, subset: usize) -> f64 {
    let chosen = |k: usize| subset >> k & 1 == 1;
    // Rows and columns of unused corners are those of the unit matrix.
    let gram = Matrix3::from_fn(|i, j| match (chosen(i) && chosen(j), i == j) {
        (true, _) => ways[i].dot(&ways[j]),
        (false, true) => 1.0,
        (false, false) => 0.0,
    });
    let Some(inverse) = gram.try_inverse() else { return f64::INFINITY };
    let ones = Vector3::from_fn(|k, _| if chosen(k) { 1.0 } else { 0.0 });
    let values = values.component_mul(&ones);
    // |grad| = 1 with ways . grad = t - values: a t^2 - 2 b t + c = 0.
    let (a, b, c) = (
        ones.dot(&(inverse * ones)),
        ones.dot(&(inverse * values)),
        values.dot(&(inverse * values)) - 1.0,
    );
    let discriminant = b * b - a * c;
    if discriminant < 0.0 {
        return f64::INFINITY;
    }
    let t = (b + discriminant.sqrt()) / a;
    let from = inverse * (ones * t - values);
    if (0..3).all(|k| !chosen(k) || from[k] >= 0.0) { t } else { f64::INFINITY }
}
