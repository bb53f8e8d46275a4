//! The folder of a run.

use super::Options;
use super::record::{Column, Record};
use crate::base::{Error, Kind, Result, copy_bandwidth, fnv1a};
use crate::flow::nodal_pressure;
use crate::mesh::{Mesh, Point};
use crate::output::{FieldData, Table, write_file, write_pvd, write_vtu};
use crate::scene::{Model, Scene, geometry};
use crate::sim::{Simulation, State};
use nalgebra::SVector;
use serde_json::json;
use std::path::{Path, PathBuf};

/// What a checkpoint holds, if there is one: the record, the mesh where it is adapted, and the state.
type Kept<const D: usize> = Option<(Record, Option<Mesh<D>>, State<D>)>;

/// The folder of a run, with the scene as resolved in it.
pub struct Folder(PathBuf);

impl Folder {
    /// The folder of a new run, or of one to go on with. Writes nothing yet.
    ///
    /// # Errors
    /// A folder that holds a run which is not to be resumed, or whose run had another scene.
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
                    .remedy("resume with the same scene and the same --set, or start afresh in another folder"));
            }
        }
        Ok(folder)
    }

    /// Makes the folder and keeps the scene in it.
    ///
    /// # Errors
    /// It cannot be written.
    pub(super) fn make(&self, scene: &Scene) -> Result<()> {
        for path in [self.0.clone(), self.0.join("fields"), self.0.join("checkpoint"), self.0.join("profiles")] {
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

    /// Keeps the state, and what has been written up to it, in one file that is replaced as a whole: the length of the record and its
    /// hash, 8 bytes each, the record as JSON; the same of the mesh, which is empty unless it is adapted; the state.
    pub(super) fn save<const D: usize>(&self, scene: &Scene, record: &Record, sim: &Simulation<D>) -> Result<()> {
        let record =
            serde_json::to_vec(record).map_err(|e| Error::internal(format!("the record cannot be kept: {e}")))?;
        let mesh = if scene.adapt.is_some() { sim.space().mesh().to_bytes() } else { Vec::new() };
        let mut bytes = Vec::new();
        for part in [record, mesh] {
            bytes.extend((part.len() as u64).to_le_bytes());
            bytes.extend(fnv1a(&part).to_le_bytes());
            bytes.extend(part);
        }
        bytes.extend(sim.state().to_bytes(tag(scene)));
        write_file(&self.latest(), &bytes)
    }

    /// The state that was kept last, if there is one, and the mesh that it lives on where the scene adapts it.
    pub(super) fn checkpoint<const D: usize>(&self, scene: &Scene) -> Result<Kept<D>> {
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
        let mesh = if mesh.is_empty() { None } else { Some(Mesh::<D>::from_bytes(mesh).ok_or_else(damaged)?) };
        let state = State::from_bytes(state, tag(scene)).map_err(|e| e.at(path.display().to_string()))?;
        Ok(Some((record, mesh, state)))
    }

    /// Writes velocity, pressure and level sets of the current state.
    pub(super) fn write_fields<const D: usize>(&self, scene: &Scene, sim: &Simulation<D>, step: usize) -> Result<()> {
        let state = sim.state();
        let names: Vec<String> = names(sim).map(|name| format!("{name}.level_set")).collect();
        let level_sets: Vec<_> = (0..names.len()).map(|k| sim.level_set(k)).collect();
        let pressure = sim.flow().map_or(Vec::new(), |flow| nodal_pressure(flow.pressure().space(), &state.flow.p));
        let mut fields = vec![match sim.image() {
            Some(image) => ("image", FieldData::Scalar(image)),
            None => ("velocity", FieldData::Vector(&state.flow.u)),
        }];
        if !sim.is_prescribed() {
            fields.push(("pressure", FieldData::Scalar(&pressure)));
        }
        for (name, phi) in names.iter().zip(&level_sets) {
            fields.push((name, FieldData::Scalar(phi)));
        }
        let mut made = strained(sim);
        if scene.output.curvature {
            made.extend(curvatures(sim));
        }
        for (name, data) in &made {
            fields.push((name, data.as_field()));
        }
        write_vtu(&self.0.join(field_file(step)), sim.space(), sim.time(), &fields)
    }

    pub(super) fn write_collection(&self, record: &Record) -> Result<()> {
        let entries: Vec<_> = record.fields.iter().map(|&(k, time)| (time, field_file(k))).collect();
        write_pvd(&self.0.join("fields.pvd"), &entries)
    }

    pub(super) fn write_profile<const D: usize>(
        &self,
        name: &str,
        points: &[Point<D>],
        values: &[Column],
    ) -> Result<()> {
        let column = |f: &dyn Fn(&Point<D>) -> f64| points.iter().map(f).collect::<Vec<f64>>();
        let distance = column(&|p| (p - points[0]).norm());
        let places: Vec<Vec<f64>> = (0..D).map(|i| column(&|p| p[i])).collect();
        let mut columns: Vec<(&str, &[f64])> = vec![("distance", &distance)];
        columns.extend(["x", "y", "z"].into_iter().zip(places.iter().map(Vec::as_slice)));
        columns.extend(values.iter().map(|(name, v)| (name.as_str(), v.as_slice())));
        Table::new(&columns).write(&self.0.join("profiles").join(format!("{name}.csv")))
    }

    #[allow(clippy::too_many_arguments, reason = "a summary is about everything")]
    pub(super) fn write_summary<const D: usize>(
        &self,
        scene: &Scene,
        model: &Model<D>,
        record: &Record,
        result: &Result<()>,
        alarms: &[String],
        plan: &str,
    ) -> Result<()> {
        let sim = &model.simulation;
        let numbering = sim.flow().map(|flow| flow.numbering());
        let velocity = numbering.map_or(0, |n| n.first_pressure());
        let level_sets = sim.structures().len() + sim.passive().len();
        let status = match result {
            Ok(()) => "finished",
            Err(e) if e.kind() == Kind::Interrupted => "interrupted",
            Err(_) => "failed",
        };
        let summary = json!({
            "title": scene.title,
            "version": env!("CARGO_PKG_VERSION"),
            "status": status,
            "error": result.as_ref().err().filter(|e| e.kind() != Kind::Interrupted).map(ToString::to_string),
            "steps": sim.state().steps,
            "rejected_steps": sim.state().pace.as_ref().map(|p| p.clock.rejected),
            "end_time": sim.time(),
            "cells": sim.space().mesh().cell_count(),
            "edge": model.quality.greatest_diameter.value,
            "memory": sim.bytes(),
            "unknowns": {
                "velocity": velocity,
                "pressure": numbering.map_or(0, |n| n.order()) - velocity,
                "level_set": sim.space().len() * level_sets,
            },
            "meshes": model.lengths.is_some().then_some(&record.meshes),
            "factor_entries": sim.flow().and_then(|flow| flow.solver_size()).map(|(_, size)| size.entries),
            "solves": record.solves,
            "seconds": record.seconds,
            "cpu_seconds": record.cpu_seconds,
            "step_seconds": record.step_seconds,
            "bandwidth": bandwidth(sim, record),
            "alarms": alarms,
            "warnings": model.warnings.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "plan": plan,
            "balance": {
                "energy": (!sim.is_prescribed()).then(|| sim.state().budget.residual(&sim.state().energies)),
                "largest_energy": (!sim.is_prescribed()).then_some(record.worst_balance),
                "largest_rise": (!sim.is_prescribed()).then_some(record.largest_rise),
                scene.extents()[0]: record.area_change,
            },
            "final": record.last,
        });
        let text = serde_json::to_string_pretty(&summary)
            .map_err(|e| Error::internal(format!("the summary cannot be written: {e}")))?;
        write_file(&self.0.join("summary.json"), text.as_bytes())
    }
}

/// The names of all interfaces, in their order.
fn names<const D: usize>(sim: &Simulation<D>) -> impl Iterator<Item = &String> {
    sim.structures().iter().map(|s| &s.name).chain(sim.passive().iter().map(|s| &s.name))
}

/// A field that is made for a file.
enum Made<const D: usize> {
    Scalar(Vec<f64>),
    Vector(Vec<SVector<f64, D>>),
}

impl<const D: usize> Made<D> {
    fn as_field(&self) -> FieldData<'_, D> {
        match self {
            Made::Scalar(values) => FieldData::Scalar(values),
            Made::Vector(values) => FieldData::Vector(values),
        }
    }
}

