//! Studies: their trials are run once, go on after an interruption and may fail; and the study of
//! convergence.

use crate::program::immersa;
use immersa::output::{Cell, Page, Series, Table};
use immersa::scene::{ImmersedFlow, Scene};
use immersa::studies::convergence::{Convergence, Halved, convergence};
use immersa::studies::{Campaign, End, Listener, Outcome, Trial};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Counts steps, and sets a flag after some of them.
#[derive(Default)]
struct Counter<'a> {
    steps: usize,
    stop_after: Option<(usize, &'a AtomicBool)>,
}

impl Listener for Counter<'_> {
    fn begins(&mut self, _: usize, _: usize, _: &Trial) {}
    fn progress(&mut self, _: usize, _: usize, _: f64) {
        self.steps += 1;
        if let Some((_, stop)) = self.stop_after.filter(|s| s.0 == self.steps) {
            stop.store(true, Ordering::Relaxed);
        }
    }
    fn ended(&mut self, _: &Outcome) {}
    fn note(&mut self, _: &str) {}
}

fn scene(text: &str, set: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/scene.toml");
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    Scene::parse_with(text, &path, &set).unwrap_or_else(|e| panic!("{e}"))
}

const MEMBRANE: &str = include_str!("../../examples/relaxing-ellipse/scene.toml");
const COARSE: [&str; 3] =
    ["mesh.rectangle.cells=[16, 16]", "numerics.thickness=0.2", "time.end=0.1"];

#[test]
fn a_trial_is_run_once_and_goes_on_after_an_interruption() {
    let scene = scene(MEMBRANE, &COARSE);
    let folder = tempfile::tempdir().unwrap();
    let trial = Trial::new("dt = 0.01", vec!["time.step=0.01".into()]);
    let run = |name: &str, stop_after: Option<usize>| {
        let stop = AtomicBool::new(false);
        let mut counter = Counter { steps: 0, stop_after: stop_after.map(|n| (n, &stop)) };
        let result =
            Campaign::new(&scene, &folder.path().join(name), &stop, &mut counter).run(&trial, 1, 1);
        (result, counter.steps)
    };
    let (whole, steps) = run("whole", None);
    let whole = whole.unwrap();
    assert_eq!((steps, whole.finished()), (10, true));
    let (again, steps) = run("whole", None);
    assert_eq!((steps, again.unwrap().series), (0, whole.series.clone()));
    let (stopped, steps) = run("parts", Some(4));
    let error = stopped.unwrap_err();
    assert_eq!((steps, error.kind().exit_code()), (4, 130));
    assert!(error.advice().contains("same command"), "{error}");
    let (resumed, steps) = run("parts", None);
    assert_eq!((steps, resumed.unwrap().series), (6, whole.series));
}

#[test]
fn a_trial_that_fails_is_a_data_point() {
    let explicit =
        ["numerics.coupling=explicit", "time.step=0.05", "time.end=5", "output.every=0.05"];
    let scene = scene(MEMBRANE, &[&COARSE[..2], &explicit].concat());
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let trials = [
        Trial::new("explicit", Vec::new()),
        Trial::new("thin", vec!["numerics.thickness=0.02".into()]),
        Trial::new("implicit", vec!["numerics.coupling=implicit".into(), "time.end=0.1".into()]),
    ];
    // The second time everything is read from the folders.
    for _ in 0..2 {
        let mut counter = Counter::default();
        let outcomes =
            Campaign::new(&scene, folder.path(), &stop, &mut counter).run_all(&trials).unwrap();
        let End::Failed { time, .. } = outcomes[0].end else { panic!("{:?}", outcomes[0].end) };
        assert!(
            time < 2.0 && outcomes[0].end.in_words().starts_with("blew up at t = "),
            "{:?}",
            outcomes[0].end
        );
        // The rows before are there, those after are not.
        assert!(outcomes[0].value("membrane.area", 0.05).unwrap() > 1.0);
        assert!(outcomes[0].value("membrane.area", 5.0).unwrap().is_nan());
        assert!(
            matches!(&outcomes[1].end, End::Refused { reason } if reason.contains("thinner")),
            "{:?}",
            outcomes[1].end
        );
        assert!(outcomes[2].finished());
    }
}

fn study(scene: &Scene, folder: &Path, settings: Convergence) -> Page {
    let stop = AtomicBool::new(false);
    let mut counter = Counter::default();
    let found = convergence(&mut Campaign::new(scene, folder, &stop, &mut counter), &settings);
    found.unwrap_or_else(|e| panic!("{e}"))
}

fn table<'a>(found: &'a Page, name: &str) -> &'a Table {
    found.table(name).unwrap()
}

/// Numbers of a column in the rows of a quantity.
fn column(found: &Page, quantity: &str, name: &str) -> Vec<f64> {
    let table = table(found, "convergence");
    let k = table.position(name).unwrap();
    let rows = table.rows.iter().filter(|r| r[0] == Cell::text(quantity));
    rows.map(|r| r[k].value().unwrap()).collect()
}

