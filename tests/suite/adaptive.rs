//! Steps that follow the error.

use crate::case::{Case, V};
use immersa::scene::Problem;
use immersa::sim::State;

/// A channel flow `u = (g(t) y (1 - y), 0)` that a force drives: exact in space, `g` is 1 and a
/// pulse about t = 0.5, narrow beside the run.
const PULSE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [1, 1], cells = [3, 3] }
[fluid]
density = 1.0
viscosity = 0.1
initial_velocity = ["y*(1 - y)", "0"]
force = ["0.2 + exp(-((t - 0.5)/0.1)^2)*(-200*(t - 0.5)*y*(1 - y) + 0.2)", "0"]
[boundary]
left.periodic = "right"
top.no_slip = true
bottom.no_slip = true
[time]
end = 1.0
step = 0.01
tolerance = 1e-2
[numerics]
convection = false
[output]
every = 0.25
fields = false
pictures = false
"#;

fn pulse(t: f64) -> f64 {
    1.0 + (-((t - 0.5) / 0.1).powi(2)).exp()
}

/// Runs to the end; the times, and the largest error of the velocity over the largest speed.
fn course(changes: &[&str]) -> (Vec<f64>, f64, Case) {
    let mut case = Case::with(PULSE, changes);
    let (mut times, mut worst) = (vec![0.0], 0.0_f64);
    while !case.model.simulation.is_done() {
        case.model.simulation.step().unwrap();
        times.push(case.time());
        let error = case.largest_error(|x, t| V::new(pulse(t) * x[1] * (1.0 - x[1]), 0.0));
        worst = worst.max(error / 0.5);
    }
    (times, worst, case)
}

#[test]
fn the_error_of_a_run_is_proportional_to_the_tolerance_and_below_it() {
    let errors = [2.5e-3, 6.25e-4, 1.5625e-4].map(|tolerance| {
        let (times, error, _) = course(&[&format!("time.tolerance={tolerance}")]);
        assert!(error < tolerance, "tolerance {tolerance}: error {error:e}");
        (error, times.len())
    });
    for [coarse, fine] in [[errors[0], errors[1]], [errors[1], errors[2]]] {
        let [gain, cost] = [coarse.0 / fine.0, fine.1 as f64 / coarse.1 as f64];
        assert!(
            (2.5..6.5).contains(&gain),
            "a quarter of the tolerance: error over {gain}; {errors:?}"
        );
        // Second order: a quarter of the error takes twice the steps.
        assert!(
            (1.4..3.0).contains(&cost),
            "a quarter of the tolerance: {cost} times the steps; {errors:?}"
        );
    }
}

#[test]
fn steps_are_short_where_the_flow_changes_and_end_at_the_instants_of_output() {
    let (times, _, _) = course(&["time.tolerance=2.5e-3"]);
    let longest = |from: f64, to: f64| {
        let steps = times.windows(2).filter(|w| from <= w[0] && w[1] <= to);
        steps.map(|w| w[1] - w[0]).fold(0.0, f64::max)
    };
    assert!(longest(0.8, 1.0) > 4.0 * longest(0.4, 0.6), "{times:?}");
    for instant in [0.25, 0.5, 0.75, 1.0] {
        assert!(times.contains(&instant), "{times:?}");
    }
    for w in times.windows(3) {
        assert!(w[2] - w[1] < 2.0001 * (w[1] - w[0]), "{w:?}");
    }
}

#[test]
fn a_first_step_that_is_too_long_is_rejected_without_a_trace() {
    // The force begins at once.
    let force = r#"fluid.force=["10*y*(1 - y)*cos(30*t)", "0"]"#;
    let run = |step: &str| {
        let mut case =
            Case::with(PULSE, &[force, step, "time.tolerance=1e-3", "output.every=0.25"]);
        while !case.model.simulation.is_done() {
            case.model.simulation.step().unwrap();
        }
        case
    };
    let (short, long) = (run("time.step=1e-4"), run("time.step=0.125"));
    let rejected = |case: &Case| case.model.simulation.state().pace.as_ref().unwrap().rejected;
    assert!(rejected(&long) > 0);
    let (a, b) = (short.velocity(), long.velocity());
    let difference = a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let size = a.iter().map(|a| a.norm()).fold(0.0, f64::max);
    assert!(difference < 2e-2 * size && size > 1e-3, "{difference:e} of {size:e}");
}

