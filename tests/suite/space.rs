//! Scenes of three dimensions, through the program: they run, go on bit by bit, and wrong ones are
//! refused.

use super::program::*;
use immersa::output::{Series, Values, read_vtu};
use immersa::scene::Scene;
use std::fs;
use std::path::Path;

const CAVITY: &str = r#"title = "A cavity in space"
[mesh]
box = { min = [0, 0, 0], max = [1, 1, 1], cells = [3, 3, 3] }
[fluid]
viscosity = 0.1
gravity = [0, 0, -1]
[boundary.walls]
no_slip = true
[boundary.top]
velocity = ["16*x*(1-x)*z*(1-z)", 0, 0]
[time]
end = 0.06
step = 0.02
[output]
probes.middle = { at = [0.5, 0.5, 0.5], of = "velocity" }
forces.lid = { boundary = "top", about = [0.5, 0.5, 0.5] }
fluxes.left = { boundary = "left" }
[output.profiles]
line = { from = [0, 0.5, 0.5], to = [1, 0.5, 0.5], of = "velocity", points = 5 }
"#;

/// An ellipsoid that relaxes.
const MEMBRANE: &str = r#"title = "An ellipsoid that relaxes"
[mesh]
box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [6, 6, 6] }
[fluid]
viscosity = 0.1
[boundary.walls]
no_slip = true
[[membrane]]
shape.ellipsoid = { centre = [0, 0, 0], semi_axes = [0.48, 0.36, 0.36] }
stretch = 1.2
area.linear = { modulus = 1 }
[membrane.chords]
long = { through = [0, 0, 0], direction = [1, 0, 0] }
[time]
end = 0.06
step = 0.02
[numerics]
thickness = 0.5
[output]
fields = 0.02
pictures = false
checkpoint = 0
probes.p = { at = [0.5, 0.1, 0.2], of = "pressure" }
"#;

fn refused(scene: &str, words: &[&str]) {
    let folder = folder_with(scene);
    immersa(folder.path(), &["explain", "scene.toml"]).expect(2, words);
}

#[test]
fn a_cavity_in_space_runs_with_every_kind_of_output() {
    let folder = folder_with(CAVITY);
    let ended = immersa(folder.path(), &["run", "scene.toml", "--out", "run"]);
    ended.expect(0, &["162 tetrahedra", "done: 3 steps"]);
    assert!(!ended.stderr.contains("third dimension"), "{}", ended.stderr);
    let run = folder.path().join("run");
    let table = series(&run);
    let last = |name: &str| *table.column(name).unwrap().last().unwrap();
    // The middle flows back under the lid, and the flow is the same on both sides of the plane z =
    // 1/2.
    assert!(last("middle_x") < 0.0 && last("velocity_max") > 0.5, "{}", last("middle_x"));
    assert!(last("lid_x") < 0.0 && last("left").abs() < 1e-10);
    for column in ["lid_y", "lid_z", "lid_stress_z", "lid_moment_z", "lid_stress_moment_x"] {
        assert!(last(column).is_finite(), "{column}");
    }
    let profile = Series::read(&run.join("profiles/line.csv")).unwrap();
    assert_eq!(profile.names, ["distance", "x", "y", "z", "t=0.06_x", "t=0.06_y", "t=0.06_z"]);
    assert_eq!((profile.rows(), profile.column("z").unwrap()[3]), (5, 0.5));
    let snapshot = read_vtu::<3>(&run.join("fields/000003.vtu")).unwrap();
    assert_eq!(snapshot.space.mesh().cell_count(), 162);
    let speeds = snapshot.vector("velocity").unwrap().iter().map(|u| u.norm());
    assert_eq!(speeds.fold(0.0, f64::max), last("velocity_max"));
    let report = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(report.contains("on two planes through the middle") && report.contains("Probe middle"));
    assert!(run.join("pictures/000003.png").exists() && run.join("film.gif").exists());
}

#[test]
fn an_ellipsoid_relaxes_and_goes_on_bit_by_bit_after_an_interruption() {
    for force in ["smeared", "sharp"] {
        let folder = folder_with(
            &MEMBRANE.replace("stretch = 1.2", &format!("stretch = 1.2\nforce = \"{force}\"")),
        );
        let [whole, parts] = run_whole_and_in_parts(folder.path(), "done: 3 steps");
        has_relaxed(&whole);
        assert_same(&whole, &parts);
        let stretch = ["--set", "output.pictures=0.02", "--set", "output.picture.field=stretch"];
        immersa(folder.path(), &[&["render", "whole"], &stretch[..]].concat()).expect(0, &[]);
        assert!(whole.join("pictures/000003.png").exists());
        assert!(
            fs::read_to_string(whole.join("report.html")).unwrap().contains("The end, t = 0.06")
        );
    }
}

