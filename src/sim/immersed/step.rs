//! The time step.

use super::measure::Powers;
use super::scheme::{Scheme, combine};
use super::{Simulation, Work};
use crate::base::{Error, Kind, Phase, Result};
use crate::fem::Cells;
use crate::flow::block::Block;
use crate::flow::term::MomentumTerm;
use crate::flow::{Convection, ConvectionScheme, History, Step, StepReport};
use crate::structure::{Coupling, Place, Velocity};
use nalgebra::SVector;

impl<const D: usize> Simulation<D> {
    /// Takes one step: predicts the structures, solves the flow with their forces, and transports
    /// the structures with the new velocity.
    ///
    /// Order 1 is the book's scheme (section 3.6.1): forces of the fields at `t^n`, backward Euler
    /// along the characteristics of `u^n`, transport by `u^{n+1}`; an implicit force is linearised
    /// in `u^{n+1}`. Order 2 takes forces of the fields transported by `u^n`, linearised in
    /// `u^{n+1} - u^n`, BDF2 along the characteristics, and transport by `(u^n + u^{n+1})/2`. All
    /// three are of second order, and the scheme is stable for any step if the stiffness in the
    /// matrix is at least half the true one; with the extrapolated velocity in place of `u^n` it is
    /// not (user guide, "Coupling"). Order 3, for flows without structures whose convection is
    /// implicit, is BDF3 with the extrapolation of three velocities.
    ///
    /// # Errors
    /// A solve that fails, or a blow-up: a particle would cross the whole domain in one step.
    pub fn step(&mut self) -> Result<StepReport> {
        let Some(pacing) = self.pacing.take() else { return self.single_step() };
        let result = self.paced_step(&pacing);
        self.pacing = Some(pacing);
        result
    }

    /// A step of the given length.
    pub(super) fn single_step(&mut self) -> Result<StepReport> {
        let mut work = std::mem::take(&mut self.work);
        let result = self.flow_step(&mut work);
        self.work = work;
        result.map_err(|e| {
            let (time, place) = (self.state.time, e.place().to_string());
            match (e.kind(), place.as_str()) {
                (Kind::Computation, "") => e.at(format!("time {time:.6}")),
                (Kind::Computation, inner) if !inner.starts_with("time") => {
                    e.at(format!("time {time:.6}, {inner}"))
                }
                _ => e,
            }
        })
    }

    fn flow_step(&mut self, work: &mut Work<D>) -> Result<StepReport> {
        let scheme = self.scheme();
        work.current.clone_from(&self.state.flow.u);
        let leaving = self.leaving_at(&self.state.fields);
        self.phases.begin();
        // Predicted structures.
        self.predict(&scheme, work)?;
        self.phases.end(Phase::Transport);
        // Feet of the characteristics.
        self.trace(&scheme, work);
        self.phases.end(Phase::Feet);
        // Materials and forces.
        self.set_materials(&work.ahead);
        self.phases.end(Phase::Assembly);
        self.prepare(&scheme, work)?;
        self.phases.end(Phase::Force);
        // Velocity and pressure.
        let (report, powers) = self.solve(&scheme, work)?;
        self.carried.check_speed(&work.next.u, scheme.dt, scheme.time)?;
        self.note_factor(&report, scheme.weight(), (&work.ahead, &work.wind));
        self.phases.end(Phase::Diagnostics);
        // Transport of structures, and materials.
        self.follow(&scheme, work)?;
        std::mem::swap(&mut self.state.flow, &mut work.next);
        std::mem::swap(&mut self.state.earlier_u, &mut work.current);
        if self.settings.order == 3 {
            self.state.earliest_u.clone_from(&work.current);
        }
        self.state.steps += 1;
        let regular = self.state.steps as f64 * scheme.dt;
        self.state.time = if self.state.pace.is_some() { scheme.time } else { regular };
        if !self.has_constant_materials() {
            self.set_materials_now();
        }
        self.phases.end(Phase::Assembly);
        // Energies and their balance (3.23).
        let now = self.measure(powers)?;
        let brought = self.energy_at_outlets(&leaving)?;
        let balance = &mut self.state.balance;
        balance.advance(&self.state.energies, &now, scheme.dt, scheme.order());
        balance.work += brought;
        balance.elastic_work += brought;
        balance.settle(&now);
        self.state.energies = now;
        self.phases.end(Phase::Diagnostics);
        Ok(report)
    }

