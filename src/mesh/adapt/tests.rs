use super::*;
use crate::mesh::{Diagonals, NONE, Point, check, disc, rectangle};
use nalgebra::SMatrix;
use proptest::prelude::*;
use std::collections::BTreeMap;

fn at(x: f64, y: f64) -> Point<2> {
    Point::<2>::new(x, y)
}

fn isotropic(mesh: &Mesh<2>, h: impl Fn(&Point<2>) -> f64) -> Metric {
    Metric::isotropic(&mesh.points().iter().map(h).collect::<Vec<_>>())
}

/// Sizes `across` along the direction `n` (a unit vector), `along` at right angles to it.
fn tensor(n: Point<2>, across: f64, along: f64) -> SMatrix<f64, 2, 2> {
    let normal = n * n.transpose();
    normal / (across * across) + (SMatrix::<f64, 2, 2>::identity() - normal) / (along * along)
}

/// Adapts until the mesh that carries the metric is the one that fits it, as a user does.
fn adapted_to(
    mut mesh: Mesh<2>,
    times: usize,
    metric: impl Fn(&Point<2>) -> SMatrix<f64, 2, 2>,
) -> Adapted {
    let mut report = None;
    for _ in 0..times {
        let given = Metric { tensors: mesh.points().iter().map(&metric).collect() };
        let adapted = adapt(&mesh, &given, &AdaptOptions::default()).unwrap();
        mesh = adapted.mesh;
        report = Some(adapted.report);
    }
    Adapted { mesh, report: report.unwrap() }
}

/// Area of every region and, of every boundary, its length and the integral of its normal times a
/// linear function.
fn measures(mesh: &Mesh<2>) -> BTreeMap<String, Vec<f64>> {
    let mut all = BTreeMap::new();
    for (name, cells) in mesh.regions() {
        let (mut area, mut moment) = (0.0, Point::<2>::zeros());
        for &c in cells {
            let v = mesh.cell(c as usize);
            let centre =
                (0..3).fold(Point::<2>::zeros(), |s, k| s + mesh.points()[v[k] as usize]) / 3.0;
            area += mesh.map(c as usize).volume;
            moment += centre * mesh.map(c as usize).volume;
        }
        all.insert(format!("region {name}"), vec![area, moment[0], moment[1]]);
    }
    for (name, facets) in mesh.boundaries() {
        let mut sums = vec![0.0; 5];
        for &f in facets {
            let f = &mesh.facets()[f as usize];
            let (n, length) = mesh.facet_normal(f);
            let middle = mesh
                .facet_points(f)
                .fold(Point::<2>::zeros(), |s, v| s + mesh.points()[v as usize])
                / 2.0;
            for (s, x) in
                sums.iter_mut().zip([1.0, middle[0], middle[1], n[0] * middle[0], n[1] * middle[1]])
            {
                *s += x * length;
            }
        }
        all.insert(format!("boundary {name}"), sums);
    }
    all
}

/// Checks the properties of every adapted mesh: conforming, positive, of the same domain with the
/// same parts. `Mesh::new` rejects sides of more than two triangles and overlaps; a hanging vertex
/// would give inner boundaries and change their length.
fn assert_same_domain(old: &Mesh<2>, new: &Mesh<2>) {
    assert!(new.reoriented().is_empty());
    assert!(
        (new.volume() - old.volume()).abs() < 1e-12 * old.volume(),
        "{} {}",
        new.volume(),
        old.volume()
    );
    let (before, after) = (measures(old), measures(new));
    assert_eq!(before.keys().collect::<Vec<_>>(), after.keys().collect::<Vec<_>>());
    for (name, values) in &before {
        for (a, b) in values.iter().zip(&after[name]) {
            assert!((a - b).abs() < 1e-11, "{name}: {values:?} {:?}", after[name]);
        }
    }
    let length = |m: &Mesh<2>| m.facets().iter().map(|f| m.facet_normal(f).1).sum::<f64>();
    assert!((length(old) - length(new)).abs() < 1e-11, "{} {}", length(old), length(new));
    assert!(
        check(new)
            .1
            .iter()
            .all(|w| !w.what.contains("belong to no cell") && !w.what.contains("not connected"))
    );
}

