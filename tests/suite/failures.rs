//! What ends a run early, through the program: the exit code, the message, and what is left in the
//! folder.

use super::meshes::recorded;
use super::program::*;
use std::fs;
use tempfile::TempDir;

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = folder_with(SCENE);
    fs::write(folder.path().join("file"), "").unwrap();
    for out in ["file", "file/run", "/proc/run", "/dev/null"] {
        let ended = immersa(folder.path(), &["run", "scene.toml", "--out", out]);
        ended.expect(3, &["run folder cannot be made", &format!("at: {out}\n"), "--out"]);
    }
    // A folder stands where a file is to be.
    let arguments = ["run", "scene.toml", "--out", "run", "--set", "time.end=0.02"];
    immersa(folder.path(), &arguments).expect(0, &[]);
    fs::remove_file(folder.path().join("run/series.csv")).unwrap();
    fs::create_dir_all(folder.path().join("run/series.csv/mine")).unwrap();
    let ended = immersa(folder.path(), &[&arguments[..], &["--overwrite"]].concat());
    ended.expect(3, &["cannot write a file", "at: run/series.csv", "directory", "--out"]);
}

#[test]
fn a_scene_that_is_wrong_leaves_no_folder_and_can_be_run_once_it_is_mended() {
    let folder = folder_with(&SCENE.replace("boundary.top", "boundary.lid"));
    let arguments = ["run", "scene.toml", "--out", "run", "--set", "time.end=0.02"];
    immersa(folder.path(), &arguments).expect(3, &["boundary.lid"]);
    assert!(!folder.path().join("run").exists());
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    immersa(folder.path(), &arguments).expect(0, &[]);
}

/// A run whose files may not grow beyond `blocks` of 512 bytes, which stops it at `file`; with more
/// space it ends as `whole` did.
fn full_disk(folder: &TempDir, blocks: u64, file: &str) {
    let (at, out) = (folder.path(), format!("full-{blocks}"));
    let ended = immersa_within(at, blocks, &["run", "scene.toml", "--out", &out]);
    ended.expect(
        3,
        &[
            "cannot write a file",
            &format!("at: {out}/{file}"),
            "File too large",
            "free space on this disk",
        ],
    );
    let run = at.join(&out);
    for (name, content) in files(&run) {
        assert!(!name.ends_with(".part"), "{name} is left");
        assert!(content.len() as u64 <= 512 * blocks);
        if name == "series.csv" {
            assert!(content.ends_with(b"\n"), "a piece of a row is left");
        }
    }
    if run.join("summary.json").exists() {
        let summary = summary(&run);
        assert_eq!(summary["status"], "failed");
        assert!(summary["error"].as_str().unwrap().contains(file));
    }
    immersa(at, &["run", "scene.toml", "--out", &out, "--resume"]).expect(0, &["done: 40 steps"]);
    assert_same(&at.join("whole"), &run);
}

fn whole(scene: &str) -> TempDir {
    let folder = folder_with(scene);
    immersa(folder.path(), &["run", "scene.toml", "--out", "whole"]).expect(0, &[]);
    folder
}

#[test]
fn a_full_disk_stops_the_run_and_space_lets_it_go_on() {
    let folder = whole(SCENE);
    full_disk(&folder, 1, "scene.toml");
    full_disk(&folder, 60, "fields/000001.vtu");
    let folder = whole(&SCENE.replace("fields = 0.01", "fields = false"));
    // The record in a checkpoint grows with the run: a limit just below the size at the end is met
    // on the way.
    let size = fs::metadata(folder.path().join("whole/checkpoint/latest.bin")).unwrap().len();
    full_disk(&folder, (size - 300) / 512, "checkpoint/latest.bin");
    let folder = whole(
        &SCENE
            .replace("fields = 0.01", "fields = false")
            .replace("checkpoint = 0", "checkpoint = false"),
    );
    full_disk(&folder, 20, "series.csv");
}

#[test]
fn broken_meshes_are_refused_by_name() {
    let header = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
    let square = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n";
    let fan = "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 -1 0\n5 1 -1 0\n$EndNodes\n";
    let binary = recorded("pieces-41-bin.msh");
    let cube = recorded("cube-41-bin.msh");
    let text = |nodes: &str, elements: &str| {
        format!("{header}{nodes}$Elements\n{elements}$EndElements\n").into_bytes()
    };
    let triangles = "2\n1 2 0 1 2 3\n2 2 0 1 3 4\n";
    let apart = "$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 5 0 0\n5 6 0 0\n6 5 1 0\n$EndNodes\n";
    let cases: [(&str, Vec<u8>, &[&str]); 10] = [
        ("apart", text(apart, "2\n1 2 0 1 2 3\n2 2 0 4 5 6\n"), &["not connected", "2 parts"]),
        ("cut", binary[..binary.len() / 2].to_vec(), &["byte"]),
        ("empty", Vec::new(), &["$MeshFormat"]),
        (
            "nan",
            text(&square.replace("3 1 1 0", "3 nan 1 0"), triangles),
            &["not a finite", "point 3", "NaN"],
        ),
        ("fan", text(fan, "3\n1 2 0 1 2 3\n2 2 0 1 4 2\n3 2 0 1 5 2\n"), &["manifold", "cell 2"]),
        ("quadrangle", text(square, "1\n1 3 0 1 2 3 4\n"), &["quadrangle"]),
        ("flat", text(&square.replace("3 1 1 0", "3 2 0 0"), triangles), &["cell 0"]),
        ("missing-point", text(square, "1\n1 2 0 1 2 9\n"), &["9"]),
        ("lines-only", text(square, "1\n1 1 0 1 2\n"), &["triangle"]),
        ("solid", cube, &["triangle"]),
    ];
    for (name, bytes, words) in cases {
        let folder = folder_with(&SCENE.replace(
            "rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16], \
             diagonals = \"union-jack\" }",
            &format!("file = \"{name}.msh\""),
        ));
        fs::write(folder.path().join(format!("{name}.msh")), bytes).unwrap();
        for command in ["run", "explain"] {
            let ended = immersa(folder.path(), &[command, "scene.toml"]);
            ended.expect(3, &["error: ", &format!("{name}.msh"), "value: ", "remedy: "]);
            ended.expect(3, words);
        }
    }
}

