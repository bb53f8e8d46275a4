//! Orders of elimination with little fill and a stable factorisation.

use super::SymmetricMatrix;
use super::metis::{self, Graph};
use crate::base::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use std::collections::HashSet;
use std::ops::Range;

const NONE: usize = usize::MAX;

/// The multipliers among the unknowns of a saddle point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Multipliers {
    /// The first multiplier; all later unknowns are multipliers.
    pub first: usize,
    /// The first multiplier that is eliminated after all its neighbours of the first row.
    pub first_late: usize,
    /// The first late multiplier that is not paired with a velocity: the order does not depend on
    /// the values of these.
    pub first_unpaired: usize,
}

impl From<usize> for Multipliers {
    /// All multipliers from `first` on, none of them late.
    fn from(first: usize) -> Multipliers {
        Multipliers { first, first_late: usize::MAX, first_unpaired: usize::MAX }
    }
}

/// An order of elimination: a permutation of the unknowns of a [`SymmetricMatrix`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ordering {
    /// `unknowns[k]` is eliminated as `k`-th.
    unknowns: Vec<usize>,
    /// `positions[unknowns[k]] = k`.
    positions: Vec<usize>,
}

impl Ordering {
    /// Nested dissection, for a positive definite matrix. Depends on the pattern only.
    ///
    /// # Errors
    /// Computation, if the matrix is too large for METIS.
    pub fn plain(matrix: &SymmetricMatrix) -> Result<Ordering> {
        let adjacency = Adjacency::new(matrix);
        let singles = Blocks::from_partners(&vec![NONE; matrix.order()]);
        Ordering::of_blocks(&adjacency, &singles, matrix.order())
    }

    /// Approximate minimum degree, for a positive definite matrix that is analysed often: on the
    /// matrices of surfaces the order takes a fifth of the time of [`plain`](Self::plain), and the
    /// factor is about as large.
    ///
    /// # Errors
    /// Computation, if the matrix is too large.
    pub fn minimum_degree(matrix: &SymmetricMatrix) -> Result<Ordering> {
        let (n, entries, upper) = (matrix.order(), matrix.nonzeros(), matrix.upper());
        let starts = upper.indptr();
        let pattern =
            SymbolicSparseColMatRef::new_checked(n, n, starts.raw_storage(), None, upper.indices());
        let too_large = |_| Error::computation("a matrix is too large for an ordering");
        let (mut unknowns, mut positions) = (vec![0; n], vec![0; n]);
        let mut memory = MemBuffer::try_new(amd::order_scratch::<usize>(n, entries))
            .map_err(|_| Error::computation("no memory for the ordering of a matrix"))?;
        let stack = MemStack::new(&mut memory);
        amd::order(&mut unknowns, &mut positions, pattern, amd::Control::default(), stack)
            .map_err(too_large)?;
        Ok(Ordering::new(unknowns).postordered(&Adjacency::new(matrix)))
    }

    /// Nested dissection for a saddle point `[A, B^T; B, -C]` with `A` positive definite and `C`
    /// small, even zero.
    ///
    /// The `multipliers` belong to the second row (pressures). Each is paired with one unknown of
    /// the first row (a velocity component): the one with the largest entry of `B` that is still
    /// free, if possible on a node without a multiplier, multipliers with the fewest entries first.
    /// The graph of the pairs is dissected, and each velocity is eliminated before its pressure: no
    /// pressure is eliminated while its pivot is still the tiny `-C`. For Taylor-Hood elements
    /// LDL^T without pivoting is then accurate to rounding. Depends on the values of `B`: fill the
    /// matrix first.
    ///
    /// Late multipliers (constants of cells in a discontinuous pressure) are eliminated after all
    /// their neighbours of the first row: an edge couples equally with the constant of a cell and
    /// with the pressure at the opposite vertex, so that one velocity per multiplier does not
    /// suffice.
    ///
    /// # Errors
    /// Computation, if the matrix is too large for METIS; internal, if there are fewer unknowns
    /// than come before the first multiplier.
    pub fn saddle_point(
        matrix: &SymmetricMatrix,
        multipliers: impl Into<Multipliers>,
    ) -> Result<Ordering> {
        let Multipliers { first: first_multiplier, first_late, first_unpaired } =
            multipliers.into();
        if first_multiplier > matrix.order() {
            return Err(Error::internal(format!(
                "a matrix of {} unknowns cannot have its first multiplier at {first_multiplier}",
                matrix.order()
            )));
        }
        let paired = first_multiplier..first_unpaired.min(matrix.order());
        let blocks = Blocks::from_partners(&partners(matrix, paired));
        Ordering::of_blocks(&Adjacency::new(matrix), &blocks, first_late)
    }

