//! The book's semi-implicit scheme (3.62)-(3.64): right for constant tension, of little use for an area law.

use crate::membrane::{Case, advance, area_error, balance, half_chords, largest_rise};
use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{Basis, Projector, Rule};
use immersa::fem::{Element, Space};
use immersa::flow::{Coefficient, FlowSolver, History, Step};
use immersa::levelset::Contour;
use immersa::sim::Coupling;
use immersa::transport::{Feet, Tracer, carry_nodal};
use std::sync::Arc;

/// A drop of surface tension 1 that starts as the ellipse.
const DROP: Case = Case { tension: true, stretch: 1.0, ..Case::LISTING };
const SEMI: Coupling = Coupling::SemiImplicit;

/// Energy over that at the start and error of the area in per cent at `end`, with the diffusion of (3.62) as `div(E' grad phi*)`. The rest is
/// the time step of order 1.
pub fn divergence_form(case: Case, end: f64) -> (f64, f64) {
    let start = case.simulation();
    let space = start.space().clone();
    let rule = Arc::new(Rule::simplex(2, 5));
    let mut flow =
        FlowSolver::new(&space, &Arc::new(Space::new(space.mesh(), Element::P1)), &rule, &vec![], case.grad_div)
            .unwrap();
    flow.set_materials(Coefficient::Constant(1.0), Coefficient::Constant(case.viscosity));
    let basis = flow.velocity().clone();
    let mut diffusion = Projector::without_form(basis.clone(), &[]).unwrap();
    let tracer = Tracer::new(&space, &[]);
    let law = AreaLaw::Linear { modulus: case.modulus };
    let mut membrane = Membrane::new(law, case.thickness);
    let (mut state, mut phi) = (flow.at_rest(), start.state().phi[0].clone());
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
    let energy = (flow.energies(&state)[0] + membrane.energy(&fine, &phi)) / start.state().energies.total();
    let area = Contour::new(&space, &phi).unwrap().measures().unwrap().area / (0.375 * std::f64::consts::PI) - 1.0;
    (energy, 100.0 * area)
}

#[test]
fn explore() {
    use std::io::Write;
    let out = std::cell::RefCell::new(std::io::stdout());
    for dt in [5e-2, 2e-2, 1e-2, 5e-3] {
        let mut sim = Case { dt, coupling: SEMI, ..DROP }.simulation();
        let e = sim.state().energies.total();
        for k in 1..=2 {
            let rise = largest_rise(&mut sim, 0.5 * k as f64) / e;
            writeln!(
                out.borrow_mut(),
                "semi {dt}: {} rise {rise:+.2e} E/E0 {:.5} bal {:+.5} area {:+.4} {:.5?}",
                sim.time(),
                sim.state().energies.total() / e,
                balance(&sim),
                area_error(&sim),
                half_chords(&sim)
            )
            .unwrap();
        }
    }
    let mut sim = Case { dt: 1.25e-3, ..DROP }.simulation();
    for k in 1..=2 {
        advance(&mut sim, 0.5 * k as f64);
        println!("expl {:.5?} {}", half_chords(&sim), balance(&sim));
    }
}
