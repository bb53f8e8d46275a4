//! Record of the output of a run so far; a checkpoint contains it beside the state.

use super::Clock;
use super::session::{Session, now};
use super::solves::Solves;
use crate::base::{PHASES, Result, Warning};
use crate::scene::Scene;
use crate::scene::problem::{DRAG, Gap, Moment, Problem};
use crate::scene::row::Row;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Part of a run in which the error in time of the start is not told.
const START: f64 = 0.25;
/// Part of a run in which each row has to say that the steps are too long.
const LASTING: f64 = 0.1;

/// A column of a profile: its name, which contains the time, and its values.
pub(super) type Column = (String, Vec<f64>);

/// The output written, and extreme values of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// Rows of the series.
    pub rows: usize,
    /// What computed the run, the last one last.
    #[serde(default)]
    pub sessions: Vec<Session>,
    /// Hashes of the files that the scene reads, by their keys.
    #[serde(default)]
    pub inputs: BTreeMap<String, u64>,
    /// Steps with field files, and their times.
    pub fields: Vec<(usize, f64)>,
    /// Profiles by name.
    pub profiles: BTreeMap<String, Vec<Column>>,
    /// Largest rise of kinetic and elastic energy in one step that is not the work of walls and
    /// forces, over the initial energy.
    pub largest_rise: f64,
    /// Largest residual of the energy balance.
    pub worst_balance: f64,
    /// Least residual of the energy balance, with what the start has taken: negative where the scheme
    /// lost energy.
    #[serde(default)]
    pub least_balance: f64,
    /// The elastic waves that steps were too long for, in words, by structure: the quickest.
    #[serde(default)]
    pub lost_waves: BTreeMap<String, LostWave>,
    /// The residual after the last step.
    #[serde(default)]
    pub last_balance: f64,
    /// Spurious elastic energy where it was largest of that in play, that in play, and the time:
    /// while the latter was between powers of two with this exponent.
    #[serde(default)]
    pub elastic: BTreeMap<i32, [f64; 3]>,
    /// The largest elastic energy.
    #[serde(default)]
    pub largest_elastic: f64,
    /// Enclosed areas (in space: volumes) at the start.
    pub area: BTreeMap<String, f64>,
    /// Largest relative change of an enclosed area, with its sign.
    pub area_change: BTreeMap<String, f64>,
    /// First time at which a structure or its band reached the boundary, what happened, and a
    /// remedy.
    pub at_wall: BTreeMap<String, (f64, String, String)>,
    /// Structures that have begun to leave the domain, and when.
    #[serde(default)]
    pub left: BTreeMap<String, f64>,
    /// Open sides through which fluid has come in, and when it first did.
    #[serde(default)]
    pub entered: BTreeMap<String, f64>,
    /// What was told of steps that are too long for the flow.
    #[serde(default)]
    pub hasty: Option<String>,
    /// The time since which all rows say so.
    #[serde(default)]
    pub hasty_since: Option<f64>,
    /// First time at which the mesh did not resolve a structure, what was wrong, and a remedy.
    #[serde(default)]
    pub unresolved: BTreeMap<String, (f64, String, String)>,
    /// Sums over rows of the squares of how far each force by the residual and by the stress are
    /// apart, while the time was between powers of two with these exponents.
    #[serde(default)]
    pub forces: BTreeMap<String, BTreeMap<i32, Gap>>,
    /// What was told at the end.
    #[serde(default)]
    pub told: Vec<String>,
    /// The last row of the series.
    pub last: BTreeMap<String, f64>,
    /// Solves of the linear systems.
    #[serde(default)]
    pub solves: Solves,
    /// Checks of the mesh, each of which may have rebuilt it.
    pub looks: u64,
    /// Shortest and longest edge in the bands when the current mesh was built.
    pub band_edges: Option<[f64; 2]>,
    /// The meshes of an adapted run.
    pub meshes: Vec<MeshRecord>,
    /// Seconds by phase, in all sessions of the run.
    pub seconds: BTreeMap<String, f64>,
    /// CPU seconds by phase, in all sessions of the run.
    pub cpu_seconds: BTreeMap<String, f64>,
    /// CPU seconds by phase of the steps.
    #[serde(default)]
    pub step_seconds: BTreeMap<String, f64>,
    /// Number of substitutions with the factor of the flow, each of which reads it twice.
    #[serde(default)]
    pub substitutions: u64,
    /// Bytes of the factors read by these substitutions.
    #[serde(default)]
    pub factor_bytes_read: f64,
}

/// Relative difference of a force by the residual and by the stress that is told.
const FORCES_APART: f64 = 0.02;
/// Force over the integral of the size of the stress below which it is a small difference of large
/// numbers, of which only the latter can be resolved.
const TINY: f64 = 0.01;

/// An elastic wave that the steps were too long for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LostWave {
    /// Its period.
    pub period: f64,
    /// The time.
    pub time: f64,
    /// The wave and the step in words.
    pub said: String,
}

