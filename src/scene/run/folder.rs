//! The folder of a run.

use super::lock::Lock;
use super::physics::{differences, tag};
use super::record::{Column, Record};
use super::{Earlier, Options, contents};
use crate::base::{Error, Kind, Result, Warning, copy_bandwidth};
use crate::output::{Series, cannot_write, write_durably, write_file, write_pvd, write_vtkhdf};
use crate::scene::Scene;
use crate::scene::charts::Columns;
use crate::scene::kept::{CHECKPOINTS, Checkpoint, is_run};
use crate::scene::keys::Named;
use crate::scene::period::Oscillation;
use crate::scene::problem::{Facts, Problem};
use crate::scene::schema::Force;
use crate::scene::structures::FindingValue;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The folder of a run, with the resolved scene in it.
pub struct Folder {
    path: PathBuf,
    earlier: Earlier,
    /// Held from the first write on; from the start where a run goes on.
    lock: Option<Lock>,
}

impl Folder {
    /// Opens the folder of a new run, or of one to go on with. Writes nothing but the lock of a
    /// folder that holds a run.
    ///
    /// # Errors
    /// A folder that holds a run which is to be kept, a run of another scene, or something else;
    /// another process that writes to it.
    pub(super) fn open(scene: &Scene, options: &Options<'_>) -> Result<Folder> {
        let path = options.folder.clone();
        let is_run = is_run(&path);
        if !is_run && !contents::is_empty(&path) {
            return Err(foreign(&path));
        }
        let mut folder = Folder { path, earlier: options.earlier, lock: None };
        if !is_run {
            return Ok(folder);
        }
        if options.earlier == Earlier::Keep {
            return Err(Error::input("the folder holds a run already, and nothing is overwritten")
                .at(folder.path.display().to_string())
                .value(folder.path.display())
                .remedy(
                    "go on with --resume, replace the run with --overwrite, or choose another \
                     folder with --out",
                ));
        }
        folder.lock = Some(Lock::take(&folder.path)?);
        let kept = folder.path.join("scene.toml");
        if options.earlier == Earlier::Resume && kept.exists() {
            let differences = differences(&Scene::load(&kept, &[])?, scene)?;
            if !differences.is_empty() {
                return Err(Error::scene("the run to be resumed was started with another scene")
                    .at(kept.display().to_string())
                    .value(differences.join("; "))
                    .remedy(
                        "resume with the same scene and the same --set (only time.end and what \
                         [output] writes may change), or start afresh with --overwrite or in \
                         another folder",
                    ));
            }
        }
        Ok(folder)
    }

    /// The scene of the run: one that starts from another run and goes on has kept its start.
    ///
    /// # Errors
    /// A scene that starts from this very folder.
    pub(super) fn begun(&self, scene: &Scene) -> Result<Scene> {
        let Some(initial) = &scene.initial else { return Ok(scene.clone()) };
        let start = self.start();
        if self.earlier == Earlier::Resume && start.is_file() {
            return Ok(scene.begun(start));
        }
        let own = self.path.canonicalize().ok();
        if own.is_some() && own == initial.from.canonicalize().ok() {
            let e = Error::scene("a run cannot start from its own folder, which it would replace")
                .value(self.path.display())
                .remedy("choose another folder with --out");
            return Err(scene.blame(&["initial", "from"], e));
        }
        Ok(scene.clone())
    }

