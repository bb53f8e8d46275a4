//! What a run steps: a problem, with no dimension in its type.

use super::row::Row;
use crate::base::{PHASES, Result, Warning};
use crate::flow::StepReport;
use crate::mesh::Mesh;
use crate::sim::{Energies, EnergyBalance};
use std::path::Path;

/// Position of a problem in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Steps made.
    pub steps: u64,
    /// Time.
    pub time: f64,
    /// Length of the last step, or of the coming one.
    pub dt: f64,
    /// True if the time is one of those that steps of changing length must end at.
    pub at_instant: bool,
    /// True if steps of changing length have reached the end.
    pub done: bool,
    /// Rejected steps, where steps follow the error.
    pub rejected: Option<u64>,
}

impl Moment {
    /// After `steps` steps of one length.
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
    /// Bytes of all that grows with the mesh.
    pub memory: usize,
    /// Unknowns of velocity, pressure and level sets.
    pub unknowns: [usize; 3],
    /// Entries of the factor of the flow, and bytes of its values.
    pub factor: Option<(usize, usize)>,
    /// True if the mesh is adapted.
    pub adapted: bool,
}

/// Limits and lengths known before the first step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Half-width of the bands.
    pub thickness: Option<f64>,
    /// Shortest and longest edge in the bands.
    pub band_edges: Option<[f64; 2]>,
    /// Largest stable step of the explicit coupling (1.54) at the start, if there is one.
    pub explicit_limit: Option<f64>,
}

/// Remedies of alarms, in the words of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Advice {
    /// Against spurious energy.
    pub energy: String,
    /// Against a change of an enclosed area.
    pub area: &'static str,
}

/// A column of a profile: the end of its name, and its values.
pub type ProfileColumn = (&'static str, Vec<f64>);

/// A problem in time that a scene describes: an immersed flow, advection, segmentation.
pub trait Problem {
    /// Warnings before the first step.
    fn warnings(&self) -> &[Warning];
    /// The plan as plain text, ready to print. Analyses matrices, but does not factor them.
    ///
    /// # Errors
    /// Too little memory.
    fn plan(&mut self) -> Result<String>;
    /// Limits and lengths at the start.
    fn limits(&self) -> Limits;
    /// Takes a step.
    ///
    /// # Errors
    /// A computation that failed.
    fn step(&mut self) -> Result<StepReport>;
    /// Position in time.
    fn moment(&self) -> Moment;
    /// One row of the series, without `time`.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn row(&self) -> Result<Row>;
    /// Values along profile number `k` of the scene, point by point.
    fn profile(&self, k: usize) -> Vec<ProfileColumn>;
    /// Points of profile number `k`, as many coordinates as dimensions.
    fn profile_points(&self, k: usize) -> Vec<Vec<f64>>;
    /// Writes the fields into a VTU file.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn write_fields(&self, path: &Path) -> Result<()>;
    /// Writes further results of the end of a run into its folder.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn write_results(&self, _folder: &Path) -> Result<()> {
        Ok(())
    }
    /// Rebuilds the mesh where it no longer fits interfaces or fields. Returns true if it did.
    ///
    /// # Errors
    /// A mesh that cannot be built.
    fn follow(&mut self) -> Result<bool> {
        Ok(false)
    }
    /// Mesh (empty unless it is adapted) and state as bytes, the latter marked with `tag`.
    fn save(&self, tag: u64) -> [Vec<u8>; 2];
    /// Continues from what [`save`](Self::save) gave; `band_edges` are those when the mesh was built.
    ///
    /// # Errors
    /// Damaged bytes, a state of another scene.
    fn restore(&mut self, saved: [&[u8]; 2], tag: u64, band_edges: Option<[f64; 2]>) -> Result<()>;
    /// Energies and their balance, where a flow is solved.
    fn energies(&self) -> Option<(Energies, EnergyBalance)> {
        None
    }
    /// Seconds of all processors by [phase](PHASES) since this was called last, and number of
    /// substitutions with the factor of the flow.
    fn take_costs(&mut self) -> ([f64; PHASES.len()], u64);
    /// Sizes.
    fn facts(&self) -> Facts;
    /// Names of the structures whose bands have reached the boundary.
    fn cut_bands(&self) -> Vec<String> {
        Vec::new()
    }
    /// Remedies of alarms.
    fn advice(&self) -> Advice;
    /// The mesh, in the plane.
    fn plane_mesh(&self) -> Option<&Mesh<2>>;
    /// Values of `[numerics]` that the plan derived or took from the scene, by their keys.
    fn derived(&self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
}
