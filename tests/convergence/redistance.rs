//! Redistancing: accuracy of the distance, and how far it displaces the interface.

use crate::tools::{Study, size};
use immersa::fem::{Element, Space};
use immersa::levelset::{
    Circle, Contour, Ellipse, Ellipsoid, Isosurface, Redistance, Redistancing, Shape, Union,
};
use immersa::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use immersa::transport::Tracer;
use std::sync::Arc;

const METHODS: [(&str, Redistance); 3] = [
    ("Hamilton-Jacobi", Redistance::HamiltonJacobi { iterations: 10 }),
    ("fast marching", Redistance::FastMarching),
    ("exact", Redistance::Exact),
];

/// Largest errors, in the mesh: of the distance at nodes up to `BAND` from the interface, of the
/// place of the interface, and of what it encloses (relative, against what it enclosed before).
#[derive(Clone, Copy, Debug)]
struct Errors {
    distance: f64,
    place: f64,
    enclosed: f64,
}

impl std::fmt::Display for Errors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "distance {:.2e}, place {:.2e}, enclosed {:+.1e}",
            self.distance, self.place, self.enclosed
        )
    }
}

const BAND: f64 = 0.1;

/// What a dimension measures: points of the cut interface, and what it encloses.
type Measure<const D: usize> = fn(&Space<D>, &[f64]) -> (Vec<Point<D>>, f64);

fn in_the_plane(space: &Space<2>, phi: &[f64]) -> (Vec<Point<2>>, f64) {
    let contour = Contour::new(space, phi).unwrap();
    let points = contour.quadrature(space, phi).iter().map(|q| q.point).collect();
    (points, contour.measures().unwrap().area)
}

fn in_space(space: &Space<3>, phi: &[f64]) -> (Vec<Point<3>>, f64) {
    let surface = Isosurface::new(space, phi).unwrap();
    let points = surface.quadrature(space, phi).iter().map(|q| q.at.x).collect();
    (points, surface.measures().unwrap().volume)
}

struct Case<'a, const D: usize> {
    mesh: Mesh<D>,
    shape: &'a dyn Shape<D>,
    function: &'a dyn Fn(&Point<D>) -> f64,
    measure: Measure<D>,
}

impl<const D: usize> Case<'_, D> {
    /// Errors before anything was done, and after redistancing `times` times.
    fn errors(self, method: Redistance, volume: bool, times: usize) -> [Errors; 2] {
        let space = Arc::new(Space::new(&Arc::new(self.mesh), Element::P2));
        let tracer = Tracer::new(&space, &[]);
        let mut phi = space.interpolate(self.function);
        let at_start = (self.measure)(&space, &phi).1;
        // Up to a quarter of the reach of the characteristics, which a steep function delays.
        let band = match method {
            Redistance::HamiltonJacobi { iterations } => {
                BAND.min(0.125 * iterations as f64 * size(space.mesh()) / (D as f64).sqrt())
            }
            _ => BAND,
        };
        let errors = |phi: &[f64]| {
            let (points, enclosed) = (self.measure)(&space, phi);
            let off = |(x, v): (&Point<D>, &f64)| {
                let d = self.shape.distance(x);
                if d.abs() < band { (v - d).abs() } else { 0.0 }
            };
            Errors {
                distance: space.nodes().iter().zip(phi).map(off).fold(0.0, f64::max),
                place: points.iter().map(|x| self.shape.distance(x).abs()).fold(0.0, f64::max),
                enclosed: enclosed / at_start - 1.0,
            }
        };
        let before = errors(&phi);
        let redistancing = Redistancing { method, volume };
        for _ in 0..times {
            redistancing.apply(&tracer, &[], 1.0, &mut phi).unwrap();
        }
        [before, errors(&phi)]
    }
}

