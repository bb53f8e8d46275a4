//! The largest stable step of the explicit coupling against formula (1.54), and the implicit coupling beyond it.

use crate::membrane::Case;
use crate::tools::point;
use immersa::elastic::{AreaLaw, Membrane, explicit_step_limit};
use immersa::fem::{Condition, Element, Space};
use immersa::mesh::{Diagonals, rectangle};
use immersa::sim::{Contrast, Coupling, Materials, Settings, Simulation, Structure};
use immersa::transport::Method;
use nalgebra::SVector;
use std::sync::Arc;

/// Whether `steps` steps neither fail nor bring the energy above 1.02 of the initial one or the speed above `speed`.
pub fn is_stable(mut sim: Simulation<2>, steps: usize, speed: f64) -> bool {
    let allowed = 1.02 * sim.state().energies.total();
    (0..steps).all(|_| sim.step().is_ok() && sim.state().energies.total() < allowed && sim.largest_speed() < speed)
}

/// The stable and the unstable step around the limit, 3 per cent apart, between a quarter and four times `guess`.
fn bisect(guess: f64, is_stable: impl Fn(f64) -> bool) -> (f64, f64) {
    let (mut stable, mut unstable) = (0.25 * guess, 4.0 * guess);
    assert!(is_stable(stable) && !is_stable(unstable), "the limit is not within a factor of four of {guess}");
    while unstable > 1.03 * stable {
        let middle = (stable * unstable).sqrt();
        if is_stable(middle) { stable = middle } else { unstable = middle }
    }
    (stable, unstable)
}

/// FreeFEM, with the same criterion, failed between .0160 and .0170 (modulus 1) and between .00377 and .0040 (modulus 10).
fn ellipse(modulus: f64, measured: f64) {
    let case = Case { modulus, ..Case::LISTING };
    let limit =
        explicit_step_limit(case.viscosity, case.thickness, modulus * (case.stretch - 1.0), 2.0 / case.n as f64);
    let speed = 4.0 * modulus.sqrt();
    let (stable, unstable) = bisect(limit, |dt| is_stable(Case { dt, ..case }.simulation(), 60, speed));
    let ratio = (stable * unstable).sqrt() / limit;
    println!(
        "Explicit limit, ellipse, lambda = {modulus}, n = 30: {stable:.5} .. {unstable:.5}, formula {limit:.5}, ratio {ratio:.2}"
    );
    assert!((0.7..=1.5).contains(&ratio) && (ratio - measured).abs() < 0.05, "{ratio}");
    for order in [1, 2] {
        let implicit = Case { dt: 4.0 * unstable, order, coupling: Coupling::Implicit, ..case };
        assert!(is_stable(implicit.simulation(), 60, speed), "implicit coupling of order {order}");
    }
}

#[test]
fn the_limit_of_the_soft_ellipse() {
    ellipse(1.0, 1.37);
}

#[test]
fn the_limit_of_the_stiff_ellipse() {
    ellipse(10.0, 1.40);
}

/// Constant tension 1 over a band of half-width `thickness`.
pub fn tension(thickness: f64) -> Membrane<2> {
    Membrane::new(AreaLaw::Tension { tension: 1.0 }, thickness)
}

/// A flat membrane across a unit box with periodic sides, its interface shaken by the grid.
pub fn flat(n: usize, viscosity: f64, membrane: &Membrane<2>, dt: f64, coupling: Coupling) -> Simulation<2> {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [n; 2], Diagonals::UnionJack).unwrap());
    let space = Space::new(&mesh, Element::P2);
    let height = |x: f64| 1e-3 * (std::f64::consts::TAU * x).sin() + 1e-4 * (std::f64::consts::PI * n as f64 * x).cos();
    let structure = Structure {
        name: "film".into(),
        phi: space.interpolate(|x| x[1] - 0.5 - height(x[0])),
        membrane: membrane.clone(),
        surface_mass: 0.0,
    };
    let uniform = Contrast::uniform;
    let settings = Settings {
        dt,
        order: 1,
        transport: Method::Nodal,
        coupling,
        convection: true,
        grad_div: 1.0,
        quadrature: 5,
        materials: Materials { density: uniform(1.0), viscosity: uniform(viscosity) },
        conditions: vec![
            ("left".into(), Condition::Periodic("right".into())),
            ("bottom".into(), Condition::NoSlip),
            ("top".into(), Condition::NoSlip),
        ],
        gravity: SVector::zeros(),
        body_force: None,
    };
    Simulation::new(&mesh, settings, vec![structure], |_| point(0.0, 0.0)).unwrap()
}

/// The formula stays below what is measured here: the nodal transport damps what the grid shakes.
#[test]
fn the_limit_of_a_flat_membrane() {
    for (n, viscosity, measured) in [(16, 1e-2, 1.34), (16, 0.1, 1.56), (32, 1e-3, 1.23)] {
        let (thickness, edge) = (3.0 / n as f64, 1.0 / n as f64);
        let limit = explicit_step_limit(viscosity, thickness, 1.0, edge);
        let run = |dt: f64| is_stable(flat(n, viscosity, &tension(thickness), dt, Coupling::Explicit), 90, 1.0);
        let (stable, unstable) = bisect(limit, run);
        let ratio = (stable * unstable).sqrt() / limit;
        println!(
            "Explicit limit, flat, mu = {viscosity}, n = {n}: {stable:.5} .. {unstable:.5}, formula {limit:.5}, ratio {ratio:.2}"
        );
        assert!((ratio - measured).abs() < 0.05, "{ratio}");
    }
}
