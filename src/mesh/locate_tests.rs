use super::*;
use crate::mesh::{Diagonals, Facet, box_mesh, disc, rectangle};
use proptest::prelude::*;

/// The mesh without the cells whose centre lies in the open box with corners `low` and `high`.
fn with_hole<const D: usize>(mesh: &Mesh<D>, low: f64, high: f64) -> Mesh<D> {
    let centre = |c: usize| {
        mesh.cell(c).iter().fold(Point::<D>::zeros(), |s, &v| s + mesh.points()[v as usize])
            / (D + 1) as f64
    };
    let kept = (0..mesh.cell_count()).filter(|&c| !centre(c).iter().all(|&x| low < x && x < high));
    Mesh::new(mesh.points().to_vec(), kept.flat_map(|c| mesh.cell(c).to_vec()).collect()).unwrap()
}

/// Moves the inner points of a rectangle or box mesh on `[0, n]^D` with `n` cells a side, so that
/// nothing is aligned.
fn shaken<const D: usize>(mesh: &Mesh<D>, n: f64) -> Mesh<D> {
    let move_point = |(i, p): (usize, &Point<D>)| {
        let inner = p.iter().all(|&x| x > 0.0 && x < n);
        let noise = Point::<D>::from_fn(|a, _| 0.15 * ((i * (7 + 6 * a)) as f64).sin());
        if inner { p + noise } else { *p }
    };
    let points = mesh.points().iter().enumerate().map(move_point).collect();
    Mesh::new(points, (0..mesh.cell_count()).flat_map(|c| mesh.cell(c).to_vec()).collect()).unwrap()
}

/// Some barycentric coordinates: inside, on a facet, on an edge or at a vertex.
fn weights<const D: usize>() -> impl Strategy<Value = [f64; 4]> {
    (prop::array::uniform4(0.01..1.0f64), 1usize..(1 << (D + 1))).prop_map(|(mut w, used)| {
        for k in 0..4 {
            if k > D || used & (1 << k) == 0 {
                w[k] = 0.0;
            }
        }
        let sum: f64 = w.iter().sum();
        w.map(|x| x / sum)
    })
}

fn is_at<const D: usize>(mesh: &Mesh<D>, at: &Location, x: &Point<D>) -> bool {
    at.barycentric[..=D].iter().all(|&l| l >= -TOLERANCE) && (mesh.point_at(at) - x).norm() < 1e-11
}

/// Every search for a point of a convex domain finds it.
fn finds<const D: usize>(mesh: &Mesh<D>, from: Location, to: Location) {
    let (x, y) = (mesh.point_at(&from), mesh.point_at(&to));
    let (found, inside) = mesh.walk(from.cell, &x, &y);
    assert!(inside && is_at(mesh, &found, &y), "walk from {x:?} to {y:?}: {found:?} {inside}");
    let found = Locator::new(mesh).locate(mesh, &y);
    assert!(found.is_some_and(|at| is_at(mesh, &at, &y)), "locate {y:?}: {found:?}");
}

proptest! {
    #[test]
    fn points_of_cells_facets_edges_and_vertices_are_found_in_2d(c in 0usize..72, d in 0usize..72, a in weights::<2>(), b in weights::<2>()) {
        let regular = rectangle([0.0; 2], [6.0; 2], [6, 6], Diagonals::Right).unwrap();
        for mesh in [shaken(&regular, 6.0), regular] {
            finds(&mesh, Location { cell: c as u32, barycentric: a }, Location { cell: d as u32, barycentric: b });
        }
    }

    #[test]
    fn points_of_cells_facets_edges_and_vertices_are_found_in_3d(c in 0usize..384, d in 0usize..384, a in weights::<3>(), b in weights::<3>()) {
        let regular = box_mesh([0.0; 3], [4.0; 3], [4, 4, 4]).unwrap();
        for mesh in [shaken(&regular, 4.0), regular] {
            finds(&mesh, Location { cell: c as u32, barycentric: a }, Location { cell: d as u32, barycentric: b });
        }
    }

    #[test]
    fn a_segment_leaves_a_box_where_geometry_says(c in 0usize..72, a in weights::<2>(), angle in 0.0..std::f64::consts::TAU) {
        let mesh = shaken(&rectangle([0.0; 2], [6.0; 2], [6, 6], Diagonals::Right).unwrap(), 6.0);
        let from = Location { cell: c as u32, barycentric: a };
        let x = mesh.point_at(&from);
        let d = Point::<2>::new(angle.cos(), angle.sin());
        let t = (0..2).map(|i| (if d[i] > 0.0 { 6.0 - x[i] } else { -x[i] }) / d[i]).fold(f64::INFINITY, f64::min);
        let (found, inside) = mesh.walk(from.cell, &x, &(x + d * 20.0));
        prop_assert!(!inside && is_at(&mesh, &found, &(x + d * t.max(0.0))), "{:?}, {}", found, t);
        prop_assert!(found.barycentric.iter().all(|&l| l >= 0.0));
    }

    #[test]
    fn holes_and_the_outside_hold_no_points(x in -1.0..4.0f64, y in -1.0..4.0f64) {
        let mesh = with_hole(&rectangle([0.0; 2], [3.0; 2], [9, 9], Diagonals::Right).unwrap(), 1.0, 2.0);
        let within = |l: f64, h: f64| l < x && x < h && l < y && y < h;
        let found = Locator::new(&mesh).locate(&mesh, &Point::<2>::new(x, y));
        prop_assert_eq!(found.is_some(), within(0.0, 3.0) && !within(1.0, 2.0));
    }
}

