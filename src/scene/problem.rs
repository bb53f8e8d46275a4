//! A problem that a run steps in time, independent of the dimension.

use super::plan::Plan;
use super::row::Row;
use crate::base::{PHASES, Result, Warning};
use crate::flow::StepReport;
use crate::mesh::Mesh;
use crate::output::rounded;
use crate::sim::{Energies, EnergyBalance};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Position of a problem in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Steps made.
    pub steps: u64,
    /// Time.
    pub time: f64,
    /// Length of the last step, or of the next one.
    pub dt: f64,
    /// True if the time is one at which an adaptive step must end.
    pub at_instant: bool,
    /// True if adaptive steps have reached the end.
    pub done: bool,
    /// Number of rejected steps, for adaptive steps.
    pub rejected: Option<u64>,
}

impl Moment {
    /// State after `steps` steps of constant length.
    pub(super) fn regular(steps: u64, time: f64, dt: f64) -> Moment {
        Moment { steps, time, dt, at_instant: true, done: false, rejected: None }
    }
}

/// Sizes of a problem.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facts {
    /// Cells of the mesh.
    pub cells: usize,
    /// Longest edge of the mesh.
    pub edge: f64,
    /// Memory of all data that scale with the mesh, in bytes.
    pub memory: usize,
    /// Unknowns of velocity, pressure and level sets.
    pub unknowns: [usize; 3],
    /// Entries of the factor of the flow, and bytes of their values.
    pub factor: Option<(usize, usize)>,
    /// True if the mesh is adapted.
    pub adapted: bool,
}

/// Limits and lengths computed before the first step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Half-width of the bands.
    pub thickness: Option<f64>,
    /// Shortest and longest edge in the bands.
    pub band_edges: Option<[f64; 2]>,
    /// Largest stable step of the explicit coupling (1.54) at the start, if there is one.
    pub explicit_limit: Option<f64>,
    /// The same once the membranes that have less stretch at the start are stretched by
    /// a tenth, if there are any.
    pub stretched_limit: Option<f64>,
}

/// Strain of the membranes without tension for which a plan estimates the limit of the step.
pub const FIRST_STRETCH: f64 = 0.1;

/// An elastic wave.
#[derive(Clone, Debug, PartialEq)]
pub struct ElasticWave {
    /// Name of its structure.
    pub name: String,
    /// Its period in the present tension.
    pub period: f64,
}

impl ElasticWave {
    /// Number of steps of a period below which a scheme damps a wave rather than resolves it.
    pub const STEPS: f64 = 10.0;
    /// True if steps of length `dt` are too long for it.
    pub fn is_lost(&self, dt: f64) -> bool {
        dt * ElasticWave::STEPS > self.period
    }
    /// A step of length `dt` beside the period, in words.
    pub fn in_words(&self, dt: f64) -> String {
        format!(
            "a step of {} is {} of the period {} of the elastic wave of `{}`",
            rounded(dt, 3),
            rounded(dt / self.period, 3),
            rounded(self.period, 3),
            self.name
        )
    }
}

/// Remedies of alarms and failures: choices, in terms of keys that the scene can take.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Advice {
    /// Against spurious energy.
    pub energy: Vec<String>,
    /// Against energy that vanishes.
    pub loss: Vec<String>,
    /// Against a change of an enclosed area.
    pub area: Vec<String>,
    /// Against a computation that blows up.
    pub blow_up: Vec<String>,
    /// Against what fluid that comes in through an open side does.
    pub inflow: Vec<String>,
}

/// What follows the name of a force in that of its drag, where both are compared.
pub(in crate::scene) const DRAG: &str = " along the stream";

/// A force on a boundary in two ways.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// Length of the difference of the force by the residual and by the stress.
    pub difference: f64,
    /// The larger of the two.
    pub force: f64,
    /// Integral of the size of the stress: what the force is a difference of.
    pub stresses: f64,
}

