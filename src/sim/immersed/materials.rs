//! Density and viscosity of the fluids, by (3.19).

use super::Simulation;
use crate::fem::At;
use crate::flow::{Coefficient, Fluid};
use crate::levelset as band;
use crate::structure::{FieldId, Fields, Held, Medium, Structure};

impl<const D: usize> Simulation<D> {
    pub(super) fn has_constant_materials(&self) -> bool {
        self.settings.has_constant_materials(&self.carried.structures)
    }
    /// The fluids inside and outside of a structure, with the densities of their inertia.
    pub fn sides(&self, of: &dyn Structure<D>) -> [Fluid; 2] {
        let outside = self.settings.fluid;
        let inside = of.held().and_then(|h| h.fluid).unwrap_or(outside);
        let density = if self.settings.boussinesq { outside.density } else { inside.density };
        [Fluid { density, ..inside }, outside]
    }
    /// What the waves of a structure move in, on edges of length `edge`.
    ///
    /// Between two fluids the shortest waves move toward the lighter and thinner one, to the edge
    /// of the band: of the densities and of the viscosities these are the geometric means, which
    /// give a step below the measured limit by 1.2 to 2 for contrasts up to 1000 (user guide,
    /// "Coupling"). The mass of an interface only makes its waves slower, and is left out.
    pub fn medium(&self, of: &dyn Structure<D>, edge: f64) -> Medium {
        let [inside, outside] = self.sides(of);
        let mean = |property: fn(Fluid) -> f64| (property(inside) * property(outside)).sqrt();
        let (density, viscosity) = (mean(|f| f.density), mean(|f| f.viscosity));
        Medium { density, viscosity, edge, order: self.settings.order }
    }

    /// Density and viscosity for the current fields.
    pub(super) fn set_materials_now(&mut self) {
        let fields = std::mem::take(&mut self.state.fields);
        self.set_materials(&fields);
        self.state.fields = fields;
    }

    /// Density and viscosity by (3.19), and surface masses; in the Boussinesq form the density that
    /// gravity acts on instead.
    pub(super) fn set_materials(&mut self, fields: &Fields<D>) {
        let (settings, structures) = (&self.settings, &self.carried.structures);
        let basis = self.flow.velocity();
        let points = basis.rule().len();
        let count = self.carried.space.mesh().cell_count();
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
        let at_point = |at: &At<D>, id: FieldId| basis.value(at, fields.scalar(id));
        let Fluid { density, viscosity } = settings.fluid;
        let buoyant =
            settings.boussinesq && settings.fluids(structures).any(|f| f.density != density);
        let held = self.held();
        let rho_of = |at: &At<D>| density_of(settings.fluid, &held, |id| at_point(at, id));
        let buoyancy = buoyant.then(|| pointwise(&|at| rho_of(at) - density));
        let rho = match settings.has_constant_inertia(structures) {
            true => Coefficient::Constant(density),
            false => pointwise(&rho_of),
        };
        let mu = match settings.has_constant_viscosity(structures) {
            true => Coefficient::Constant(viscosity),
            false => pointwise(&|at| viscosity_of(settings.fluid, &held, |id| at_point(at, id))),
        };
        self.flow.set_materials(rho, mu);
        self.flow.set_buoyancy(buoyancy);
    }

    fn held(&self) -> Vec<Held> {
        self.carried.structures.iter().filter_map(|s| s.held()).collect()
    }
    /// Density of inertia by cell and barycentric coordinates, for the current fields; in the
    /// Boussinesq form that of the fluid outside.
    pub fn density(&self) -> impl Fn(usize, &[f64; 4]) -> f64 {
        let (fluid, held, same) = (self.settings.fluid, self.held(), self.settings.boussinesq);
        move |cell, l| match same {
            true => fluid.density,
            false => density_of(fluid, &held, |id| self.value_at(id, cell, l)),
        }
    }
    /// Viscosity by cell and barycentric coordinates, for the current fields.
    pub fn viscosity(&self) -> impl Fn(usize, &[f64; 4]) -> f64 {
        let (fluid, held) = (self.settings.fluid, self.held());
        move |cell, l| viscosity_of(fluid, &held, |id| self.value_at(id, cell, l))
    }
    /// Density and viscosity at the nodes, for the current fields; `None` where they are the same
    /// everywhere.
    pub fn nodal_materials(&self) -> [Option<Vec<f64>>; 2] {
        let (fluid, held, fields) = (self.settings.fluid, self.held(), &self.state.fields);
        let (inside, heavy) =
            (held.iter().filter_map(|h| h.fluid), held.iter().any(|h| h.surface_mass > 0.0));
        let differ = |of: fn(Fluid) -> f64| inside.clone().any(|f| of(f) != of(fluid));
        let nodal = |of: &dyn Fn(usize) -> f64| (0..self.carried.space.len()).map(of).collect();
        let at = |n: usize| move |id: FieldId| fields.scalar(id)[n];
        [
            (heavy || differ(|f| f.density)).then(|| nodal(&|n| density_of(fluid, &held, at(n)))),
            differ(|f| f.viscosity).then(|| nodal(&|n| viscosity_of(fluid, &held, at(n)))),
        ]
    }
    fn value_at(&self, id: FieldId, cell: usize, l: &[f64; 4]) -> f64 {
        self.carried.space.value(self.state.fields.scalar(id), cell, l)
    }
}

/// Density by (3.19) where level set `id` has the value `phi(id)`: each structure replaces the
/// density by that of its fluid.
fn density_of(outside: Fluid, held: &[Held], phi: impl Fn(FieldId) -> f64) -> f64 {
    let mut rho = outside.density;
    for h in held {
        match h.fluid {
            Some(inside) if inside.density != rho => {
                rho = band::density(phi(h.level_set), h.thickness, inside.density, rho, 0.0);
            }
            _ => {}
        }
    }
    let heavy = held.iter().filter(|h| h.surface_mass > 0.0);
    heavy.fold(rho, |rho, h| {
        rho + band::density(phi(h.level_set), h.thickness, 0.0, 0.0, h.surface_mass)
    })
}

/// Viscosity by (3.19) where level set `id` has the value `phi(id)`, as the density.
fn viscosity_of(outside: Fluid, held: &[Held], phi: impl Fn(FieldId) -> f64) -> f64 {
    let mut mu = outside.viscosity;
    for h in held {
        match h.fluid {
            Some(inside) if inside.viscosity != mu => {
                mu = band::viscosity(phi(h.level_set), h.thickness, inside.viscosity, mu);
            }
            _ => {}
        }
    }
    mu
}
