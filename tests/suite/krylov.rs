//! A matrix that changes in each step, solved for with an older factor.

use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{Element, Space};
use immersa::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use immersa::sim::{Coupling, Fluid, Simulation, SimulationSettings};
use immersa::structure::{Immersed, ImmersedInterface};
use nalgebra::SVector;
use std::sync::Arc;

/// A stretched sphere (in the plane a circle) of another fluid, ten times as viscous, that is
/// squeezed in a box.
fn squeezed<const D: usize>(
    mesh: Mesh<D>,
    coupling: Coupling,
    tolerance: f64,
    dt: f64,
) -> Simulation<D> {
    let mesh = Arc::new(mesh);
    let space = Space::new(&mesh, Element::P2);
    let centre = Point::<D>::from_element(0.5);
    let squeeze = |x: &Point<D>| {
        let mut d = x - centre;
        d[0] *= 1.3;
        d.norm() - 0.28
    };
    let structure = Immersed::boxed(
        ImmersedInterface::new(
            "skin",
            space.nodes().iter().map(|x| 1.1 * squeeze(x)).collect(),
            0.15,
        )
        .stretched(1.1)
        .coupled(coupling)
        .filled(Fluid { density: 1.0, viscosity: 0.1 }),
        Membrane::new(AreaLaw::Linear { modulus: 1.0 }, 0.15),
    );
    let settings = SimulationSettings {
        grad_div: 1.0,
        solve_tolerance: tolerance,
        quadrature: 4,
        ..SimulationSettings::new(dt, Fluid { density: 1.0, viscosity: 0.01 }, vec![])
    };
    Simulation::new(&mesh, settings, vec![structure], |_| SVector::zeros()).unwrap()
}

/// Velocity and counts (factorisations, iterations, seconds of the later steps) after `steps`.
fn course<const D: usize>(
    mut sim: Simulation<D>,
    steps: usize,
) -> (Vec<SVector<f64, D>>, usize, usize, f64) {
    let (mut factored, mut iterations) = (0, 0);
    let mut begin = cpu_time::ProcessTime::now();
    for k in 0..steps {
        let report = sim.step().unwrap();
        assert!(report.solve.residual <= 1e-10, "step {k}: {report:?}");
        factored += usize::from(report.refactored);
        iterations += report.solve.iterations;
        if k == 1 {
            begin = cpu_time::ProcessTime::now();
        }
    }
    (
        sim.state().flow.u.clone(),
        factored,
        iterations,
        begin.elapsed().as_secs_f64() / (steps - 2) as f64,
    )
}

/// Both ways of solving come to the same flow; the one with iterations factors less often than it
/// steps.
#[allow(clippy::print_stdout, reason = "prints what was measured, with --nocapture")]
fn both_ways_agree<const D: usize>(
    mesh: &Mesh<D>,
    coupling: Coupling,
    dt: f64,
    steps: usize,
) -> f64 {
    let (direct, each, none, slow) = course(squeezed(mesh.clone(), coupling, 0.0, dt), steps);
    let (iterated, factored, iterations, fast) =
        course(squeezed(mesh.clone(), coupling, 1e-10, dt), steps);
    assert_eq!((each, none), (steps, 0));
    assert!(
        factored < steps && iterations > 0,
        "{factored} factorisations in {steps} steps, {iterations} iterations"
    );
    let size = |u: &[SVector<f64, D>]| u.iter().map(|u| u.norm_squared()).sum::<f64>().sqrt();
    let error =
        size(&direct.iter().zip(&iterated).map(|(a, b)| a - b).collect::<Vec<_>>()) / size(&direct);
    assert!(error < 1e-7, "velocities differ by {error:e}");
    println!(
        "{D}-D, {} cells, {coupling:?}, dt {dt}: factored {factored} of {steps}, {iterations} \
         iterations, difference {error:.1e}, step {slow:.4} s factored, {fast:.4} s iterated, \
         ratio {:.2}",
        mesh.cell_count(),
        slow / fast
    );
    slow / fast
}

#[test]
fn iterations_with_an_older_factor_come_to_the_flow_of_factoring_each_matrix() {
    let plane = rectangle([0.0; 2], [1.0; 2], [40; 2], Diagonals::UnionJack).unwrap();
    both_ways_agree(&plane, Coupling::Implicit, 5e-3, 12);
    both_ways_agree(&plane, Coupling::Explicit, 5e-3, 12);
    let space = box_mesh([0.0; 3], [1.0; 3], [5; 3]).unwrap();
    both_ways_agree(&space, Coupling::Explicit, 5e-3, 8);
    both_ways_agree(&space, Coupling::Implicit, 5e-3, 8);
}

/// Prints ratios of times; run by hand.
#[test]
#[ignore = "measures times"]
fn measure_iterations_in_three_dimensions() {
    for n in [8, 10] {
        let space = box_mesh([0.0; 3], [1.0; 3], [n; 3]).unwrap();
        both_ways_agree(&space, Coupling::Explicit, 5e-3, 10);
        both_ways_agree(&space, Coupling::Implicit, 5e-3, 10);
        both_ways_agree(&space, Coupling::Implicit, 2e-2, 10);
    }
}
