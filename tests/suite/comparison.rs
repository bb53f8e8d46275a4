//! `immersa compare`, with FreeFEM where it is installed, with its recorded results, and with a
//! program that stands in for it.

use super::program::{Ended, files, immersa};
use immersa::mesh::{freefem, gmsh};
use immersa::scene::Scene;
use immersa::studies::{Case, Twin};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

/// Runs `immersa compare SCENE ARGUMENTS` with programs looked for in `path` alone.
fn compare_within(path: &Path, folder: &Path, scene: &Path, arguments: &[&str]) -> Ended {
    let mut command = Command::new(env!("CARGO_BIN_EXE_immersa"));
    command
        .current_dir(folder)
        .env("PATH", path)
        .arg("compare")
        .arg(scene)
        .args(["--out", "cmp", "--repeat", "1"]);
    let output = command.args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended {
        code: output.status.code().unwrap_or(-1),
        stdout: text(output.stdout),
        stderr: text(output.stderr),
    }
}

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.stdout)
        .unwrap_or_else(|e| panic!("{e}\n{}\n{}", ended.stdout, ended.stderr))
}

fn relative(found: &Value, quantity: &str) -> f64 {
    let rows = found["tables"]["differences"].as_array().unwrap();
    let row = rows
        .iter()
        .find(|r| r["quantity"] == quantity)
        .unwrap_or_else(|| panic!("no {quantity} in {rows:?}"));
    row["relative"].as_f64().unwrap()
}

/// Tolerance and source: FreeFEM computes the same scheme on the same mesh; what is left are the
/// quadrature of the energy and the tracing of characteristics.
#[test]
#[allow(clippy::print_stdout, reason = "says what was tried, and the numbers")]
fn the_listing_agrees_with_freefem_live_or_recorded() {
    let out = TempDir::new().unwrap();
    let scene = example("listing").join("scene.toml");
    let arguments = [
        "compare",
        scene.to_str().unwrap(),
        "--out",
        "cmp",
        "--repeat",
        "1",
        "--set",
        "time.end=0.1",
        "--json",
    ];
    let bounds = [
        "--within",
        "1e-3",
        "--within",
        "membrane.horizontal=1e-5",
        "--within",
        "membrane.vertical=1e-5",
    ];
    let run = || immersa(out.path(), &[&arguments[..], &bounds].concat());
    let first = run();
    first.expect(0, &[]);
    let found = json(&first);
    let recorded = found["notes"].to_string().contains("recorded");
    println!("FreeFEM: {}", if recorded { "not installed, recorded results" } else { "ran here" });
    assert!(
        relative(&found, "membrane.area") < 1e-5 && relative(&found, "energy_kinetic") < 1e-4,
        "{found}"
    );
    let times = found["tables"]["times"].as_array().unwrap();
    assert_eq!(times.len(), if recorded { 2 } else { 3 });
    assert!(times.iter().all(|t| t["per later step"].as_f64().unwrap() > 0.0), "{times:?}");
    for file in [
        "report.html",
        "side_by_side.csv",
        "study.json",
        "charts/membrane_horizontal.svg",
        "charts/differences.svg",
    ] {
        assert!(fs::metadata(out.path().join("cmp").join(file)).unwrap().len() > 0, "{file}");
    }
    // Nothing runs twice.
    let before = files(&out.path().join("cmp/runs"));
    let again = run();
    again.expect(0, &[]);
    assert_eq!(json(&again)["tables"], found["tables"]);
    assert!(files(&out.path().join("cmp/runs")) == before);
    // A bound that is not kept is a failure.
    let strict =
        immersa(out.path(), &[&arguments[..], &["--within", "membrane.area=1e-12"]].concat());
    strict.expect(4, &["differ by more than --within", "membrane.area", "1e-12"]);
}

