//! Numbers without units that characterise a flow, as far as its scene defines them.

use super::ImmersedFlow;
use crate::base::{Warning, length};
use crate::mesh::Quality;
use crate::output::rounded;
use crate::scene::Scene;
use crate::scene::problems::scales::Given;
use crate::sim::ConvectionScheme;

/// A line of the plan: numbers with their definitions; and their names and values.
pub(super) struct Numbers {
    pub line: String,
    pub values: Vec<(String, f64)>,
}

/// Reynolds number of a cell that is told.
const COARSE: f64 = 1000.0;

/// A warning of layers at walls and in shear that are far thinner than the cells.
pub(super) fn coarse<const D: usize>(
    scene: &Scene,
    quality: &Quality<D>,
    given: &Given,
) -> Option<Warning> {
    let (fluid, edge) = (scene.outside(), quality.greatest_diameter.value);
    let reynolds = fluid.density * given.difference * edge / fluid.viscosity;
    (reynolds > COARSE).then(|| {
        let what = format!(
            "the Reynolds number of a cell is {}: layers at walls and in shear are far thinner \
             than the mesh",
            rounded(reynolds, 3)
        );
        let remedy = "they are smoothed by the mesh: take a finer mesh there, or a larger \
            fluid.viscosity, if they count";
        Warning::new(what, remedy)
    })
}

/// A warning of steps whose error is not estimated: of order 1 along characteristics.
pub(super) fn unestimated(scene: &Scene, scheme: Option<ConvectionScheme>) -> Option<Warning> {
    let alone = scene.acting().next().is_none();
    let first = scene.time.order == 1 && scheme == Some(ConvectionScheme::Characteristics);
    (alone && first).then(|| {
        let what = "steps of order 1 along characteristics have no estimate of their error, which may be \
                    many per cent of a force";
        Warning::new(what, "take time.order = 2, or numerics.convection = \"baker1982\"")
    })
}

impl<const D: usize> ImmersedFlow<D> {
    /// The numbers that are defined: of the flow, then of each structure.
    pub(super) fn find_numbers(&self) -> Vec<Numbers> {
        let Given { speed, difference, side } = self.given;
        let (sim, fluid) = (&self.simulation, self.simulation.settings().fluid);
        let [h, finest] = [self.quality.greatest_diameter, self.quality.smallest_diameter];
        let dt = sim.settings().dt;
        let inertial = fluid.density > 0.0 && fluid.viscosity > 0.0;
        let (speed_in_words, side_in_words) = (length(speed), length(side));
        let mut lines = Vec::new();
        if speed > 0.0 && inertial {
            let [of_domain, of_cell] =
                [side, h.value].map(|size| fluid.density * speed * size / fluid.viscosity);
            let values = vec![("reynolds".into(), of_domain), ("cell_reynolds".into(), of_cell)];
            let line = format!(
                "Reynolds number rho U L/mu = {}, of a cell {}: U = {speed_in_words} is the \
                 largest velocity given, L = {side_in_words} the shorter side of the domain",
                rounded(of_domain, 3),
                rounded(of_cell, 3)
            );
            lines.push(Numbers { line, values });
        }
        if speed > 0.0 {
            let courant = speed * dt / finest.value;
            let line = format!(
                "Courant number U dt/h = {} with U = {speed_in_words} in the smallest cell",
                rounded(courant, 3)
            );
            lines.push(Numbers { line, values: vec![("courant".into(), courant)] });
        }
        let rate = difference / side;
        for (k, (kind, s)) in self.scene.structures().iter().zip(sim.structures()).enumerate() {
            let (radius, modulus) = (self.radii[k], kind.traits().modulus);
            if !radius.is_finite() || modulus <= 0.0 {
                continue;
            }
            let (mut numbers, mut values) = (Vec::new(), Vec::new());
            let mut add = |name: &str, definition: &str, per: &str, value: f64| {
                values.push((format!("{}.{name}", kind.name()), value));
                numbers.push(format!("{definition}{per} = {}", rounded(value, 3)));
            };
            let per = if kind.traits().constant_tension { "tension" } else { "modulus" };
            if rate > 0.0 {
                let capillary = fluid.viscosity * rate * radius / modulus;
                add("capillary", "Ca = mu G R/", per, capillary);
            }
            if rate > 0.0 && inertial {
                let weber = fluid.density * rate.powi(2) * radius.powi(3) / modulus;
                add("weber", "We = rho G^2 R^3/", per, weber);
            } else if inertial {
                let laplace = fluid.density * modulus * radius / fluid.viscosity.powi(2);
                add("laplace", "La = rho R/mu^2 times the ", per, laplace);
            }
            let [inside, outside] = [s.held().and_then(|held| held.fluid), Some(fluid)]
                .map(|f| f.map_or(fluid.density, |f| f.density));
            let bond = (inside - outside).abs() * sim.settings().gravity.norm() * radius.powi(2);
            if bond > 0.0 {
                add("bond", "Bo = |rho_in - rho_out| g R^2/", per, bond / modulus);
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
                let line = format!("`{}`: {}, with {of}", kind.name(), numbers.join(", "));
                lines.push(Numbers { line, values });
            }
        }
        lines
    }
}
