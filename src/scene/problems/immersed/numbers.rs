//! Numbers without units that characterise a flow, as far as its scene defines them.

use super::ImmersedFlow;
use crate::base::length;
use crate::output::rounded;
use crate::scene::problems::scales::Given;

impl<const D: usize> ImmersedFlow<D> {
    /// Lines of the plan: each number with its definition. `given` are the velocities of the scene.
    pub(super) fn numbers(&self) -> Vec<String> {
        let Given { speed, difference, side } = self.given;
        let (sim, fluid) = (&self.simulation, self.simulation.settings().fluid);
        let [h, finest] = [self.quality.greatest_diameter, self.quality.smallest_diameter];
        let dt = sim.settings().dt;
        let inertial = fluid.density > 0.0 && fluid.viscosity > 0.0;
        let (speed_in_words, side_in_words) = (length(speed), length(side));
        let mut lines = Vec::new();
        if speed > 0.0 && inertial {
            let reynolds = |size: f64| fluid.density * speed * size / fluid.viscosity;
            lines.push(format!(
                "Reynolds number rho U L/mu = {}, of a cell {}: U = {speed_in_words} is the \
                 largest velocity given, L = {side_in_words} the shorter side of the domain",
                rounded(reynolds(side), 3),
                rounded(reynolds(h.value), 3)
            ));
        }
        if speed > 0.0 {
            let courant = rounded(speed * dt / finest.value, 3);
            lines.push(format!(
                "Courant number U dt/h = {courant} with U = {speed_in_words} in the smallest cell"
            ));
        }
        let rate = difference / side;
        for (k, (kind, s)) in self.scene.structures().iter().zip(sim.structures()).enumerate() {
            let (radius, modulus) = (self.radii[k], kind.traits().modulus);
            if !radius.is_finite() || modulus <= 0.0 {
                continue;
            }
            let mut numbers = Vec::new();
            let per = if kind.traits().constant_tension { "tension" } else { "modulus" };
            if rate > 0.0 {
                let capillary = fluid.viscosity * rate * radius / modulus;
                numbers.push(format!("Ca = mu G R/{per} = {}", rounded(capillary, 3)));
            }
            if rate > 0.0 && inertial {
                let weber = fluid.density * rate.powi(2) * radius.powi(3) / modulus;
                numbers.push(format!("We = rho G^2 R^3/{per} = {}", rounded(weber, 3)));
            } else if inertial {
                let laplace = fluid.density * modulus * radius / fluid.viscosity.powi(2);
                numbers.push(format!("La = rho R {per}/mu^2 = {}", rounded(laplace, 3)));
            }
            let [inside, outside] = [s.held().and_then(|held| held.fluid), Some(fluid)]
                .map(|f| f.map_or(fluid.density, |f| f.density));
            let bond = (inside - outside).abs() * sim.settings().gravity.norm() * radius.powi(2);
            if bond > 0.0 {
                numbers.push(format!(
                    "Bo = |rho_in - rho_out| g R^2/{per} = {}",
                    rounded(bond / modulus, 3)
                ));
            }
            if !numbers.is_empty() {
                let of = match rate > 0.0 {
                    true => format!(
                        "R = {} and G = {}, the largest difference of given velocities over L",
                        length(radius),
                        rounded(rate, 3)
                    ),
                    false => format!("R = {}", length(radius)),
                };
                lines.push(format!("`{}`: {}, with {of}", kind.name(), numbers.join(", ")));
            }
        }
        lines
    }
}
