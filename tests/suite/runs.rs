//! Runs through the program: interrupted and killed at any moment, resumed, on one thread and on
//! two; what they say and what they refuse.

use super::program::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A folder with `scene.toml` and the folder `whole` of its run, which nothing disturbed; and how
/// long that took.
fn with_run(scene: &str) -> (TempDir, PathBuf, Duration) {
    let folder = folder_with(scene);
    let start = Instant::now();
    let ended = immersa(folder.path(), &["run", "scene.toml", "--out", "whole"]);
    ended.expect(0, &["40 steps of 0.01 to t = 0.4", "done: 40 steps"]);
    assert!(ended.stdout.contains("whole/report.html"));
    let whole = folder.path().join("whole");
    assert_eq!(rows(&whole), 41);
    (folder, whole, start.elapsed())
}

/// The scene on a mesh that is made anew at every look.
fn adapted() -> String {
    let scene = SCENE.replace(
        "[fluid]",
        "[mesh.adapt]\nevery = 0.05\nedge = 0.1\nfields = [\"pressure\"]\nerror = 0.05\n[fluid]",
    );
    scene.replace("thickness = 0.2", "thickness = 0.25")
}

/// A membrane that the flow carries out of the fine part of one mesh after the other.
const MOVING: &str = r#"
[mesh]
rectangle = { min = [0, 0], max = [3, 2], cells = [12, 8] }
[mesh.adapt]
every = 0.05
edge = 0.1
[fluid]
viscosity = 0.05
initial_velocity = ["2", "0"]
[boundary.left]
velocity = [2, 0]
[boundary.right]
open = true
[boundary.top]
slip = true
[boundary.bottom]
slip = true
[[membrane]]
shape.circle = { centre = [1, 1], radius = 0.4 }
stretch = 1.2
area.linear = { modulus = 1 }
[time]
end = 0.4
step = 0.01
[numerics]
thickness = 0.25
[output]
every = 0.01
pictures = false
checkpoint = 0
"#;

#[test]
fn runs_that_were_interrupted_end_as_if_they_had_not_been() {
    for scene in [
        SCENE.to_string(),
        SCENE.replace("checkpoint = 0", "checkpoint = false"),
        adapted(),
        MOVING.into(),
    ] {
        let (folder, whole, _) = with_run(&scene);
        let meshes = summary(&whole)["meshes"].as_array().map_or(0, Vec::len);
        assert_eq!(meshes > 2, scene.contains("mesh.adapt"), "{meshes} meshes");
        for row in [0, 1, 7, 15] {
            let out = format!("interrupted-{row}");
            let ended = interrupted(folder.path(), &out, row);
            ended.expect(
                130,
                &["interrupted", "at: time ", &format!("go on with --resume --out {out}")],
            );
            let run = folder.path().join(&out);
            assert_eq!(summary(&run)["status"], "interrupted");
            assert!(summary(&run)["error"].is_null());
            let made = rows(&run);
            assert!((row..41).contains(&made), "{made} rows");
            resume(folder.path(), &out).expect(0, &["done: 40 steps"]);
            assert_same(&whole, &run);
        }
    }
}

#[test]
fn a_second_ctrl_c_stops_at_once_also_while_pictures_are_drawn() {
    let folder = TempDir::new().unwrap();
    let pictures = "pictures = 0.01\npicture = { size = 4000 }";
    fs::write(folder.path().join("scene.toml"), SCENE.replace("pictures = false", pictures))
        .unwrap();
    let run = folder.path().join("run");
    let mut child = start(folder.path(), &["run", "scene.toml", "--out", "run"]);
    wait_until(&mut child, || run.join("pictures").exists());
    interrupt(&child);
    std::thread::sleep(Duration::from_millis(20));
    interrupt(&child);
    wait(child).expect(130, &["drawing pictures"]);
    assert_eq!(summary(&run)["status"], "finished");
    assert!(!run.join("report.html").exists());
}

/// A small generator of pseudo-random numbers from 0 to 1 (Knuth's MMIX constants).
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 33) as f64 / (1u64 << 31) as f64
}

