//! Alarms and warnings about runs whose results mean nothing, and none about those that are right.

use super::program::*;
use immersa::output::Series;
use std::f64::consts::PI;
use std::path::Path;

/// A scene without files but the series.
fn scene(mesh: &str, fluid: &str, rest: &str) -> String {
    format!(
        "output = {{ fields = false, pictures = false, checkpoint = false }}\nmesh.{mesh}\n\
         [fluid]\n{fluid}\n{rest}\n"
    )
}

fn square(cells: usize) -> String {
    format!("rectangle = {{ min = [0, 0], max = [1, 1], cells = [{cells}, {cells}] }}")
}

/// What the program says about a scene that it runs to the end: its warnings and alarms.
#[track_caller]
fn said(scene: &str) -> String {
    let folder = folder_with(scene);
    let ended = immersa(folder.path(), &["run", "scene.toml", "--out", "run"]);
    ended.expect(0, &["done"]);
    let said = |l: &&str| l.starts_with("ALARM") || l.starts_with("warning");
    ended.stderr.lines().filter(said).collect::<Vec<_>>().join("\n")
}

#[track_caller]
fn assert_said(scene: &str, words: &[&str]) {
    let said = said(scene);
    assert!(!said.is_empty() && words.iter().all(|w| said.contains(w)), "{said}");
}

/// Nothing moves but by rounding, or all of the fluid together: energies are rounding errors, or
/// those of the first step alone.
#[test]
fn water_at_rest_and_water_that_moves_as_a_whole_raise_no_alarm() {
    let water = "density = 1000\nviscosity = 1e-3";
    let heavy = format!("{water}\ngravity = [0, -9.81]");
    let time = "[time]\nend = 1\nstep = 0.1";
    for n in [3, 7, 12] {
        assert_eq!(said(&scene(&square(n), &heavy, time)), "");
    }
    let pushed = format!("{water}\nforce = [3, 0]");
    assert_eq!(said(&scene(&square(7), &pushed, time)), "");
    let carried = format!("[boundary.walls]\nvelocity = [\"3*t\", 0]\n{time}");
    assert_eq!(said(&scene(&square(7), water, &carried)), "");
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1], cells = [3, 3, 3] }";
    let heavy = format!("{water}\ngravity = [0, 0, -9.81]");
    assert_eq!(said(&scene(cube, &heavy, "[time]\nend = 0.3\nstep = 0.1")), "");
}

/// Vortices that turn once in a few steps lose most of their energy in them, and little in steps as
/// short as the alarm asks for. A lid that sets water in motion takes energy in the first step.
#[test]
fn energy_that_vanishes_without_viscosity_raises_the_alarm() {
    let vortices = |step: f64| {
        let start =
            "initial_velocity = [\"sin(6*pi*x)*cos(6*pi*y)\", \"-cos(6*pi*x)*sin(6*pi*y)\"]";
        let fluid = format!("viscosity = 1e-6\n{start}");
        let rest = format!(
            "[boundary.walls]\nslip = true\n[time]\nend = 0.2\nstep = {step}\n[numerics]\n\
             convection = \"pironneau1982\"\n"
        );
        scene(&square(36), &fluid, &rest)
    };
    assert_said(&vortices(0.05), &["Energy balance", "vanished", "smaller time.step"]);
    let short = said(&vortices(0.0125));
    assert!(short.starts_with("warning: the Reynolds number of a cell"), "{short}");
    assert!(!short.contains("ALARM"), "{short}");
    let lid = "[boundary.walls]\nno_slip = true\n[boundary.top]\nvelocity = [\"x*(1-x)\", 0]\n\
               [time]\nend = 0.1\nstep = 0.05\n";
    assert_eq!(said(&scene(&square(8), "viscosity = 0.01", lid)), "");
}

