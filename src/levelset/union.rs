//! Unions of plane shapes.

use super::distance::Tree;
use super::grid::{Grid, Level};
use super::shape::Shape;
use crate::base::{Error, Result};
use crate::mesh::Point;
use std::sync::Arc;

/// The union of plane shapes, with the true distance to its boundary.
///
/// The smallest distance of the parts is exact outside, and inside as long as the disc of this
/// radius meets one part only. Where parts overlap, the nearest boundary of one part may lie inside
/// another; there the distance is that to the traced boundary of the union, with an error of `1e-9`
/// of its diagonal.
pub struct Union {
    parts: Arc<Vec<Box<dyn Shape<2>>>>,
    /// Boundary of the union; only if the boxes of two parts meet.
    boundary: Option<Tree<2>>,
    bounds: (Point<2>, Point<2>),
    /// Distance below which parts are joined.
    seam: f64,
}

impl Union {
    /// # Errors
    /// No part; a boundary that cannot be traced.
    pub fn new(parts: Vec<Box<dyn Shape<2>>>) -> Result<Union> {
        let boxes: Vec<_> = parts.iter().map(|s| s.bounds()).collect();
        let Some(bounds) = boxes.iter().copied().reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
        else {
            return Err(Error::scene("a union needs at least one shape"));
        };
        let meet = |i: usize, j: usize| {
            (0..2).all(|k| boxes[i].0[k] <= boxes[j].1[k] && boxes[j].0[k] <= boxes[i].1[k])
        };
        let seam = 1e-10 * (bounds.1 - bounds.0).norm();
        let parts = Arc::new(parts);
        let mut boundary = None;
        if (0..boxes.len()).any(|i| (0..i).any(|j| meet(i, j))) {
            // Resolves the smallest part, within limits.
            let smallest = boxes.iter().map(|b| (b.1 - b.0).min()).fold(f64::INFINITY, f64::min);
            let squares =
                (64.0 * (bounds.1 - bounds.0).max() / smallest).clamp(256.0, 1024.0) as usize;
            let grid = Grid::over(bounds, squares, 2);
            let copy = Arc::clone(&parts);
            // Enlarged by less than the tolerance, so that a side shared by two parts is not a
            // boundary.
            let level: Box<Level> = Box::new(move |x| nearest(&copy, x).1 - seam);
            boundary = Some(Tree::new(grid.trace(&*level, &grid.sample(&*level))?));
        }
        Ok(Union { parts, boundary, bounds, seam })
    }
}

/// The part with the smallest distance, and that distance.
fn nearest(parts: &[Box<dyn Shape<2>>], x: &Point<2>) -> (usize, f64) {
    parts
        .iter()
        .enumerate()
        .map(|(i, s)| (i, s.distance(x)))
        .fold((0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a })
}

impl Shape<2> for Union {
    fn distance(&self, x: &Point<2>) -> f64 {
        let (part, d) = nearest(&self.parts, x);
        match &self.boundary {
            Some(boundary) if d < 0.0 => {
                let alone = self
                    .parts
                    .iter()
                    .enumerate()
                    .all(|(i, s)| i == part || s.distance(x) > self.seam - d);
                if alone { d } else { -boundary.distance(x) }
            }
            _ => d,
        }
    }
    fn bounds(&self) -> (Point<2>, Point<2>) {
        self.bounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levelset::{Circle, Polygon, RoundedBox};
    use proptest::prelude::*;

    fn p(x: f64, y: f64) -> Point<2> {
        Point::<2>::new(x, y)
    }
    fn square(x: f64, y: f64, half: f64) -> Box<dyn Shape<2>> {
        Box::new(RoundedBox::new(p(x, y), p(half, half), 0.0, 0.0).unwrap())
    }

    #[test]
    fn overlapping_boxes_are_the_polygon_around_them() {
        let both = Union::new(vec![square(0.0, 0.0, 1.0), square(0.5, 0.7, 1.0)]).unwrap();
        let outline = [
            [-1., -1.],
            [1., -1.],
            [1., -0.3],
            [1.5, -0.3],
            [1.5, 1.7],
            [-0.5, 1.7],
            [-0.5, 1.],
            [-1., 1.],
        ];
        let exact = Polygon::new(outline.iter().map(|v| p(v[0], v[1])).collect()).unwrap();
        for i in 0..60 {
            for j in 0..60 {
                let x = p(-1.5 + 0.06 * i as f64, -1.5 + 0.06 * j as f64);
                let (d, e) = (both.distance(&x), exact.distance(&x));
                assert!((d - e).abs() < 1e-8, "{:?} {d} {e}", x.as_slice());
            }
        }
        assert_eq!(both.bounds(), (p(-1.0, -1.0), p(1.5, 1.7)));
    }

    #[test]
    fn parts_that_touch_or_lie_inside_each_other_are_allowed() {
        // Touching: the common side is no boundary.
        let touching = Union::new(vec![square(0.0, 0.0, 1.0), square(2.0, 0.0, 1.0)]).unwrap();
        let d = touching.distance(&p(0.75, 0.0));
        assert!((d + 1.0).abs() < 1e-8, "{d}");
        let nested = Union::new(vec![square(0.0, 0.0, 1.0), square(0.0, 0.0, 0.4)]).unwrap();
        assert!((nested.distance(&p(0.4, 0.0)) + 0.6).abs() < 1e-8);
        assert!(Union::new(Vec::new()).err().unwrap().to_string().contains("at least one"));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        /// Two discs: inside, the nearest boundary point is the foot on one arc or one of the two
        /// corners.
        #[test]
        fn overlapping_discs_have_the_distance_to_their_arcs_and_corners(gap in 0.1..1.9f64, r in 0.4..1.0f64, x in -1.0..3.0f64, y in -1.0..1.0f64) {
            let centres = [p(0.0, 0.0), p(gap, 0.0)];
            let radii = [1.0, r];
            let discs: Vec<Box<dyn Shape<2>>> = (0..2).map(|i| Box::new(Circle::new(centres[i], radii[i]).unwrap()) as Box<dyn Shape<2>>).collect();
            let both = Union::new(discs).unwrap();
            let n = 20_000;
            let mut sampled = f64::INFINITY;
            for i in 0..2 {
                for k in 0..n {
                    let t = std::f64::consts::TAU * k as f64 / n as f64;
                    let q = centres[i] + p(t.cos(), t.sin()) * radii[i];
                    if (q - centres[1 - i]).norm() >= radii[1 - i] {
                        sampled = sampled.min((q - p(x, y)).norm());
                    }
                }
            }
            let d = both.distance(&p(x, y));
            prop_assert!(d.abs() <= sampled + 1e-8 && sampled <= d.abs() + 4e-4, "{} {}", d, sampled);
            let inside = (0..2).any(|i| (p(x, y) - centres[i]).norm() < radii[i]);
            prop_assert_eq!(d < 0.0, inside);
            for k in 0..200 {
                let step = p(0.003, -0.002) * k as f64;
                prop_assert!((both.distance(&(p(x, y) + step)) - d).abs() <= step.norm() + 2e-9 * 3.0);
            }
        }
    }
}
