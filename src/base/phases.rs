//! Processor time of a step by phase.

use cpu_time::ProcessTime;
use std::time::Duration;

/// A phase of a time step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Matrices and right-hand sides of the flow, without forces of structures.
    Assembly,
    /// Orderings and factors.
    Factor,
    /// Solve for velocity and pressure: substitution, residual, and transfer of values.
    Solve,
    /// Feet of the characteristics of the velocity.
    Feet,
    /// Bands of the structures, and their forces.
    Force,
    /// Transport of the level sets, with the feet that it needs.
    Transport,
    /// Redistancing of the level sets.
    Redistance,
    /// Energies, powers and reactions.
    Diagnostics,
}

/// All phases with their names, in the order of a step.
pub const PHASES: [(Phase, &str); 8] = [
    (Phase::Assembly, "assembly"),
    (Phase::Factor, "factor"),
    (Phase::Solve, "solve"),
    (Phase::Feet, "feet"),
    (Phase::Force, "force"),
    (Phase::Transport, "transport"),
    (Phase::Redistance, "redistance"),
    (Phase::Diagnostics, "diagnostics"),
];

/// Processor time of this process by phase, in seconds. A measurement costs a microsecond: use it
/// per phase, not per cell.
#[derive(Clone, Debug, Default)]
pub struct Phases {
    seconds: [f64; PHASES.len()],
    mark: Duration,
}

impl Phases {
    /// Starts a measurement: time before it is not counted.
    pub fn begin(&mut self) {
        self.mark = ProcessTime::now().as_duration();
    }
    /// Adds the time since the last measurement to a phase, and starts the next one.
    pub fn end(&mut self, phase: Phase) {
        let now = ProcessTime::now().as_duration();
        self.seconds[phase as usize] += now.saturating_sub(self.mark).as_secs_f64();
        self.mark = now;
    }
    /// Moves seconds that were counted for one phase to another.
    pub fn transfer(&mut self, seconds: f64, from: Phase, to: Phase) {
        self.seconds[from as usize] -= seconds;
        self.seconds[to as usize] += seconds;
    }
    /// Returns the seconds by phase and resets them to zero.
    pub fn take(&mut self) -> [f64; PHASES.len()] {
        std::mem::take(&mut self.seconds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_phase_has_its_place_and_the_sum_is_what_was_spent() {
        assert!(PHASES.iter().enumerate().all(|(k, (phase, _))| *phase as usize == k));
        let mut phases = Phases::default();
        let start = ProcessTime::now();
        phases.begin();
        let spend = || assert!((0..100_000).map(|i| f64::from(i).sqrt()).sum::<f64>() > 0.0);
        spend();
        phases.end(Phase::Solve);
        spend();
        phases.end(Phase::Feet);
        let all = start.elapsed().as_secs_f64();
        let seconds = phases.take();
        assert!(seconds[2] > 0.0 && seconds[3] > 0.0 && seconds[0] == 0.0);
        // Other tests run in the same process: no more than all of it.
        assert!(seconds.iter().sum::<f64>() <= all);
        assert_eq!(phases.take(), [0.0; PHASES.len()]);
    }
}
