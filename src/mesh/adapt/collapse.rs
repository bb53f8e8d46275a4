//! Removal of short edges by edge collapse.

use super::triangulation::{Freedom, Side, Triangulation};
use super::{LONG, SHORT};
use crate::mesh::NONE;

/// Least quality of triangles after a collapse, or the worst before it if that is less.
const FLOOR: f64 = 0.3;

/// Removes edges shorter than [`SHORT`], the shortest first, if no edge becomes too long and no
/// triangle bad; returns their number.
pub(super) fn collapse_short(t: &mut Triangulation) -> usize {
    let mut short: Vec<(f64, [u32; 2])> = t
        .sides()
        .map(|s| t.ends(s))
        .map(|[a, b]| (t.length(a, b), [a, b]))
        .filter(|(length, _)| *length < SHORT)
        .collect();
    short.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut star = Vec::new();
    let mut count = 0;
    for (_, [a, b]) in short {
        // Removed vertices have no triangle any more.
        let both = [a, b].iter().all(|&v| t.vertices[v as usize].triangle != NONE);
        let ways =
            [(a, b), (b, a)].map(|(v, w)| if both { worst_after(t, v, w, &mut star) } else { 0.0 });
        let (v, w) = if ways[0] >= ways[1] { (a, b) } else { (b, a) };
        if ways[0].max(ways[1]) > 0.0 {
            collapse(t, v, w, &mut star);
            count += 1;
        }
    }
    count
}

/// Worst quality around `v` after moving it to `w`; 0 if the collapse is not allowed.
fn worst_after(t: &Triangulation, v: u32, w: u32, star: &mut Vec<Side>) -> f64 {
    let kind = t.vertices[v as usize].kind;
    if kind == Freedom::Fixed {
        return 0.0;
    }
    t.star(v, star);
    let (mut before, mut after): (f64, f64) = (f64::INFINITY, f64::INFINITY);
    let mut adjacent = false;
    for corner in star.iter() {
        let old = t.triangles[corner.triangle as usize].vertices;
        before = before.min(t.quality(old));
        if old.contains(&w) {
            let along = t.side_of(corner.triangle, v, w).is_some_and(|s| t.is_kept(s));
            adjacent |= kind == Freedom::Free || along;
            continue;
        }
        let mut new = old;
        new[corner.opposite] = w;
        after = after.min(t.quality(new));
        let [p, q] = t.ends(*corner);
        if after <= 0.0 || t.length(w, p) > LONG || t.length(w, q) > LONG {
            return 0.0;
        }
    }
    if adjacent && after.is_finite() && after >= FLOOR.min(before) { after } else { 0.0 }
}

/// Moves `v` to `w`: the triangles with both disappear; in the other triangles of `v` it is
/// replaced by `w`.
fn collapse(t: &mut Triangulation, v: u32, w: u32, star: &mut Vec<Side>) {
    t.star(v, star);
    for corner in star.iter() {
        let old = t.triangles[corner.triangle as usize];
        let Some(k) = old.vertices.iter().position(|&x| x == w) else { continue };
        // Sides opposite to `w` (inside the star) and to `v` (on its rim) become one.
        let inner = t.twin(Side { triangle: corner.triangle, opposite: k });
        let rim = t.twin(*corner);
        if let Some(inner) = inner {
            t.triangles[inner.triangle as usize].sides[inner.opposite] = old.sides[corner.opposite];
            t.link(inner, rim);
        }
        t.remove(corner.triangle);
    }
    for corner in star.iter() {
        let mut new = t.triangles[corner.triangle as usize];
        if new.vertices[0] != NONE {
            new.vertices[corner.opposite] = w;
            t.put(corner.triangle, new);
        }
    }
    t.remove_vertex(v);
}