/// A mesh of an adapted run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct MeshRecord {
    /// Time of its construction.
    pub time: f64,
    /// Its cells.
    pub cells: usize,
    /// Unknowns of velocity and pressure on it.
    pub unknowns: usize,
    /// Energy added by all transfers of fields to new meshes so far.
    pub energy_transferred: f64,
}

impl Record {
    /// Records the time until which this process has computed the run.
    pub(super) fn note_time(&mut self) {
        self.sessions.iter_mut().last().into_iter().for_each(|session| session.ended = now());
    }
    /// Records the current mesh of a run with adaptation.
    pub(super) fn note_mesh(&mut self, problem: &dyn Problem) {
        let facts = problem.facts();
        if facts.adapted {
            self.band_edges = problem.limits().band_edges;
            self.meshes.push(MeshRecord {
                time: problem.moment().time,
                cells: facts.cells,
                unknowns: facts.unknowns[0] + facts.unknowns[1],
                energy_transferred: problem
                    .energies()
                    .map_or(0.0, |(_, budget)| budget.transferred),
            });
        }
    }

    /// Adds the time since `start` to a phase.
    pub(super) fn spent(&mut self, phase: &str, start: &Clock) {
        *self.seconds.entry(phase.to_string()).or_default() += start.0.elapsed().as_secs_f64();
        *self.cpu_seconds.entry(phase.to_string()).or_default() += start.1.elapsed().as_secs_f64();
    }

    /// Adds the costs of the steps since the last call.
    pub(super) fn note_costs(&mut self, problem: &mut dyn Problem) {
        let (seconds, substitutions) = problem.take_costs();
        for ((_, name), s) in PHASES.iter().zip(seconds) {
            *self.step_seconds.entry(name.to_string()).or_default() += s;
        }
        self.substitutions += substitutions;
        let factor = problem.facts().factor.map_or(0, |(_, bytes)| bytes);
        self.factor_bytes_read += 2.0 * factor as f64 * substitutions as f64;
    }

    /// Records the cost of the first step, a part of `steps`: with a constant matrix only this step
    /// factors.
    pub(super) fn note_first_step(&mut self) {
        let spent = self.cpu_seconds.get("steps").copied().unwrap_or_default();
        self.cpu_seconds.insert("first_step".to_string(), spent);
    }

    /// Records a rise of the energy from `before` in the last step.
    pub(super) fn note_rise(&mut self, before: f64, problem: &dyn Problem) {
        let Some((e, budget)) = problem.energies() else { return };
        let put_in = e.power.max(0.0) * problem.moment().dt;
        if budget.initial > 0.0 {
            self.largest_rise =
                self.largest_rise.max((e.total() - before - put_in) / budget.initial);
        }
        let spurious = budget.spurious(&e);
        self.last_balance = budget.share(spurious);
        self.largest_elastic = self.largest_elastic.max(e.elastic);
        let [elastic, in_play] = budget.elastic(&e);
        if in_play > 0.0 {
            let kept = self.elastic.entry(in_play.log2().floor() as i32).or_default();
            if elastic.abs() * kept[1] >= kept[0].abs() * in_play {
                *kept = [elastic, in_play, problem.moment().time];
            }
        }
        self.worst_balance = self.worst_balance.max(self.last_balance);
        self.least_balance = self.least_balance.min(budget.share(spurious + budget.start));
    }