    /// Creates the folder, removes an earlier run that is to be replaced, and writes the scene.
    ///
    /// # Errors
    /// The folder cannot be written, or has been filled since it was opened.
    pub(super) fn make(&mut self, scene: &Scene) -> Result<()> {
        make_folder(&self.path)?;
        if self.lock.is_none() {
            self.lock = Some(Lock::take(&self.path)?);
            if !contents::is_empty(&self.path) {
                return Err(foreign(&self.path));
            }
        }
        if self.earlier == Earlier::Replace {
            contents::clear(&self.path)?;
        }
        contents::check_links(&self.path)?;
        for name in ["fields", "checkpoint", "profiles"] {
            make_folder(&self.path.join(name))?;
        }
        write_file(&self.path.join("scene.toml"), scene.to_toml_in(&self.path).as_bytes())
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    pub(super) fn series(&self) -> PathBuf {
        self.path.join("series.csv")
    }

    /// Removes the report of a run that goes on: it would tell of an earlier end.
    pub(super) fn remove_report(&self) -> Result<()> {
        match std::fs::remove_file(self.path.join("report.html")) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                Err(Error::input(format!("the report of the earlier end cannot be removed: {e}"))
                    .at(self.path.join("report.html").display().to_string())
                    .remedy("check the permissions of the run folder"))
            }
            _ => Ok(()),
        }
    }

    pub(super) fn log(&self) -> PathBuf {
        self.path.join("log.txt")
    }

    /// The start of a run that begins with the flow of another one.
    pub(super) fn start(&self) -> PathBuf {
        self.path.join("start.vtu")
    }

    fn checkpoint_file(&self, name: &str) -> PathBuf {
        self.path.join("checkpoint").join(name)
    }

    /// Writes the state and the record of all output so far to one file, which is replaced as a
    /// whole. It is on the disk when this returns, and the one before is kept.
    pub(super) fn save(&self, scene: &Scene, record: &Record, problem: &dyn Problem) -> Result<()> {
        let record = serde_json::to_vec(record)
            .map_err(|e| Error::internal(format!("the record cannot be kept: {e}")))?;
        let [mesh, state] = problem.save(tag(scene)?);
        let bytes = Checkpoint { record, mesh, state }.to_bytes();
        let [latest, earlier] = CHECKPOINTS.map(|name| self.checkpoint_file(name));
        if latest.exists() {
            std::fs::rename(&latest, &earlier).map_err(|e| cannot_write(&earlier, &e))?;
        }
        write_durably(&latest, &bytes)
    }

    /// Continues a problem from the last checkpoint that can be used; its record, and a warning if
    /// it is not the last. `None` if there is no checkpoint.
    ///
    /// # Errors
    /// Checkpoints that are all damaged; other inputs than those that the run was started with.
    pub(super) fn restore(
        &self,
        scene: &Scene,
        inputs: &BTreeMap<String, u64>,
        problem: &mut dyn Problem,
    ) -> Result<Option<(Record, Option<Warning>)>> {
        let (tag, mut unusable) = (tag(scene)?, None);
        let [latest, earlier] = CHECKPOINTS.map(|name| self.checkpoint_file(name));
        for path in [&latest, &earlier] {
            let read = Checkpoint::read(path).and_then(|kept| {
                kept.map(|kept| Ok((kept.record::<Record>(path)?, kept))).transpose()
            });
            let (record, Checkpoint { mesh, state, .. }) = match read {
                Ok(Some(kept)) => kept,
                Ok(None) => continue,
                Err(e) => {
                    unusable.get_or_insert(e);
                    continue;
                }
            };
            check_inputs(scene, &record.inputs, inputs)?;
            match problem.restore([&mesh, &state], tag, record.band_edges) {
                Ok(()) if path == &latest => return Ok(Some((record, None))),
                Ok(()) => {
                    // It is now the last one, and what is damaged does not take its place.
                    std::fs::rename(&earlier, &latest).map_err(|e| cannot_write(&latest, &e))?;
                    let why = unusable.map_or("it is missing".into(), |e| e.what().to_string());
                    let what = format!("the last checkpoint cannot be used: {why}");
                    let warning = Warning::new(what, "the run goes on from the one before");
                    return Ok(Some((record, Some(warning))));
                }
                Err(e) if e.kind() == Kind::Input => {
                    let place = path.display().to_string();
                    unusable.get_or_insert(if e.place().is_empty() { e.at(place) } else { e });
                }
                Err(e) => return Err(e),
            }
        }
        unusable.map_or(Ok(None), Err)
    }

    /// Removes from the record the field files that are no longer there; a warning that names them.
    pub(super) fn check_fields(&self, record: &mut Record) -> Option<Warning> {
        let gone = |(step, _): &(usize, f64)| !self.fields(*step).is_file();
        let missing: Vec<String> =
            record.fields.iter().filter(|f| gone(f)).map(|f| field_file(f.0)).collect();
        record.fields.retain(|f| !gone(f));
        (!missing.is_empty()).then(|| {
            let what = format!("field files of the run are missing: {}", missing.join(", "));
            Warning::new(what, "the run goes on; pictures and fields.pvd will lack these times")
        })
    }

    /// The field file after `step` steps.
    pub(super) fn fields(&self, step: usize) -> PathBuf {
        self.path.join(field_file(step))
    }

    pub(super) fn write_collection(&self, record: &Record) -> Result<()> {
        let entries: Vec<_> =
            record.fields.iter().map(|&(k, time)| (time, field_file(k))).collect();
        let interfaces: Vec<_> = (entries.iter())
            .map(|(time, file)| (*time, Path::new(file).with_extension("vtp")))
            .filter(|(_, file)| self.path.join(file).is_file())
            .map(|(time, file)| (time, file.display().to_string()))
            .collect();
        if !interfaces.is_empty() {
            write_pvd(&self.path.join("interfaces.pvd"), &interfaces)?;
        }
        write_pvd(&self.path.join("fields.pvd"), &entries)
    }

    /// The file of the boundary.
    pub(super) fn boundaries(&self) -> PathBuf {
        self.path.join("boundaries.vtp")
    }

    /// Makes the file with the fields of all times, if the scene wants it.
    pub(super) fn write_all_times(&self, scene: &Scene, record: &Record) -> Result<()> {
        let frames: Vec<PathBuf> = record.fields.iter().map(|f| self.fields(f.0)).collect();
        let path = self.path.join("fields.vtkhdf");
        match scene.dimension() {
            _ if !scene.output.vtkhdf || frames.is_empty() => Ok(()),
            2 => write_vtkhdf::<2>(&path, &frames),
            _ => write_vtkhdf::<3>(&path, &frames),
        }
    }

    /// Writes a profile: the coordinates of its points, and its columns.
    pub(super) fn write_profile(
        &self,
        name: &str,
        points: &[Vec<f64>],
        values: &[Column],
    ) -> Result<()> {
        let column = |f: &dyn Fn(&Vec<f64>) -> f64| points.iter().map(f).collect::<Vec<f64>>();
        let square =
            |p: &Vec<f64>| p.iter().zip(&points[0]).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let distance = column(&|p| square(p).sqrt());
        let dimension = points.first().map_or(0, Vec::len);
        let places: Vec<Vec<f64>> = (0..dimension).map(|i| column(&|p| p[i])).collect();
        let mut columns: Vec<(&str, &[f64])> = vec![("distance", &distance)];
        columns.extend(["x", "y", "z"].into_iter().zip(places.iter().map(Vec::as_slice)));
        columns.extend(values.iter().map(|(name, v)| (name.as_str(), v.as_slice())));
        Series::new(&columns).write(&self.path.join("profiles").join(format!("{name}.csv")))
    }

    /// The Strouhal number of each force that has a reference, enough rows, and oscillates.
    fn strouhal(scene: &Scene, series: &Series) -> Result<BTreeMap<String, serde_json::Value>> {
        let mut found = BTreeMap::new();
        let every = scene.output.every.max(scene.time.step);
        let dense =
            |f: &&Named<Force>| f.reference.as_ref().is_some_and(|r| r.is_resolved_by(every));
        for force in scene.output.forces.iter().filter(dense) {
            let lift = series.column(&format!("{}_lift", force.name))?;
            let oscillation = Oscillation::of(series.column("time")?, lift);
            if let (Some(r), Some(o)) = (&force.reference, oscillation) {
                let number = o.frequency * r.length / r.speed;
                let value = json!({ "strouhal": number, "frequency": o.frequency,
                    "periods": o.periods, "spread": o.spread });
                found.insert(force.name.clone(), value);
            }
        }
        Ok(found)
    }

    /// Mean, least and largest drag and lift in the second half of the run, by force.
    fn coefficients(scene: &Scene, series: &Series) -> Result<BTreeMap<String, serde_json::Value>> {
        let mut found = BTreeMap::new();
        for force in scene.output.forces.iter().filter(|f| f.reference.is_some()) {
            let time = series.column("time")?;
            let middle = 0.5 * (time.first().unwrap_or(&0.0) + time.last().unwrap_or(&0.0));
            let of = |what: &str| -> Result<serde_json::Value> {
                let column = series.column(&format!("{}_{what}", force.name))?;
                let late = time.iter().zip(column).filter(|(t, v)| **t >= middle && v.is_finite());
                let late: Vec<f64> = late.map(|(_, v)| *v).collect();
                let mean = late.iter().sum::<f64>() / late.len() as f64;
                let least = late.iter().copied().fold(f64::INFINITY, f64::min);
                let most = late.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                Ok(json!({ "mean": mean, "min": least, "max": most }))
            };
            let value = json!({ "drag": of("drag")?, "lift": of("lift")? });
            found.insert(force.name.clone(), value);
        }
        Ok(found)
    }

    /// What the series says of each structure.
    fn findings(
        scene: &Scene,
        series: &Series,
    ) -> BTreeMap<String, serde_json::Map<String, serde_json::Value>> {
        let mut found = BTreeMap::new();
        let (dimension, units) = (scene.dimension(), &scene.units);
        let columns = Columns { series, dimension, units };
        for structure in &scene.structures {
            let of = structure.findings(&columns).into_iter().map(|finding| {
                let value = match finding.value {
                    FindingValue::Word(word) => json!(word),
                    FindingValue::Number(value) => json!(value),
                };
                (finding.names[0].to_string(), value)
            });
            let of: serde_json::Map<_, _> = of.collect();
            if !of.is_empty() {
                found.insert(structure.name().to_string(), of);
            }
        }
        found
    }

    /// Writes `summary.json`.
    pub(super) fn write_summary(
        &self,
        scene: &Scene,
        problem: &dyn Problem,
        (record, plan): (&Record, &str),
        (result, alarms): (&Result<()>, &[String]),
    ) -> Result<()> {
        let (facts, moment) = (problem.facts(), problem.moment());
        let judged = !scene.structures.is_empty()
            || scene.output.forces.iter().any(|f| f.reference.is_some());
        let series = if judged { Series::read(&self.series())? } else { Series::default() };
        let [velocity, pressure, level_set] = facts.unknowns;
        let status = match result {
            Ok(()) => "finished",
            Err(e) if e.kind() == Kind::Interrupted => "interrupted",
            Err(_) => "failed",
        };
        let energies = problem.energies();
        let summary = json!({
            "title": scene.title,
            "version": crate::base::VERSION,
            "sessions": record.sessions,
            "status": status,
            "error": result.as_ref().err().filter(|e| e.kind() != Kind::Interrupted).map(ToString::to_string),
            "steps": moment.steps,
            "rejected_steps": moment.rejected,
            "end_time": moment.time,
            "cells": facts.cells,
            "edge": facts.edge,
            "memory": facts.memory,
            "unknowns": { "velocity": velocity, "pressure": pressure, "level_set": level_set },
            "meshes": facts.adapted.then_some(&record.meshes),
            "factor_entries": facts.factor.map(|(entries, _)| entries),
            "solves": record.solves,
            "seconds": record.seconds,
            "cpu_seconds": record.cpu_seconds,
            "step_seconds": record.step_seconds,
            "bandwidth": bandwidth(&facts, record),
            "alarms": alarms,
            "strouhal": Self::strouhal(scene, &series)?,
            "coefficients": Self::coefficients(scene, &series)?,
            "findings": Self::findings(scene, &series),
            "leaves": record.left,
            "fluid_enters": record.entered,
            "warnings": problem
                .warnings()
                .iter()
                .map(ToString::to_string)
                .chain(record.hasty.iter().chain(&record.told).cloned())
                .collect::<Vec<_>>(),
            "plan": plan,
            "balance": {
                "energy": energies.map(|(energies, budget)| budget.residual(&energies)),
                "start": energies.map(|(_, budget)| budget.share(budget.start)),
                "largest_energy": energies.map(|_| record.worst_balance),
                "largest_rise": energies.map(|_| record.largest_rise),
                scene.extents()[0]: record.area_change,
            },
            "final": record.last,
        });
        let text = serde_json::to_string_pretty(&summary)
            .map_err(|e| Error::internal(format!("the summary cannot be written: {e}")))?;
        write_file(&self.path.join("summary.json"), text.as_bytes())
    }
}

