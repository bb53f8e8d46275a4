//! Running a twin in FreeFEM, and the results that were recorded of it.

mod process;

use super::twin::{Loop, Twin};
use crate::base::{Error, Result, fnv1a};
use crate::mesh::freefem;
use crate::output::{Series, read_text, write_file};
use crate::scene::{Scene, problem};
use process::{FAILED, execute, failure, tail};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;

/// Advice on the installation of FreeFEM.
pub const INSTALL: &str = "install FreeFEM (Debian and Ubuntu: apt-get install freefem++)";
const PROGRAM: &str = "FreeFem++";

/// A scene as its twin computes it.
pub struct Case<'a> {
    twin: &'a Twin,
    scene: &'a Scene,
    switches: Vec<(String, String)>,
    mesh: String,
    /// Description of the mesh.
    pub size: String,
    /// Boundaries and their labels in the mesh file.
    pub labels: Vec<(String, u32)>,
}

/// A result of FreeFEM.
#[derive(Clone, Debug)]
pub struct Reading {
    /// Columns named as in the series.
    pub table: Series,
    /// Its origin and cost.
    pub about: About,
    /// The file it was read from, if it was not computed now.
    pub recorded: Option<PathBuf>,
}

/// Origin and cost of a result of FreeFEM. The file `NAME.json` beside `NAME.csv` holds it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The program and its version.
    pub made_by: String,
    /// The value of `-loop`; may be empty.
    #[serde(rename = "loop")]
    pub work: String,
    /// The switches, but for those that name files.
    pub switches: std::collections::BTreeMap<String, String>,
    /// The mesh in words.
    pub mesh: String,
    /// Hash of the mesh file.
    pub mesh_hash: String,
    /// Steps.
    pub steps: Option<f64>,
    /// Unknowns of all fields, those that boundary conditions fix among them.
    pub unknowns: Option<f64>,
    /// CPU seconds of the first step.
    pub first_step: Option<f64>,
    /// CPU seconds of a later step.
    pub per_step: Option<f64>,
}

impl About {
    /// CPU seconds of all steps.
    pub fn cpu_seconds(&self) -> f64 {
        match (self.first_step, self.per_step, self.steps) {
            (Some(first), Some(later), Some(steps)) => first + later * (steps - 1.0),
            _ => f64::NAN,
        }
    }
}

