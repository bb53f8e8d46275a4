//! Extensibility: a new structure needs one file of physics, one file of the scene and one line of
//! registration, and has all features of the others.

mod kind;
mod physics;

pub(in crate::scene) use kind::KIND;

use crate::base::{Kind, Result, Warning};
use crate::scene::keys::Kind as ValueKind;
use crate::scene::run::{Earlier, Observer, Options, run};
use crate::scene::{KEYS, Scene, problem};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

const SCENE: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }
[fluid]
viscosity = 0.05
[[spring]]
name = "disc"
shape.circle = { centre = [0.8, 1], radius = 0.35 }
anchor = [1.2, 1.1]
stiffness = 2
[[level_set]]
name = "dye"
shape.circle = { centre = [1.2, 0.8], radius = 0.3 }
[time]
end = 0.4
step = 0.02
[numerics]
thickness = 0.25
[output]
every = 0.02
fields = 0.2
pictures = 0.4
film = false
picture = { size = 200 }
"#;

/// Stops a run after some steps; stores the plan.
#[derive(Default)]
struct Listener<'a> {
    stop: Option<(usize, &'a AtomicBool)>,
    plan: String,
}

impl Observer for Listener<'_> {
    fn plan(&mut self, plan: &str) {
        self.plan = plan.to_string();
    }
    fn warning(&mut self, _: &Warning) {}
    fn progress(&mut self, step: usize, _: usize, _: f64) {
        if let Some((_, stop)) = self.stop.filter(|(last, _)| *last == step) {
            stop.store(true, Ordering::Relaxed);
        }
    }
    fn phase(&mut self, _: &str) {}
}

fn scene(set: &[&str]) -> Scene {
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    Scene::parse_with(SCENE, Path::new("case/scene.toml"), &set).unwrap()
}

/// Runs a scene in a folder; with `stop` it is interrupted after this many steps.
fn go(scene: &Scene, folder: &Path, resume: bool, stop: Option<usize>) -> Result<String> {
    let flag = AtomicBool::new(false);
    let mut listener = Listener { stop: stop.map(|step| (step, &flag)), ..Listener::default() };
    let earlier = if resume { Earlier::Resume } else { Earlier::Keep };
    let command = "a test".to_string();
    let options = Options { folder: folder.to_path_buf(), earlier, command, stop: &flag };
    run(scene, &options, &mut listener)?;
    Ok(listener.plan)
}

#[test]
fn it_is_in_the_reference_and_reads_back() {
    let key = KEYS.get("spring").unwrap();
    assert!(matches!(key.kind, ValueKind::List(keys) if keys.get("anchor").is_some()));
    assert!(
        crate::scene::reference::reference(Some("spring"))
            .unwrap()
            .contains("`stiffness`: number > 0 (N/m), required")
    );
    let scene = scene(&[]);
    let again = Scene::parse(&scene.to_toml(), Path::new("elsewhere/scene.toml")).unwrap();
    assert_eq!(again, scene);
    assert_ne!(again, self::scene(&["spring.0.stiffness=3"]));
    let wrong = SCENE.replace("anchor", "ancor");
    let e = Scene::parse(&wrong, Path::new("case/scene.toml")).unwrap_err();
    assert!(e.to_string().contains("did you mean `anchor`?"), "{e}");
    let clash = Scene::parse_with(SCENE, Path::new("s.toml"), &["level_set.0.name=disc".into()])
        .unwrap_err();
    assert!(clash.to_string().contains("two interfaces are named `disc`"), "{clash}");
}

