//! Delta functions, curvatures and curves between interfaces, as a scene asks for them.

use super::program::*;
use std::f64::consts::PI;
use std::path::Path;

fn last(run: &Path, column: &str) -> f64 {
    *series(run).column(column).unwrap().last().unwrap()
}

const PLANE: &str = r#"
[mesh]
rectangle = { min = [-1, -1], max = [1, 1], cells = [24, 24] }
[fluid]
prescribed_velocity = [0.2, 0]
[[level_set]]
name = "disc"
shape.circle = { centre = [0.03, -0.02], radius = 0.6 }
[time]
end = 0.1
step = 0.05
[output]
deltas = ["smereka1", "smereka2", "towers", "smeared"]
curvature = true
fields = 0.1
pictures = false
"#;

#[test]
fn a_level_set_is_measured_by_every_delta_function_that_is_asked_for() {
    let folder = folder_with(PLANE);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run", "--quiet"]).expect(0, &[]);
    let run = folder.path().join("run");
    for (column, exact, tolerance) in [
        ("perimeter_smereka1", 1.2 * PI, 2e-3),
        ("perimeter_smereka2", 1.2 * PI, 2e-4),
        ("perimeter_towers", 1.2 * PI, 2e-3),
        ("area_towers", 0.36 * PI, 4e-3),
        ("perimeter_smeared", 1.2 * PI, 2e-4),
        ("area_smeared", 0.36 * PI, 2e-2),
        ("curvature_min", 1.0 / 0.6, 2e-2),
        ("curvature_max", 1.0 / 0.6, 2e-2),
        ("curvature_mean", 1.0 / 0.6, 5e-3),
    ] {
        let found = last(&run, &format!("disc.{column}"));
        assert!((found / exact - 1.0).abs() < tolerance, "{column}: {found} {exact}");
    }
    for absent in ["disc.area_smereka1", "disc.gauss_curvature_min", "disc.perimeter_cut"] {
        assert!(series(&run).column(absent).is_err(), "{absent}");
    }
    let resolved = std::fs::read_to_string(run.join("scene.toml")).unwrap();
    assert!(
        resolved.contains(r#"deltas = ["smereka1", "smereka2", "towers", "smeared"]"#),
        "{resolved}"
    );
    let fields = std::fs::read(run.join("fields/000002.vtu")).unwrap();
    assert!(fields.windows(16).any(|w| w == b"\"disc.curvature\""));
}

const SPACE: &str = r#"
[mesh]
box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [10, 10, 10] }
[fluid]
viscosity = 1
[[membrane]]
name = "ball"
shape.sphere = { centre = [0, 0, 0], radius = 0.45 }
area.linear = { modulus = 0.1 }
[[level_set]]
name = "other"
shape.sphere = { centre = [0, 0, 0.4], radius = 0.45 }
[time]
end = 0.01
step = 0.01
[numerics]
thickness = 0.3
kernel = "hat"
width = "l1"
[output]
deltas = ["smereka2", "smeared"]
curvature = true
curves.ring = { of = ["other", "ball"] }
fields = false
pictures = false
"#;

/// Radius of the circle in which the spheres meet: `sqrt(.45^2 - .2^2)`.
const RING: f64 = 0.403_112_887_414_927_5;

#[test]
fn in_space_there_are_gauss_curvatures_and_curves() {
    let folder = folder_with(SPACE);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run", "--quiet"]).expect(0, &[]);
    let run = folder.path().join("run");
    for (column, exact, tolerance) in [
        ("ball.surface_smereka2", 0.81 * PI, 0.02),
        ("ball.surface_smeared", 0.81 * PI, 0.2),
        ("ball.curvature_mean", 2.0 / 0.45, 0.1),
        ("ball.gauss_curvature_mean", 1.0 / 0.2025, 0.2),
        ("ring_length", 2.0 * PI * RING, 0.01),
        ("ring_curvature_mean", 1.0 / RING, 0.05),
        ("ring_curvature_max", 1.0 / RING, 0.2),
    ] {
        let found = last(&run, column);
        assert!((found / exact - 1.0).abs() < tolerance, "{column}: {found} {exact}");
    }
    assert!(
        last(&run, "other.curvature_mean") > 4.0 && last(&run, "ring_torsion_mean").abs() < 0.2
    );
}

/// With the hat and the l1 norm the energy is that of a band whose weight is the perimeter, too,
/// and the run differs from the default.
#[test]
fn the_band_of_a_membrane_has_the_cut_off_function_and_the_norm_of_the_scene() {
    let scene = r#"
[mesh]
rectangle = { min = [-1, -1], max = [1, 1], cells = [20, 20] }
[fluid]
viscosity = 0.1
[[membrane]]
shape.ellipse = { centre = [0, 0], semi_axes = [0.6, 0.4], angle = 30 }
area.tension = { tension = 1 }
[time]
end = 0.02
step = 0.02
[numerics]
band = "renormalised"
thickness = 0.2
[output]
fields = false
pictures = false
"#;
    let mut energies = Vec::new();
    for (kernel, width) in [("cosine", "l2"), ("cosine", "l1"), ("hat", "l2"), ("hat", "l1")] {
        let folder =
            folder_with(&scene.replace(
                "[output]",
                &format!("kernel = \"{kernel}\"\nwidth = \"{width}\"\n[output]"),
            ));
        immersa(folder.path(), &["run", "scene.toml", "--out", "run", "--quiet"]).expect(0, &[]);
        let run = folder.path().join("run");
        let (energy, length) = (
            series(&run).column("energy_elastic").unwrap()[0],
            series(&run).column("membrane.perimeter").unwrap()[0],
        );
        assert!((energy / length - 1.0).abs() < 5e-3, "{kernel} {width}: {energy} {length}");
        assert!(last(&run, "energy_elastic") < energy);
        energies.push(last(&run, "energy_elastic"));
    }
    assert!((0..4).all(|i| (0..i).all(|j| energies[i] != energies[j])), "{energies:?}");
    // Without a word the first of them, to the last bit.
    let folder = folder_with(scene);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run", "--quiet"]).expect(0, &[]);
    assert_eq!(last(&folder.path().join("run"), "energy_elastic"), energies[0]);
}

#[test]
fn what_cannot_be_measured_is_refused_with_a_remedy() {
    let wrong = |scene: &str, from: &str, to: &str, needles: &[&str]| {
        assert!(scene.contains(from), "{from}");
        let folder = folder_with(&scene.replace(from, to));
        immersa(folder.path(), &["explain", "scene.toml"]).expect(2, needles);
    };
    wrong(PLANE, "\"towers\"", "\"tower\"", &["`tower` is not a value", "towers"]);
    wrong(PLANE, "\"towers\"", "\"smereka1\"", &["twice"]);
    wrong(
        PLANE,
        "curvature = true",
        "curves.a = { of = [\"disc\", \"disc\"] }",
        &["plane", "leave output.curves out"],
    );
    wrong(
        SPACE,
        "\"other\", \"ball\"",
        "\"other\", \"drop\"",
        &["no interface `drop`", "ball, other"],
    );
    wrong(SPACE, "\"other\", \"ball\"", "\"other\", \"other\"", &["two interfaces that differ"]);
    wrong(SPACE, "curves.ring", "curves.ball", &["`ball` is taken"]);
    wrong(SPACE, "\"hat\"", "\"cap\"", &["`cap` is not a value", "hat"]);
    wrong(SPACE, "\"l1\"", "1", &["numerics", "width"]);
}
