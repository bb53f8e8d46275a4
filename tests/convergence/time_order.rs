//! Orders in time, convection on: a Taylor-Green vortex carried along, and the relaxing membrane.

use crate::exact::{TaylorGreen, V};
use crate::membrane::{Case, half_chords};
use crate::space_order::taylor_green_run;
use crate::tools::Study;
use immersa::fem::vector_errors;
use immersa::sim::Coupling;

/// Errors of a travelling vortex at t = 0.8 against the exact solution.
fn vortex(order: usize, dt: &[f64]) -> Vec<f64> {
    let exact = TaylorGreen { viscosity: 0.1, stream: V::new(1.0, 0.5) };
    let end = 0.8;
    let error = |&dt: &f64| {
        let sim = taylor_green_run(exact, 48, dt, (end / dt).round() as usize, order);
        vector_errors(sim.space(), &sim.state().flow.u, |x| {
            (exact.velocity(x, end), exact.gradient(x, end))
        })
        .l2
    };
    dt.iter().map(error).collect()
}

#[test]
fn a_travelling_vortex_by_backward_euler() {
    let sizes = [0.2, 0.1, 0.05, 0.025];
    Study { what: "Vortex in a stream, BDF1, u in L2", sizes: &sizes, errors: vortex(1, &sizes) }
        .assert(1.0, 2.8e-2);
}

#[test]
fn a_travelling_vortex_by_bdf2() {
    let sizes = [0.2, 0.1, 0.05, 0.025];
    Study { what: "Vortex in a stream, BDF2, u in L2", sizes: &sizes, errors: vortex(2, &sizes) }
        .assert(2.0, 1.5e-3);
}

/// Largest difference of the half-chords from those of a fine step, at t = 0.8.
fn membrane(case: Case, dt: &[f64], finest: f64) -> Vec<f64> {
    let chords = |dt: f64| half_chords(&Case { dt, ..case }.run(0.8));
    let exact = chords(finest);
    dt.iter()
        .map(|&dt| chords(dt))
        .map(|c| (c[0] - exact[0]).abs().max((c[1] - exact[1]).abs()))
        .collect()
}

const MEMBRANE: Case = Case { n: 24, thickness: 0.15, viscosity: 0.05, ..Case::LISTING };

#[test]
fn the_membrane_implicit_of_order_two() {
    let case = Case { order: 2, coupling: Coupling::Implicit, ..MEMBRANE };
    let sizes = [0.04, 0.02, 0.01];
    Study {
        what: "Membrane, implicit, order 2",
        sizes: &sizes,
        errors: membrane(case, &sizes, 0.00125),
    }
    .assert(2.0, 5.8e-6);
}

#[test]
fn the_membrane_implicit_of_order_one() {
    let case = Case { order: 1, coupling: Coupling::Implicit, ..MEMBRANE };
    let sizes = [0.08, 0.04, 0.02, 0.01];
    Study {
        what: "Membrane, implicit, order 1",
        sizes: &sizes,
        errors: membrane(case, &sizes, 0.00125),
    }
    .assert(1.0, 1.5e-4);
}

#[test]
fn the_membrane_explicit_of_order_two() {
    let case = Case { order: 2, coupling: Coupling::Explicit, ..MEMBRANE };
    let sizes = [0.04, 0.02, 0.01, 0.005];
    Study {
        what: "Membrane, explicit, order 2",
        sizes: &sizes,
        errors: membrane(case, &sizes, 0.00125),
    }
    .assert(2.0, 8.1e-7);
}
