//! Distance to a set of straight segments, by a tree of boxes.

use crate::mesh::Point;

/// Most segments in a leaf of the tree.
const LEAF: usize = 8;

/// Segments in a balanced binary tree of axis-aligned boxes: the one over `low..high` has its halves as children, and box
/// `k` has the boxes `2 k + 1` and `2 k + 2`.
#[derive(Clone, Debug)]
pub(super) struct SegmentTree {
    segments: Vec<[Point<2>; 2]>,
    boxes: Vec<(Point<2>, Point<2>)>,
}

impl SegmentTree {
    /// The tree over `segments`, of which there must be at least one for a finite distance.
    pub(super) fn new(mut segments: Vec<[Point<2>; 2]>) -> SegmentTree {
        let levels = segments.len().div_ceil(LEAF).next_power_of_two();
        let mut boxes = vec![(Point::<2>::zeros(), Point::<2>::zeros()); 2 * levels - 1];
        build(&mut segments, &mut boxes, 0);
        SegmentTree { segments, boxes }
    }
    /// Lower and upper corner of the box around all segments.
    pub(super) fn bounds(&self) -> (Point<2>, Point<2>) {
        self.boxes[0]
    }
    /// Distance from `x` to the nearest segment.
    pub(super) fn distance(&self, x: &Point<2>) -> f64 {
        let mut best = f64::INFINITY;
        self.search(x, 0, &self.segments, &mut best);
        best.sqrt()
    }
    fn search(&self, x: &Point<2>, node: usize, part: &[[Point<2>; 2]], best: &mut f64) {
        if part.len() <= LEAF {
            for [a, b] in part {
                *best = best.min(segment_distance_squared(x, a, b));
            }
            return;
        }
        let (left, right) = part.split_at(part.len() / 2);
        let near = |k: usize| box_distance_squared(x, &self.boxes[k]);
        let children = [(near(2 * node + 1), 2 * node + 1, left), (near(2 * node + 2), 2 * node + 2, right)];
        let order = if children[0].0 <= children[1].0 { [0, 1] } else { [1, 0] };
        for i in order {
            let (distance, child, part) = children[i];
            if distance < *best {
                self.search(x, child, part, best);
            }
        }
    }
}

fn build(part: &mut [[Point<2>; 2]], boxes: &mut [(Point<2>, Point<2>)], node: usize) {
    let Some(first) = part.first() else { return };
    let (low, high) =
        part.iter().fold((first[0], first[0]), |(low, high), [a, b]| (low.inf(a).inf(b), high.sup(a).sup(b)));
    boxes[node] = (low, high);
    if part.len() <= LEAF {
        return;
    }
    let axis = (high - low).imax();
    let half = part.len() / 2;
    part.select_nth_unstable_by(half, |a, b| (a[0][axis] + a[1][axis]).total_cmp(&(b[0][axis] + b[1][axis])));
    let (left, right) = part.split_at_mut(half);
    build(left, boxes, 2 * node + 1);
    build(right, boxes, 2 * node + 2);
}

fn segment_distance_squared(x: &Point<2>, a: &Point<2>, b: &Point<2>) -> f64 {
    let (ab, ax) = (b - a, x - a);
    let length = ab.norm_squared();
    let t = if length > 0.0 { (ax.dot(&ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    (ax - ab * t).norm_squared()
}

fn box_distance_squared(x: &Point<2>, (low, high): &(Point<2>, Point<2>)) -> f64 {
    (low - x).sup(&(x - high)).sup(&Point::<2>::zeros()).norm_squared()
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
            let all = segments.iter().map(|[a, b]| segment_distance_squared(&x, a, b)).fold(f64::INFINITY, f64::min);
            prop_assert_eq!(SegmentTree::new(segments).distance(&x), all.sqrt());
        }
    }

    #[test]
    fn a_segment_without_length_is_a_point() {
        let a = Point::<2>::new(1.0, 0.0);
        assert_eq!(SegmentTree::new(vec![[a, a]]).distance(&Point::<2>::new(4.0, 4.0)), 5.0);
    }
}
