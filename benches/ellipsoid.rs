//! The explicit step of a membrane in space beside FreeFEM's: an ellipsoid, stretched beforehand,
//! relaxes in a closed box.
//!
//! `cargo bench --bench ellipsoid -- 8 12` runs boxes of 8 and 12 blocks along a side; `steps=20`
//! sets how many steps, `mesh=FOLDER` also writes the meshes as `FOLDER/ellipsoid-N.mesh` for
//! `FreeFem++ -nw -v 0 examples/ellipsoid/twin.edp -mesh FOLDER/ellipsoid-N.mesh -eps 3/N -steps
//! 20` (3/N as a number). One thread.

#![allow(clippy::print_stdout, reason = "the figures are the point of a bench")]

use cpu_time::ProcessTime;
use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{Condition, Element, Space};
use immersa::mesh::{Point, box_mesh, freefem};
use immersa::sim::{Coupling, Fluid, Simulation, SimulationSettings};
use immersa::structure::{Immersed, ImmersedInterface};
use nalgebra::SVector;
use std::sync::Arc;

/// Axes of the ellipsoid, and what the level set is multiplied with.
const AXES: [f64; 3] = [0.7, 0.6, 0.5];
const STRETCH: f64 = 1.25;
/// FreeFEM's form `mu (grad u, grad v)` is ours with a grad-div term less `mu`.
const VISCOSITY: f64 = 0.01;
const GRAD_DIV: f64 = 1.0 - VISCOSITY;
const DT: f64 = 5e-3;

fn main() {
    // It fails only where threads were started already.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let value = |key: &str| arguments.iter().find_map(|a| a.strip_prefix(key).map(str::to_owned));
    let steps = value("steps=").and_then(|s| s.parse().ok()).unwrap_or(10);
    let sizes: Vec<usize> = arguments.iter().filter_map(|a| a.parse().ok()).collect();
    println!(
        "n,cells,unknowns,set_up,first_step,per_step,peak_mb,time,a,b,c,kinetic,elastic,largest_speed"
    );
    for n in if sizes.is_empty() { vec![8] } else { sizes } {
        run(n, steps, value("mesh=").as_deref());
    }
}

fn run(n: usize, steps: usize, folder: Option<&str>) {
    let begin = ProcessTime::now();
    let mesh = Arc::new(box_mesh([0.0; 3], [2.0; 3], [n; 3]).unwrap());
    if let Some(folder) = folder {
        std::fs::write(format!("{folder}/ellipsoid-{n}.mesh"), freefem::text(&mesh).unwrap())
            .unwrap();
    }
    let mut sim = simulation(&mesh, 3.0 / n as f64);
    let set_up = begin.elapsed().as_secs_f64();
    let begin = ProcessTime::now();
    sim.step().unwrap();
    let first = begin.elapsed().as_secs_f64();
    let begin = ProcessTime::now();
    for _ in 1..steps {
        sim.step().unwrap();
    }
    let each = begin.elapsed().as_secs_f64() / (steps - 1).max(1) as f64;
    let unknowns = 4 * mesh.points().len() + 3 * (sim.space().len() - mesh.points().len());
    let [a, b, c] = [0, 1, 2].map(|k| radius(&sim, k));
    let energies = sim.state().energies;
    let speed = sim.state().flow.u.iter().map(|u| u.norm()).fold(0.0, f64::max);
    println!(
        "{n},{},{unknowns},{set_up:.3},{first:.3},{each:.4},{:.0},{:.4},{a:.7},{b:.7},{c:.7},{:.8e},{:.8e},{speed:.8e}",
        mesh.cell_count(),
        peak(),
        sim.time(),
        energies.kinetic,
        energies.elastic
    );
}

fn simulation(mesh: &Arc<immersa::mesh::Mesh<3>>, thickness: f64) -> Simulation<3> {
    let settings = SimulationSettings {
        order: 1,
        grad_div: GRAD_DIV,
        ..SimulationSettings::new(
            DT,
            Fluid { density: 1.0, viscosity: VISCOSITY },
            vec![("walls".into(), Condition::NoSlip)],
        )
    };
    let space = Space::new(mesh, Element::P2);
    let level =
        |x: &Point<3>| (0..3).map(|k| ((x[k] - 1.0) / AXES[k]).powi(2)).sum::<f64>().sqrt() - 1.0;
    let phi = space.interpolate(|x| STRETCH * AXES[1] * level(x));
    let membrane = Membrane::new(AreaLaw::Linear { modulus: 1.0 }, thickness);
    let structure = Immersed::boxed(
        ImmersedInterface::new("membrane", phi, thickness)
            .stretched(STRETCH)
            .coupled(Coupling::Explicit),
        membrane,
    );
    Simulation::new(mesh, settings, vec![structure], |_| SVector::zeros()).unwrap()
}

/// Distance of the membrane from the centre along an axis, by bisection.
fn radius(sim: &Simulation<3>, axis: usize) -> f64 {
    let (space, phi) = (sim.space(), &sim.level_set(0));
    let locator = immersa::mesh::Locator::new(space.mesh());
    let (mut inside, mut outside) = (0.05, 0.95);
    for _ in 0..40 {
        let middle = 0.5 * (inside + outside);
        let mut x = Point::<3>::repeat(1.0);
        x[axis] += middle;
        let at = locator.locate(space.mesh(), &x).unwrap();
        if space.value(phi, at.cell as usize, &at.barycentric) < 0.0 {
            inside = middle
        } else {
            outside = middle
        }
    }
    0.5 * (inside + outside)
}

/// Most memory held so far, in MB; NaN where the system does not tell.
fn peak() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse::<f64>().ok())
        .map_or(f64::NAN, |kb| kb / 1024.0)
}