#[test]
fn a_square_gets_the_sizes_of_a_circle() {
    let mesh = rectangle([0.0; 2], [2.0; 2], [20, 20], Diagonals::Right).unwrap();
    let metric = isotropic(&mesh, |x| 0.02 + 0.3 * ((x - at(1.0, 1.0)).norm() - 0.5).abs());
    let metric = metric.graded(&mesh, 1.5).unwrap();
    let new = adapt(&mesh, &metric, &AdaptOptions::default()).unwrap();
    assert_same_domain(&mesh, &new.mesh);
    assert!(new.report.unit_edges > 0.97 && new.report.worst_quality > 0.6, "{:?}", new.report);
    let expected = metric.expected_vertices(&mesh).unwrap();
    assert!(
        (new.report.vertices as f64 / expected - 1.0).abs() < 0.05,
        "{:?}, expected {expected}",
        new.report
    );
    let (quality, warnings) = check(&new.mesh);
    assert!(quality.smallest_angle.value > 25.0 && warnings.is_empty(), "{quality:?} {warnings:?}");
}

#[test]
fn a_boundary_layer_and_a_circular_front_get_stretched_triangles() {
    let layer = |x: &Point<2>| tensor(at(0.0, 1.0), 0.002 + 0.1 * x[1], 0.1);
    let front = |x: &Point<2>| {
        let r = x - at(-0.1, 0.5);
        tensor(r / r.norm(), 0.003 + 0.3 * (r.norm() - 0.7).abs(), 0.1)
    };
    for (name, metric) in
        [("layer", &layer as &dyn Fn(&Point<2>) -> SMatrix<f64, 2, 2>), ("front", &front)]
    {
        let mesh = rectangle([0.0; 2], [1.0; 2], [10, 10], Diagonals::Right).unwrap();
        let new = adapted_to(mesh.clone(), 6, metric);
        assert_same_domain(&mesh, &new.mesh);
        assert!(
            new.report.unit_edges > 0.9 && new.report.worst_quality > 0.3,
            "{name}: {:?}",
            new.report
        );
        assert!(new.report.mean_quality > 0.85);
    }
}

#[test]
fn a_mesh_that_fits_is_hardly_changed() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [10, 10], Diagonals::Right).unwrap();
    let metric = |x: &Point<2>| tensor(at(1.0, 0.0), 0.01 + 0.1 * x[0], 0.01 + 0.1 * x[0]);
    let first = adapted_to(mesh, 4, metric);
    let second = adapted_to(first.mesh.clone(), 1, metric);
    let same = second.mesh.points().iter().filter(|p| first.mesh.points().contains(p)).count();
    assert!(second.report.sweeps <= 2 && same as f64 > 0.95 * first.mesh.points().len() as f64);
}

/// A square with a named disc of cells inside, another name for its lower half, and oblique sides
/// (turned by one radian).
fn parts(n: usize) -> Mesh<2> {
    let straight = rectangle([0.0; 2], [1.0; 2], [n, n], Diagonals::UnionJack).unwrap();
    let turned = straight.points().iter().map(|p| nalgebra::Rotation2::new(1.0) * p).collect();
    let cells: Vec<u32> =
        (0..straight.cell_count()).flat_map(|c| straight.cell(c).to_vec()).collect();
    let mut mesh = Mesh::<2>::new(turned, cells).unwrap();
    for (name, facets) in straight.boundaries() {
        mesh.set_boundary(name, facets.clone());
    }
    let centre = |c: &u32| {
        (0..3).fold(at(0.0, 0.0), |s, k| {
            s + straight.points()[straight.cell(*c as usize)[k] as usize]
        }) / 3.0
    };
    let all = 0..mesh.cell_count() as u32;
    mesh.set_region(
        "disc",
        all.clone().filter(|c| (centre(c) - at(0.5, 0.5)).norm() < 0.3).collect(),
    );
    mesh.set_region("lower", all.filter(|c| centre(c)[1] < 0.5).collect());
    mesh
}

