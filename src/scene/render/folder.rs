//! The folder of a run, read for its page.

use super::summary::Summary;
use crate::base::{Error, Result, Warning};
use crate::output::{Series, read_pvd};
use crate::scene::Scene;
use crate::scene::charts::Columns;
use crate::scene::kept::is_run;
use crate::scene::keys::Named;
use crate::scene::run::Lock;
use crate::scene::schema::{Profile, Units};
use crate::scene::words::Words;
use std::path::{Path, PathBuf};

/// The folder of a run.
pub(super) struct RunFolder {
    pub path: PathBuf,
    /// Nothing else writes to the folder while its pages are made.
    _lock: Lock,
    pub scene: Scene,
    /// Units of its numbers.
    pub units: Units,
    pub summary: Summary,
    pub series: Series,
    /// Stored fields, in the order of time.
    pub frames: Vec<StoredFields>,
    /// Profiles, those that were reached.
    pub profiles: Vec<(Named<Profile>, Series)>,
    pub warnings: Vec<Warning>,
}

/// Fields at one time.
#[derive(Clone, Debug)]
pub(super) struct StoredFields {
    pub time: f64,
    /// The VTU file.
    pub file: PathBuf,
    /// Name of its picture, without ending.
    pub name: String,
}

impl RunFolder {
    pub fn open(path: &Path, overrides: &[String]) -> Result<RunFolder> {
        let scene = open_scene(path, overrides)?;
        let summary = path.join("summary.json");
        if !summary.is_file() {
            return Err(not_finished(path));
        }
        if !is_run(path) {
            return Err(not_marked(path));
        }
        let lock = Lock::take(path)?;
        let mut run = RunFolder {
            path: path.to_path_buf(),
            _lock: lock,
            summary: Summary::read(&summary)?,
            series: Series::read(&path.join("series.csv"))?,
            frames: frames(path)?,
            profiles: Vec::new(),
            warnings: Vec::new(),
            units: units(&scene),
            scene,
        };
        run.series
            .column("time")
            .map_err(|e| e.at(path.join("series.csv").display().to_string()))?;
        run.read_profiles()?;
        Ok(run)
    }

    /// Reads the profiles; warns of missing ones, whose times the run did not reach.
    fn read_profiles(&mut self) -> Result<()> {
        for profile in &self.scene.output.profiles {
            let file = self.path.join("profiles").join(format!("{}.csv", profile.name));
            if file.is_file() {
                let table = Series::read(&file)?;
                table.column("distance").map_err(|e| e.at(file.display().to_string()))?;
                self.profiles.push((profile.clone(), table));
            } else {
                let what = format!("there is no profile `{}` in this folder", profile.name);
                self.warnings.push(Warning::new(what, "the run did not come to its first time"));
            }
        }
        Ok(())
    }

    /// Creates a folder in the folder of the run, if it does not exist.
    pub fn folder(&self, name: &str) -> Result<PathBuf> {
        let path = self.path.join(name);
        std::fs::create_dir_all(&path).map_err(|e| {
            Error::input("cannot make a folder")
                .at(path.display().to_string())
                .value(e)
                .remedy("copy the run to a disk that may be written to, and render it there")
        })?;
        Ok(path)
    }

    /// A column of the series; `None` if it does not exist or has no rows.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns().column(name)
    }

    /// The columns over time.
    pub fn columns(&self) -> Columns<'_> {
        Columns { series: &self.series, dimension: self.scene.dimension(), units: &self.units }
    }
    /// The unit of a quantity; empty if it has none, or none is known.
    pub fn unit(&self, quantity: &str) -> String {
        self.units.of(quantity, self.scene.dimension())
    }
    /// A number and its unit, if it has one.
    pub fn measured(&self, number: String, quantity: &str) -> String {
        match self.unit(quantity).as_str() {
            "" => number,
            unit => format!("{number} {unit}"),
        }
    }
    /// Vocabulary for the dimension of the scene.
    pub fn words(&self) -> &'static Words {
        self.columns().words()
    }
    /// A column of a structure.
    pub fn column_of(&self, structure: &str, quantity: &str) -> Option<&[f64]> {
        self.columns().column_of(structure, quantity)
    }

    /// The last value of a column.
    pub fn last(&self, name: &str) -> Option<f64> {
        let said = self.summary.last.get(name).copied().flatten();
        said.or_else(|| self.column(name)?.last().copied())
    }
}

/// The units of a scene. A segmentation has lengths only: its time and its energies are none.
fn units(scene: &Scene) -> Units {
    let mut units = scene.units.clone();
    if scene.image.is_some() {
        (units.base.time, units.base.mass) = (None, None);
    }
    units
}

/// The resolved scene of a run folder.
fn open_scene(path: &Path, overrides: &[String]) -> Result<Scene> {
    let scene = path.join("scene.toml");
    if scene.is_file() {
        return Scene::load(&scene, overrides);
    }
    Err(Error::input("this is not the folder of a run: it has no scene.toml")
        .at(path.display().to_string())
        .value(path.display())
        .remedy("give a folder that `immersa run` has written"))
}

fn not_marked(path: &Path) -> Error {
    Error::input("this is not the folder of a run: it has no mark of one, immersa.run")
        .at(path.display().to_string())
        .value(path.display())
        .remedy("give a folder that `immersa run` has written, as a whole")
}

fn not_finished(path: &Path) -> Error {
    let scene = path.join("scene.toml");
    let scene = scene.display();
    if path.join("series.csv").is_file() {
        return Error::input("the run in this folder has not ended: there is no summary.json")
            .at(path.display().to_string())
            .value("summary.json")
            .remedy(format!(
                "end it with `immersa run {scene} --out {} --resume`",
                path.display()
            ));
    }
    Error::input("this folder holds a scene but no run: there is no summary.json")
        .at(path.display().to_string())
        .value("summary.json")
        .remedy(format!(
            "compute it with `immersa run {scene}`, and render the folder that this prints"
        ))
}

/// The stored fields; none if there is no list of them.
fn frames(path: &Path) -> Result<Vec<StoredFields>> {
    let list = path.join("fields.pvd");
    if !list.is_file() {
        return Ok(Vec::new());
    }
    let frame = |(time, file): (f64, String)| {
        let file = path.join(file);
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        StoredFields { time, file, name }
    };
    Ok(read_pvd(&list)?.into_iter().map(frame).collect())
}
