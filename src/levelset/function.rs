//! Shapes given by a level function, and the tracing of its zero set.

use super::distance::Tree;
use super::grid::{Grid, Level, root, sampled};
use super::shape::Shape;
use crate::base::{Error, Result};
use crate::mesh::Point;

/// Number of squares of the tracing grid along the longer side of the domain.
const GRID: usize = 256;
/// The traced polygon lies within this distance of the zero set, as a fraction of the diagonal of
/// the domain.
const TOLERANCE: f64 = 1e-9;
/// Largest number of segments; more indicate a zero set that is rough on every scale.
const MOST_SEGMENTS: usize = 4_000_000;
/// Largest number of halvings. A square of the grid is 4e6 tolerances wide; around a spike of 15
/// degrees a halving shortens a segment by a tenth only.
const MOST_HALVINGS: usize = 300;

/// The set where a function is negative, with the true distance to its boundary (not the value of
/// the function).
///
/// The zero set is traced on a grid of 256 squares along the domain (and a quarter of the domain
/// around it, for an interface that leaves the domain), then every piece is halved until its
/// deviation is below `1e-9` of the diagonal of the domain; corners are resolved to the same
/// length. The distance is that to the traced polygon, hence has that error. Limits: a part smaller
/// than a square of the grid may be missed; a spike sharper than 15 degrees may be truncated by the
/// size of a square.
pub struct LevelFunction {
    function: Box<Level>,
    zero_set: Tree<2>,
}

impl LevelFunction {
    /// The set where `function < 0`; `domain` is the bounding box of the mesh.
    ///
    /// # Errors
    /// A value that is not finite, no zero set in the domain, a zero set too rough to trace.
    pub fn new(
        function: impl Fn(&Point<2>) -> f64 + Send + Sync + 'static,
        domain: (Point<2>, Point<2>),
    ) -> Result<LevelFunction> {
        let function: Box<Level> = Box::new(function);
        let (grid, values) = sampled(&*function, domain, GRID, GRID / 4)?;
        let zero_set = grid.trace(&*function, &values)?;
        Ok(LevelFunction { function, zero_set: Tree::new(zero_set) })
    }
}

impl Shape<2> for LevelFunction {
    fn distance(&self, x: &Point<2>) -> f64 {
        let d = self.zero_set.distance(x);
        if (self.function)(x) < 0.0 { -d } else { d }
    }
    /// The box around the traced zero set, which reaches a quarter of the domain beyond it where
    /// the interface does.
    fn bounds(&self) -> (Point<2>, Point<2>) {
        self.zero_set.bounds()
    }
}

impl Grid<2> {
    /// The zero set of `f`, whose values at the nodes are given, as segments within the tolerance.
    /// Squares are halved into triangles, in which a zero set is one piece; triangles with a value
    /// that is not finite are left out.
    pub(super) fn trace(&self, f: &Level, values: &[f64]) -> Result<Vec<[Point<2>; 2]>> {
        let tolerance = TOLERANCE * self.diagonal;
        let mut segments = Vec::new();
        let row = self.nodes[0];
        for j in 0..self.nodes[1] - 1 {
            for i in 0..row - 1 {
                let a = i + j * row;
                for triangle in [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]] {
                    if !triangle.iter().all(|&k| values[k].is_finite()) {
                        continue;
                    }
                    let mut ends = [Point::<2>::zeros(); 2];
                    let mut found = 0;
                    for (p, q) in [(0, 1), (1, 2), (2, 0)] {
                        let (p, q) = (triangle[p], triangle[q]);
                        if (values[p] < 0.0) != (values[q] < 0.0) && found < 2 {
                            let (inner, outer) = if values[p] < 0.0 { (p, q) } else { (q, p) };
                            let (a, b) = (
                                (self.point(inner), values[inner]),
                                (self.point(outer), values[outer]),
                            );
                            ends[found] = root(f, a, b, 1e-2 * tolerance);
                            found += 1;
                        }
                    }
                    if found == 2 {
                        refine(f, ends[0], ends[1], tolerance, 0, &mut segments)?;
                    }
                }
            }
        }
        Ok(segments)
    }
}

