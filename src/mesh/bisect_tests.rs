//! Tests of bisected boxes.

use super::*;
use crate::mesh::check;
use proptest::prelude::*;

/// Area of a named side.
fn area(mesh: &Mesh<3>, name: &str) -> f64 {
    mesh.boundary(name)
        .unwrap()
        .iter()
        .map(|&f| mesh.facet_normal(&mesh.facets()[f as usize]).1)
        .sum()
}

/// A mesh without hanging points has no facets but those on the sides of the box, and these cover
/// the sides once.
fn assert_sound(mesh: &Mesh<3>, min: [f64; 3], max: [f64; 3]) {
    let side = [0, 1, 2].map(|k| max[k] - min[k]);
    assert!((mesh.volume() / side.iter().product::<f64>() - 1.0).abs() < 1e-12);
    for (axis, names) in
        [["left", "right"], ["bottom", "top"], ["back", "front"]].iter().enumerate()
    {
        for (name, at) in names.iter().zip([min[axis], max[axis]]) {
            let exact = side.iter().product::<f64>() / side[axis];
            assert!(
                (area(mesh, name) / exact - 1.0).abs() < 1e-12,
                "{name}: {} for {exact}",
                area(mesh, name)
            );
            for &f in mesh.boundary(name).unwrap() {
                let on_side = |v: u32| (mesh.points()[v as usize][axis] - at).abs() < 1e-14;
                assert!(mesh.facet_points(&mesh.facets()[f as usize]).all(on_side));
            }
        }
    }
    let (quality, warnings) = check(mesh);
    assert!(quality.parts == 1 && warnings.is_empty(), "{warnings:?}");
}

#[test]
fn three_bisections_of_all_cells_halve_the_box() {
    let wants = |h: f64| move |v: &[Point<3>; 4]| third_shortest_edge(v) > h * 1.000001;
    for (edge, cells, points) in
        [(1.0, 48, 27), (0.87, 96, 35), (0.71, 192, 71), (0.5, 384, 125), (0.25, 3072, 729)]
    {
        let mesh = graded_box([0.0; 3], [2.0; 3], [2; 3], wants(edge)).unwrap();
        assert_sound(&mesh, [0.0; 3], [2.0; 3]);
        assert_eq!((mesh.cell_count(), mesh.points().len()), (cells, points), "{edge}");
        let quality = check(&mesh).0;
        assert!(quality.smallest_angle.value > 45.0 - 1e-9, "{}", quality.smallest_angle.value);
    }
}

#[test]
fn a_shell_is_as_fine_as_wished_and_the_rest_is_coarse() {
    let (centre, radius, band, edge) = ([0.05, -0.02, 0.01], 0.5, 0.11, 0.09);
    let mesh = ball_in_box([-1.0; 3], [1.0; 3], [4; 3], centre, radius, band, edge).unwrap();
    assert_sound(&mesh, [-1.0; 3], [1.0; 3]);
    let mut coarsest: f64 = 0.0;
    for c in 0..mesh.cell_count() {
        let v = [0, 1, 2, 3].map(|k| mesh.points()[mesh.cell(c)[k] as usize]);
        let third = third_shortest_edge(&v);
        assert!(
            third <= edge * 1.001 || !meets_shell(&v, &centre.into(), radius, band),
            "cell {c}: {third}"
        );
        // Nothing is finer than one step below the requested size: no unnecessary bisections.
        assert!(third > 0.4 * edge, "cell {c}: {third}");
        coarsest = coarsest.max(third);
    }
    let quality = check(&mesh).0;
    // A uniform mesh of this edge has 6 (2/0.0884)^3 = 69000 cells.
    assert!(coarsest > 0.4 && mesh.cell_count() < 40_000, "{coarsest} {}", mesh.cell_count());
    assert!(quality.smallest_angle.value > 45.0 - 1e-9, "{}", quality.smallest_angle.value);
}

#[test]
fn a_wish_that_never_ends_is_refused() {
    let corner = |v: &[Point<3>; 4]| v.iter().any(|x| x.norm() == 0.0);
    let error = graded_box([0.0; 3], [1.0; 3], [1; 3], corner).unwrap_err().to_string();
    assert!(error.contains("120 bisections at [0.0, 0.0, 0.0]"), "{error}");
    for (radius, band, edge) in [(0.0, 0.1, 0.1), (0.5, -1.0, 0.1), (0.5, 0.1, f64::NAN)] {
        assert!(ball_in_box([0.0; 3], [1.0; 3], [1; 3], [0.5; 3], radius, band, edge).is_err());
    }
}

/// The distance of `x` from a simplex over many points of it.
fn sampled(x: &Point<3>, v: &[Point<3>; 4], n: usize) -> f64 {
    let mut least = f64::INFINITY;
    for (i, j, k) in
        (0..=n).flat_map(|i| (0..=n - i).flat_map(move |j| (0..=n - i - j).map(move |k| (i, j, k))))
    {
        let l = [i, j, k, n - i - j - k].map(|m| m as f64 / n as f64);
        least = least.min((x - (v[0] * l[0] + v[1] * l[1] + v[2] * l[2] + v[3] * l[3])).norm());
    }
    least
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Refinement about any points of any box is conforming, with few shapes.
    #[test]
    fn cells_about_any_point_fit(
        x in prop::array::uniform3(0.0..1.0f64),
        side in prop::array::uniform3(0.5..2.0f64),
        cells in prop::array::uniform3(1..4usize),
        depth in 1..5i32,
    ) {
        // The angles of blocks that are stretched further are below 5 degrees, with a warning.
        let block = Point::<3>::from_fn(|k, _| side[k] / cells[k] as f64);
        prop_assume!(block.max() < 8.0 * block.min());
        let max = [0, 1, 2].map(|k| side[k] - 1.0);
        let at = Point::<3>::from_fn(|k, _| x[k] * side[k] - 1.0);
        let wants = |v: &[Point<3>; 4]| distance(&at, v) < 1e-9 && third_shortest_edge(v) > 0.5f64.powi(depth);
        let mesh = graded_box([-1.0; 3], max, cells, wants).unwrap();
        assert_sound(&mesh, [-1.0; 3], max);
        let once = |v: &[Point<3>; 4]| third_shortest_edge(v) > 0.5f64.powi(depth.min(3));
        let uniform = check(&graded_box([-1.0; 3], max, cells, once).unwrap()).0.smallest_angle.value;
        prop_assert!(check(&mesh).0.smallest_angle.value > 0.4 * uniform);
    }

    #[test]
    fn distances_are_those_of_many_points(
        x in prop::array::uniform3(-2.0..2.0f64),
        v in prop::array::uniform4(prop::array::uniform3(-1.0..1.0f64)),
    ) {
        let (x, v) = (Point::<3>::from(x), v.map(Point::<3>::from));
        let volume = (v[1] - v[0]).cross(&(v[2] - v[0])).dot(&(v[3] - v[0])).abs();
        prop_assume!(volume > 0.05);
        let (ours, theirs) = (distance(&x, &v), sampled(&x, &v, 24));
        prop_assert!(ours <= theirs + 1e-12 && ours > theirs - 0.15, "{ours} {theirs}");
    }
}