#[test]
fn an_initial_velocity_that_does_not_fit_is_told() {
    let time = "[time]\nend = 0.02\nstep = 0.01\n";
    let plane = |velocity: &str, walls: &str| {
        let fluid = format!("viscosity = 0.01\ninitial_velocity = {velocity}");
        scene(&square(8), &fluid, &format!("{walls}\n{time}"))
    };
    let open = "[boundary.walls]\nopen = true";
    let divergent = plane("[\"x\", \"y\"]", open);
    let word = "warning: the initial velocity is not free of divergence: div u = 2.000";
    assert_said(&divergent, &[word, "fluid.initial_velocity"]);
    let explained = immersa(folder_with(&divergent).path(), &["explain", "scene.toml"]);
    assert!(explained.stdout.contains(word), "{}", explained.stdout);
    let through = "goes through boundary `walls`";
    for wall in ["no_slip = true", "slip = true", "velocity = [0, 1]"] {
        let walls = format!("[boundary.walls]\n{wall}");
        assert_said(&plane("[1, 1]", &walls), &[through, "boundary.walls"]);
    }
    let left = "[boundary.left]\nperiodic = \"right\"";
    let periodic = format!("{left}\n{open}");
    assert_said(&plane("[\"-y\", \"x\"]", &periodic), &["is not periodic", "differs by 1.000"]);
    // What fits: along the walls, constants of four digits, swirl in a round domain.
    let [slip, no_slip] = ["slip", "no_slip"].map(|w| format!("[boundary.walls]\n{w} = true"));
    let waves = "[\"sin(3.142*x)*cos(3.142*y)\", \"-cos(3.142*x)*sin(3.142*y)\"]";
    let stream = "[boundary.left]\nvelocity = [1, 0]\n[boundary.right]\nopen = true";
    for (velocity, walls) in [
        ("[\"y*(1-y)\", 0]", format!("{left}\n{no_slip}")),
        (waves, slip.clone()),
        ("[1, 0]", format!("{slip}\n{stream}")),
    ] {
        assert_eq!(said(&plane(velocity, &walls)), "");
    }
    let disc = "disc = { centre = [0, 0], radius = 1, cells = 6 }";
    let swirl = "viscosity = 0.01\ninitial_velocity = [\"-y\", \"x\"]";
    assert_eq!(said(&scene(disc, swirl, &format!("{slip}\n{time}"))), "");
    // In space.
    let cube = "box = { min = [0, 0, 0], max = [1, 1, 1], cells = [2, 2, 2] }";
    let swirl = |z: &str| format!("viscosity = 0.01\ninitial_velocity = [\"-y\", \"x\", {z}]");
    let rest = format!("{open}\n{time}");
    assert_said(&scene(cube, &swirl("\"z\""), &rest), &["div u = 1.000"]);
    let fits = said(&scene(cube, &swirl("1"), &rest));
    assert!(fits.starts_with("warning: fluid comes in") && fits.lines().count() == 1, "{fits}");
    let rest = format!("{slip}\n{time}");
    assert_said(&scene(cube, &swirl("1"), &rest), &[through]);
}

/// Zalesak's disc in a square, where fluid comes in: composed transport is refused there.
#[test]
fn the_advice_of_an_alarm_is_one_that_the_scene_takes() {
    let turn = "prescribed_velocity = [\"2*pi*(0.5-y)\", \"2*pi*(x-0.5)\"]";
    let slotted = "hypot(x-0.5,y-0.75)-0.15, min(min(0.025-abs(x-0.5), 2), 0.85-y)";
    let disc = |cells: usize| {
        let rest = format!(
            "[[level_set]]\nshape.expression = \"max({slotted})\"\n\
             [time]\nend = 0.5\nstep = 0.02"
        );
        scene(&square(cells), turn, &rest)
    };
    let told = said(&disc(24));
    assert!(told.contains("Take a finer mesh or ") && !told.contains("composed"), "{told}");
    assert_eq!(said(&disc(48)), "");
}