    /// Fields at which forces are taken: those at the start (order 1), or transported by the
    /// velocity there (order 2).
    fn predict(&mut self, scheme: &Scheme, work: &mut Work<D>) -> Result<()> {
        let Work { current, ahead, drifted, .. } = work;
        let velocity = Velocity::Computed { ends: [current, current], mean: current };
        let (fields, of) = (&self.state.fields, (scheme.dt, scheme.time));
        let acting = || self.carried.structures.iter().filter(|s| s.acts());
        let (acts, semi) =
            (acting().count() > 0, acting().any(|s| s.coupling() == Coupling::SemiImplicit));
        if scheme.second && acts {
            self.carried.predict(fields, velocity, of, ahead)?;
            self.outlets.let_in(&self.carried.structures, current, scheme.dt, ahead);
        } else {
            ahead.clone_from(fields);
        }
        if semi {
            self.carried.predict(fields, velocity, of, drifted)?;
        }
        Ok(())
    }

    /// Feet of the characteristics of earlier velocities.
    fn trace(&mut self, scheme: &Scheme, Work { current, mean, .. }: &mut Work<D>) {
        let (tracer, basis) = (&self.carried.carrier.tracer, self.flow.velocity());
        let (dt, ratio, earlier) = (scheme.dt, scheme.ratio, &self.state.earlier_u);
        if !scheme.traces() {
            return;
        }
        if !scheme.second {
            return tracer.from_quadrature(current, dt, basis, &mut self.feet[0]);
        }
        combine(1.0 + 0.5 * ratio, current, -0.5 * ratio, earlier, mean);
        tracer.from_quadrature(mean, dt, basis, &mut self.feet[0]);
        let (both, beyond) = (dt + dt / ratio, 0.5 * (ratio - 1.0));
        combine(1.0 + beyond, current, -beyond, earlier, mean);
        let middle: &[_] = if ratio == 1.0 { current } else { mean };
        tracer.from_quadrature(middle, both, basis, &mut self.feet[1]);
    }

    /// Precomputes the forces of the structures.
    fn prepare(&mut self, scheme: &Scheme, work: &Work<D>) -> Result<()> {
        let at = Place {
            drift: Some([&self.state.fields, &work.drifted]),
            step: Some(scheme.dt),
            ..Place::new(&self.carried.space, &self.flow, &work.ahead, scheme.time)
        };
        self.carried.structures.iter_mut().try_for_each(|s| s.prepare(&at))
    }

    /// The velocity extrapolated to the end of the step.
    fn look_ahead(
        &self,
        scheme: &Scheme,
        current: &[SVector<f64, D>],
        ahead: &mut Vec<SVector<f64, D>>,
    ) {
        let [now, earlier, earliest] = scheme.extrapolation();
        combine(now, current, earlier, &self.state.earlier_u, ahead);
        if scheme.third {
            let two_before = ahead.iter_mut().zip(&self.state.earliest_u);
            two_before.for_each(|(u, v)| *u += v * earliest);
        }
    }

    /// Takes the stress on open sides for the velocity that the step is expected to have there.
    fn meet_inflow(&mut self, scheme: &Scheme, Work { current, mean, .. }: &mut Work<D>) {
        self.look_ahead(scheme, current, mean);
        let mut backflow = std::mem::take(&mut self.backflow);
        let start = scheme.second.then_some(&current[..]);
        backflow.prepare(&self.carried.space, self.density(), mean, start);
        self.backflow = backflow;
    }

