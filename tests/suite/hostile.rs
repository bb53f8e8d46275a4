//! Inputs with random damage: each is accepted or refused with words; nothing panics. The number of
//! cases is small here; `IMMERSA_CASES=100000 cargo test --release --test suite -- hostile` runs as
//! many, and prints what became of them (CONTRIBUTING.md, "Hostile inputs").

use super::program::SCENE;
use immersa::base::{Error, Result, Warning, fnv1a};
use immersa::mesh::gmsh::MshData;
use immersa::mesh::{Diagonals, freefem, rectangle};
use immersa::output::read_vtu;
use immersa::scene::run::{Earlier, Observer, Options, run};
use immersa::scene::schema::MeshSource;
use immersa::scene::{Scene, problem, render};
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Pseudo-random whole numbers (Knuth's MMIX constants).
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        let next = self.0.wrapping_mul(6_364_136_223_846_793_005);
        self.0 = next.wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n.max(1)
    }
    fn of<'a, T: ?Sized>(&mut self, list: &[&'a T]) -> &'a T {
        list[self.below(list.len())]
    }
}

/// Values that stand at the edge of what is allowed.
const EDGES: [&str; 20] = [
    "0",
    "-1",
    "1",
    "1e-300",
    "1e300",
    "-0.0",
    "nan",
    "inf",
    "-inf",
    "1e400",
    "9223372036854775807",
    "-9223372036854775808",
    "4294967296",
    "0.5",
    "\"\"",
    "\"x/0\"",
    "true",
    "[]",
    "{}",
    "\"1/x\"",
];

/// The bytes with one or two random changes.
fn damaged(good: &[u8], others: &[Vec<u8>], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..=dice.below(2) {
        let (a, b) = (dice.below(bytes.len() + 1), dice.below(60));
        let b = (a + b).min(bytes.len());
        match dice.below(7) {
            0 if a < bytes.len() => bytes[a] ^= 1 << dice.below(8),
            1 => drop(bytes.drain(a..b)),
            2 => {
                let part = bytes[a..b].to_vec();
                let to = dice.below(bytes.len() + 1);
                drop(bytes.splice(to..to, part));
            }
            3 => {
                let other = &others[dice.below(others.len())];
                let from = dice.below(other.len() + 1);
                let part = other[from..(from + 60).min(other.len())].to_vec();
                drop(bytes.splice(a..b, part));
            }
            4 => bytes.truncate(a),
            _ => {
                // A number by one at an edge.
                let is_number = |c: &u8| c.is_ascii_digit() || b".-e".contains(c);
                let Some(from) = (a..bytes.len()).find(|&k| bytes[k].is_ascii_digit()) else {
                    continue;
                };
                let end = (from..bytes.len()).find(|&k| !is_number(&bytes[k]));
                let value = dice.of(&EDGES).as_bytes().to_vec();
                drop(bytes.splice(from..end.unwrap_or(bytes.len()), value));
            }
        }
    }
    bytes
}

/// Number of cases, of which `share` in a thousand are taken for costly inputs.
fn cases(share: usize, here: usize) -> usize {
    let all = std::env::var("IMMERSA_CASES").ok().and_then(|n| n.parse::<usize>().ok());
    all.map_or(here, |n| n * share / 1000)
}

/// Feeds damaged inputs to `read`, and reports what became of them.
#[allow(clippy::print_stdout, reason = "the counts are what a run by hand is for")]
fn feed(name: &str, seeds: &[Vec<u8>], count: usize, mut read: impl FnMut(&[u8]) -> Result<()>) {
    let (mut dice, mut refused, mut slowest) = (Dice(7), 0, Duration::ZERO);
    for case in 0..count {
        let bytes = damaged(&seeds[dice.below(seeds.len())], seeds, &mut dice);
        let start = Instant::now();
        let Ok(result) = catch_unwind(AssertUnwindSafe(|| read(&bytes))) else {
            panic!("{name}, case {case} panics:\n{}", String::from_utf8_lossy(&bytes));
        };
        slowest = slowest.max(start.elapsed());
        if let Err(e) = result {
            refused += 1;
            assert!(told(&e), "{name}, case {case}: {e}\n{}", String::from_utf8_lossy(&bytes));
        }
    }
    assert!(refused > count / 4 && refused < count, "{name}: {refused} of {count} refused");
    println!("{name}: {count} cases, {refused} refused, the slowest in {slowest:?}");
}

/// A refusal says what is wrong and what to do.
fn told(e: &Error) -> bool {
    !e.what().is_empty() && e.kind() != Error::internal("").kind()
}

