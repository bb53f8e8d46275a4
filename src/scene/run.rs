//! Running a scene: steps, files, checkpoints, and going on after an interruption.

mod folder;
mod record;
mod solves;

pub use folder::Folder;
pub use solves::Solves;

use super::Scene;
use super::diagnostics::Diagnostics;
use super::dimension::{Dimension, In};
use super::model::Model;
use crate::base::{Error, Kind, Result, Warning};
use crate::output::Series;
use crate::transport::Method;
use cpu_time::ProcessTime;
use record::Record;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Energy from nowhere, over the energy in play, that raises the alarm.
const ENERGY_ALARM: f64 = 0.05;
/// Relative change of an enclosed area that raises the alarm.
const AREA_ALARM: f64 = 0.01;

/// Hears how a run goes.
pub trait Observer {
    /// The plan, before the first step.
    fn plan(&mut self, plan: &str);
    /// A warning.
    fn warning(&mut self, warning: &Warning);
    /// A step was made.
    fn progress(&mut self, step: usize, steps: usize, time: f64);
    /// Another phase has begun.
    fn phase(&mut self, what: &str);
}

/// How to run.
pub struct Options<'a> {
    /// The run folder.
    pub folder: PathBuf,
    /// Whether to go on with the run that the folder holds.
    pub resume: bool,
    /// Set to stop after the current step.
    pub stop: &'a AtomicBool,
}

/// What a run came to.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The run folder.
    pub folder: PathBuf,
    /// Steps made in all.
    pub steps: usize,
    /// What went against the balances.
    pub alarms: Vec<String>,
}

/// Runs a scene into a folder.
///
/// # Errors
/// Whatever is wrong with scene, mesh or folder; a computation that failed, its last good state and a summary being kept in the folder;
/// [`Kind::Interrupted`] when `stop` was set, the state being kept for `resume`.
pub fn run(scene: &Scene, options: &Options<'_>, observer: &mut dyn Observer) -> Result<Outcome> {
    match scene.dimension() {
        2 => run_in::<2>(scene, options, observer),
        _ => run_in::<3>(scene, options, observer),
    }
}

fn run_in<const D: usize>(scene: &Scene, options: &Options<'_>, observer: &mut dyn Observer) -> Result<Outcome>
where
    In<D>: Dimension<D>,
{
    let start = Clock::now();
    observer.phase("building the model");
    let folder = Folder::open(scene, options)?;
    let mut model = Model::<D>::new(scene)?;
    let plan = model.plan(scene)?;
    observer.plan(&plan);
    for w in &model.warnings {
        observer.warning(w);
    }
    let diagnostics = Diagnostics::new(scene, &model)?;
    model.simulation.keep_reactions(!scene.output.forces.is_empty());
    // Not before: a scene or a mesh that is wrong leaves no folder behind, and can be run again once it is mended.
    folder.make(scene)?;
    let mut run = Run::start(scene, &folder, options.resume, model, diagnostics, plan)?;
    run.record.spent("setup", &start);
    let result = run.all_steps(options.stop, observer);
    run.finish(result)
}

/// When a phase began: by the clock on the wall, and by the work of the processors for this process.
struct Clock(Instant, ProcessTime);

impl Clock {
    fn now() -> Clock {
        Clock(Instant::now(), ProcessTime::now())
    }
}

/// A run in progress.
struct Run<'a, const D: usize> {
    scene: &'a Scene,
    folder: &'a Folder,
    model: Model<D>,
    diagnostics: Diagnostics<'a, D>,
    series: Series,
    record: Record,
    plan: String,
    saved: Instant,
}

