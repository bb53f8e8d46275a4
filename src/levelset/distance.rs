//! Distance to a set of straight segments (in space: triangles), by a bounding-box tree.

use crate::mesh::Point;
use nalgebra::SVector;

/// Largest number of parts in a leaf of the tree.
const LEAF: usize = 8;

/// Segments (`D = 2`) or triangles (`D = 3`) in a balanced binary tree of axis-aligned boxes: the
/// children of the box over `low..high` are its halves; the children of box `k` are the boxes
/// `2 k + 1` and `2 k + 2`.
#[derive(Clone, Debug)]
pub(super) struct Tree<const D: usize> {
    parts: Vec<Part<D>>,
    boxes: Vec<(Point<D>, Point<D>)>,
}

/// Corners and number of a part.
type Part<const D: usize> = ([Point<D>; D], u32);

/// The difference to the nearest part so far: its square, itself, and the number of the part.
type Best<const D: usize> = (f64, SVector<f64, D>, u32);

impl<const D: usize> Tree<D> {
    /// The tree over `parts`; the distance is infinite if there are none.
    pub(super) fn new(parts: Vec<[Point<D>; D]>) -> Tree<D> {
        let mut parts: Vec<Part<D>> = parts.into_iter().zip(0..).collect();
        let levels = parts.len().div_ceil(LEAF).next_power_of_two();
        let mut boxes = vec![(Point::<D>::zeros(), Point::<D>::zeros()); 2 * levels - 1];
        build(&mut parts, &mut boxes, 0);
        Tree { parts, boxes }
    }
    /// Lower and upper corner of the box around everything.
    pub(super) fn bounds(&self) -> (Point<D>, Point<D>) {
        self.boxes[0]
    }
    /// Distance from `x` to the nearest part.
    pub(super) fn distance(&self, x: &Point<D>) -> f64 {
        self.difference(x).norm()
    }
    /// `x` minus the nearest point.
    pub(super) fn difference(&self, x: &Point<D>) -> SVector<f64, D> {
        self.nearest(x).1
    }
    /// Number of the nearest part in the given list, and `x` minus its nearest point.
    pub(super) fn nearest(&self, x: &Point<D>) -> (usize, SVector<f64, D>) {
        let mut best = (f64::INFINITY, Point::<D>::repeat(f64::INFINITY), 0);
        self.search(x, 0, &self.parts, &mut best);
        (best.2 as usize, best.1)
    }
    fn search(&self, x: &Point<D>, node: usize, part: &[Part<D>], best: &mut Best<D>) {
        if part.len() <= LEAF {
            for (simplex, number) in part {
                let difference = difference(x, simplex);
                let square = difference.norm_squared();
                if square < best.0 {
                    *best = (square, difference, *number);
                }
            }
            return;
        }
        let (left, right) = part.split_at(part.len() / 2);
        let near = |k: usize| box_distance_squared(x, &self.boxes[k]);
        let children =
            [(near(2 * node + 1), 2 * node + 1, left), (near(2 * node + 2), 2 * node + 2, right)];
        let order = if children[0].0 <= children[1].0 { [0, 1] } else { [1, 0] };
        for i in order {
            let (distance, child, part) = children[i];
            if distance < best.0 {
                self.search(x, child, part, best);
            }
        }
    }
}

fn build<const D: usize>(part: &mut [Part<D>], boxes: &mut [(Point<D>, Point<D>)], node: usize) {
    let Some(first) = part.first() else { return };
    let corners = part.iter().flat_map(|p| &p.0);
    let (low, high) =
        corners.fold((first.0[0], first.0[0]), |(low, high), a| (low.inf(a), high.sup(a)));
    boxes[node] = (low, high);
    if part.len() <= LEAF {
        return;
    }
    let axis = (high - low).imax();
    let half = part.len() / 2;
    let sum = |s: &Part<D>| s.0.iter().map(|a| a[axis]).sum::<f64>();
    part.select_nth_unstable_by(half, |a, b| sum(a).total_cmp(&sum(b)));
    let (left, right) = part.split_at_mut(half);
    build(left, boxes, 2 * node + 1);
    build(right, boxes, 2 * node + 2);
}

