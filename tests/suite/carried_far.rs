//! Structures that a flow carries for long.

use crate::case::Case;
use immersa::scene::{Problem, Scene, problem};
use std::f64::consts::PI;
use std::path::Path;

/// A membrane in Couette flow that turns like the tread of a tank.
const TREADING: &str = "
    mesh.rectangle = { min = [0, 0], max = [2, 2], cells = [24, 24] }
    fluid = { density = 0, viscosity = 1 }
    boundary.right.periodic = \"left\"
    boundary.top.velocity = [1, 0]
    boundary.bottom.velocity = [-1, 0]
    time = { end = 6, step = 0.02 }
    numerics.thickness = 0.15
    [[membrane]]
    shape.ellipse = { centre = [1, 1], semi_axes = [0.6, 0.4] }
    force = \"sharp\"
    area.linear = { modulus = 20.0 }";

/// The steady state on finer meshes: half-axes .719 and .334, angle 21.2 degrees, energy .192.
#[test]
fn a_treading_membrane_becomes_steady_and_stays_so() {
    let mut case = Case::new(TREADING);
    let area = case.get("membrane.area");
    let steady = [
        ("membrane.axis_1", 0.719, 2e-3),
        ("membrane.axis_2", 0.3336, 2e-3),
        ("membrane.angle", 21.2, 0.3),
        ("energy_elastic", 0.192, 4e-3),
        ("energy_balance", 0.0, 5e-4),
    ];
    for steps in [180, 120] {
        case.steps(steps);
        for (column, value, within) in steady {
            let found = case.get(column);
            assert!((found - value).abs() < within, "{column} {found} after {steps} steps");
        }
    }
    let change = case.get("membrane.area") / area - 1.0;
    // Three turns of the walls: 1e-4 in each unit of shear at six edges a radius.
    assert!(change.abs() < 1e-3, "{change}");
}

/// What the redistancing interval is does not matter.
#[test]
fn the_interval_of_redistancing_does_not_show() {
    let end = |set: &[&str]| {
        let mut case = Case::with(TREADING, set);
        case.steps(100);
        case.get("membrane.axis_1") / case.get("membrane.axis_2")
    };
    let slope = "numerics.redistance={ method = 'exact', slope = 0.1 }";
    let [usual, often] = [&[][..], &[slope][..]].map(end);
    assert!((often / usual - 1.0).abs() < 1e-3, "{usual} {often}");
}

/// A sphere twisted by pi about its axis: the energy `1/2 int (Z2 - 1)^2 dA` at time 0 with
/// `Z2 - 1 = pi^2/2 (x^2 + y^2)^2/R^2` is known, and is what the fluid and its viscosity get.
#[test]
fn a_twisted_sphere_has_its_energy_and_gives_it_to_the_fluid() {
    let text = "mesh.box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [12, 12, 12] }
        fluid = { density = 1, viscosity = 0.05 }
        boundary.walls.no_slip = true
        time = { end = 0.1, step = 0.01 }
        [[membrane]]
        shape.sphere = { centre = [0, 0, 0], radius = 0.5 }
        force = \"sharp\"
        area.linear = { modulus = 1.0 }
        shear.linear = { modulus = 0.1 }
        map = [\"x*cos(pi*z) + y*sin(pi*z)\", \"-x*sin(pi*z) + y*cos(pi*z)\", \"z\"]";
    let mut sphere = problem(&Scene::parse(text, Path::new("scene.toml")).unwrap()).unwrap();
    let get = |p: &dyn Problem, column: &str| p.row().unwrap().get(column).unwrap();
    let exact = 0.1 * 0.5 * (PI * PI / 2.0).powi(2) * 0.5f64.powi(6) * 2.0 * PI * 768.0 / 945.0;
    let start = get(&*sphere, "energy_elastic");
    assert!((start / exact - 1.0).abs() < 0.02, "{start} {exact}");
    for _ in 0..10 {
        sphere.step().unwrap();
    }
    let [now, balance] = ["energy_elastic", "energy_balance"].map(|c| get(&*sphere, c));
    // The projection of the strain in ten steps, at three edges a radius.
    assert!(now < 0.8 * start && balance.abs() < 0.03, "{now} {start} {balance}");
    let volume = get(&*sphere, "membrane.volume") / (4.0 / 3.0 * PI * 0.125) - 1.0;
    assert!(volume.abs() < 2e-3, "{volume}");
}