/// What backward characteristics tell: the displacement `Y(x) - x` to the place at rest of each structure that resists shear, that to the place at
/// time 0, and in space area and shear about each interface.
fn strained<const D: usize>(sim: &Simulation<D>) -> Vec<(String, Made<D>)> {
    let mut fields = Vec::new();
    if !sim.has_backward_map() {
        return fields;
    }
    for (k, name) in names(sim).enumerate() {
        if sim.structures().get(k).is_some_and(|s| s.shear.is_some()) {
            fields.push((format!("{name}.displacement"), Made::Vector(sim.rest_displacement(k).into_owned())));
        }
        if D == 3 {
            let reach = sim.structures().get(k).map_or_else(|| thinnest(sim), |s| s.membrane.thickness());
            let [area, shear] = sim.nodal_strain(k, reach);
            fields.push((format!("{name}.area_change"), Made::Scalar(area)));
            fields.push((format!("{name}.shear"), Made::Scalar(shear)));
        }
    }
    fields.push(("displacement".into(), Made::Vector(sim.state().displacement.clone())));
    fields
}

/// The curvatures of each interface.
fn curvatures<const D: usize>(sim: &Simulation<D>) -> Vec<(String, Made<D>)> {
    let of = |(k, name): (usize, &String)| {
        let fields = geometry::fields(sim, k).into_iter();
        fields.map(|(end, values)| (format!("{name}.{end}"), Made::Scalar(values))).collect::<Vec<_>>()
    };
    names(sim).enumerate().flat_map(of).collect()
}