#[test]
fn runs_that_were_killed_again_and_again_end_as_if_they_had_not_been() {
    let (folder, whole, time) = with_run(SCENE);
    let run = folder.path().join("killed");
    let mut seed = 1;
    for session in 0..60 {
        let mut child = start(folder.path(), &["run", "scene.toml", "--resume", "--out", "killed"]);
        // The first ones while the model is built, the others at any moment of the steps that
        // follow: computing takes about as long as writing, so many of them are amid a file.
        let (mut target, mut delay) = (0, 0.1 * random(&mut seed));
        if session >= 3 {
            (target, delay) =
                (rows(&run) + 1 + (3.0 * random(&mut seed)) as usize, 0.03 * random(&mut seed));
        }
        wait_until(&mut child, || rows(&run) >= target);
        std::thread::sleep(time.mul_f64(delay));
        child.kill().unwrap();
        if wait(child).code == 0 {
            assert!(session > 10, "only {session} kills met the run at work");
            assert_same(&whole, &run);
            return;
        }
    }
    panic!("the run does not come on");
}

#[test]
fn a_run_without_checkpoints_that_was_killed_is_computed_from_the_beginning() {
    let (folder, whole, _) = with_run(&SCENE.replace("checkpoint = 0", "checkpoint = false"));
    let run = folder.path().join("killed");
    for row in [1, 20] {
        let mut child = start(folder.path(), &["run", "scene.toml", "--resume", "--out", "killed"]);
        wait_until(&mut child, || rows(&run) >= row);
        child.kill().unwrap();
        wait(child);
        assert!(!run.join("checkpoint/latest.bin").exists());
    }
    resume(folder.path(), "killed").expect(0, &[]);
    assert_same(&whole, &run);
}

#[test]
fn the_seconds_of_all_sessions_are_counted() {
    let (folder, whole, _) = with_run(SCENE);
    let seconds = |phase: &str| summary(&whole)["seconds"][phase].as_f64().unwrap();
    let before = ["setup", "steps", "output"].map(seconds);
    resume(folder.path(), "whole").expect(0, &[]);
    let after = ["setup", "steps", "output"].map(seconds);
    assert!(
        after[0] > before[0] && after[1] == before[1] && after[2] >= before[2],
        "{before:?} {after:?}"
    );
}

#[test]
fn nothing_of_a_run_is_lost_by_running_it_again() {
    let (folder, whole, _) = with_run(SCENE);
    let before = files(&whole);
    let run = |arguments: &[&str]| {
        immersa(folder.path(), &[&["run", "scene.toml", "--out", "whole"], arguments].concat())
    };
    let out = ["the folder holds a run already", "at: whole", "--resume", "--out"];
    run(&[]).expect(3, &out);
    run(&["--set", "time.step=0.02"]).expect(3, &out);
    run(&["--resume", "--set", "time.step=0.02"]).expect(
        2,
        &["started with another scene", "whole/scene.toml", "time.step: 0.01 became 0.02", "--set"],
    );
    assert!(before == files(&whole), "a refused run has changed the folder");

    // A run that has ended is drawn again, and that is all.
    let (copy, ended) = (folder.path().join("copy"), run(&["--resume"]));
    ended.expect(0, &["done: 40 steps"]);
    for (name, content) in before {
        let path = copy.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }
    assert_same(&copy, &whole);
}

#[test]
fn damaged_checkpoints_are_noticed_and_nothing_is_changed() {
    let (folder, whole, _) = with_run(SCENE);
    let path = whole.join("checkpoint/latest.bin");
    let good = fs::read(&path).unwrap();
    fs::remove_file(whole.join("checkpoint/earlier.bin")).unwrap();
    let record = 16 + u64::from_le_bytes(good[..8].try_into().unwrap()) as usize;
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    };
    let number = good.windows(7).position(|w| w == b"\"rows\":").unwrap() + 7;
    let cut = [0, 5, 12, 40, record, record + 30, good.len() - 1].map(|n| good[..n].to_vec());
    let changed = [0, 9, number, record + 2, record + 20, record + 60, good.len() - 1].map(flipped);
    for bytes in cut.into_iter().chain(changed) {
        fs::write(&path, &bytes).unwrap();
        let before = files(&whole);
        resume(folder.path(), "whole").expect(3, &["checkpoint", "latest.bin", "--out"]);
        assert!(before == files(&whole));
    }
    fs::write(&path, &good).unwrap();
    fs::remove_file(whole.join("series.csv")).unwrap();
    resume(folder.path(), "whole").expect(3, &["series.csv", "No such file"]);
    fs::write(whole.join("series.csv"), "time\n0.0\n").unwrap();
    resume(folder.path(), "whole")
        .expect(3, &["columns of the series", "whole/series.csv", "--out"]);
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let folder = TempDir::new().unwrap();
    // More cells than a chunk of a parallel loop holds, and both kinds of transport.
    for (transport, coupling) in [("nodal", "implicit"), ("projected", "explicit")] {
        let numerics =
            format!("thickness = 0.2\ntransport = \"{transport}\"\ncoupling = \"{coupling}\"");
        let scene = SCENE.replace("thickness = 0.2", &numerics).replace("[16, 16]", "[24, 24]");
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        same_on_two_threads(folder.path(), transport);
    }
    fs::write(folder.path().join("scene.toml"), adapted()).unwrap();
    same_on_two_threads(folder.path(), "adapted");
    assert_eq!(summary(&folder.path().join("adapted-1"))["meshes"].as_array().unwrap().len(), 2);
}