/// Small scenes of every kind.
fn scenes() -> Vec<Vec<u8>> {
    let square = "mesh.rectangle = { min = [0, 0], max = [2, 2], cells = [12, 12] }\n";
    let cube = "mesh.box = { min = [0, 0, 0], max = [2, 2, 2], cells = [3, 3, 3] }\n";
    let rest = "time = { end = 1, step = 0.1, order = 1 }\n";
    let flow = "[fluid]\ndensity = 1\nviscosity = 0.1\ngravity = [0, -1]\n\
        initial_velocity = [\"y*(2-y)\", \"0\"]\n[boundary.left]\nvelocity = [\"y*(2-y)*t\", 0]\n\
        [boundary.right]\nopen = true\n[boundary.walls]\nno_slip = true\n";
    let solid = "[fluid]\ndensity = { inside = 1, outside = 1 }\nviscosity = 0.1\n\
        [boundary.right]\nperiodic = \"left\"\n[boundary.walls]\nslip = true\n";
    let membrane = "[[membrane]]\nname = \"skin\"\nstretch = 1.2\n\
        shape.ellipse = { centre = [1, 1], semi_axes = [0.4, 0.3] }\narea.linear = { modulus = 1 }\n\
        chords.a = { through = [1, 1], direction = [1, 0] }\n";
    let output = "[output]\nevery = 0.1\nprobes.p = { at = [1, 1], of = \"velocity\" }\n\
        forces.f = { boundary = \"walls\", about = [0, 0] }\nfluxes.q = { boundary = \"left\" }\n\
        picture = { size = 300, field = \"pressure\" }\n\
        profiles.l = { from = [0, 1], to = [2, 1], of = \"pressure\", points = 5, times = [0.5] }\n";
    let drop = "[[drop]]\ntension = 1\ndensity = 2\nviscosity = 0.2\n\
        shape.union = [{ circle = { centre = [0.6, 1], radius = 0.3 } }, \
        { rounded_box = { centre = [1.4, 1], half_size = [0.2, 0.4], radius = 0.1 } }]\n\
        surfactant = { concentration = 0.3, elasticity = 0.2, diffusivity = 0.1 }\n";
    let ball = "[[membrane]]\nshape.sphere = { centre = [1, 1, 1], radius = 0.6 }\n\
        area.linear = { modulus = 1 }\nshear.linear = { modulus = 1 }\n";
    let numerics = "[numerics]\nthickness = 0.27\ngrad_div = 1\ntransport = \"nodal\"\n\
        coupling = \"explicit\"\nredistance.method = \"none\"\n";
    let carried = "[fluid]\nprescribed_velocity = [\"1-y\", \"x-1\"]\n[[level_set]]\n\
        shape.expression = \"hypot(x-1, y-1) - 0.4\"\nmarkers = 20\n";
    let adapt = "[mesh.adapt]\nevery = 0.1\nedge = 0.2\n";
    [
        SCENE.replace("[16, 16]", "[8, 8]"),
        format!("{rest}{square}{flow}{membrane}{output}"),
        format!("{rest}{square}{flow}{membrane}force = \"smeared\"\n{numerics}"),
        format!(
            "constants = {{ a = 1, b = \"a/2\" }}\n{rest}numerics.thickness = 0.27\n{square}{flow}{drop}{output}"
        ),
        format!("{rest}{cube}{solid}{ball}"),
        format!("{rest}{square}{carried}[output]\nevery = 0.1\npicture.size = 300\n"),
        format!("{rest}{square}{adapt}{carried}"),
    ]
    .map(String::into_bytes)
    .into()
}

/// True if a mesh is small enough to be made thousands of times.
fn is_small(scene: &Scene) -> bool {
    let product = |cells: &[usize]| cells.iter().map(|&n| n as f64).product::<f64>();
    match &scene.mesh {
        MeshSource::Rectangle(r) => product(&r.cells) < 500.0,
        MeshSource::Disc(d) => d.cells < 16,
        MeshSource::Box(b) => product(&b.cells) < 60.0,
        _ => false,
    }
}

#[test]
fn the_undamaged_scenes_are_planned() {
    for bytes in scenes() {
        let text = String::from_utf8(bytes).unwrap();
        let scene = Scene::parse(&text, Path::new("scene.toml")).unwrap_or_else(|e| panic!("{e}"));
        assert!(is_small(&scene), "{text}");
        problem(&scene).and_then(|mut p| p.plan()).unwrap_or_else(|e| panic!("{e}\n{text}"));
    }
}

#[test]
fn damaged_scenes_are_read_or_refused() {
    feed("scenes, read", &scenes(), cases(1000, 3000), |bytes| {
        let scene = Scene::parse(&String::from_utf8_lossy(bytes), Path::new("scene.toml"))?;
        let again = Scene::parse(&scene.to_toml(), Path::new("scene.toml"))?;
        assert_eq!(again, scene, "a scene that is written is another one");
        Ok(())
    });
}

