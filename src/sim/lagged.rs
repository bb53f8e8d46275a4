//! A factor that outlives its matrix, through interruptions too.

use super::setup::{Configuration, Coupling, Factored, Structure};
use super::step::Simulation;
use crate::base::Result;
use crate::flow::term::MomentumTerm;
use crate::flow::{FlowSolver, FlowState, StepReport};

impl<const D: usize> Simulation<D> {
    /// Notes what the factor was made of, after a step in which the matrix was that of the structures `of` with the coefficient `weight`.
    pub(super) fn note_factor(
        &mut self,
        flow: &FlowSolver<D>,
        report: &StepReport,
        weight: f64,
        of: Configuration<'_, D>,
    ) {
        if self.settings.solve_tolerance == 0.0 || flow.is_constant() {
            return;
        }
        let dt = self.settings.dt;
        let ledger = flow.ledger();
        let empty = || Factored { phi: Vec::new(), stretch: Vec::new(), displacement: Vec::new(), weight, dt, ledger };
        let kept = self.state.factored.get_or_insert_with(empty);
        if report.refactored {
            for (to, from) in [&mut kept.phi, &mut kept.stretch].into_iter().zip([of.phi, of.stretch]) {
                to.resize_with(from.len(), Vec::new);
                to.iter_mut().zip(from).for_each(|(to, from)| to.clone_from(from));
            }
            kept.displacement.clear();
            kept.displacement.extend_from_slice(of.displacement);
            (kept.weight, kept.dt) = (weight, dt);
        }
        kept.ledger = ledger;
    }

    /// Where iterations start: the velocity `u^n + ratio (u^n - u^{n-1})` and the pressure `p^n`. (That of the pressure extrapolated
    /// too saved no iteration.)
    pub(super) fn extrapolate(&self, solver: &FlowSolver<D>, ratio: f64, guess: &mut FlowState<D>) {
        guess.clone_from(&self.state.flow);
        if self.state.factored.is_some() || solver.always_iterates() {
            guess.u.iter_mut().zip(&self.state.earlier_u).for_each(|(u, earlier)| *u += (*u - earlier) * ratio);
        }
    }

    /// Makes the factor again that the state was computed with.
    pub(super) fn restore_factor(&mut self, flow: &mut FlowSolver<D>) -> Result<()> {
        let Some(kept) = self.state.factored.take() else { return Ok(()) };
        self.set_materials(flow, &kept.phi);
        let implicit = (self.settings.coupling == Coupling::Implicit).then_some(kept.dt);
        let of = Configuration { phi: &kept.phi, stretch: &kept.stretch, displacement: &kept.displacement };
        self.prepare_structures(flow, of, implicit)?;
        let terms: Vec<&dyn MomentumTerm<D>> = self.structures.iter().map(Structure::term).collect();
        let made = flow.restore_factor(kept.weight / kept.dt, &terms, kept.ledger);
        self.state.factored = Some(kept);
        made
    }
}