    /// The largest spurious elastic energy over that in play, of either sign, and its time. What
    /// was in play while a motion set in counts as what was stored later: the errors of the first
    /// steps are no share of it, and those of later ones do not fade with the length of the run.
    pub(super) fn worst_elastic(&self) -> (f64, f64) {
        let share = |[spurious, in_play, time]: &[f64; 3]| {
            (spurious / in_play.max(self.largest_elastic), *time)
        };
        let all = self.elastic.values().map(share);
        all.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).unwrap_or_default()
    }

    /// Records the elastic waves that a step is too long for.
    pub(super) fn note_waves(&mut self, problem: &dyn Problem) {
        let Moment { dt, time, .. } = problem.moment();
        for wave in problem.waves().into_iter().filter(|w| w.is_lost(dt)) {
            let said = wave.in_words(dt);
            let lost = LostWave { period: wave.period, time, said };
            match self.lost_waves.get_mut(&wave.name) {
                Some(known) if known.period <= lost.period => {}
                Some(known) => *known = lost,
                None => drop(self.lost_waves.insert(wave.name, lost)),
            }
        }
    }

    /// Records the structures that leave the domain and the open sides through which fluid comes
    /// in, and returns what is to be told of those that were not known to.
    pub(super) fn note_open_sides(&mut self, problem: &dyn Problem) -> Vec<Warning> {
        let (time, mut told) = (problem.moment().time, Vec::new());
        for name in problem.leaving() {
            self.left.entry(name).or_insert_with_key(|name| {
                let what = format!("`{name}` leaves through an open side from t = {time:.4} on");
                told.push(Warning::new(what, "there it exerts no force and follows the flow"));
                time
            });
        }
        if let Some((side, warning)) = problem.inflow() {
            self.entered.entry(side).or_insert_with(|| {
                told.push(warning);
                time
            });
        }
        told
    }

    /// Records that the steps have been too long for the flow, in a tenth of the run after its first
    /// quarter, and returns what is to be told if it was not known.
    pub(super) fn note_haste(
        &mut self,
        (problem, row): (&dyn Problem, &Row),
        end: f64,
    ) -> Option<Warning> {
        let time = problem.moment().time;
        // A flow that starts at once has no short enough step.
        if self.hasty.is_some() || time < START * end {
            return None;
        }
        let Some(warning) = problem.hasty(row) else {
            self.hasty_since = None;
            return None;
        };
        if time - *self.hasty_since.get_or_insert(time) < LASTING * end {
            return None;
        }
        self.hasty = Some(warning.to_string());
        Some(warning)
    }

    /// Records the structures whose bands reach the boundary, and those that the mesh does not
    /// resolve.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub(super) fn note_structures(&mut self, problem: &dyn Problem) -> Result<()> {
        let time = problem.moment().time;
        for (name, Warning { what, remedy }) in problem.at_walls() {
            self.at_wall.entry(name).or_insert((time, what, remedy));
        }
        for (name, Warning { what, remedy }) in problem.unresolved()? {
            // What has left has no interface.
            if !self.left.contains_key(&name) && !self.at_wall.contains_key(&name) {
                self.unresolved.entry(name).or_insert((time, what, remedy));
            }
        }
        Ok(())
    }

    /// Records how far forces by the residual and by the stress are apart.
    ///
    /// # Errors
    /// A boundary that the mesh does not have.
    pub(super) fn note_forces(
        &mut self,
        scene: &Scene,
        (problem, row): (&dyn Problem, &Row),
    ) -> Result<()> {
        let time = problem.moment().time;
        if scene.output.forces.is_empty() || time <= 0.0 {
            return Ok(());
        }
        for (name, gap) in problem.force_gaps(row)? {
            let of_name = self.forces.entry(name).or_default();
            let sum = of_name.entry(time.log2().floor() as i32).or_default();
            sum.difference += gap.difference.powi(2);
            sum.force += gap.force.powi(2);
            sum.stresses += gap.stresses.powi(2);
        }
        Ok(())
    }

    /// A warning for each force whose two values are too far apart.
    pub(super) fn force_warnings(&mut self, scene: &Scene) -> Vec<Warning> {
        let warning = |(name, gaps): (&String, &BTreeMap<i32, Gap>)| {
            // The last two powers of two: half of the run to three quarters of it.
            let last = gaps.keys().next_back()?;
            let late = || gaps.range(last - 1..).map(|(_, gap)| gap);
            let sum = |of: fn(&Gap) -> f64| late().map(of).sum::<f64>().sqrt();
            let force = sum(|gap| gap.force).max(TINY * sum(|gap| gap.stresses));
            let apart = sum(|gap| gap.difference) / force;
            let boundary =
                scene.output.forces.iter().find(|f| name.trim_end_matches(DRAG) == f.name)?;
            let (name_of_force, boundary) = (&boundary.name, &boundary.boundary);
            (apart > FORCES_APART).then(|| {
                let what = format!(
                    "the force `{name}` by the residual and by the stress are {:.1} % apart \
                     (root mean square in the later part of the run)",
                    100.0 * apart
                );
                let remedy = format!(
                    "the mesh at boundary `{boundary}` is too coarse for them: take a finer one \
                     there until they agree (at sharp corners much finer); the one by the residual, \
                     `{name_of_force}_x`, is the better"
                );
                Warning::new(what, remedy)
            })
        };
        let told: Vec<Warning> = self.forces.iter().filter_map(warning).collect();
        self.told = told.iter().map(Warning::to_string).collect();
        told
    }

    /// Records a row of the series.
    pub(super) fn note_row(&mut self, scene: &Scene, row: &Row) {
        // JSON has no NaN: values that could not be measured are omitted.
        self.last = row
            .names()
            .iter()
            .cloned()
            .zip(row.values().iter().copied())
            .filter(|(_, v)| v.is_finite())
            .collect();
        let [enclosed, _] = scene.extents();
        // A segmentation does not conserve the area, nor does a domain that a structure leaves.
        let is_free =
            |name: &str| !self.left.contains_key(name) && !self.at_wall.contains_key(name);
        let kept = |name: &&str| scene.image.is_none() && is_free(name);
        for name in scene.interfaces().filter(kept) {
            // An interface that has vanished has no area.
            let area = self.last.get(&format!("{name}.{enclosed}")).copied().unwrap_or(0.0);
            let first = *self.area.entry(name.to_string()).or_insert(area);
            let change = area / first - 1.0;
            let worst = self.area_change.entry(name.to_string()).or_insert(0.0);
            if change.abs() > worst.abs() {
                *worst = change;
            }
        }
    }
}