#[test]
fn damaged_scenes_are_planned_or_refused() {
    feed("scenes, planned", &scenes(), cases(200, 250), |bytes| {
        let scene = Scene::parse(&String::from_utf8_lossy(bytes), Path::new("scene.toml"))?;
        let adapts = scene.adapt.as_ref().and_then(|a| a.edge).is_some_and(|h| h < 0.1);
        if is_small(&scene) && !adapts {
            scene.check_files()?;
            problem(&scene)?.plan()?;
        }
        Ok(())
    });
}

#[test]
fn damaged_meshes_are_read_or_refused() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, 2], Diagonals::Right).unwrap();
    let mut seeds = vec![freefem::text(&mesh).unwrap().into_bytes()];
    for entry in fs::read_dir("tests/data/gmsh").unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "msh") {
            seeds.push(fs::read(path).unwrap());
        }
    }
    assert!(seeds.len() > 3);
    feed("meshes", &seeds, cases(1000, 3000), |bytes| {
        let data = MshData::parse(bytes, "m.msh")?;
        data.mesh::<2>().map(|_| ()).or_else(|_| data.mesh::<3>().map(|_| ()))
    });
}

/// An observer that says nothing.
struct Silent;

impl Observer for Silent {
    fn plan(&mut self, _: &str) {}
    fn warning(&mut self, _: &Warning) {}
    fn progress(&mut self, _: usize, _: usize, _: f64) {}
    fn phase(&mut self, _: &str) {}
}

/// The folder of a short run with field files and a checkpoint.
fn ended() -> TempDir {
    let folder = TempDir::new().unwrap();
    let text = SCENE
        .replace("[16, 16]", "[6, 6]")
        .replace("end = 0.4", "end = 0.05")
        .replace("thickness = 0.2", "thickness = 0.4")
        .replace("times = [0.05, 0.2, 0.4]", "times = [0.05]");
    let scene = Scene::parse(&text, Path::new("scene.toml")).unwrap();
    let (stop, command) = (AtomicBool::new(false), String::new());
    let (folder_of, earlier) = (folder.path().join("run"), Earlier::Keep);
    let options = Options { folder: folder_of, earlier, command, stop: &stop };
    run(&scene, &options, &mut Silent).unwrap();
    folder
}

#[test]
fn damaged_field_files_are_read_or_refused() {
    let folder = ended();
    let fields = fs::read_dir(folder.path().join("run/fields")).unwrap();
    let seeds: Vec<_> = fields.map(|f| fs::read(f.unwrap().path()).unwrap()).collect();
    let path = folder.path().join("damaged.vtu");
    feed("field files", &seeds, cases(1000, 2000), |bytes| {
        fs::write(&path, bytes).unwrap();
        read_vtu::<2>(&path).map(|_| ())
    });
}

/// Of a checkpoint whose check sum is right.
#[test]
fn damaged_states_are_read_or_refused() {
    let text = SCENE.replace("[16, 16]", "[6, 6]").replace("thickness = 0.2", "thickness = 0.4");
    let scene = Scene::parse(&text, Path::new("scene.toml")).unwrap();
    let mut whole = problem(&scene).unwrap();
    let first = whole.save(1)[1].clone();
    whole.step().unwrap();
    whole.step().unwrap();
    let seeds = [first, whole.save(1)[1].clone()];
    feed("states", &seeds, cases(200, 500), |bytes| {
        let mut bytes = bytes[..bytes.len().saturating_sub(8)].to_vec();
        let check = fnv1a(&bytes);
        bytes.extend(check.to_le_bytes());
        whole.restore([&[], &bytes], 1, None)?;
        // A state that fits is one to go on from, or a failure that is told.
        whole.step().map(drop)
    });
}

#[test]
fn damaged_run_folders_are_drawn_or_refused() {
    let folder = ended();
    let run = folder.path().join("run");
    let names = ["series.csv", "summary.json", "fields.pvd", "scene.toml", "immersa.run"];
    let files: Vec<_> =
        names.iter().map(|n| (run.join(n), fs::read(run.join(n)).unwrap())).collect();
    let seeds: Vec<_> = files.iter().map(|f| f.1.clone()).collect();
    let mut turn = 0;
    feed("run folders", &seeds, cases(20, 60), |bytes| {
        turn += 1;
        let (path, good) = &files[turn % files.len()];
        fs::write(path, bytes).unwrap();
        let result = render::render(&run).map(drop);
        fs::write(path, good).unwrap();
        result
    });
}
