//! The capillary wave of `examples/capillary-wave` against the exact solution: orders in space and
//! time, and what a coupling costs.

use crate::prosperetti::CapillaryWave;
use crate::tools::Study;
use immersa::levelset::Contour;
use immersa::scene::{ImmersedFlow, Scene};
use std::f64::consts::PI;
use std::path::Path;

const WAVE: CapillaryWave = CapillaryWave {
    density: 1.0,
    viscosity: 0.0182571749,
    tension: 1.0,
    number: 2.0 * PI,
    amplitude: 0.01,
};
/// Distance of the times that are looked at.
const SAMPLE: f64 = 0.08;

/// The amplitude, without its sign, at the multiples of [`SAMPLE`] to the end of the scene, 25 over
/// the frequency without viscosity.
fn amplitudes(cells: usize, dt: f64, set: &[&str]) -> Vec<f64> {
    let mut all =
        vec![format!("mesh.rectangle.cells=[{cells},{}]", 3 * cells), format!("time.step={dt}")];
    all.extend(set.iter().map(ToString::to_string));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/capillary-wave/scene.toml");
    let scene = Scene::load(&path, &all).unwrap();
    let mut sim = ImmersedFlow::<2>::new(&scene).unwrap().simulation;
    let each = (SAMPLE / dt).round() as usize;
    assert!(
        (each as f64 * dt - SAMPLE).abs() < 1e-9
            && (scene.time.end * WAVE.frequency() - 25.0).abs() < 0.1
    );
    let amplitude = |sim: &immersa::sim::Simulation<2>| {
        let contour = Contour::new(sim.space(), &sim.level_set(0)).unwrap();
        contour.measures().unwrap().extent_y
    };
    let mut found = vec![amplitude(&sim)];
    for _ in 0..scene.time.steps() as usize / each {
        if (0..each).any(|_| sim.step().is_err()) {
            break;
        }
        found.push(amplitude(&sim));
    }
    found
}

/// Root mean square of the differences, over the amplitude at the start.
fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
        / WAVE.amplitude
}

/// The same against the exact amplitude.
fn error(found: &[f64]) -> f64 {
    let exact: Vec<f64> = (0..found.len()).map(|i| WAVE.at(i as f64 * SAMPLE).abs()).collect();
    rms(found, &exact)
}

/// Mesh and step refined together.
#[test]
fn the_sharp_force_is_of_second_order() {
    let levels = [(8, 0.02), (16, 0.01), (32, 0.005)];
    let errors = levels.map(|(cells, dt)| error(&amplitudes(cells, dt, &[]))).to_vec();
    let sizes = levels.map(|(cells, _)| 1.0 / cells as f64);
    let what = "Capillary wave, sharp, implicit of order 2";
    Study { what, sizes: &sizes, errors }.assert_at_least(1.8, 0.008);
}

/// Over a band the error is that of its thickness.
#[test]
fn the_smeared_force_is_of_the_order_of_its_band() {
    let band = |cells: usize| format!("numerics.thickness={}", 1.5 / cells as f64);
    let errors = [(8, 0.02), (16, 0.01)].map(|(cells, dt)| {
        let found = amplitudes(cells, dt, &["drop.0.force=\"smeared\"", &band(cells)]);
        error(&found)
    });
    println!("Capillary wave, smeared over 1.5 edges, 8 and 16 squares: {errors:.4?}");
    let order = (errors[0] / errors[1]).log2();
    assert!((0.6..1.4).contains(&order) && errors[1] < 0.14, "{order} {errors:?}");
}

/// What a step costs in accuracy, on 16 squares over a band of 2.5 edges, against a small step of
/// order 2 with the same band: at .5, 1, 2, 5 and 10 times the limit (1.54), which is .0082. None:
/// unstable.
#[test]
fn the_price_of_a_step_beyond_the_limit() {
    let run = |coupling: &str, order: usize, dt: f64| {
        let coupling = format!("numerics.coupling=\"{coupling}\"");
        amplitudes(16, dt, &["drop.0.force=\"smeared\"", &coupling, &format!("time.order={order}")])
    };
    let right = run("explicit", 2, 0.002);
    println!(
        "Capillary wave over a band of 2.5 edges, small step: {:.3} from the exact one",
        error(&right)
    );
    let measured = [
        ("explicit", 1, [Some(0.0052), Some(0.0105), Some(0.022), None, None]),
        ("semi-implicit", 1, [0.046, 0.085, 0.149, 0.223, 0.267].map(Some)),
        ("implicit", 1, [0.053, 0.095, 0.155, 0.242, 0.293].map(Some)),
        ("explicit", 2, [Some(0.0003), Some(0.0011), None, None, None]),
        ("implicit", 2, [0.0021, 0.0084, 0.0325, 0.146, 0.214].map(Some)),
    ];
    for (coupling, order, expected) in measured {
        let found =
            [0.004, 0.008, 0.016, 0.04, 0.08].map(|dt| rms(&run(coupling, order, dt), &right));
        println!("Capillary wave, {coupling}, order {order}: {found:.4?}");
        for (found, expected) in found.iter().zip(expected) {
            match expected {
                Some(e) => assert!(
                    (found - e).abs() < 0.1 * e + 5e-4,
                    "{coupling} {order}: {found}, expected {e}"
                ),
                None => {
                    assert!(*found > 1.0, "{coupling} {order}: {found}, expected to be unstable")
                }
            }
        }
    }
}