fn same_on_two_threads(folder: &Path, name: &str) {
    let [one, two] = ["1", "2"].map(|threads| {
        let out = format!("{name}-{threads}");
        let options = ["--threads", threads, "--out", &out, "--set", "time.end=0.1"];
        immersa(folder, &[&["run", "scene.toml"][..], &options].concat())
            .expect(0, &["done: 10 steps"]);
        folder.join(out)
    });
    assert_same(&one, &two);
}

#[test]
fn a_quiet_run_says_nothing() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    let ended = immersa(folder.path(), &["run", "scene.toml", "--quiet", "--set", "time.end=0.02"]);
    assert_eq!((ended.code, ended.stdout.as_str(), ended.stderr.as_str()), (0, "", ""));
    let name = folder.path().file_name().unwrap().to_str().unwrap();
    let run = folder.path().join("runs").join(format!("{name},time.end=0.02"));
    assert!(run.join("report.html").exists());
}

#[test]
fn the_book_s_case_without_grad_div_raises_the_alarm() {
    let folder = TempDir::new().unwrap();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/listing/scene.toml");
    let run = |out: &str, more: &[&str]| {
        let set = [
            "numerics.coupling=explicit",
            "time.order=1",
            "time.step=5e-3",
            "time.end=0.4",
            "output.pictures=false",
        ];
        let set = set.iter().chain(more).flat_map(|s| ["--set", *s]);
        let arguments: Vec<&str> = ["run", scene, "--out", out].into_iter().chain(set).collect();
        let ended = immersa(folder.path(), &arguments);
        (ended, summary(&folder.path().join(out)))
    };
    let (ended, wrong) = run("without", &["numerics.grad_div=0"]);
    ended.expect(0, &["ALARM: Energy balance: ", "is spurious", "numerics.grad_div"]);
    assert!(wrong["alarms"][0].as_str().unwrap().contains("Energy balance"));
    assert!(wrong["balance"]["largest_energy"].as_f64().unwrap() > 0.2);
    let report = fs::read_to_string(folder.path().join("without/report.html")).unwrap();
    assert!(report.contains("is spurious"), "the report keeps the alarm to itself");

    let (ended, right) = run("with", &[]);
    ended.expect(0, &["done: 80 steps"]);
    assert!(!ended.stderr.contains("ALARM"));
    assert_eq!(right["alarms"].as_array().unwrap().len(), 0);
    assert!(right["balance"]["largest_energy"].as_f64().unwrap() < 0.01);
}

