//! Elastic waves: the largest explicit step (1.54) for any density, and steps too long to follow a
//! wave.

use super::case::Case;
use super::program::*;
use immersa::scene::{ImmersedFlow, Problem};

/// A stretched ellipse whose force is explicit.
const ELLIPSE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [20, 20] }
[fluid]
density = 0.001
viscosity = 1e-4
[[membrane]]
shape.ellipse = { centre = [1, 1], semi_axes = [0.6, 0.4] }
stretch = 1.2
area.linear = { modulus = 1.0 }
force = "smeared"
[time]
end = 0.2
step = 0.002
[numerics]
coupling = "explicit"
thickness = 0.15
[output]
fields = false
pictures = false
checkpoint = false
"#;

/// A stiff ellipse in a single step.
const STIFF: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [24, 24], diagonals = "union-jack" }
[fluid]
viscosity = 0.01
density = 1
[[membrane]]
name = "m"
shape.ellipse = { centre = [1, 1], semi_axes = [0.75, 0.5] }
stretch = 1.2625316
area.linear = { modulus = 10 }
force = "sharp"
[time]
end = 0.4
step = 0.4
[output]
pictures = false
fields = false
"#;

fn ellipse(set: &[&str]) -> Case {
    Case::with(ELLIPSE, set)
}

/// Whether 60 steps of this length neither fail nor win energy.
fn is_stable(set: &[&str], dt: f64) -> bool {
    let time = [format!("time.step={dt}"), format!("time.end={}", 60.0 * dt)];
    let all: Vec<&str> = set.iter().copied().chain(time.iter().map(String::as_str)).collect();
    let mut case = ellipse(&all);
    let allowed = 1.02 * case.model.simulation.state().energies.total();
    (0..60).all(|_| {
        case.model.step().is_ok() && case.model.simulation.state().energies.total() < allowed
    })
}

/// A light fluid, a heavy one, Stokes flow, and two fluids: the largest stable steps by `immersa
/// study stability` are 1.21 to 1.96 of the formula. In steps of order 2 viscosity counts half.
#[test]
fn the_explicit_limit_holds_for_light_and_heavy_fluids_and_without_inertia() {
    let heavy = ["fluid.density=1000", "fluid.viscosity=0.1"];
    let stokes = ["fluid.density=0", "fluid.viscosity=1e-3"];
    let two = ["fluid.density={inside=1, outside=0.01}"];
    for (fluid, limits) in [
        (&[][..], [5.257e-4, 4.909e-4]),
        (&heavy, [0.5257, 0.4909]),
        (&stokes, [1.2604e-3, 6.302e-4]),
        (&two, [4.617e-3, 4.615e-3]),
    ] {
        for (order, expected) in [1, 2].into_iter().zip(limits) {
            let order = format!("time.order={order}");
            let set: Vec<&str> = fluid.iter().copied().chain([order.as_str()]).collect();
            let limit = ellipse(&set).model.explicit_limit.unwrap();
            assert!((limit / expected - 1.0).abs() < 0.01, "{set:?}: {limit}");
            assert!(is_stable(&set, limit), "{set:?}: unstable at the limit");
            assert!(!is_stable(&set, 2.1 * limit), "{set:?}: stable at 2.1 of the limit");
        }
    }
}

/// Multiples of powers of two, which change no digits: of length, time and mass.
#[test]
fn the_step_over_its_limit_has_no_units() {
    let over_limit = |[length, time, mass]: [f64; 3]| {
        let set = [
            format!("mesh.rectangle.max=[{0}, {0}]", 2.0 * length),
            format!("fluid.density={}", 1e-3 * mass / length.powi(3)),
            format!("fluid.viscosity={}", 1e-4 * mass / (length * time)),
            format!("membrane.0.shape.ellipse.centre=[{length}, {length}]"),
            format!("membrane.0.shape.ellipse.semi_axes=[{}, {}]", 0.6 * length, 0.4 * length),
            format!("membrane.0.area.linear.modulus={}", mass / (time * time)),
            format!("numerics.thickness={}", 0.15 * length),
            format!("time.step={}", 4e-4 * time),
            format!("time.end={}", 4e-3 * time),
        ];
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let case = ellipse(&set);
        let mut all = vec![case.get("step_over_limit")];
        all.push(case.run().get("step_over_limit"));
        all
    };
    let plain = over_limit([1.0; 3]);
    assert!((plain[0] / 0.8148 - 1.0).abs() < 1e-3, "{plain:?}");
    for units in [[8.0, 1.0, 1.0], [1.0, 0.25, 1.0], [1.0, 1.0, 64.0], [0.125, 4.0, 0.5]] {
        for (other, plain) in over_limit(units).iter().zip(&plain) {
            assert!((other / plain - 1.0).abs() < 1e-9, "{units:?}: {other}, {plain}");
        }
    }
}

