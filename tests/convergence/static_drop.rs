//! Currents about a drop at rest, and its pressure, by force, thickness of the band, pressure space
//! and grad-div.

use crate::tools::{Study, point};
use immersa::fem::{Element, Space};
use immersa::mesh::Locator;
use immersa::scene::{ImmersedFlow, Scene};
use std::path::Path;

/// Largest speed, and error of the jump of the pressure over the exact one, on `cells` squares a
/// side.
fn at_rest(cells: usize, set: &[&str]) -> [f64; 2] {
    let mut all = vec![format!("mesh.rectangle.cells=[{cells},{cells}]")];
    all.extend(set.iter().map(ToString::to_string));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/static-drop/scene.toml");
    let scene = Scene::load(&path, &all).unwrap();
    let mut sim = ImmersedFlow::<2>::new(&scene).unwrap().simulation;
    sim.step().unwrap();
    let mesh = sim.space().mesh();
    let (space, locator) = (Space::new(mesh, Element::P1), Locator::new(mesh));
    let [inside, outside] = [point(0.52, 0.47), point(0.02, 0.97)].map(|x| {
        let at = locator.locate(mesh, &x).unwrap();
        space.value(&sim.state().flow.p, at.cell as usize, &at.barycentric)
    });
    [sim.largest_speed(), ((inside - outside) / 4.0 - 1.0).abs()]
}

/// The study over 16, 32 and 64 squares of the speeds, and the errors of the jump.
fn study(what: &str, set: impl Fn(usize) -> Vec<String>, order: f64, speed: f64) -> [f64; 3] {
    let cells = [16, 32, 64];
    let found = cells.map(|n| {
        let set = set(n);
        at_rest(n, &set.iter().map(String::as_str).collect::<Vec<_>>())
    });
    let jumps = found.map(|f| f[1]);
    println!("{what}: errors of the jump {:.1e} {:.1e} {:.1e}", jumps[0], jumps[1], jumps[2]);
    let sizes = cells.map(|n| 1.0 / n as f64);
    Study { what, sizes: &sizes, errors: found.map(|f| f[0]).to_vec() }
        .assert_at_least(order, speed);
    jumps
}

/// A scheme over a band of `width` edges.
fn banded(scheme: &'static str, width: f64) -> impl Fn(usize) -> Vec<String> {
    move |n| {
        vec![
            format!("numerics.surface_tension=\"{scheme}\""),
            format!("numerics.thickness={}", width / n as f64),
        ]
    }
}

#[test]
fn currents_and_pressure_of_a_drop_at_rest() {
    let sharp = study("Static drop, sharp", |_| vec![], 1.5, 6e-5);
    assert!(sharp[1] < 2e-4 && sharp[2] < 1e-5, "{sharp:?}");
    let thin = study("Static drop, stress over 1.5 edges", banded("lafaurie1994", 1.5), 0.5, 4e-4);
    let thick = study("Static drop, stress over 3 edges", banded("lafaurie1994", 3.0), 1.2, 4e-5);
    let csf = study(
        "Static drop, continuum force over 3 edges",
        banded("brackbill1992", 3.0),
        1.9,
        1.9e-4,
    );
    // The jump is wrong by the thickness, and the pressure of the sharp force is the best.
    assert!(
        thin[2] < 2e-3 && thick[2] < 7e-3 && csf[2] < 7e-3 && sharp[2] < thin[2],
        "{thin:?} {thick:?} {csf:?}"
    );
}

/// Without grad-div the sharp force is worse than any band; with it, P1+P0 does not pay.
#[test]
fn grad_div_makes_the_sharp_force_useful() {
    let none = "numerics.grad_div=0";
    let constants = "numerics.pressure=\"P1+P0\"";
    let [with, without] = [at_rest(32, &[]), at_rest(32, &[none])].map(|f| f[0]);
    let [more, alone] = [at_rest(32, &[constants]), at_rest(32, &[constants, none])].map(|f| f[0]);
    println!(
        "Static drop, sharp, 32 squares: P1 {with:.2e}, without grad-div {without:.2e}; P1+P0 \
         {more:.2e}, {alone:.2e}"
    );
    assert!(
        without > 40.0 * with
            && alone > 20.0 * more
            && alone < 0.6 * without
            && (0.8..1.0).contains(&(more / with))
    );
}
