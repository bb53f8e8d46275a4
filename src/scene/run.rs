//! Running a scene: steps, files, checkpoints, and resuming after an interruption.

mod contents;
mod folder;
mod lock;
mod log;
mod physics;
mod record;
mod session;
mod solves;

pub use folder::Folder;
pub(in crate::scene) use lock::Lock;
pub use session::Session;
pub use solves::Solves;

use super::Scene;
use super::problem::Problem;
use super::problems::problem;
use super::remedies::one_of;
use super::schema::Stored;
use crate::base::{Error, Kind, Result, Warning, fnv1a};
use crate::output::{SeriesWriter, read_file};
use cpu_time::ProcessTime;
use log::Log;
use record::Record;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Spurious or lost energy, over the energy in play, that raises the alarm.
const ENERGY_ALARM: f64 = 0.05;
/// Threshold of the alarm for the relative change of an enclosed area.
const AREA_ALARM: f64 = 0.01;

/// Receives the progress of a run.
pub trait Observer {
    /// The plan, before the first step.
    fn plan(&mut self, plan: &str);
    /// A warning.
    fn warning(&mut self, warning: &Warning);
    /// Called after each step.
    fn progress(&mut self, step: usize, steps: usize, time: f64);
    /// Called when another phase begins.
    fn phase(&mut self, what: &str);
}

/// Shares of the steps after which the progress is told in lines.
const LINES: usize = 10;

/// True if the progress is told in a line after this step.
pub fn is_told(step: usize, steps: usize) -> bool {
    step == steps || step * LINES / steps > (step - 1) * LINES / steps
}

/// What becomes of an earlier run in the folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// It is kept, and there is no new one.
    Keep,
    /// It goes on from its last checkpoint.
    Resume,
    /// Its files are removed.
    Replace,
}

/// Options of a run.
pub struct Options<'a> {
    /// The run folder.
    pub folder: PathBuf,
    /// What becomes of an earlier run in it.
    pub earlier: Earlier,
    /// The command that started the run, for its log.
    pub command: String,
    /// Set to stop after the current step.
    pub stop: &'a AtomicBool,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The run folder.
    pub folder: PathBuf,
    /// Total number of steps.
    pub steps: usize,
    /// Alarms about violated balances.
    pub alarms: Vec<String>,
}

/// Runs a scene into a folder.
///
/// # Errors
/// An invalid scene, mesh or folder. A failed computation; its last valid state and a summary are
/// kept in the folder. [`Kind::Interrupted`] if `stop` was set; the state is kept for `resume`.
pub fn run(scene: &Scene, options: &Options<'_>, observer: &mut dyn Observer) -> Result<Outcome> {
    let start = Clock::now();
    observer.phase("building the model");
    let mut folder = Folder::open(scene, options)?;
    let scene = &folder.begun(scene)?;
    let mut problem = problem(scene)?;
    let plan = problem.plan()?.to_string();
    // Created only now: an invalid scene or mesh leaves no folder behind, and the run can be
    // repeated after the correction.
    folder.make(scene)?;
    let session = Session::begin(&options.command);
    let mut log = Log::open(&folder.log(), &session, observer)?;
    log.plan(&plan);
    for w in problem.warnings() {
        log.warning(w);
    }
    let resume = options.earlier == Earlier::Resume;
    let result = Run::start(scene, &folder, resume, (problem, plan), &mut log);
    let ended = result.and_then(|mut run| {
        run.record.sessions.push(session);
        folder.remove_report()?;
        run.record.spent("setup", &start);
        let result = run.all_steps(options.stop, &mut log);
        run.finish(result)
    });
    match &ended {
        Ok(outcome) => {
            outcome.alarms.iter().for_each(|alarm| log.note(&format!("ALARM: {alarm}")));
            log.note(&format!("done: {} steps", outcome.steps));
        }
        Err(e) => log.note(&format!("error: {e}")),
    }
    ended
}