/// Parameter at which a segment between points with integer coordinates first enters the open cube
/// `(low, high)^D`; `None` if never. Without rounding (parameters are fractions over the product of
/// the steps).
fn entry<const D: usize>(from: [i64; D], to: [i64; D], low: i64, high: i64) -> Option<f64> {
    let step: [i64; D] = std::array::from_fn(|i| to[i] - from[i]);
    let all: i64 = step.iter().filter(|s| **s != 0).map(|s| s.abs()).product();
    let (mut first, mut last) = (0, all);
    for i in 0..D {
        if step[i] == 0 {
            if from[i] <= low || from[i] >= high {
                return None;
            }
            continue;
        }
        let at = |face: i64| (face - from[i]) * step[i].signum() * (all / step[i].abs());
        let (near, far) = if step[i] > 0 { (at(low), at(high)) } else { (at(high), at(low)) };
        first = first.max(near);
        last = last.min(far);
    }
    (first < last).then(|| first as f64 / all as f64)
}

/// Walks between all points of a lattice (`2 n` steps a unit cell of three, with the middle cell
/// missing) must stop at the hole exactly when they enter its interior: along its sides and past
/// its corners they go on.
fn lattice<const D: usize>(mesh: &Mesh<D>, per_cell: i64, stride: usize) {
    let n = 3 * per_cell + 1;
    let lattice: Vec<[i64; D]> =
        (0..n.pow(D as u32)).map(|i| std::array::from_fn(|a| i / n.pow(a as u32) % n)).collect();
    let hole = |p: &[i64; D]| p.iter().all(|&c| per_cell < c && c < 2 * per_cell);
    let place = |p: &[i64; D]| Point::<D>::from_fn(|a, _| p[a] as f64 / per_cell as f64);
    let locator = Locator::new(mesh);
    for p in &lattice {
        assert_eq!(locator.locate(mesh, &place(p)).is_some(), !hole(p), "{p:?}");
    }
    let free: Vec<_> = lattice.iter().filter(|p| !hole(p)).collect();
    for (i, p) in free.iter().enumerate() {
        let x = place(p);
        let start = locator.locate(mesh, &x).unwrap();
        for q in free.iter().skip(i % stride).step_by(stride) {
            let y = place(q);
            let (found, inside) = mesh.walk(start.cell, &x, &y);
            let end = entry(**p, **q, per_cell, 2 * per_cell).map_or(y, |t| x + (y - x) * t);
            assert_eq!(inside, end == y, "{p:?} to {q:?}: {found:?}");
            assert!(is_at(mesh, &found, &end), "{p:?} to {q:?}: {found:?}, expected {end:?}");
        }
    }
}

#[test]
fn a_hole_stops_a_walk_exactly_when_its_inside_is_entered_in_2d() {
    lattice(
        &with_hole(&rectangle([0.0; 2], [3.0; 2], [6, 6], Diagonals::Right).unwrap(), 1.0, 2.0),
        4,
        1,
    );
}

#[test]
fn a_hole_stops_a_walk_exactly_when_its_inside_is_entered_in_3d() {
    lattice(&with_hole(&box_mesh([0.0; 3], [3.0; 3], [3, 3, 3]).unwrap(), 1.0, 2.0), 2, 3);
}

#[test]
fn a_target_that_is_not_a_number_is_not_inside() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], Diagonals::Right).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        let to = Point::<2>::new(0.5, bad);
        let (found, inside) = mesh.walk(0, &Point::<2>::new(0.3, 0.1), &to);
        assert!(!inside && found.barycentric[0].is_nan());
        assert!(Locator::new(&mesh).locate(&mesh, &to).is_none());
    }
}

#[test]
fn walks_through_a_point_of_many_cells_and_along_a_curved_wall() {
    // A fan: one inner point with 200 cells round it.
    let n = 200;
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / n as f64;
    let mut points = vec![Point::<2>::zeros()];
    points.extend((0..n).map(|i| Point::<2>::new(angle(i).cos(), angle(i).sin())));
    let cells = (0..n as u32).flat_map(|i| [0, 1 + i, 1 + (i + 1) % n as u32]).collect();
    for mesh in [Mesh::new(points, cells).unwrap(), disc([0.0; 2], 1.0, 20).unwrap()] {
        let rim: Vec<Facet> = mesh.facets().to_vec();
        for (i, f) in rim.iter().enumerate() {
            let v = mesh.facet_points(f).next().unwrap() as usize;
            for g in rim.iter().skip(i % 7).step_by(7) {
                let w = mesh.facet_points(g).next().unwrap() as usize;
                let (x, y) = (mesh.points()[v], mesh.points()[w]);
                let (found, inside) = mesh.walk(f.cell, &x, &y);
                assert!(inside && is_at(&mesh, &found, &y), "{v} to {w}: {found:?}");
                let (found, inside) = mesh.walk(f.cell, &x, &(2.0 * y - x));
                assert!(
                    (v == w || !inside) && is_at(&mesh, &found, &y),
                    "{v} through {w}: {found:?}"
                );
            }
        }
    }
}
