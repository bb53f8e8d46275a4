//! Shapes at periodic sides.

use immersa::scene::{Problem, Scene, problem};
use std::f64::consts::PI;
use std::path::Path;

fn scene(mesh: &str, pairs: &str, shape: &str) -> Scene {
    let velocity = if mesh.starts_with("box") { "[0, 0, 0]" } else { "[0, 0]" };
    let text = format!(
        "mesh.{mesh}\nfluid.prescribed_velocity = {velocity}\n{pairs}\n\
         time = {{ end = 1, step = 1 }}\n[[level_set]]\nname = \"a\"\n{shape}"
    );
    Scene::parse_with(&text, Path::new("scene.toml"), &[]).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn built(scene: &Scene) -> Box<dyn Problem> {
    problem(scene).unwrap_or_else(|e| panic!("{e}"))
}

fn square(cells: usize) -> String {
    format!("rectangle = {{ min = [0, 0], max = [1, 1], cells = [{cells}, {cells}] }}")
}

const SIDES: &str = "boundary.left.periodic = \"right\"";
/// Length of the wave `0.1 sin(2 pi x)`.
const WAVE: f64 = 1.092_383_6;

/// Whether its zero set passes through points of the mesh or beside them.
#[test]
fn a_wave_through_periodic_sides_has_its_area_and_length() {
    for height in [0.5, 0.5137] {
        for (cells, tolerance) in [(20, 2e-5), (40, 2e-6)] {
            let shape = format!("shape.expression = \"y - {height} - 0.1*sin(2*pi*x)\"");
            let row = built(&scene(&square(cells), SIDES, &shape)).row().unwrap();
            let [area, length] = ["a.area", "a.perimeter"].map(|c| row.get(c).unwrap());
            assert!((area - height).abs() < tolerance, "{area}");
            assert!((length - WAVE).abs() < 10.0 * tolerance, "{length}");
        }
    }
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1], cells = [8, 8, 8] }";
    let shape = "shape.expression = \"y - 0.5 - 0.1*sin(2*pi*x)\"";
    for pairs in [SIDES.to_string(), format!("{SIDES}\nboundary.back.periodic = \"front\"")] {
        let row = built(&scene(cube, &pairs, shape)).row().unwrap();
        let [volume, surface] = ["a.volume", "a.surface"].map(|c| row.get(c).unwrap());
        assert!((volume - 0.5).abs() < 1e-3, "{volume}");
        assert!((surface - WAVE).abs() < 5e-3, "{surface}");
    }
}

/// A shape within one period is continued on the other side, also one that is periodic along the
/// other axis.
#[test]
fn shapes_that_cross_periodic_sides_are_whole() {
    let both = format!("{SIDES}\nboundary.bottom.periodic = \"top\"");
    let disc = "shape.expression = \"hypot(x-0.05, y-0.9) - 0.2\"";
    let row = built(&scene(&square(24), &both, disc)).row().unwrap();
    assert!((row.get("a.area").unwrap() - 0.04 * PI).abs() < 1e-4);
    let strip = "shape.expression = \"abs(y - 0.05 - 0.02*sin(2*pi*x)) - 0.15\"";
    let row = built(&scene(&square(24), &both, strip)).row().unwrap();
    assert!((row.get("a.area").unwrap() - 0.3).abs() < 1e-3, "{:?}", row.get("a.area"));
}

#[test]
fn a_shape_that_is_not_periodic_is_refused() {
    for (mesh, slope) in [
        (square(20), "y - 0.4 - 0.2*x"),
        ("box = { min = [0, 0, 0], max = [1, 1, 1], cells = [4, 4, 4] }".into(), "y - 0.4 - 0.2*x"),
        (square(20), "hypot(x - 1.6, y - 0.5) - 0.7"),
    ] {
        let shape = format!("shape.expression = \"{slope}\"");
        let refused = problem(&scene(&mesh, SIDES, &shape)).map(drop).unwrap_err();
        for word in ["not the same on both periodic sides", "scene.toml:", "period of the domain"] {
            assert!(refused.to_string().contains(word), "{refused}");
        }
    }
}