/// A drop in a uniform stream that leaves through an open side, with what is told at the end.
fn leaving(mesh: &str, [u, left, rest]: [&str; 3], shape: &str, more: &str) -> (String, Series) {
    let scene = format!(
        "output = {{ every = 0.05, fields = false, pictures = false, checkpoint = false }}\n\
         mesh.{mesh}\n[fluid]\nviscosity = 0.05\ninitial_velocity = {u}\n\
         [boundary.left]\nvelocity = {left}\n[boundary.right]\nopen = true\n\
         [boundary.walls]\nslip = true\n[[drop]]\nname = \"d\"\nshape.{shape}\n\
         tension = 1\n{more}\n{rest}\n"
    );
    let folder = folder_with(&scene);
    let ended = immersa(folder.path(), &["run", "scene.toml", "--out", "run"]);
    ended.expect(0, &["done"]);
    let alarms = ended.stderr.lines().filter(|l| l.starts_with("ALARM"));
    (alarms.collect::<Vec<_>>().join("\n"), series(&folder.path().join("run")))
}

/// Heavy or light, sharp or smeared: the stream carries it out as if it went on behind the side. Its
/// tension leaves with it, and nothing comes back.
#[test]
fn a_drop_leaves_through_an_open_side_and_does_not_come_back() {
    let mesh = "rectangle = { min = [0, 0], max = [2, 1], cells = [24, 12] }";
    let rest = "[numerics]\nthickness = 0.21\n[time]\nend = 1\nstep = 0.02";
    let circle = "circle = { centre = [1.4, 0.5], radius = 0.25 }";
    for more in ["density = 2", "density = 0.01", "density = 2\nforce = \"smeared\""] {
        let (alarms, series) = leaving(mesh, ["[1, 0]", "[1, 0]", rest], circle, more);
        assert_eq!(alarms, "", "{more}");
        let column = |name: &str| series.column(name).unwrap();
        let fastest = column("velocity_max").iter().copied().fold(0.0, f64::max);
        assert!(fastest < 1.03, "{more}: {fastest}");
        let balance = column("energy_balance").last().unwrap();
        assert!(balance.abs() < 2e-3, "{more}: {balance}");
        assert!(column("d.area").last().unwrap().is_nan(), "{more}");
        // Half of it has left when its centre would be at the side.
        let at = series.columns[0].iter().position(|t| (t - 0.6).abs() < 1e-9).unwrap();
        let half = column("d.area")[at] / column("d.area")[0];
        assert!((half - 0.5).abs() < 0.01, "{more}: {half}");
    }
}

#[test]
fn a_drop_leaves_a_box_through_an_open_side() {
    let mesh = "box = { min = [0, 0, 0], max = [1.5, 1, 1], cells = [9, 6, 6] }";
    let rest = "[time]\nend = 1.05\nstep = 0.05\norder = 1";
    let sphere = "sphere = { centre = [0.9, 0.5, 0.5], radius = 0.3 }";
    let (alarms, series) = leaving(mesh, ["[1, 0, 0]", "[1, 0, 0]", rest], sphere, "");
    assert_eq!(alarms, "");
    let fastest = series.column("velocity_max").unwrap().iter().copied().fold(0.0, f64::max);
    assert!(fastest < 1.1, "{fastest}");
    assert!(series.column("d.volume").unwrap().last().unwrap().is_nan());
}

/// Where a flow turns back while a drop leaves, fluid from outside comes in.
#[test]
fn what_comes_in_through_an_open_side_is_fluid_from_outside() {
    let mesh = "rectangle = { min = [0, 0], max = [2, 1], cells = [24, 12] }";
    let rest = "[numerics]\nthickness = 0.21\n[time]\nend = 1.2\nstep = 0.02";
    let circle = "circle = { centre = [1.5, 0.5], radius = 0.25 }";
    let (alarms, series) = leaving(mesh, ["[1, 0]", "[\"cos(pi*t)\", 0]", rest], circle, "");
    assert_eq!(alarms, "");
    // At t = 0.5 the centre is `d` before the side, and the cap behind it has gone for ever.
    let (r, d) = (0.25_f64, 0.5 - 1.0 / PI);
    let left = PI * r * r - (r * r * (d / r).acos() - d * (r * r - d * d).sqrt());
    let area = *series.column("d.area").unwrap().last().unwrap();
    assert!((area / left - 1.0).abs() < 0.01, "{area} {left}");
}

