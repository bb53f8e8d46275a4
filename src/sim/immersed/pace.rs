//! Adaptive time steps: error estimate, acceptance and rejection.

use super::Simulation;
use crate::base::{Cause, Error, Kind, Result};
use crate::fem::{Cells, integrate};
use crate::flow::{ConvectionScheme, StepReport};
use crate::levelset::band_edges;
use crate::sim::State;
use crate::sim::carried::largest;
use crate::sim::clock::{Clock, Pacing};
use nalgebra::SVector;

/// Largest ratio of a step to the explicit limit (1.54).
const OF_THE_LIMIT: f64 = 0.9;
/// Courant number (longest edge of a cell) that explicit convection keeps. DFG 2D-2 is stable at .33
/// and blows up at .48.
const EXPLICIT_COURANT: f64 = 0.25;
/// Fraction of the tolerance for the first two steps, the start of order 1.
const START: f64 = 0.1;

impl<const D: usize> Simulation<D> {
    /// Makes the steps adaptive from time 0 on; [`step`](Self::step) then repeats until a step is
    /// accepted.
    ///
    /// The error of a step is the larger of two: that of the velocity, by comparing BDF2 with the
    /// extrapolation of the last three velocities, both of whose errors are known multiples of
    /// `u''' dt^3` (Milne's device), over a speed; and that of positions, `u'' dt^3/12` for the
    /// mean velocity of the step, over a length. Both are the largest at any node; in a flow
    /// without structures the first alone counts, by its root mean square over the domain. The
    /// first two steps, one of backward Euler and one of BDF2, are judged together.
    ///
    /// Explicit convection bounds the step too.
    ///
    /// # Errors
    /// A scheme of order 1, or a velocity that is prescribed.
    pub fn pace(&mut self, pacing: Pacing) -> Result<()> {
        if self.settings.order != 2 {
            return Err(Error::scene("the step can follow the error only in a flow of order 2")
                .value(format!("order {}", self.settings.order))
                .remedy("take order 2 and a flow that is solved for, or steps of one length")
                .because(Cause::ErrorControl));
        }
        self.follow_error();
        self.state.pace = Some(Clock::new(&pacing));
        self.pacing = Some(pacing);
        Ok(())
    }
    /// Prepares the solver for steps of variable length.
    pub(super) fn follow_error(&mut self) {
        self.flow.iterate(self.settings.solve_tolerance);
        self.flow.expect_changes();
    }
    /// True if the end is reached; never with steps of one length.
    pub fn is_done(&self) -> bool {
        self.pacing.as_ref().zip(self.state.pace.as_ref()).is_some_and(|(p, pace)| pace.is_done(p))
    }
    /// True if the time is one of the instants.
    pub fn is_at_instant(&self) -> bool {
        self.state.pace.as_ref().is_none_or(|pace| pace.part == 0)
    }

    /// The largest stable step of explicit convection and of the explicit coupling: (1.54) with the
    /// largest tension and the shortest edge of the bands.
    fn explicit_limit(&mut self) -> Result<f64> {
        let explicit =
            |s: &dyn crate::structure::Structure<D>| s.acts() && s.coupling().is_explicit();
        let mut limit = f64::INFINITY;
        if self.settings.convection == Some(ConvectionScheme::Explicit) && !self.is_stokes() {
            let u = [&self.state.flow.u, &self.state.earlier_u];
            let fastest = u.map(|u| self.carried.carrier.tracer.courant(u, 1.0));
            limit = EXPLICIT_COURANT / fastest[0].max(fastest[1]);
        }
        if !self.carried.structures.iter().any(|s| explicit(&**s)) {
            return Ok(limit);
        }
        self.prepare_now()?;
        for s in self.carried.structures.iter().filter(|s| explicit(&***s)) {
            let phi = s.level_set().map_or(&[][..], |id| self.state.fields.scalar(id));
            if let Some(edges) = band_edges(&self.carried.space, phi, s.reach()) {
                limit = limit.min(OF_THE_LIMIT * s.step_limit(&self.medium(&**s, edges.smallest)));
            }
        }
        Ok(limit)
    }

