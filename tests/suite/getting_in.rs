//! What a newcomer meets first: scenes to start from, the format for editors, the commands for
//! shells, and the plan for other programs.

use super::program::*;
use immersa::scene::keys::Kind;
use immersa::scene::{KEYS, Scene, problem};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// The names that `immersa new` lists.
fn cases() -> Vec<String> {
    let listed = immersa(Path::new("."), &["new"]);
    listed.expect(0, &[]);
    let lines = listed.stdout.lines().filter_map(|l| l.strip_prefix("  "));
    lines.map(|l| l.split_whitespace().next().unwrap().to_string()).collect()
}

/// Makes the mesh of a case, if it has one; false without gmsh.
fn meshed(folder: &Path, name: &str) -> bool {
    let geometry = format!("{name}.geo");
    if !folder.join(&geometry).exists() {
        return true;
    }
    match Command::new("gmsh").current_dir(folder).args(["-2", &geometry]).output() {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => false,
        output => {
            assert!(output.unwrap().status.success());
            true
        }
    }
}

#[test]
#[expect(clippy::print_stderr, reason = "a test that leaves out a case must say so")]
fn every_case_explains_itself_without_a_warning_and_makes_its_first_steps() {
    let folder = TempDir::new().unwrap();
    let mut lists = BTreeSet::new();
    let names = cases();
    assert!(names.len() > 10, "{names:?}");
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src/first-steps/five-minutes.md");
    let page = fs::read_to_string(page).unwrap();
    for name in names {
        assert!(page.contains(&format!("`{name}`")), "the book does not name the case {name}");
        immersa(folder.path(), &["new", &name]).expect(0, &[]);
        let path = folder.path().join(format!("{name}.toml"));
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().next(), Some("#:schema ./immersa.schema.json"), "{name}");
        for command in ["explain", "run"] {
            assert!(
                text.contains(&format!("`immersa {command} {name}.toml`")),
                "{name}: {command}"
            );
        }
        if !meshed(folder.path(), &name) {
            eprintln!("gmsh is not installed: the case `{name}` is not computed");
            continue;
        }
        let scene = Scene::load(&path, &[]).unwrap();
        lists.extend(scene.structures().iter().map(|s| s.list()));
        let mut problem = problem(&scene).unwrap();
        problem.plan().unwrap();
        assert!(problem.warnings().is_empty(), "{name}: {:?}", problem.warnings());
        for _ in 0..2 {
            problem.step().unwrap();
        }
        let row = problem.row().unwrap();
        // The error of the steps is known from the third step on.
        let mut known = row.names().iter().zip(row.values()).filter(|(n, _)| *n != "time_error");
        assert!(known.all(|(_, v)| v.is_finite()), "{name}: {row:?}");
    }
    let all = KEYS.keys.iter().filter(|k| matches!(k.kind, Kind::List(_))).map(|k| k.name);
    assert_eq!(lists, all.collect(), "a family has no case");
}

#[test]
fn the_schema_beside_new_scenes_is_that_of_the_program() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("immersa.schema.json");
    immersa(folder.path(), &["new", "cavity"]).expect(0, &[]);
    let schema = immersa(folder.path(), &["schema"]).stdout;
    assert_eq!(fs::read_to_string(&file).unwrap(), schema);
    let parsed: Value = serde_json::from_str(&schema).unwrap();
    assert_eq!(parsed["$schema"], "http://json-schema.org/draft-07/schema#");

    fs::write(&file, "{}").unwrap();
    let told = immersa(folder.path(), &["new", "membrane"]);
    told.expect(0, &[]);
    assert!(told.stdout.contains("immersa schema > immersa.schema.json"), "{}", told.stdout);
    assert_eq!(fs::read_to_string(&file).unwrap(), "{}", "a file of the user was replaced");
}

#[test]
fn a_new_case_overwrites_nothing() {
    let folder = TempDir::new().unwrap();
    let new = |arguments: &[&str]| immersa(folder.path(), &[&["new"], arguments].concat());
    new(&["cavity"]).expect(0, &[]);
    new(&["cavity"]).expect(3, &["cavity.toml", "--out"]);
    new(&["cavity", "--out", "nowhere/a.toml"]).expect(3, &["nowhere/a.toml"]);
    fs::create_dir(folder.path().join("flow")).unwrap();
    let told = new(&["obstacle", "--out", "flow/mine.toml"]).stdout;
    for part in ["flow/mine.toml is", "gmsh -2 flow/obstacle.geo", "immersa run flow/mine.toml"] {
        assert!(told.contains(part), "{told}");
    }
    assert!(folder.path().join("flow/immersa.schema.json").exists());
    fs::write(folder.path().join("obstacle.geo"), "mine").unwrap();
    new(&["obstacle"]).expect(3, &["obstacle.geo", "--out"]);
    assert!(!folder.path().join("obstacle.toml").exists(), "half of a case was written");
    assert_eq!(fs::read(folder.path().join("obstacle.geo")).unwrap(), b"mine");
}