/// Bytes of the factor read per second by the substitutions, and speed of copying a large block of
/// memory on this machine; null for a run so short that the measurement would affect its time.
fn bandwidth(facts: &Facts, record: &Record) -> serde_json::Value {
    let solve = record.step_seconds.get("solve").copied().unwrap_or_default();
    let factor = facts.factor.map_or(0, |(_, bytes)| bytes);
    if solve < LONG_ENOUGH || factor == 0 {
        return serde_json::Value::Null;
    }
    let achieved = record.factor_bytes_read / solve;
    json!({ "factor_bytes": factor, "substitutions": record.substitutions, "achieved": achieved, "copy": copy_bandwidth() })
}

/// Minimum time of the solves in seconds for a measurement of the bandwidth, which takes some
/// hundredths of a second.
const LONG_ENOUGH: f64 = 0.5;

fn field_file(step: usize) -> String {
    format!("fields/{step:06}.vtu")
}

/// Refuses to go on with other files than those that a run was started with.
fn check_inputs(
    scene: &Scene,
    before: &BTreeMap<String, u64>,
    now: &BTreeMap<String, u64>,
) -> Result<()> {
    match before.iter().find(|(key, hash)| now.get(*key) != Some(hash)) {
        None => Ok(()),
        Some((key, _)) => {
            let keys: Vec<&str> = key.split('.').collect();
            let e = Error::input(format!("`{key}` is not what the run was started with"))
                .remedy("put back what was there, or start afresh with --overwrite");
            Err(scene.blame(&keys, e))
        }
    }
}

fn make_folder(path: &Path) -> Result<()> {
    std::fs::create_dir_all(path).map_err(|e| {
        Error::input(format!("the run folder cannot be made: {e}"))
            .at(path.display().to_string())
            .value(path.display())
            .remedy("choose a folder that can be written with --out")
    })
}

fn foreign(path: &Path) -> Error {
    Error::input(
        "the folder is not empty and holds no run of immersa; nothing in it is overwritten",
    )
    .at(path.display().to_string())
    .value(path.display())
    .remedy("choose another folder with --out")
}
