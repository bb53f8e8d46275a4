//! `immersa study`: the same scene many times.

mod convergence;
mod phases;
mod precision;
mod stability;

use super::progress::Runs;
use super::{SceneArguments, set_threads, stop_on_interrupt};
use crate::base::Result;
use crate::output::Page;
use crate::scene::Scene;
use crate::studies::{Campaign, files};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(clap::Subcommand)]
pub(super) enum Study {
    /// Halve mesh size, time step or thickness, and say what the numbers tend to
    Convergence(convergence::Arguments),
    /// The largest stable time step, by bisection, beside the formula (1.54); or which other values
    /// are stable
    Stability(stability::Arguments),
    /// What the structures do over one or more parameters: a phase diagram
    Phases(phases::Arguments),
    /// Cost of accuracy: error against CPU time for methods, meshes and steps
    Precision(Box<precision::Arguments>),
}

/// Does a study.
pub(super) fn study(study: &Study) -> Result<()> {
    match study {
        Study::Convergence(a) => convergence::run(a),
        Study::Stability(a) => a.conduct(),
        Study::Phases(a) => a.conduct(),
        Study::Precision(a) => precision::precision(a),
    }
}

/// Options of all studies.
#[derive(clap::Args)]
pub(super) struct Common {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// The folder of the study; studies/NAME-STUDY without it. Runs that it holds already are not
    /// made again
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the findings as JSON
    #[arg(long)]
    json: bool,
    /// Threads that compute
    #[arg(long, value_name = "N", default_value = "1")]
    threads: NonZeroUsize,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

impl Common {
    /// Does the study `kind` in its folder, writes its findings there and prints them.
    pub(super) fn conduct(
        &self,
        kind: &str,
        study: impl FnOnce(&mut Campaign<'_>) -> Result<Page>,
    ) -> Result<()> {
        self.conduct_with(&self.scene.load()?, kind, study).map(drop)
    }
    /// The same with a scene that was read already; gives what was found.
    pub(super) fn conduct_with(
        &self,
        scene: &Scene,
        kind: &str,
        study: impl FnOnce(&mut Campaign<'_>) -> Result<Page>,
    ) -> Result<Page> {
        set_threads(Some(self.threads))?;
        let folder = self
            .out
            .clone()
            .unwrap_or_else(|| Path::new("studies").join(format!("{}-{kind}", scene.name())));
        let mut runs = Runs::new(self.quiet);
        let found = study(&mut Campaign::new(scene, &folder, stop_on_interrupt(), &mut runs));
        runs.finish();
        let found = found?;
        let command = command_line();
        let report = files::write(&found, &folder, &command)?;
        // A closed pipe is no reason to fail.
        let mut out = std::io::stdout().lock();
        if self.json {
            let _ = writeln!(out, "{:#}", files::json(&found, &command));
        } else if !self.quiet {
            let _ = writeln!(out, "{}\nreport:  {}", found.text(), report.display());
        }
        for alarm in &found.alarms {
            let _ = writeln!(std::io::stderr().lock(), "ALARM: {alarm}");
        }
        Ok(found)
    }
}

/// The command line of the process, as it could be typed again.
fn command_line() -> String {
    let quoted = |a: String| {
        let plain = a.chars().all(|c| c.is_ascii_alphanumeric() || "-_.,=:/+@%".contains(c));
        if plain && !a.is_empty() { a } else { format!("'{}'", a.replace('\'', "'\\''")) }
    };
    let arguments = std::env::args_os().skip(1).map(|a| quoted(a.to_string_lossy().into_owned()));
    std::iter::once("immersa".to_string()).chain(arguments).collect::<Vec<_>>().join(" ")
}
