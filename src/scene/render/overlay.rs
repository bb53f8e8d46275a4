//! The series of several runs on one page, a line a run.

use super::charts;
use super::folder::RunFolder;
use super::units::of_column;
use crate::base::{Error, Result};
use crate::output::{Cell, Column, Page, Stroke, Table, read_text, rounded, write_file};
use crate::scene::charts::{Plot, PlotCurve};
use crate::scene::schema::Units;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use toml::Value;

/// What the foot of each such page begins with: a file without it is not replaced.
const MARK: &str = "An overlay of runs, made by immersa";
/// Most values of a scene in the name of a run.
const MOST_IN_NAME: usize = 2;

/// Writes the page of several runs; without `out` it is `overlay.html` in the folder that holds all
/// of them.
///
/// # Errors
/// Fewer than two runs, or one given twice; a folder that is not that of a run; a file in the way
/// that is no such page.
pub fn overlay(folders: &[PathBuf], overrides: &[String], out: Option<&Path>) -> Result<PathBuf> {
    let places = places(folders)?;
    let path = out.map_or_else(|| common(&places).join("overlay.html"), Path::to_path_buf);
    if path.exists() && !read_text(&path).is_ok_and(|text| text.contains(MARK)) {
        return Err(Error::input("this file is no overlay of runs, and is not replaced")
            .at(path.display().to_string())
            .value(path.display())
            .remedy("choose another file with --out"));
    }
    let mut runs: Vec<RunFolder> =
        folders.iter().map(|folder| RunFolder::open(folder, overrides)).collect::<Result<_>>()?;
    let mixed = runs.iter().any(|run| run.units != runs[0].units);
    if mixed {
        runs.iter_mut().for_each(|run| run.units = Units::default());
    }
    let base = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let base = base.canonicalize().map_err(|e| {
        Error::input("the folder of the page does not exist")
            .at(base.display().to_string())
            .value(e)
            .remedy("make it, or choose another file with --out")
    })?;
    let links: Vec<PathBuf> = places.iter().map(|place| relative(&base, place)).collect();
    write_file(&path, page(&runs, &links, mixed).html().as_bytes())?;
    Ok(path)
}

/// The folders as absolute paths, each once.
fn places(folders: &[PathBuf]) -> Result<Vec<PathBuf>> {
    if folders.len() < 2 {
        return Err(Error::scene("one run has nothing to be compared with")
            .at("--out")
            .value(folders.len())
            .remedy("give the folders of two runs or more, or leave --out out"));
    }
    let mut places: Vec<PathBuf> = Vec::new();
    for folder in folders {
        let place = folder.canonicalize().map_err(|e| {
            Error::input("the folder of a run cannot be opened")
                .at(folder.display().to_string())
                .value(e)
                .remedy("give a folder that `immersa run` has written")
        })?;
        if places.contains(&place) {
            return Err(Error::scene("the same run is given twice")
                .at(folder.display().to_string())
                .value(folder.display())
                .remedy("give each run once"));
        }
        places.push(place);
    }
    Ok(places)
}

/// The folder that holds all these.
fn common(places: &[PathBuf]) -> PathBuf {
    let parents = places.iter().filter_map(|p| p.parent().map(Path::to_path_buf));
    let shared = |a: PathBuf, b: PathBuf| {
        let both = a.components().zip(b.components()).take_while(|(a, b)| a == b);
        both.map(|(a, _)| a).collect()
    };
    parents.reduce(shared).unwrap_or_default()
}

/// The way from one folder to another.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let both = from.components().zip(to.components()).take_while(|(a, b)| a == b).count();
    let up = from.components().skip(both).map(|_| Component::ParentDir);
    up.chain(to.components().skip(both)).collect()
}

