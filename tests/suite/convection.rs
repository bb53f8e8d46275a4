//! Convection by each scheme, against exact solutions of the Navier-Stokes equations.

use crate::case::{Case, V, refused};
use immersa::scene::Problem;
use immersa::sim::State;
use std::f64::consts::PI;

/// Kovasznay's steady flow at Reynolds number 40, prescribed all round; it starts from itself.
const KOVASZNAY: &str = r#"
[mesh]
rectangle = { min = [-0.5, -0.5], max = [1, 0.5], cells = [12, 8] }
[constants]
k = "20 - sqrt(400 + 4*pi^2)"
[fluid]
density = 1.0
viscosity = 0.025
initial_velocity = ["1 - exp(k*x)*cos(2*pi*y)", "k/(2*pi)*exp(k*x)*sin(2*pi*y)"]
[boundary]
walls.velocity = ["1 - exp(k*x)*cos(2*pi*y)", "k/(2*pi)*exp(k*x)*sin(2*pi*y)"]
[time]
end = 8.0
step = 0.1
[output]
every = 1.0
fields = false
pictures = false
"#;

fn kovasznay(x: &V, _: f64) -> V {
    let k = 20.0 - (400.0 + 4.0 * PI * PI).sqrt();
    let e = (k * x[0]).exp();
    V::new(1.0 - e * (2.0 * PI * x[1]).cos(), k / (2.0 * PI) * e * (2.0 * PI * x[1]).sin())
}

/// Vortices that decay while a uniform stream carries them: an exact solution of the Navier-Stokes
/// equations, u = U + (-cos a sin b, sin a cos b) exp(-2 nu t), a = x - U t, b = y - V t.
const CARRIED: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [3, 3], cells = [10, 10] }
[constants]
nu = 0.02
[fluid]
density = 1.0
viscosity = 0.02
initial_velocity = ["1 - cos(x)*sin(y)", "0.5 + sin(x)*cos(y)"]
[boundary]
walls.velocity = ["1 - cos(x - t)*sin(y - 0.5*t)*exp(-2*nu*t)",
                  "0.5 + sin(x - t)*cos(y - 0.5*t)*exp(-2*nu*t)"]
[time]
end = 4.0
step = 0.1
[numerics]
solve_tolerance = 1e-10
[output]
every = 1.0
fields = false
pictures = false
"#;

fn run(text: &str, changes: &[&str], steps: usize) -> Case {
    let mut case = Case::with(text, changes);
    for _ in 0..steps {
        case.model.simulation.step().unwrap();
    }
    case
}

