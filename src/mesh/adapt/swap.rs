//! Edge swaps that improve triangles.

use super::triangulation::{Side, Triangle, Triangulation};
use crate::mesh::NONE;

/// Least factor by which a swap must improve the worse of the two triangles.
const GAIN: f64 = 1.001;

/// Swaps edges until no swap is worthwhile; returns their number.
pub(super) fn swap_all(t: &mut Triangulation) -> usize {
    let mut waiting: Vec<Side> = t.sides().collect();
    // Quality only increases, so this ends; the bound is a safeguard against rounding.
    let most = 50 * t.triangles.len();
    let mut count = 0;
    while let Some(side) = waiting.pop() {
        if count < most && swap(t, side) {
            count += 1;
            let twin = t.twin(side).map_or(side.triangle, |s| s.triangle);
            for triangle in [side.triangle, twin] {
                waiting.extend((0..3).map(|opposite| Side { triangle, opposite }));
            }
        }
    }
    count
}

/// Replaces the side `(a, b)` of the triangles `(c, a, b)` and `(d, b, a)` by `(c, d)` if the worse
/// triangle becomes better.
fn swap(t: &mut Triangulation, side: Side) -> bool {
    if t.triangles[side.triangle as usize].vertices[0] == NONE || t.is_kept(side) {
        return false;
    }
    let Some(twin) = t.twin(side) else { return false };
    let corners = |s: Side| {
        [0, 1, 2].map(|k| t.triangles[s.triangle as usize].vertices[(s.opposite + k) % 3])
    };
    let ([c, a, b], [d, ..]) = (corners(side), corners(twin));
    let before = t.quality([c, a, b]).min(t.quality([d, b, a]));
    if t.quality([c, a, d]).min(t.quality([d, b, c])) <= before * GAIN {
        return false;
    }
    // The four sides of the quadrilateral: mark and neighbour.
    let rim = |s: Side, k: usize| {
        let at = Side { triangle: s.triangle, opposite: (s.opposite + k) % 3 };
        (t.triangles[s.triangle as usize].sides[at.opposite], t.twin(at))
    };
    let (bc, ca, ad, db) = (rim(side, 1), rim(side, 2), rim(twin, 1), rim(twin, 2));
    let region = t.triangles[side.triangle as usize].region;
    let new = |vertices, sides| Triangle { vertices, neighbours: [NONE; 3], sides, region };
    let at = |s: Side, opposite| Side { triangle: s.triangle, opposite };
    t.put(side.triangle, new([c, a, d], [ad.0, 0, ca.0]));
    t.put(twin.triangle, new([d, b, c], [bc.0, 0, db.0]));
    t.link(at(side, 0), ad.1);
    t.link(at(side, 2), ca.1);
    t.link(at(twin, 0), bc.1);
    t.link(at(twin, 2), db.1);
    t.link(at(side, 1), Some(at(twin, 1)));
    true
}
