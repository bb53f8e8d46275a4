//! The folder of a run.

use super::Options;
use super::record::{Column, Record};
use crate::base::{Error, Kind, Result, copy_bandwidth, fnv1a};
use crate::output::{Series, write_file, write_pvd};
use crate::scene::Scene;
use crate::scene::problem::{Facts, Problem};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Content of a checkpoint: the record, and mesh and state from [`Problem::save`].
pub(super) struct Kept {
    pub record: Record,
    pub mesh: Vec<u8>,
    pub state: Vec<u8>,
}

/// The folder of a run, with the resolved scene in it.
pub struct Folder(PathBuf);

impl Folder {
    /// Opens the folder of a new run, or of one to resume. Writes nothing yet.
    ///
    /// # Errors
    /// A folder that contains a run which is not to be resumed, or a run of another scene.
    pub(super) fn open(scene: &Scene, options: &Options<'_>) -> Result<Folder> {
        let folder = Folder(options.folder.clone());
        let kept = folder.0.join("scene.toml");
        let resolved = scene.to_toml();
        if kept.exists() && !options.resume {
            return Err(Error::input("the folder holds a run already, and nothing is overwritten")
                .at(folder.0.display().to_string())
                .value(folder.0.display())
                .remedy("go on with --resume, choose another folder with --out, or remove it"));
        }
        if kept.exists() {
            let before = Scene::load(&kept, &[])?;
            if before.to_toml() != resolved {
                return Err(Error::scene("the run to be resumed was started with another scene")
                    .at(kept.display().to_string())
                    .value(first_difference(&before.to_toml(), &resolved))
                    .remedy(
                        "resume with the same scene and the same --set, or start afresh in \
                         another folder",
                    ));
            }
        }
        Ok(folder)
    }

    /// Creates the folder and writes the scene to it.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub(super) fn make(&self, scene: &Scene) -> Result<()> {
        for path in [
            self.0.clone(),
            self.0.join("fields"),
            self.0.join("checkpoint"),
            self.0.join("profiles"),
        ] {
            std::fs::create_dir_all(&path).map_err(|e| {
                Error::input(format!("the run folder cannot be made: {e}"))
                    .at(path.display().to_string())
                    .value(path.display())
                    .remedy("choose a folder that can be written with --out")
            })?;
        }
        write_file(&self.0.join("scene.toml"), scene.to_toml().as_bytes())
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.0
    }

    pub(super) fn series(&self) -> PathBuf {
        self.0.join("series.csv")
    }

    fn latest(&self) -> PathBuf {
        self.0.join("checkpoint").join("latest.bin")
    }

    /// Writes the state and the record of all output so far to one file, which is replaced as a
    /// whole: the length of the record and its hash, 8 bytes each, the record as JSON; the same for
    /// the mesh, which is empty if not adapted; the state.
    pub(super) fn save(&self, scene: &Scene, record: &Record, problem: &dyn Problem) -> Result<()> {
        let record = serde_json::to_vec(record)
            .map_err(|e| Error::internal(format!("the record cannot be kept: {e}")))?;
        let [mesh, state] = problem.save(tag(scene));
        let mut bytes = Vec::new();
        for part in [record, mesh] {
            bytes.extend((part.len() as u64).to_le_bytes());
            bytes.extend(fnv1a(&part).to_le_bytes());
            bytes.extend(part);
        }
        bytes.extend(state);
        write_file(&self.latest(), &bytes)
    }

    /// The last checkpoint, if there is one.
    pub(super) fn checkpoint(&self) -> Result<Option<Kept>> {
        let path = self.latest();
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => {
                return Err(Error::input(format!("the checkpoint cannot be read: {e}"))
                    .at(path.display().to_string())
                    .remedy("check the permissions of the run folder"));
            }
        };
        let damaged = || {
            Error::input("the checkpoint is damaged")
                .at(path.display().to_string())
                .value(format!("{} bytes", bytes.len()))
                .remedy("start afresh in another folder with --out")
        };
        let (record, rest) = part(&bytes).ok_or_else(damaged)?;
        let (mesh, state) = part(rest).ok_or_else(damaged)?;
        let record = serde_json::from_slice(record).map_err(|_| damaged())?;
        Ok(Some(Kept { record, mesh: mesh.to_vec(), state: state.to_vec() }))
    }

    /// Continues a problem from a checkpoint.
    pub(super) fn restore(
        &self,
        scene: &Scene,
        kept: &Kept,
        problem: &mut dyn Problem,
    ) -> Result<()> {
        let saved = [&kept.mesh[..], &kept.state[..]];
        let restored = problem.restore(saved, tag(scene), kept.record.band_edges);
        restored.map_err(|e| {
            if e.place().is_empty() { e.at(self.latest().display().to_string()) } else { e }
        })
    }

    /// The field file after `step` steps.
    pub(super) fn fields(&self, step: usize) -> PathBuf {
        self.0.join(field_file(step))
    }

    pub(super) fn write_collection(&self, record: &Record) -> Result<()> {
        let entries: Vec<_> =
            record.fields.iter().map(|&(k, time)| (time, field_file(k))).collect();
        write_pvd(&self.0.join("fields.pvd"), &entries)
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
        Series::new(&columns).write(&self.0.join("profiles").join(format!("{name}.csv")))
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
        let [velocity, pressure, level_set] = facts.unknowns;
        let status = match result {
            Ok(()) => "finished",
            Err(e) if e.kind() == Kind::Interrupted => "interrupted",
            Err(_) => "failed",
        };
        let energies = problem.energies();
        let summary = json!({
            "title": scene.title,
            "version": env!("CARGO_PKG_VERSION"),
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
            "warnings": problem.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
            "plan": plan,
            "balance": {
                "energy": energies.map(|(energies, budget)| budget.residual(&energies)),
                "largest_energy": energies.map(|_| record.worst_balance),
                "largest_rise": energies.map(|_| record.largest_rise),
                scene.extents()[0]: record.area_change,
            },
            "final": record.last,
        });
        let text = serde_json::to_string_pretty(&summary)
            .map_err(|e| Error::internal(format!("the summary cannot be written: {e}")))?;
        write_file(&self.0.join("summary.json"), text.as_bytes())
    }
}

/// The first part written by `Folder::save` with its length and hash, and the rest; `None` if it is
/// corrupt.
fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (size, rest) = bytes.split_first_chunk::<8>()?;
    let (check, rest) = rest.split_first_chunk::<8>()?;
    let (part, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*size)).ok()?)?;
    (fnv1a(part) == u64::from_le_bytes(*check)).then_some((part, rest))
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

/// Identifies a scene: a checkpoint fits only the scene it was written for.
fn tag(scene: &Scene) -> u64 {
    fnv1a(scene.to_toml().as_bytes())
}

fn first_difference(a: &str, b: &str) -> String {
    let pair = a.lines().zip(b.lines()).find(|(x, y)| x != y);
    pair.map_or_else(
        || "the number of lines differs".into(),
        |(x, y)| format!("`{x}` became `{y}`"),
    )
}