/// At rest there is no tension yet: the plan tells that, and the limit at a stretch of 10 %, which
/// is that of a membrane with this stretch.
#[test]
fn at_rest_the_plan_estimates_the_limit_that_a_stretch_will_bring() {
    let folder = folder_with(ELLIPSE);
    let explain = |stretch: &str| {
        let set = ["membrane.0.force=sharp", stretch].into_iter().flat_map(|s| ["--set", s]);
        let arguments: Vec<&str> = ["explain", "scene.toml"].into_iter().chain(set).collect();
        let ended = immersa(folder.path(), &arguments);
        ended.expect(0, &[]);
        ended.stdout
    };
    let rest = explain("membrane.0.stretch=1");
    let lines = [
        "explicit step limit (1.54): none at the start, no tension yet",
        "explicit step limit (1.54) at a stretch of 10 %: 6.295e-4; the step is 3.18 of it",
        "the explicit coupling will be unstable",
    ];
    assert!(lines.iter().all(|line| rest.contains(line)), "{rest}");
    let stretched = explain("membrane.0.stretch=1.1");
    assert!(stretched.contains("limit (1.54) at the start: 6.295e-4; the step"), "{stretched}");
    let more = explain("membrane.0.stretch=1.2");
    assert!(!more.contains("at a stretch of") && !more.contains("no tension"), "{more}");
}

/// The wave of an ellipse of area `pi 0.375` under the tension 10 (r - 1): `2 pi / sqrt(3 lambda /
/// R^3 - (3 mu / R^2)^2)` is 1.07.
#[test]
fn a_step_too_long_for_the_elastic_wave_is_told_before_and_after() {
    let case = Case::new(STIFF);
    let [wave] = &case.model.waves()[..] else { panic!("{:?}", case.model.waves()) };
    assert!(wave.name == "m" && (wave.period / 1.07 - 1.0).abs() < 0.03, "{wave:?}");
    let folder = folder_with(STIFF);
    let run = |set: &[&str]| {
        let set = set.iter().flat_map(|s| ["--set", *s]);
        let arguments: Vec<&str> =
            ["run", "scene.toml", "--out", "run"].into_iter().chain(set).collect();
        let _ = std::fs::remove_dir_all(folder.path().join("run"));
        immersa(folder.path(), &arguments)
    };
    let words = |list: &serde_json::Value| {
        list.as_array().unwrap().iter().map(|w| w.as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    for (modulus, of_period) in [("10", "0.373"), ("1000", "3.73")] {
        let ended = run(&[&format!("membrane.0.area.linear.modulus={modulus}")]);
        let told = format!("a step of 0.4 is {of_period} of the period");
        ended.expect(0, &[&format!("warning: {told}"), &format!("ALARM: Elastic wave: {told}")]);
        let summary = summary(&folder.path().join("run"));
        let (warnings, alarms) = (words(&summary["warnings"]), words(&summary["alarms"]));
        assert!(warnings.len() == 1 && warnings[0].contains(&told), "{warnings:?}");
        let tells = |a: &String| a.contains(&told) && a.contains("the energy balance is off by");
        assert!(alarms.iter().any(tells), "{alarms:?}");
        let page = std::fs::read_to_string(folder.path().join("run/report.html")).unwrap();
        assert!(page.contains(&told), "the report does not tell");
    }
    let explicit = run(&["numerics.coupling=explicit"]);
    explicit.expect(0, &["give time.step <= 0.0029", "ALARM: Energy", "ALARM: Elastic wave"]);
    // Eleven steps of a period.
    let ended = run(&["time.step=0.1"]);
    ended.expect(0, &[]);
    assert!(!ended.stderr.contains("of the period"), "{}", ended.stderr);
}

/// Steps that follow the error resolve the waves; where viscosity leaves no wave there is none to
/// follow; a passive interface has none.
#[test]
fn there_is_no_wave_to_lose_without_inertia_or_tension() {
    for set in [
        &["time.tolerance=0.1"][..],
        &["fluid.density=0"],
        &["fluid.viscosity=10"],
        &["membrane.0.stretch=1"],
    ] {
        let case: Case<ImmersedFlow> = Case::with(STIFF, set);
        assert!(case.model.waves().is_empty() && case.model.warnings().is_empty(), "{set:?}");
    }
}
