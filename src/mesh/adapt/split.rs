//! Splitting of long edges.

use super::triangulation::{Freedom, Side, Triangle, Triangulation, Vertex};
use super::{LONG, measure};

/// Least quality of triangles after a split, unless the split triangle was worse.
const FLOOR: f64 = 0.1;

/// Splits edges longer than [`LONG`] once each, the longest first, until there are `most` vertices;
/// returns their number.
pub(super) fn split_long(t: &mut Triangulation, most: usize) -> usize {
    let mut long: Vec<(f64, Side, [u32; 2])> = t
        .sides()
        .filter(|&s| !(t.frozen_boundary && t.is_boundary(s)))
        .map(|s| (s, t.ends(s)))
        .map(|(s, [a, b])| (t.length(a, b), s, [a, b]))
        .filter(|(length, ..)| *length > LONG)
        .collect();
    long.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
    let mut count = 0;
    for (_, side, [a, b]) in long {
        // The edge still exists, but an earlier split may have moved it within its triangle or to a
        // new one.
        let at = t.side_of(side.triangle, a, b);
        if t.vertex_count() < most
            && let Some(side) = at
        {
            count += usize::from(split(t, side));
        }
    }
    count
}

/// Splits a side at the middle of its metric length, unless this gives a bad triangle.
fn split(t: &mut Triangulation, side: Side) -> bool {
    let [a, b] = t.ends(side);
    let (from, to) = (t.vertices[a as usize], t.vertices[b as usize]);
    let part = measure::middle(&from.point, &from.metric.tensor, &to.point, &to.metric.tensor);
    let point = from.point + (to.point - from.point) * part.clamp(0.1, 0.9);
    let metric = t.background.at(&from.metric, &point);
    let kind = if t.is_kept(side) { Freedom::Line } else { Freedom::Free };
    let m = t.add_vertex(Vertex { point, metric, kind, triangle: side.triangle, pending: true });
    let twin = t.twin(side);
    let fits = |s: Side| {
        let c = t.triangles[s.triangle as usize].vertices[s.opposite];
        let [a, b] = t.ends(s);
        let worst = t.quality([c, a, m]).min(t.quality([c, m, b]));
        worst > 0.0 && worst >= FLOOR.min(t.quality([c, a, b]))
    };
    if !(fits(side) && twin.is_none_or(fits)) {
        t.remove_vertex(m);
        return false;
    }
    let [first, second] = halve(t, side, m);
    if let Some(twin) = twin {
        let [near, far] = halve(t, twin, m);
        // The twin runs the other way.
        t.link(first, Some(far));
        t.link(second, Some(near));
    } else {
        t.link(first, None);
        t.link(second, None);
    }
    true
}

/// Cuts the triangle `(c, a, b)` of a side `(a, b)` into `(c, a, m)` and `(c, m, b)`; returns their
/// sides opposite to `c`.
fn halve(t: &mut Triangulation, side: Side, m: u32) -> [Side; 2] {
    let old = t.triangles[side.triangle as usize];
    let (c, a, b) = (side.opposite, (side.opposite + 1) % 3, (side.opposite + 2) % 3);
    let beyond = t.twin(Side { triangle: side.triangle, opposite: a });
    let new = |vertices, sides| Triangle {
        vertices,
        neighbours: [crate::mesh::NONE; 3],
        sides,
        region: old.region,
    };
    let [pc, pa, pb] = [c, a, b].map(|k| old.vertices[k]);
    let [sc, sa, sb] = [c, a, b].map(|k| old.sides[k]);
    let kept = t.twin(Side { triangle: side.triangle, opposite: b });
    t.put(side.triangle, new([pc, pa, m], [sc, 0, sb]));
    let other = t.add(new([pc, m, pb], [sc, sa, 0]));
    t.link(Side { triangle: side.triangle, opposite: 2 }, kept);
    t.link(Side { triangle: other, opposite: 1 }, beyond);
    t.link(
        Side { triangle: side.triangle, opposite: 1 },
        Some(Side { triangle: other, opposite: 2 }),
    );
    [side.triangle, other].map(|triangle| Side { triangle, opposite: 0 })
}