#[test]
fn an_inside_out_shape_is_refused() {
    let inside_out = "shape.expression = \"0.3 - hypot(x - 0.5, y - 0.5)\"";
    let time = "[time]\nend = 0.02\nstep = 0.01";
    let acting = scene(
        &square(16),
        "viscosity = 1",
        &format!("[[drop]]\ntension = 1\n{inside_out}\n{time}"),
    );
    let ended = immersa(folder_with(&acting).path(), &["run", "scene.toml"]);
    ended.expect(2, &["`drop` is inside out", "scene.toml:", "0.3 - hypot", "change the sign"]);
    let passive = scene(
        &square(16),
        "prescribed_velocity = [0, 0]",
        &format!("[[level_set]]\nname = \"a\"\n{inside_out}\n{time}"),
    );
    assert_said(&passive, &["warning: the shape of `a` is inside out"]);
}

#[test]
fn a_band_thicker_than_what_it_surrounds_is_told() {
    let drop = |radius: f64| {
        let rest = format!(
            "[[drop]]\nforce = \"smeared\"\ntension = 1\n\
             shape.circle = {{ centre = [0.5, 0.5], radius = {radius} }}\n\
             [numerics]\nthickness = 0.16\n[time]\nend = 0.02\nstep = 0.01"
        );
        scene(&square(16), "viscosity = 1", &rest)
    };
    assert_said(&drop(0.1), &["the band of `drop` is thicker", "inside 0.1", "thickness"]);
    assert_eq!(said(&drop(0.25)), "");
}

/// A stream carries a drop into the coarse part of a mesh, whose cells are as large as the drop.
#[test]
fn a_drop_that_comes_into_coarse_cells_is_told_when_it_does() {
    let drop = |force: &str| {
        let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gmsh/graded.msh");
        let rest = format!(
            "[boundary.left]\nvelocity = [1, 0]\n[boundary.right]\nopen = true\n\
             [boundary.walls]\nslip = true\n[[drop]]\nname = \"d\"\nforce = \"{force}\"\n\
             tension = 0.1\nshape.circle = {{ centre = [0.4, 0.5], radius = 0.15 }}\n\
             [numerics]\nthickness = 0.14\n[time]\nend = 1.6\nstep = 0.04\n"
        );
        let mesh = format!("file = \"{}\"", mesh.display());
        said(&scene(&mesh, "viscosity = 0.05\ninitial_velocity = [1, 0]", &rest))
    };
    let time = |told: &str| -> f64 {
        let after = told.rsplit("at t = ").next().unwrap_or_else(|| panic!("{told}"));
        after.split(". ").next().unwrap().parse().unwrap()
    };
    let smeared = drop("smeared");
    assert!(smeared.contains("The band of `d` is too thin for the mesh"), "{smeared}");
    assert!((0.1..0.5).contains(&time(&smeared)), "{smeared}");
    let sharp = drop("sharp");
    assert!(sharp.contains("`d`, of radius 0.1") && sharp.contains("is not resolved"), "{sharp}");
    assert!((0.7..1.5).contains(&time(&sharp)), "{sharp}");
}

/// A membrane at rest with a tail: one that the mesh resolves stays at rest without a word, of one
/// that is thinner than a cell the tail is told, and not only what it does to the energy.
#[test]
fn a_tail_thinner_than_the_mesh_is_told() {
    let tadpole = |half: f64| {
        let rest = format!(
            "[[membrane]]\nname = \"tadpole\"\narea.linear = {{ modulus = 1 }}\n\
             shape.union = [{{ circle = {{ centre = [0.35, 0.5], radius = 0.18 }} }}, \
             {{ ellipse = {{ centre = [0.6, 0.505], semi_axes = [0.25, {half}] }} }}]\n\
             [time]\nend = 0.02\nstep = 0.01"
        );
        said(&scene(&square(20), "density = 0\nviscosity = 1", &rest))
    };
    let thin = tadpole(0.015);
    assert!(thin.contains("`tadpole` has tips or folds that are thinner than the mesh"), "{thin}");
    assert_eq!(tadpole(0.06), "");
}