fn page(runs: &[RunFolder], links: &[PathBuf], mixed: bool) -> Page {
    let scenes: Vec<_> = runs.iter().map(values).collect();
    let differing = differing(&scenes);
    let names = names(runs, &scenes, &differing);
    let (plots, alone) = plots(runs, &names);
    let mut notes = Vec::new();
    if mixed {
        notes.push("The units of the runs differ: their numbers are drawn as they are.".into());
    }
    if !alone.is_empty() {
        notes.push(format!("Not shown, as only one run has it: {}.", alone.join(", ")));
    }
    let alarms = runs.iter().zip(&names).filter_map(|(run, name)| doubts(run, name));
    Page {
        title: format!("{} runs", runs.len()),
        subtitle: subtitle(runs),
        alarms: alarms.collect(),
        notes,
        charts: plots.iter().map(Plot::figure).collect(),
        tables: vec![at_the_end(runs, &names), listed(runs, (&names, links), &scenes, &differing)],
        footer: format!("{MARK} {} with `immersa render`.", crate::base::VERSION),
        ..Page::default()
    }
}

fn subtitle(runs: &[RunFolder]) -> String {
    let mut titles: Vec<&str> = runs.iter().map(|run| run.scene.title.as_str()).collect();
    titles.dedup();
    titles.join(" · ")
}

/// What stands against the results of a run.
fn doubts(run: &RunFolder, name: &str) -> Option<String> {
    let ended = match run.summary.status.as_str() {
        "failed" | "interrupted" => Some(format!("the run has {}", run.summary.status))
            .map(|text| text.replace("has interrupted", "was interrupted")),
        _ => None,
    };
    let all: Vec<String> = ended.into_iter().chain(run.summary.alarms.iter().cloned()).collect();
    (!all.is_empty()).then(|| format!("{name}: {}", all.join("\n")))
}

/// The values of a scene by their keys, except its title and what is written.
fn values(run: &RunFolder) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    if let Ok(table) = run.scene.to_toml().parse::<toml::Table>() {
        collect("", &Value::Table(table), &mut all);
    }
    all.retain(|key, _| key != "title" && key != "units" && !key.starts_with("output."));
    all
}

fn collect(key: &str, value: &Value, all: &mut BTreeMap<String, String>) {
    let inner = |name: &str| if key.is_empty() { name.into() } else { format!("{key}.{name}") };
    match value {
        Value::Table(table) => table.iter().for_each(|(k, v)| collect(&inner(k), v, all)),
        Value::Array(list) if list.iter().any(Value::is_table) => {
            list.iter().enumerate().for_each(|(k, v)| collect(&inner(&k.to_string()), v, all));
        }
        Value::Float(number) => drop(all.insert(key.into(), rounded(*number, 6))),
        Value::String(text) => drop(all.insert(key.into(), text.clone())),
        other => drop(all.insert(key.into(), other.to_string())),
    }
}

/// The keys whose values differ.
fn differing(scenes: &[BTreeMap<String, String>]) -> Vec<String> {
    let mut keys: Vec<&String> = scenes.iter().flat_map(BTreeMap::keys).collect();
    keys.sort();
    keys.dedup();
    let differs = |key: &&String| scenes.iter().any(|s| s.get(*key) != scenes[0].get(*key));
    keys.into_iter().filter(differs).cloned().collect()
}

/// Names of the runs in legends: the values in which the scenes differ if these are few and tell
/// them apart, else the folders.
fn names(
    runs: &[RunFolder],
    scenes: &[BTreeMap<String, String>],
    differing: &[String],
) -> Vec<String> {
    let of_scene = |scene: &BTreeMap<String, String>| {
        let value =
            |key: &String| format!("{key} = {}", scene.get(key).map_or("none", String::as_str));
        differing.iter().map(value).collect::<Vec<_>>().join(", ")
    };
    let last = |run: &RunFolder| {
        let place = run.path.canonicalize().unwrap_or_else(|_| run.path.clone());
        place.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned())
    };
    let whole = |run: &RunFolder| run.path.display().to_string();
    let unlike = |names: &Vec<String>| (1..names.len()).all(|k| !names[..k].contains(&names[k]));
    let mut choices: Vec<Vec<String>> = Vec::new();
    if (1..=MOST_IN_NAME).contains(&differing.len()) {
        choices.push(scenes.iter().map(of_scene).collect());
    }
    choices.push(runs.iter().map(last).collect());
    let found = choices.into_iter().find(unlike);
    found.unwrap_or_else(|| runs.iter().map(whole).collect())
}

