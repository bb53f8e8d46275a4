//! The energy balance (3.23) and its residual.

/// Energies at one time, and their rates of change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// `int rho |u|^2 / 2`.
    pub kinetic: f64,
    /// Elastic energy of all structures: for a membrane `int E(r)/r ds`, over a band
    /// `int E(|grad phi|) zeta(phi/eps)/eps`.
    pub elastic: f64,
    /// Viscous dissipation rate `int 2 mu |D(u)|^2`, and that of the slip of sharp membranes.
    pub dissipation: f64,
    /// Dissipation rate of the grad-div term.
    pub grad_div: f64,
    /// Power of walls, gravity and body forces.
    pub power: f64,
    /// L2 norm of `div u`.
    pub divergence: f64,
    /// Power of the flow on elastic structures, less the dissipation of their slip; 0 where their
    /// forces are no derivatives of their energies.
    pub elastic_power: f64,
    /// The power at each of their points counted positive.
    pub elastic_traffic: f64,
}

impl Energies {
    /// Kinetic and elastic energy.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic
    }
}

/// Elastic energies over all energy in play below which they do not count.
const NEGLIGIBLE: f64 = 1e-6;

/// Terms of the energy balance (3.23): `E(t) + int dissipation - int power = E(0)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Kinetic and elastic energy at time 0.
    pub initial: f64,
    /// Energy dissipated by viscosity and grad-div.
    pub dissipated: f64,
    /// Work of walls and body forces on the flow.
    pub work: f64,
    /// Total absolute work of walls and body forces.
    pub exchanged: f64,
    /// Energy added by transfers to new meshes; not subtracted from the residual.
    pub transferred: f64,
    /// Energy below which differences are errors of rounding or of the mesh.
    pub least: f64,
    /// Energy that the start has taken, at most 0: where the velocity changes at once, half the work
    /// of the impulse is in no energy, whatever the step. Not counted in the residual.
    pub start: f64,
    /// Number of steps to come that still know the velocity before the start.
    pub settling: u64,
    /// Elastic energy at time 0.
    pub elastic_initial: f64,
    /// Work of the flow on elastic structures.
    pub elastic_work: f64,
    /// Elastic energy that flow and structures have exchanged at each point, counted positive.
    pub elastic_traffic: f64,
}