/// An ellipse by a function that is no distance, on `n x n` squares.
fn ellipse(n: usize, method: Redistance, volume: bool, times: usize) -> [Errors; 2] {
    let (a, b) = (0.35, 0.2);
    let case = Case {
        mesh: rectangle([-0.5; 2], [0.5; 2], [n; 2], Diagonals::Right).unwrap(),
        shape: &Ellipse::new(Point::<2>::new(0.011, 0.007), [a, b].into(), 0.0).unwrap(),
        function: &|x: &Point<2>| {
            (((x[0] - 0.011) / a).powi(2) + ((x[1] - 0.007) / b).powi(2) - 1.0).exp_m1()
        },
        measure: in_the_plane,
    };
    case.errors(method, volume, times)
}

/// Two discs of radius .2 that overlap.
fn discs(n: usize, method: Redistance, volume: bool, times: usize) -> [Errors; 2] {
    let disc =
        |x| Box::new(Circle::new(Point::<2>::new(x, 0.007), 0.2).unwrap()) as Box<dyn Shape<2>>;
    let square = |x: &Point<2>, c: f64| (x - Point::<2>::new(c, 0.007)).norm_squared() - 0.04;
    let case = Case {
        mesh: rectangle([-0.5; 2], [0.5; 2], [n; 2], Diagonals::Right).unwrap(),
        shape: &Union::new(vec![disc(-0.13), disc(0.14)]).unwrap(),
        function: &|x: &Point<2>| square(x, -0.13).min(square(x, 0.14)),
        measure: in_the_plane,
    };
    case.errors(method, volume, times)
}

fn ellipsoid(n: usize, method: Redistance, volume: bool, times: usize) -> [Errors; 2] {
    let axes = Point::<3>::new(0.35, 0.3, 0.25);
    let centre = Point::<3>::new(0.011, 0.007, -0.013);
    let case = Case {
        mesh: box_mesh([-0.5; 3], [0.5; 3], [n; 3]).unwrap(),
        shape: &Ellipsoid::new(centre, axes, Point::<3>::zeros()).unwrap(),
        function: &|x: &Point<3>| ((x - centre).component_div(&axes).norm_squared() - 1.0).exp_m1(),
        measure: in_space,
    };
    case.errors(method, volume, times)
}

/// The errors on a row of meshes, after one redistancing.
fn row(case: impl Fn(usize) -> [Errors; 2], meshes: &[usize], what: &str) -> Vec<Errors> {
    let measured = |&n: &usize| {
        let [before, after] = case(n);
        println!("{what}, {n} cells along a side: place before {:.2e}; {after}", before.place);
        after
    };
    meshes.iter().map(measured).collect()
}

/// Slope of the distance at nodes and of the place of the interface, at least, and their largest
/// last errors.
fn assert_orders(
    errors: &[Errors],
    meshes: &[usize],
    what: &str,
    distance: (f64, f64),
    place: (f64, f64),
) {
    let sizes: Vec<f64> = meshes.iter().map(|n| 1.0 / *n as f64).collect();
    let assert = |what: String, errors: Vec<f64>, (order, last): (f64, f64)| {
        Study { what: &what, sizes: &sizes, errors }.assert_at_least(order, last);
    };
    assert(format!("{what}: distance"), errors.iter().map(|e| e.distance).collect(), distance);
    assert(format!("{what}: place"), errors.iter().map(|e| e.place).collect(), place);
}

/// An ellipse from a function that is neither a distance nor of the space.
#[test]
fn an_ellipse_becomes_a_distance() {
    let meshes = [16, 32, 64, 128];
    let bounds =
        [((2.3, 4e-5), (2.3, 4e-5)), ((0.6, 2e-3), (2.8, 4e-6)), ((2.8, 4e-6), (2.8, 4e-6))];
    for ((name, method), (distance, place)) in METHODS.into_iter().zip(bounds) {
        for volume in [false, true] {
            let what = format!("Ellipse, {name}{}", if volume { " with its area" } else { "" });
            let errors = row(|n| ellipse(n, method, volume, 1), &meshes, &what);
            assert_orders(&errors, &meshes, &what, distance, place);
            assert!(!volume || errors.iter().all(|e| e.enclosed.abs() < 1e-11), "{errors:?}");
        }
        let many = ellipse(64, method, false, 20)[1];
        println!("    20 times on 64: {many}");
        // Once in every step: the displacement grows, but no faster than the number of times.
        let once = ellipse(64, method, false, 1)[1];
        assert!(many.place < 20.0 * once.place, "{name}: {} and {}", many.place, once.place);
    }
}

