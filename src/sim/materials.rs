//! Density and viscosity of the fluids, by (3.19).

use super::setup::{Fluid, Structure};
use super::step::Simulation;
use crate::fem::At;
use crate::flow::{Coefficient, FlowSolver};
use crate::levelset as band;

impl<const D: usize> Simulation<D> {
    pub(super) fn has_constant_materials(&self) -> bool {
        self.settings.has_constant_materials(&self.structures)
    }
    /// Viscosity of the thinnest fluid.
    pub fn least_viscosity(&self) -> f64 {
        self.settings.fluids(&self.structures).map(|f| f.viscosity).fold(f64::INFINITY, f64::min)
    }

    /// Density and viscosity by (3.19), and surface masses; in the Boussinesq form the density that gravity acts on instead.
    pub(super) fn set_materials(&self, flow: &mut FlowSolver<D>, level_sets: &[Vec<f64>]) {
        let basis = flow.velocity();
        let points = basis.rule().len();
        let count = self.space.mesh().cell_count();
        let pointwise = |value: &(dyn Fn(&At<D>) -> f64 + Sync)| {
            let mut values = vec![0.0; count * points];
            crate::base::parallel::fill(&mut values, points, |first, part| {
                for (i, values) in part.chunks_exact_mut(points).enumerate() {
                    for (q, v) in values.iter_mut().enumerate() {
                        *v = value(&basis.at(first + i, q));
                    }
                }
            });
            Coefficient::Pointwise { points, values }
        };
        let at_point = |at: &At<D>, k: usize| basis.value(at, &level_sets[k]);
        let Fluid { density, viscosity } = self.settings.fluid;
        let buoyant = self.settings.boussinesq && self.settings.fluids(&self.structures).any(|f| f.density != density);
        let buoyancy = buoyant.then(|| pointwise(&|at| self.density_of(|k| at_point(at, k)) - density));
        let rho = if self.settings.has_constant_inertia(&self.structures) {
            Coefficient::Constant(density)
        } else {
            pointwise(&|at| self.density_of(|k| at_point(at, k)))
        };
        let mu = if self.settings.has_constant_viscosity(&self.structures) {
            Coefficient::Constant(viscosity)
        } else {
            pointwise(&|at| self.viscosity_of(|k| at_point(at, k)))
        };
        flow.set_materials(rho, mu);
        flow.set_buoyancy(buoyancy);
    }

    /// Density by (3.19) where level set `k` has the value `phi(k)`: each structure puts its fluid in place of what was there.
    fn density_of(&self, phi: impl Fn(usize) -> f64) -> f64 {
        let mut rho = self.settings.fluid.density;
        let eps = |s: &Structure<D>| s.membrane.thickness();
        for (k, s, inside) in self.filled() {
            if inside.density != rho {
                rho = band::density(phi(k), eps(s), inside.density, rho, 0.0);
            }
        }
        let heavy = self.structures.iter().enumerate().filter(|(_, s)| s.surface_mass > 0.0);
        heavy.fold(rho, |rho, (k, s)| rho + band::density(phi(k), eps(s), 0.0, 0.0, s.surface_mass))
    }
    /// Viscosity by (3.19) where level set `k` has the value `phi(k)`, as the density.
    fn viscosity_of(&self, phi: impl Fn(usize) -> f64) -> f64 {
        let mut mu = self.settings.fluid.viscosity;
        for (k, s, inside) in self.filled() {
            if inside.viscosity != mu {
                mu = band::viscosity(phi(k), s.membrane.thickness(), inside.viscosity, mu);
            }
        }
        mu
    }
    /// The structures that hold a fluid of their own.
    fn filled(&self) -> impl Iterator<Item = (usize, &Structure<D>, Fluid)> {
        self.structures.iter().enumerate().filter_map(|(k, s)| Some((k, s, s.inside?)))
    }
    /// Density of what moves, in a cell at barycentric coordinates, for the current level sets; in the Boussinesq form that of the fluid outside.
    pub fn density_at(&self, cell: usize, l: &[f64; 4]) -> f64 {
        if self.settings.boussinesq {
            return self.settings.fluid.density;
        }
        self.density_of(|k| self.space.value(&self.state.phi[k], cell, l))
    }
    /// Viscosity in a cell at barycentric coordinates, for the current level sets.
    pub fn viscosity_at(&self, cell: usize, l: &[f64; 4]) -> f64 {
        self.viscosity_of(|k| self.space.value(&self.state.phi[k], cell, l))
    }
}
