//! Solutions that lie in the discrete spaces come back to rounding; slip, open and periodic
//! boundaries; forces two ways.

use immersa::base::Cause;
use immersa::fem::{Condition, Conditions, Element, Rule, Space, scalar_errors, vector_errors};
use immersa::flow::{Coefficient, FlowSolver, FlowState, History, Step, flux, traction};
use immersa::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use immersa::transport::{Feet, Tracer};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

type V = SVector<f64, 2>;

fn given<const D: usize>(
    f: impl Fn(&Point<D>) -> SVector<f64, D> + Send + Sync + 'static,
) -> Condition<D> {
    Condition::Velocity(Arc::new(move |x, _| f(x)))
}

struct Setup<const D: usize> {
    velocity: Arc<Space<D>>,
    pressure: Arc<Space<D>>,
    solver: FlowSolver<D>,
}

fn setup<const D: usize>(
    mesh: Mesh<D>,
    conditions: Conditions<D>,
    viscosity: f64,
    density: f64,
) -> Setup<D> {
    let mesh = Arc::new(mesh);
    let velocity = Arc::new(Space::new(&mesh, Element::P2));
    let pressure = Arc::new(Space::new(&mesh, Element::P1));
    let rule = Arc::new(Rule::simplex(D, 5));
    let mut solver = FlowSolver::new(&velocity, &pressure, &rule, &conditions, 1.0).unwrap();
    solver.set_materials(Coefficient::Constant(density), Coefficient::Constant(viscosity));
    Setup { velocity, pressure, solver }
}

fn stokes<'a, const D: usize>() -> Step<'a, D> {
    Step { weight: 0.0, ..Step::backward_euler(0.0, 1.0, &[]) }
}

fn unit_square(n: usize) -> Mesh<2> {
    rectangle([0.0, 0.0], [1.0, 1.0], [n, n], Diagonals::Right).unwrap()
}

#[test]
fn stokes_reproduces_a_quadratic_velocity_and_a_linear_pressure() {
    let mu = 0.3;
    let exact = |x: &Point<2>| V::new(x[1] * x[1], x[0] * x[0]);
    let mut s = setup(unit_square(5), vec![("walls".into(), given(exact))], mu, 1.0);
    let mut state = s.solver.at_rest();
    let force = move |_: &Point<2>, _: f64| V::new(3.0 - 2.0 * mu, -2.0 - 2.0 * mu);
    let report = s.solver.step(&Step { body_force: Some(&force), ..stokes() }, &mut state).unwrap();
    assert!(report.solve.residual < 1e-12);
    let u = vector_errors(&s.velocity, &state.u, |x| {
        (exact(x), SMatrix::<f64, 2, 2>::new(0.0, 2.0 * x[1], 2.0 * x[0], 0.0))
    });
    let p = scalar_errors(&s.pressure, &state.p, |x| {
        (3.0 * x[0] - 2.0 * x[1] - 0.5, V::new(3.0, -2.0))
    });
    assert!(u.l2 < 1e-10 && u.h1 < 1e-10 && p.l2 < 1e-10, "{u:?} {p:?}");
}

#[test]
fn stokes_reproduces_polynomials_in_three_dimensions() {
    let mesh = box_mesh([0.0; 3], [1.0; 3], [2, 2, 2]).unwrap();
    let exact = |x: &Point<3>| SVector::<f64, 3>::new(x[1] * x[1], x[2] * x[2], x[0] * x[0]);
    let mut s = setup(mesh, vec![("walls".into(), given(exact))], 1.0, 1.0);
    let mut state = s.solver.at_rest();
    let force = |_: &Point<3>, _: f64| SVector::<f64, 3>::new(-1.0, -2.0, -2.0);
    s.solver.step(&Step { body_force: Some(&force), ..stokes() }, &mut state).unwrap();
    let u = vector_errors(&s.velocity, &state.u, |x| {
        let g = SMatrix::<f64, 3, 3>::new(
            0.0,
            2.0 * x[1],
            0.0,
            0.0,
            0.0,
            2.0 * x[2],
            2.0 * x[0],
            0.0,
            0.0,
        );
        (exact(x), g)
    });
    let p = scalar_errors(&s.pressure, &state.p, |x| {
        (x[0] - 0.5, SVector::<f64, 3>::new(1.0, 0.0, 0.0))
    });
    assert!(u.l2 < 1e-10 && u.h1 < 1e-10 && p.l2 < 1e-10, "{u:?} {p:?}");
}