#[test]
fn an_error_that_no_step_above_the_shortest_allows_ends_the_run_with_a_reason() {
    let mut case = Case::with(PULSE, &["time.tolerance=1e-5", "time.step_min=5e-3"]);
    let e = loop {
        match case.model.step() {
            Ok(_) => assert!(!case.model.simulation.is_done()),
            Err(e) => break e.to_string(),
        }
    };
    for part in ["shorter than the shortest", "time.step_min", "time.tolerance", "at: time"] {
        assert!(e.contains(part), "{e}");
    }
}

/// A stretched membrane, stiff: every part of the step is at work.
const MEMBRANE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16], diagonals = "union-jack" }
[fluid]
density = 1.0
viscosity = { inside = 0.02, outside = 0.01 }
[boundary.walls]
no_slip = true
[[membrane]]
name = "membrane"
shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }
stretch = 1.2625316
area.linear = { modulus = 10.0 }
[time]
end = 0.5
step = 0.02
tolerance = 2e-2
[numerics]
thickness = 0.2
[output]
every = 0.125
fields = false
pictures = false
"#;

fn bits(case: &mut Case, until: f64) -> Vec<u8> {
    while case.time() < until {
        case.model.simulation.step().unwrap();
    }
    case.model.simulation.state().to_bytes(0)
}

#[test]
fn threads_and_interruptions_change_no_bit() {
    for changes in [
        &["numerics.coupling=implicit"][..],
        &["numerics.coupling=explicit", "fluid.viscosity=0.01"][..],
    ] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bits(&mut Case::with(MEMBRANE, changes), 0.5))
        };
        let straight = run(1);
        assert!(run(2) == straight, "{changes:?}");
        let state = State::<2>::from_bytes(&straight, 0).unwrap();
        assert!(state.pace.unwrap().rejected > 0, "{changes:?}: no step was rejected");
        for part in [0.02, 0.1, 0.3] {
            let half = bits(&mut Case::with(MEMBRANE, changes), part);
            let mut resumed = Case::with(MEMBRANE, changes);
            resumed.model.simulation.restore(State::from_bytes(&half, 0).unwrap()).unwrap();
            assert!(bits(&mut resumed, 0.5) == straight, "{changes:?}, interrupted at {part}");
        }
    }
}

#[test]
fn the_explicit_coupling_never_exceeds_its_limit() {
    for cells in ["[16, 16]", "[32, 32]"] {
        let mesh = format!("mesh.rectangle.cells={cells}");
        let changes = [
            "numerics.coupling=explicit",
            "fluid.viscosity=0.01",
            "time.tolerance=0.1",
            "time.end=0.25",
            &mesh,
        ];
        let mut case = Case::with(MEMBRANE, &changes);
        let (mut longest, mut over) = (0.0_f64, 0.0_f64);
        while !case.model.simulation.is_done() {
            // The limit at the state that the step starts from, with the edges of this mesh.
            let limit = case.model.step_limit().unwrap();
            case.model.simulation.step().unwrap();
            let dt = case.model.simulation.settings().dt;
            longest = longest.max(dt / limit);
            over = over.max(dt / case.model.step_limit().unwrap());
        }
        assert!(over < 1.0 && longest > 0.3, "{cells}: {over} of the limit, {longest}");
        assert!(case.get("energy_balance") < 0.02, "{}", case.get("energy_balance"));
    }
}

#[test]
fn order_one_and_prescribed_velocities_are_refused() {
    let text = PULSE.replace("step = 0.01", "step = 0.01\norder = 1");
    let scene =
        immersa::scene::Scene::parse_with(&text, std::path::Path::new("scene.toml"), &[]).unwrap();
    let e = immersa::scene::ImmersedFlow::<2>::new(&scene).err().unwrap().to_string();
    assert!(e.contains("order 1") && e.contains("time.tolerance"), "{e}");
}
