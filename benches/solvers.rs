//! The ways of solving for the flow in space, side by side: what they take, how many iterations,
//! how many seconds of the processor.
//!
//! `cargo bench --bench solvers -- N [N ...] [WAY ...]`: cubes along a side, `direct`, `single` or
//! `schur`; 4, 8 and 12 by all ways if none is given. With `sizes` the factors are planned and not
//! computed.

#![allow(clippy::print_stdout, reason = "the figures are the point of a bench")]
#[allow(dead_code, reason = "some of it is for the other benches alone")]
mod case;

use case::Case;
use immersa::flow::{Coefficient, FlowSolver, FlowState, History, Step};
use immersa::linalg::{SolverKind, SolverOptions};
use nalgebra::SVector;

const WAYS: [(&str, SolverKind); 3] =
    [("direct", SolverKind::Direct), ("single", SolverKind::Single), ("schur", SolverKind::Schur)];
/// `rho/dt` and grad-div weight for `rho U L = 1`, viscosity .01.
const STEPS: [[f64; 2]; 4] = [[200.0, 0.5], [200.0, 5.0], [1000.0, 0.5], [1000.0, 5.0]];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let given: Vec<usize> = words.iter().filter_map(|w| w.parse().ok()).collect();
    let sizes = if given.is_empty() { vec![4, 8, 12] } else { given };
    let named = |word: &str| words.iter().any(|w| w == word);
    let all = WAYS.iter().all(|(word, _)| !named(word));
    for n in sizes {
        let case = Case::space(n);
        for (_, kind) in WAYS.iter().filter(|(word, _)| all || named(word)) {
            if named("sizes") {
                plan(n, &case, *kind);
            } else {
                STEPS.iter().for_each(|step| time(n, &case, *kind, *step));
            }
        }
    }
}

fn solver(case: &Case<3>, kind: SolverKind, grad_div: f64) -> FlowSolver<3> {
    let (velocity, pressure) = (case.velocity.space(), case.pressure.space());
    let mut solver =
        FlowSolver::new(velocity, pressure, case.velocity.rule(), &case.conditions, grad_div)
            .unwrap();
    solver.set_materials(Coefficient::Constant(1.0), Coefficient::Constant(0.01));
    solver.solve_by(SolverOptions {
        kind: Some(kind),
        memory: Some(usize::MAX),
        unsymmetric: false,
    });
    solver
}

fn plan(n: usize, case: &Case<3>, kind: SolverKind) {
    let mut solver = solver(case, kind, 1.0);
    solver.analyse(200.0).unwrap();
    println!(
        "n = {n}, {} unknowns: {}",
        solver.numbering().order(),
        solver.solver_summary().unwrap()
    );
}

/// The first step factors; the second one, of the same matrix, does not.
fn time(n: usize, case: &Case<3>, kind: SolverKind, [inertia, grad_div]: [f64; 2]) {
    let mut solver = solver(case, kind, grad_div);
    let dt = 1.0 / inertia;
    let force = |x: &immersa::mesh::Point<3>, t: f64| {
        SVector::<f64, 3>::new(x[2] * x[2], (3.0 * x[0] + t).sin(), x[0] * x[1])
    };
    let mut state = FlowState { u: case.u.clone(), p: vec![0.0; case.pressure.space().len()] };
    let mut line = String::new();
    for k in 0..2 {
        let u = state.u.clone();
        let history = [History { weight: 1.0, u: &u, feet: None }];
        let step = Step {
            body_force: Some(&force),
            ..Step::backward_euler((k + 1) as f64 * dt, dt, &history)
        };
        let report = solver.step(&step, &mut state).unwrap();
        let ([_, factor, solve, ..], _) = solver.take_costs();
        line = match k {
            0 => format!("ordering and factor {factor:.3} s, "),
            _ => format!(
                "{line}solve {solve:.3} s, {} iterations, residual {:.1e}",
                report.solve.iterations, report.solve.residual
            ),
        };
    }
    let (_, size) = solver.solver_size().unwrap();
    println!(
        "n = {n}, rho/dt = {inertia}, grad-div {grad_div}, {kind}: {:.2e} entries, {:.0} MB, \
         {line}",
        size.entries as f64,
        size.bytes as f64 / 1e6
    );
}