/// In these boxes three pressures near a corner were merged with the three components of one
/// velocity node: a zero pivot.
#[test]
fn pressures_near_the_corner_of_a_box_have_pivots() {
    for cells in [[6, 6, 6], [7, 7, 7], [4, 3, 4], [5, 6, 4]] {
        let mut s = setup(box_mesh([0.0; 3], [1.0; 3], cells).unwrap(), vec![], 1.0, 1.0);
        let mut state = s.solver.at_rest();
        let force = |x: &Point<3>, _: f64| SVector::<f64, 3>::new(x[1], x[2] * x[2], -x[0]);
        let report =
            s.solver.step(&Step { body_force: Some(&force), ..stokes() }, &mut state).unwrap();
        assert!(
            report.solve.residual < 1e-13 && report.solve.refinements == 0,
            "{cells:?}: {:?}",
            report.solve
        );
    }
}

#[test]
fn a_navier_stokes_step_keeps_channel_flow() {
    let mu = 0.05;
    let exact = |x: &Point<2>| V::new(x[1] * (1.0 - x[1]), 0.0);
    let mut s = setup(unit_square(4), vec![("walls".into(), given(exact))], mu, 2.0);
    let tracer = Tracer::new(&s.velocity, &[]);
    let start = s.velocity.interpolate(exact);
    let mut feet = Feet::default();
    tracer.from_quadrature(&start, 0.1, s.solver.velocity(), &mut feet);
    let history = [History { weight: 1.0, u: &start, feet: Some(&feet) }];
    let mut state = s.solver.at_rest();
    // Feet of points near the inflow would leave the domain; the field is the same where they stop.
    let step = Step { time: 0.1, dt: 0.1, weight: 1.0, history: &history, ..stokes() };
    s.solver.step(&step, &mut state).unwrap();
    let u = vector_errors(&s.velocity, &state.u, |x| {
        (exact(x), SMatrix::<f64, 2, 2>::new(0.0, 1.0 - 2.0 * x[1], 0.0, 0.0))
    });
    let p = scalar_errors(&s.pressure, &state.p, |x| {
        (-2.0 * mu * (x[0] - 0.5), V::new(-2.0 * mu, 0.0))
    });
    assert!(u.l2 < 1e-10 && p.l2 < 1e-10, "{u:?} {p:?}");
}

/// Plane shear between a moving wall and a wall at rest, with slip or periodic sides: linear, so
/// exact. Traction and residual agree.
#[test]
fn shear_flow_is_exact_with_slip_and_periodic_sides_and_gives_the_wall_force_both_ways() {
    let mu = 0.7;
    let exact = |x: &Point<2>| V::new(x[1], 0.0);
    let periodic: Conditions<2> = vec![
        ("left".into(), Condition::Periodic("right".into())),
        ("bottom".into(), Condition::NoSlip),
        ("top".into(), given(exact)),
    ];
    let mut s = setup(unit_square(4), periodic, mu, 1.0);
    let mut state = s.solver.at_rest();
    s.solver.step(&stokes(), &mut state).unwrap();
    let u = vector_errors(&s.velocity, &state.u, |x| {
        (exact(x), SMatrix::<f64, 2, 2>::new(0.0, 1.0, 0.0, 0.0))
    });
    assert!(u.l2 < 1e-10, "{u:?}");
    let about = V::new(0.5, 0.5);
    let by_stress = traction(&s.velocity, &s.pressure, |_, _| mu, &state, "top", &about).unwrap();
    assert!((by_stress.force - V::new(-mu, 0.0)).norm() < 1e-10, "{by_stress:?}");
    // The force is spread evenly over the side, half a unit above the point.
    assert!((by_stress.moment[2] - 0.5 * mu).abs() < 1e-10, "{by_stress:?}");
    let reaction = s.solver.reaction(&stokes(), &state, immersa::fem::Cells::All);
    let top: V = (0..s.velocity.len())
        .filter(|&n| s.velocity.nodes()[n][1] == 1.0)
        .map(|n| reaction[n])
        .sum();
    assert!((top - V::new(mu, 0.0)).norm() < 1e-10, "{top:?}");
    assert!((s.solver.wall_power(&stokes(), &state) - mu).abs() < 1e-10);
}