#[test]
fn shells_and_manuals_know_every_command() {
    let folder = TempDir::new().unwrap();
    let help = immersa(folder.path(), &["--help"]).stdout;
    let commands = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let commands = commands.lines().filter_map(|l| l.strip_prefix("  ")?.split_whitespace().next());
    let commands: Vec<&str> = commands.filter(|c| *c != "help").collect();
    assert!(commands.len() > 9, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = immersa(folder.path(), &["completions", shell]);
        script.expect(0, &[]);
        for command in commands.iter().chain(&["overwrite"]) {
            assert!(script.stdout.contains(command), "{shell}: {command}");
        }
        // The other shells complete no values of arguments.
        let cases = ["bash", "zsh"].contains(&shell);
        assert_eq!(script.stdout.contains("surfactant"), cases, "{shell}");
    }
    immersa(folder.path(), &["man", "pages"]).expect(0, &[]);
    for command in commands {
        let page = folder.path().join(format!("pages/immersa-{command}.1"));
        assert!(fs::read_to_string(page).unwrap().contains(".SH SYNOPSIS"), "{command}");
    }
    let page = immersa(folder.path(), &["man"]).stdout;
    assert!(page.contains(".TH immersa 1") && page.contains("Exit codes"), "{page}");
    fs::write(folder.path().join("file"), "").unwrap();
    immersa(folder.path(), &["man", "file/pages"]).expect(3, &["at: file/pages"]);
}

/// The explanation of a scene for programs, and the summary of its run, which says the same where
/// both have a name.
#[test]
fn explain_as_json_has_the_numbers_of_the_run() {
    let folder = folder_with(SCENE);
    let explained = immersa(folder.path(), &["explain", "scene.toml", "--json"]);
    explained.expect(0, &[]);
    let told: Value = serde_json::from_str(&explained.stdout).unwrap();
    let arguments = ["run", "scene.toml", "--out", "out", "--set", "time.end=0.05"];
    immersa(folder.path(), &arguments).expect(0, &[]);
    let run = folder.path().join("out");
    let summary = summary(&run);
    for name in ["title", "version", "cells", "edge", "unknowns", "factor_entries"] {
        assert!(!told[name].is_null(), "{name}");
        assert_eq!(told[name], summary[name], "{name}");
    }
    let header = fs::read_to_string(run.join("series.csv")).unwrap();
    let header: Vec<&str> = header.lines().next().unwrap().split(',').collect();
    assert_eq!(told["columns"], serde_json::json!(header));
    assert_eq!(told["time"]["steps"], 40);
    assert_eq!(told["limits"]["thickness"], 0.2);
    assert!(told["limits"]["explicit_limit"].as_f64().unwrap() > 0.0);
    assert_eq!(told["waves"][0]["name"], "membrane");
    assert_eq!(told["structures"], serde_json::json!([{ "name": "membrane", "list": "membrane" }]));

    let plan = immersa(folder.path(), &["explain", "scene.toml"]).stdout;
    let sections = told["plan"].as_array().unwrap();
    let mut lines = Vec::new();
    for section in sections {
        lines.push(section["heading"].as_str().unwrap().to_string());
        let inside = section["lines"].as_array().unwrap().iter();
        lines.extend(inside.map(|line| format!("  {}", line.as_str().unwrap())));
    }
    // Between the title and the warnings.
    let printed: Vec<&str> = plan.lines().skip(2).take(lines.len()).collect();
    assert_eq!(lines, printed);
    assert!(sections.len() > 4);
}

#[test]
fn explain_as_json_has_every_warning_with_its_remedy() {
    let folder = folder_with(SCENE);
    let told = [
        "explain",
        "scene.toml",
        "--set",
        "time.end=0.2",
        "--set",
        "fluid.viscosity={ inside = 0.02, outside = 0.01 }",
    ];
    let text = immersa(folder.path(), &told).stdout;
    let json = immersa(folder.path(), &[&told[..], &["--json"]].concat()).stdout;
    let json: Value = serde_json::from_str(&json).unwrap();
    let said = |w: &Value| {
        let (what, remedy) = (w["what"].as_str().unwrap(), w["remedy"].as_str().unwrap());
        format!("warning: {what}{}{remedy}", if remedy.is_empty() { "" } else { "; " })
    };
    let warnings: Vec<String> = json["warnings"].as_array().unwrap().iter().map(said).collect();
    let printed: Vec<&str> = text.lines().filter(|l| l.starts_with("warning: ")).collect();
    assert_eq!(warnings, printed);
    let with_remedy = |w: &Value| w["remedy"] != "";
    assert!(json["warnings"].as_array().unwrap().iter().any(with_remedy), "{warnings:?}");
    assert!(warnings.len() >= 2, "{warnings:?}");
}