    /// Solves for velocity and pressure. Also returns the powers of the step.
    fn solve(&mut self, scheme: &Scheme, work: &mut Work<D>) -> Result<(StepReport, Powers)> {
        if scheme.convection.is_some() && self.has_backflow() {
            self.meet_inflow(scheme, work);
        }
        self.given_stress.prepare(&self.settings.conditions, scheme.time);
        if let Some(x) = self.given_stress.not_finite() {
            return Err(Error::computation("the stress on an open side is not a finite number")
                .at(format!("point {:?}", x.as_slice()))
                .remedy("check the pressures and tractions of the boundary"));
        }
        let Work { current, mean, wind, next, ahead, .. } = work;
        let feet = |k: usize| self.feet.get(k).filter(|_| scheme.traces());
        if scheme.convection == Some(ConvectionScheme::Implicit) {
            self.look_ahead(scheme, current, wind);
            self.flow.impose(scheme.time, wind);
        }
        let earlier = [&current[..], &self.state.earlier_u, &self.state.earliest_u];
        let weighed = |weights: [f64; 3]| std::array::from_fn(|k| (weights[k], earlier[k]));
        let extrapolated: [_; 3] = weighed(scheme.extrapolation());
        let history: [_; 3] = weighed(scheme.history());
        let history: Vec<_> = history
            .into_iter()
            .take(if scheme.inertia { scheme.order() } else { 0 })
            .enumerate()
            .map(|(k, (weight, u))| History { weight, u, feet: feet(k) })
            .collect();
        let convection = match scheme.convection {
            Some(ConvectionScheme::Implicit) => Convection::Implicit(wind),
            Some(ConvectionScheme::Explicit) => {
                Convection::Explicit(&extrapolated[..scheme.order()])
            }
            _ => Convection::InHistory,
        };
        let (mut terms, mut blocks): (Vec<&dyn MomentumTerm<D>>, Vec<&dyn Block<D>>) =
            <_>::default();
        let leaving = self.leaving_at(ahead);
        for (s, leaves) in self.carried.structures.iter().zip(&leaving) {
            if !*leaves {
                s.terms(&mut terms);
                s.blocks(&mut blocks);
            }
        }
        if self.backflow.is_active() {
            terms.push(&self.backflow);
        }
        if !self.given_stress.is_empty() {
            terms.push(&self.given_stress);
        }
        let step = Step {
            time: scheme.time,
            dt: scheme.dt,
            weight: scheme.weight(),
            history: &history,
            convection,
            terms: &terms,
            blocks: &blocks,
            predicted: scheme.second.then_some(&current[..]),
            body_force: self.settings.body_force.as_deref(),
            gravity: self.settings.gravity,
        };
        let flow = &mut self.flow;
        // The solver must be chosen first, also in a resumed run.
        flow.analyse(step.weight / scheme.dt)?;
        super::factor::extrapolate(&self.state, flow, scheme.ratio, next);
        let report = flow.step(&step, next)?;
        self.phases.begin();
        let walls = flow.wall_power(&step, next);
        self.reactions = self.keeps_reactions.then(|| flow.reaction(&step, next, Cells::All));
        let space = &self.carried.space;
        let sides = self.backflow.power(space, &next.u)
            + self.given_stress.power(space, &next.u)
            + self.gradient_form.power(space, &next.u);
        let mut powers = Powers { walls: walls + sides, ..Powers::default() };
        if self.carried.structures.iter().any(|s| s.acts()) {
            combine(1.0, &next.u, if scheme.second { -1.0 } else { 0.0 }, current, mean);
            [powers.structures, powers.traffic] = self.structure_power(&leaving, &next.u, mean);
        }
        Ok((report, powers))
    }

    /// Values of the unknowns of the blocks of all structures; none of those that leave, which had no
    /// part in the step.
    fn values_of_blocks(&self, leaving: &[bool]) -> Vec<Vec<f64>> {
        let (mut solved, mut all) = (self.flow.block_values().iter(), Vec::new());
        for (s, leaves) in self.carried.structures.iter().zip(leaving) {
            let mut blocks = Vec::new();
            s.blocks(&mut blocks);
            let values = |_| if *leaves { None } else { solved.next().cloned() };
            all.extend(blocks.iter().map(values).map(Option::unwrap_or_default));
        }
        all
    }

    /// Transports all fields over the step.
    fn follow(&mut self, scheme: &Scheme, work: &mut Work<D>) -> Result<()> {
        if self.state.fields.is_empty() {
            return Ok(());
        }
        let leaving = self.leaving_at(&work.ahead);
        let Work { current, mean, next, moved, .. } = work;
        let mut acting = self.carried.structures.iter().filter(|s| s.acts());
        if scheme.second {
            combine(0.5, current, 0.5, &next.u, mean);
        } else if acting.any(|s| s.coupling() == Coupling::FullyExplicit) {
            mean.clone_from(current);
        } else {
            mean.clone_from(&next.u);
        }
        let velocity = Velocity::Computed { ends: [current, &next.u], mean };
        let of = (scheme.dt, scheme.time, self.state.steps + 1);
        let values = self.values_of_blocks(&leaving);
        let with = (&values[..], &mut self.phases);
        self.carried.carry(&self.state.fields, velocity, of, with, moved)?;
        self.outlets.let_in(&self.carried.structures, mean, scheme.dt, moved);
        std::mem::swap(&mut self.state.fields, moved);
        Ok(())
    }
}