/// Two edges of the finest cell.
fn thinnest<const D: usize>(sim: &Simulation<D>) -> f64 {
    let mesh = sim.space().mesh();
    2.0 * (0..mesh.cell_count()).map(|c| mesh.diameter(c)).fold(f64::INFINITY, f64::min)
}

/// The part at the front that `Folder::save` wrote with its length and hash, and what follows; `None` when it is damaged.
fn part(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let (size, rest) = bytes.split_first_chunk::<8>()?;
    let (check, rest) = rest.split_first_chunk::<8>()?;
    let (part, rest) = rest.split_at_checked(usize::try_from(u64::from_le_bytes(*size)).ok()?)?;
    (fnv1a(part) == u64::from_le_bytes(*check)).then_some((part, rest))
}

/// What the substitutions read of the factor, and how fast a large block of memory is copied on this machine, in bytes a second; not
/// for a run so short that the measurement would show in its time.
fn bandwidth<const D: usize>(sim: &Simulation<D>, record: &Record) -> serde_json::Value {
    let solve = record.step_seconds.get("solve").copied().unwrap_or_default();
    let factor = sim.flow().and_then(|flow| flow.solver_size()).map_or(0, |(_, size)| size.value_bytes());
    if solve < LONG_ENOUGH || factor == 0 {
        return serde_json::Value::Null;
    }
    let achieved = record.factor_bytes_read / solve;
    json!({ "factor_bytes": factor, "substitutions": record.substitutions, "achieved": achieved, "copy": copy_bandwidth() })
}

/// Seconds in solves from which on the bandwidth is measured, which takes some hundredths of a second.
const LONG_ENOUGH: f64 = 0.5;

fn field_file(step: usize) -> String {
    format!("fields/{step:06}.vtu")
}

/// Tells scenes apart: a checkpoint fits only the scene that it was made with.
fn tag(scene: &Scene) -> u64 {
    fnv1a(scene.to_toml().as_bytes())
}

fn first_difference(a: &str, b: &str) -> String {
    let pair = a.lines().zip(b.lines()).find(|(x, y)| x != y);
    pair.map_or_else(|| "the number of lines differs".into(), |(x, y)| format!("`{x}` became `{y}`"))
}