    /// One accepted step; rejected steps change nothing but their count.
    pub(super) fn paced_step(&mut self, pacing: &Pacing) -> Result<StepReport> {
        let limit = self.explicit_limit()?;
        let mut failure = None;
        loop {
            let Some(mut clock) = self.state.pace else {
                return Err(Error::internal("steps that follow the error have no clock"));
            };
            let start = self.state.steps == 0;
            let dt = clock
                .propose(pacing, limit, 1 + u64::from(start))
                .map_err(|e| failure.take().unwrap_or(e))?;
            let before = self.state.clone();
            let tried = self.try_step(pacing, dt, &before);
            let error = match tried {
                Ok((report, error)) if clock.judge(dt, error) => {
                    let steps = if start { 2 } else { 1 };
                    (0..steps).for_each(|_| clock.advance(dt));
                    clock.speed = clock.speed.max(largest(&self.state.flow.u));
                    self.state.time = clock.time(pacing);
                    self.state.earliest_u = if start { before.flow.u } else { before.earlier_u };
                    self.state.pace = Some(clock);
                    return Ok(report);
                }
                Ok((_, error)) => error,
                Err(e) if e.kind() == Kind::Computation => {
                    // The factor no longer belongs to the state.
                    self.flow.invalidate_factor();
                    self.state.factored = None;
                    failure = Some(e);
                    f64::INFINITY
                }
                Err(e) => return Err(e),
            };
            // The factor of the attempt is kept.
            let factored = self.state.factored.take();
            self.state = State { factored, ..before };
            if let Some(pace) = &mut self.state.pace {
                pace.judge(dt, error);
                pace.rejected += 1;
            }
        }
    }

    /// Takes a step `dt` (at the start two) and returns its error relative to the tolerance.
    fn try_step(
        &mut self,
        pacing: &Pacing,
        dt: f64,
        before: &State<D>,
    ) -> Result<(StepReport, f64)> {
        self.settings.dt = dt;
        let (mut report, start) = (self.single_step()?, before.steps == 0);
        if start {
            report = self.single_step()?;
        }
        let pace = before.pace.as_ref();
        let [h1, h2] = pace.map_or([0.0; 2], |p| [p.last, p.before]);
        let earliest = &before.earliest_u;
        let (new, now) = (&self.state.flow.u, &self.state.earlier_u);
        let fastest = pace.map_or(0.0, |p| p.speed).max(largest(new));
        let speed = pacing.speed.max(fastest).max(f64::MIN_POSITIVE);
        let alone = self.carried.structures.is_empty();
        if start {
            let bend = self.size(|n| new[n] - now[n] * 2.0 + before.flow.u[n]);
            let position = if alone { 0.0 } else { dt * bend / (6.0 * pacing.length) };
            let error = (0.5 * bend / speed).max(position);
            return Ok((report, error / (START * pacing.tolerance)));
        }
        let earlier = &before.earlier_u;
        // Newton's form of the extrapolation, and the error of BDF2 over that of the extrapolation.
        let slope = |n: usize| (now[n] - earlier[n]) / h1;
        let bend = |n: usize| (slope(n) - (earlier[n] - earliest[n]) / h2) / (h1 + h2);
        let ahead = |n: usize| now[n] + slope(n) * dt + bend(n) * (dt * (dt + h1));
        let ratio = dt / h1;
        let part = (1.0 + ratio) / (1.0 + 2.0 * ratio) * dt / (dt + h1 + h2);
        let velocity = self.size(|n| new[n] - ahead(n)) * part / (1.0 + part);
        let second = |n: usize| ((new[n] - now[n]) / dt - slope(n)) * (2.0 / (dt + h1));
        let position = if alone { 0.0 } else { self.size(second) * dt.powi(3) / 12.0 };
        let error = (velocity / speed).max(position / pacing.length);
        Ok((report, error / (pacing.tolerance * dt / pacing.memory)))
    }

    /// The size of a nodal velocity: the largest norm with structures, which are carried by it, the
    /// root mean square over the domain without.
    fn size(&self, v: impl Fn(usize) -> SVector<f64, D>) -> f64 {
        let nodes = self.state.flow.u.len();
        if !self.carried.structures.is_empty() {
            return greatest((0..nodes).map(v));
        }
        let (basis, v) = (self.flow.velocity(), (0..nodes).map(v).collect::<Vec<_>>());
        let [square] = integrate(basis, Cells::All, |at| [basis.value(at, &v).norm_squared()]);
        let size = (square / self.space().mesh().volume()).sqrt();
        if size.is_nan() { f64::INFINITY } else { size }
    }
}

/// The largest norm; NaN counts as infinite.
fn greatest<const D: usize>(vectors: impl Iterator<Item = SVector<f64, D>>) -> f64 {
    vectors
        .map(|v| v.norm())
        .fold(0.0, |m: f64, v| if v.is_nan() { f64::INFINITY } else { m.max(v) })
}