#[test]
fn it_runs_resumes_writes_fields_and_charts() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let scene = scene(&[]);
    let plan = go(&scene, &whole, false, None).unwrap();
    assert!(plan.contains("spring `disc`: stiffness 2, pulls to [1.2, 1.1]"), "{plan}");
    let stopped = go(&scene, &parts, false, Some(9)).unwrap_err();
    assert_eq!(stopped.kind(), Kind::Interrupted);
    go(&scene, &parts, true, None).unwrap();
    let read = |folder: &Path, name: &str| fs::read(folder.join(name)).unwrap();
    for name in ["series.csv", "fields/000020.vtu"] {
        assert!(read(&whole, name) == read(&parts, name), "{name} differs");
    }
    let series = crate::output::Series::read(&whole.join("series.csv")).unwrap();
    let last = |name: &str| *series.column(name).unwrap().last().unwrap();
    assert!(last("disc.centre_x") > 0.81 && last("disc.path") > 0.01);
    // The energy of the spring is transferred to the fluid.
    assert!(last("energy_balance").abs() < 5e-3, "{}", last("energy_balance"));
    assert!(last("energy_kinetic") > 1e-4 && last("energy_elastic") < 0.5 * 2.0 * 0.17);
    let file = read(&whole, "fields/000020.vtu");
    assert!(String::from_utf8_lossy(&file).contains("Name=\"disc.level_set\""));
    let rendered = crate::scene::render::render(&whole).unwrap();
    assert!(
        rendered.files.iter().any(|f| f.ends_with("charts/path-disc.svg")),
        "{:?}",
        rendered.files
    );
    assert!(fs::read_to_string(&rendered.report).unwrap().contains("Path of disc"));
}

#[test]
fn it_follows_an_adapted_mesh() {
    let set = ["mesh.adapt={ edge = 0.08, every = 0.1, fields = ['velocity'], error = 0.02 }"];
    let folder = tempfile::tempdir().unwrap();
    go(&scene(&set), folder.path(), false, None).unwrap();
    let series = crate::output::Series::read(&folder.path().join("series.csv")).unwrap();
    let unknowns = series.column("unknowns").unwrap();
    assert!(unknowns.iter().any(|n| *n != unknowns[0]), "the mesh never changed");
    let path = series.column("disc.path").unwrap();
    assert!(path.windows(2).all(|w| w[1] > w[0]), "{path:?}");
}

/// The spring is also available in space, and with adaptive steps.
#[test]
fn it_is_built_in_space_and_stepped_by_the_error() {
    let text = SCENE
        .replace(
            "rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }",
            "box = { min = [0, 0, 0], max = [2, 2, 2], cells = [10, 10, 10] }",
        )
        .replace("circle = { centre = [0.8, 1]", "sphere = { centre = [0.8, 1, 1]")
        .replace("circle = { centre = [1.2, 0.8]", "sphere = { centre = [1.2, 0.8, 1]")
        .replace("[1.2, 1.1]", "[1.2, 1.1, 1]")
        .replace("thickness = 0.25", "thickness = 0.35");
    let mut space = problem(&Scene::parse(&text, Path::new("s.toml")).unwrap()).unwrap();
    space.step().unwrap();
    let row = space.row().unwrap();
    assert!(row.get("disc.path").unwrap() > 0.0);
    // The anchor is at a distance of .412 in the plane of the centre.
    let energy = row.get("energy_elastic").unwrap();
    assert!((energy / (0.4f64.powi(2) + 0.1f64.powi(2)) - 1.0).abs() < 0.03, "{energy}");
    let mut paced = problem(&scene(&["time.tolerance=0.05"])).unwrap();
    while !paced.moment().done {
        paced.step().unwrap();
    }
    assert!(paced.row().unwrap().get("disc.centre_x").unwrap() > 0.81);
}

/// No file except those of the spring and the registration may refer to it.
#[test]
fn no_other_file_knows_it() {
    fn sources(folder: &Path, found: &mut Vec<std::path::PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true if path.ends_with("tests/spring") => {}
                true => sources(&path, found),
                false => found.push(path),
            }
        }
    }
    let mut files = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    let mentions_it = |path: &&std::path::PathBuf| {
        let text = fs::read_to_string(path).unwrap_or_default();
        text.lines()
            .filter(|l| l.to_lowercase().contains("spring") && !l.contains("Springer"))
            .count()
            > 0
    };
    let found: Vec<_> =
        files.iter().filter(mentions_it).map(|p| p.file_name().unwrap().to_owned()).collect();
    assert_eq!(found.len(), 2, "the registration and the declaration of the test alone: {found:?}");
}
