//! The largest stable step of the explicit coupling against FreeFEM's and formula (1.54), and the
//! implicit coupling beyond it.

use crate::membrane::Case;
use crate::tools::point;
use immersa::elastic::{AreaLaw, Membrane, explicit_step_limit};
use immersa::fem::{Condition, Element, Space};
use immersa::mesh::{Diagonals, rectangle};
use immersa::sim::{Coupling, Fluid, Simulation, SimulationSettings};
use immersa::structure::{Immersed, ImmersedInterface, Medium};
use immersa::studies::stability::largest_stable_step;
use std::sync::Arc;

/// Whether `steps` steps neither fail nor bring the energy above 1.02 of the initial one or the
/// speed above `speed`.
pub fn is_stable(mut sim: Simulation<2>, steps: usize, speed: f64) -> bool {
    let allowed = 1.02 * sim.state().energies.total();
    (0..steps).all(|_| {
        sim.step().is_ok() && sim.state().energies.total() < allowed && sim.largest_speed() < speed
    })
}

/// The explicit scheme of order 1 is stable at 0.9 of the largest step that FreeFEM found stable
/// and unstable at 1.1 of the smallest that it found unstable, with the same criterion over 60
/// steps (freefem `memb2d`, grad-div 1, eps = .1, union-jack); the implicit coupling is stable at
/// ten times the former. `immersa study stability` finds .01681-.01717, .003851-.003935,
/// .01055-.01078 and .002051-.002096 by the energy alone.
fn ellipse(n: usize, modulus: f64, [stable, unstable]: [f64; 2], implicit: &[(usize, usize)]) {
    let case = Case { n, modulus, ..Case::LISTING };
    let speed = 4.0 * modulus.sqrt();
    let explicit = |dt: f64| is_stable(Case { dt, ..case }.simulation(), 60, speed);
    assert!(explicit(0.9 * stable), "unstable at {}", 0.9 * stable);
    assert!(!explicit(1.1 * unstable), "stable at {}", 1.1 * unstable);
    for &(order, steps) in implicit {
        let case = Case { dt: 10.0 * stable, order, coupling: Coupling::Implicit, ..case };
        assert!(is_stable(case.simulation(), steps, speed), "implicit coupling of order {order}");
    }
}

#[test]
fn the_limit_of_the_soft_ellipse() {
    ellipse(30, 1.0, [0.0160, 0.0170], &[(1, 60), (2, 60)]);
}

#[test]
fn the_limit_of_the_stiff_ellipse() {
    ellipse(30, 10.0, [0.00377, 0.0040], &[(1, 60), (2, 60)]);
}

#[test]
fn the_limit_of_the_soft_ellipse_on_the_finer_mesh() {
    ellipse(60, 1.0, [0.0100, 0.0106], &[(2, 20)]);
}

#[test]
fn the_limit_of_the_stiff_ellipse_on_the_finer_mesh() {
    ellipse(60, 10.0, [0.00199, 0.00211], &[(2, 20)]);
}

/// A fluid of density 1 on edges of this length, in steps of order 1.
pub fn medium(viscosity: f64, edge: f64) -> Medium {
    Medium { density: 1.0, viscosity, edge, order: 1 }
}

/// Constant tension 1 over a band of half-width `thickness`.
pub fn tension(thickness: f64) -> Membrane<2> {
    Membrane::new(AreaLaw::Tension { tension: 1.0 }, thickness)
}

/// A flat membrane across a unit box with periodic sides, its interface shaken by the grid.
pub fn flat(
    n: usize,
    viscosity: f64,
    membrane: &Membrane<2>,
    dt: f64,
    coupling: Coupling,
) -> Simulation<2> {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [n; 2], Diagonals::UnionJack).unwrap());
    let space = Space::new(&mesh, Element::P2);
    let height = |x: f64| {
        1e-3 * (std::f64::consts::TAU * x).sin()
            + 1e-4 * (std::f64::consts::PI * n as f64 * x).cos()
    };
    let structure = Immersed::boxed(
        ImmersedInterface::new(
            "film",
            space.interpolate(|x| x[1] - 0.5 - height(x[0])),
            membrane.thickness(),
        )
        .coupled(coupling),
        membrane.clone(),
    );
    let settings = SimulationSettings {
        order: 1,
        grad_div: 1.0,
        ..SimulationSettings::new(
            dt,
            Fluid { density: 1.0, viscosity },
            vec![
                ("left".into(), Condition::Periodic("right".into())),
                ("bottom".into(), Condition::NoSlip),
                ("top".into(), Condition::NoSlip),
            ],
        )
    };
    Simulation::new(&mesh, settings, vec![structure], |_| point(0.0, 0.0)).unwrap()
}

/// The formula stays below what is measured here: the nodal transport damps what the grid shakes.
#[test]
fn the_limit_of_a_flat_membrane() {
    for (n, viscosity, measured) in [(16, 1e-2, 1.34), (16, 0.1, 1.56), (32, 1e-3, 1.23)] {
        let (thickness, edge) = (3.0 / n as f64, 1.0 / n as f64);
        let limit = explicit_step_limit(&medium(viscosity, edge), thickness, 1.0);
        let run = |dt: f64| {
            Ok(is_stable(flat(n, viscosity, &tension(thickness), dt, Coupling::Explicit), 90, 1.0))
        };
        let found = largest_stable_step(limit, [0.25 * limit, 4.0 * limit], 0.03, run).unwrap();
        let ratio = found.limit().unwrap() / limit;
        println!(
            "Explicit limit, flat, mu = {viscosity}, n = {n}: {found:?}, formula {limit:.5}, \
             ratio {ratio:.2}"
        );
        assert!(
            found.stable.is_some() && found.unstable.is_some() && found.islands.is_empty(),
            "{found:?}"
        );
        assert!((ratio - measured).abs() < 0.05, "{ratio}");
    }
}
