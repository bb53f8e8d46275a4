//! `summary.json`: the end of a run.

use crate::base::{Error, Result};
use crate::output::read_text;
use crate::scene::run::{Session, Solves};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Numbers by name; one that is not finite is `None`.
type Numbers = BTreeMap<String, Option<f64>>;

/// Summary of a run. Entries that the file lacks have no value.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Summary {
    /// Title of the scene.
    pub title: String,
    /// `finished`, `interrupted` or `failed`.
    pub status: String,
    /// Reason of its failure.
    pub error: Option<String>,
    /// What computed the run, the last one last.
    pub sessions: Vec<Session>,
    /// Steps made.
    pub steps: Option<u64>,
    /// The time reached.
    pub end_time: Option<f64>,
    /// Cells of the mesh.
    pub cells: Option<u64>,
    /// Longest edge of the mesh.
    pub edge: Option<f64>,
    /// Memory of all data that scale with the mesh, in bytes; an estimate.
    pub memory: Option<u64>,
    /// Unknowns by field.
    pub unknowns: BTreeMap<String, u64>,
    /// Solution of the linear systems.
    pub solves: Solves,
    /// Seconds by phase.
    pub seconds: Numbers,
    /// CPU seconds by phase; those of `first_step` are included in those of `steps`.
    pub cpu_seconds: Numbers,
    /// CPU seconds by phase of the steps.
    pub step_seconds: Numbers,
    /// Bandwidth of the substitutions; of long runs alone.
    pub bandwidth: Option<Bandwidth>,
    /// Violations of the balances.
    pub alarms: Vec<String>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// The plan of the run.
    pub plan: String,
    /// Oscillations of the lift, by force.
    pub strouhal: BTreeMap<String, Strouhal>,
    /// What the series says of each structure: words and numbers.
    pub findings: BTreeMap<String, BTreeMap<String, serde_json::Value>>,
    /// Residuals of the balances.
    pub balance: Balance,
    /// Last values by column of the series.
    #[serde(rename = "final")]
    pub last: Numbers,
}

/// Bandwidth of the substitutions, in bytes a second.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Bandwidth {
    /// Bytes of the factor.
    pub factor_bytes: f64,
    /// Number of substitutions, each of which reads it twice.
    pub substitutions: f64,
    /// Bytes read of it, over the time of the solves.
    pub achieved: f64,
    /// Bytes read and written when a large block is copied on the same machine.
    pub copy: f64,
}

/// The oscillation of a lift.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Strouhal {
    /// The Strouhal number.
    pub strouhal: f64,
    /// Its frequency.
    pub frequency: f64,
    /// Number of periods in the second half of the run.
    pub periods: u64,
    /// The largest distance of a period from the mean one, over the latter.
    pub spread: f64,
}

/// Residuals of the balances.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Balance {
    /// Relative residual of (3.23) at the end.
    pub energy: Option<f64>,
    /// Energy that the start has taken, over the energy in play.
    pub start: Option<f64>,
    /// Largest rise of kinetic and elastic energy in one step, over the energy at the start.
    pub largest_rise: Option<f64>,
    /// Relative change of the enclosed area (in space: `volume`) by membrane.
    #[serde(alias = "volume")]
    pub area: Numbers,
}

impl Summary {
    /// Reads the file.
    ///
    /// # Errors
    /// The file cannot be read, is not JSON, or contains a value of the wrong type.
    pub fn read(path: &Path) -> Result<Summary> {
        serde_json::from_str(&read_text(path)?).map_err(|e| {
            Error::input("the summary of the run cannot be read")
                .at(format!("{}:{}:{}", path.display(), e.line(), e.column()))
                .value(e)
                .remedy("compute the scene again, or continue it with `immersa run SCENE --resume`")
        })
    }
}
