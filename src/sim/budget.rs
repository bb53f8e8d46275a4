//! The energy identity (3.23) as a running residual.

/// Energies at one time, and the rates at which they change.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// `int rho |u|^2 / 2`.
    pub kinetic: f64,
    /// `int E(|grad phi|) zeta(phi/eps)/eps`, of all structures.
    pub elastic: f64,
    /// Viscous dissipation rate `int 2 mu |D(u)|^2`, and that of the slip of sharp membranes.
    pub dissipation: f64,
    /// Rate taken by the grad-div term.
    pub grad_div: f64,
    /// Power of walls, gravity and body forces.
    pub power: f64,
    /// L2 norm of `div u`.
    pub divergence: f64,
}

impl Energies {
    /// Kinetic and elastic energy.
    pub fn total(&self) -> f64 {
        self.kinetic + self.elastic
    }
}

/// What (3.23) compares: `E(t) + int dissipation - int power = E(0)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Budget {
    /// Kinetic and elastic energy at the start.
    pub initial: f64,
    /// What viscosity and grad-div have taken since.
    pub dissipated: f64,
    /// What walls and body forces have put in since.
    pub work: f64,
    /// What walls and body forces have exchanged since, without sign.
    pub exchanged: f64,
    /// What bringing the fields to new meshes has added since; not taken out of the residual.
    pub transferred: f64,
}

impl Budget {
    /// A budget that starts with `e`.
    pub fn new(e: &Energies) -> Budget {
        Budget { initial: e.total(), ..Budget::default() }
    }
    /// Adds a step of length `dt` from `old` to `new`. The rates are taken at the new time (`order` 1, as backward Euler does) or as the mean (order 2).
    pub fn advance(&mut self, old: &Energies, new: &Energies, dt: f64, order: usize) {
        let mean = |f: fn(&Energies) -> f64| if order == 1 { f(new) } else { 0.5 * (f(old) + f(new)) };
        self.dissipated += dt * mean(|e| e.dissipation + e.grad_div);
        self.work += dt * mean(|e| e.power);
        self.exchanged += dt * mean(|e| e.power.abs());
    }
    /// Energy that came from nowhere since the start, over the energy in play (the initial one and the work exchanged); negative
    /// when the scheme itself dissipates.
    pub fn residual(&self, now: &Energies) -> f64 {
        let scale = self.initial.abs() + self.exchanged;
        let created = now.total() + self.dissipated - self.work - self.initial;
        if scale > 0.0 { created / scale } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An oscillator that loses exactly what it dissipates has no residual, and one that is fed has one.
    #[test]
    fn the_residual_counts_what_came_from_nowhere() {
        let at = |t: f64| Energies { kinetic: (-t).exp(), dissipation: (-t).exp(), ..Energies::default() };
        let mut budget = Budget::new(&at(0.0));
        let dt = 1e-3;
        for k in 1..=1000 {
            budget.advance(&at((k - 1) as f64 * dt), &at(k as f64 * dt), dt, 2);
        }
        assert!(budget.residual(&at(1.0)).abs() < 1e-7);
        let fed = Energies { elastic: 0.1, ..at(1.0) };
        assert!((budget.residual(&fed) - 0.1).abs() < 1e-7);
    }

    /// Rates that change linearly in time are integrated exactly by their mean, and by the new ones to first order.
    #[test]
    fn rates_are_the_mean_or_the_new_ones() {
        let old = Energies { dissipation: 1.0, grad_div: 2.0, power: -4.0, ..Energies::default() };
        let new = Energies { dissipation: 3.0, grad_div: 6.0, power: 8.0, ..Energies::default() };
        let after = |order| {
            let mut budget = Budget::new(&old);
            budget.advance(&old, &new, 0.5, order);
            [budget.dissipated, budget.work, budget.exchanged]
        };
        assert_eq!(after(1), [4.5, 4.0, 4.0]);
        assert_eq!(after(2), [3.0, 1.0, 3.0]);
    }

    /// What was exchanged counts as energy in play; where nothing is in play nothing is created.
    #[test]
    fn the_residual_is_relative_to_the_energy_in_play() {
        let now = Energies { kinetic: 1.0, elastic: 4.0, ..Energies::default() };
        let budget = Budget { initial: 3.0, dissipated: 1.0, work: 2.0, exchanged: 5.0, transferred: 0.0 };
        assert_eq!(budget.residual(&now), 0.125);
        assert_eq!(Budget::default().residual(&now), 0.0);
    }
}
