//! The factor that preconditions later matrices, also after an interruption.

use super::Simulation;
use crate::base::Result;
use crate::flow::term::MomentumTerm;
use crate::flow::{Convection, FlowSolver, FlowState, StepReport};
use crate::sim::{Factored, State};
use crate::structure::{Fields, Place};
use nalgebra::SVector;

/// Initial guess of iterations: the velocity `u^n + ratio (u^n - u^{n-1})` and the pressure `p^n`.
/// (Extrapolating the pressure too saved no iteration.)
pub(super) fn extrapolate<const D: usize>(
    state: &State<D>,
    solver: &FlowSolver<D>,
    ratio: f64,
    guess: &mut FlowState<D>,
) {
    guess.clone_from(&state.flow);
    if state.factored.is_some() || solver.always_iterates() {
        let earlier = guess.u.iter_mut().zip(&state.earlier_u);
        earlier.for_each(|(u, earlier)| *u += (*u - earlier) * ratio);
    }
}

impl<const D: usize> Simulation<D> {
    /// Keeps the ingredients of the factor after a step in which the matrix was that of the
    /// structures at `fields` with the coefficient `weight` and convection by `wind`.
    pub(super) fn note_factor(
        &mut self,
        report: &StepReport,
        weight: f64,
        (fields, wind): (&Fields<D>, &[SVector<f64, D>]),
    ) {
        let has_blocks = !self.flow.block_values().is_empty();
        if self.settings.solve_tolerance == 0.0 || self.flow.is_constant() || has_blocks {
            return;
        }
        let (dt, solve_cost) = (self.settings.dt, self.flow.solve_cost());
        let empty = || {
            let (fields, backflow, wind) = (Fields::default(), Vec::new(), Vec::new());
            Factored { fields, backflow, wind, weight, dt, solve_cost }
        };
        let kept = self.state.factored.get_or_insert_with(empty);
        if report.refactored {
            kept.fields.clone_from(fields);
            kept.backflow = self.backflow.rates().to_vec();
            kept.wind.clear();
            kept.wind.extend_from_slice(wind);
            (kept.weight, kept.dt) = (weight, dt);
        }
        kept.solve_cost = solve_cost;
    }

    /// Computes the factor of the state again.
    pub(super) fn restore_factor(&mut self) -> Result<()> {
        let Some(kept) = self.state.factored.take() else { return Ok(()) };
        self.set_materials(&kept.fields);
        let at = Place {
            step: Some(kept.dt),
            ..Place::new(&self.carried.space, &self.flow, &kept.fields, self.state.time)
        };
        self.carried.structures.iter_mut().try_for_each(|s| s.prepare(&at))?;
        let leaving = self.leaving_at(&kept.fields);
        let mut terms: Vec<&dyn MomentumTerm<D>> = Vec::new();
        let acting = self.carried.structures.iter().zip(leaving).filter(|(_, leaves)| !leaves);
        acting.for_each(|(s, _)| s.terms(&mut terms));
        self.backflow.set_rates(kept.backflow.clone());
        if self.backflow.is_active() {
            terms.push(&self.backflow);
        }
        let convection = match kept.wind.is_empty() {
            true => Convection::InHistory,
            false => Convection::Implicit(&kept.wind),
        };
        let weight = kept.weight / kept.dt;
        let made = self.flow.restore_factor(weight, &terms, convection, kept.solve_cost);
        self.state.factored = Some(kept);
        made
    }
}
