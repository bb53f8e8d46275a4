//! The log of a run: what was told while it ran, with times.

use super::session::{Session, now};
use super::{Observer, is_told};
use crate::base::{Error, Result, Warning};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::Path;

/// Writes to a file what it hands on to another observer. A log that cannot be written is no reason
/// to end a run.
pub(super) struct Log<'a> {
    file: File,
    to: &'a mut dyn Observer,
}

impl<'a> Log<'a> {
    /// Goes on with the log of a run folder, in a session that begins.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn open(path: &Path, session: &Session, to: &'a mut dyn Observer) -> Result<Log<'a>> {
        let file = OpenOptions::new().create(true).append(true).open(path).map_err(|e| {
            Error::input(format!("the log cannot be written: {e}"))
                .at(path.display().to_string())
                .remedy("choose a folder that can be written with --out")
        })?;
        let mut log = Log { file, to };
        log.note(&format!("immersa {}: {}", session.version, session.command));
        log.note(&session.machine);
        Ok(log)
    }
    /// Notes a text, each line with the time.
    pub fn note(&mut self, text: &str) {
        let now = now();
        for line in text.lines() {
            let _ = writeln!(self.file, "{now} {line}");
        }
    }
}

impl Observer for Log<'_> {
    fn plan(&mut self, plan: &str) {
        self.note(plan);
        self.to.plan(plan);
    }
    fn warning(&mut self, warning: &Warning) {
        self.note(&format!("warning: {warning}"));
        self.to.warning(warning);
    }
    fn progress(&mut self, step: usize, steps: usize, time: f64) {
        if is_told(step, steps) {
            self.note(&format!("step {step} of {steps}, t = {time}"));
        }
        self.to.progress(step, steps, time);
    }
    fn phase(&mut self, what: &str) {
        self.note(what);
        self.to.phase(what);
    }
}
