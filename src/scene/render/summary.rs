//! `summary.json`: how a run ended.

use crate::base::{Error, Result};
use crate::output::read_text;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Numbers by name; one that is not finite is `None`.
type Numbers = BTreeMap<String, Option<f64>>;

/// How a run ended. What the file does not say has no value here.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Summary {
    pub title: String,
    /// `finished`, `interrupted` or `failed`.
    pub status: String,
    pub error: Option<String>,
    pub steps: Option<u64>,
    pub end_time: Option<f64>,
    pub cells: Option<u64>,
    /// Unknowns by field.
    pub unknowns: BTreeMap<String, u64>,
    /// Seconds by phase.
    pub seconds: Numbers,
    pub alarms: Vec<String>,
    pub warnings: Vec<String>,
    pub plan: String,
    pub balance: Balance,
    /// Last values by column of the series.
    #[serde(rename = "final")]
    pub last: Numbers,
}

/// What ought to be zero.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub(super) struct Balance {
    /// Relative residual of (3.23) at the end.
    pub energy: Option<f64>,
    /// Largest rise of kinetic and elastic energy in one step, over the energy at the start.
    pub largest_rise: Option<f64>,
    /// Relative change of the enclosed area by membrane.
    pub area: Numbers,
}

impl Summary {
    /// Reads the file.
    ///
    /// # Errors
    /// It cannot be read, is no JSON, or a value is of the wrong kind.
    pub fn read(path: &Path) -> Result<Summary> {
        serde_json::from_str(&read_text(path)?).map_err(|e| {
            Error::input("the summary of the run cannot be read")
                .at(format!("{}:{}:{}", path.display(), e.line(), e.column()))
                .value(e)
                .remedy("compute the scene again, or continue it with `immersa run SCENE --resume`")
        })
    }
}
