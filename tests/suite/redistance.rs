//! Scenes that redistance their level sets.

use super::case::{Built, Case, refused};
use immersa::levelset::Contour;
use immersa::scene::{Advected, ImmersedFlow, Problem, Scene};
use std::path::Path;

const METHODS: [&str; 3] = ["hamilton-jacobi", "fast-marching", "exact"];

const VORTEX: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [1, 1], cells = [16, 16] }
[fluid]
prescribed_velocity = ["-sin(pi*x)^2*sin(2*pi*y)", "sin(2*pi*x)*sin(pi*y)^2"]
[[level_set]]
name = "disc"
shape.circle = { centre = [0.5, 0.75], radius = 0.15 }
[time]
end = 1.0
step = 0.0625
[numerics.redistance]
method = "exact"
"#;

/// A drop of constant tension, its level set twice the distance, beside a dye.
const DROP: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }
[fluid]
viscosity = 0.05
[[membrane]]
shape.ellipse = { centre = [1, 1], semi_axes = [0.6, 0.45] }
stretch = 2.0
area.tension = { tension = 1.0 }
[[level_set]]
name = "dye"
shape.circle = { centre = [0.5, 0.5], radius = 0.2 }
[time]
end = 0.4
step = 0.02
[numerics]
thickness = 0.2
[numerics.redistance]
method = "exact"
every = 4
"#;

/// Mean slope on the interface of level set number `k`, and its root mean square deviation from the
/// mean.
fn slope<P: Built>(case: &Case<P>, k: usize) -> [f64; 2] {
    let (space, phi) = (case.model.space(), case.model.level_set(k));
    let contour = Contour::new(space, &phi).unwrap();
    let gradient = |c: u32, l: &[f64; 4]| space.gradient(&phi, c as usize, l).norm();
    let mean = contour.integrate(space, &phi, |c, l, _| gradient(c, l)) / contour.perimeter();
    let square = contour.integrate(space, &phi, |c, l, _| (gradient(c, l) - mean).powi(2))
        / contour.perimeter();
    [mean, square.sqrt()]
}

#[test]
fn the_slope_is_one_again_and_the_plan_says_so() {
    let without = {
        let text = VORTEX.split("[numerics").next().unwrap();
        slope(&Case::<Advected>::of(text, &[]).run(), 0)
    };
    assert!(without[1] > 0.3, "{without:?}");
    for method in METHODS {
        let mut case =
            Case::<Advected>::of(VORTEX, &[&format!("numerics.redistance.method={method}")]);
        let plan = case.model.plan().unwrap().to_string();
        assert!(
            plan.contains("level sets redistanced after every step")
                && !plan.contains("redistancing: the slope"),
            "{plan}"
        );
        let with = slope(&case.run(), 0);
        // The tip of the filament is thinner than a cell, and fast marching is of first order: its
        // slopes keep an error.
        assert!(
            (with[0] - 1.0).abs() < 0.2 && with[1] < 0.5 * without[1],
            "{method}: {with:?}, without {without:?}"
        );
    }
}

/// Between two redistancings transport alone acts; at one, what the cut interface encloses is what
/// it was.
#[test]
fn the_count_of_steps_decides_and_the_area_is_kept() {
    let set = ["numerics.redistance.every=4", "numerics.redistance.volume=true"];
    let mut with = Case::<Advected>::of(VORTEX, &set);
    let mut without = Case::<Advected>::of(VORTEX.split("[numerics").next().unwrap(), &[]);
    with.steps(3);
    without.steps(3);
    assert_eq!(with.model.level_set(0), without.model.level_set(0));
    with.steps(1);
    without.steps(1);
    let [a, b] = [&with, &without].map(|c| c.get("disc.area"));
    assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    assert!(with.model.level_set(0) != without.model.level_set(0));
}

#[test]
fn a_resumed_run_goes_on_with_the_same_bits() {
    fn check<P: Built>(text: &str, every: &str, half: usize) {
        for method in METHODS {
            let set = [every, &format!("numerics.redistance.method={method}")];
            let mut whole = Case::<P>::of(text, &set);
            whole.steps(half);
            let bytes = whole.bytes();
            whole.steps(half);
            let mut resumed = Case::<P>::of(text, &set);
            resumed.resume(&bytes);
            resumed.steps(half);
            assert!(whole.bytes() == resumed.bytes(), "{set:?}");
        }
    }
    check::<Advected>(VORTEX, "numerics.redistance.every=3", 8);
    check::<ImmersedFlow>(DROP, "numerics.redistance.every=4", 6);
}

