//! Which cells share a facet.

use super::{Facet, NONE, Point};
use crate::base::{Error, Result};
use std::collections::HashMap;

/// Neighbours of all cells, and the facets that have none.
pub(super) fn connect<const D: usize>(points: &[Point<D>], cells: &[u32]) -> Result<(Vec<u32>, Vec<Facet>)> {
    let mut neighbours = vec![NONE; cells.len()];
    let mut open: HashMap<[u32; 3], (u32, bool)> = HashMap::with_capacity(cells.len());
    let vertices = |slot: usize| &cells[slot / (D + 1) * (D + 1)..][..D + 1];
    let refuse = |what: &str, key: &[u32; 3], slots: &[usize], remedy: &str| {
        let at: Vec<_> = key[..D].iter().map(|&v| points[v as usize].as_slice().to_vec()).collect();
        let numbers: Vec<_> = slots.iter().map(|s| s / (D + 1)).collect();
        Error::input(what)
            .at(format!("cell {} (counted from 0), facet with points {at:?}", numbers[0]))
            .value(format!("cells {numbers:?}"))
            .remedy(remedy)
    };
    for slot in 0..cells.len() {
        let k = slot % (D + 1);
        let key = facet_key::<D>(vertices(slot), k);
        let Some((other, used)) = open.get_mut(&key) else {
            open.insert(key, (slot as u32, false));
            continue;
        };
        let other = *other as usize;
        if *used {
            let second = neighbours[other] as usize * (D + 1);
            return Err(refuse(
                "a facet belongs to more than two cells: the mesh is not a manifold",
                &key,
                &[slot, other, second],
                "look for cells that are stored twice or overlap",
            ));
        }
        if facet_parity(vertices(slot), k) == facet_parity(vertices(other), other % (D + 1)) {
            return Err(refuse(
                "two cells overlap: they lie on the same side of the facet they share",
                &key,
                &[slot, other],
                "look for cells that are stored twice, and for a surface that is folded or meshed twice",
            ));
        }
        neighbours[slot] = (other / (D + 1)) as u32;
        neighbours[other] = (slot / (D + 1)) as u32;
        *used = true;
    }
    let facets = (0..cells.len())
        .filter(|&s| neighbours[s] == NONE)
        .map(|s| Facet { cell: (s / (D + 1)) as u32, opposite: (s % (D + 1)) as u32 })
        .collect();
    Ok((neighbours, facets))
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

/// Whether the facet opposite to vertex `k`, seen from inside the (positively oriented) cell, takes an odd number of
/// exchanges to sort: different for the two cells of a facet.
fn facet_parity(cell: &[u32], k: usize) -> bool {
    let mut odd = k % 2 == 1;
    for i in (0..cell.len()).filter(|&i| i != k) {
        for j in (0..i).filter(|&j| j != k) {
            odd ^= cell[j] > cell[i];
        }
    }
    odd
}
