//! Polygons given by their corners.

use crate::base::Result;
use crate::scene::keys::{Context, Form, Item, Kind, kinds, table};
use robust::{Coord, orient2d};

table! {
    /// A simple polygon, in either sense of rotation.
    Polygon {
        /// The corners, in order, each once.
        points: Vec<[f64; 2]> [Points, "m", Required(REMEDY)],
    }
}

kinds! {
    /// The corners of a simple polygon.
    Points: Vec<[f64; 2]> = Kind::Value(
        "list of at least three points",
        Form::List(&Form::List(&Form::NUMBER, [2, 2]), [3, usize::MAX]),
    ), corners;
}

const REMEDY: &str = "give at least three corners: points = [[0, 0], [1, 0], [0, 1]]";

/// Reads at least three corners. Sides must not intersect except neighbours in their common corner.
fn corners(list: &Item, _: &Context) -> Result<Vec<[f64; 2]>> {
    let items = list.list()?;
    let points: Vec<[f64; 2]> = items.iter().map(Item::vector).collect::<Result<_>>()?;
    if points.len() < 3 {
        return Err(list
            .error(format!("a polygon has at least 3 corners, not {}", points.len()))
            .remedy(REMEDY));
    }
    match crossing(&points) {
        None => Ok(points),
        Some((i, j)) => Err(items[j]
            .error(format!(
                "sides {i} and {j} of the polygon meet (side 0 runs from the first corner)"
            ))
            .remedy(
                "list every corner once, in order along the curve, without the first one again at \
                 the end",
            )),
    }
}

/// Two sides with an invalid intersection, the smaller index first.
fn crossing(points: &[[f64; 2]]) -> Option<(usize, usize)> {
    let n = points.len();
    let side = |i: usize| (points[i], points[(i + 1) % n]);
    for i in 0..n {
        if side(i).0 == side(i).1 {
            return Some((i, (i + 1) % n));
        }
        for j in i + 1..n {
            let meet = if j == i + 1 {
                folds(side(i), side(j))
            } else if (j + 1) % n == i {
                folds(side(j), side(i))
            } else {
                intersect(side(i), side(j))
            };
            if meet {
                return Some((i, j));
            }
        }
    }
    None
}

type Side = ([f64; 2], [f64; 2]);

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let coord = |p: [f64; 2]| Coord { x: p[0], y: p[1] };
    orient2d(coord(a), coord(b), coord(c))
}

/// True if the second side, which begins at the end of the first one, runs back along it.
fn folds((a, b): Side, (_, c): Side) -> bool {
    turn(a, b, c) == 0.0 && (c[0] - b[0]) * (b[0] - a[0]) + (c[1] - b[1]) * (b[1] - a[1]) < 0.0
}

/// True if two segments have a point in common.
fn intersect((a, b): Side, (c, d): Side) -> bool {
    let apart = |k: usize| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]);
    let opposite = |s: f64, t: f64| !(s > 0.0 && t > 0.0 || s < 0.0 && t < 0.0);
    !apart(0)
        && !apart(1)
        && opposite(turn(a, b, c), turn(a, b, d))
        && opposite(turn(c, d, a), turn(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simple_polygons_pass_and_crossing_ones_do_not() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(crossing(&square), None);
        assert_eq!(
            crossing(&[[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0]]),
            None,
            "a corner of 180 degrees"
        );
        assert_eq!(
            crossing(&[square[0], square[2], square[1], square[3]]),
            Some((0, 2)),
            "a bow tie"
        );
        assert_eq!(
            crossing(&[square[0], square[1], square[2], square[3], square[0]]),
            Some((0, 3)),
            "closed twice"
        );
        assert_eq!(
            crossing(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]),
            Some((0, 1)),
            "runs back"
        );
        assert_eq!(crossing(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), Some((0, 2)), "no area");
    }
}