impl EnergyBalance {
    /// A balance that starts with `e`.
    pub fn new(e: &Energies) -> EnergyBalance {
        let (initial, elastic_initial) = (e.total(), e.elastic);
        EnergyBalance { initial, elastic_initial, ..EnergyBalance::default() }
    }
    /// Adds a step of length `dt` from `old` to `new`. Rates are taken at the new time (`order` 1,
    /// as in backward Euler) or as the mean (order 2).
    pub fn advance(&mut self, old: &Energies, new: &Energies, dt: f64, order: usize) {
        let mean =
            |f: fn(&Energies) -> f64| if order == 1 { f(new) } else { 0.5 * (f(old) + f(new)) };
        self.dissipated += dt * mean(|e| e.dissipation + e.grad_div);
        self.work += dt * mean(|e| e.power);
        self.exchanged += dt * mean(|e| e.power.abs());
        self.elastic_work += dt * mean(|e| e.elastic_power);
        self.elastic_traffic += dt * mean(|e| e.elastic_traffic);
    }
    /// Takes what is missing after one of the first steps for what the start has taken, which is then
    /// no energy in play either.
    pub fn settle(&mut self, now: &Energies) {
        if self.settling == 0 {
            return;
        }
        self.settling -= 1;
        self.start = 0.0;
        self.start = self.spurious(now).min(0.0);
        if self.start < 0.0 {
            self.exchanged = (self.work + self.start).abs();
        }
    }
    /// Spurious energy since the start; negative if the scheme is dissipative.
    pub fn spurious(&self, now: &Energies) -> f64 {
        now.total() + self.dissipated - self.work - self.initial - self.start
    }
    /// An energy over that in play: the initial energy and the absolute work, and at least that of
    /// rounding errors.
    pub fn share(&self, energy: f64) -> f64 {
        let in_play = (self.initial.abs() + self.exchanged).max(self.least);
        if in_play > 0.0 { energy / in_play } else { 0.0 }
    }
    /// Spurious energy over the energy in play.
    pub fn residual(&self, now: &Energies) -> f64 {
        self.share(self.spurious(now))
    }
    /// Elastic energy that the flow has not put in, negative if it has vanished; and that in play:
    /// what was there at time 0 and all that flow and structures have exchanged since. In a flow
    /// that walls or forces drive, a structure may lose what it stores while
    /// [`residual`](Self::residual) stays small.
    pub fn elastic(&self, now: &Energies) -> [f64; 2] {
        let all = self.initial.abs() + self.exchanged;
        let least = self.least.max(NEGLIGIBLE * all);
        let in_play = (self.elastic_initial.abs() + self.elastic_traffic).max(least);
        match self.elastic_traffic > 0.0 {
            true => [now.elastic - self.elastic_initial - self.elastic_work, in_play],
            false => [0.0, in_play],
        }
    }
    /// Spurious elastic energy over that in play.
    pub fn elastic_residual(&self, now: &Energies) -> f64 {
        let [spurious, in_play] = self.elastic(now);
        if in_play > 0.0 { spurious / in_play } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The residual of an oscillator is zero if it loses exactly what it dissipates, and positive
    /// if energy is added.
    #[test]
    fn the_residual_measures_spurious_energy() {
        let at = |t: f64| Energies {
            kinetic: (-t).exp(),
            dissipation: (-t).exp(),
            ..Energies::default()
        };
        let mut balance = EnergyBalance::new(&at(0.0));
        let dt = 1e-3;
        for k in 1..=1000 {
            balance.advance(&at((k - 1) as f64 * dt), &at(k as f64 * dt), dt, 2);
        }
        assert!(balance.residual(&at(1.0)).abs() < 1e-7);
        let fed = Energies { elastic: 0.1, ..at(1.0) };
        assert!((balance.residual(&fed) - 0.1).abs() < 1e-7);
    }

    /// Rates that change linearly in time are integrated exactly by their mean, and by the new ones
    /// to first order.
    #[test]
    fn rates_are_the_mean_or_the_new_ones() {
        let old = Energies { dissipation: 1.0, grad_div: 2.0, power: -4.0, ..Energies::default() };
        let new = Energies { dissipation: 3.0, grad_div: 6.0, power: 8.0, ..Energies::default() };
        let after = |order| {
            let mut budget = EnergyBalance::new(&old);
            budget.advance(&old, &new, 0.5, order);
            [budget.dissipated, budget.work, budget.exchanged]
        };
        assert_eq!(after(1), [4.5, 4.0, 4.0]);
        assert_eq!(after(2), [3.0, 1.0, 3.0]);
    }

    /// Half the work of the impulse of a sudden start is missing: it is kept apart, as long as the
    /// scheme knows the velocity before, and is no energy in play. What is spurious stays.
    #[test]
    fn the_start_is_kept_apart() {
        let rest = Energies::default();
        let moved = |kinetic| Energies { kinetic, ..Energies::default() };
        let mut balance = EnergyBalance { settling: 2, ..EnergyBalance::new(&rest) };
        // Work 2 for the energy 1, then 0.25 more of it, then a loss of 0.5.
        for (work, kinetic, start, spurious) in
            [(2.0, 1.0, -1.0, 0.0), (0.5, 1.25, -1.25, 0.0), (0.0, 0.75, -1.25, -0.5)]
        {
            balance.work += work;
            balance.exchanged += work;
            balance.settle(&moved(kinetic));
            assert_eq!(balance.start, start);
            assert_eq!(balance.spurious(&moved(kinetic)), spurious);
        }
        assert_eq!(balance.residual(&moved(0.75)), -0.5 / 1.25);
        let mut gained = EnergyBalance { settling: 1, ..EnergyBalance::new(&rest) };
        gained.settle(&moved(1.0));
        assert_eq!((gained.start, gained.spurious(&moved(1.0))), (0.0, 1.0));
    }

    /// Exchanged energy counts as energy in play; without energy in play the residual is zero.
    #[test]
    fn the_residual_is_relative_to_the_energy_in_play() {
        let now = Energies { kinetic: 1.0, elastic: 4.0, ..Energies::default() };
        let budget = EnergyBalance {
            initial: 3.0,
            dissipated: 1.0,
            work: 2.0,
            exchanged: 5.0,
            least: 4.0,
            ..EnergyBalance::default()
        };
        assert_eq!(budget.residual(&now), 0.125);
        assert_eq!(EnergyBalance { least: 16.0, ..budget }.residual(&now), 0.0625);
        assert_eq!(EnergyBalance::default().residual(&now), 0.0);
    }
}