/// The largest difference of two velocities at a node.
fn apart(a: &Case, b: &Case) -> f64 {
    a.velocity().iter().zip(b.velocity()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// The steady state of implicit convection does not depend on the step, and is as near to the exact
/// one as the mesh allows; that of characteristics is the step's.
#[test]
fn a_steady_state_of_implicit_convection_knows_no_step() {
    let tight = "numerics.solve_tolerance=1e-9";
    let by = |scheme: &str, step: f64, order: usize| {
        let scheme = format!("numerics.convection={scheme:?}");
        let changes =
            [scheme, format!("time.step={step}"), format!("time.order={order}"), tight.into()];
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        run(KOVASZNAY, &changes, (8.0 / step).round() as usize)
    };
    let [long, short, third] =
        [("baker1982", 0.2, 2), ("baker1982", 0.05, 2), ("baker1982", 0.1, 3)]
            .map(|(s, dt, order)| by(s, dt, order));
    assert!(apart(&long, &short) < 1e-6, "{:e}", apart(&long, &short));
    assert!(apart(&long, &third) < 1e-6, "{:e}", apart(&long, &third));
    let errors = [&long, &by("pironneau1982", 0.2, 2)].map(|c| c.error(kovasznay));
    assert!(errors[0] < 3e-3 && errors[1] > 10.0 * errors[0], "{errors:?}");
    // The work of the walls is what is dissipated and flows out: the reactions hold the convection.
    let e = long.model.simulation.state().energies;
    let balance = (e.power - e.dissipation - e.grad_div) / e.dissipation;
    assert!(balance.abs() < 1e-4, "{balance:e}");
}

/// Orders in time of each scheme, beside the error of the mesh: the difference from a solution with
/// a much shorter step. The first steps of order 3 are of order 1 and 2: what they leave keeps the
/// order below 3 until it has flowed out.
#[test]
fn each_scheme_has_its_order_in_time() {
    let by = |scheme: &str, order: usize, step: f64, more: &[&str]| {
        let scheme = format!("numerics.convection={scheme:?}");
        let changes = [scheme, format!("time.step={step}"), format!("time.order={order}")];
        let mut changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        changes.extend(more);
        run(CARRIED, &changes, (4.0 / step).round() as usize)
    };
    let exact = by("baker1982", 3, 0.0125, &[]);
    for (order, least, most) in [(1, 0.8, 1.3), (2, 1.7, 2.4), (3, 2.3, 3.6)] {
        let [coarse, fine] =
            [0.1, 0.05].map(|step| apart(&by("baker1982", order, step, &[]), &exact));
        let found = (coarse / fine).log2();
        assert!((least..=most).contains(&found), "order {order}: {found} ({coarse:e}, {fine:e})");
    }
}

/// Explicit convection holds its step below the limit by itself and agrees with the implicit one.
#[test]
fn explicit_convection_keeps_below_its_limit() {
    let changes = ["numerics.convection=\"karniadakis1991\"", "time.tolerance=0.1"];
    let mut case = Case::with(CARRIED, &changes);
    let mut fastest = 0.0_f64;
    while !case.model.simulation.is_done() {
        case.model.simulation.step().unwrap();
        fastest = fastest.max(case.model.simulation.courant());
    }
    assert!(fastest > 0.1 && fastest < 0.27, "{fastest}");
    let implicit = run(CARRIED, &["numerics.convection=\"baker1982\"", "time.step=0.02"], 200);
    assert!(apart(&case, &implicit) < 5e-3, "{:e}", apart(&case, &implicit));
    let message = refused(CARRIED, &["numerics.convection=\"karniadakis1991\""]);
    assert!(message.contains("time.tolerance") && message.contains("baker1982"), "{message}");
}

/// Without driving, implicit convection makes no energy at a Courant number of 9 and a Reynolds
/// number of a cell of 900.
#[test]
fn implicit_convection_makes_no_energy() {
    let closed = r#"
[mesh]
rectangle = { min = [0, 0], max = [1, 1], cells = [16, 16] }
[fluid]
density = 1.0
viscosity = 1e-4
initial_velocity = ["sin(pi*x)^2*sin(2*pi*y)", "-sin(2*pi*x)*sin(pi*y)^2"]
[boundary]
walls.no_slip = true
[time]
end = 27.0
step = 0.9
[numerics]
convection = "baker1982"
[output]
every = 27.0
fields = false
pictures = false
"#;
    let mut case = Case::with(closed, &[]);
    let mut energy = case.model.simulation.state().energies.kinetic;
    let first = energy;
    for step in 0..30 {
        case.model.simulation.step().unwrap();
        if step == 0 {
            assert!(case.model.simulation.courant() > 8.0);
        }
        let now = case.model.simulation.state().energies.kinetic;
        assert!(now <= energy * (1.0 + 1e-3), "step {step}: {energy} to {now}");
        energy = now;
    }
    assert!(energy < first);
}

/// A state that is written and read goes on with the same bits: the old factor is made again, in
/// order 3 the velocity two steps earlier is known.
#[test]
fn a_resumed_flow_has_the_same_bits() {
    for change in ["time.order=2", "time.order=3"] {
        let changes =
            ["numerics.convection=\"baker1982\"", "numerics.solve_tolerance=1e-6", change];
        let mut whole = run(CARRIED, &changes, 7);
        let bytes = whole.model.simulation.state().to_bytes(1);
        let mut resumed = Case::with(CARRIED, &changes);
        resumed.model.simulation.restore(State::from_bytes(&bytes, 1).unwrap()).unwrap();
        for case in [&mut whole, &mut resumed] {
            (0..5).for_each(|_| {
                case.model.simulation.step().unwrap();
            });
        }
        assert_eq!(whole.velocity(), resumed.velocity(), "{change}");
    }
}

/// The estimated error in time is near the true one, of the order of the scheme, and long steps are
/// told.
#[test]
fn the_error_in_time_is_estimated() {
    let exact = run(CARRIED, &["time.order=3", "time.step=0.0125"], 160);
    let size = exact.error(|_, _| V::zeros());
    for scheme in ["baker1982", "pironneau1982"] {
        let scheme = format!("numerics.convection={scheme:?}");
        let found = [0.1, 0.05f64].map(|step| {
            let case = run(
                CARRIED,
                &[&scheme, &format!("time.step={step}")],
                (2.0 / step).round() as usize,
            );
            let row = case.model.row().unwrap();
            let estimate = row.get("time_error").unwrap();
            let difference = case.velocity().iter().zip(exact.velocity());
            let square: f64 = difference.map(|(a, b)| (a - b).norm_squared()).sum();
            let scale: f64 = exact.velocity().iter().map(|u| u.norm_squared()).sum();
            (estimate, (square / scale).sqrt())
        });
        // Along paths, errors of interpolation are in the estimate too.
        let falls = if scheme.contains("baker") { 2.5 } else { 1.5 };
        assert!(size > 0.0 && found[0].0 > falls * found[1].0, "{scheme}: {found:?}");
        for (estimate, error) in found {
            let ratio = estimate / error;
            assert!((0.7..30.0).contains(&ratio), "{scheme}: {estimate:e}, {error:e}");
        }
    }
}

/// Steps of order 1 along characteristics know one foot: there is no estimate, and no failure.
#[test]
fn steps_of_order_one_along_characteristics_have_no_estimate() {
    let traced = "numerics.convection=\"pironneau1982\"";
    let case = run(CARRIED, &[traced, "time.order=1"], 4);
    assert!(case.model.row().unwrap().get("time_error").unwrap().is_nan());
}

/// Order 3 is refused where it does not hold.
#[test]
fn order_three_is_for_a_flow_alone_in_steps_of_one_length() {
    for (changes, words) in [
        (&["time.order=3", "numerics.convection=\"pironneau1982\""][..], "baker1982"),
        (&["time.order=3", "time.tolerance=1e-2"], "time.tolerance"),
    ] {
        let message = refused(CARRIED, changes);
        assert!(message.contains(words), "{message}");
    }
}

/// Layers of transverse velocity, thinner than a cell, that a stream carries once round a periodic
/// box with hardly any viscosity.
const LAYERS: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [4, 1], cells = [24, 6] }
[constants]
width = 0.02
[fluid]
density = 1.0
viscosity = 1e-5
initial_velocity = ["1", "0.1*(tanh((x-1)/width) - tanh((x-3)/width))"]
[boundary]
left.periodic = "right"
bottom.periodic = "top"
[numerics]
convection = "baker1982"
[time]
end = 4.0
step = 0.01
[output]
fields = false
pictures = false
"#;

/// The stabilisation along streamlines takes the ripples behind a thin layer (without it their
/// total variation is .44 beyond the exact .4) and leaves a smooth layer alone.
#[test]
fn coarse_cells_are_stabilised() {
    let along = |case: &Case| {
        let flow = case.model.simulation.flow();
        let mut line: Vec<(f64, f64)> =
            std::iter::zip(flow.velocity().space().nodes(), case.velocity())
                .filter(|(x, _)| (x[1] - 0.5).abs() < 1e-9)
                .map(|(x, u)| (x[0], u[1]))
                .collect();
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        line
    };
    let thin = along(&run(LAYERS, &[], 400));
    let variation: f64 = thin.windows(2).map(|w| (w[1].1 - w[0].1).abs()).sum();
    assert!((0.4..0.54).contains(&variation), "{variation}");
    let smooth = along(&run(LAYERS, &["constants.width=0.4"], 400));
    for (x, v) in smooth {
        let exact = 0.1 * (((x - 1.0) / 0.4).tanh() - ((x - 3.0) / 0.4).tanh());
        assert!((v - exact).abs() < 2e-3, "at {x}: {v} is not {exact}");
    }
}
