//! The same bits for any number of threads, and after a checkpoint.

use immersa::elastic::{AreaLaw, Force, Membrane, SharpMembrane};
use immersa::fem::{Element, Space};
use immersa::levelset::{Ellipse, signed_distance};
use immersa::mesh::{Diagonals, Point, rectangle};
use immersa::sim::{Coupling, Fluid, Simulation, SimulationSettings, State, Transport};
use immersa::structure::{Immersed, ImmersedInterface};
use immersa::transport::Method;
use nalgebra::SVector;
use std::sync::Arc;

/// A drop with a stretched skin that falls: every part of the step is at work.
fn simulation(
    (transport, coupling, order, force): (Method, Coupling, usize, Force),
) -> Simulation<2> {
    let mesh = Arc::new(rectangle([0.0; 2], [2.0; 2], [24; 2], Diagonals::UnionJack).unwrap());
    let space = Space::new(&mesh, Element::P2);
    let shape = Ellipse::new(Point::<2>::new(1.0, 1.1), Point::<2>::new(0.6, 0.4), 20.0).unwrap();
    let phi = signed_distance(&space, &shape).iter().map(|d| 1.2 * d).collect();
    let interface = ImmersedInterface::new("skin", phi, 0.2)
        .stretched(1.2)
        .coupled(coupling)
        .filled(Fluid { density: 2.0, viscosity: 0.1 })
        .heavy(0.1);
    let structure = match force {
        Force::Sharp => Immersed::boxed(interface, SharpMembrane::new(LAW, 0.1)),
        Force::Smeared => Immersed::boxed(interface, Membrane::new(LAW, 0.2)),
    };
    let settings = SimulationSettings {
        order,
        grad_div: 1.0,
        gravity: SVector::<f64, 2>::new(0.0, -1.0),
        transport: Transport { method: transport, ..Transport::default() },
        ..SimulationSettings::new(5e-3, Fluid { density: 1.0, viscosity: 0.05 }, vec![])
    };
    Simulation::new(&mesh, settings, vec![structure], |_| SVector::zeros()).unwrap()
}

const LAW: AreaLaw = AreaLaw::Linear { modulus: 2.0 };

const CASES: [(Method, Coupling, usize, Force); 7] = [
    (Method::Nodal, Coupling::Explicit, 1, Force::Smeared),
    (Method::Nodal, Coupling::SemiImplicit, 1, Force::Smeared),
    (Method::Nodal, Coupling::Implicit, 2, Force::Smeared),
    (Method::Projected, Coupling::Implicit, 2, Force::Smeared),
    (Method::Nodal, Coupling::Explicit, 1, Force::Sharp),
    (Method::Nodal, Coupling::Implicit, 2, Force::Sharp),
    (Method::Projected, Coupling::Implicit, 2, Force::Sharp),
];

fn steps(sim: &mut Simulation<2>, count: usize) -> Vec<u8> {
    for _ in 0..count {
        sim.step().unwrap();
    }
    // Bytes, so that -0 and 0 differ and NaN would show.
    sim.state().to_bytes(0)
}

#[test]
fn one_thread_and_several_give_the_same_bits() {
    for case in CASES {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| steps(&mut simulation(case), 10))
        };
        let one = run(1);
        // A drop of another viscosity: the matrix changes in each step, and an older factor must be
        // among the bits.
        assert!(
            State::<2>::from_bytes(&one, 0)
                .unwrap()
                .factored
                .is_some_and(|f| f.solve_cost.solves >= 1.0)
        );
        assert!(run(2) == one && run(3) == one, "{case:?}");
    }
}

#[test]
fn a_checkpoint_in_the_middle_changes_no_bit() {
    for case in CASES {
        let straight = steps(&mut simulation(case), 10);
        let half = steps(&mut simulation(case), 5);
        let mut resumed = simulation(case);
        resumed.restore(State::from_bytes(&half, 0).unwrap()).unwrap();
        assert!(steps(&mut resumed, 5) == straight, "{case:?}");
    }
}