/// `x` minus the nearest point of a segment or triangle.
fn difference<const D: usize>(x: &Point<D>, s: &[Point<D>; D]) -> SVector<f64, D> {
    if D < 3 {
        return from_segment(x, &s[0], &s[1]);
    }
    let (u, v, w) = (s[1] - s[0], s[D - 1] - s[0], x - s[0]);
    let (uu, uv, vv, wu, wv) =
        (u.norm_squared(), u.dot(&v), v.norm_squared(), w.dot(&u), w.dot(&v));
    let determinant = uu * vv - uv * uv;
    let (a, b) = ((vv * wu - uv * wv) / determinant, (uu * wv - uv * wu) / determinant);
    if a >= 0.0 && b >= 0.0 && a + b <= 1.0 {
        return w - u * a - v * b;
    }
    let sides = [(0, 1), (1, D - 1), (D - 1, 0)].map(|(i, j)| from_segment(x, &s[i], &s[j]));
    sides
        .into_iter()
        .reduce(|a, b| if b.norm_squared() < a.norm_squared() { b } else { a })
        .unwrap_or(w)
}

fn from_segment<const D: usize>(x: &Point<D>, a: &Point<D>, b: &Point<D>) -> SVector<f64, D> {
    let (ab, ax) = (b - a, x - a);
    let length = ab.norm_squared();
    let t = if length > 0.0 { (ax.dot(&ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    ax - ab * t
}

fn box_distance_squared<const D: usize>(x: &Point<D>, (low, high): &(Point<D>, Point<D>)) -> f64 {
    (low - x).sup(&(x - high)).sup(&Point::<D>::zeros()).norm_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_tree_finds_the_nearest_of_all_segments(
            ends in prop::collection::vec(prop::array::uniform4(-1.0..1.0f64), 1..200), x in -2.0..2.0f64, y in -2.0..2.0f64,
        ) {
            let segments: Vec<_> = ends.iter().map(|e| [Point::<2>::new(e[0], e[1]), Point::<2>::new(e[2], e[3])]).collect();
            let x = Point::<2>::new(x, y);
            let all = segments.iter().map(|[a, b]| from_segment(&x, a, b).norm_squared()).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(Tree::new(segments).distance(&x), all.sqrt());
        }
    }

    #[test]
    fn a_segment_without_length_is_a_point() {
        let a = Point::<2>::new(1.0, 0.0);
        assert_eq!(Tree::new(vec![[a, a]]).distance(&Point::<2>::new(4.0, 4.0)), 5.0);
    }

    proptest! {
        /// Nothing sampled on the triangles is nearer, and the nearest point lies on one of them.
        #[test]
        fn the_nearest_point_of_triangles_is_found(
            corners in prop::collection::vec(prop::array::uniform9(-1.0..1.0f64), 1..60), x in prop::array::uniform3(-2.0..2.0f64),
        ) {
            let p = |e: &[f64]| Point::<3>::new(e[0], e[1], e[2]);
            let triangles: Vec<_> = corners.iter().map(|e| [p(&e[..3]), p(&e[3..6]), p(&e[6..])]).collect();
            let x = Point::<3>::from(x);
            let n = 40;
            let mut sampled = f64::INFINITY;
            for [a, b, c] in &triangles {
                for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                    let (s, t) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                    sampled = sampled.min((a + (b - a) * s + (c - a) * t - x).norm());
                }
            }
            let d = Tree::new(triangles).distance(&x);
            prop_assert!(d <= sampled + 1e-14 && sampled <= d + 0.06, "{} {}", d, sampled);
        }
    }
}