/// What the run of the ellipsoid has measured, and says.
fn has_relaxed(run: &Path) {
    let table = series(run);
    let ends = |name: &str| {
        let column = table.column(&format!("membrane.{name}")).unwrap();
        (column[0], column[column.len() - 1])
    };
    let exact = 4.0 / 3.0 * std::f64::consts::PI * 0.48 * 0.36 * 0.36;
    let ((first, last), (long, shorter)) = (ends("volume"), ends("axis_1"));
    assert!(
        (first / exact - 1.0).abs() < 0.01 && (last / first - 1.0).abs() < 1e-3,
        "{first} {last} {exact}"
    );
    assert!((long - 0.48).abs() < 0.01 && shorter < long, "{long} {shorter}");
    assert!(
        (ends("long").0 - 0.48).abs() < 1e-9 && (ends("extent_z").0 - 0.36).abs() < 1e-3,
        "{:?}",
        ends("long")
    );
    assert!((ends("axis_2").0 - ends("axis_3").0).abs() < 0.01 && ends("centre_z").0.abs() < 1e-4);
    let [elastic, kinetic] =
        ["energy_elastic", "energy_kinetic"].map(|name| table.column(name).unwrap());
    let total: Vec<f64> = elastic.iter().zip(kinetic).map(|(e, k)| e + k).collect();
    assert!(total.windows(2).all(|e| e[1] < e[0]) && kinetic[3] > 0.0, "{total:?}");
    assert!(summary(run)["balance"]["volume"]["membrane"].as_f64().unwrap().abs() < 1e-3);
    let report = fs::read_to_string(run.join("report.html")).unwrap();
    for text in [
        "Volume inside",
        "sphere of the same volume",
        "Change of the enclosed volume",
        "surface / area at rest",
    ] {
        assert!(report.contains(text), "`{text}` is not in the report");
    }
}

#[test]
fn a_mesh_file_says_its_dimension_and_a_missing_one_is_told() {
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/ball.msh");
    let file = CAVITY.replace(
        "box = { min = [0, 0, 0], max = [1, 1, 1], cells = [3, 3, 3] }",
        "file = \"ball.msh\"",
    );
    let file = file
        .split_once("[output]")
        .unwrap()
        .0
        .replace("[boundary.top]\nvelocity = [\"16*x*(1-x)*z*(1-z)\", 0, 0]\n", "");
    let folder = folder_with(&file);
    immersa(folder.path(), &["explain", "scene.toml"])
        .expect(3, &["ball.msh", "cannot be read", "mesh.file"]);
    fs::copy(mesh, folder.path().join("ball.msh")).unwrap();
    let ended = immersa(folder.path(), &["explain", "scene.toml"]);
    ended.expect(0, &[]);
    assert!(
        ended.stdout.contains("tetrahedra") && !ended.stdout.contains("third dimension"),
        "{}",
        ended.stdout
    );
    // Written out, the scene does not need the file to be read.
    let scene = Scene::load(&folder.path().join("scene.toml"), &[]).unwrap();
    let text = scene.to_toml();
    fs::remove_file(folder.path().join("ball.msh")).unwrap();
    assert_eq!(
        (scene.dimension(), Scene::parse(&text, Path::new("elsewhere/a.toml")).unwrap()),
        (3, scene)
    );
    refused(
        &CAVITY.replace("[mesh]", "[mesh]\ndimension = 3"),
        &["mesh.dimension", "for mesh files"],
    );
}