/// Halves the segment `p q`, whose ends lie on the zero set, until the zero set is within
/// `tolerance` of it.
fn refine(
    f: &Level,
    p: Point<2>,
    q: Point<2>,
    tolerance: f64,
    depth: usize,
    out: &mut Vec<[Point<2>; 2]>,
) -> Result<()> {
    let (middle, half) = ((p + q) * 0.5, (q - p) * 0.5);
    let Some(y) = lift(f, middle, half, tolerance) else {
        out.push([p, q]);
        return Ok(());
    };
    // Two halvings at least: one middle can lie on the chord of an S.
    if depth >= 2 && (y - middle).norm() <= tolerance {
        out.extend([[p, y], [y, q]]);
        return Ok(());
    }
    if out.len() > MOST_SEGMENTS || depth > MOST_HALVINGS {
        return Err(Error::scene("the zero set of the function of a shape is too rough")
            .at(format!("x = {}, y = {}", y[0], y[1]))
            .remedy("give a function whose zero set is a curve with finitely many corners"));
    }
    refine(f, p, y, tolerance, depth + 1, out)?;
    refine(f, y, q, tolerance, depth + 1, out)
}

/// The zero of `f` nearest to the middle of a segment on its perpendicular bisector, within the
/// height of a spike of 15 degrees; `None` for a segment that is short enough, or if the search
/// fails.
fn lift(f: &Level, middle: Point<2>, half: Point<2>, tolerance: f64) -> Option<Point<2>> {
    if half.norm() <= 0.5 * tolerance {
        return None;
    }
    let across = Point::<2>::new(-half[1], half[0]);
    let (mut left, mut right) = ((middle, f(&middle)), (middle, f(&middle)));
    for reach in [1.0, 2.0, 4.0, 8.0] {
        for (sign, near) in [(1.0, &mut left), (-1.0, &mut right)] {
            let x = middle + across * (sign * reach);
            let far = (x, f(&x));
            if !far.1.is_finite() || !near.1.is_finite() {
                return None;
            }
            if (far.1 < 0.0) != (near.1 < 0.0) {
                let (inner, outer) = if far.1 < 0.0 { (far, *near) } else { (*near, far) };
                return Some(root(f, inner, outer, 1e-2 * tolerance));
            }
            *near = far;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levelset::{Circle, Ellipse, Polygon, RoundedBox};
    use proptest::prelude::*;

    fn p(x: f64, y: f64) -> Point<2> {
        Point::<2>::new(x, y)
    }
    fn domain() -> (Point<2>, Point<2>) {
        (p(0.0, 0.0), p(2.0, 2.0))
    }
    /// Largest difference of the distances of two shapes on a grid in the domain.
    fn difference(a: &dyn Shape<2>, b: &dyn Shape<2>) -> f64 {
        let n = 57;
        (0..n * n)
            .map(|k| p((k % n) as f64, (k / n) as f64) * (2.0 / (n - 1) as f64))
            .map(|x| (a.distance(&x) - b.distance(&x)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn level_functions_of_an_ellipse_give_its_distance() {
        let exact = Ellipse::new(p(1.0, 1.0), p(0.75, 0.5), 0.0).unwrap();
        let square =
            |x: &Point<2>| ((x[0] - 1.0) / 0.75).powi(2) + ((x[1] - 1.0) / 0.5).powi(2) - 1.0;
        let by_square = LevelFunction::new(square, domain()).unwrap();
        let by_root =
            LevelFunction::new(move |x| (square(x) + 1.0).sqrt() - 1.0, domain()).unwrap();
        for shape in [&by_square, &by_root] {
            let error = difference(shape, &exact);
            assert!(error < 3e-9, "{error}");
            let (a, b) = (shape.bounds(), exact.bounds());
            assert!((a.0 - b.0).norm() + (a.1 - b.1).norm() < 1e-8);
        }
    }

    #[test]
    fn corners_of_a_level_function_are_found() {
        // The value inside is not the distance; corners convex and re-entrant.
        let star = [
            [0.2, 0.3],
            [1.0, 0.8],
            [1.7, 0.4],
            [1.3, 1.0],
            [1.6, 1.7],
            [0.9, 1.4],
            [0.3, 1.5],
            [0.6, 1.0],
        ];
        let square =
            LevelFunction::new(|x| (x[0] - 0.9).abs().max((x[1] - 1.1).abs()) - 0.47, domain())
                .unwrap();
        let exact = RoundedBox::new(p(0.9, 1.1), p(0.47, 0.47), 0.0, 0.0).unwrap();
        assert!(difference(&square, &exact) < 6e-9);
        let exact = Polygon::new(star.iter().map(|v| p(v[0], v[1])).collect()).unwrap();
        let copy = exact.clone();
        let by_value =
            LevelFunction::new(move |x| copy.distance(x).clamp(-0.1, 0.2), domain()).unwrap();
        let error = difference(&by_value, &exact);
        assert!(error < 1e-8, "{error}");
    }

    #[test]
    fn an_interface_across_the_domain_keeps_its_distance_at_the_walls() {
        let slope = LevelFunction::new(|x| (x[1] - 0.5 - 0.25 * x[0]).powi(3), domain()).unwrap();
        for x in [p(0.0, 0.0), p(2.0, 0.0), p(0.0, 2.0), p(1.0, 1.0)] {
            let exact = (x[1] - 0.5 - 0.25 * x[0]) / 1.0625f64.sqrt();
            assert!((slope.distance(&x) - exact).abs() < 1e-8, "{} {exact}", slope.distance(&x));
        }
    }

    #[test]
    fn bad_level_functions_are_refused() {
        let error = |f: fn(&Point<2>) -> f64| {
            LevelFunction::new(f, domain()).err().map(|e| e.to_string()).unwrap_or_default()
        };
        assert!(error(|x| x[0] + 1.0).contains("from 1 to 3"));
        assert!(error(|_| -1.0).contains("no zero"));
        assert!(error(|x| (x[0] - 1.0).ln()).contains("no finite value"));
        assert!(
            LevelFunction::new(|x| x[0] - 1.0, (p(0.0, 0.0), p(2.0, 0.0)))
                .err()
                .unwrap()
                .to_string()
                .contains("no area")
        );
        // A zero set outside of the domain only.
        assert!(error(|x| x[0] + 0.25).contains("no zero"));
        assert!(
            error(|x| (1e4 * x[0]).sin() * (1.7e4 * x[1] * x[0]).cos() + 0.1 * (9e7 * x[0]).sin())
                .contains("too rough")
        );
    }

    #[test]
    fn a_hole_in_the_definition_between_the_nodes_of_the_grid_does_no_harm() {
        // Not a number on a strip across the zero set, thinner than a square of the grid.
        let f = |x: &Point<2>| {
            if (x[0] - 1.0019).abs() < 1e-3 { f64::NAN } else { (x - p(1.0, 1.0)).norm() - 0.5 }
        };
        let shape = LevelFunction::new(f, domain()).unwrap();
        let exact = Circle::new(p(1.0, 1.0), 0.5).unwrap();
        for x in [p(0.3, 0.3), p(1.0, 1.9), p(1.4, 1.1), p(0.0, 1.0)] {
            assert!((shape.distance(&x) - exact.distance(&x)).abs() < 1e-4);
        }
    }

    #[test]
    fn the_distance_to_a_level_function_is_lipschitz() {
        let f = |x: &Point<2>| (4.0 * x[0]).sin() * (3.0 * x[1]).cos() - 0.2 + (x[0] * x[1]).abs();
        let shape = LevelFunction::new(f, domain()).unwrap();
        let n = 61;
        let x: Vec<_> =
            (0..n * n).map(|k| p((k * 37 % n) as f64, (k / n) as f64) * (2.0 / n as f64)).collect();
        let d: Vec<_> = x.iter().map(|x| shape.distance(x)).collect();
        for k in 1..x.len() {
            assert!((d[k] - d[k - 1]).abs() <= (x[k] - x[k - 1]).norm() + 1e-14);
            assert_eq!(d[k] < 0.0, f(&x[k]) < 0.0);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20))]
        #[test]
        fn level_functions_of_circles_give_their_distance(cx in 0.7..1.3f64, cy in 0.7..1.3f64, r in 0.1..0.6f64, power in 0.5..3.0f64) {
            let f = move |x: &Point<2>| (x - p(cx, cy)).norm().powf(power) - r.powf(power);
            let error = difference(&LevelFunction::new(f, domain()).unwrap(), &Circle::new(p(cx, cy), r).unwrap());
            prop_assert!(error < 3e-9, "{}", error);
        }
    }
}