/// A run of each kind, short and on coarse meshes.
fn kinds() -> [(&'static str, String); 8] {
    let rest = "[output]\nevery = 0.01\nfields = 0.05\npictures = false\ncheckpoint = 0\n";
    let steps = "[time]\nend = 0.4\nstep = 0.01\n";
    let square = "mesh.rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }\n";
    let circle = "shape.circle = { centre = [1, 1], radius = 0.4 }\n";
    let lid = "fluid = { density = 1, viscosity = 0.05 }\n\
        boundary = { walls.no_slip = true, top.velocity = [1, 0] }\n";
    let drop = format!(
        "{square}{lid}{steps}{rest}[[drop]]\n{circle}tension = 1\nviscosity = 0.1\n\
         surfactant = {{ concentration = 0.3, elasticity = 0.2 }}\n[numerics]\nthickness = 0.25\n"
    );
    let vortex = format!(
        "{square}fluid.prescribed_velocity = [\"1-y\", \"x-1\"]\n{steps}{rest}[[level_set]]\n{circle}"
    );
    let space = format!(
        "mesh.box = {{ min = [0, 0, 0], max = [2, 2, 2], cells = [4, 4, 4] }}\n\
         fluid = {{ density = 1, viscosity = 0.05, initial_velocity = [\"y-1\", \"1-x\", \"0\"] }}\n\
         boundary.walls.no_slip = true\n[[membrane]]\n\
         shape.sphere = {{ centre = [1, 1, 1], radius = 0.6 }}\nstretch = 1.2\n\
         area.linear = {{ modulus = 1 }}\nshear.linear = {{ modulus = 1 }}\n{steps}{rest}"
    );
    let backflow = format!(
        "{square}fluid = {{ density = 1, viscosity = 1e-3, \
         initial_velocity = [\"4*(y-1)*(2-y)*y\", \"4*(1.6-x)\"] }}\n\
         boundary = {{ right.open = true, walls.slip = true }}\n{steps}{rest}"
    );
    let slow = lid.replace("[1, 0]", "[\"t*x*(2-x)\", 0]");
    let paced = format!("{square}{slow}{steps}tolerance = 1e-3\n{rest}");
    [
        ("membrane", SCENE.into()),
        ("adapted", adapted()),
        ("moving", MOVING.into()),
        ("drop", drop),
        ("vortex", vortex),
        ("space", space),
        ("backflow", backflow),
        ("paced", paced),
    ]
}

/// Two hundred kills at random moments of runs of all kinds, and fifty races for one folder.
#[test]
#[ignore = "takes minutes: a measurement by hand, recorded in CONTRIBUTING.md"]
#[allow(clippy::print_stdout, reason = "the counts are what a run by hand is for")]
fn two_hundred_kills_and_fifty_races_leave_no_trace() {
    let mut seed = 3;
    let (mut kills, mut idle) = (0, 0);
    for (name, scene) in kinds() {
        let folder = folder_with(&scene);
        let start_of = |out: &'static str, how: &'static str| {
            start(folder.path(), &["run", "scene.toml", how, "--out", out])
        };
        let begin = Instant::now();
        immersa(folder.path(), &["run", "scene.toml", "--out", "whole"]).expect(0, &[]);
        let time = begin.elapsed();
        let [whole, run] = ["whole", "killed"].map(|out| folder.path().join(out));
        let mut of_kind = 0;
        while of_kind < 25 {
            let mut child = start_of("killed", "--resume");
            std::thread::sleep(time.mul_f64(0.7 * random(&mut seed)));
            child.kill().unwrap();
            match wait(child).code {
                0 => idle += 1,
                _ => of_kind += 1,
            }
            if summary_of(&run).is_some_and(|s| s["status"] == "finished") && of_kind < 25 {
                resume(folder.path(), "killed").expect(0, &[]);
                assert_same(&whole, &run);
                fs::remove_dir_all(&run).unwrap();
            }
        }
        resume(folder.path(), "killed").expect(0, &[]);
        assert_same(&whole, &run);
        kills += of_kind;
        println!("{name}: {of_kind} kills, the same bits");
    }
    let folder = folder_with(&SCENE.replace("end = 0.4", "end = 0.1"));
    for k in 0..50 {
        let out = format!("run-{}", k / 2);
        let how = if k % 2 == 0 { "--quiet" } else { "--resume" };
        let both = [0, 1].map(|_| start(folder.path(), &["run", "scene.toml", how, "--out", &out]));
        let codes = both.map(|child| wait(child).code);
        assert!(codes.contains(&0) && codes.iter().all(|c| [0, 3].contains(c)), "{codes:?}");
        // One that began after the other had ended is no race: it has drawn the run again.
        assert!(k % 2 == 1 || codes.contains(&3), "{codes:?}");
        assert_eq!(rows(&folder.path().join(&out)), 11);
    }
    println!("{kills} kills of runs at work ({idle} came too late), 50 races");
}

fn summary_of(run: &Path) -> Option<serde_json::Value> {
    serde_json::from_slice(&fs::read(run.join("summary.json")).ok()?).ok()
}
