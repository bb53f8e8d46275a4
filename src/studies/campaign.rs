//! Running the trials of a study, each once.

use super::axis::{Axis, assignments, check_distinct, combinations};
use super::trial::{Outcome, Trial};
use crate::base::{Error, Kind, Result, Warning};
use crate::scene::Scene;
use crate::scene::run::{self, Earlier, Observer, Options};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Output that a study does not need of its runs.
const LEAN: [&str; 3] = ["output.pictures=false", "output.film=false", "output.fields=false"];

/// Receives the progress of a study.
pub trait Listener {
    /// A trial begins: number `k` of `of`, both from 1, as far as is known by now.
    fn begins(&mut self, k: usize, of: usize, trial: &Trial);
    /// A step of the current trial was made.
    fn progress(&mut self, step: usize, steps: usize, time: f64);
    /// A trial ended, or was found to have ended before.
    fn ended(&mut self, outcome: &Outcome);
    /// A remark for the user.
    fn note(&mut self, text: &str);
}

/// The runs of a study, in the folder of the study.
///
/// `folder/runs/` holds a run folder a trial, named after the trial and its scene. A trial that
/// ended is not run again; one that was interrupted goes on.
pub struct Campaign<'a> {
    scene: &'a Scene,
    folder: PathBuf,
    stop: &'a AtomicBool,
    listener: &'a mut dyn Listener,
}

impl<'a> Campaign<'a> {
    /// A campaign with `scene`; `stop` is set to stop after the current step.
    pub fn new(
        scene: &'a Scene,
        folder: &Path,
        stop: &'a AtomicBool,
        listener: &'a mut dyn Listener,
    ) -> Campaign<'a> {
        Campaign { scene, folder: folder.to_path_buf(), stop, listener }
    }
    /// The scene that the trials change.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }
    /// The folder of the study.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
    /// Set to stop as soon as possible.
    pub fn stop(&self) -> &'a AtomicBool {
        self.stop
    }
    /// The listener.
    pub fn listener(&mut self) -> &mut dyn Listener {
        self.listener
    }
    /// The scene of a trial, with the pictures and field files that its values do not ask for left
    /// out.
    ///
    /// # Errors
    /// A value that the scene does not take.
    pub fn scene_of(&self, trial: &Trial) -> Result<Scene> {
        let set: Vec<String> =
            LEAN.iter().map(ToString::to_string).chain(trial.set.iter().cloned()).collect();
        self.scene.with(&set)
    }
    /// Refuses values of `axes` that the scene does not take, and keys that are set twice, on two
    /// axes or on one and among the keys `own` that the study sets itself.
    ///
    /// # Errors
    /// Such values or keys.
    pub fn check(&self, axes: &[Axis], own: &[&str]) -> Result<()> {
        combinations(axes).iter().try_for_each(|c| {
            let set = assignments(c);
            check_distinct(set.iter().map(String::as_str).chain(own.iter().copied()))?;
            self.scene_of(&Trial::new("", set)).map(drop)
        })
    }
    /// The run folder of a trial.
    ///
    /// # Errors
    /// A value that the scene does not take.
    pub fn folder_of(&self, trial: &Trial) -> Result<PathBuf> {
        Ok(self.folder.join("runs").join(trial.key(&self.scene_of(trial)?)))
    }
    /// Runs all trials in their order.
    ///
    /// # Errors
    /// As for [`run`](Campaign::run).
    pub fn run_all(&mut self, trials: &[Trial]) -> Result<Vec<Outcome>> {
        trials.iter().enumerate().map(|(k, t)| self.run(t, k + 1, trials.len())).collect()
    }
    /// Runs a trial, number `k` of `of`, unless it has ended before.
    ///
    /// A computation that fails, and a scene that cannot be run with these values, are outcomes.
    ///
    /// # Errors
    /// A value that the scene does not know; a mesh file that is wrong; a folder that cannot be
    /// written; [`Kind::Interrupted`] when `stop` was set.
    pub fn run(&mut self, trial: &Trial, k: usize, of: usize) -> Result<Outcome> {
        let scene = self.scene_of(trial)?;
        let folder = self.folder.join("runs").join(trial.key(&scene));
        self.listener.begins(k, of, trial);
        let outcome = match ended(trial, &folder)? {
            Some(outcome) => outcome,
            None => self.compute(trial, &scene, folder)?,
        };
        self.listener.ended(&outcome);
        Ok(outcome)
    }

    fn compute(&mut self, trial: &Trial, scene: &Scene, folder: PathBuf) -> Result<Outcome> {
        let command = format!("a run of a study: {}", trial.label);
        let options = Options { earlier: Earlier::Resume, folder, command, stop: self.stop };
        match run::run(scene, &options, &mut Quiet(self.listener)) {
            Ok(_) => Outcome::read(trial, &options.folder),
            Err(e) => match e.kind() {
                // Refused before the first step nothing is left behind; failed on the way there is
                // a summary.
                Kind::Computation if options.folder.join("summary.json").exists() => {
                    Outcome::read(trial, &options.folder)
                }
                Kind::Computation | Kind::Scene => Ok(Outcome::refused(trial, e.to_string())),
                Kind::Interrupted => {
                    let what = Error::interrupted("the study was interrupted; its runs are kept")
                        .at(e.place());
                    Err(what.remedy("start the same command again: it goes on from here"))
                }
                _ => Err(e),
            },
        }
    }
}

/// Outcome of a run that has ended, from its folder.
fn ended(trial: &Trial, folder: &Path) -> Result<Option<Outcome>> {
    if !folder.join("summary.json").exists() {
        return Ok(None);
    }
    let outcome = Outcome::read(trial, folder)?;
    let ended = ["finished", "failed"].contains(&outcome.summary.status.as_str());
    Ok(ended.then_some(outcome))
}

/// Passes on the steps of a run, and nothing else.
struct Quiet<'a>(&'a mut dyn Listener);

impl Observer for Quiet<'_> {
    fn plan(&mut self, _: &str) {}
    fn warning(&mut self, _: &Warning) {}
    fn phase(&mut self, _: &str) {}
    fn progress(&mut self, step: usize, steps: usize, time: f64) {
        self.0.progress(step, steps, time);
    }
}
