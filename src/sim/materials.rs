//! Density and viscosity of the fluids, by (3.19).

use super::setup::{Materials, Structure};
use super::step::Simulation;
use crate::fem::At;
use crate::flow::{Coefficient, FlowSolver};
use crate::levelset as band;

impl<const D: usize> Simulation<D> {
    pub(super) fn has_constant_materials(&self) -> bool {
        self.settings.has_constant_materials(&self.structures)
    }

    /// Density and viscosity by (3.19), with the level set of the first structure; surface masses of all.
    pub(super) fn set_materials(&self, flow: &mut FlowSolver<D>, level_sets: &[Vec<f64>]) {
        let Materials { density, viscosity } = self.settings.materials;
        if self.has_constant_materials() {
            let (density, viscosity) = (density.outside, viscosity.outside);
            return flow.set_materials(Coefficient::Constant(density), Coefficient::Constant(viscosity));
        }
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
        let rho = pointwise(&|at| self.density_of(|k| at_point(at, k)));
        let mu = if viscosity.is_uniform() {
            Coefficient::Constant(viscosity.outside)
        } else {
            pointwise(&|at| self.viscosity_of(|k| at_point(at, k)))
        };
        flow.set_materials(rho, mu);
    }

    /// Density by (3.19) where level set `k` has the value `phi(k)`.
    fn density_of(&self, phi: impl Fn(usize) -> f64) -> f64 {
        let rho = self.settings.materials.density;
        let eps = |s: &Structure<D>| s.membrane.thickness();
        let bulk = match self.structures.first() {
            Some(s) if !rho.is_uniform() => band::density(phi(0), eps(s), rho.inside, rho.outside, 0.0),
            _ => rho.outside,
        };
        let heavy = self.structures.iter().enumerate().filter(|(_, s)| s.surface_mass > 0.0);
        heavy.fold(bulk, |rho, (k, s)| rho + band::density(phi(k), eps(s), 0.0, 0.0, s.surface_mass))
    }
    /// Viscosity by (3.19) where level set `k` has the value `phi(k)`.
    fn viscosity_of(&self, phi: impl Fn(usize) -> f64) -> f64 {
        let mu = self.settings.materials.viscosity;
        match self.structures.first() {
            Some(s) if !mu.is_uniform() => band::viscosity(phi(0), s.membrane.thickness(), mu.inside, mu.outside),
            _ => mu.outside,
        }
    }
    /// Density in a cell at barycentric coordinates, for the current level sets.
    pub fn density_at(&self, cell: usize, l: &[f64; 4]) -> f64 {
        self.density_of(|k| self.space.value(&self.state.phi[k], cell, l))
    }
    /// Viscosity in a cell at barycentric coordinates, for the current level sets.
    pub fn viscosity_at(&self, cell: usize, l: &[f64; 4]) -> f64 {
        self.viscosity_of(|k| self.space.value(&self.state.phi[k], cell, l))
    }
}
