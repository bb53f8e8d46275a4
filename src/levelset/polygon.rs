//! Simple closed polygons.

use super::distance::Tree;
use super::shape::{Shape, check_point};
use crate::base::{Error, Result};
use crate::mesh::Point;
use robust::{Coord, orient2d};

/// A simple closed polygon, its vertices in either direction.
#[derive(Clone, Debug)]
pub struct Polygon {
    vertices: Vec<Point<2>>,
    sides: Tree<2>,
}

/// Refuses equal neighbours, vertices on a line, and sides that cross or touch.
fn check_sides(vertices: &[Point<2>]) -> Result<()> {
    let n = vertices.len();
    let side = |i: usize| [vertices[i], vertices[(i + 1) % n]];
    for i in 0..n {
        let [a, b] = side(i);
        if a == b {
            return Err(Error::scene("two neighbouring vertices of a polygon are equal")
                .at(format!("vertices {i} and {} (counted from 0)", (i + 1) % n))
                .value(format!("{:?}", a.as_slice()))
                .remedy("remove one of them"));
        }
    }
    if (1..n - 1).all(|i| orientation(&vertices[0], &vertices[i], &vertices[i + 1]) == 0.0) {
        return Err(Error::scene("a polygon has no area: its vertices lie on a line")
            .value(format!("{n} vertices")));
    }
    for i in 0..n {
        for j in i + 1..n {
            if sides_conflict(side(i), side(j), j == i + 1, i == 0 && j == n - 1) {
                return Err(Error::scene("a polygon crosses or touches itself")
                    .at(format!("sides {i} and {j} (side k starts at vertex k, counted from 0)"))
                    .value(format!("{:?}", side(i).map(|p| [p[0], p[1]])))
                    .remedy(
                        "list the vertices in the order in which the boundary is walked, each \
                         once",
                    ));
            }
        }
    }
    Ok(())
}

impl Polygon {
    /// The polygon with these vertices. A last vertex equal to the first is dropped.
    ///
    /// # Errors
    /// Fewer than 3 vertices, a coordinate that is not finite, equal neighbours, sides that cross
    /// or touch, no area.
    pub fn new(mut vertices: Vec<Point<2>>) -> Result<Polygon> {
        if vertices.len() > 1 && vertices.first() == vertices.last() {
            vertices.pop();
        }
        let n = vertices.len();
        if n < 3 {
            return Err(Error::scene("a polygon needs at least 3 different vertices").value(n));
        }
        for v in &vertices {
            check_point("the vertices of a polygon", v)?;
        }
        check_sides(&vertices)?;
        let side = |i: usize| [vertices[i], vertices[(i + 1) % n]];
        let sides = Tree::new((0..n).map(side).collect());
        Ok(Polygon { vertices, sides })
    }

    /// True if `x` lies inside: the number of sides that a ray to the right crosses is odd.
    fn contains(&self, x: &Point<2>) -> bool {
        let n = self.vertices.len();
        let mut inside = false;
        for i in 0..n {
            let (a, b) = (&self.vertices[i], &self.vertices[(i + 1) % n]);
            if (a[1] > x[1]) != (b[1] > x[1]) {
                let left = orientation(a, b, x) > 0.0;
                inside ^= left == (b[1] > a[1]);
            }
        }
        inside
    }
}

impl Shape<2> for Polygon {
    fn distance(&self, x: &Point<2>) -> f64 {
        let d = self.sides.distance(x);
        if self.contains(x) { -d } else { d }
    }
    fn bounds(&self) -> (Point<2>, Point<2>) {
        self.sides.bounds()
    }
}

/// Positive when `a, b, c` turn left; the sign is exact.
fn orientation(a: &Point<2>, b: &Point<2>, c: &Point<2>) -> f64 {
    let coord = |p: &Point<2>| Coord { x: p[0], y: p[1] };
    orient2d(coord(a), coord(b), coord(c))
}

