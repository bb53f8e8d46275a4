//! Progress of a run: a bar on a terminal, plain lines otherwise.

use crate::base::Warning;
use crate::output::rounded;
use crate::scene::run::{Observer, Outcome, is_told};
use crate::studies::{self, Listener, Trial};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::time::Instant;

/// Prints progress on standard error, results on standard output.
pub(super) struct Progress {
    quiet: bool,
    title: String,
    bar: Option<ProgressBar>,
    terminal: bool,
    start: Instant,
    first_step: Option<usize>,
}

impl Progress {
    pub(super) fn new(quiet: bool, title: &str) -> Progress {
        let terminal = std::io::stderr().is_terminal();
        Progress {
            quiet,
            title: title.to_string(),
            bar: None,
            terminal,
            start: Instant::now(),
            first_step: None,
        }
    }

    /// Removes the bar.
    pub(super) fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    /// Prints the paths of the results, and the alarms.
    pub(super) fn done(&self, outcome: &Outcome, report: &Path) {
        let seconds = self.start.elapsed().as_secs_f64();
        self.line(&format!("done: {} steps in {seconds:.1} s", outcome.steps));
        for alarm in &outcome.alarms {
            // Alarms are shown even when nothing else is.
            let _ = writeln!(std::io::stderr().lock(), "ALARM: {alarm}");
        }
        if !self.quiet {
            let folder = outcome.folder.display();
            let text = format!(
                "report:  {}\nseries:  {folder}/series.csv\nfields:  {folder}/fields.pvd \
                 (ParaView)",
                report.display()
            );
            // A closed pipe is no reason to fail.
            let _ = writeln!(std::io::stdout().lock(), "{text}");
        }
    }

    fn line(&self, text: &str) {
        print_line(self.quiet, self.bar.as_ref(), text);
    }
}

/// A line on standard error, above the bar if there is one.
fn print_line(quiet: bool, bar: Option<&ProgressBar>, text: &str) {
    match bar {
        _ if quiet => {}
        Some(bar) => bar.println(text),
        None => {
            let _ = writeln!(std::io::stderr().lock(), "{text}");
        }
    }
}

impl Observer for Progress {
    fn plan(&mut self, plan: &str) {
        self.line(&format!("{}\n\n{plan}", self.title));
    }
    fn warning(&mut self, warning: &Warning) {
        self.line(&format!("warning: {warning}"));
    }
    fn progress(&mut self, step: usize, steps: usize, time: f64) {
        let first = *self.first_step.get_or_insert_with(|| {
            self.start = Instant::now();
            step - 1
        });
        if self.quiet {
            return;
        }
        if self.terminal {
            let bar = self.bar.get_or_insert_with(|| {
                let style =
                    ProgressStyle::with_template("{bar:40} {pos}/{len} steps  {msg}  {eta} left")
                        .unwrap_or_else(|_| ProgressStyle::default_bar());
                ProgressBar::new(steps as u64).with_style(style).with_position(first as u64)
            });
            bar.set_message(format!("t = {time:.4}"));
            bar.set_position(step as u64);
        } else if is_told(step, steps) {
            let spent = self.start.elapsed().as_secs_f64();
            let left = spent * (steps - step) as f64 / (step - first).max(1) as f64;
            self.line(&format!("step {step} of {steps}, t = {time:.4}, about {left:.0} s left"));
        }
    }
    fn phase(&mut self, what: &str) {
        self.line(&format!("{what} ..."));
    }
}

/// Prints how the runs of a study go, on standard error: a bar for the current run on a terminal,
/// and a line for each that ended.
pub(super) struct Runs {
    quiet: bool,
    bar: Option<ProgressBar>,
    place: String,
}

impl Runs {
    pub(super) fn new(quiet: bool) -> Runs {
        let terminal = std::io::stderr().is_terminal();
        let style = ProgressStyle::with_template("{prefix} {bar:30} {pos}/{len} steps  {eta} left");
        let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = (terminal && !quiet).then(|| ProgressBar::new(1).with_style(style));
        Runs { quiet, bar, place: String::new() }
    }

    /// Removes the bar.
    pub(super) fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Listener for Runs {
    fn begins(&mut self, k: usize, of: usize, trial: &Trial) {
        self.place = format!("[{k}/{of}] {}", trial.label);
        if let Some(bar) = &self.bar {
            bar.reset();
            bar.set_prefix(self.place.clone());
        }
    }
    fn progress(&mut self, step: usize, steps: usize, _: f64) {
        if let Some(bar) = &self.bar {
            bar.set_length(steps as u64);
            bar.set_position(step as u64);
        }
    }
    fn ended(&mut self, outcome: &studies::Outcome) {
        let cpu = outcome.cpu_seconds();
        let cost = if cpu.is_nan() { String::new() } else { format!(", {} s", rounded(cpu, 3)) };
        self.note(&format!("{}: {}{cost}", self.place, outcome.end.in_words()));
    }
    fn note(&mut self, text: &str) {
        print_line(self.quiet, self.bar.as_ref(), text);
    }
}
