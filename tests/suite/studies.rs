//! Studies through the program.

use super::program::*;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The small scene with a wall at rest, so that its energy can only fall.
fn closed() -> String {
    SCENE.replace("[boundary.top]\nvelocity = [\"0.2 * t * sin(pi * x / 2)\", 0]\n", "")
}

/// `immersa study ARGUMENTS --json --out study` and the JSON that it prints.
fn study(folder: &Path, arguments: &[&str]) -> (Ended, Value) {
    let ended = immersa(folder, &[&["study"], arguments, &["--json", "--out", "study"]].concat());
    let json = serde_json::from_str(&ended.stdout).unwrap_or(Value::Null);
    (ended, json)
}

/// The run folders of a study by name, with the bytes of their series.
fn runs(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let all = files(&folder.join("study/runs")).into_iter();
    all.filter(|(name, _)| name.ends_with("series.csv")).collect()
}

/// On this scene, membrane of modulus 1 on 16 x 16 squares, formula (1.54) gives .022.
#[test]
fn stability_finds_the_limit_of_the_explicit_coupling_and_goes_on_where_it_was_interrupted() {
    let folder = folder_with(&closed());
    let at = folder.path();
    let arguments = [
        "stability",
        "scene.toml",
        "--steps",
        "30",
        "--accuracy",
        "0.3",
        "--order",
        "1",
        "--max-step",
        "0.2",
    ];
    let (ended, found) = study(at, &arguments);
    ended.expect(0, &["explicit coupling, order 1, dt = "]);
    let limits = found["tables"]["limits"].as_array().unwrap();
    let number = |row: usize, key: &str| limits[row][key].as_f64();
    let (stable, unstable) = (number(0, "stable").unwrap(), number(0, "unstable").unwrap());
    let formula = number(0, "formula").unwrap();
    assert!(unstable > stable && unstable <= 1.3001 * stable, "{stable} {unstable}");
    let ratio = number(0, "ratio").unwrap();
    assert!(
        (ratio - (stable * unstable).sqrt() / formula).abs() < 1e-9 && (0.8..2.0).contains(&ratio),
        "{ratio}"
    );
    assert_eq!((number(1, "stable"), number(1, "unstable")), (Some(0.2), None));
    assert_eq!(limits[1]["remark"], "stable at the largest step tried");
    let said = found["statements"][1].as_str().unwrap();
    assert!(
        said.contains("the largest step tried") && said.contains("times the explicit limit"),
        "{said}"
    );
    for name in ["limits.csv", "probes.csv", "study.json", "report.html"] {
        assert!(at.join("study").join(name).exists(), "{name}");
    }
    // Probes that grew say when.
    let probes = found["tables"]["probes"].as_array().unwrap();
    let grown = probes.iter().find(|p| p["step"].as_f64() == Some(unstable)).unwrap();
    assert!(
        grown["growth"].as_f64().unwrap() > 0.02
            && grown["outcome"].as_str().unwrap().contains("unstable from t")
    );

    // One run is lost: only that one is made again, and the findings are the same.
    let before = runs(at);
    let lost = before[2].0.split('/').next().unwrap().to_string();
    fs::remove_dir_all(at.join("study/runs").join(&lost)).unwrap();
    let kept =
        at.join("study/runs").join(before[0].0.split('/').next().unwrap()).join("summary.json");
    let written = fs::metadata(&kept).unwrap().modified().unwrap();
    let (_, again) = study(at, &arguments);
    assert_eq!(again, found);
    assert_eq!(runs(at), before);
    assert_eq!(
        fs::metadata(&kept).unwrap().modified().unwrap(),
        written,
        "a run that had ended was made again"
    );
}

#[test]
fn stability_takes_ends_of_its_range_and_refused_bands_as_results() {
    let folder = folder_with(&closed());
    let at = folder.path();
    let few =
        ["stability", "scene.toml", "--steps", "20", "--coupling", "explicit", "--accuracy", "1"];
    let (ended, found) = study(
        at,
        &[
            &few[..],
            &["--set", "membrane.0.force=smeared"],
            &["--min-step", "0.1", "--max-step", "0.2", "--vary", "numerics.thickness=0.1,0.2"],
        ]
        .concat(),
    );
    ended.expect(0, &["thickness = 0.1: refused"]);
    let limits = &found["tables"]["limits"];
    assert_eq!(
        (limits[0]["remark"].as_str(), limits[0]["stable"].as_f64()),
        (Some("refused"), None)
    );
    assert_eq!(limits[1]["remark"], "unstable at the smallest step tried");
    assert_eq!(limits[1]["unstable"].as_f64(), Some(0.1));
    let notes = found["notes"].to_string();
    assert!(
        notes.contains("thinner than the mesh allows") && notes.contains("more than 2 %"),
        "{notes}"
    );
}

