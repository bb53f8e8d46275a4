//! Every example is complete and gives the numbers that its `expect.toml` names.
//!
//! An `expect.toml` has a `[[case]]` for each way to run the scene: `name`, `set` (as after
//! `--set`), and under `[[case.value]]` what is expected: `column` of the series, `time`, `value`,
//! absolute `tolerance`, `kind` (`exact`, `published`, `freefem` or `regression`) and `source`.

use super::program::immersa;
use immersa::output::Series;
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const PARTS: [&str; 3] = ["scene.toml", "README.md", "expect.toml"];
/// The same or a simpler case in FreeFEM, where there is one; what FreeFEM has not the memory or
/// the elements for names another reference.
const WITHOUT_TWIN: [(&str, &str); 19] = [
    ("sheared-sphere", "axisymmetric.edp"),
    ("capsule-in-shear", "README.md"),
    ("membrane-in-channel", "data/as_shipped.csv"),
    ("active-contours", "shapes-mask.png"),
    // Linear theory in tests/convergence/drop_modes.rs; Fig. 1.4 of the source book.
    ("oscillating-drop", "data/as_shipped.csv"),
    ("merging-bubbles", "README.md"),
    ("capillary-wave", "README.md"),
    ("static-drop", "README.md"),
    // Published numbers, and a steady solution on the same mesh by another program.
    ("turek-hron-channel", "README.md"),
    ("driven-cavity", "README.md"),
    ("backward-step", "README.md"),
    ("cylinder-3d", "README.md"),
    // Boundary integrals, the equations of forms at rest.
    ("tank-treading", "README.md"),
    ("tumbling", "README.md"),
    ("breathing", "README.md"),
    ("vesicle-at-rest", "README.md"),
    ("vesicle-in-channel", "README.md"),
    ("shapes-in-space", "README.md"),
    ("red-cell", "README.md"),
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expectations {
    case: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    name: String,
    set: Vec<String>,
    value: Vec<Expected>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expected {
    column: String,
    time: f64,
    value: f64,
    tolerance: f64,
    kind: Kind,
    source: String,
}

#[derive(Debug, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Exact,
    Published,
    Freefem,
    Regression,
}

/// The folders of `examples/` that hold a case.
fn examples() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let mut folders: Vec<_> =
        fs::read_dir(root).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir()).collect();
    folders.sort();
    assert!(folders.len() >= 2);
    folders
}

#[test]
fn every_example_is_complete() {
    let parts = examples().into_iter().flat_map(|folder| {
        let reference = WITHOUT_TWIN
            .iter()
            .find(|(name, _)| folder.ends_with(name))
            .map_or("twin.edp", |other| other.1);
        PARTS.into_iter().chain([reference]).map(|part| folder.join(part)).collect::<Vec<_>>()
    });
    let missing: Vec<PathBuf> =
        parts.filter(|p| fs::metadata(p).map_or(0, |m| m.len()) == 0).collect();
    assert!(missing.is_empty(), "missing: {missing:?}");
}

#[test]
fn every_example_gives_the_numbers_that_are_expected() {
    for folder in examples() {
        let text = fs::read_to_string(folder.join("expect.toml")).unwrap();
        let expectations: Expectations =
            toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        assert!(!expectations.case.is_empty());
        for case in &expectations.case {
            check(&folder, case);
        }
    }
}

fn check(folder: &Path, case: &Case) {
    let place = format!("{}, case `{}`", folder.display(), case.name);
    let out = TempDir::new().unwrap();
    let scene = folder.join("scene.toml");
    let mut arguments = vec!["run", scene.to_str().unwrap(), "--quiet", "--out", "run"];
    // The numbers are in the series.
    let fixed = ["output.pictures=false", "output.film=false", "output.fields=false"];
    arguments.extend(
        fixed.into_iter().chain(case.set.iter().map(String::as_str)).flat_map(|s| ["--set", s]),
    );
    immersa(out.path(), &arguments).expect(0, &[]);
    let series = Series::read(&out.path().join("run/series.csv")).unwrap();
    let times = series.column("time").unwrap();
    let mut wrong = Vec::new();
    assert!(!case.value.is_empty(), "{place} expects nothing");
    for e in &case.value {
        assert!(
            !e.source.is_empty() && e.tolerance > 0.0,
            "{place}: {} has no source or tolerance",
            e.column
        );
        let row = times.iter().position(|t| (t - e.time).abs() < 1e-9);
        let row = row.unwrap_or_else(|| panic!("{place}: the series has no row at t = {}", e.time));
        let value = series.column(&e.column).unwrap_or_else(|e| panic!("{place}: {e}"))[row];
        // A value that is no number is wrong too.
        if value.is_nan() || (value - e.value).abs() > e.tolerance {
            wrong.push(format!(
                "{} at t = {}: {value}, but {} +- {} by {:?}, {}",
                e.column, e.time, e.value, e.tolerance, e.kind, e.source
            ));
        }
    }
    assert!(wrong.is_empty(), "{place}:\n{}", wrong.join("\n"));
}