#[test]
fn frozen_boundaries_keep_their_points_and_edges() {
    let mesh = parts(8);
    let middle = nalgebra::Rotation2::new(1.0) * at(0.5, 0.5);
    let metric = isotropic(&mesh, |x| 0.02 + 0.3 * (x - middle).norm());
    let options = AdaptOptions { keep_boundary: true, ..AdaptOptions::default() };
    let new = adapt(&mesh, &metric, &options).unwrap();
    assert_same_domain(&mesh, &new.mesh);
    let edges = |m: &Mesh<2>| {
        let ends = |f| {
            m.facet_points(f)
                .map(|v| m.points()[v as usize].as_slice().to_vec())
                .collect::<Vec<_>>()
        };
        let mut all: Vec<_> = m.facets().iter().map(ends).collect();
        all.iter_mut().for_each(|e| e.sort_by(|a, b| a.partial_cmp(b).unwrap()));
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all
    };
    assert_eq!(edges(&mesh), edges(&new.mesh));
    assert!(new.report.worst_quality > 0.5 && new.report.vertices > 130, "{:?}", new.report);
    // Edges of a sixth of the boundary's cannot be reached: the sizes inside follow those on the
    // boundary.
    let new = adapt(&mesh, &isotropic(&mesh, |_| 0.02), &options).unwrap();
    assert_same_domain(&mesh, &new.mesh);
    assert_eq!(edges(&mesh), edges(&new.mesh));
    assert!(check(&new.mesh).0.smallest_angle.value > 15.0, "{:?}", check(&new.mesh).0);
}

#[test]
fn straight_lines_are_coarsened_and_curves_keep_their_corners() {
    let coarse = AdaptOptions::default();
    let mesh = parts(16);
    let new = adapt(&mesh, &isotropic(&mesh, |_| 0.4), &coarse).unwrap();
    assert_same_domain(&mesh, &new.mesh);
    // Lower and upper half meet in a straight line, the disc is a polygon with corners.
    assert!(
        new.mesh.boundary("left").unwrap().len() <= 5,
        "{}",
        new.mesh.boundary("left").unwrap().len()
    );
    let mesh = disc([0.0; 2], 1.0, 10).unwrap();
    let new = adapt(&mesh, &isotropic(&mesh, |_| 0.4), &coarse).unwrap();
    assert_same_domain(&mesh, &new.mesh);
    assert_eq!(new.mesh.facets().len(), 60);
    assert!(new.mesh.cell_count() < mesh.cell_count() / 3);
}

#[test]
fn metrics_that_make_no_mesh_are_refused() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, 3], Diagonals::Right).unwrap();
    let refused = |metric: &Metric, options: AdaptOptions, words: &[&str]| {
        let message = adapt(&mesh, metric, &options).unwrap_err().to_string();
        assert!(words.iter().all(|w| message.contains(w)), "{message}");
    };
    let good = isotropic(&mesh, |_| 0.1);
    let options = AdaptOptions::default();
    refused(
        &Metric { tensors: good.tensors[1..].to_vec() },
        options,
        &["one tensor a point", "15 tensors, 16"],
    );
    refused(&isotropic(&mesh, |x| x[0]), options, &["not positive and finite", "point 0"]);
    refused(
        &isotropic(&mesh, |_| 1e-4),
        options,
        &["too many vertices", "about 125020001", "2000000"],
    );
    refused(&good, AdaptOptions { h_min: 2.0, ..options }, &["not in order", "h_min = 2"]);
    refused(&good, AdaptOptions { h_min: 0.2, h_max: 0.1, ..options }, &["not in order"]);
    assert!(good.graded(&mesh, 1.0).unwrap_err().to_string().contains("above 1"));
    assert!(good.intersect(&Metric { tensors: Vec::new() }).is_err());
}