/// An interface with corners: of first order there, whatever is done.
#[test]
fn two_discs_that_overlap_become_a_distance() {
    let meshes = [32, 64, 128];
    for (name, method) in METHODS {
        for volume in [false, true] {
            let what = format!("Discs, {name}{}", if volume { " with their area" } else { "" });
            let errors = row(|n| discs(n, method, volume, 1), &meshes, &what);
            assert_orders(&errors, &meshes, &what, (0.5, 1e-2), (0.8, 4e-3));
            assert!(!volume || errors.iter().all(|e| e.enclosed.abs() < 1e-11), "{errors:?}");
        }
    }
}

#[test]
fn an_ellipsoid_becomes_a_distance() {
    let meshes = [8, 16, 32];
    let bounds =
        [((2.5, 2e-3), (2.5, 2e-3)), ((0.5, 4e-3), (2.5, 4e-4)), ((2.5, 4e-4), (2.5, 4e-4))];
    for ((name, method), (distance, place)) in METHODS.into_iter().zip(bounds) {
        let what = format!("Ellipsoid, {name} with its volume");
        let errors = row(|n| ellipsoid(n, method, true, 1), &meshes, &what);
        assert_orders(&errors, &meshes, &what, distance, place);
        assert!(errors.iter().all(|e| e.enclosed.abs() < 1e-11), "{errors:?}");
    }
}

/// A straight filament of half-width `r` node distances anywhere in the mesh: what the P2 function
/// of its exact distance encloses, over what it should, on the average. Below half a node distance
/// it is lost; at one it swells, because the function rounds the kink in its middle: a filament
/// that is stretched and redistanced gets no thinner than that.
#[test]
fn a_filament_of_two_node_distances_swells() {
    let n = 32;
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [n; 2], Diagonals::Right).unwrap());
    let space = Space::new(&mesh, Element::P2);
    let h = 0.5 / n as f64;
    let swollen = |r: f64| {
        let place = |k: usize| {
            let (middle, along) = (0.7 + 0.037 * h * k as f64, Point::<2>::new(0.6, 0.8));
            let phi = space.interpolate(|x| (x.dot(&along) - middle).abs() - r * h);
            let area = Contour::new(&space, &phi).unwrap().measures().map_or(0.0, |m| m.area);
            area / exact_strip(&along, middle, r * h)
        };
        (0..60).map(place).sum::<f64>() / 60.0
    };
    let found: Vec<f64> = [0.25, 0.5, 1.0, 2.0, 4.0].map(swollen).to_vec();
    println!(
        "Filament of half-width 1/4, 1/2, 1, 2, 4 node distances: area over the exact one \
         {found:.3?}"
    );
    assert!(found[0] < 0.5 && found[1] < 1.0 && found[2] > 1.04 && found[2] < 1.08, "{found:?}");
    assert!((found[4] - 1.0).abs() < 1e-3, "{found:?}");
}

/// Area of the strip about `x . along = middle` in the unit square, by slices.
fn exact_strip(along: &Point<2>, middle: f64, r: f64) -> f64 {
    let slices = 20_000;
    let width = |k: usize| {
        let x = (k as f64 + 0.5) / slices as f64;
        let y = |d: f64| ((middle + d - x * along[0]) / along[1]).clamp(0.0, 1.0);
        y(r) - y(-r)
    };
    (0..slices).map(width).sum::<f64>() / slices as f64
}