#[test]
fn a_scene_that_names_no_vector_has_the_dimension_of_its_mesh_file_which_is_refined() {
    let text = "[mesh]\nfile = \"cube.msh\"\nrefine = 1\n[fluid]\nviscosity = 1\n[time]\nend = \
        1\nstep = 1\n";
    let folder = folder_with(text);
    let cube = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gmsh/cube-22.msh");
    fs::copy(cube, folder.path().join("cube.msh")).unwrap();
    let ended = immersa(folder.path(), &["explain", "scene.toml"]);
    ended.expect(0, &[]);
    assert!(ended.stdout.contains("cube.msh, every tetrahedron cut into 8: "), "{}", ended.stdout);
    // A shape of the plane makes a scene of the plane, for which the mesh is wrong.
    let level_set = "[[level_set]]\nshape.circle = { centre = [0, 0], radius = 0.1 }\n[time]";
    fs::write(folder.path().join("plane.toml"), text.replace("[time]", level_set)).unwrap();
    immersa(folder.path(), &["explain", "plane.toml"])
        .expect(3, &["dimension 3, where 2 is needed", "cube.msh"]);
}

#[test]
fn a_ball_in_a_box_is_fine_where_the_membrane_is() {
    let ball = "ball_in_box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [4, 4, 4], \
        centre = [0, 0, 0], radius = 0.45, band = 0.1, edge = 0.36 }";
    let scene =
        MEMBRANE.replace("box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [6, 6, 6] }", ball);
    let scene = scene.replace("stretch", "force = \"sharp\"\nstretch");
    let folder = folder_with(&scene);
    let ended = immersa(folder.path(), &["explain", "scene.toml"]);
    ended.expect(0, &[]);
    assert!(
        ended.stdout.contains("box of 4 x 4 x 4 boxes, cut to edges of 0.36 about a sphere: "),
        "{}",
        ended.stdout
    );
}

#[test]
fn every_shape_of_space_is_read_and_written() {
    for shape in [
        "sphere = { centre = [0, 0.1, 0], radius = 0.5 }",
        "ellipsoid = { centre = [0, 0, 0], semi_axes = [0.5, 0.4, 0.3], rotation = [0, 20, 30] }",
        "rounded_box = { centre = [0, 0, 0], half_size = [0.5, 0.4, 0.45], radius = 0.2, \
         rotation = [0, 20, 0] }",
        "torus = { centre = [0, 0, 0], axis = [0, 1, 0], major = 0.35, minor = 0.2 }",
        "union = [{ sphere = { centre = [0.2, 0, 0], radius = 0.4 } }, \
         { sphere = { centre = [-0.2, 0, 0], radius = 0.4 } }]",
        "expression = \"x^2 + y^2 + 2*z^2 - 0.25\"",
    ] {
        let text = MEMBRANE
            .replace("ellipsoid = { centre = [0, 0, 0], semi_axes = [0.48, 0.36, 0.36] }", shape);
        let text = text.replace("stretch", "force = \"sharp\"\nstretch");
        let scene = Scene::parse(&text, Path::new("a.toml")).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(Scene::parse(&scene.to_toml(), Path::new("b.toml")).unwrap(), scene);
        let folder = folder_with(&text);
        immersa(folder.path(), &["explain", "scene.toml"]).expect(0, &[]);
    }
}

#[test]
fn what_belongs_to_the_plane_is_refused_in_space() {
    let shape = "ellipsoid = { centre = [0, 0, 0], semi_axes = [0.48, 0.36, 0.36] }";
    let with = |other: &str| MEMBRANE.replace(shape, other);
    refused(
        &with("circle = { centre = [0, 0], radius = 0.5 }"),
        &["shape.circle", "of the plane", "3 dimensions", "sphere"],
    );
    refused(
        &with("sphere = { centre = [0, 0], radius = 0.5 }"),
        &["shape.sphere.centre", "2 components", "needs 3"],
    );
    refused(
        &with("ellipsoid = { centre = [0, 0, 0], semi_axes = [1, 1, 0] }"),
        &["semi_axes", "all numbers", "lengths > 0"],
    );
    refused(
        &with(
            "rounded_box = { centre = [0, 0, 0], half_size = [1, 1, 1], radius = 0, angle = 20 }",
        ),
        &["angle", "rotation = [0, 0, 30]"],
    );
    refused(
        &with("sphere = { centre = [0.8, 0, 0], radius = 0.5 }"),
        &["does not lie inside", "membrane.0.shape", "x = 0.3"],
    );
    refused(
        &MEMBRANE.replace("[fluid]", "[mesh.adapt]\nedge = 0.1\n[fluid]"),
        &["mesh.adapt", "tetrahedra are not adapted"],
    );
    refused(
        &CAVITY.replace("[0, 0, -1]", "[0, -1]"),
        &["fluid.gravity", "needs 3", "3 dimensions"],
    );
    refused(
        &CAVITY.replace("[0.5, 0.5, 0.5], of", "[0.5, 0.5], of"),
        &["output.probes.middle.at", "needs 3"],
    );
    let edges = CAVITY.replace("[output]", "[output]\npicture = { mesh = true }");
    refused(&edges, &["output.picture.mesh", "in the plane alone", "ParaView"]);
    let markers = "[[level_set]]\n\
        shape.sphere = { centre = [0.5, 0.5, 0.5], radius = 0.2 }\nmarkers = 10\n[time]";
    refused(
        &CAVITY.replace("[time]", markers),
        &["level_set.0.markers", "a surface", "leave them out"],
    );
    let plane = CAVITY.replace(
        "box = { min = [0, 0, 0], max = [1, 1, 1], cells = [3, 3, 3] }",
        "rectangle = { min = [0, 0], max = [1, 1], cells = [3, 3] }",
    );
    refused(&plane, &["needs 2", "2 dimensions"]);
    let plane = include_str!("../../examples/relaxing-ellipse/scene.toml");
    let (before, after) = plane.split_once("shape.").unwrap();
    let ball = format!(
        "{before}shape.sphere = {{ centre = [1, 1, 1], radius = 0.5 }}\n{}",
        after.split_once('\n').unwrap().1
    );
    refused(&ball, &["shape.sphere", "of space", "the mesh is plane", "circle"]);
}

