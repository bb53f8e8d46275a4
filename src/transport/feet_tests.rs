use super::*;
use crate::fem::{Condition, periodic_pairs};
use crate::fem::{Element, Rule};
use crate::mesh::{Diagonals, Mesh, box_mesh, rectangle};

/// Solid rotation: the exact foot is a rotation; the midpoint rule is of third order in one
/// step.
#[test]
fn feet_of_a_rotation_converge_with_order_three() {
    let mesh = Arc::new(rectangle([-1.0, -1.0], [1.0, 1.0], [8, 8], Diagonals::Right).unwrap());
    let space = Arc::new(Space::new(&mesh, Element::P2));
    let u = space.interpolate(|x| Point::<2>::new(-x[1], x[0]));
    let basis = Basis::new(&space, &Arc::new(Rule::simplex(2, 5)));
    let tracer = Tracer::new(&space, &[]);
    let error = |dt: f64| {
        let mut feet = Feet::default();
        tracer.from_quadrature(&u, dt, &basis, &mut feet);
        let mut worst: f64 = 0.0;
        for c in 0..mesh.cell_count() {
            for q in 0..7 {
                let x = basis.at(c, q).x;
                if x.norm() < 0.9 {
                    let exact = Point::<2>::new(
                        x[0] * dt.cos() + x[1] * dt.sin(),
                        x[1] * dt.cos() - x[0] * dt.sin(),
                    );
                    worst = worst.max((mesh.point_at(feet.get(c * 7 + q)) - exact).norm());
                }
            }
        }
        worst
    };
    let order = (error(0.04) / error(0.02)).log2();
    assert!((order - 3.0).abs() < 0.1, "order {order}");
    assert!(error(0.04) < 2e-5);
}

/// A uniform velocity moves a quadratic function without error, in both methods of transport,
/// whatever the Courant number; at the inflow the value of the boundary is taken.
#[test]
fn a_uniform_velocity_translates_a_quadratic_function_exactly() {
    let mesh = Arc::new(rectangle([0.0; 2], [4.0, 1.0], [16, 4], Diagonals::UnionJack).unwrap());
    let space = Arc::new(Space::new(&mesh, Element::P2));
    let (w, dt) = (Point::<2>::new(1.0, 0.0), 0.7);
    let u = vec![w; space.len()];
    let tracer = Tracer::new(&space, &[]);
    assert!(tracer.courant(&u, dt) > 1.9, "{}", tracer.courant(&u, dt));
    let f = |x: &Point<2>| x[0] * x[0] - 3.0 * x[0] * x[1] + 0.5;
    let old = space.interpolate(f);
    let mut feet = Feet::default();
    tracer.from_nodes(&u, dt, &mut feet);
    let mut new = vec![0.0; space.len()];
    crate::transport::carry_nodal(&space, &old, &feet, &mut new);
    for (x, v) in space.nodes().iter().zip(&new) {
        let from = Point::<2>::new((x[0] - dt).max(0.0), x[1]);
        assert!((v - f(&from)).abs() < 1e-12, "{x} {v}");
    }
}

/// The classical Runge-Kutta rule along a given velocity: fifth order in one step, in time too.
#[test]
fn paths_of_a_given_velocity_are_of_fourth_order() {
    // The solution of x' = (t x, 1) from (1, 0) at t = 0 is (exp(t^2/2), t).
    let velocity: VelocityFunction<2> =
        Arc::new(|x: &Point<2>, t: f64| Point::<2>::new(t * x[0], 1.0));
    let error = |steps| {
        let end = path(&velocity, Point::<2>::new(1.0, 0.0), 0.0, 1.0, steps);
        (end - Point::<2>::new(0.5f64.exp(), 1.0)).norm()
    };
    let order = (error(8) / error(16)).log2();
    assert!((order - 4.0).abs() < 0.15 && error(16) < 1e-6, "{order} {:e}", error(16));
}

/// The mesh without the cells whose centre lies in the open box from 1 to 2.
fn with_hole<const D: usize>(mesh: &Mesh<D>) -> Mesh<D> {
    let centre = |c: usize| {
        mesh.cell(c).iter().fold(Point::<D>::zeros(), |s, &v| s + mesh.points()[v as usize])
            / (D + 1) as f64
    };
    let kept = (0..mesh.cell_count()).filter(|&c| !centre(c).iter().all(|&x| 1.0 < x && x < 2.0));
    Mesh::new(mesh.points().to_vec(), kept.flat_map(|c| mesh.cell(c).to_vec()).collect()).unwrap()
}

/// Paths in several substeps are chains of short steps, which use points of space and values of the
/// velocity instead of barycentric coordinates and drifts: to rounding, through cells, out of the
/// domain, into holes and through periodic sides. Returns how many left the domain.
fn as_many_short_steps<const D: usize>(mesh: &Mesh<D>, periodic: &[(&str, &str)]) -> usize {
    let conditions: Vec<_> =
        periodic.iter().map(|(a, b)| (a.to_string(), Condition::Periodic(b.to_string()))).collect();
    let pairs = periodic_pairs(mesh, &conditions).unwrap();
    let space = Arc::new(Space::new(&Arc::new(mesh.clone()), Element::P2));
    let (tracer, basis) =
        (Tracer::new(&space, &pairs), Basis::new(&space, &Arc::new(Rule::simplex(D, 5))));
    let turn = 2.0 * std::f64::consts::PI / 3.0;
    let u = space.interpolate(|x| {
        Point::<D>::from_fn(|i, _| 0.7 - 0.3 * i as f64 + (turn * x[(i + 1) % D] + 0.4).sin())
    });
    let dt = 5.2 / tracer.courant(&u, 1.0);
    let mut feet = Feet::default();
    tracer.from_quadrature(&u, dt, &basis, &mut feet);
    let points = basis.rule().len();
    let starts: Vec<_> = (0..feet.len())
        .map(|i| (i / points, basis.rule().points[i % points]))
        .map(|(c, barycentric)| Location { cell: c as u32, barycentric })
        .collect();
    let back: Vec<_> = u.iter().map(|v| -v).collect();
    let ends = tracer.ahead(&AdvectingVelocity::Nodal(&back), dt, &starts);
    let mut left = 0;
    for (i, start) in starts.iter().enumerate() {
        let (mut here, mut inside) = (*start, true);
        for _ in 0..6 {
            if inside {
                (here, inside) = tracer.end_of_short_step(&u, -dt / 6.0, here);
            }
        }
        left += usize::from(!inside);
        let far = (mesh.point_at(feet.get(i)) - mesh.point_at(&here)).norm();
        assert!(far < 1e-12 && ends[i] == (*feet.get(i), inside), "{start:?}: {far:e} {inside}");
        assert!(feet.get(i).barycentric.iter().all(|l| *l >= -crate::mesh::TOLERANCE));
    }
    left
}

#[test]
fn several_substeps_are_as_many_short_steps() {
    let plane = rectangle([0.0; 2], [3.0; 2], [9, 9], Diagonals::UnionJack).unwrap();
    let space = box_mesh([0.0; 3], [3.0; 3], [6, 6, 6]).unwrap();
    assert!(as_many_short_steps(&with_hole(&plane), &[]) > 100);
    assert!(as_many_short_steps(&with_hole(&space), &[]) > 100);
    assert_eq!(as_many_short_steps(&plane, &[("left", "right"), ("bottom", "top")]), 0);
    assert!(as_many_short_steps(&space, &[("left", "right")]) > 100);
}
