//! The ways of solving for the flow in space: each comes to the solution of the direct one, by what
//! fits into the memory.

use immersa::base::Cause;
use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{Condition, Conditions, Element, Rule, Space};
use immersa::flow::term::MomentumTerm;
use immersa::flow::{Coefficient, FlowSolver, FlowState, History, Step};
use immersa::linalg::{SolverKind, SolverOptions};
use immersa::mesh::{Point, box_mesh};
use nalgebra::SVector;
use std::sync::Arc;

type V = SVector<f64, 3>;

/// What differs from case to case.
#[derive(Clone)]
struct Case {
    cells: usize,
    conditions: Conditions<3>,
    /// `weight/dt`; 0 without inertia.
    inertia: f64,
    grad_div: f64,
    density: Coefficient,
    viscosity: Coefficient,
}

fn closed(cells: usize) -> Case {
    Case {
        cells,
        conditions: vec![("walls".into(), Condition::NoSlip)],
        inertia: 200.0,
        grad_div: 1.0,
        density: Coefficient::Constant(1.0),
        viscosity: Coefficient::Constant(0.01),
    }
}

fn solver(case: &Case, solving: SolverOptions) -> FlowSolver<3> {
    let mesh = Arc::new(box_mesh([0.0; 3], [1.0; 3], [case.cells; 3]).unwrap());
    let [velocity, pressure] = [Element::P2, Element::P1].map(|e| Arc::new(Space::new(&mesh, e)));
    let rule = Arc::new(Rule::simplex(3, 4));
    let mut solver =
        FlowSolver::new(&velocity, &pressure, &rule, &case.conditions, case.grad_div).unwrap();
    solver.set_materials(case.density.clone(), case.viscosity.clone());
    solver.solve_by(solving);
    solver
}

fn by(kind: SolverKind) -> SolverOptions {
    SolverOptions { kind: Some(kind), memory: None, ..SolverOptions::default() }
}

fn swirl(x: &Point<3>) -> V {
    let bump: f64 = x.iter().map(|x| x * (1.0 - x)).product();
    V::new(x[1] - 0.5, 0.5 - x[0], 0.3 * (x[0] - x[1])) * (16.0 * bump)
}

/// One step from a swirl, with a force that no potential has. Returns the flow, the iterations and
/// the residual.
fn step(
    solver: &mut FlowSolver<3>,
    case: &Case,
    terms: &[&dyn MomentumTerm<3>],
) -> (FlowState<3>, usize, f64) {
    let u = solver.velocity().space().interpolate(swirl);
    let history = [History { weight: 1.0, u: &u, feet: None }];
    let force = |x: &Point<3>, _: f64| V::new(x[2] * x[2], (3.0 * x[0]).sin(), x[0] * x[1]);
    let dt = if case.inertia > 0.0 { 1.0 / case.inertia } else { 1.0 };
    let inert = case.inertia > 0.0;
    let step = Step {
        weight: if inert { 1.0 } else { 0.0 },
        history: if inert { &history } else { &[] },
        terms,
        body_force: Some(&force),
        ..Step::backward_euler(dt, dt, &history)
    };
    let mut state = solver.at_rest();
    let report = solver.step(&step, &mut state).unwrap();
    (state, report.solve.iterations, report.solve.residual)
}

/// Velocity and pressure relative to the direct solution.
fn errors(direct: &FlowState<3>, other: &FlowState<3>) -> [f64; 2] {
    let norm = |v: &[V]| v.iter().map(|v| v.norm_squared()).sum::<f64>().sqrt();
    let differences: Vec<V> = direct.u.iter().zip(&other.u).map(|(a, b)| a - b).collect();
    let scale = direct.p.iter().map(|p| p.abs()).fold(0.0, f64::max);
    let p = direct.p.iter().zip(&other.p).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    [norm(&differences) / norm(&direct.u), p / scale]
}

fn all_ways_agree(name: &str, case: &Case) {
    let direct = step(&mut solver(case, by(SolverKind::Direct)), case, &[]);
    assert_eq!(direct.1, 0);
    for (kind, most) in [(SolverKind::Single, 4), (SolverKind::Schur, 120)] {
        let (state, iterations, residual) = step(&mut solver(case, by(kind)), case, &[]);
        let [u, p] = errors(&direct.0, &state);
        assert!(
            iterations > 0 && iterations <= most && residual <= 1e-10,
            "{name}, {kind}: {iterations}, {residual:e}"
        );
        assert!(
            u < 1e-7 && p < 1e-5,
            "{name}, {kind}: velocity {u:e}, pressure {p:e}, {iterations} iterations"
        );
    }
}

#[test]
fn every_way_of_solving_gives_the_direct_solution() {
    all_ways_agree("closed box", &closed(4));
    all_ways_agree("much grad-div", &Case { grad_div: 5.0, ..closed(6) });
    all_ways_agree("without inertia", &Case { inertia: 0.0, grad_div: 0.1, ..closed(4) });
}