#[test]
fn without_freefem_what_was_recorded_is_taken_and_marked() {
    let out = TempDir::new().unwrap();
    let scene = example("relaxing-ellipse").join("scene.toml");
    let coarse = [
        "--set",
        "mesh.rectangle.cells=[30, 30]",
        "--set",
        "time.end=0.1",
        "--set",
        "output.every=0.1",
    ];
    let found =
        compare_within(out.path(), out.path(), &scene, &[&coarse[..], &["--json"]].concat());
    found.expect(0, &["not installed"]);
    let found = json(&found);
    for part in
        ["recorded", "apt-get install freefem++", "freefem_n30_dt1.25e-3.csv", "FreeFem++ 4"]
    {
        assert!(found["notes"].to_string().contains(part), "{part}: {}", found["notes"]);
    }
    assert!(
        relative(&found, "membrane.horizontal") < 2e-5
            && relative(&found, "membrane.vertical") < 2e-5
    );
    assert!(found["tables"]["times"][1]["over immersa's"].is_null(), "seconds of another machine");
    let page = fs::read_to_string(out.path().join("cmp/report.html")).unwrap();
    assert!(page.contains("FreeFEM (recorded)"));
    let none = compare_within(
        out.path(),
        out.path(),
        &scene,
        &[&coarse[..], &["--set", "membrane.0.stretch=1.1"]].concat(),
    );
    none.expect(3, &["not installed", "no result was recorded", "apt-get", "-stretch 1.2625316"]);
    let record =
        compare_within(out.path(), out.path(), &scene, &[&coarse[..], &["--record", "x"]].concat());
    record.expect(3, &["nothing to record"]);
}

/// What the cases of `examples/` recorded belongs to them as they are.
#[test]
fn recorded_results_fit_their_cases() {
    for name in ["listing", "relaxing-ellipse"] {
        let path = example(name).join("scene.toml");
        let twin = Twin::read(&Twin::beside(&path)).unwrap();
        let scene = Scene::load(&path, twin.settings()).unwrap();
        let reading = Case::new(&twin, &scene).unwrap().recorded().unwrap();
        assert!(
            reading.recorded.is_some()
                && reading.table.rows() == 21
                && reading.about.steps.is_some(),
            "{name}"
        );
    }
}

/// A twin of one line for a program that stands in for FreeFEM: what it prints and writes is in the
/// script itself.
struct Stand {
    folder: TempDir,
}

const FLOW: &str = "[mesh]\n\
    rectangle = { min = [0, 0], max = [1, 1], cells = [2, 2] }\n\
    [fluid]\nviscosity = 1\n\
    [boundary.walls]\nno_slip = true\n\
    [time]\nend = 0.2\nstep = 0.1\norder = 1\n\
    [output]\nevery = 0.1\n";

impl Stand {
    fn new() -> Stand {
        let folder = TempDir::new().unwrap();
        // Runs the lines of the twin that begin with `//$` with the name of the output as $OUT.
        let program = "#!/bin/sh\nfor a; do [ \"$last\" = -out ] && OUT=$a; case $a in *.edp) \
            T=$a;; esac; last=$a; done\n\
                       export OUT ARGS=\"$*\"\n/usr/bin/env -i OUT=\"$OUT\" ARGS=\"$ARGS\" \
                       /bin/sh -c \"$(/bin/sed -n 's|^//\\$||p' \"$T\")\"\n";
        let path = folder.path().join("FreeFem++");
        fs::write(&path, program).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
        fs::write(folder.path().join("scene.toml"), FLOW).unwrap();
        Stand { folder }
    }
    fn compare(&self, twin: &str, arguments: &[&str]) -> Ended {
        let folder = self.folder.path();
        fs::write(folder.join("twin.edp"), twin).unwrap();
        compare_within(folder, folder, &folder.join("scene.toml"), arguments)
    }
}

const ROWS: &str = "//$ printf 'time,velocity_max\\n0,0\\n0.1,0\\n0.2,0\\n' > $OUT\n";

#[test]
fn a_twin_may_have_one_way_to_work_and_say_nothing_of_its_cost() {
    let stand = Stand::new();
    let ended =
        stand.compare(&format!("{ROWS}//$ case $ARGS in *-loop*) exit 3;; esac\n"), &["--json"]);
    ended.expect(0, &[]);
    let found = json(&ended);
    assert_eq!(relative(&found, "velocity_max"), 0.0);
    assert_eq!(found["tables"]["times"].as_array().unwrap().len(), 2);
}

