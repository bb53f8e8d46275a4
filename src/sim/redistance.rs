//! Level sets that become distances again as the steps go on.

use super::step::Simulation;
use crate::base::{Phase, Result};
use crate::levelset::Redistancing;

impl<const D: usize> Simulation<D> {
    /// Redistances all level sets after every `every` steps of the count of the state, in a resumed run too. For interfaces whose slope
    /// means nothing; an elastic membrane would lose its stretch.
    pub fn redistance_every(&mut self, every: usize, how: Redistancing<D>) {
        self.redistancing = Some((every.max(1) as u64, how));
    }

    /// What is to be done to the level sets in step number `step`, the first being 1.
    pub(super) fn redistance(&mut self, step: u64) -> Result<()> {
        let Some((every, how)) = self.redistancing else { return Ok(()) };
        if !step.is_multiple_of(every) {
            return Ok(());
        }
        self.phases.end(Phase::Transport);
        let slopes = self.structures.iter().map(|s| s.stretch).chain(self.passive.iter().map(|_| 1.0));
        for (phi, slope) in self.state.phi.iter_mut().zip(slopes) {
            how.apply(&self.carrier.tracer, &self.translations, slope, phi)?;
        }
        self.phases.end(Phase::Redistance);
        Ok(())
    }
}