#[test]
fn a_metric_scaled_to_a_number_of_vertices_gives_about_as_many() {
    for wanted in [200, 2000] {
        let mut mesh = rectangle([0.0; 2], [2.0, 1.0], [20, 10], Diagonals::Right).unwrap();
        for _ in 0..3 {
            let shape = |x: &Point<2>| {
                tensor(at(0.6, 0.8), 0.1 + (x[0] - 1.0).abs(), 0.5 + (x[0] - 1.0).abs())
            };
            let metric = Metric { tensors: mesh.points().iter().map(shape).collect() };
            let metric = metric.scaled_to(&mesh, wanted).unwrap();
            assert!((metric.expected_vertices(&mesh).unwrap() / wanted as f64 - 1.0).abs() < 1e-12);
            mesh = adapt(&mesh, &metric, &AdaptOptions::default()).unwrap().mesh;
        }
        let found = mesh.points().len() as f64 / wanted as f64;
        assert!((found - 1.0).abs() < 0.05, "{found} of {wanted}");
    }
}

#[test]
fn sizes_of_a_graded_metric_grow_no_faster_than_asked() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [24, 24], Diagonals::Right).unwrap();
    let metric = isotropic(&mesh, |x| if (x - at(0.5, 0.5)).norm() < 0.1 { 0.01 } else { 0.5 });
    let graded = metric.graded(&mesh, 1.4).unwrap();
    let size = |p: u32| graded.tensors[p as usize][(0, 0)].powf(-0.5);
    for c in 0..mesh.cell_count() {
        for k in 0..3 {
            let (p, q) = (mesh.cell(c)[k], mesh.cell(c)[(k + 1) % 3]);
            let e = (mesh.points()[p as usize] - mesh.points()[q as usize]).norm();
            // With l = e/h the factor 1 + l ln r makes h + e ln r.
            assert!((size(p) - size(q)).abs() <= e * 1.4f64.ln() * 1.02 + 1e-3 * size(p));
        }
    }
    // On a path of length s from the fine disc the size is 0.01 + s ln r.
    let corner = (0.5f64.sqrt() - 0.1) * 1.4f64.ln();
    assert!((size(0) - corner).abs() < 0.1 * corner, "{} {corner}", size(0));
}

#[test]
fn bounds_limits_and_hessians_give_the_metrics_of_their_formulas() {
    let hessian = tensor(at(0.6, 0.8), 0.1, 1.0) * 9.0;
    // Eigenvalues 900 and -9: the moduli count.
    let turned = hessian - SMatrix::<f64, 2, 2>::new(0.64, -0.48, -0.48, 0.36) * 18.0;
    let zero = SMatrix::<f64, 2, 2>::zeros();
    let metric = Metric::from_hessians(&[hessian, turned, zero], 0.02);
    for m in &metric.tensors[..2] {
        assert!((m - tensor(at(0.6, 0.8), 0.01, 0.1)).norm() < 1e-9 * m.norm(), "{m}");
    }
    assert!((metric.tensors[2] - SMatrix::<f64, 2, 2>::identity() * 1e-8).norm() < 1e-12);
    let same = |a: &Metric, b: SMatrix<f64, 2, 2>| {
        assert!((a.tensors[0] - b).norm() < 1e-9 * b.norm(), "{a:?} {b}")
    };
    same(&metric.bounded(0.02, 0.05), tensor(at(0.6, 0.8), 0.02, 0.05));
    same(&metric.limited_anisotropy(3.0), tensor(at(0.6, 0.8), 0.01, 0.03));
    let mesh = rectangle([0.0; 2], [3.0, 1.0], [5, 4], Diagonals::Right).unwrap();
    assert!((isotropic(&mesh, |_| 0.1).complexity(&mesh).unwrap() - 300.0).abs() < 1e-9);
}