impl<'a, const D: usize> Run<'a, D>
where
    In<D>: Dimension<D>,
{
    fn start(
        scene: &'a Scene,
        folder: &'a Folder,
        resume: bool,
        mut model: Model<D>,
        diagnostics: Diagnostics<'a, D>,
        plan: String,
    ) -> Result<Run<'a, D>> {
        let columns = diagnostics.columns();
        let names: Vec<&str> = columns.iter().map(String::as_str).collect();
        let kept = if resume { folder.checkpoint(scene)? } else { None };
        let (series, record) = match kept {
            Some((record, mesh, state)) => {
                if let (Some(mesh), Some(adapt)) = (mesh, &scene.adapt) {
                    model.go_on(mesh, adapt.transfer)?;
                }
                model.simulation.restore(state)?;
                model.band_edges = record.band_edges.or(model.band_edges);
                (Series::resume(&folder.series(), &names, record.rows)?, record)
            }
            None => (Series::create(&folder.series(), &names)?, Record::default()),
        };
        let fresh = record.rows == 0;
        let diagnostics = if fresh { diagnostics } else { Diagnostics::new(scene, &model)? };
        let mut run = Run { scene, folder, model, diagnostics, series, record, plan, saved: Instant::now() };
        if fresh {
            run.record.note_mesh(&run.model);
            run.sample(0)?;
        }
        Ok(run)
    }

    /// Makes the mesh anew when it is time to look at it and it no longer fits.
    fn follow(&mut self) -> Result<()> {
        let Some(every) = self.scene.adapt.as_ref().and_then(|a| a.every) else { return Ok(()) };
        let due = (self.model.simulation.time() / every + 1e-9).floor() as u64;
        if due <= self.record.looks {
            return Ok(());
        }
        self.record.note_costs(&mut self.model.simulation);
        if self.model.follow(self.scene)? {
            self.diagnostics = Diagnostics::new(self.scene, &self.model)?;
            self.model.simulation.keep_reactions(!self.scene.output.forces.is_empty());
            self.record.note_mesh(&self.model);
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
                    .at(format!("time {:.6}", self.model.simulation.time()))
                    .remedy(format!("go on with --resume --out {}", self.folder.path().display())));
            }
            let before = self.model.simulation.state().energies.total();
            let first = self.model.simulation.state().steps == 0;
            self.timed("steps", |run| {
                let report = run.model.simulation.step()?;
                run.record.solves.note(&report);
                Ok(())
            })?;
            if first {
                self.record.note_first_step();
            }
            self.record.note_rise(before, &self.model.simulation);
            self.timed("output", |run| run.sample(run.model.simulation.state().steps as usize))?;
            let due = self.scene.output.checkpoint.is_some_and(|s| self.saved.elapsed().as_secs_f64() >= s);
            if due && !self.is_done() {
                self.timed("output", Run::save)?;
            }
            let [done, all] = self.progress();
            observer.progress(done, all, self.model.simulation.time());
        }
        Ok(())
    }

    fn is_done(&self) -> bool {
        let sim = &self.model.simulation;
        match self.scene.time.tolerance {
            Some(_) => sim.is_done() || sim.time() >= self.scene.time.end,
            None => sim.state().steps as usize >= self.scene.time.steps(),
        }
    }

    /// Steps made and to be made, as far as they are known.
    fn progress(&self) -> [usize; 2] {
        let (sim, time) = (&self.model.simulation, &self.scene.time);
        let done = sim.state().steps as usize;
        match time.tolerance {
            Some(_) => [done, done + ((time.end - sim.time()).max(0.0) / sim.settings().dt).ceil() as usize],
            None => [done, time.steps()],
        }
    }

    fn timed(&mut self, phase: &str, work: impl FnOnce(&mut Self) -> Result<()>) -> Result<()> {
        let start = Clock::now();
        let result = work(self);
        self.record.spent(phase, &start);
        result
    }

    /// Writes what is due after `step`.
    fn sample(&mut self, step: usize) -> Result<()> {
        let (output, time) = (&self.scene.output, &self.scene.time);
        let now = self.model.simulation.time();
        let (last, paced) = (self.is_done(), time.tolerance.is_some());
        let at_instant = self.model.simulation.is_at_instant();
        let near = |t: f64| at_instant && (now - t).abs() <= 1e-9 * time.end;
        let due = |interval: f64| match paced {
            _ if last || step == 0 => true,
            true => near((now / interval).round() * interval),
            false => time.step_at((step as f64 * time.step / interval + 1e-9).floor() * interval) == step,
        };
        if due(output.every) {
            let row = self.diagnostics.row(&self.model)?;
            self.series.append(now, &row)?;
            self.record.rows = self.series.rows();
            self.record.note_walls(&self.model);
            self.record.note_row(self.scene, &self.diagnostics.columns(), &row);
        }
        if [output.fields, output.pictures].into_iter().flatten().any(due) {
            self.folder.write_fields(self.scene, &self.model.simulation, step)?;
            self.record.fields.push((step, now));
            self.folder.write_collection(&self.record)?;
        }
        for (k, p) in output.profiles.iter().enumerate() {
            if p.times.iter().any(|&t| if paced { near(t) } else { time.step_at(t) == step }) {
                let values = self.diagnostics.profile(&self.model.simulation, k);
                let columns = values.into_iter().map(|(suffix, v)| (format!("t={now}{suffix}"), v));
                self.record.profiles.entry(p.name.clone()).or_default().extend(columns);
                let points: Vec<_> = self.diagnostics.profile_points(k).copied().collect();
                self.folder.write_profile(&p.name, &points, &self.record.profiles[&p.name])?;
            }
        }
        Ok(())
    }

    fn save(&mut self) -> Result<()> {
        self.record.note_costs(&mut self.model.simulation);
        self.folder.save(self.scene, &self.record, &self.model.simulation)?;
        self.saved = Instant::now();
        Ok(())
    }

    /// Writes the summary, whatever came of the run, and keeps the last good state.
    fn finish(mut self, result: Result<()>) -> Result<Outcome> {
        let failed = matches!(&result, Err(e) if e.kind() == Kind::Computation);
        let result = result.and_then(|()| {
            In::<D>::write_segmentation(self.scene, &self.model.simulation, self.folder.path())?;
            self.save()
        });
        self.record.note_costs(&mut self.model.simulation);
        let kept = if failed { self.keep_last_state() } else { Ok(()) };
        let alarms = self.alarms();
        let steps = self.model.simulation.state().steps as usize;
        let written = self.folder.write_summary(self.scene, &self.model, &self.record, &result, &alarms, &self.plan);
        // What stopped the run comes first: a disk that is full stops the summary too.
        result.and(kept).and(written)?;
        Ok(Outcome { folder: self.folder.path().to_path_buf(), steps, alarms })
    }

    fn keep_last_state(&mut self) -> Result<()> {
        let step = self.model.simulation.state().steps as usize;
        self.folder.write_fields(self.scene, &self.model.simulation, step)?;
        if self.record.fields.last().is_none_or(|last| last.0 != step) {
            self.record.fields.push((step, self.model.simulation.time()));
            self.folder.write_collection(&self.record)?;
        }
        self.save()
    }

    fn alarms(&self) -> Vec<String> {
        let mut alarms = Vec::new();
        if self.record.worst_balance > ENERGY_ALARM {
            let projected = self.model.simulation.settings().transport == Method::Projected;
            let sharp = self.model.simulation.structures().iter().any(|s| s.sharp.is_some());
            let band =
                if sharp { "" } else { " a larger thickness over the edges of the mesh, numerics.band = \"carried\"," };
            alarms.push(format!(
                "Energy balance: {:.1} % of the energy in play came from nowhere, so the motion is not to be trusted. \
                 Take a larger numerics.grad_div,{band}{} or a smaller step.",
                100.0 * self.record.worst_balance,
                if projected { " transport = \"nodal\"," } else { "" }
            ));
        }
        for (name, time) in &self.record.at_wall {
            alarms.push(format!(
                "The band of `{name}` reached the boundary at t = {time:.4}: its stress is cut off there. Enlarge the mesh or give a smaller thickness."
            ));
        }
        for (name, change) in &self.record.area_change {
            if change.abs() > AREA_ALARM {
                let remedy = match self.scene.fluid.is_prescribed() {
                    true => "numerics.transport = \"composed\" or a finer mesh",
                    false => "a larger numerics.grad_div or a finer mesh",
                };
                let [enclosed, _] = self.scene.extents();
                alarms.push(format!(
                    "Enclosed {enclosed}: that of `{name}` changed by {:+.2} %. Take {remedy}.",
                    100.0 * change
                ));
            }
        }
        alarms
    }
}