/// True if two sides share more than the common vertex of neighbours (`next`: the second starts at
/// the end of the first; `previous`: it ends at the start of the first).
fn sides_conflict(
    [a, b]: [Point<2>; 2],
    [c, d]: [Point<2>; 2],
    next: bool,
    previous: bool,
) -> bool {
    let apart = |axis: usize| {
        a[axis].max(b[axis]) < c[axis].min(d[axis]) || c[axis].max(d[axis]) < a[axis].min(b[axis])
    };
    if apart(0) || apart(1) {
        return false;
    }
    if next || previous {
        // Neighbours conflict when they fold back onto each other.
        let (tip, p, q) = if next { (b, a, d) } else { (a, b, c) };
        return orientation(&p, &tip, &q) == 0.0 && (p - tip).dot(&(q - tip)) > 0.0;
    }
    let (o1, o2) = (orientation(&a, &b, &c), orientation(&a, &b, &d));
    let (o3, o4) = (orientation(&c, &d, &a), orientation(&c, &d, &b));
    // The boxes overlap, so sides on one line overlap too.
    o1 * o2 <= 0.0 && o3 * o4 <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn polygon(v: &[[f64; 2]]) -> Result<Polygon> {
        Polygon::new(v.iter().map(|p| Point::<2>::new(p[0], p[1])).collect())
    }

    #[test]
    fn an_l_has_exact_distances() {
        let l = [[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]];
        for reversed in [false, true] {
            let mut v = l.to_vec();
            if reversed {
                v.reverse();
            }
            v.push(v[0]);
            let s = polygon(&v).unwrap();
            let d = |x, y| s.distance(&Point::<2>::new(x, y));
            assert_eq!(d(0.5, 0.5), -0.5);
            assert!(
                (d(0.875, 0.875) + 0.125 * 2f64.sqrt()).abs() < 1e-15,
                "the re-entrant corner is the nearest"
            );
            assert_eq!(d(1.5, 1.25), 0.25);
            assert_eq!(d(-3.0, -4.0), 5.0);
            assert_eq!(d(2.5, 1.0), 0.5);
            assert_eq!(d(1.0, 1.0), 0.0);
            assert_eq!(s.bounds(), (Point::<2>::new(0., 0.), Point::<2>::new(2., 2.)));
        }
    }

    #[test]
    fn bad_polygons_are_refused_by_name() {
        let error = |v: &[[f64; 2]]| polygon(v).unwrap_err().to_string();
        assert!(error(&[[0., 0.], [1., 0.]]).contains("at least 3"));
        assert!(error(&[[0., 0.], [1., 0.], [0., 0.]]).contains("at least 3"));
        assert!(error(&[[0., 0.], [1., 0.], [2., 0.]]).contains("no area"));
        assert!(error(&[[0., 0.], [1., 0.], [1., 0.], [0., 1.]]).contains("equal"));
        assert!(error(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]]).contains("sides 0 and 2"));
        assert!(
            error(&[[0., 0.], [2., 0.], [2., 2.], [1., 0.], [0., 2.]])
                .contains("crosses or touches")
        );
        assert!(error(&[[0., 0.], [2., 0.], [1., 0.], [0., 2.]]).contains("sides 0 and 1"));
        assert!(error(&[[0., 0.], [1., f64::NAN], [1., 0.]]).contains("NaN"));
    }

    proptest! {
        #[test]
        fn any_list_of_vertices_is_refused_or_gives_a_distance(v in prop::collection::vec((0..5i8, 0..5i8), 0..8)) {
            let v: Vec<_> = v.iter().map(|&(x, y)| [f64::from(x), f64::from(y)]).collect();
            if let Ok(s) = polygon(&v) {
                prop_assert!(v.iter().all(|p| s.distance(&Point::<2>::new(p[0], p[1])) == 0.0));
                prop_assert!(s.distance(&Point::<2>::new(-1.0, -1.0)) >= 2f64.sqrt());
                // Some point of a fine grid lies inside: a lattice polygon has an area of at least
                // 1/2.
                prop_assert!((0..2500).any(|k| s.distance(&Point::<2>::new((k % 50) as f64 * 0.1 + 0.013, (k / 50) as f64 * 0.1 + 0.029)) < 0.0));
            }
        }

        /// Star-shaped polygons: the inside is known in polar coordinates.
        #[test]
        fn the_sign_is_that_of_the_inside_and_the_distance_is_lipschitz(
            radii in prop::collection::vec(0.3..1.0f64, 3..40), x in -1.2..1.2f64, y in -1.2..1.2f64, dx in -0.5..0.5f64, dy in -0.5..0.5f64,
        ) {
            let n = radii.len();
            let step = std::f64::consts::TAU / n as f64;
            let v: Vec<_> = (0..n).map(|k| [radii[k] * (k as f64 * step).cos(), radii[k] * (k as f64 * step).sin()]).collect();
            let s = polygon(&v).unwrap();
            let d = s.distance(&Point::<2>::new(x, y));
            let k = (y.atan2(x).rem_euclid(std::f64::consts::TAU) / step) as usize % n;
            let (a, b) = (Point::<2>::from(v[k]), Point::<2>::from(v[(k + 1) % n]));
            let inside = (b - a).perp(&(Point::<2>::new(x, y) - a)) > 0.0;
            prop_assert!(d.abs() < 1e-12 || (d < 0.0) == inside);
            let e = s.distance(&Point::<2>::new(x + dx, y + dy));
            prop_assert!((d - e).abs() <= dx.hypot(dy) + 1e-14);
        }
    }
}