/// Charts that at least two runs have, and the titles of the others. Where the report has several
/// full curves in a chart each is a chart here; dashed ones, which are there for comparison, are
/// left out.
fn plots(runs: &[RunFolder], names: &[String]) -> (Vec<Plot>, Vec<String>) {
    let mut found: Vec<Plot> = Vec::new();
    for (k, run) in runs.iter().enumerate() {
        for plot in charts::draw(run) {
            let full: Vec<&PlotCurve> =
                plot.curves.iter().filter(|c| c.stroke != Stroke::Dashed).collect();
            for curve in &full {
                let title = match full.len() {
                    1 => plot.title.clone(),
                    _ => format!("{}: {}", plot.title, curve.name),
                };
                let line =
                    PlotCurve { name: names[k].clone(), colour: Some(k), ..(*curve).clone() };
                match found.iter_mut().find(|p| p.title == title) {
                    Some(plot) => plot.curves.push(line),
                    None => found.push(Plot {
                        name: String::new(),
                        title,
                        curves: vec![line],
                        caption: String::new(),
                        ..plot.clone()
                    }),
                }
            }
        }
    }
    let (mut shown, alone): (Vec<Plot>, Vec<Plot>) =
        found.into_iter().partition(|plot| plot.curves.len() > 1);
    for plot in &mut shown {
        let without = |name: &&String| plot.curves.iter().all(|c| c.name != **name);
        let missing: Vec<&str> = names.iter().filter(without).map(String::as_str).collect();
        if !missing.is_empty() {
            plot.caption = format!("Not in: {}.", missing.join("; "));
        }
    }
    (shown, alone.into_iter().map(|plot| plot.title).collect())
}

/// The last values of all columns that two runs or more have.
fn at_the_end(runs: &[RunFolder], names: &[String]) -> Table {
    let mut columns: Vec<&String> = Vec::new();
    let all = runs.iter().flat_map(|run| &run.series.names);
    all.for_each(|name| {
        if !columns.contains(&name) {
            columns.push(name)
        }
    });
    columns.retain(|name| runs.iter().filter(|r| r.series.names.contains(name)).count() > 1);
    let row = |name: &&String| {
        let owner = runs.iter().find(|run| run.series.names.contains(name));
        let unit = owner.map_or_else(String::new, |run| of_column(run, name));
        let values = runs.iter().map(|run| Cell::optional(run.last(name), 6));
        [Cell::text(name.as_str()), Cell::text(unit)].into_iter().chain(values).collect()
    };
    let heads = ["column of series.csv", "unit"].map(Column::from);
    Table::new(
        "",
        "At the end",
        heads.into_iter().chain(names.iter().map(|n| Column::from(n.as_str()))),
    )
    .with_rows(columns.iter().map(row))
}

/// The runs, with the values of their scenes that differ.
fn listed(
    runs: &[RunFolder],
    (names, links): (&[String], &[PathBuf]),
    scenes: &[BTreeMap<String, String>],
    differing: &[String],
) -> Table {
    let row = |k: usize| {
        let run = &runs[k];
        let computed = run.summary.sessions.last();
        let report = links[k].join("report.html");
        let head = [
            Cell::text(names[k].as_str()),
            Cell::file(report.to_string_lossy()),
            Cell::file(links[k].join("series.csv").to_string_lossy()),
            Cell::text(run.summary.status.as_str()),
            Cell::text(computed.map_or("", |s| s.ended.as_str())),
            Cell::text(computed.map_or("", |s| s.version.as_str())),
        ];
        let values = differing.iter().map(|key| scenes[k].get(key).map_or("", String::as_str));
        head.into_iter().chain(values.map(Cell::text)).collect()
    };
    let heads = ["run", "report", "series", "status", "computed", "version"];
    let heads = heads.into_iter().chain(differing.iter().map(String::as_str));
    Table::new("", "Runs", heads).with_rows((0..runs.len()).map(row))
}