#[test]
fn what_does_not_fit_the_mesh_is_refused_with_its_place() {
    let names = ["names in this mesh: bottom, left, right, top, walls"];
    let cases: [(&str, &str, i32, &[&str]); 9] = [
        ("boundary.top", "boundary.lid", 3, &["boundary.lid", names[0]]),
        (
            "lid = { boundary = \"top\" }",
            "lid = { boundary = \"lid\" }",
            3,
            &["output.forces.lid.boundary", names[0]],
        ),
        (
            "boundary = \"left\"",
            "boundary = \"inlet\"",
            3,
            &["output.fluxes.side.boundary", names[0]],
        ),
        (
            "thickness = 0.2",
            "thickness = 0.1",
            2,
            &["thinner than the mesh allows", "0.1", "refine the mesh"],
        ),
        (
            "thickness = 0.2",
            "thickness = 0.7",
            2,
            &["reaches the boundary", "0.7", "smaller thickness"],
        ),
        (
            "centre = [1, 1]",
            "centre = [1.8, 1]",
            2,
            &["does not lie inside the domain", "membrane.0.shape", "2.35"],
        ),
        (
            "at = [1.1, 0.9]",
            "at = [3, 1]",
            2,
            &["outside the mesh", "output.probes.middle", "[3.0, 1.0]"],
        ),
        (
            "to = [2, 1]",
            "to = [2, 3]",
            2,
            &["outside the mesh", "output.profiles.pressure", "spans"],
        ),
        (
            "\"0.2 * t * sin(pi * x / 2)\", 0",
            "0, 1",
            2,
            &["more fluid in than out", "net outflow", "open = true"],
        ),
    ];
    let law = "area.linear = { modulus = 1 }";
    let scene = SCENE.replace(law, &format!("{law}\nforce = \"smeared\""));
    for (from, to, code, words) in cases {
        assert!(scene.contains(from), "{from}");
        let folder = folder_with(&scene.replacen(from, to, 1));
        let ended = immersa(folder.path(), &["run", "scene.toml"]);
        ended.expect(code, words);
        ended.expect(code, &["error: ", "remedy: "]);
    }
}

#[test]
fn a_lid_that_leaks_by_rounding_alone_is_closed() {
    // sin(pi x) is 1e-16 in the corner, where the lid meets the wall beside it.
    let scene = SCENE.replace("0.2 * t * sin(pi * x / 2)", "sin(pi * x)");
    let folder = folder_with(&scene);
    immersa(folder.path(), &["run", "scene.toml", "--set", "time.end=0.02"]).expect(0, &[]);
}

#[test]
fn a_blow_up_keeps_the_last_good_state_and_says_what_to_do() {
    let folder = folder_with(&SCENE.replace("fields = 0.01", "fields = 0.1"));
    let explicit = ["numerics.coupling=explicit", "membrane.0.area.linear.modulus=2000"];
    let arguments = |more: &[&'static str]| {
        let set = explicit.iter().chain(more).flat_map(|s| ["--set", *s]);
        ["run", "scene.toml", "--out", "run"].into_iter().chain(set).collect::<Vec<_>>()
    };
    // The plan warns of it before.
    let plan = immersa(folder.path(), &[&["explain", "scene.toml"], &arguments(&[])[4..]].concat());
    assert!(
        plan.stdout.contains("the explicit coupling will be unstable: take a smaller step"),
        "{}",
        plan.stdout
    );

    let words = [
        "the computation blew up",
        "at: time 0.0",
        "largest velocity",
        "smaller time.step",
        "implicit",
    ];
    let run = folder.path().join("run");
    immersa(folder.path(), &arguments(&[])).expect(4, &words);
    let kept = summary(&run);
    assert_eq!(kept["status"], "failed");
    assert!(kept["error"].as_str().unwrap().contains("blew up"));
    let steps = kept["steps"].as_u64().unwrap() as usize;
    assert!((1..40).contains(&steps));
    assert_eq!(rows(&run), steps + 1);
    assert!(
        run.join(format!("fields/{steps:06}.vtu")).exists(),
        "the last good state is not among the fields"
    );
    assert!(
        fs::read_to_string(run.join("fields.pvd")).unwrap().contains(&format!("{steps:06}.vtu"))
    );
    assert!(fs::read_to_string(run.join("report.html")).unwrap().contains("blew up"));
    // The same again: the state before it is the last good one.
    immersa(folder.path(), &[&arguments(&[])[..], &["--resume"]].concat()).expect(4, &words);
    assert_eq!(summary(&run)["steps"].as_u64().unwrap() as usize, steps);

    // Without grad-div, far beyond the limit.
    fs::remove_dir_all(&run).unwrap();
    immersa(folder.path(), &arguments(&["numerics.grad_div=0"])).expect(4, &words);
}