/// A square with a square hole, whose points no cell uses, and a corner cut off: not convex.
fn pierced() -> Mesh<2> {
    let whole = rectangle([0.0; 2], [1.0; 2], [8, 8], Diagonals::UnionJack).unwrap();
    let centre = |c: usize| {
        (0..3).fold(at(0.0, 0.0), |s, k| s + whole.points()[whole.cell(c)[k] as usize]) / 3.0
    };
    let kept = |x: Point<2>| {
        !(x[0] + x[1] > 1.5 || (0.25 < x[0] && x[0] < 0.5 && 0.25 < x[1] && x[1] < 0.5))
    };
    let cells = (0..whole.cell_count())
        .filter(|&c| kept(centre(c)))
        .flat_map(|c| whole.cell(c).to_vec())
        .collect();
    let mut mesh = Mesh::<2>::new(whole.points().to_vec(), cells).unwrap();
    let all: Vec<u32> = (0..mesh.facets().len() as u32).collect();
    let inner = |f: &u32| {
        mesh.facet_points(&mesh.facets()[*f as usize])
            .all(|v| (whole.points()[v as usize] - at(0.375, 0.375)).amax() < 0.2)
    };
    let hole = all.iter().copied().filter(inner).collect();
    mesh.set_boundary("hole", hole);
    mesh.set_boundary("all", all);
    mesh
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let mesh = pierced();
    let metric = Metric {
        tensors: mesh
            .points()
            .iter()
            .map(|x| tensor(at(0.6, 0.8), 0.005 + 0.1 * x[0], 0.1))
            .collect(),
    };
    let run = |n| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| adapt(&mesh, &metric, &AdaptOptions::default()).unwrap().mesh)
    };
    let (one, two) = (run(1), run(2));
    assert_eq!(one.points(), two.points());
    assert!((0..one.cell_count()).all(|c| one.cell(c) == two.cell(c)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    /// Random tensors at every point, sizes over four decades, anisotropy up to 1e4, no gradation.
    #[test]
    fn wild_metrics_give_valid_meshes_of_the_same_domain(
        seed in prop::collection::vec((0.0..1.0f64, 0.0..1.0f64, 0.0..3.2f64), 81),
        fine in -2.5..-0.5f64, frozen: bool, hole: bool,
    ) {
        let mesh = if hole { pierced() } else { parts(8) };
        let sizes = |a: f64| 10f64.powf(fine + a * (0.5 - fine));
        let random = |(a, b, angle): &(f64, f64, f64)| tensor(at(angle.cos(), angle.sin()), sizes(*a), sizes(*b));
        let metric = Metric { tensors: seed.iter().map(random).collect() };
        let options = AdaptOptions { keep_boundary: frozen, most_vertices: 100_000, ..AdaptOptions::default() };
        let new = adapt(&mesh, &metric, &options).unwrap();
        assert_same_domain(&mesh, &new.mesh);
        // Back to something coarse, from a bad mesh.
        let back = adapt(&new.mesh, &isotropic(&new.mesh, |_| 0.2), &options).unwrap();
        assert_same_domain(&mesh, &back.mesh);
        prop_assert!(frozen || back.report.worst_quality > 0.1, "{:?}", back.report);
        prop_assert!(new.mesh.facets().iter().all(|f| new.mesh.neighbours(f.cell as usize)[f.opposite as usize] == NONE));
    }

    #[test]
    fn gradation_bounds_every_direction_along_every_edge_and_coarsens_nothing(
        seed in prop::collection::vec((-2.0..0.0f64, -2.0..0.0f64, 0.0..3.2f64), 81), ratio in 1.1..3.0f64,
    ) {
        let mesh = parts(8);
        let random = |(a, b, t): &(f64, f64, f64)| tensor(at(t.cos(), t.sin()), 10f64.powf(*a), 10f64.powf(*b));
        let metric = Metric { tensors: seed.iter().map(random).collect() };
        let graded = metric.graded(&mesh, ratio).unwrap();
        let directions = [at(1.0, 0.0), at(0.6, 0.8), at(0.0, 1.0), at(-0.8, 0.6)];
        let square = |m: &Metric, p: u32, e: &Point<2>| e.dot(&(m.tensors[p as usize] * e));
        for (c, (i, j)) in (0..mesh.cell_count()).flat_map(|c| [(c, (0, 1)), (c, (1, 2)), (c, (2, 0)), (c, (1, 0))]) {
            let (p, q) = (mesh.cell(c)[i], mesh.cell(c)[j]);
            let e = mesh.points()[q as usize] - mesh.points()[p as usize];
            let growth = 1.0 + square(&graded, p, &e).sqrt() * ratio.ln();
            for d in &directions {
                prop_assert!(square(&graded, q, d) > 0.99 * square(&graded, p, d) / growth.powi(2));
                prop_assert!(square(&graded, q, d) > (1.0 - 1e-6) * square(&metric, q, d));
            }
        }
    }
}