    /// The unknowns in the order of their elimination.
    pub fn unknowns(&self) -> &[usize] {
        &self.unknowns
    }

    /// Position of every unknown in the order of elimination.
    pub fn positions(&self) -> &[usize] {
        &self.positions
    }

    fn of_blocks(adjacency: &Adjacency, blocks: &Blocks, first_late: usize) -> Result<Ordering> {
        let order = blocks.graph(adjacency)?.nested_dissection()?;
        let expanded =
            Ordering::new(order.into_iter().flat_map(|b| blocks.members(b)).copied().collect());
        Ok(expanded.delayed(adjacency, first_late).postordered(adjacency))
    }

    /// The same order, but each unknown from `first_late` on follows the last of its neighbours
    /// among the others.
    fn delayed(self, adjacency: &Adjacency, first_late: usize) -> Ordering {
        let n = self.unknowns.len();
        if first_late >= n {
            return self;
        }
        let place = |i: usize| {
            let neighbours =
                adjacency.neighbours(i).iter().filter(|&&j| i >= first_late && j < first_late);
            let last = neighbours.map(|&j| self.positions[j]).fold(self.positions[i], usize::max);
            (last, i >= first_late)
        };
        let mut unknowns = self.unknowns.clone();
        unknowns.sort_by_cached_key(|&i| place(i));
        Ordering::new(unknowns)
    }

    fn new(unknowns: Vec<usize>) -> Ordering {
        let mut positions = vec![0; unknowns.len()];
        for (k, &i) in unknowns.iter().enumerate() {
            positions[i] = k;
        }
        Ordering { unknowns, positions }
    }

    /// An equivalent order in which every subtree of the elimination tree is contiguous: the same
    /// fill, and columns of the same pattern next to each other, so that supernodes are large.
    fn postordered(&self, adjacency: &Adjacency) -> Ordering {
        let parents = self.elimination_tree(adjacency);
        let n = parents.len();
        let mut first_child = vec![NONE; n];
        let mut sibling = vec![NONE; n];
        for k in (0..n).rev().filter(|&k| parents[k] != NONE) {
            sibling[k] = first_child[parents[k]];
            first_child[parents[k]] = k;
        }
        let mut unknowns = Vec::with_capacity(n);
        let mut path = Vec::new();
        for root in (0..n).filter(|&k| parents[k] == NONE) {
            path.push(root);
            while let Some(&node) = path.last() {
                let child = first_child[node];
                if child == NONE {
                    unknowns.push(self.unknowns[node]);
                    path.pop();
                } else {
                    first_child[node] = sibling[child];
                    path.push(child);
                }
            }
        }
        Ordering::new(unknowns)
    }

    /// The parent of every position in the elimination tree, [`NONE`] for a root.
    ///
    /// J. W. H. Liu, *The role of elimination trees in sparse factorization*, 1990, with path
    /// compression.
    fn elimination_tree(&self, adjacency: &Adjacency) -> Vec<usize> {
        let n = self.unknowns.len();
        let mut parents = vec![NONE; n];
        let mut ancestors = vec![NONE; n];
        for (k, &unknown) in self.unknowns.iter().enumerate() {
            for &neighbour in adjacency.neighbours(unknown) {
                let mut node = self.positions[neighbour];
                while node < k {
                    let next = std::mem::replace(&mut ancestors[node], k);
                    if next == NONE {
                        parents[node] = k;
                    }
                    node = next;
                }
            }
        }
        parents
    }
}

