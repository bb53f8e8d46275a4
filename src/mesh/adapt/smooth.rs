//! Smoothing: vertices move towards positions where their edges have unit length.

use super::triangulation::{Freedom, Side, Triangulation};
use crate::mesh::Point;

/// Fractions of the move that are tried.
const STEPS: [f64; 3] = [1.0, 0.5, 0.25];
/// Least factor by which a move must improve the [mean quality](mean_quality).
const GAIN: f64 = 1.002;
/// Quality below which the vertices of a triangle are tried again even if nothing has changed
/// around them.
const POOR: f64 = 0.7;

/// Marks the vertices of poor triangles for a move.
pub(super) fn mark_poor(t: &mut Triangulation) {
    let poor: Vec<[u32; 3]> = t
        .alive()
        .map(|c| t.triangles[c as usize].vertices)
        .filter(|v| t.quality(*v) < POOR)
        .collect();
    poor.into_iter().flatten().for_each(|v| t.vertices[v as usize].pending = true);
}

/// Moves each marked vertex once, if the surrounding triangles improve.
pub(super) fn smooth_all(t: &mut Triangulation) {
    let mut star = Vec::new();
    for v in 0..t.vertices.len() as u32 {
        if std::mem::take(&mut t.vertices[v as usize].pending) && smooth(t, v, &mut star) {
            for side in &star {
                t.triangles[side.triangle as usize]
                    .vertices
                    .into_iter()
                    .for_each(|v| t.vertices[v as usize].pending = true);
            }
        }
    }
}

fn smooth(t: &mut Triangulation, v: u32, star: &mut Vec<Side>) -> bool {
    let old = t.vertices[v as usize];
    if old.kind == Freedom::Fixed || old.triangle == crate::mesh::NONE {
        return false;
    }
    t.star(v, star);
    let before = mean_quality(t, star);
    let Some(wanted) =
        (if old.kind == Freedom::Free { balance(t, v, star) } else { balance_on_line(t, v, star) })
    else {
        return false;
    };
    for step in STEPS {
        let point = old.point + (wanted - old.point) * step;
        let metric = t.background.at(&old.metric, &point);
        let vertex = &mut t.vertices[v as usize];
        (vertex.point, vertex.metric) = (point, metric);
        if mean_quality(t, star) > GAIN * before {
            return true;
        }
    }
    t.vertices[v as usize] = old;
    false
}

/// Mean of the qualities `q` around a vertex, `n / sum q^-3`: dominated by bad triangles, 0 if one
/// is flat or inverted.
fn mean_quality(t: &Triangulation, star: &[Side]) -> f64 {
    let badness = |s: &Side| t.quality(t.triangles[s.triangle as usize].vertices).powi(-3);
    star.len() as f64 / star.iter().map(badness).sum::<f64>()
}

/// Mean of the positions at which each edge of `v` has unit length.
fn balance(t: &Triangulation, v: u32, star: &[Side]) -> Option<Point<2>> {
    let places = star.iter().map(|s| unit_place(t, v, t.ends(*s)[0]));
    Some(places.fold(Point::<2>::zeros(), |s, p| s + p) / star.len() as f64)
}

/// The point at unit length from `other` in the direction of `v`.
fn unit_place(t: &Triangulation, v: u32, other: u32) -> Point<2> {
    let (p, q) = (t.vertices[v as usize].point, t.vertices[other as usize].point);
    q + (p - q) / t.length(v, other)
}

/// The same with the two neighbours on the line, kept on it.
fn balance_on_line(t: &Triangulation, v: u32, star: &[Side]) -> Option<Point<2>> {
    let mut ends = star.iter().flat_map(|s| {
        // The sides of the triangle at `v`.
        [1, 2].map(|k| Side { triangle: s.triangle, opposite: (s.opposite + k) % 3 })
    });
    let mut next = || {
        let side = ends.find(|s| t.is_kept(*s))?;
        t.ends(side).into_iter().find(|&x| x != v)
    };
    let first = next()?;
    let second = std::iter::from_fn(next).find(|&x| x != first)?;
    let (a, b) = (t.vertices[first as usize].point, t.vertices[second as usize].point);
    let place = (unit_place(t, v, first) + unit_place(t, v, second)) * 0.5;
    let part = (place - a).dot(&(b - a)) / (b - a).norm_squared();
    Some(a + (b - a) * part.clamp(0.05, 0.95))
}