/// The travelling vortex of Taylor and Green: an exact solution of the Navier-Stokes equations.
const VORTEX: &str = r#"
[constants]
nu = 0.1
[mesh]
rectangle = { min = [0, 0], max = [6.283185307179586, 6.283185307179586], cells = [8, 8], diagonals = "union-jack" }
[fluid]
viscosity = 0.1
initial_velocity = ["1 + sin(x) * cos(y)", "0.5 - cos(x) * sin(y)"]
[boundary]
left.periodic = "right"
bottom.periodic = "top"
[time]
end = 0.4
step = 0.1
[numerics]
convection = "pironneau1982"
[exact]
velocity = ["1 + sin(x - t) * cos(y - t/2) * exp(-2*nu*t)", "0.5 - cos(x - t) * sin(y - t/2) * exp(-2*nu*t)"]
pressure = "0.25 * (cos(2*(x - t)) + cos(2*y - t)) * exp(-4*nu*t)"
"#;

#[test]
fn errors_against_an_exact_solution_fall_with_their_orders() {
    let folder = tempfile::tempdir().unwrap();
    let settings = Convergence {
        halved: Halved { space: true, time: true, thickness: false },
        levels: 3,
        ..Convergence::default()
    };
    let found = study(&scene(VORTEX, &[]), folder.path(), settings);
    // Third order in space and second in time make 2.6 on these levels; the bounds are 1.2 times
    // what is measured.
    for (name, orders, bound) in [
        ("error_velocity_l2", 2.5..3.0, 2.0e-3),
        ("error_velocity_h1", 1.9..2.2, 3.5e-2),
        ("error_pressure_l2", 1.9..2.4, 9.0e-3),
    ] {
        let (errors, seen) = (column(&found, name, "error"), column(&found, name, "order"));
        assert!(errors.len() == 3 && errors[2] < bound, "{name}: {errors:?}");
        assert!(
            seen[0].is_nan() && seen[1..].iter().all(|p| orders.contains(p)),
            "{name}: {seen:?}"
        );
    }
    assert!(found.table("limits").is_none(), "errors have no limit but zero");
    immersa::studies::files::write(&found, folder.path(), "").unwrap();
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("error_pressure_l2") && page.contains(">2</text>"), "no slope triangle");
}

/// A Stokes flow on gmsh's disc, driven by a force: velocity curl(sin(2 x + 1) sin(3 y)), pressure
/// cos(3 x + y).
const DISC: &str = r#"
[constants]
mu = 0.5
[mesh]
file = "disc.msh"
geometry.wall = { circle = { centre = [0, 0], radius = 1 } }
[fluid]
density = 0
viscosity = 0.5
force = [
    "13 * mu * 3 * sin(2*x + 1) * cos(3*y) - 3 * sin(3*x + y)",
    "-13 * mu * 2 * cos(2*x + 1) * sin(3*y) - sin(3*x + y)",
]
[boundary.wall]
velocity = ["3 * sin(2*x + 1) * cos(3*y)", "-2 * cos(2*x + 1) * sin(3*y)"]
[time]
end = 0.1
step = 0.1
[numerics]
grad_div = 1
[exact]
velocity = ["3 * sin(2*x + 1) * cos(3*y)", "-2 * cos(2*x + 1) * sin(3*y)"]
pressure = "cos(3*x + y)"
"#;

#[test]
fn a_mesh_file_is_refined_onto_its_circle() {
    let area = |refine: &str| {
        let model =
            ImmersedFlow::<2>::new(&scene(DISC, &[refine])).unwrap_or_else(|e| panic!("{e}"));
        let mesh = model.simulation.space().mesh();
        assert_eq!(mesh.boundary("wall").unwrap().len(), mesh.facets().len());
        assert!(
            mesh.facets()
                .iter()
                .flat_map(|f| mesh.facet_points(f))
                .all(|v| { (mesh.points()[v as usize].norm() - 1.0).abs() < 1e-12 })
        );
        std::f64::consts::PI - mesh.volume()
    };
    let missing = ["mesh.refine=0", "mesh.refine=1", "mesh.refine=2"].map(area);
    assert!(
        (missing[0] / missing[1] - 4.0).abs() < 0.02
            && (missing[1] / missing[2] - 4.0).abs() < 0.02,
        "{missing:?}"
    );
    for (set, words) in [
        ("mesh.geometry.wall.circle.radius=1.1", "does not lie on the curve"),
        (
            "mesh.geometry.rim={ circle = { centre = [0, 0], radius = 1 } }",
            "no boundary of this name",
        ),
    ] {
        let error = ImmersedFlow::<2>::new(&scene(DISC, &[set])).err().unwrap();
        assert!(
            error.to_string().contains(words) && error.place().contains("mesh.geometry"),
            "{error}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let settings = Convergence {
        halved: Halved { space: true, time: false, thickness: false },
        levels: 3,
        ..Convergence::default()
    };
    let found = study(&scene(DISC, &[]), folder.path(), settings);
    for (name, order, bound) in
        [("error_velocity_l2", 3.0, 9.2e-6), ("error_pressure_l2", 2.0, 2.5e-4)]
    {
        let (errors, seen) = (column(&found, name, "error"), column(&found, name, "order"));
        assert!(errors[2] < bound && (seen[2] - order).abs() < 0.15, "{name}: {errors:?} {seen:?}");
    }
}

/// A square of `n x n` squares as gmsh would write it (MSH 2.2).
fn write_msh(path: &Path, n: usize) {
    let id = |i: usize, j: usize| i + j * (n + 1) + 1;
    let mut text = format!("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", (n + 1) * (n + 1));
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        text += &format!("{} {} {} 0\n", id(i, j), i as f64 / n as f64, j as f64 / n as f64);
    }
    text += &format!("$EndNodes\n$Elements\n{}\n", 2 * n * n);
    for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i, j + 1), id(i + 1, j + 1)];
        let k = 2 * (i + j * n) + 1;
        text += &format!("{k} 2 2 0 1 {a} {b} {d}\n{} 2 2 0 1 {a} {d} {c}\n", k + 1);
    }
    fs::write(path, text + "$EndElements\n").unwrap();
}

