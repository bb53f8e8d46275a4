//! `immersa study precision` on small scenes.

use super::program::{Ended, SCENE, files, immersa};
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

fn study(folder: &Path, arguments: &[&str]) -> Ended {
    let always = ["study", "precision", "scene.toml", "--out", "study", "--repeat", "1"];
    immersa(folder, &[&always[..], arguments].concat())
}

fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    folder
}

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.stdout)
        .unwrap_or_else(|e| panic!("{e}\n{}\n{}", ended.stdout, ended.stderr))
}

/// The steps are the only difference to the reference: order 1 halves the error, order 2 quarters
/// it, within the slack of coarse steps.
#[test]
#[allow(clippy::print_stdout, reason = "says what was tried, and the numbers")]
fn errors_fall_with_the_order_of_the_method_and_failures_are_points() {
    let folder = folder();
    let arguments = [
        ["--set", "time.end=0.16"],
        ["--set", "membrane.0.force=smeared"],
        ["--steps", "0.02,0.01"],
        ["--method", "BDF1: time.order=1"],
        ["--method", "BDF2: time.order=2"],
        ["--method", "thin: numerics.thickness=0.01 steps=0.02"],
        ["--quantity", "membrane.horizontal"],
        ["--quantity", "membrane.area@0.16"],
        ["--reference", "step=0.0025"],
        ["--tolerance", "0.5,1e-12"],
    ]
    .concat();
    let first = study(folder.path(), &[&arguments[..], &["--json"]].concat());
    first.expect(0, &[]);
    let found = json(&first);
    let points = found["tables"]["points"].as_array().unwrap();
    assert_eq!(points.len(), 5);
    let error = |method: &str, dt: f64| {
        let point = points.iter().find(|p| p["method"] == method && p["dt"] == dt);
        point.unwrap_or_else(|| panic!("{method}, {dt}: {points:?}"))["error"].as_f64()
    };
    let [a, b, c, d] = [("BDF1", 0.02), ("BDF1", 0.01), ("BDF2", 0.02), ("BDF2", 0.01)]
        .map(|(method, dt)| error(method, dt).unwrap());
    println!("BDF1: {a:.2e}, {b:.2e}; BDF2: {c:.2e}, {d:.2e}");
    assert!((1.6..3.0).contains(&(a / b)) && c / d > 3.0 && d < b, "{a:e} {b:e} {c:e} {d:e}");
    assert!(error("thin", 0.02).is_none(), "refused: no error");
    let text = found.to_string();
    assert!(text.contains("thin, dt = 0.02: refused"), "{text}");
    let said: Vec<&str> =
        found["statements"].as_array().unwrap().iter().map(|s| s.as_str().unwrap()).collect();
    assert!(
        said[0].starts_with("50 % in membrane.horizontal, membrane.area at t = 0.16: dt = 0.0"),
        "{said:?}"
    );
    assert!(
        said[1].contains("not reached; closest came dt = 0.01, BDF2")
            && said[1].contains("The reference itself"),
        "{said:?}"
    );
    for file in ["report.html", "points.csv", "cheapest.csv", "study.json", "charts/work.svg"] {
        assert!(fs::metadata(folder.path().join("study").join(file)).unwrap().len() > 0, "{file}");
    }
    // Started again, it runs nothing and says the same.
    let before = files(&folder.path().join("study/runs"));
    let again = study(folder.path(), &[&arguments[..], &["--json"]].concat());
    again.expect(0, &[]);
    assert!(files(&folder.path().join("study/runs")) == before);
    assert_eq!(json(&again)["tables"], found["tables"]);
}

/// The area is conserved exactly: pi 0.55 0.4.
#[test]
fn an_exact_value_needs_no_reference() {
    let folder = folder();
    let arguments = [
        "--set",
        "time.end=0.04",
        "--cells",
        "16,20",
        "--quantity",
        "membrane.area",
        "--exact",
        "0.69115038",
        "--json",
    ];
    let ended = study(folder.path(), &arguments);
    ended.expect(0, &[]);
    let found = json(&ended);
    let points = found["tables"]["points"].as_array().unwrap();
    assert_eq!(points.iter().map(|p| p["n"].as_f64().unwrap()).collect::<Vec<_>>(), [16.0, 20.0]);
    assert!(points.iter().all(|p| p["error"].as_f64().unwrap() < 2e-3), "{points:?}");
    assert!(found["notes"].to_string().contains("exact values"));
    assert!(fs::metadata(folder.path().join("study/charts/unknowns.svg")).is_ok());
}

#[test]
fn a_wrong_command_line_is_told() {
    let folder = folder();
    let q = ["--quantity", "membrane.area"];
    for (arguments, words) in [
        (&[][..], ["--reference", "--exact"]),
        (&["--exact", "1", "--reference", "step=1"], ["--reference", "--exact"]),
        (&["--exact", "1", "--method", "time.order=2"], ["time.order=2", "a name, a colon"]),
        (&["--exact", "1", "--steps", "0.1,-1"], ["-1", "positive numbers"]),
        (&["--exact", "1", "--cells", "0"], ["--cells", "0"]),
        (
            &["--exact", "1", "--vary", "numerics.grad_div"],
            ["numerics.grad_div", "--vary KEY=V1,V2"],
        ),
        (&["--exact", "1", "--exact", "2"], ["2 values for 1 quantities", "--reference"]),
        (&["--reference", "fine"], ["fine", "cells=120"]),
        (
            &["--exact", "1", "--quantity", "membrane.aera", "--exact", "1"],
            ["membrane.aera", "did you mean `membrane.area`"],
        ),
        (
            &["--exact", "1", "--quantity", "membrane.area@7", "--exact", "1"],
            ["outside the run", "time.end"],
        ),
        (
            &["--exact", "1", "--method", "a: time.order=1", "--method", "a: time.order=2"],
            ["same name", "differently"],
        ),
        (&["--exact", "1", "--method", "a: time.oder=1"], ["oder", "order"]),
    ] {
        study(folder.path(), &[&q, arguments].concat()).expect(2, &words);
    }
    study(folder.path(), &["--exact", "1"]).expect(2, &["--quantity"]);
    study(folder.path(), &[&q[..], &["--exact", "1", "--twin"]].concat())
        .expect(3, &["no FreeFEM twin", "--twin"]);
}
