//! The flow of an earlier run at a stored time.

use crate::base::{Error, Result, fnv1a};
use crate::fem::{Element, Space};
use crate::flow::nodal_pressure;
use crate::mesh::Mesh;
use crate::output::{read_file, read_pvd, read_vtu};
use crate::scene::Scene;
use crate::scene::kept::{CHECKPOINTS, Checkpoint, is_run};
use crate::scene::meshing;
use crate::scene::schema::Initial;
use crate::sim::State;
use nalgebra::SVector;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Number of stored times that a message names.
const NAMED: usize = 6;
/// Relative rounding error of a time.
const ROUNDING: f64 = 1e-9;

/// A flow at a stored time.
pub(super) struct Stored<const D: usize> {
    /// The space of the velocity.
    pub space: Space<D>,
    /// Velocity at the nodes.
    pub u: Vec<SVector<f64, D>>,
    /// Pressure at the points of the mesh.
    pub p: Vec<f64>,
    /// The time.
    pub time: f64,
}

/// What the summary says about the end of a run.
#[derive(Deserialize)]
struct Ended {
    status: String,
    end_time: Option<f64>,
}

/// What the record of a checkpoint says about its mesh.
#[derive(Deserialize)]
struct Inputs {
    inputs: BTreeMap<String, u64>,
}

/// Reads the flow that a scene starts from. The field file of its time is preferred, as it has the
/// mesh with it; both have all digits.
///
/// # Errors
/// A folder that holds no run, or none of a flow of this dimension; a run that has not finished, if
/// no time is given; a time that is not stored; files that are missing or damaged.
pub(super) fn read<const D: usize>(scene: &Scene, initial: &Initial) -> Result<Stored<D>> {
    let blame = |e| scene.blame(&["initial", "from"], e);
    let source = source::<D>(&initial.from).map_err(|e| match e.source_snippet() {
        // What is wrong is in the scene of that run.
        Some(_) => e,
        None => blame(e),
    })?;
    let files = field_files(&initial.from)?;
    let time = match initial.time {
        Some(time) => time,
        None => end(&initial.from, &files).map_err(blame)?,
    };
    let same = |t: f64| (t - time).abs() <= ROUNDING * time;
    if let Some((_, file)) = files.iter().find(|(t, _)| same(*t)) {
        return of_file(file);
    }
    let last = Last::read(&initial.from)?;
    match &last {
        Some(last) if same(last.state.time) => last.flow(&source),
        _ => {
            let all = files.iter().map(|f| f.0).chain(last.map(|last| last.state.time));
            let e = Error::input("the run in initial.from has not stored this time")
                .value(time)
                .remedy(format!("give initial.time: {}", nearest(all, time)));
            Err(scene.blame(&["initial", "time"], e))
        }
    }
}

/// The scene of a run.
fn source<const D: usize>(folder: &Path) -> Result<Scene> {
    let wrong = |what: &str, value: String| {
        Error::input(what).value(value).remedy("give the folder of a run that immersa has written")
    };
    let name = || folder.display().to_string();
    if !folder.is_dir() {
        return Err(wrong("there is no such folder", name()));
    }
    let kept = folder.join("scene.toml");
    if !is_run(folder) || !kept.is_file() {
        let what = "this is not the folder of a run: it has no mark of one, immersa.run, or no \
            scene.toml";
        return Err(wrong(what, name()));
    }
    let scene = Scene::load(&kept, &[])?;
    if scene.image.is_some() || scene.fluid.is_prescribed() {
        let what = "the run in this folder has not solved a flow";
        return Err(wrong(what, name()).remedy("give the folder of a run with a fluid"));
    }
    if scene.dimension() != D {
        let what = format!("the run in this folder has {} dimensions", scene.dimension());
        return Err(wrong(&what, name()).remedy(format!("give a run of {D} dimensions")));
    }
    Ok(scene)
}

/// The end of a run that has finished.
fn end(folder: &Path, files: &[(f64, PathBuf)]) -> Result<f64> {
    let path = folder.join("summary.json");
    let ended: Option<Ended> = match path.is_file() {
        true => serde_json::from_slice(&read_file(&path)?).map_err(|e| {
            Error::input(format!("the summary cannot be read: {e}"))
                .value(path.display())
                .remedy("run that scene again")
        })?,
        false => None,
    };
    let what = match ended {
        Some(Ended { status, end_time: Some(time) }) if status == "finished" => return Ok(time),
        Some(Ended { status, end_time }) => {
            let time = end_time.map_or_else(String::new, |t| format!(" at t = {t}"));
            match status.as_str() {
                "failed" => format!("the run in this folder has failed{time}"),
                _ => format!("the run in this folder has not finished: {status}{time}"),
            }
        }
        None => "the run in this folder has not ended: there is no summary.json".to_string(),
    };
    let times = nearest(files.iter().map(|f| f.0), f64::MAX);
    let or = if files.is_empty() { String::new() } else { format!(": {times}") };
    Err(Error::input(what)
        .value(folder.display())
        .remedy(format!("finish it (--resume), or give initial.time, a time it has stored{or}")))
}

