//! Elastic waves of the structures: the step that explicit coupling bears, and periods.

use super::ImmersedFlow;
use crate::base::{Result, Warning};
use crate::elastic::{explicit_step_limit, wave_period};
use crate::flow::Fluid;
use crate::output::rounded;
use crate::scene::problem::{ElasticWave, FIRST_STRETCH};
use crate::structure::Structure;
use std::f64::consts::PI;

impl<const D: usize> ImmersedFlow<D> {
    /// The limit (1.54) for the current tension, with the shortest edge in the bands; `None`
    /// without tension.
    pub fn step_limit(&self) -> Option<f64> {
        let ([edge, _], sim) = (self.band_edges?, &self.simulation);
        let limits = sim.structures().iter().map(|s| s.step_limit(&sim.medium(&**s, edge)));
        limits.filter(|limit| limit.is_finite()).reduce(f64::min)
    }

    /// The limit (1.54) of the membranes whose tension will be larger than it is, when they are
    /// stretched by [`FIRST_STRETCH`]; `None` if there are none.
    pub(super) fn limit_when_stretched(&self) -> Option<f64> {
        let ([edge, _], eps, sim) = (self.band_edges?, self.thickness?, &self.simulation);
        let limits =
            self.scene.structures().iter().zip(sim.structures()).filter_map(|(kind, s)| {
                let (traits, medium) = (kind.traits(), sim.medium(&**s, edge));
                let tension = FIRST_STRETCH * traits.modulus;
                // The limit of a membrane with shear counts its stiffness at rest already.
                let sheared = traits.resists_shear || traits.carries_strain;
                let slack = traits.stretches && !sheared && s.tension() < tension;
                let thickness = if traits.on_interface { edge } else { eps };
                slack.then(|| explicit_step_limit(&medium, thickness, tension))
            });
        limits.reduce(f64::min)
    }

    /// Radius of the circle (in space: sphere) that holds as much as each structure; NaN for one
    /// that does not act.
    pub(super) fn equal_radii(&self) -> Result<Vec<f64>> {
        let sim = &self.simulation;
        let radius = |k: usize| {
            let interface = sim.carried().interface(&sim.state().fields, k)?;
            Ok(interface.measures().map_or(f64::NAN, |m| equal_radius(D, m.enclosed)))
        };
        let structures = sim.structures().iter().enumerate();
        structures.map(|(k, s)| if s.acts() { radius(k) } else { Ok(f64::NAN) }).collect()
    }

    /// The slowest elastic wave of each structure that has one, in the present tension; none for
    /// steps that follow the error, which resolve them.
    pub(super) fn elastic_waves(&self) -> Vec<ElasticWave> {
        let sim = &self.simulation;
        if self.scene.time.tolerance.is_some() {
            return Vec::new();
        }
        let wave = |(s, &radius): (&dyn Structure<D>, &f64)| {
            let [inside, outside] = sim.sides(s);
            let mean = |property: fn(Fluid) -> f64| 0.5 * (property(inside) + property(outside));
            let (density, viscosity) = (mean(|f| f.density), mean(|f| f.viscosity));
            let period = wave_period(density, viscosity, radius, s.tension());
            period.is_finite().then(|| ElasticWave { name: s.name().to_string(), period })
        };
        let structures = sim.structures().iter().map(|s| &**s);
        structures.zip(&self.radii).filter_map(wave).collect()
    }

    /// Warns of steps that are too long to follow the elastic waves.
    pub(super) fn warn_of_waves(&mut self) {
        let (dt, explicit) = (self.scene.time.step, self.scene.numerics.coupling.is_explicit());
        let bound = self.explicit_limit.filter(|_| explicit).unwrap_or(f64::INFINITY);
        let stable = match explicit {
            true => "",
            false => "the steps are stable, but they damp the wave instead of following it: ",
        };
        let lost = self.elastic_waves().into_iter().filter(|w| w.is_lost(dt));
        self.warnings.extend(lost.map(|wave| {
            let step = rounded(bound.min(wave.period / ElasticWave::STEPS), 2);
            let remedy = format!("{stable}give time.step <= {step}");
            Warning::new(wave.in_words(dt), remedy)
        }));
    }
}

/// Radius of the circle, in space of the sphere, of this measure.
fn equal_radius(dimension: usize, measure: f64) -> f64 {
    match dimension {
        2 => (measure / PI).sqrt(),
        _ => (0.75 * measure / PI).cbrt(),
    }
}