#[test]
fn a_level_set_is_carried_round_in_space() {
    let scene = r#"
[mesh]
box = { min = [-1, -1, -1], max = [1, 1, 1], cells = [6, 6, 6] }
[fluid]
prescribed_velocity = ["-y", "x", 0]
[[level_set]]
name = "ball"
shape.sphere = { centre = [0.4, 0, 0], radius = 0.4 }
[time]
end = 0.4
step = 0.1
[numerics]
transport = "composed"
[output]
pictures = false
"#;
    // Composed transport wants no inflow: the rotation is stopped at the walls.
    let scene =
        scene.replace("\"-y\", \"x\", 0", "\"-y*(1-y^2)*(1-x^2)^2\", \"x*(1-x^2)*(1-y^2)^2\", 0");
    let folder = folder_with(&scene);
    immersa(folder.path(), &["run", "scene.toml", "--out", "run"]).expect(0, &["done: 4 steps"]);
    let table = series(&folder.path().join("run"));
    let column = |name: &str| table.column(&format!("ball.{name}")).unwrap();
    let (x, y, volume) = (column("centre_x"), column("centre_y"), column("volume"));
    assert!(y[4] > 0.08 && x[4] < x[0], "{y:?}");
    assert!((volume[4] / volume[0] - 1.0).abs() < 0.01, "{volume:?}");
    let snapshot = read_vtu::<3>(&folder.path().join("run/fields/000004.vtu")).unwrap();
    assert!(
        snapshot
            .fields
            .iter()
            .any(|(name, f)| name == "ball.level_set" && matches!(f, Values::Scalar(_)))
    );
}

#[test]
fn studies_halve_boxes_and_a_twin_is_for_the_plane() {
    let folder = folder_with(&CAVITY.replace("[3, 3, 3]", "[2, 2, 2]"));
    let study = [
        "study",
        "convergence",
        "scene.toml",
        "--space",
        "--levels",
        "2",
        "--no-checks",
        "--out",
        "study",
    ];
    let ended = immersa(folder.path(), &study);
    ended.expect(0, &["n = 2", "n = 4"]);
    assert!(ended.stdout.contains("energy_kinetic"), "{}", ended.stdout);
    let stability =
        ["study", "stability", "scene.toml", "--scan", "fluid.viscosity=0.1,0.2", "--out", "scan"];
    immersa(folder.path(), &stability).expect(0, &["viscosity = 0.2"]);
    let membrane = folder_with(MEMBRANE);
    let surface = [&study[..5], &["2", "--quantity", "interface", "--out", "study"]].concat();
    immersa(membrane.path(), &surface).expect(2, &["no such quantity", "membrane.volume"]);
    let twin = include_str!("../../examples/relaxing-ellipse/twin.edp");
    fs::write(membrane.path().join("twin.edp"), twin).unwrap();
    immersa(membrane.path(), &["compare", "scene.toml"])
        .expect(2, &["in the plane only", "3 dimensions"]);
}