/// A column of a profile: the suffix of its name, and its values.
pub type ProfileColumn = (&'static str, Vec<f64>);

/// A time-dependent problem described by a scene: an immersed flow, advection, segmentation.
pub trait Problem {
    /// Warnings before the first step.
    fn warnings(&self) -> &[Warning];
    /// The plan. Analyses matrices without factoring them.
    ///
    /// # Errors
    /// Insufficient memory.
    fn plan(&mut self) -> Result<Plan>;
    /// Limits and lengths at the start.
    fn limits(&self) -> Limits;
    /// Advances by one step.
    ///
    /// # Errors
    /// A failed computation.
    fn step(&mut self) -> Result<StepReport>;
    /// Current time and step.
    fn moment(&self) -> Moment;
    /// One row of the series, without `time`.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn row(&self) -> Result<Row>;
    /// Values along profile number `k` of the scene, point by point.
    fn profile(&self, k: usize) -> Vec<ProfileColumn>;
    /// Points of profile number `k`, each with one coordinate per dimension.
    fn profile_points(&self, k: usize) -> Vec<Vec<f64>>;
    /// Writes the fields into a VTU file and, if the scene says so, the interfaces into a VTP file
    /// beside it.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn write_fields(&self, path: &Path) -> Result<()>;
    /// Writes the boundary of the mesh with its names into a VTP file.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn write_boundaries(&self, path: &Path) -> Result<()>;
    /// Writes further results to the folder at the end of a run.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn write_results(&self, _folder: &Path) -> Result<()> {
        Ok(())
    }
    /// Rebuilds the mesh if it no longer fits interfaces or fields. Returns true if it was rebuilt.
    ///
    /// # Errors
    /// A mesh that cannot be built.
    fn follow(&mut self) -> Result<bool> {
        Ok(false)
    }
    /// Hash of the mesh: points, cells, names.
    fn mesh_hash(&self) -> u64;
    /// Hash of the flow that was taken from another run, if it was.
    fn start_hash(&self) -> Option<u64> {
        None
    }
    /// Writes the flow that was taken from another run, if it was, to a field file. To be called
    /// before the first step.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn write_start(&self, _path: &Path) -> Result<()> {
        Ok(())
    }
    /// Mesh (empty if not adapted) and state as bytes, the latter marked with `tag`.
    fn save(&self, tag: u64) -> [Vec<u8>; 2];
    /// Restores the result of [`save`](Self::save); `band_edges` are those when the mesh was built.
    ///
    /// # Errors
    /// Corrupt bytes, or a state of another scene.
    fn restore(&mut self, saved: [&[u8]; 2], tag: u64, band_edges: Option<[f64; 2]>) -> Result<()>;
    /// Energies and their balance, where a flow is solved.
    fn energies(&self) -> Option<(Energies, EnergyBalance)> {
        None
    }
    /// CPU seconds by [phase](PHASES) since the last call, and number of substitutions with the
    /// factor of the flow.
    fn take_costs(&mut self) -> ([f64; PHASES.len()], u64);
    /// Sizes.
    fn facts(&self) -> Facts;
    /// Names of the structures that have reached the boundary, or whose bands have, with what that
    /// means.
    fn at_walls(&self) -> Vec<(String, Warning)> {
        Vec::new()
    }
    /// The slowest elastic wave of each structure that has one, in the present tension; none where
    /// steps follow the error.
    fn waves(&self) -> Vec<ElasticWave> {
        Vec::new()
    }
    /// Numbers without units that characterise the problem, as far as it defines them: `reynolds`,
    /// `cell_reynolds`, `courant`, and of each structure `capillary`, `weber`, `laplace`, `bond`
    /// after its name and a dot.
    fn numbers(&self) -> Vec<(String, f64)> {
        Vec::new()
    }
    /// Names of the structures that leave the domain now, whose areas need not be kept.
    fn leaving(&self) -> Vec<String> {
        Vec::new()
    }
    /// A warning of steps that are too long for the flow, by a row of its series.
    fn hasty(&self, _row: &Row) -> Option<Warning> {
        None
    }
    /// The open side through which fluid comes in most quickly, with a warning that has the speed
    /// and the place; `None` where it is slow.
    fn inflow(&self) -> Option<(String, Warning)> {
        None
    }
    /// Structures that the mesh does not resolve now: their names, and what is wrong with what
    /// remedy.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn unresolved(&self) -> Result<Vec<(String, Warning)>> {
        Ok(Vec::new())
    }
    /// How far forces by the residual and by the stress are apart in a row of now, by name.
    ///
    /// # Errors
    /// A boundary that the mesh does not have.
    fn force_gaps(&self, _row: &Row) -> Result<Vec<(String, Gap)>> {
        Ok(Vec::new())
    }
    /// Remedies of alarms.
    fn advice(&self) -> Advice;
    /// The mesh, in the plane.
    fn plane_mesh(&self) -> Option<&Mesh<2>>;
    /// Values of `[numerics]` that were derived by the plan or given by the scene, by their keys.
    fn derived(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}