#[test]
fn slip_walls_let_a_uniform_stream_pass_and_an_open_end_fixes_the_pressure() {
    let stream: Conditions<2> = vec![
        ("left".into(), given(|_| V::new(1.0, 0.0))),
        ("bottom".into(), Condition::Slip),
        ("top".into(), Condition::Slip),
        ("right".into(), Condition::Open),
    ];
    let mut s = setup(unit_square(4), stream, 1.0, 1.0);
    let mut state: FlowState<2> = s.solver.at_rest();
    s.solver.step(&stokes(), &mut state).unwrap();
    let u = vector_errors(&s.velocity, &state.u, |_| (V::new(1.0, 0.0), SMatrix::zeros()));
    let p = scalar_errors(&s.pressure, &state.p, |_| (0.0, V::zeros()));
    assert!(u.l2 < 1e-10 && p.l2 < 1e-10, "{u:?} {p:?}");
    assert!((flux(&s.velocity, &state, "right").unwrap() - 1.0).abs() < 1e-12);
}

/// On a wall that is not aligned with the axes the normal component vanishes and the tangential one
/// is free.
#[test]
fn slip_on_an_oblique_wall() {
    // A unit square turned by 30 degrees, sheared along itself: uniform flow along its sides.
    let square = unit_square(3);
    let (s30, c30) = 30f64.to_radians().sin_cos();
    let turn = |p: &Point<2>| Point::<2>::new(c30 * p[0] - s30 * p[1], s30 * p[0] + c30 * p[1]);
    let cells = (0..square.cell_count()).flat_map(|c| square.cell(c).to_vec()).collect();
    let mut mesh = Mesh::new(square.points().iter().map(turn).collect(), cells).unwrap();
    for (name, facets) in square.boundaries() {
        mesh.set_boundary(name.clone(), facets.clone());
    }
    let along = V::new(c30, s30);
    let conditions: Conditions<2> = vec![
        ("left".into(), given(move |_| along)),
        ("right".into(), Condition::Open),
        ("bottom".into(), Condition::Slip),
        ("top".into(), Condition::Slip),
    ];
    let mut s = setup(mesh, conditions, 1.0, 1.0);
    let mut state = s.solver.at_rest();
    s.solver.step(&stokes(), &mut state).unwrap();
    let u = vector_errors(&s.velocity, &state.u, |_| (along, SMatrix::zeros()));
    assert!(u.l2 < 1e-10, "{u:?}");
}

#[test]
fn a_net_inflow_into_a_closed_box_is_an_error() {
    let mut s = setup(
        unit_square(3),
        vec![("walls".into(), Condition::NoSlip), ("left".into(), given(|_| V::new(1.0, 0.0)))],
        1.0,
        1.0,
    );
    let mut state = s.solver.at_rest();
    let e = s.solver.step(&stokes(), &mut state).unwrap_err();
    assert!(e.cause() == Some(Cause::Inflow), "{e}");
}

#[test]
fn an_uncovered_boundary_is_named() {
    let mesh = Arc::new(unit_square(2));
    let velocity = Space::new(&mesh, Element::P2);
    let pressure = Space::new(&mesh, Element::P1);
    let conditions = vec![("left".to_string(), Condition::NoSlip)];
    let e = immersa::fem::Numbering::new(&velocity, &pressure, &conditions).err().unwrap();
    assert!(e.to_string().contains("no condition") && e.to_string().contains("bottom"), "{e}");
}
