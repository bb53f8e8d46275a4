//! The book's semi-implicit scheme (3.62)-(3.64): right for constant tension, of little use for an
//! area law.

use crate::explicit_limit::medium;
use crate::membrane::{Case, area_error, balance, half_chords, largest_rise};
use immersa::elastic::{AreaLaw, Membrane, explicit_step_limit};
use immersa::fem::{Basis, Element, Projector, Rule, Space};
use immersa::flow::{Coefficient, FlowSolver, History, Step};
use immersa::levelset::Contour;
use immersa::sim::Coupling;
use immersa::transport::{Feet, Tracer, carry_nodal};
use std::sync::Arc;

/// A drop of surface tension 1 that starts as the ellipse.
const DROP: Case = Case { tension: true, stretch: 1.0, ..Case::LISTING };
const SEMI: Coupling = Coupling::SemiImplicit;

/// Energy over that at the start and error of the area in per cent at `end`, with the diffusion of
/// (3.62) as `div(E' grad phi*)`. The rest is the time step of order 1.
pub fn divergence_form(case: Case, end: f64) -> (f64, f64) {
    let start = case.simulation();
    let space = start.space().clone();
    let rule = Arc::new(Rule::simplex(2, 5));
    let mut flow = FlowSolver::new(
        &space,
        &Arc::new(Space::new(space.mesh(), Element::P1)),
        &rule,
        &vec![],
        case.grad_div,
    )
    .unwrap();
    flow.set_materials(Coefficient::Constant(1.0), Coefficient::Constant(case.viscosity));
    let basis = flow.velocity().clone();
    let mut diffusion = Projector::without_form(basis.clone(), &[]).unwrap();
    let tracer = Tracer::new(&space, &[]);
    let law = AreaLaw::Linear { modulus: case.modulus };
    let mut membrane = Membrane::new(law, case.thickness);
    let (mut state, mut phi) = (flow.at_rest(), start.level_set(0).into_owned());
    let (mut feet, mut carried) = (Feet::default(), phi.clone());
    for k in 0..(end / case.dt).round() as usize {
        tracer.from_nodes(&state.u, case.dt, &mut feet);
        carry_nodal(&space, &phi, &feet, &mut carried);
        let diffusivity = |r: f64| case.dt * case.dt * law.tension(r).max(0.0) / case.thickness;
        diffusion.set_form(|at| (1.0, diffusivity(basis.gradient(at, &phi).norm()))).unwrap();
        let source = carried.clone();
        diffusion.project(|at| basis.value(at, &source), &mut carried).unwrap();
        membrane.prepare(&basis, &carried, None);
        tracer.from_quadrature(&state.u, case.dt, &basis, &mut feet);
        let before = state.u.clone();
        let history = [History { weight: 1.0, u: &before, feet: Some(&feet) }];
        let step = Step::backward_euler((k + 1) as f64 * case.dt, case.dt, &history);
        flow.step(&Step { terms: &[&membrane], ..step }, &mut state).unwrap();
        tracer.from_nodes(&state.u, case.dt, &mut feet);
        carry_nodal(&space, &phi, &feet, &mut carried);
        phi.copy_from_slice(&carried);
    }
    let fine = Basis::new(&space, &Arc::new(Rule::simplex(2, 8)));
    let energy =
        (flow.energies(&state)[0] + membrane.energy(&fine, &phi)) / start.state().energies.total();
    let area = Contour::new(&space, &phi).unwrap().measures().unwrap().area
        / (0.375 * std::f64::consts::PI)
        - 1.0;
    (energy, 100.0 * area)
}

/// Constant tension, what the scheme is made for: at four times the limit (1.54), where the
/// explicit coupling has lost the drop, the energy falls but for what the tests of the drop at rest
/// allow, and the oscillation is that of the explicit coupling at a small step.
#[test]
fn a_drop_beyond_the_explicit_limit() {
    let limit =
        explicit_step_limit(&medium(DROP.viscosity, 2.0 / DROP.n as f64), DROP.thickness, 1.0);
    let exact = half_chords(&Case { dt: 1.25e-3, ..DROP }.run(0.5));
    let lost = Case { dt: 2e-2, ..DROP }.run(0.2);
    assert!(balance(&lost) > 1.0);
    for (dt, chords, created) in [(2e-2, 8e-3, 5e-4), (1e-2, 2.3e-3, 9e-4), (5e-3, 6e-4, 7e-4)] {
        let mut sim = Case { dt, coupling: SEMI, ..DROP }.simulation();
        let rise = largest_rise(&mut sim, 0.5) / sim.state().balance.initial;
        let [a, b] = half_chords(&sim);
        let error = (a - exact[0]).abs().max((b - exact[1]).abs());
        let residual = balance(&sim);
        println!(
            "Drop, semi-implicit, dt = {dt} ({:.1} of the limit), t = .5: half-chords {error:.1e} \
             off, balance {residual:+.5}, largest rise {rise:+.1e} E0, area {:+.3} %",
            dt / limit,
            area_error(&sim)
        );
        assert!(
            error < chords && residual.abs() < created && rise < 0.0,
            "{error} {residual} {rise}"
        );
    }
}

/// An area law at a step below the limit: the explicit coupling's motion and balance.
#[test]
fn an_area_law_below_the_explicit_limit() {
    let small = Case { modulus: 10.0, dt: 1.25e-3, ..Case::LISTING };
    let (explicit, semi) = (small.run(0.2), Case { coupling: SEMI, ..small }.run(0.2));
    let (a, b) = (half_chords(&explicit)[0], half_chords(&semi)[0]);
    let residuals = [balance(&semi), balance(&explicit)];
    println!(
        "Area law, lambda = 10, dt = 1.25e-3, t = .2: half-chord {b:.5}, explicit {a:.5}, \
         balances {residuals:.4?}"
    );
    assert!((a - b).abs() < 4e-4 && (residuals[0] - residuals[1]).abs() < 2e-3);
}

/// An area law at the steps that the scheme is for: wrong or unstable. With lambda = 1 at 1.7 times
/// the limit the run looks well, but 7 % of the energy are spurious by t = 2; with lambda = 10 at
/// 1.8 times 4 % by t = .4, and at 3.6 times it blows up. The implicit coupling bears all of these.
#[test]
fn an_area_law_beyond_the_explicit_limit() {
    for (modulus, grad_div, dt, end, range) in [
        (1.0, 1.0, 2e-2, 2.0, 0.05..0.08),
        (10.0, 16.0, 5e-3, 0.4, 0.03..0.05),
        (10.0, 16.0, 1e-2, 0.4, 10.0..1e5),
    ] {
        let case = Case { modulus, grad_div, dt, ..Case::LISTING };
        let [semi, implicit] =
            [SEMI, Coupling::Implicit].map(|coupling| balance(&Case { coupling, ..case }.run(end)));
        println!(
            "Area law, lambda = {modulus}, dt = {dt}, t = {end}: balance {semi:+.4}, implicit \
             coupling {implicit:+.4}"
        );
        assert!(range.contains(&semi) && implicit.abs() < 0.025, "{semi} {implicit}");
    }
}