#[test]
fn a_drop_keeps_the_slope_of_its_start() {
    let case = Case::new(DROP).run();
    let (drop, dye) = (slope(&case, 0), slope(&case, 1));
    assert!((drop[0] - 2.0).abs() < 0.02 && drop[1] < 0.1, "{drop:?}");
    assert!((dye[0] - 1.0).abs() < 0.01 && dye[1] < 0.05, "{dye:?}");
    let area = std::f64::consts::PI * 0.6 * 0.45;
    assert!((case.get("membrane.area") / area - 1.0).abs() < 2e-3, "{}", case.get("membrane.area"));
}

#[test]
fn a_ball_in_space_is_redistanced() {
    let text = r#"
        [mesh]
        box = { min = [0, 0, 0], max = [1, 1, 1], cells = [6, 6, 6] }
        [fluid]
        prescribed_velocity = ["x - 0.5", "0.5 - y", "0"]
        [[level_set]]
        name = "ball"
        shape.sphere = { centre = [0.5, 0.5, 0.5], radius = 0.25 }
        [time]
        end = 0.2
        step = 0.05
        [numerics.redistance]
        method = "exact"
        volume = true
    "#;
    for method in METHODS {
        let set = [format!("numerics.redistance.method={method}")];
        let scene = Scene::parse_with(text, Path::new("scene.toml"), &set).unwrap();
        let mut model = Advected::<3>::new(&scene).unwrap();
        for _ in 0..4 {
            model.advection.step().unwrap();
        }
        let (space, phi) = (model.advection.space(), model.advection.level_set(0));
        let surface = immersa::levelset::Isosurface::new(space, &phi).unwrap();
        let slope = surface
            .integrate(space, &phi, |p| space.gradient(&phi, p.at.cell, &p.at.barycentric).norm());
        assert!((slope / surface.area() - 1.0).abs() < 0.1, "{method}: {}", slope / surface.area());
        let volume = surface.measures().unwrap().volume
            / (4.0 / 3.0 * std::f64::consts::PI * 0.25f64.powi(3));
        assert!((volume - 1.0).abs() < 0.02, "{method}: {volume}");
    }
}

#[test]
fn what_redistancing_would_destroy_is_refused() {
    let smeared = DROP.replace("stretch = 2.0", "force = \"smeared\"");
    for (text, set, word) in [
        (VORTEX, "numerics.transport=composed", "nodal"),
        (VORTEX, "numerics.redistance.iterations=3", "hamilton-jacobi"),
        (VORTEX, "numerics.redistance.every=0", "every"),
        (VORTEX, "numerics.redistance.method=sweeping", "exact"),
        (&smeared, "membrane.0.area={linear={modulus=1.0}}", "stretch"),
        (DROP, "membrane.0.mass=0.1", "mass"),
        (DROP, "time.tolerance=1e-2", "time.tolerance"),
    ] {
        let error = refused(text, &[set]);
        assert!(error.contains(word) && error.contains("redistance"), "{set}: {error}");
    }
    let (before, after) =
        (VORTEX.split("[[level_set]]").next().unwrap(), VORTEX.split("[time]").nth(1).unwrap());
    let alone = format!("{before}[time]{after}").replace(
        "prescribed_velocity = [\"-sin(pi*x)^2*sin(2*pi*y)\", \"sin(2*pi*x)*sin(pi*y)^2\"]",
        "viscosity = 1",
    );
    assert!(refused(&alone, &[]).contains("no interface"));
}

#[test]
fn the_scene_writes_what_it_read() {
    for method in METHODS {
        let set = [
            format!("numerics.redistance.method={method}"),
            "numerics.redistance.volume=true".to_string(),
        ];
        let scene = Scene::parse_with(DROP, Path::new("scene.toml"), &set).unwrap();
        let again = Scene::parse(&scene.to_toml(), Path::new("scene.toml")).unwrap();
        assert_eq!(scene.numerics, again.numerics);
        assert!(scene.numerics.redistance.is_some_and(|r| r.volume && r.every == Some(4)));
    }
}