/// Hashes of what a scene reads, by keys: of a mesh its points, cells and names, of another run the
/// velocity.
fn inputs(scene: &Scene, problem: &dyn Problem) -> Result<BTreeMap<String, u64>> {
    let mut inputs = BTreeMap::from([("mesh".to_string(), problem.mesh_hash())]);
    inputs.extend(problem.start_hash().map(|hash| ("initial.from".to_string(), hash)));
    if let Some(image) = &scene.image {
        let mask = image.mask.as_ref().map(|file| ("image.mask", file));
        for (key, file) in std::iter::once(("image.file", &image.file)).chain(mask) {
            inputs.insert(key.to_string(), fnv1a(&read_file(file)?));
        }
    }
    Ok(inputs)
}

/// Start of a phase, in wall time and in CPU time of this process.
struct Clock(Instant, ProcessTime);

impl Clock {
    fn now() -> Clock {
        Clock(Instant::now(), ProcessTime::now())
    }
}

/// A run in progress.
struct Run<'a> {
    scene: &'a Scene,
    folder: &'a Folder,
    problem: Box<dyn Problem>,
    series: SeriesWriter,
    record: Record,
    plan: String,
    saved: Instant,
}

impl<'a> Run<'a> {
    fn start(
        scene: &'a Scene,
        folder: &'a Folder,
        resume: bool,
        (mut problem, plan): (Box<dyn Problem>, String),
        observer: &mut dyn Observer,
    ) -> Result<Run<'a>> {
        let first = problem.row()?;
        let names: Vec<&str> = first.names().iter().map(String::as_str).collect();
        let inputs = inputs(scene, &*problem)?;
        let kept = match resume {
            true => folder.restore(scene, &inputs, &mut *problem)?,
            false => None,
        };
        let (reached, end) = (problem.moment().time, scene.time.end);
        if reached > end + 0.5 * problem.moment().dt {
            let e = Error::scene("the run has passed this end already")
                .value(format!("{end}; it has reached t = {reached:.6}"))
                .remedy("give a later time.end, or start afresh with --overwrite");
            return Err(scene.blame(&["time", "end"], e));
        }
        let (series, record) = match kept {
            Some((mut record, warning)) => {
                let missing = folder.check_fields(&mut record);
                warning.iter().chain(&missing).for_each(|w| observer.warning(w));
                (SeriesWriter::resume(&folder.series(), &names, record.rows)?, record)
            }
            None => {
                let record = Record { inputs, ..Record::default() };
                (SeriesWriter::create(&folder.series(), &names)?, record)
            }
        };
        let fresh = record.rows == 0;
        let mut run = Run { scene, folder, problem, series, record, plan, saved: Instant::now() };
        if fresh {
            run.problem.write_start(&folder.start())?;
            run.record.note_mesh(&*run.problem);
            run.record.note_waves(&*run.problem);
            let told = run.record.note_open_sides(&*run.problem);
            told.iter().for_each(|w| observer.warning(w));
            run.sample(0, observer)?;
        }
        // Those of the first mesh, also where it was adapted before the run was interrupted.
        let boundaries = folder.boundaries();
        let wanted = scene.output.store.contains(&Stored::Boundaries);
        if wanted && (fresh || !boundaries.exists()) {
            run.problem.write_boundaries(&boundaries)?;
        }
        Ok(run)
    }

    /// Rebuilds the mesh if a check is due and it no longer fits.
    fn follow(&mut self) -> Result<()> {
        let Some(every) = self.scene.adapt.as_ref().and_then(|a| a.every) else { return Ok(()) };
        let due = (self.problem.moment().time / every + 1e-9).floor() as u64;
        if due <= self.record.looks {
            return Ok(());
        }
        self.record.note_costs(&mut *self.problem);
        if self.problem.follow()? {
            self.record.note_mesh(&*self.problem);
        }
        self.record.looks = due;
        Ok(())
    }

    fn all_steps(&mut self, stop: &AtomicBool, observer: &mut dyn Observer) -> Result<()> {
        observer.phase("computing");
        while !self.is_done() {
            self.timed("adaptation", Run::follow)?;
            if stop.load(Ordering::Relaxed) {
                self.save()?;
                return Err(Error::interrupted("the run was interrupted; its state is kept")
                    .at(format!("time {:.6}", self.problem.moment().time))
                    .remedy(format!(
                        "go on with --resume --out {0}, or look at it: immersa render {0}",
                        self.folder.path().display()
                    )));
            }
            let before = self.problem.energies().map_or(0.0, |(e, _)| e.total());
            let first = self.problem.moment().steps == 0;
            self.timed("steps", |run| {
                let report = run.problem.step()?;
                run.record.solves.note(&report);
                Ok(())
            })?;
            if first {
                self.record.note_first_step();
            }
            self.record.note_rise(before, &*self.problem);
            self.record.note_waves(&*self.problem);
            let told = self.record.note_open_sides(&*self.problem);
            told.iter().for_each(|w| observer.warning(w));
            self.timed("output", |run| run.sample(run.problem.moment().steps as usize, observer))?;
            let elapsed = self.saved.elapsed().as_secs_f64();
            let due = self.scene.output.checkpoint.is_some_and(|s| elapsed >= s);
            if due && !self.is_done() {
                self.timed("output", Run::save)?;
            }
            let [done, all] = self.progress();
            observer.progress(done, all, self.problem.moment().time);
        }
        let told = self.record.force_warnings(self.scene);
        told.iter().for_each(|w| observer.warning(w));
        Ok(())
    }

    fn is_done(&self) -> bool {
        let moment = self.problem.moment();
        match self.scene.time.tolerance {
            Some(_) => moment.done || moment.time >= self.scene.time.end,
            None => moment.steps as usize >= self.scene.time.steps(),
        }
    }

    /// Number of steps done and, as far as known, in total.
    fn progress(&self) -> [usize; 2] {
        let (moment, time) = (self.problem.moment(), &self.scene.time);
        let done = moment.steps as usize;
        match time.tolerance {
            Some(_) => {
                [done, done + ((time.end - moment.time).max(0.0) / moment.dt).ceil() as usize]
            }
            None => [done, time.steps()],
        }
    }

    fn timed(&mut self, phase: &str, work: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        let start = Clock::now();
        let result = work(self);
        self.record.spent(phase, &start);
        result
    }

    /// Writes the output that is due after `step`.
    fn sample(&mut self, step: usize, observer: &mut dyn Observer) -> Result<()> {
        let (output, time, moment) = (&self.scene.output, &self.scene.time, self.problem.moment());
        let now = moment.time;
        let (last, paced) = (self.is_done(), time.tolerance.is_some());
        let near = |t: f64| moment.at_instant && (now - t).abs() <= 1e-9 * time.end;
        let due = |interval: f64| match paced {
            _ if last || step == 0 => true,
            true => near((now / interval).round() * interval),
            false => {
                let before = (step as f64 * time.step / interval + 1e-9).floor() * interval;
                time.step_at(before) == step
            }
        };
        if due(output.every) {
            let row = self.problem.row()?;
            self.series.append(now, row.values())?;
            self.record.rows = self.series.rows();
            self.record.note_structures(&*self.problem)?;
            self.record.note_row(self.scene, &row);
            let told = self.record.note_haste((&*self.problem, &row), time.end);
            told.iter().for_each(|w| observer.warning(w));
            self.record.note_forces(self.scene, (&*self.problem, &row))?;
        }
        if [output.fields, output.pictures].into_iter().flatten().any(due) {
            self.problem.write_fields(&self.folder.fields(step))?;
            self.record.fields.push((step, now));
            self.folder.write_collection(&self.record)?;
        }
        for (k, p) in output.profiles.iter().enumerate() {
            if p.times.iter().any(|&t| if paced { near(t) } else { time.step_at(t) == step }) {
                let values = self.problem.profile(k).into_iter();
                let columns = values.map(|(suffix, v)| (format!("t={now}{suffix}"), v));
                self.record.profiles.entry(p.name.clone()).or_default().extend(columns);
                let (points, written) =
                    (self.problem.profile_points(k), &self.record.profiles[&p.name]);
                self.folder.write_profile(&p.name, &points, written)?;
            }
        }
        Ok(())
    }

    fn save(&mut self) -> Result<()> {
        self.record.note_costs(&mut *self.problem);
        self.record.note_time();
        self.folder.save(self.scene, &self.record, &*self.problem)?;
        self.saved = Instant::now();
        Ok(())
    }

    /// Writes the summary for any result of the run, and keeps the last valid state.
    fn finish(mut self, result: Result<()>) -> Result<Outcome> {
        let failed = matches!(&result, Err(e) if e.kind() == Kind::Computation);
        let result = result.and_then(|()| {
            self.problem.write_results(self.folder.path())?;
            self.save()
        });
        self.record.note_costs(&mut *self.problem);
        let kept = if failed { self.keep_last_state() } else { Ok(()) };
        let kept = kept.and_then(|()| self.folder.write_all_times(self.scene, &self.record));
        let alarms = self.alarms();
        let steps = self.problem.moment().steps as usize;
        self.record.note_time();
        let told = ((&self.record, &self.plan[..]), (&result, &alarms[..]));
        let written = self.folder.write_summary(self.scene, &*self.problem, told.0, told.1);
        // The error of the run has priority: a full disk also prevents the summary.
        result.and(kept).and(written)?;
        Ok(Outcome { folder: self.folder.path().to_path_buf(), steps, alarms })
    }

    fn keep_last_state(&mut self) -> Result<()> {
        let moment = self.problem.moment();
        let step = moment.steps as usize;
        self.problem.write_fields(&self.folder.fields(step))?;
        if self.record.fields.last().is_none_or(|last| last.0 != step) {
            self.record.fields.push((step, moment.time));
            self.folder.write_collection(&self.record)?;
        }
        self.save()
    }

    fn alarms(&self) -> Vec<String> {
        let (mut alarms, mut advice) = (Vec::new(), self.problem.advice());
        if !self.record.entered.is_empty() {
            let lists = [&mut advice.energy, &mut advice.loss];
            lists.into_iter().for_each(|list| list.extend(advice.inflow.iter().cloned()));
        }
        let lost = -self.record.last_balance;
        for (share, what, remedy) in [
            (self.record.worst_balance, "is spurious", &advice.energy),
            // While a motion sets in, the energy in play is small: a loss is judged at the end.
            (lost, "vanished without viscosity taking it", &advice.loss),
        ] {
            if share > ENERGY_ALARM {
                alarms.push(format!(
                    "Energy balance: {:.1} % of the energy in play {what}, so the motion is not \
                     to be trusted. Take {}.",
                    100.0 * share,
                    one_of(remedy)
                ));
            }
        }
        let (elastic, time) = self.record.worst_elastic();
        if alarms.is_empty() && elastic.abs() > ENERGY_ALARM {
            let (what, remedy) = match elastic > 0.0 {
                true => ("is spurious", &advice.energy),
                false => ("has vanished", &advice.loss),
            };
            alarms.push(format!(
                "Elastic energy: at t = {time:.4} {:.1} % of what flow and structures have \
                 exchanged {what}, so that their forces are not to be trusted. Take {}.",
                100.0 * elastic.abs(),
                one_of(remedy)
            ));
        }
        let [lost, won] = [self.record.least_balance, self.record.worst_balance];
        let residual = if won > -lost { won } else { lost };
        for wave in self.record.lost_waves.values().filter(|_| residual.abs() > ENERGY_ALARM) {
            alarms.push(format!(
                "Elastic wave: {} at t = {:.4}, too much to follow it, and the energy balance is \
                 off by {:+.1} %. Take a smaller step.",
                wave.said,
                wave.time,
                100.0 * residual
            ));
        }
        for (time, what, remedy) in
            self.record.at_wall.values().chain(self.record.unresolved.values())
        {
            alarms.push(format!("{what} at t = {time:.4}. {remedy}."));
        }
        for (name, change) in &self.record.area_change {
            if change.abs() > AREA_ALARM {
                let ([enclosed, _], remedy) = (self.scene.extents(), one_of(&advice.area));
                alarms.push(format!(
                    "Enclosed {enclosed}: that of `{name}` changed by {:+.2} %. Take {remedy}.",
                    100.0 * change
                ));
            }
        }
        alarms
    }
}
