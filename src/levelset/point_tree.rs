//! The nearest of many points.

use crate::mesh::Point;

/// Points in a balanced tree: the middle one of a part halves it along an axis, which changes from level to level.
#[derive(Clone, Debug)]
pub(super) struct PointTree<const D: usize>(Vec<Point<D>>);

impl<const D: usize> PointTree<D> {
    /// The tree over points with finite coordinates.
    pub(super) fn new(mut points: Vec<Point<D>>) -> PointTree<D> {
        halve(&mut points, 0);
        PointTree(points)
    }
    /// Lower and upper corner of the box around all points; none without any.
    pub(super) fn bounds(&self) -> Option<(Point<D>, Point<D>)> {
        let first = *self.0.first()?;
        Some(self.0.iter().fold((first, first), |(low, high), x| (low.inf(x), high.sup(x))))
    }
    /// The point nearest to `x`; `None` without any.
    pub(super) fn nearest(&self, x: &Point<D>) -> Option<&Point<D>> {
        let mut best = (f64::INFINITY, None);
        search(&self.0, 0, x, &mut best);
        best.1
    }
}

fn halve<const D: usize>(part: &mut [Point<D>], axis: usize) {
    if part.len() < 2 {
        return;
    }
    let middle = part.len() / 2;
    part.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
    let (low, high) = part.split_at_mut(middle);
    halve(low, (axis + 1) % D);
    halve(&mut high[1..], (axis + 1) % D);
}

fn search<'a, const D: usize>(part: &'a [Point<D>], axis: usize, x: &Point<D>, best: &mut (f64, Option<&'a Point<D>>)) {
    let (low, Some((middle, high))) = ({
        let (low, rest) = part.split_at(part.len() / 2);
        (low, rest.split_first())
    }) else {
        return;
    };
    let distance = (x - middle).norm_squared();
    if distance < best.0 {
        *best = (distance, Some(middle));
    }
    let beyond = x[axis] - middle[axis];
    let (near, far) = if beyond < 0.0 { (low, high) } else { (high, low) };
    search(near, (axis + 1) % D, x, best);
    if beyond * beyond < best.0 {
        search(far, (axis + 1) % D, x, best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_is_that_of_a_search_through_all() {
        let random = |k: usize| ((k as f64 * 12.9898).sin() * 43758.5453).fract();
        for count in [0, 1, 2, 3, 100, 1000] {
            let points: Vec<_> =
                (0..count).map(|k| Point::<3>::new(random(3 * k), random(3 * k + 1), random(3 * k + 2))).collect();
            let tree = PointTree::new(points.clone());
            for k in 0..50 {
                let x = Point::<3>::new(random(7 * k), random(7 * k + 2), random(7 * k + 5)) * 1.5;
                let all = points.iter().map(|p| (p - x).norm()).reduce(f64::min);
                assert_eq!(tree.nearest(&x).map(|p| (p - x).norm()), all);
            }
        }
    }
}
