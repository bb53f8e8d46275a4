//! Settings of an immersed flow.

use crate::base::Error;
use crate::fem::{Conditions, Element};
use crate::flow::{BodyForce, ConvectionScheme, Fluid};
use crate::linalg::SolverOptions;
use crate::sim::carried::Transport;
use crate::structure::Structure;
use nalgebra::SVector;
use std::sync::Arc;

/// Settings of a flow with structures; those of the structures belong to the structures.
#[derive(Clone)]
pub struct SimulationSettings<const D: usize> {
    /// Time step.
    pub dt: f64,
    /// Order in time, 1 or 2; 3 without structures and characteristics.
    pub order: usize,
    /// Transport of fields.
    pub transport: Transport,
    /// How velocity carries itself; `None` for no convection.
    pub convection: Option<ConvectionScheme>,
    /// Weight of the grad-div term, in units of viscosity.
    pub grad_div: f64,
    /// Relative residual of iterations with an old factor, if the matrix changes from step to step;
    /// 0 factors every matrix.
    pub solve_tolerance: f64,
    /// Solver of the linear systems of the flow, and its memory.
    pub solver: SolverOptions,
    /// Degree of the quadrature rule.
    pub quadrature: usize,
    /// The fluid outside all structures; the fluids inside are those of [`held`](Structure::held).
    pub fluid: Fluid,
    /// True for the Boussinesq form (book, section 1.4.2): densities differ in gravity only; the
    /// inertia is that of [`fluid`](Self::fluid) everywhere.
    pub boussinesq: bool,
    /// Element of the pressure: P1, or in the plane P1 + P0.
    pub pressure: Element,
    /// Boundary conditions.
    pub conditions: Conditions<D>,
    /// Force per mass.
    pub gravity: SVector<f64, D>,
    /// Force per volume.
    pub body_force: Option<Arc<BodyForce<D>>>,
}

impl<const D: usize> SimulationSettings<D> {
    /// A flow of `fluid` under `conditions` in steps of length `dt`, of order 2, with convection
    /// where there is inertia, without grad-div and forces.
    pub fn new(dt: f64, fluid: Fluid, conditions: Conditions<D>) -> SimulationSettings<D> {
        SimulationSettings {
            dt,
            order: 2,
            transport: Transport::default(),
            convection: (fluid.density > 0.0).then_some(ConvectionScheme::Characteristics),
            grad_div: 0.0,
            solve_tolerance: 1e-10,
            solver: SolverOptions::default(),
            quadrature: 5,
            fluid,
            boussinesq: false,
            pressure: Element::P1,
            conditions,
            gravity: SVector::zeros(),
            body_force: None,
        }
    }
    /// All fluids, that outside of the structures first.
    pub(super) fn fluids<'a>(
        &self,
        structures: &'a [Box<dyn Structure<D>>],
    ) -> impl Iterator<Item = Fluid> + use<'a, D> {
        let inside = structures.iter().filter_map(|s| s.held().and_then(|h| h.fluid));
        std::iter::once(self.fluid).chain(inside)
    }
    /// Least density of all fluids.
    pub(super) fn lightest(&self, structures: &[Box<dyn Structure<D>>]) -> f64 {
        self.fluids(structures).map(|f| f.density).fold(f64::INFINITY, f64::min)
    }
    /// True if the density of inertia is constant in space and time.
    pub(super) fn has_constant_inertia(&self, structures: &[Box<dyn Structure<D>>]) -> bool {
        structures.iter().all(|s| s.held().is_none_or(|h| h.surface_mass == 0.0))
            && (self.boussinesq || self.fluids(structures).all(|f| f.density == self.fluid.density))
    }
    /// True if the viscosity is constant in space and time.
    pub(super) fn has_constant_viscosity(&self, structures: &[Box<dyn Structure<D>>]) -> bool {
        self.fluids(structures).all(|f| f.viscosity == self.fluid.viscosity)
    }
    /// True if the density of inertia and the viscosity are constant in space and time.
    pub(super) fn has_constant_materials(&self, structures: &[Box<dyn Structure<D>>]) -> bool {
        self.has_constant_inertia(structures) && self.has_constant_viscosity(structures)
    }
    /// Checks the couplings of the structures.
    ///
    /// # Errors
    /// A coupling that is not possible with these settings.
    pub fn check_couplings(&self, structures: &[Box<dyn Structure<D>>]) -> crate::base::Result<()> {
        let traced = self.convection.is_some_and(|c| c != ConvectionScheme::Implicit);
        if self.order > 2 && (traced || !structures.is_empty()) {
            return Err(Error::scene(
                "order 3 is for flows without structures, with implicit convection or none",
            )
            .value(format!("{} structures, convection {:?}", structures.len(), self.convection))
            .remedy("take order 2"));
        }
        let lightest = self.lightest(structures);
        structures
            .iter()
            .filter(|s| s.acts())
            .try_for_each(|s| s.check_coupling(self.order, lightest))
    }
}