/// The unknown that every multiplier is paired with, [`NONE`] for all other unknowns and where none
/// is free.
///
/// Of the unknowns with the same multipliers (the velocity components of a node) only one is paired
/// while there is another choice: with three pressures on the components of one node near the
/// corner of a box their block of `B` is singular, and elimination meets a zero pivot.
fn partners(matrix: &SymmetricMatrix, paired: Range<usize>) -> Vec<usize> {
    let first_multiplier = paired.start;
    // An entry must be larger by this factor to win over an earlier one: equal ones differ by
    // rounding.
    const CLEARLY_LARGER: f64 = 1.0001;
    let entries = |p: usize| {
        let (rows, values) = matrix.column(p);
        let end = rows.partition_point(|&i| i < first_multiplier);
        rows[..end].iter().copied().zip(values.iter().map(|v| v.abs()))
    };
    let mut multipliers: Vec<usize> = paired.collect();
    // Unknowns of one node: those with the same multipliers, distinguished by a hash of their list.
    let mut node = vec![0_u64; first_multiplier];
    for &p in &multipliers {
        for (i, _) in entries(p) {
            node[i] = (node[i] ^ p as u64).wrapping_mul(0x0100_0000_01b3);
        }
    }
    multipliers.sort_by_key(|&p| entries(p).len());
    let mut taken = vec![false; first_multiplier];
    let mut taken_nodes = HashSet::new();
    let mut partners = vec![NONE; matrix.order()];
    for p in multipliers {
        let mut largest = (false, 0.0);
        for (i, size) in entries(p).filter(|&(i, _)| !taken[i]) {
            let fresh = !taken_nodes.contains(&node[i]);
            if size > 0.0
                && ((fresh && !largest.0)
                    || (fresh == largest.0 && size > CLEARLY_LARGER * largest.1))
            {
                (largest, partners[p]) = ((fresh, size), i);
            }
        }
        if let Some(taken) = taken.get_mut(partners[p]) {
            *taken = true;
            taken_nodes.insert(node[partners[p]]);
        }
    }
    partners
}

/// The neighbours of every unknown, from both triangles and without itself.
struct Adjacency {
    starts: Vec<usize>,
    neighbours: Vec<usize>,
}

impl Adjacency {
    fn new(matrix: &SymmetricMatrix) -> Adjacency {
        let n = matrix.order();
        let pairs = || {
            (0..n)
                .flat_map(|j| matrix.column(j).0.iter().map(move |&i| (i, j)))
                .filter(|(i, j)| i < j)
        };
        let mut starts = vec![0; n + 1];
        for (i, j) in pairs() {
            starts[i + 1] += 1;
            starts[j + 1] += 1;
        }
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut neighbours = vec![0; starts[n]];
        for (i, j) in pairs() {
            for (a, b) in [(i, j), (j, i)] {
                neighbours[next[a]] = b;
                next[a] += 1;
            }
        }
        Adjacency { starts, neighbours }
    }

    fn neighbours(&self, unknown: usize) -> &[usize] {
        &self.neighbours[self.starts[unknown]..self.starts[unknown + 1]]
    }
}

/// A partition of the unknowns into blocks that are eliminated together, each in the order of its
/// members.
struct Blocks {
    starts: Vec<usize>,
    members: Vec<usize>,
    of_unknown: Vec<usize>,
}

