use super::*;
use crate::fem::{Condition, Element, Space, periodic_pairs};
use crate::levelset::{Circle, Shape};
use crate::mesh::{Diagonals, Point, box_mesh, rectangle};
use std::sync::Arc;

const ALL: [Redistance; 3] =
    [Redistance::HamiltonJacobi { iterations: 10 }, Redistance::FastMarching, Redistance::Exact];

fn plane(n: usize) -> Arc<Space<2>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [n; 2], Diagonals::Right).unwrap();
    Arc::new(Space::new(&Arc::new(mesh), Element::P2))
}
fn apply(space: &Arc<Space<2>>, method: Redistance, volume: bool, slope: f64, phi: &mut Vec<f64>) {
    let how = Redistancing { method, volume };
    how.apply(&Tracer::new(space, &[]), &[], slope, phi).unwrap();
}

#[test]
fn a_function_of_one_sign_is_left_alone_and_one_that_is_not_finite_is_an_error() {
    let space = plane(4);
    for method in ALL {
        for value in [2.0, 0.0, -3.0] {
            let mut phi = vec![value; space.len()];
            apply(&space, method, true, 1.0, &mut phi);
            assert!(phi.iter().all(|v| *v == value), "{method:?}");
        }
        let how = Redistancing { method, volume: false };
        let mut phi = vec![f64::NAN; space.len()];
        assert!(how.apply(&Tracer::new(&space, &[]), &[], 1.0, &mut phi).is_err());
    }
}

/// A straight interface has a distance function in the space: all methods reproduce it, for any
/// slope before and after.
#[test]
fn a_straight_interface_gets_its_slope() {
    let space = plane(10);
    let along = Point::<2>::new(0.6, 0.8);
    let exact = |x: &Point<2>| 1.5 * (x.dot(&along) - 0.71);
    for (method, bound) in ALL.into_iter().zip([1e-12, 1e-12, 1e-14]) {
        let mut phi = space.interpolate(|x| exact(x) * 3.0);
        apply(&space, method, false, 1.5, &mut phi);
        // Within the range of ten characteristics, away from characteristics that start at a wall.
        let near = |x: &Point<2>| {
            let d = exact(x) / 1.5;
            d.abs() < 0.2 && (x - along * d).iter().all(|c| (0.25..0.75).contains(c))
        };
        let errors = space
            .nodes()
            .iter()
            .zip(&phi)
            .filter(|(x, _)| near(x))
            .map(|(x, v)| (v - exact(x)).abs());
        let worst = errors.fold(0.0, f64::max);
        assert!(worst < bound, "{method:?}: {worst:e}");
    }
}

/// The exact distance to a quadratic zero set: that of the circle itself, to rounding, at all
/// nodes; no sign changes.
#[test]
fn the_distance_to_a_quadratic_zero_set_is_exact() {
    let space = plane(13);
    let circle = Circle::new(Point::<2>::new(0.47, 0.52), 0.31).unwrap();
    let square = |x: &Point<2>| (x - Point::<2>::new(0.47, 0.52)).norm_squared() - 0.31 * 0.31;
    let mut phi = space.interpolate(square);
    apply(&space, Redistance::Exact, false, 1.0, &mut phi);
    for (x, v) in space.nodes().iter().zip(&phi) {
        assert!((v - circle.distance(x)).abs() < 1e-13, "{v} at {x}");
        assert_eq!(*v < 0.0, square(x) < 0.0);
    }
}

/// Through periodic sides everything is as if the mesh were shifted: a disc in the corner has the
/// distances of one in the middle.
#[test]
fn distances_go_through_periodic_sides() {
    let n = 16;
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [n; 2], Diagonals::Right).unwrap();
    let all = (0..mesh.facets().len() as u32).collect();
    mesh.set_boundary("walls", all);
    let conditions = vec![
        ("left".to_string(), Condition::Periodic("right".into())),
        ("bottom".to_string(), Condition::Periodic("top".into())),
    ];
    let pairs = periodic_pairs(&mesh, &conditions).unwrap();
    let space = Arc::new(Space::new(&Arc::new(mesh), Element::P2));
    let tracer = Tracer::new(&space, &pairs);
    // (1 - cos) / 2 grows like a square: no distance, and periodic.
    let bump = |x: &Point<2>, c: f64| {
        let part = |v: f64| 0.5 - 0.5 * (2.0 * std::f64::consts::PI * (v - c)).cos();
        part(x[0]) + part(x[1]) - 0.5
    };
    for method in ALL {
        let how = Redistancing { method, volume: false };
        let result = |c: f64| {
            let mut phi = space.interpolate(|x| bump(x, c));
            how.apply(&tracer, &pairs, 1.0, &mut phi).unwrap();
            phi
        };
        let (corner, middle) = (result(0.0), result(0.5));
        let (mut compared, mut worst) = (0, 0.0_f64);
        for (x, v) in space.nodes().iter().zip(&corner) {
            let moved = x.map(|v| (v + 0.5) % 1.0);
            let Some(k) = space.nodes().iter().position(|y| (y - moved).norm() < 1e-9) else {
                continue;
            };
            // Near the medial axis the limiter acts, and a foot on an edge belongs to either of two
            // cells, by rounding, whose values limit it.
            if matches!(method, Redistance::HamiltonJacobi { .. }) && v.abs() > 0.05 {
                continue;
            }
            worst = worst.max((v - middle[k]).abs());
            compared += 1;
        }
        // A foot beyond a periodic side is not followed into the cell on the other side: the
        // nearest point of the cut replaces it. The bound is measured: 1/30 of the spacing of the
        // nodes.
        let bound = if matches!(method, Redistance::HamiltonJacobi { .. }) { 1e-9 } else { 1e-3 };
        assert!(
            compared > space.len() / 10 && worst < bound,
            "{method:?}: {compared} nodes, {worst:e}"
        );
    }
}

#[test]
fn the_bits_do_not_depend_on_the_number_of_threads() {
    let mesh = Arc::new(box_mesh([0.0; 3], [1.0; 3], [6; 3]).unwrap());
    let space = Arc::new(Space::new(&mesh, Element::P2));
    for method in ALL {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut phi =
                space.interpolate(|x| (x - Point::<3>::repeat(0.51)).norm_squared() - 0.1);
            let how = Redistancing { method, volume: true };
            pool.install(|| how.apply(&Tracer::new(&space, &[]), &[], 1.0, &mut phi).unwrap());
            phi
        };
        assert!(run(1) == run(3), "{method:?}");
    }
}
