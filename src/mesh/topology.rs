//! Neighbours of cells across facets.

use super::{Facet, NONE, Point};
use crate::base::{Error, Result};
use rayon::prelude::*;

/// Neighbours of all cells, and the facets without one.
pub(super) fn connect<const D: usize>(
    points: &[Point<D>],
    cells: &[u32],
) -> Result<(Vec<u32>, Vec<Facet>)> {
    let vertices = |slot: u32| &cells[slot as usize / (D + 1) * (D + 1)..][..D + 1];
    let local = |slot: u32| slot as usize % (D + 1);
    let mut sides: Vec<([u32; 3], u32)> = (0..cells.len() as u32)
        .into_par_iter()
        .map(|slot| (facet_key::<D>(vertices(slot), local(slot)), slot))
        .collect();
    sides.par_sort_unstable();
    let mut neighbours = vec![NONE; cells.len()];
    for group in sides.chunk_by(|a, b| a.0 == b.0) {
        match *group {
            [_] => {}
            [(_, a), (_, b)]
                if facet_parity(vertices(a), local(a)) != facet_parity(vertices(b), local(b)) =>
            {
                neighbours[a as usize] = b / (D as u32 + 1);
                neighbours[b as usize] = a / (D as u32 + 1);
            }
            _ => return Err(refuse(points, group)),
        }
    }
    let facets = (0..cells.len())
        .filter(|&s| neighbours[s] == NONE)
        .map(|s| Facet { cell: (s / (D + 1)) as u32, opposite: (s % (D + 1)) as u32 })
        .collect();
    Ok((neighbours, facets))
}

/// The error for a facet that cells do not share as they should.
fn refuse<const D: usize>(points: &[Point<D>], group: &[([u32; 3], u32)]) -> Error {
    let at: Vec<_> =
        group[0].0[..D].iter().map(|&v| points[v as usize].as_slice().to_vec()).collect();
    let numbers: Vec<_> = group.iter().map(|(_, slot)| slot / (D as u32 + 1)).collect();
    let what = if group.len() > 2 {
        "a facet belongs to more than two cells: the mesh is not a manifold"
    } else {
        "two cells overlap: they lie on the same side of the facet they share"
    };
    Error::input(what)
        .at(format!(
            "cell {} (counted from 0), facet with points {at:?}",
            numbers[numbers.len() - 1]
        ))
        .value(format!("cells {numbers:?}"))
        .remedy(
            "look for cells that are stored twice, and for a surface that is folded or meshed \
             twice",
        )
}

/// The sorted point numbers of the facet opposite to vertex `k`; unused entries are [`NONE`].
pub(crate) fn facet_key<const D: usize>(cell: &[u32], k: usize) -> [u32; 3] {
    let mut key = [NONE; 3];
    let mut n = 0;
    for (i, &v) in cell.iter().enumerate() {
        if i != k {
            key[n] = v;
            n += 1;
        }
    }
    key[..n].sort_unstable();
    key
}

/// True if the facet opposite to vertex `k`, seen from inside the (positively oriented) cell, takes
/// an odd number of exchanges to sort: different for the two cells of a facet.
fn facet_parity(cell: &[u32], k: usize) -> bool {
    let mut odd = k % 2 == 1;
    for i in (0..cell.len()).filter(|&i| i != k) {
        for j in (0..i).filter(|&j| j != k) {
            odd ^= cell[j] > cell[i];
        }
    }
    odd
}
