//! Run folders: one writer, nothing of the user's overwritten, runs that go on.

use super::program::*;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

const RUN: [&str; 4] = ["run", "scene.toml", "--out", "run"];

fn with(arguments: &[&'static str]) -> Vec<&'static str> {
    [&RUN[..], arguments].concat()
}

/// A run of the scene that has ended, in `run`.
fn ended() -> TempDir {
    let folder = folder_with(SCENE);
    immersa(folder.path(), &with(&["--set", "time.end=0.1"])).expect(0, &["done: 10 steps"]);
    folder
}

/// 07-two-resumes, F1: while a process writes to a folder, no other one does.
#[test]
fn a_folder_has_one_writer() {
    let folder = folder_with(&SCENE.replace("end = 0.4", "end = 40"));
    let run = folder.path().join("run");
    let mut child = start(folder.path(), &RUN);
    wait_until(&mut child, || rows(&run) > 2);
    let pid = format!("process {}", child.id());
    let refused = ["another process writes to this run folder", "at: run", &pid];
    immersa(folder.path(), &with(&["--resume"])).expect(3, &refused);
    immersa(folder.path(), &with(&["--overwrite"])).expect(3, &refused);
    fs::write(run.join("summary.json"), "{}").unwrap();
    immersa(folder.path(), &["render", "run"]).expect(3, &refused);
    interrupt(&child);
    wait(child).expect(130, &["go on with --resume", "immersa render run"]);
    // A lock ends with its process.
    immersa(folder.path(), &["render", "run"]).expect(0, &[]);
    assert!(
        fs::read_to_string(run.join("report.html")).unwrap().contains("was interrupted at t =")
    );
    // The report of an interruption is not that of the run that goes on.
    let mut child = start(folder.path(), &with(&["--resume"]));
    let before = rows(&run);
    wait_until(&mut child, || rows(&run) > before + 2);
    assert!(!run.join("report.html").exists());
    interrupt(&child);
    wait(child).expect(130, &[]);
}

/// Of two runs that begin at the same time in one folder, one is refused.
#[test]
fn of_two_new_runs_at_once_one_is_refused() {
    let folder = folder_with(&SCENE.replace("end = 0.4", "end = 0.1"));
    for k in 0..5 {
        let out = format!("run-{k}");
        let both = [0, 1].map(|_| start(folder.path(), &["run", "scene.toml", "--out", &out]));
        let mut codes = both.map(|child| wait(child).code);
        codes.sort_unstable();
        assert_eq!(codes, [0, 3]);
        assert_eq!(rows(&folder.path().join(&out)), 11);
    }
}

/// 08-foreign-files-overwritten, F3.
#[test]
fn a_folder_that_holds_something_else_is_left_alone() {
    let folder = folder_with(SCENE);
    let other = folder.path().join("other");
    fs::create_dir(&other).unwrap();
    fs::write(other.join("series.csv"), "my,data\n").unwrap();
    let before = files(folder.path());
    let refused = ["not empty and holds no run", "nothing in it is overwritten", "--out"];
    for out in ["other", "."] {
        for more in [&[][..], &["--resume"], &["--overwrite"]] {
            let arguments = [&["run", "scene.toml", "--out", out][..], more].concat();
            immersa(folder.path(), &arguments).expect(3, &refused);
            assert!(files(folder.path()) == before);
        }
    }
    immersa(folder.path(), &["render", "other"]).expect(3, &["not the folder of a run"]);
    assert!(files(folder.path()) == before);
    // An empty folder is as good as none.
    fs::create_dir(folder.path().join("run")).unwrap();
    immersa(folder.path(), &with(&["--set", "time.end=0.02"])).expect(0, &["done"]);
}

/// F4: nothing is written through a link.
#[test]
fn links_out_of_a_folder_are_not_followed() {
    for name in ["series.csv", "pictures", "checkpoint/latest.bin"] {
        let folder = ended();
        let (run, away) = (folder.path().join("run"), folder.path().join("away"));
        let _ = fs::remove_file(run.join(name));
        let _ = fs::remove_dir_all(run.join(name));
        fs::create_dir(&away).unwrap();
        symlink(&away, run.join(name)).unwrap();
        let refused = ["is a link to another place", &format!("run/{name}"), "remove the link"];
        immersa(folder.path(), &with(&["--resume", "--set", "time.end=0.2"])).expect(3, &refused);
        immersa(folder.path(), &["render", "run"]).expect(3, &refused);
        assert_eq!(fs::read_dir(&away).unwrap().count(), 0);
    }
}

#[test]
fn a_run_is_replaced_when_it_is_asked_for_and_its_neighbours_stay() {
    let folder = ended();
    let run = folder.path().join("run");
    fs::write(run.join("notes.md"), "mine").unwrap();
    fs::write(run.join("fields/mine.txt"), "mine").unwrap();
    immersa(folder.path(), &RUN).expect(3, &["holds a run already", "--resume", "--overwrite"]);
    let replaced = immersa(folder.path(), &with(&["--overwrite", "--set", "time.end=0.05"]));
    replaced.expect(0, &["done: 5 steps"]);
    assert_eq!(rows(&run), 6);
    let all = files(&run);
    assert!(["notes.md", "fields/mine.txt"].iter().all(|name| all[*name] == b"mine"));
    assert_eq!(all.keys().filter(|name| name.ends_with(".vtu")).count(), 6);
}

/// A finished run goes on to a later end, with other output, and is the run that would have been
/// made at once; what changes the physics is refused with what it is.
#[test]
fn a_finished_run_goes_on_to_a_later_end() {
    let folder = ended();
    let far = ["--set", "time.end=0.2"];
    immersa(folder.path(), &with(&["--resume", far[0], far[1]])).expect(0, &["done: 20 steps"]);
    immersa(folder.path(), &["run", "scene.toml", "--out", "whole", far[0], far[1]])
        .expect(0, &["done: 20 steps"]);
    let [run, whole] = ["run", "whole"].map(|out| folder.path().join(out));
    assert_same(&run, &whole);
    let sparse = ["--resume", "--set", "time.end=0.3", "--set", "output.fields=0.1"];
    immersa(folder.path(), &with(&sparse)).expect(0, &["done: 30 steps"]);
    let fields = files(&run).keys().filter(|name| name.ends_with(".vtu")).count();
    assert_eq!((rows(&run), fields), (31, 22));
    let other = ["--resume", "--set", "fluid.viscosity=0.02", "--set", "membrane.0.stretch=1.1"];
    immersa(folder.path(), &with(&other)).expect(
        2,
        &[
            "started with another scene",
            "fluid.viscosity: 0.01 became 0.02",
            "membrane.0.stretch: 1.2 became 1.1",
            "time.end",
        ],
    );
}

/// F2: the mesh file has become another one.
#[test]
fn a_run_does_not_go_on_with_another_mesh() {
    let folder = folder_with(&SCENE.replace(
        "rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16], diagonals = \"union-jack\" }",
        "file = \"m.msh\"",
    ));
    let geometry = |edge: f64| {
        let text = format!(
            "SetFactory(\"OpenCASCADE\"); Rectangle(1) = {{0, 0, 0, 2, 2}};\n\
             Mesh.MeshSizeMax = {edge}; Physical Surface(\"fluid\") = {{1}};\n\
             Physical Curve(\"bottom\") = {{1}}; Physical Curve(\"right\") = {{2}};\n\
             Physical Curve(\"top\") = {{3}}; Physical Curve(\"left\") = {{4}};\n"
        );
        fs::write(folder.path().join("m.geo"), text).unwrap();
        let made = Command::new("gmsh")
            .current_dir(folder.path())
            .args(["m.geo", "-2", "-format", "msh41", "-o", "m.msh"])
            .output();
        made.is_ok_and(|o| o.status.success())
    };
    if !geometry(0.15) {
        // Without gmsh there is no mesh to exchange.
        return;
    }
    immersa(folder.path(), &with(&["--set", "time.end=0.05"])).expect(0, &["done: 5 steps"]);
    let far = with(&["--resume", "--set", "time.end=0.1"]);
    assert!(geometry(0.14));
    immersa(folder.path(), &far)
        .expect(3, &["`mesh` is not what the run was started with", "scene.toml", "put back"]);
    assert!(geometry(0.15));
    immersa(folder.path(), &far).expect(0, &["done: 10 steps"]);
}

/// A damaged checkpoint costs the steps since the one before, and nothing else.
#[test]
fn the_checkpoint_before_the_last_is_there() {
    let folder = ended();
    let run = folder.path().join("run");
    let (before, latest) = (files(&run), run.join("checkpoint/latest.bin"));
    for damage in [|p: &Path| fs::write(p, "damage"), |p: &Path| fs::remove_file(p)] {
        damage(&latest).unwrap();
        immersa(folder.path(), &with(&["--resume", "--set", "time.end=0.1"]))
            .expect(0, &["the last checkpoint cannot be used", "from the one before"]);
        let after = files(&run);
        assert!(before["series.csv"] == after["series.csv"]);
        assert!(before["fields/000010.vtu"] == after["fields/000010.vtu"]);
    }
}

#[test]
fn field_files_that_are_gone_are_noticed() {
    let folder = ended();
    fs::remove_file(folder.path().join("run/fields/000003.vtu")).unwrap();
    immersa(folder.path(), &with(&["--resume", "--set", "time.end=0.2"]))
        .expect(0, &["field files of the run are missing: fields/000003.vtu", "done: 20 steps"]);
    let list = fs::read_to_string(folder.path().join("run/fields.pvd")).unwrap();
    assert!(list.contains("000002") && !list.contains("000003"));
}

/// A queue ends a job with SIGTERM, a closed terminal with SIGHUP.
#[test]
fn other_signals_end_a_run_as_ctrl_c_does() {
    let folder = folder_with(&SCENE.replace("end = 0.4", "end = 40"));
    for signal in ["-TERM", "-HUP"] {
        let out = format!("run{signal}");
        let run = folder.path().join(&out);
        let mut child = start(folder.path(), &["run", "scene.toml", "--out", &out]);
        wait_until(&mut child, || rows(&run) > 2);
        let id = child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
        wait(child).expect(130, &["interrupted", "--resume"]);
        assert_eq!(summary(&run)["status"], "interrupted");
    }
}

/// L1, L2.
#[test]
fn output_to_a_full_disk_is_an_error() {
    let folder = folder_with(SCENE);
    for command in ["explain scene.toml", "reference", "reference numerics"] {
        let script = format!("exec \"$0\" {command} > /dev/full");
        let mut shell = Command::new("sh");
        shell.current_dir(folder.path()).args(["-c", &script, env!("CARGO_BIN_EXE_immersa")]);
        let ended = shell.output().unwrap();
        let told = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(3), "{told}");
        assert!(told.contains("cannot be written") && told.contains("free space"), "{told}");
    }
}

/// What the terminal showed is kept, with who ran it and when.
#[test]
fn a_run_keeps_a_log() {
    let folder = ended();
    let log = || fs::read_to_string(folder.path().join("run/log.txt")).unwrap();
    let first = log();
    let version = format!("immersa {}", env!("CARGO_PKG_VERSION"));
    for word in [&*version, "run scene.toml --out run", "threads on", "Navier-Stokes", "done: 10"] {
        assert!(first.contains(word), "`{word}` is missing in\n{first}");
    }
    let dated =
        |line: &str| line.get(..20).is_some_and(|t| t.starts_with("20") && t.ends_with('Z'));
    assert!(first.lines().all(dated), "{first}");
    immersa(folder.path(), &with(&["--resume", "--set", "time.end=0.2"])).expect(0, &[]);
    assert!(log().starts_with(&first) && log().contains("done: 20 steps"));
    // The summary and the report know both commands.
    let run = folder.path().join("run");
    let sessions = summary(&run)["sessions"].as_array().unwrap().clone();
    let commands: Vec<&str> = sessions.iter().map(|s| s["command"].as_str().unwrap()).collect();
    assert!(commands.len() == 2 && commands[1].ends_with("--resume --set time.end=0.2"));
    assert!(sessions.iter().all(|s| s["ended"].as_str() >= s["started"].as_str()));
    assert!(sessions[0]["started"].as_str().is_some_and(dated));
    let page = fs::read_to_string(run.join("report.html")).unwrap();
    assert!(commands.iter().all(|command| page.contains(command)), "{commands:?}");
}

/// The folder of a scene with changes has them in its name.
#[test]
fn changes_of_a_scene_have_folders_of_their_own() {
    let folder = folder_with(SCENE);
    fs::rename(folder.path().join("scene.toml"), folder.path().join("lid.toml")).unwrap();
    let run = |set: &[&str]| {
        let set = set.iter().flat_map(|s| ["--set", *s]);
        let arguments: Vec<&str> = ["run", "lid.toml"].into_iter().chain(set).collect();
        immersa(folder.path(), &arguments).expect(0, &["done"]);
    };
    run(&["time.end=0.02"]);
    run(&["time.end=0.02", "boundary.top.velocity=[\"0.1*t\", 0]"]);
    let long = format!("title=\"{}\"", "long ".repeat(50));
    run(&["time.end=0.02", &long]);
    let mut names: Vec<String> = fs::read_dir(folder.path().join("runs"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names[0], "lid,time.end=0.02");
    assert_eq!(names[1], "lid,time.end=0.02,boundary.top.velocity=0.1t0");
    assert!(names[2].starts_with("lid,time.end=0.02,title=long") && names[2].len() < 140);
}

/// A run on a mesh file goes on after both were moved together, from the scene that it keeps too.
#[test]
fn a_run_and_its_mesh_can_be_moved_together() {
    let above = TempDir::new().unwrap();
    let [first, second] = ["first", "second"].map(|name| above.path().join(name));
    fs::create_dir(&first).unwrap();
    fs::copy("meshes/channel.msh", first.join("channel.msh")).unwrap();
    let scene = "mesh.file = \"channel.msh\"\nfluid.viscosity = 0.1\n[boundary]\n\
        walls.no_slip = true\ncylinder.no_slip = true\ninlet.velocity = [1, 0]\n\
        outlet.open = true\n[time]\nend = 0.4\nstep = 0.1\n[output]\npictures = false\n";
    fs::write(first.join("scene.toml"), scene).unwrap();
    let until = |folder: &Path, scene: &str, end: &str| {
        let end = format!("time.end={end}");
        immersa(folder, &["run", scene, "--resume", "--out", "run", "--set", &end])
    };
    until(&first, "scene.toml", "0.1").expect(0, &[]);
    let kept = fs::read_to_string(first.join("run/scene.toml")).unwrap();
    assert!(kept.contains("file = \"../channel.msh\""), "{kept}");
    fs::rename(&first, &second).unwrap();
    until(&second, "scene.toml", "0.2").expect(0, &["done: 2 steps"]);
    until(&second, "run/scene.toml", "0.3").expect(0, &["done: 3 steps"]);
    // Another mesh under the same name is another run.
    fs::copy("meshes/cylinder.msh", second.join("channel.msh")).unwrap();
    let told = until(&second, "scene.toml", "0.4");
    assert!(told.code != 0 && told.stderr.contains("mesh"), "{}", told.stderr);
}

/// A mark that is a link, or a file of the user's, is left alone.
#[test]
fn a_mark_that_is_not_the_program_s_is_left_alone() {
    let folder = folder_with(SCENE);
    let [linked, filled] = ["linked", "filled"].map(|name| folder.path().join(name));
    let precious = folder.path().join("precious.txt");
    fs::write(&precious, "mine").unwrap();
    for folder in [&linked, &filled] {
        fs::create_dir(folder).unwrap();
    }
    symlink("../precious.txt", linked.join("immersa.run")).unwrap();
    fs::write(filled.join("immersa.run"), "my notes").unwrap();
    for out in ["linked", "filled"] {
        let told = immersa(folder.path(), &["run", "scene.toml", "--out", out, "--overwrite"]);
        told.expect(3, &["immersa.run", "--out"]);
        immersa(folder.path(), &["run", "scene.toml", "--out", out]).expect(3, &["immersa.run"]);
    }
    assert_eq!(fs::read_to_string(&precious).unwrap(), "mine");
    assert_eq!(fs::read_to_string(filled.join("immersa.run")).unwrap(), "my notes");
}

/// Files of the user's among those of a run stay when it is replaced.
#[test]
fn files_between_those_of_a_run_stay_when_it_is_replaced() {
    let folder = ended();
    let run = folder.path().join("run");
    let own = ["charts/mine.svg", "pictures/mine.png", "profiles/my.csv", "fields/mine.vtu"];
    for name in own {
        fs::create_dir_all(run.join(name).parent().unwrap()).unwrap();
        fs::write(run.join(name), "mine").unwrap();
    }
    let short = ["--overwrite", "--set", "time.end=0.05"];
    immersa(folder.path(), &with(&short)).expect(0, &["done: 5 steps"]);
    assert!(own.iter().all(|name| fs::read_to_string(run.join(name)).unwrap() == "mine"));
    assert!(!run.join("fields/000010.vtu").exists());
}

/// A run does not go on to an end that it has passed, and is not shown with another physics.
#[test]
fn a_run_is_neither_resumed_backwards_nor_shown_with_other_values() {
    let folder = ended();
    let back = with(&["--resume", "--set", "time.end=0.05"]);
    immersa(folder.path(), &back).expect(2, &["passed this end", "later time.end"]);
    let other = ["render", "run", "--set", "fluid.viscosity=3"];
    immersa(folder.path(), &other).expect(2, &["as it was computed", "output.picture"]);
    immersa(folder.path(), &["render", "run", "--set", "output.picture.size=300"]).expect(0, &[]);
    assert_eq!(rows(&folder.path().join("run")), 11);
}

/// What has no end is not read to its end.
#[test]
fn devices_are_not_read_as_meshes_and_scenes() {
    let mesh = SCENE.replace(
        "rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16], diagonals = \"union-jack\" }",
        "file = \"/dev/zero\"",
    );
    let folder = folder_with(&mesh);
    let words = ["no plain file"];
    immersa(folder.path(), &["explain", "scene.toml"]).expect(3, &words);
    immersa(folder.path(), &["explain", "/dev/zero"]).expect(2, &words);
    let many = ["explain", "scene.toml", "--threads", "100000"];
    assert_ne!(immersa(folder.path(), &many).code, 0);
    let many = ["run", "scene.toml", "--out", "r", "--threads", "100000"];
    immersa(folder.path(), &many).expect(2, &["--threads", "at most"]);
}