#[test]
fn a_scan_tells_stable_unstable_and_refused_values_apart() {
    let folder = folder_with(&closed());
    let at = folder.path();
    // Twice the explicit limit: without the implicit coupling it blows up.
    let scan = [
        "stability",
        "scene.toml",
        "--set",
        "time.step=0.06",
        "--set",
        "time.end=2.4",
        "--set",
        "time.order=1",
        "--set",
        "membrane.0.force=smeared",
        "--steps",
        "30",
    ];
    let scan = [
        &scan[..],
        &["--scan", "numerics.thickness=0.1,0.2,0.25", "--coupling", "explicit,implicit"],
    ]
    .concat();
    let (ended, found) = study(at, &scan);
    ended.expect(0, &["thickness = 0.1, explicit coupling, dt = 0.06: refused"]);
    let rows = found["tables"]["scan"].as_array().unwrap();
    let outcome = |k: usize| rows[k]["outcome"].as_str().unwrap();
    assert_eq!((outcome(0), outcome(1)), ("refused", "refused"));
    assert!(
        outcome(2).starts_with("unstable from t = ")
            && outcome(4).starts_with("unstable from t = "),
        "{rows:?}"
    );
    assert_eq!((outcome(3), outcome(5)), ("stable", "stable"));
    assert!(
        rows[2]["growth"].as_f64().unwrap() > 0.02 && rows[3]["growth"].as_f64().unwrap() < 1e-3
    );
    assert_eq!(rows[2]["band/edge"].as_f64().unwrap(), 0.2 / 0.125);
    assert_eq!(found["tables"]["map"].as_array().unwrap().len(), 2);
    let said = found["statements"][0].as_str().unwrap();
    assert!(
        said.contains("refused at thickness = 0.1")
            && said.contains("unstable at thickness = 0.2 (from"),
        "{said}"
    );
    for chart in ["energy-over-thickness.svg", "area-over-thickness.svg"] {
        assert!(at.join("study/charts").join(chart).exists(), "{chart}");
    }
}

#[test]
fn what_is_wrong_on_the_command_line_of_a_study_of_stability_is_named() {
    let folder = folder_with(&closed());
    let try_it = |arguments: &[&str], words: &[&str]| {
        let (ended, _) = study(folder.path(), &[&["stability", "scene.toml"], arguments].concat());
        ended.expect(2, words);
        assert!(!folder.path().join("study/runs").exists(), "something was computed");
    };
    try_it(&["--coupling", "explict"], &["numerics.coupling=explict", "did you mean", "explicit"]);
    try_it(&["--order", "3"], &["time.order=3", "2"]);
    try_it(&["--vary", "membrane.0.strech=1,2"], &["strech", "stretch"]);
    try_it(&["--vary", "membrane.0.stretch"], &["--vary", "membrane.0.stretch", "KEY=V1,V2"]);
    try_it(&["--scan", "numerics.grad_div=1,-1"], &["grad_div=-1"]);
    try_it(&["--scan", "numerics.grad_div=1", "--max-step", "1"], &["--scan", "--max-step"]);
    try_it(&["--accuracy", "0"], &["--accuracy", "value: 0", "0.05"]);
    try_it(&["--growth", "NaN"], &["--growth", "NaN", "positive"]);
    try_it(
        &["--min-step", "1", "--max-step", "0.5"],
        &["--min-step", "value: 1", "below --max-step"],
    );
    try_it(&["--vary", "time.step=0.01,0.02"], &["time.step", "set twice"]);
    try_it(&["--vary", "numerics.coupling=implicit"], &["numerics.coupling", "set twice"]);
    try_it(&["--steps", "0"], &["--steps", "zero"]);
    try_it(&["--cells", "many"], &["--cells", "many"]);
    try_it(&["--cells", "0"], &["--cells", "zero"]);
}