/// The field files that are there, with their times.
fn field_files(folder: &Path) -> Result<Vec<(f64, PathBuf)>> {
    let list = folder.join("fields.pvd");
    let all = if list.is_file() { read_pvd(&list)? } else { Vec::new() };
    let all = all.into_iter().map(|(time, file)| (time, folder.join(file)));
    Ok(all.filter(|(_, file)| file.is_file()).collect())
}

/// The times nearest to `time`, in their order.
fn nearest(times: impl Iterator<Item = f64>, time: f64) -> String {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(|a, b| (a - time).abs().total_cmp(&(b - time).abs()).then(b.total_cmp(a)));
    times.dedup();
    times.truncate(NAMED);
    times.sort_by(f64::total_cmp);
    match times.is_empty() {
        true => "it has stored none".to_string(),
        false => times.iter().map(f64::to_string).collect::<Vec<_>>().join(", "),
    }
}

fn of_file<const D: usize>(file: &Path) -> Result<Stored<D>> {
    let fields = read_vtu::<D>(file)?;
    let (u, points) = (fields.vector("velocity")?.to_vec(), fields.space.mesh().points().len());
    if fields.space.element() != Element::P2 {
        return Err(Error::input("the velocity in this file has no values at midpoints of edges")
            .at(file.display().to_string())
            .value(format!("{} nodes", fields.space.len()))
            .remedy("run that scene again with this version"));
    }
    // The first fields of a run may lack the pressure.
    let p = fields.scalar("pressure").map_or_else(|_| vec![0.0; points], |p| p[..points].to_vec());
    Ok(Stored { u, p, time: fields.time, space: fields.space })
}

/// The last checkpoint of a run.
struct Last<const D: usize> {
    path: PathBuf,
    kept: Checkpoint,
    state: State<D>,
}

impl<const D: usize> Last<D> {
    /// `None` if there is no checkpoint.
    fn read(folder: &Path) -> Result<Option<Last<D>>> {
        let path = folder.join("checkpoint").join(CHECKPOINTS[0]);
        let Some(kept) = Checkpoint::read(&path)? else { return Ok(None) };
        let state = State::of_any_scene(&kept.state).map_err(|e| {
            e.at(path.display().to_string())
                .remedy("run that scene again, or give initial.time, a time of its field files")
        })?;
        Ok(Some(Last { path, kept, state }))
    }

    /// Its flow; the mesh is that of the checkpoint, or else of the scene.
    fn flow(&self, scene: &Scene) -> Result<Stored<D>> {
        let wrong = |what: &str| {
            Error::input(what)
                .at(self.path.display().to_string())
                .value(format!("{} velocities", self.state.flow.u.len()))
                .remedy(
                    "put back the mesh of that run, or let it write fields (output.fields), which \
                     have the mesh with them",
                )
        };
        let mesh = match self.kept.mesh.is_empty() {
            false => Mesh::from_bytes(&self.kept.mesh)
                .ok_or_else(|| wrong("the mesh of the checkpoint is damaged"))?,
            true => {
                let mesh = meshing::with_walls(meshing::mesh::<D>(scene)?.0);
                let Inputs { inputs } = self.kept.record(&self.path)?;
                if inputs.get("mesh") != Some(&fnv1a(&mesh.to_bytes())) {
                    return Err(wrong("the mesh of that run has changed since"));
                }
                mesh
            }
        };
        let mesh = Arc::new(mesh);
        let space = Space::new(&mesh, Element::P2);
        let pressure = Space::new(&mesh, scene.numerics.pressure);
        let flow = &self.state.flow;
        if flow.u.len() != space.len() || flow.p.len() != pressure.len() {
            return Err(wrong("the checkpoint does not fit its mesh"));
        }
        let p = nodal_pressure(&pressure, &flow.p);
        Ok(Stored { u: flow.u.clone(), p, time: self.state.time, space })
    }
}