/// A structure that is at an open side exerts no force: at the start that is refused, later told.
#[test]
fn a_structure_at_an_open_side_is_told() {
    let membrane = |x: f64| {
        let rest = format!(
            "[boundary.walls]\nno_slip = true\n[boundary.left]\nvelocity = [\"y*(1-y)\", 0]\n[boundary.right]\nopen = true\n\
             [[membrane]]\nname = \"m\"\nstretch = 1.2\narea.linear = {{ modulus = 0.1 }}\n\
             shape.circle = {{ centre = [{x}, 0.5], radius = 0.2 }}\n\
             [time]\nend = 0.4\nstep = 0.02"
        );
        scene(
            "rectangle = { min = [0, 0], max = [2, 1], cells = [32, 16] }",
            "viscosity = 1\ninitial_velocity = [\"y*(1-y)\", 0]",
            &rest,
        )
    };
    let close = immersa(folder_with(&membrane(1.75)).path(), &["explain", "scene.toml"]);
    close.expect(2, &["`m` is at an open side", "membrane.0.shape", "move the shape away"]);
    let folder = folder_with(&membrane(1.65));
    let ended = immersa(folder.path(), &["run", "scene.toml", "--out", "run"]);
    ended.expect(0, &["warning: `m` leaves through an open side from t = 0.", "no force"]);
    let left = summary(&folder.path().join("run"))["leaves"]["m"].as_f64().unwrap();
    assert!((0.02..0.4).contains(&left), "{left}");
}

/// A drop that is carried out through a side of given velocity.
#[test]
fn a_drop_that_reaches_a_side_which_is_not_open_is_told_and_nothing_else() {
    let rest = "[boundary.walls]\nvelocity = [1, 0]\n[[drop]]\nname = \"d\"\ntension = 0.1\n\
        shape.circle = { centre = [0.6, 0.5], radius = 0.2 }\n[time]\nend = 0.4\nstep = 0.02";
    let text = scene(&square(16), "viscosity = 1\ninitial_velocity = [1, 0]", rest);
    let told = said(&text);
    assert!(told.contains("`d` reached the boundary at t = 0.2"), "{told}");
    assert!(told.contains("open") && !told.contains("grad_div"), "{told}");
}

/// A membrane that is pressed together has no bending stiffness to say how it wrinkles.
#[test]
fn a_membrane_under_compression_is_told() {
    let pressed = |law: &str| {
        let rest = format!(
            "[[membrane]]\nname = \"m\"\nstretch = 0.9\narea.{law} = {{ modulus = 1 }}\n\
             shape.circle = {{ centre = [0.5, 0.5], radius = 0.25 }}\n\
             [time]\nend = 0.02\nstep = 0.01"
        );
        said(&scene(&square(16), "density = 0\nviscosity = 1", &rest))
    };
    let told = pressed("linear");
    assert!(told.contains("`m` is compressed, to a stretch of 0.9"), "{told}");
    assert!(told.contains("area.one_sided"), "{told}");
    assert_eq!(pressed("one_sided"), "");
}

/// A jump of the concentration that nothing smooths overshoots.
#[test]
fn a_negative_concentration_is_told() {
    let rest = "[[drop]]\nname = \"d\"\ntension = 5\n\
        shape.circle = { centre = [0.5, 0.5], radius = 0.25 }\n\
        surfactant = { elasticity = 1, concentration = \"if(x > 0.5, 1, 1e-6)\" }\n\
        [time]\nend = 0.1\nstep = 0.01";
    let told = said(&scene(&square(16), "density = 0\nviscosity = 1", rest));
    assert!(told.contains("`d` has a negative concentration"), "{told}");
    assert!(told.contains("diffusivity"), "{told}");
}
