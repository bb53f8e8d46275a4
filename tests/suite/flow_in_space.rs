//! Flows in space that lie in the discrete spaces come back to rounding, with every kind of
//! boundary, on every kind of mesh.

use immersa::fem::{
    Cells, Condition, Conditions, Element, Rule, Space, scalar_errors, vector_errors,
};
use immersa::flow::{BodyForce, Coefficient, FlowSolver, FlowState, Step, flux, traction};
use immersa::mesh::{Mesh, Point, ball_in_box, box_mesh, gmsh, refine};
use nalgebra::{SMatrix, SVector};
use std::path::Path;
use std::sync::Arc;

type V = SVector<f64, 3>;
type M = SMatrix<f64, 3, 3>;

/// An exact solution: velocity with its gradient, pressure with its gradient.
struct Exact {
    velocity: fn(&Point<3>) -> (V, M),
    pressure: fn(&Point<3>) -> (f64, V),
    force: fn(&Point<3>) -> V,
}

const VISCOSITY: f64 = 0.3;

struct Solved {
    velocity: Arc<Space<3>>,
    pressure: Arc<Space<3>>,
    solver: FlowSolver<3>,
    state: FlowState<3>,
}

fn stokes<'a>(force: &'a BodyForce<3>) -> Step<'a, 3> {
    Step { weight: 0.0, body_force: Some(force), ..Step::backward_euler(0.0, 1.0, &[]) }
}

/// Solves the Stokes equations and compares. The pressure is compared with its mean taken off where
/// nothing sets its level.
fn assert_exact(what: &str, mesh: Mesh<3>, conditions: Conditions<3>, exact: &Exact) -> Solved {
    let open = conditions.iter().any(|(_, c)| matches!(c, Condition::Open));
    let mesh = Arc::new(mesh);
    let [velocity, pressure] = [Element::P2, Element::P1].map(|e| Arc::new(Space::new(&mesh, e)));
    let mut solver =
        FlowSolver::new(&velocity, &pressure, &Arc::new(Rule::simplex(3, 5)), &conditions, 1.0)
            .unwrap();
    solver.set_materials(Coefficient::Constant(1.0), Coefficient::Constant(VISCOSITY));
    let mut state = solver.at_rest();
    let force = exact.force;
    let force = move |x: &Point<3>, _: f64| force(x);
    solver.step(&stokes(&force), &mut state).unwrap();
    let centre: Point<3> = mesh.bounding_box().0.lerp(&mesh.bounding_box().1, 0.5);
    let level = if open { 0.0 } else { (exact.pressure)(&centre).0 };
    let u = vector_errors(&velocity, &state.u, exact.velocity);
    let p = scalar_errors(&pressure, &state.p, |x| {
        let (p, g) = (exact.pressure)(x);
        (p - level, g)
    });
    assert!(u.l2 < 1e-10 && u.h1 < 1e-9 && p.l2 < 1e-9, "{what}: {u:?} {p:?}");
    Solved { velocity, pressure, solver, state }
}

fn given(f: fn(&Point<3>) -> (V, M)) -> Condition<3> {
    Condition::Velocity(Arc::new(move |x, _| f(x).0))
}

fn with_walls(mut mesh: Mesh<3>) -> Mesh<3> {
    mesh.set_boundary("walls", (0..mesh.facets().len() as u32).collect());
    mesh
}