impl<'a> Case<'a> {
    /// The case of a scene that has the scheme of the twin.
    ///
    /// # Errors
    /// A scene that cannot be run, or lacks a value that the twin takes.
    pub fn new(twin: &'a Twin, scene: &'a Scene) -> Result<Case<'a>> {
        if scene.dimension() != 2 {
            return Err(Error::scene("a twin is compared in the plane only")
                .at(twin.path().display().to_string())
                .value(format!("{} dimensions", scene.dimension()))
                .remedy(
                    "take a scene whose mesh is plane: rectangle, disc or a gmsh file of triangles",
                ));
        }
        let refused = [
            (
                scene.acting().any(|s| s.traits().on_interface),
                "force = \"sharp\"",
                "force = \"smeared\"",
            ),
            (
                scene.adapt.as_ref().is_some_and(|a| a.every.is_some()),
                "mesh.adapt.every",
                "a mesh that stays",
            ),
            (scene.time.tolerance.is_some(), "time.tolerance", "steps of one length"),
        ];
        if let Some((_, value, remedy)) = refused.into_iter().find(|(has, ..)| *has) {
            return Err(Error::scene(
                "the twin has no counterpart of what the scene asks for, and would compute \
                 something else",
            )
            .at(twin.path().display().to_string())
            .value(value)
            .remedy(format!("compare with {remedy}")));
        }
        let problem = problem(scene)?;
        let Some(mesh) = problem.plane_mesh() else {
            return Err(Error::internal("a scene of the plane has no mesh of the plane"));
        };
        Ok(Case {
            twin,
            scene,
            switches: twin.arguments(scene, &*problem)?,
            mesh: freefem::text(mesh)?,
            size: format!("{} triangles, {} points", mesh.cell_count(), mesh.points().len()),
            labels: freefem::labels(mesh),
        })
    }

    /// Runs the twin until `end` in a folder of its own in `runs`, unless it ran there before;
    /// `None` if FreeFEM is not installed.
    ///
    /// # Errors
    /// FreeFEM failed, with the last lines it printed; what it wrote cannot be used; a file cannot
    /// be written; [`Kind::Interrupted`](crate::base::Kind::Interrupted) when `stop` was set.
    pub fn run(
        &self,
        work: &Loop,
        end: f64,
        again: usize,
        runs: &Path,
        stop: &AtomicBool,
    ) -> Result<Option<Reading>> {
        let mut about = About {
            work: work.name.clone(),
            switches: self.switches.iter().cloned().collect(),
            mesh: self.size.clone(),
            mesh_hash: format!("{:016x}", fnv1a(self.mesh.as_bytes())),
            ..About::default()
        };
        about.switches.insert("-tmax".into(), format!("{end:?}"));
        about.switches.insert("-every".into(), format!("{:?}", self.scene.output.every));
        let words = format!("{about:?}{}", self.twin.text());
        let folder = runs.join(format!(
            "freefem-{}-{:08x}-{}",
            work.name,
            fnv1a(words.as_bytes()) as u32,
            again + 1
        ));
        // The folder as FreeFEM sees it, which starts beside the script.
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        if folder.join("series.json").exists() {
            return read(&folder.join("series.csv")).map(Some);
        }
        if let Ok(reason) = std::fs::read_to_string(folder.join(FAILED)) {
            return Err(failure(self.twin.path(), reason));
        }
        std::fs::create_dir_all(&folder).map_err(|e| {
            Error::input(format!("a folder cannot be made: {e}"))
                .at(folder.display().to_string())
                .remedy("choose a folder that can be written with --out")
        })?;
        write_file(&folder.join("mesh.msh"), self.mesh.as_bytes())?;
        let command = self.command(&about, &folder);
        let Some(log) = execute(command, &folder, self.twin.path(), stop)? else { return Ok(None) };
        let number = |name: &str| {
            let words = log
                .lines()
                .filter_map(|l| l.trim().split_once(' '))
                .find(|(word, _)| *word == name);
            words.and_then(|(_, v)| v.trim().parse::<f64>().ok())
        };
        about.made_by = number("freefem").map_or(PROGRAM.to_string(), |v| format!("{PROGRAM} {v}"));
        about.steps = number("steps");
        about.unknowns = number("unknowns");
        about.first_step = number("first_step");
        about.per_step = number("per_step");
        let table = table(&folder.join("series.csv")).map_err(|e| {
            let value = format!("{}; its last words: {}", e.wrong_value(), tail(&log));
            e.value(value)
        })?;
        // Last, since it says that all is there.
        let reading = Reading { table, about, recorded: None };
        reading.keep(&folder, "series")?;
        Ok(Some(reading))
    }

    fn command(&self, about: &About, folder: &Path) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(["-nw", "-v", "0"]).arg(self.twin.path());
        command.args(about.switches.iter().flat_map(|(switch, value)| [switch, value]));
        if !about.work.is_empty() {
            command.args(["-loop", &about.work]);
        }
        command
            .arg("-mesh")
            .arg(folder.join("mesh.msh"))
            .arg("-out")
            .arg(folder.join("series.csv"));
        command.current_dir(self.twin.path().parent().unwrap_or(Path::new(".")));
        // One thread, as immersa is timed with.
        command.env("OPENBLAS_NUM_THREADS", "1").env("OMP_NUM_THREADS", "1");
        command
    }

    /// The result that was recorded in `data/` beside the twin with the same mesh, step and values.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn recorded(&self) -> Result<Reading> {
        let data = self.twin.path().with_file_name("data");
        let entries =
            std::fs::read_dir(&data).map(|d| d.flatten().map(|e| e.path()).collect::<Vec<_>>());
        let mut files = entries.unwrap_or_default();
        files.retain(|p| p.extension().is_some_and(|e| e == "json"));
        files.sort();
        let mut found = Vec::new();
        for file in &files {
            let reading = read(&file.with_extension("csv"))?;
            if self.fits(&reading.about) {
                return Ok(Reading { recorded: Some(file.with_extension("csv")), ..reading });
            }
            let other = self.switches.iter().filter(|s| !Self::agrees(s, &reading.about));
            let other = other.map(|(switch, _)| {
                let value = reading.about.switches.get(switch).map_or("none", String::as_str);
                format!(", {switch} {value}")
            });
            found.push(format!("{}{}", reading.about.mesh, other.collect::<String>()));
        }
        let found = if found.is_empty() { "nothing".into() } else { found.join("; ") };
        Err(Error::input(
            "FreeFEM is not installed, and no result was recorded for this mesh, step and these \
             values",
        )
        .at(data.display().to_string())
        .value(format!("{}, time.step={:?}", self.size, self.scene.time.step))
        .remedy(format!("{INSTALL}, or compare with the values that were recorded: {found}")))
    }

    /// True for a result with the mesh, step and values of this case.
    fn fits(&self, about: &About) -> bool {
        about.mesh_hash == format!("{:016x}", fnv1a(self.mesh.as_bytes()))
            && self.switches.iter().all(|s| Self::agrees(s, about))
    }
    /// True for a result with this value of a switch.
    fn agrees((switch, value): &(String, String), about: &About) -> bool {
        let same = |a: &str, b: &str| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= 1e-12 * a.abs(),
            _ => a == b,
        };
        about.switches.get(switch).is_some_and(|v| same(value, v))
    }
}

impl Reading {
    /// Writes `NAME.csv` and `NAME.json`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, folder: &Path, name: &str) -> Result<()> {
        self.table.write(&folder.join(format!("{name}.csv")))?;
        let json = serde_json::to_string_pretty(&self.about)
            .map_err(|e| Error::internal(format!("a result cannot be written: {e}")))?;
        write_file(&folder.join(format!("{name}.json")), (json + "\n").as_bytes())
    }
}

/// A result from the files `NAME.csv` and `NAME.json`.
fn read(csv: &Path) -> Result<Reading> {
    let path = csv.with_extension("json");
    let about = serde_json::from_str(&read_text(&path)?).map_err(|e| {
        Error::input("what is said of a result of FreeFEM cannot be read")
            .at(path.display().to_string())
            .value(e)
            .remedy("remove the file, or record the result again")
    })?;
    Ok(Reading { table: table(csv)?, about, recorded: None })
}

/// The table of a twin; its times may be called `t`.
fn table(path: &Path) -> Result<Series> {
    let at = path.display().to_string();
    let mut table = Series::read(path)
        .map_err(|e| Error::computation("FreeFEM wrote no table").at(&at).value(e.what()))?;
    if let Some(t) = table.names.iter_mut().find(|n| *n == "t") {
        *t = "time".into();
    }
    let wrong =
        table.names.iter().zip(&table.columns).find(|(_, c)| c.iter().any(|v| !v.is_finite()));
    if let Some((name, _)) = wrong {
        let e = Error::computation("FreeFEM gave a value that is no number")
            .at(at)
            .value(format!("column {name}"));
        return Err(e.remedy("take a smaller time.step: explicit coupling has a limit"));
    }
    table.column("time").map_err(|e| e.at(at.clone()))?;
    Ok(table)
}
