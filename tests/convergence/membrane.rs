//! The membrane of the book's sections 3.5.3 and 3.6.1.1: an ellipse .75 / .5 in the box [0, 2]^2,
//! stretched beforehand.

use crate::tools::point;
use immersa::elastic::{AreaLaw, Band, Membrane, SharpMembrane};
use immersa::fem::{Element, Space};
use immersa::levelset::{Contour, Ellipse, Measures, signed_distance};
use immersa::mesh::{Diagonals, rectangle};
use immersa::sim::{Coupling, Fluid, Simulation, SimulationSettings, Transport};
use immersa::structure::{Immersed, ImmersedInterface};
use immersa::transport::Method;
use nalgebra::SVector;
use std::sync::Arc;

/// Perimeter of the ellipse over that of the rest circle of radius 1/2.
pub const STRETCH: f64 = 1.26253110;

/// What differs between the cases.
#[derive(Clone, Copy)]
pub struct Case {
    /// Squares along a side.
    pub n: usize,
    pub diagonals: Diagonals,
    /// `E'(r) = modulus (r - 1)`, or `modulus` where there is constant `tension`.
    pub modulus: f64,
    /// A drop, with a carried band, instead of a membrane.
    pub tension: bool,
    /// The force on the interface itself instead of over a band.
    pub sharp: bool,
    pub thickness: f64,
    pub viscosity: f64,
    pub grad_div: f64,
    pub dt: f64,
    pub order: usize,
    pub coupling: Coupling,
    pub transport: Method,
    pub semi_axes: [f64; 2],
    pub stretch: f64,
}

impl Case {
    /// The book's listing (section 3.6.1.1) with the grad-div term.
    pub const LISTING: Case = Case {
        n: 30,
        diagonals: Diagonals::UnionJack,
        modulus: 1.0,
        tension: false,
        sharp: false,
        thickness: 0.1,
        viscosity: 0.01,
        grad_div: 1.0,
        dt: 5e-3,
        order: 1,
        coupling: Coupling::Explicit,
        transport: Method::Nodal,
        semi_axes: [0.75, 0.5],
        stretch: STRETCH,
    };

    pub fn simulation(&self) -> Simulation<2> {
        let mesh = Arc::new(rectangle([0.0; 2], [2.0; 2], [self.n; 2], self.diagonals).unwrap());
        let space = Space::new(&mesh, Element::P2);
        let [a, b] = self.semi_axes;
        let shape = Ellipse::new(point(1.0, 1.0), point(a, b), 0.0).unwrap();
        let (law, band) = if self.tension {
            (AreaLaw::Tension { tension: self.modulus }, Band::Carried)
        } else {
            (AreaLaw::Linear { modulus: self.modulus }, Band::Renormalised)
        };
        let phi = signed_distance(&space, &shape).iter().map(|d| self.stretch * d).collect();
        let interface = ImmersedInterface::new("membrane", phi, self.thickness)
            .stretched(self.stretch)
            .coupled(self.coupling);
        let structure = match self.sharp {
            true => Immersed::boxed(interface, SharpMembrane::new(law, self.viscosity)),
            false => {
                let force = Membrane::new(law, self.thickness).with_band(band, self.stretch);
                Immersed::boxed(interface, force)
            }
        };
        let settings = SimulationSettings {
            order: self.order,
            grad_div: self.grad_div,
            transport: Transport { method: self.transport, ..Transport::default() },
            ..SimulationSettings::new(
                self.dt,
                Fluid { density: 1.0, viscosity: self.viscosity },
                vec![],
            )
        };
        Simulation::new(&mesh, settings, vec![structure], |_| SVector::zeros()).unwrap()
    }

    /// The simulation after the steps to `end`.
    pub fn run(&self, end: f64) -> Simulation<2> {
        let mut sim = self.simulation();
        advance(&mut sim, end);
        sim
    }
}

/// Steps to the time `end`, which must be a whole number of them.
pub fn advance(sim: &mut Simulation<2>, end: f64) {
    let steps = (end / sim.settings().dt).round();
    assert!((steps * sim.settings().dt - end).abs() < 1e-9, "{end} is no multiple of the step");
    while sim.state().steps < steps as u64 {
        sim.step().unwrap();
    }
}

/// Half-chords of the membrane along x and y through the centre of the box.
pub fn half_chords(sim: &Simulation<2>) -> [f64; 2] {
    let phi = &sim.level_set(0);
    let contour = Contour::new(sim.space(), phi).unwrap();
    [point(1.0, 0.0), point(0.0, 1.0)]
        .map(|along| contour.half_chord(sim.space(), phi, &point(1.0, 1.0), &along).unwrap())
}

/// Area, perimeter and the like.
pub fn measures(sim: &Simulation<2>) -> Measures {
    Contour::new(sim.space(), &sim.level_set(0)).unwrap().measures().unwrap()
}

/// Error of the enclosed area in per cent, for the ellipse .75 / .5.
pub fn area_error(sim: &Simulation<2>) -> f64 {
    100.0 * (measures(sim).area / (0.375 * std::f64::consts::PI) - 1.0)
}

/// Steps to `end` and gives the largest rise of the total energy in one step.
pub fn largest_rise(sim: &mut Simulation<2>, end: f64) -> f64 {
    let steps = (end / sim.settings().dt).round() as u64;
    let mut rise = f64::NEG_INFINITY;
    while sim.state().steps < steps {
        let before = sim.state().energies.total();
        sim.step().unwrap();
        rise = rise.max(sim.state().energies.total() - before);
    }
    rise
}

/// Spurious energy, over the initial energy.
pub fn balance(sim: &Simulation<2>) -> f64 {
    sim.state().balance.residual(&sim.state().energies)
}