fn gmsh_mesh(name: &str) -> Mesh<3> {
    gmsh::read::<3>(&Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes").join(name)).unwrap().0
}

/// A quadratic flow without divergence, all of whose components and derivatives are there; the
/// pressure is linear.
const QUADRATIC: Exact = Exact {
    velocity: |x| {
        let (x, y, z) = (x[0], x[1], x[2]);
        let u = V::new(y * y - x * z, z * z - x * y, x * x - y * z + 0.5 * z * z + x * z);
        let g = M::new(-z, 2.0 * y, -x, -y, -x, 2.0 * z, 2.0 * x + z, -z, -y + z + x);
        // The divergence -z - x - y + z + x is -y; the first component is made to take it up.
        (u + V::new(x * y, 0.0, 0.0), g + M::new(y, x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    },
    pressure: |x| (x[0] - 2.0 * x[1] + 3.0 * x[2], V::new(1.0, -2.0, 3.0)),
    // - mu lap u + grad p, with lap u = (2, 2, 3).
    force: |_| V::new(1.0, -2.0, 3.0) - V::new(2.0, 2.0, 3.0) * VISCOSITY,
};

#[test]
fn stokes_reproduces_polynomials_on_boxes_bisected_boxes_and_meshes_of_gmsh() {
    let small = || box_mesh([0.0; 3], [1.0, 1.5, 0.8], [3, 2, 2]).unwrap();
    let fine = ball_in_box([-1.0; 3], [1.0; 3], [2; 3], [0.1, 0.0, 0.0], 0.5, 0.05, 0.4).unwrap();
    for (what, mesh) in [
        ("box", small()),
        ("refined box", refine(&small(), |_, _| None).unwrap()),
        ("ball in box", fine),
        ("gmsh, ball", gmsh_mesh("ball.msh")),
    ] {
        assert_exact(
            what,
            with_walls(mesh),
            vec![("walls".into(), given(QUADRATIC.velocity))],
            &QUADRATIC,
        );
    }
}

/// A plug that comes in at one end and leaves at the other, which is free of stress.
#[test]
fn a_stream_passes_between_walls_that_slip_to_an_open_end() {
    let stream = Exact {
        velocity: |_| (V::new(0.0, 0.0, 1.0), M::zeros()),
        pressure: |_| (0.0, V::zeros()),
        force: |_| V::zeros(),
    };
    let mut conditions: Conditions<3> =
        ["left", "right", "bottom", "top"].map(|name| (name.to_string(), Condition::Slip)).to_vec();
    conditions.push(("back".into(), given(stream.velocity)));
    conditions.push(("front".into(), Condition::Open));
    let s = assert_exact(
        "stream",
        box_mesh([0.0; 3], [1.0, 1.5, 2.0], [2, 3, 3]).unwrap(),
        conditions,
        &stream,
    );
    assert!((flux(&s.velocity, &s.state, "front").unwrap() - 1.5).abs() < 1e-12);
}

/// The force `f = 2 mu` along z drives `w = y (1 - y)` between plates, periodic along z, with slip
/// at the sides x = 0 and 1.
#[test]
fn a_force_drives_the_parabola_between_plates_with_periodic_ends_and_sides_that_slip() {
    let plates = Exact {
        velocity: |x| {
            let mut g = M::zeros();
            g[(2, 1)] = 1.0 - 2.0 * x[1];
            (V::new(0.0, 0.0, x[1] * (1.0 - x[1])), g)
        },
        pressure: |_| (0.0, V::zeros()),
        force: |_| V::new(0.0, 0.0, 2.0 * VISCOSITY),
    };
    let conditions: Conditions<3> = vec![
        ("back".into(), Condition::Periodic("front".into())),
        ("left".into(), Condition::Slip),
        ("right".into(), Condition::Slip),
        ("bottom".into(), Condition::NoSlip),
        ("top".into(), Condition::NoSlip),
    ];
    let mesh = box_mesh([0.0; 3], [1.5, 1.0, 2.0], [2, 3, 3]).unwrap();
    let s = assert_exact("plates", mesh, conditions, &plates);
    // The volume that passes, and the force on a plate: half of what drives the fluid.
    assert!((flux(&s.velocity, &s.state, "front").unwrap() - 1.5 / 6.0).abs() < 1e-12);
    let load =
        traction(&s.velocity, &s.pressure, |_, _| VISCOSITY, &s.state, "top", &Point::<3>::zeros())
            .unwrap();
    assert!((load.force - V::new(0.0, 0.0, VISCOSITY * 3.0)).norm() < 1e-10, "{load:?}");
}

/// Shear `u = (y, 0, 2 y)` between a wall at rest and one that moves askew; both other directions
/// are periodic.
#[test]
fn shear_with_two_periodic_directions_gives_the_force_on_the_wall_both_ways() {
    let shear = Exact {
        velocity: |x| {
            (V::new(x[1], 0.0, 2.0 * x[1]), M::new(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0))
        },
        pressure: |_| (0.0, V::zeros()),
        force: |_| V::zeros(),
    };
    let conditions: Conditions<3> = vec![
        ("left".into(), Condition::Periodic("right".into())),
        ("back".into(), Condition::Periodic("front".into())),
        ("bottom".into(), Condition::NoSlip),
        ("top".into(), given(shear.velocity)),
    ];
    let mesh = box_mesh([0.0; 3], [1.0, 1.0, 2.0], [3, 2, 3]).unwrap();
    let s = assert_exact("shear", mesh, conditions, &shear);
    let exact = V::new(-VISCOSITY, 0.0, -2.0 * VISCOSITY) * 2.0;
    let about = Point::<3>::new(0.5, 0.0, 1.0);
    let load =
        traction(&s.velocity, &s.pressure, |_, _| VISCOSITY, &s.state, "top", &about).unwrap();
    assert!((load.force - exact).norm() < 1e-10, "{load:?}");
    // Spread evenly over the wall, one unit above the point.
    assert!((load.moment - V::new(0.0, 1.0, 0.0).cross(&exact)).norm() < 1e-10, "{load:?}");
    let still = |_: &Point<3>, _: f64| V::zeros();
    let reaction = s.solver.reaction(&stokes(&still), &s.state, Cells::All);
    let top: V = (0..s.velocity.len())
        .filter(|&n| s.velocity.nodes()[n][1] == 1.0)
        .map(|n| reaction[n])
        .sum();
    assert!((top + exact).norm() < 1e-10, "{top:?}");
}

/// On walls askew to the axes the normal component vanishes and both others are free.
#[test]
fn slip_on_oblique_walls_of_a_turned_duct() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 0.7);
    let square = box_mesh([0.0; 3], [1.0; 3], [2, 2, 2]).unwrap();
    let cells = (0..square.cell_count()).flat_map(|c| square.cell(c).to_vec()).collect();
    let mut mesh = Mesh::new(square.points().iter().map(|x| turn * x).collect(), cells).unwrap();
    for (name, facets) in square.boundaries() {
        mesh.set_boundary(name.clone(), facets.clone());
    }
    let along = turn * V::new(0.0, 0.0, 1.0);
    let mut conditions: Conditions<3> =
        ["left", "right", "bottom", "top"].map(|name| (name.to_string(), Condition::Slip)).to_vec();
    conditions.push(("back".into(), Condition::Velocity(Arc::new(move |_, _| along))));
    conditions.push(("front".into(), Condition::Open));
    let mesh = Arc::new(mesh);
    let [velocity, pressure] = [Element::P2, Element::P1].map(|e| Arc::new(Space::new(&mesh, e)));
    let mut solver =
        FlowSolver::new(&velocity, &pressure, &Arc::new(Rule::simplex(3, 5)), &conditions, 1.0)
            .unwrap();
    let mut state = solver.at_rest();
    let still = |_: &Point<3>, _: f64| V::zeros();
    solver.step(&stokes(&still), &mut state).unwrap();
    let u = vector_errors(&velocity, &state.u, |_| (along, M::zeros()));
    assert!(u.l2 < 1e-10, "{u:?}");
}