#[test]
fn a_twin_that_fails_is_an_error_with_its_last_words() {
    let stand = Stand::new();
    let fails = stand.compare("//$ echo 'Error line number 7, syntax error'; exit 1\n", &[]);
    fails.expect(4, &["FreeFEM failed", "twin.edp", "Error line number 7", "log.txt"]);
    let silent = stand.compare("//$ echo 'nothing written'\n", &[]);
    silent.expect(4, &["FreeFEM wrote no table", "nothing written"]);
    let wild = stand.compare("//$ printf 'time,velocity_max\\n0,0\\n0.1,nan\\n' > $OUT\n", &[]);
    wild.expect(4, &["no number", "velocity_max", "smaller time.step"]);
    let strange = stand.compare("//$ printf 'time,u\\n0,0\\n0.1,0\\n' > $OUT\n", &[]);
    strange.expect(3, &["no quantity or no time in common", "time, u", "velocity_max"]);
    let foreign = stand.compare(&format!("//@ -k membrane.0.stretch\n{ROWS}"), &[]);
    foreign.expect(2, &["no such value", "membrane.0.stretch", "--twin"]);
}

#[test]
fn a_wrong_command_line_is_told() {
    let out = TempDir::new().unwrap();
    fs::write(out.path().join("scene.toml"), FLOW).unwrap();
    for (arguments, code, words) in [
        (&["--within", "close"][..], 2, ["close", "positive number"]),
        (&["--within", "membrane.area=-1"], 2, ["membrane.area=-1", "positive number"]),
        (&["--repeat", "0"], 2, ["--repeat", "0"]),
        (&[], 3, ["no FreeFEM twin", "--twin"]),
    ] {
        immersa(out.path(), &[&["compare", "scene.toml"], arguments].concat()).expect(code, &words);
    }
}

/// The mesh that FreeFEM reads is the one that was written: sizes, area, and the length of every
/// boundary by its label.
#[test]
#[allow(clippy::print_stdout, reason = "says what was tried, and the numbers")]
fn a_mesh_goes_to_freefem_and_back() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("meshes/cylinder.msh");
    let (mesh, _) = gmsh::read::<2>(&file).unwrap();
    let out = TempDir::new().unwrap();
    fs::write(out.path().join("mesh.msh"), freefem::text(&mesh).unwrap()).unwrap();
    let script = "mesh Th = readmesh(\"mesh.msh\"); cout.precision(12);\n\
                  cout << Th.nv << \" \" << Th.nt << \" \" << Th.nbe << \" \" << Th.area << endl;\n\
                  int[int] all = labels(Th);\nfor (int i = 0; i < all.n; i++) cout << all[i] \
                  << \" \" << int1d(Th, all[i])(1.) << endl;\n";
    fs::write(out.path().join("read.edp"), script).unwrap();
    let Ok(done) = Command::new("FreeFem++")
        .args(["-nw", "-v", "0", "read.edp"])
        .current_dir(out.path())
        .output()
    else {
        println!("FreeFEM is not installed: its reader was not tried");
        return;
    };
    let text = String::from_utf8(done.stdout).unwrap();
    assert!(done.status.success(), "{text}");
    let rows: Vec<Vec<f64>> =
        text.lines().map(|l| l.split_whitespace().map(|w| w.parse().unwrap()).collect()).collect();
    let close = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs().max(1.0);
    assert_eq!(
        rows[0][..3],
        [mesh.points().len(), mesh.cell_count(), mesh.facets().len()].map(|n| n as f64)
    );
    assert!(close(rows[0][3], mesh.volume()), "{text}");
    let labels = freefem::labels(&mesh);
    assert!(labels.len() >= 4 && rows.len() == labels.len() + 1, "{text}");
    for (name, label) in labels {
        let row = rows[1..]
            .iter()
            .find(|r| r[0] == f64::from(label))
            .unwrap_or_else(|| panic!("no label {label}: {text}"));
        let facets = mesh.boundary(&name).unwrap().iter();
        let length: f64 = facets.map(|&f| mesh.facet_normal(&mesh.facets()[f as usize]).1).sum();
        assert!(close(row[1], length), "{name}: {} but {length}", row[1]);
    }
}
