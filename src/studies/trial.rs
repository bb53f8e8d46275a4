//! A run of a study and its outcome.

use crate::base::{Result, fnv1a};
use crate::output::Series;
use crate::scene::Scene;
use crate::scene::render::Summary;
use std::path::Path;

/// A run of a study: its scene with single values set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trial {
    /// Its distinction from the others, for readers: `n = 60, dt = 0.01`.
    pub label: String,
    /// Assignments in the scene, each `key.sub=value`.
    pub set: Vec<String>,
    /// KeyNumber of the repetition, from 0: the same run again, for its time.
    pub repetition: usize,
}

impl Trial {
    /// A trial that is run once.
    pub fn new(label: impl Into<String>, set: Vec<String>) -> Trial {
        Trial { label: label.into(), set, repetition: 0 }
    }
    /// The name of its folder: the label as far as file systems take it, and a hash of the scene as
    /// resolved, so that trials of different scenes never share a folder.
    pub(super) fn key(&self, scene: &Scene) -> String {
        let letter = |c: char| if c.is_ascii_alphanumeric() || ".-".contains(c) { c } else { '_' };
        let slug: String = self.label.replace(" = ", "").chars().map(letter).take(60).collect();
        let again =
            if self.repetition > 0 { format!("-{}", self.repetition + 1) } else { String::new() };
        format!("{slug}-{:08x}{again}", fnv1a(scene.to_toml().as_bytes()) as u32)
    }
}

/// End of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// It reached its last time.
    Finished,
    /// It blew up, or a solve failed.
    Failed {
        /// The last good time.
        time: f64,
        /// The reason.
        reason: String,
    },
    /// The scene with these values cannot be run: a band too thin for its mesh.
    Refused {
        /// The reason.
        reason: String,
    },
}

impl End {
    /// In a few words: `finished`, `blew up at t = 0.31`, `refused`.
    pub fn in_words(&self) -> String {
        match self {
            End::Finished => "finished".into(),
            End::Failed { time, reason } if reason.contains("blew up") => {
                format!("blew up at t = {time:.4}")
            }
            End::Failed { time, .. } => format!("failed at t = {time:.4}"),
            End::Refused { .. } => "refused".into(),
        }
    }
    /// Reason for which it did not reach its last time; empty if it did.
    pub fn reason(&self) -> &str {
        match self {
            End::Finished => "",
            End::Failed { reason, .. } | End::Refused { reason } => reason,
        }
    }
}

/// Outcome of a trial.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The trial.
    pub trial: Trial,
    /// Its end.
    pub end: End,
    /// Its series, up to where it came; without columns if it was refused.
    pub series: Series,
    /// Its summary; empty if it was refused.
    pub summary: Summary,
}

impl Outcome {
    /// Reads what a run left in its folder.
    pub(super) fn read(trial: &Trial, folder: &Path) -> Result<Outcome> {
        let summary = Summary::read(&folder.join("summary.json"))?;
        let series = Series::read(&folder.join("series.csv"))?;
        let end = match &summary.error {
            None => End::Finished,
            Some(reason) => {
                End::Failed { time: summary.end_time.unwrap_or(f64::NAN), reason: reason.clone() }
            }
        };
        Ok(Outcome { trial: trial.clone(), end, series, summary })
    }
    /// A trial that could not be run.
    pub(super) fn refused(trial: &Trial, reason: String) -> Outcome {
        let end = End::Refused { reason };
        Outcome {
            trial: trial.clone(),
            end,
            series: Series::default(),
            summary: Summary::default(),
        }
    }
    /// True if it reached its last time.
    pub fn finished(&self) -> bool {
        self.end == End::Finished
    }
    /// The value of a column of the series at a time; NaN if the run did not come there or has no
    /// row at it.
    ///
    /// # Errors
    /// A run that was not refused has no such column.
    pub fn value(&self, column: &str, time: f64) -> Result<f64> {
        if self.series.names.is_empty() {
            return Ok(f64::NAN);
        }
        let values = self.series.column(column)?;
        Ok(self.series.row_at(time)?.and_then(|i| values.get(i)).copied().unwrap_or(f64::NAN))
    }
    /// Seconds of all processors in the time steps, with those that made the mesh anew between
    /// them: no set-up, no output.
    pub fn cpu_seconds(&self) -> f64 {
        let spent = |phase: &str| self.summary.cpu_seconds.get(phase).copied().flatten();
        spent("steps").unwrap_or(f64::NAN) + spent("adaptation").unwrap_or(0.0)
    }
    /// Seconds of all processors in the first step, which factors.
    pub fn cpu_first_step(&self) -> f64 {
        self.summary.cpu_seconds.get("first_step").copied().flatten().unwrap_or(f64::NAN)
    }
    /// Seconds of all processors a step after the first.
    pub fn cpu_per_later_step(&self) -> f64 {
        (self.cpu_seconds() - self.cpu_first_step())
            / (self.summary.steps.unwrap_or(0) as f64 - 1.0)
    }
    /// Unknowns of all fields.
    pub fn unknowns(&self) -> u64 {
        self.summary.unknowns.values().sum()
    }
}