#[test]
fn every_way_of_solving_takes_every_boundary_condition() {
    let given = |f: fn(&Point<3>) -> V| Condition::Velocity(Arc::new(move |x, _| f(x)));
    let lid = vec![
        ("walls".into(), Condition::NoSlip),
        ("top".into(), given(|x| V::new(x[0] * (1.0 - x[0]), 0.0, 0.0))),
    ];
    all_ways_agree("moving lid", &Case { conditions: lid, ..closed(4) });
    let slip = vec![
        ("walls".into(), Condition::NoSlip),
        ("top".into(), Condition::Slip),
        ("left".into(), Condition::Slip),
    ];
    all_ways_agree("slip", &Case { conditions: slip, ..closed(4) });
    let periodic = vec![
        ("walls".into(), Condition::NoSlip),
        ("left".into(), Condition::Periodic("right".into())),
    ];
    all_ways_agree("periodic", &Case { conditions: periodic, ..closed(4) });
    let open = vec![
        ("walls".into(), Condition::NoSlip),
        ("right".into(), Condition::Open),
        ("left".into(), given(|x| V::new(x[1] * (1.0 - x[1]) * x[2] * (1.0 - x[2]), 0.0, 0.0))),
    ];
    all_ways_agree("channel", &Case { conditions: open.clone(), ..closed(4) });
    all_ways_agree(
        "channel without inertia",
        &Case { conditions: open, inertia: 0.0, grad_div: 0.01, ..closed(4) },
    );
}

#[test]
fn every_way_of_solving_takes_fluids_that_differ() {
    let case = closed(4);
    let blank = solver(&case, SolverOptions::default());
    let (points, cells) =
        (blank.velocity().rule().len(), blank.velocity().space().mesh().cell_count());
    let ball = |inside: f64, outside: f64| {
        let value = |k: usize| {
            let x = blank.velocity().at(k / points, k % points).x;
            if (x - Point::<3>::repeat(0.5)).norm() < 0.3 { inside } else { outside }
        };
        Coefficient::Pointwise { points, values: (0..cells * points).map(value).collect() }
    };
    all_ways_agree("a viscous ball", &Case { viscosity: ball(0.5, 0.01), ..case.clone() });
    all_ways_agree("a heavy ball", &Case { density: ball(10.0, 1.0), ..case.clone() });
}

/// An elastic ball that moves from step to step: old factors precondition, of every kind.
#[test]
fn old_factors_of_every_kind_serve_a_matrix_that_changes() {
    let case = closed(5);
    let run = |kind: SolverKind, tolerance: f64| {
        let mut solver = solver(&case, by(kind));
        solver.iterate(tolerance);
        let space = Arc::clone(solver.velocity().space());
        let mut membrane = Membrane::new(AreaLaw::Linear { modulus: 2.0 }, 0.25);
        let (mut last, mut factored, mut iterations) = (None, 0, 0);
        for k in 0..6 {
            let radius = 0.3 + 0.004 * k as f64;
            let phi = space.interpolate(|x| 1.3 * ((x - Point::<3>::repeat(0.5)).norm() - radius));
            membrane.prepare(solver.velocity(), &phi, Some(5e-3));
            let u = space.interpolate(swirl);
            let history = [History { weight: 1.0, u: &u, feet: None }];
            let step = Step { terms: &[&membrane], ..Step::backward_euler(5e-3, 5e-3, &history) };
            let mut state =
                FlowState { u: u.clone(), p: vec![0.0; solver.pressure().space().len()] };
            let report = solver.step(&step, &mut state).unwrap();
            (factored, iterations) =
                (factored + usize::from(report.refactored), iterations + report.solve.iterations);
            assert!(report.solve.residual <= 1e-10, "{kind}: {report:?}");
            last = Some(state);
        }
        (last.unwrap(), factored, iterations)
    };
    let (direct, ..) = run(SolverKind::Direct, 0.0);
    for kind in [SolverKind::Direct, SolverKind::Single, SolverKind::Schur] {
        let (state, factored, iterations) = run(kind, 1e-10);
        let [u, _] = errors(&direct, &state);
        assert!(u < 1e-7 && iterations > 0, "{kind}: {u:e}");
        // Scalar factors of so small a mesh cost less than the iterations that they save.
        assert!(
            factored < 6 || kind == SolverKind::Schur,
            "{kind}: factored {factored} times, {iterations} iterations"
        );
    }
}

#[test]
fn the_way_of_solving_is_the_first_that_fits() {
    let case = closed(6);
    let size = |solving: SolverOptions| {
        let mut solver = solver(&case, solving);
        solver.analyse(case.inertia).map(|()| solver.solver_size().unwrap())
    };
    let bytes = [SolverKind::Direct, SolverKind::Single, SolverKind::Schur]
        .map(|kind| size(by(kind)).unwrap().1.bytes);
    assert!(bytes[0] > bytes[1] && bytes[1] > bytes[2], "{bytes:?}");
    for (limit, kind) in [
        (bytes[0], SolverKind::Direct),
        (bytes[0] - 1, SolverKind::Single),
        (bytes[1] - 1, SolverKind::Schur),
    ] {
        assert_eq!(
            size(SolverOptions { kind: None, memory: Some(limit), ..SolverOptions::default() })
                .unwrap()
                .0,
            kind
        );
    }
    let refused =
        size(SolverOptions { kind: None, memory: Some(bytes[2] - 1), ..SolverOptions::default() })
            .unwrap_err()
            .to_string();
    for part in ["by direct", "by single", "by schur", "may be taken", "unknowns by schur"] {
        assert!(refused.contains(part), "{part}: {refused}");
    }
    let refused = size(SolverOptions {
        kind: Some(SolverKind::Direct),
        memory: Some(bytes[2]),
        ..SolverOptions::default()
    })
    .unwrap_err();
    assert_eq!(refused.cause(), Some(Cause::SolverMemory), "{refused}");
}

#[test]
fn every_way_of_solving_gives_the_same_bits_with_one_thread_and_with_two() {
    let case = closed(4);
    for kind in [SolverKind::Direct, SolverKind::Single, SolverKind::Schur] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| step(&mut solver(&case, by(kind)), &case, &[]).0)
        };
        assert!(run(1) == run(2), "{kind}");
    }
}