#[test]
fn a_list_of_meshes_needs_no_ratio_of_two() {
    let folder = tempfile::tempdir().unwrap();
    let meshes: Vec<_> = [8, 12, 19].map(|n| folder.path().join(format!("square{n}.msh"))).into();
    for (path, n) in meshes.iter().zip([8, 12, 19]) {
        write_msh(path, n);
    }
    let (text, _) = DISC.split_once("geometry.wall").unwrap();
    let rest = DISC.split_once("[fluid]").unwrap().1.replace("boundary.wall]", "boundary.walls]");
    let file = format!("mesh.file='{}'", meshes[0].display());
    let scene = scene(&format!("{text}[fluid]{rest}"), &[&file]);
    let settings = Convergence {
        halved: Halved { space: true, time: false, thickness: false },
        meshes,
        quantities: vec!["error_velocity_l2".into(), "error_velocity_h1".into()],
        ..Convergence::default()
    };
    let found = study(&scene, folder.path(), settings);
    let (sizes, orders) =
        (column(&found, "error_velocity_l2", "h"), column(&found, "error_velocity_l2", "order"));
    assert!((sizes[0] / sizes[2] - 19.0 / 8.0).abs() < 1e-9, "{sizes:?}");
    assert!((orders[2] - 3.0).abs() < 0.15, "{orders:?}");
    assert!((column(&found, "error_velocity_h1", "order")[2] - 2.0).abs() < 0.15);
}

#[test]
fn the_program_studies_says_what_it_knows_and_refuses_what_it_does_not() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), MEMBRANE).unwrap();
    let base = [
        "study",
        "convergence",
        "scene.toml",
        "--set",
        COARSE[0],
        "--set",
        COARSE[1],
        "--levels",
        "3",
        "--thickness",
    ];
    let run = |more: &[&str]| immersa(folder.path(), &[&base, more].concat());
    run(&["--quantity", "membrane.horizontle"])
        .expect(2, &["--quantity", "did you mean `membrane.horizontal`"]);
    run(&["--at", "0.105"]).expect(2, &["--at", "multiple of the step"]);
    run(&["--meshes", "a.msh"]).expect(2, &["cannot be used with"]);
    run(&["--order", "0"]).expect(2, &["--order"]);
    assert!(!folder.path().join("studies").exists());
    let asked = [
        "--quantity",
        "membrane.horizontal,interface",
        "--at",
        "0.05,0.1",
        "--json",
        "--out",
        "here",
    ];
    let done = run(&asked);
    done.expect(0, &["[1/5] check: dt = 0.005: finished", "[5/5] eps = 0.05, n = 64: finished"]);
    let json: Value = serde_json::from_str(&done.stdout).unwrap();
    assert_eq!(json["tables"]["levels"].as_array().unwrap().len(), 5);
    // Two times, three levels, a half-chord and two distances.
    assert_eq!(json["tables"]["convergence"].as_array().unwrap().len(), 18);
    assert!(json["command"].as_str().unwrap().contains("--quantity membrane.horizontal,interface"));
    let limits = Series::read(&folder.path().join("here/by_time.csv")).unwrap();
    assert_eq!(limits.column("time").unwrap(), [0.05, 0.1]);
    assert_eq!(limits.column("membrane.horizontal.bar").unwrap().len(), 2);
    for file in [
        "study.json",
        "levels.csv",
        "convergence.csv",
        "limits.csv",
        "charts/convergence-t0.1.svg",
        "report.html",
    ] {
        assert!(folder.path().join("here").join(file).exists(), "{file}");
    }
    // Nothing is computed again.
    let runs = || {
        fs::read_dir(folder.path().join("here/runs"))
            .unwrap()
            .map(|e| e.unwrap().path().join("series.csv"))
    };
    let before: Vec<_> = runs().map(|f| fs::metadata(f).unwrap().modified().unwrap()).collect();
    let again = run(&asked);
    let after: Vec<_> = runs().map(|f| fs::metadata(f).unwrap().modified().unwrap()).collect();
    assert_eq!((again.stdout, before), (done.stdout, after));
}