impl Blocks {
    /// Every unknown is in the block of its partner, if it has one (an earlier unknown); otherwise
    /// it starts a block.
    fn from_partners(partners: &[usize]) -> Blocks {
        let n = partners.len();
        let mut guest = vec![NONE; n];
        for (p, &host) in partners.iter().enumerate().filter(|&(_, &host)| host != NONE) {
            guest[host] = p;
        }
        let mut blocks =
            Blocks { starts: vec![0], members: Vec::with_capacity(n), of_unknown: vec![0; n] };
        for host in (0..n).filter(|&i| partners[i] == NONE) {
            for member in [host, guest[host]].into_iter().filter(|&member| member != NONE) {
                blocks.of_unknown[member] = blocks.starts.len() - 1;
                blocks.members.push(member);
            }
            blocks.starts.push(blocks.members.len());
        }
        blocks
    }

    fn members(&self, block: usize) -> &[usize] {
        &self.members[self.starts[block]..self.starts[block + 1]]
    }

    /// The graph of the blocks, weighted by their numbers of members.
    fn graph(&self, adjacency: &Adjacency) -> Result<Graph> {
        let count = self.starts.len() - 1;
        let mut graph =
            Graph { starts: vec![0], neighbours: Vec::new(), weights: Vec::with_capacity(count) };
        let mut last_seen_by = vec![NONE; count];
        for block in 0..count {
            last_seen_by[block] = block;
            for &member in self.members(block) {
                for &neighbour in adjacency.neighbours(member) {
                    let other = self.of_unknown[neighbour];
                    if last_seen_by[other] != block {
                        last_seen_by[other] = block;
                        graph.neighbours.push(metis::size(other)?);
                    }
                }
            }
            graph.starts.push(metis::size(graph.neighbours.len())?);
            graph.weights.push(metis::size(self.members(block).len())?);
        }
        Ok(graph)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{laplacian, stokes};
    use super::*;

    /// Entries of the factor, by elimination on the pattern.
    fn fill(matrix: &SymmetricMatrix, ordering: &Ordering) -> usize {
        let adjacency = Adjacency::new(matrix);
        let n = matrix.order();
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); n];
        let mut total = n;
        for k in 0..n {
            let neighbours =
                adjacency.neighbours(ordering.unknowns[k]).iter().map(|&i| ordering.positions[i]);
            below[k].extend(neighbours.filter(|&i| i > k));
            below[k].sort_unstable();
            below[k].dedup();
            total += below[k].len();
            if let Some(&parent) = below[k].first() {
                let inherited: Vec<usize> = below[k][1..].to_vec();
                below[parent].extend(inherited);
            }
        }
        total
    }

    fn natural(n: usize) -> Ordering {
        Ordering::new((0..n).collect())
    }

    #[test]
    fn an_ordering_is_a_permutation_and_always_the_same() {
        let a = laplacian(40, 0.0);
        let ordering = Ordering::plain(&a).unwrap();
        let mut sorted = ordering.unknowns.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..1600).collect::<Vec<_>>());
        assert!((0..1600).all(|k| ordering.positions[ordering.unknowns[k]] == k));
        let again: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> =
                (0..4).map(|_| scope.spawn(|| Ordering::plain(&a).unwrap())).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(again.iter().all(|other| *other == ordering));
    }

    #[test]
    fn dissection_fills_in_less_than_the_natural_order() {
        let a = laplacian(60, 0.0);
        let dissected = fill(&a, &Ordering::plain(&a).unwrap());
        // The natural order fills the band: 60^3 entries. Nested dissection: (31/8) n^2 log2 n,
        // about 82 000.
        assert!(fill(&a, &natural(3600)) > 200_000);
        assert!(dissected < 90_000, "{dissected}");
        let by_degree = Ordering::minimum_degree(&a).unwrap();
        assert!(fill(&a, &by_degree) < 110_000, "{}", fill(&a, &by_degree));
    }

    #[test]
    fn postordering_keeps_the_fill_and_makes_parents_follow_their_last_child() {
        let a = laplacian(20, 0.0);
        let adjacency = Adjacency::new(&a);
        let checkerboard = Ordering::new((0..400).step_by(2).chain((1..400).step_by(2)).collect());
        let ordered = checkerboard.postordered(&adjacency);
        assert_eq!(fill(&a, &checkerboard), fill(&a, &ordered));
        let parents = ordered.elimination_tree(&adjacency);
        for k in 0..400 {
            let has_child = parents.contains(&k);
            assert!(!has_child || parents[k - 1] == k, "{k}");
        }
        assert_eq!(ordered.postordered(&adjacency), ordered);
    }

    #[test]
    fn every_pressure_follows_a_velocity_of_its_own() {
        let (a, first) = stokes(12, 1.0, 1.0, 0.0);
        let partners = partners(&a, first..a.order());
        let mut hosts: Vec<usize> = partners[first..].to_vec();
        hosts.sort_unstable();
        hosts.dedup();
        assert_eq!(hosts.len(), a.order() - first, "each has one of its own");
        assert!(hosts.iter().all(|&i| i < first) && partners[..first].iter().all(|&i| i == NONE));
        let ordering = Ordering::saddle_point(&a, first).unwrap();
        for p in first..a.order() {
            assert!(ordering.positions[partners[p]] < ordering.positions[p]);
        }
    }

    #[test]
    fn partners_are_the_largest_entries_on_nodes_that_are_left() {
        // Velocities 0, 1, 2; pressure 3 sees all of them, 4 sees 1 and 2, 5 sees none: 1 and 2 are
        // of one node.
        let mut a =
            SymmetricMatrix::from_groups(6, [[0, 3], [1, 3], [2, 3], [1, 4], [2, 4]].iter())
                .unwrap();
        for (i, p, b) in [(0, 3, 1.0), (1, 3, -4.0), (2, 3, 2.0), (1, 4, 3.0), (2, 4, -2.5)] {
            a.add_group(&[i, p], &[1.0, b, b, 0.0]).unwrap();
        }
        assert_eq!(partners(&a, 3..6), [NONE, NONE, NONE, 0, 1, NONE]);
        // Without velocity 0 there is no other choice than the second component of the node.
        let mut a =
            SymmetricMatrix::from_groups(4, [[0, 2], [1, 2], [0, 3], [1, 3]].iter()).unwrap();
        for (i, p, b) in [(0, 2, 3.0), (1, 2, 1.0), (0, 3, 4.0), (1, 3, 2.0)] {
            a.add_group(&[i, p], &[1.0, b, b, 0.0]).unwrap();
        }
        assert_eq!(partners(&a, 2..4), [NONE, NONE, 0, 1]);
    }

    #[test]
    fn matrices_without_couplings_can_be_ordered() {
        for n in [0, 1, 2, 1000] {
            let groups = (0..n).map(|i| [i]);
            let a = SymmetricMatrix::from_groups(n as usize, groups).unwrap();
            assert_eq!(Ordering::plain(&a).unwrap().unknowns.len(), n as usize);
        }
        // One coupled pair among many single unknowns.
        let a = SymmetricMatrix::from_groups(1000, [[3, 900]].iter()).unwrap();
        assert_eq!(Ordering::saddle_point(&a, 500).unwrap().unknowns.len(), 1000);
        assert!(Ordering::saddle_point(&a, 1001).is_err());
    }

    #[test]
    fn graphs_are_symmetric_and_without_loops() {
        let (a, first) = stokes(8, 1.0, 1.0, 0.0);
        let blocks = Blocks::from_partners(&partners(&a, first..a.order()));
        let graph = blocks.graph(&Adjacency::new(&a)).unwrap();
        let count = graph.weights.len();
        assert_eq!(count, first, "every pressure has a partner");
        assert_eq!(graph.starts.len(), count + 1);
        assert_eq!(*graph.starts.last().unwrap() as usize, graph.neighbours.len());
        assert_eq!(graph.weights.iter().sum::<i32>() as usize, a.order());
        let of =
            |v: usize| &graph.neighbours[graph.starts[v] as usize..graph.starts[v + 1] as usize];
        for v in 0..count {
            for &w in of(v) {
                assert!(w as usize != v && of(w as usize).contains(&(v as i32)));
            }
        }
    }
}
