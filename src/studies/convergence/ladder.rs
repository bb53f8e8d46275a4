//! The levels of a study: what is halved from one to the next, and the trials that show what is
//! not.

use super::Convergence;
use crate::base::{Error, Result};
use crate::scene::Scene;
use crate::scene::schema::MeshSource;
use crate::studies::Trial;
use std::path::Path;

/// Parameters that are halved from level to level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Halved {
    /// The mesh size.
    pub space: bool,
    /// The time step.
    pub time: bool,
    /// The half-width of the band.
    pub thickness: bool,
}

/// The trials of a study.
pub(super) struct Ladder {
    /// From coarse to fine.
    pub levels: Vec<Trial>,
    /// The coarsest level with something else halved, which the levels keep or which follows
    /// another; with its name.
    pub checks: Vec<(&'static str, Trial)>,
    /// The half-width of the band on the coarsest level.
    pub thickness: Option<f64>,
}

impl Ladder {
    /// The trials for `scene`, whose band has the half-width `thickness` as resolved; `common` is
    /// set in all of them.
    ///
    /// # Errors
    /// Something is to be halved that the scene does not have.
    pub fn new(
        scene: &Scene,
        settings: &Convergence,
        thickness: Option<f64>,
        common: &[String],
    ) -> Result<Ladder> {
        if settings.halved.thickness && thickness.is_none() {
            return Err(Error::scene("the scene has no membrane, hence no thickness to refine")
                .at("--thickness")
                .remedy("use --space, --time or --both"));
        }
        let rung = Rung { scene, meshes: settings, thickness };
        let count =
            if settings.meshes.is_empty() { settings.levels } else { settings.meshes.len() };
        let levels =
            (0..count).map(|k| rung.trial(settings.halved, k, common)).collect::<Result<_>>()?;
        let mut checks = Vec::new();
        for (wanted, name, more) in [
            (
                settings.halved.thickness || !settings.halved.time,
                STEP,
                Halved { time: true, ..Halved::default() },
            ),
            (
                settings.halved.thickness || !settings.halved.space,
                MESH,
                Halved { space: true, ..Halved::default() },
            ),
        ] {
            if wanted && settings.checks {
                let mut trial = rung.trial(more, 1, common)?;
                trial.label = format!("check: {}", trial.label);
                checks.push((name, trial));
            }
        }
        Ok(Ladder { levels, checks, thickness })
    }
}

/// The names of the checks.
const STEP: &str = "step halved";
const MESH: &str = "mesh halved";

/// A scene on its levels.
struct Rung<'a> {
    scene: &'a Scene,
    meshes: &'a Convergence,
    thickness: Option<f64>,
}

impl Rung<'_> {
    /// The trial of level `k`, counted from 0.
    fn trial(&self, halved: Halved, k: usize, common: &[String]) -> Result<Trial> {
        let times = |on: bool| if on { k } else { 0 };
        let mut set = common.to_vec();
        let mut label = Vec::new();
        if let Some(eps) = self.thickness {
            let eps = eps / power(times(halved.thickness))?;
            // Also where the scene leaves it to the mesh: it must not follow a mesh that is refined
            // alone.
            set.push(format!("numerics.thickness={eps:?}"));
            if halved.thickness {
                label.push(format!("eps = {eps}"));
            }
        }
        if halved.space || !self.meshes.meshes.is_empty() {
            let (values, name) = self.mesh(times(halved.space))?;
            set.extend(values);
            label.push(name);
        }
        if halved.time {
            let step = self.scene.time.step / power(times(halved.time))?;
            set.push(format!("time.step={step:?}"));
            label.push(format!("dt = {step}"));
        }
        Ok(Trial::new(label.join(", "), set))
    }

    /// The mesh of level `k`: what is set, and its name.
    fn mesh(&self, k: usize) -> Result<(Vec<String>, String)> {
        if let Some(path) = self.meshes.meshes.get(k).or(self.meshes.meshes.first()) {
            let path = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            let name =
                path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
            return Ok((vec![format!("mesh.file={}", quoted(&path))], name));
        }
        let finer = |n: usize| n.saturating_mul(1 << k.min(30));
        Ok(match &self.scene.mesh {
            MeshSource::Rectangle(rectangle) => {
                let [nx, ny] = rectangle.cells.map(finer);
                let name = if nx == ny { format!("n = {nx}") } else { format!("n = {nx} x {ny}") };
                (vec![format!("mesh.rectangle.cells=[{nx}, {ny}]")], name)
            }
            MeshSource::Disc(disc) => {
                let n = finer(disc.cells);
                (vec![format!("mesh.disc.cells={n}")], format!("n = {n}"))
            }
            MeshSource::File { refine, .. } => {
                (vec![format!("mesh.refine={}", refine + k)], format!("refine = {}", refine + k))
            }
            MeshSource::Box(block) => {
                let cells = block.cells.map(finer);
                let [nx, ny, nz] = cells;
                let name = if nx == ny && ny == nz {
                    format!("n = {nx}")
                } else {
                    format!("n = {nx} x {ny} x {nz}")
                };
                (vec![format!("mesh.box.cells={cells:?}")], name)
            }
            MeshSource::BallInBox(ball) => {
                let (cells, edge) = (ball.cells.map(finer), ball.edge / power(k)?);
                let set = [
                    format!("mesh.ball_in_box.cells={cells:?}"),
                    format!("mesh.ball_in_box.edge={edge:?}"),
                ];
                (set.to_vec(), format!("edge = {edge}"))
            }
        })
    }
}

/// `2^k`.
fn power(k: usize) -> Result<f64> {
    let k = i32::try_from(k).ok().filter(|k| *k < 50);
    k.map(|k| 2f64.powi(k))
        .ok_or_else(|| Error::scene("the study has too many levels").at("--levels"))
}

/// A path as text in TOML.
fn quoted(path: &Path) -> String {
    let path = path.to_string_lossy();
    if path.contains('\'') { format!("{path:?}") } else { format!("'{path}'") }
}
