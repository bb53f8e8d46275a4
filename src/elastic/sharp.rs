//! The membrane with an area law whose force acts on the interface itself (sharp interface).

use super::area_law::AreaLaw;
use super::cut_surface::{Points, RestDensity};
use super::slip::slip;
use super::waves::explicit_step_limit;
use crate::base::{Cause, Error, Result};
use crate::fem::{At, Basis, Space, SurfacePoint, VectorForm};
use crate::flow::term::{MomentumTerm, Support};
use crate::structure::{
    Coupling, Declaration, Density, FieldId, Fields, Host, ImmersedInterface, InitialFunction,
    InterfaceForce, Medium, Moved, Place,
};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Support of the force of a membrane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Force {
    /// In a band: [`Membrane`](super::Membrane). First order in the half-width of the band.
    Smeared,
    /// On the interface: [`SharpMembrane`].
    Sharp,
}

/// An elastic membrane on the zero level `S` of `phi`.
///
/// The force is the limit of (3.16) for a band of zero width, `F(v) = - int_S E'(r) P : grad v ds`
/// with `P = I - n n`, and the energy that of (3.12), `int_S E(r)/r ds`. Two choices make the force
/// the derivative of the energy on the mesh, so that no spurious energy is produced for any
/// stiffness:
///
/// - `n` is the normal of the cut interface, whose length the force shortens, not that of a
///   gradient;
/// - the stretch is not `|grad phi|` but the inverse of a density that the interface carries, its
///   length (area) at rest per length: `Dm/Dt + m P : grad u = 0`
///   ([`Onto::density`](crate::levelset::Onto::density)).
///   For divergence-free velocities this is `|grad phi|` on the interface; on a mesh the force
///   amplifies the error of `|grad phi|` in short waves, and in a flow that shears the fluid beside
///   the interface the slope is soon no stretch at all.
///
/// The level set is moved in every step onto the points of the interface as the fluid carries them
/// ([`CarriedSurface::fit`](crate::levelset::CarriedSurface::fit)), and its slope has no meaning.
///
/// A tangential force makes a kink in the velocity, which P2 smooths over a cell of extent `l`: the
/// interface would move too slowly, by `l/(15 mu) grad_S E'(r)` in the mean over its positions in
/// the cell. This *slip* is added, a diffusion of `m` with `l/(15 mu) E''(r) r`, solved implicitly.
/// It dissipates `int_S l/(15 mu) |grad_S E'|^2 ds` per time.
///
/// Limits: an interface that reaches a wall with a prescribed velocity, because the stiffness is
/// omitted in the lift of boundary values.
///
/// Implicit in the velocity, `C(u, v) = dt int_S [E'' r (P : grad u)(P : grad v) + max(E', 0) (n
/// grad u P) . (n grad v P)] ds` is added to the matrix; for constant tension and in 3-D the last
/// product is `(grad u P) : (grad v P)`.
#[derive(Clone)]
pub struct SharpMembrane<const D: usize> {
    law: AreaLaw,
    rest: RestDensity<D>,
    /// Viscosity of the surrounding fluid.
    viscosity: f64,
    /// Diffusivity of the carried density along the interface.
    diffusivity: f64,
    /// The density at time 0; `None` for the inverse of the stretch everywhere.
    initial: Option<Arc<InitialFunction<D>>>,
    points: Points<D>,
    /// The same points without normals.
    places: Vec<At<D>>,
    /// Stretch at the points.
    stretch: Vec<f64>,
    /// Dissipation rate of the slip.
    dissipation: f64,
    implicit_step: Option<f64>,
}

/// Tension over modulus that is an error of rounding.
const ROUNDING: f64 = 1e-9;

impl<const D: usize> SharpMembrane<D> {
    /// A membrane in a fluid of this viscosity (between two fluids, their mean).
    pub fn new(law: AreaLaw, viscosity: f64) -> SharpMembrane<D> {
        SharpMembrane {
            law,
            rest: RestDensity::default(),
            viscosity,
            diffusivity: 0.0,
            initial: None,
            points: Points::default(),
            places: Vec::new(),
            stretch: Vec::new(),
            dissipation: 0.0,
            implicit_step: None,
        }
    }
    /// The same with a surfactant that has this concentration at time 0 and diffuses along the
    /// interface with this diffusivity (area per time); its law is [`AreaLaw::Surfactant`].
    pub fn with_surfactant(
        self,
        concentration: Arc<InitialFunction<D>>,
        diffusivity: f64,
    ) -> SharpMembrane<D> {
        SharpMembrane { initial: Some(concentration), diffusivity, ..self }
    }
    /// Precomputes the force on the interface of `phi`; `rest_density` is the length (area) at rest
    /// per length, the inverse of the stretch, at the nodes of cut cells. With `implicit_step`, a
    /// time step, the stiffness enters the matrix.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn prepare(
        &mut self,
        space: &Space<D>,
        phi: &[f64],
        rest_density: &[f64],
        implicit_step: Option<f64>,
    ) -> Result<()> {
        self.implicit_step = implicit_step;
        self.points = self.rest.cuts.of(space, phi)?;
        self.places = self.points.iter().map(|p| p.at).collect();
        let at_point = |p: &SurfacePoint<D>| {
            self.rest.stretch(space.value(rest_density, p.at.cell, &p.at.barycentric))
        };
        self.stretch = self.points.iter().map(at_point).collect();
        self.check_tension()?;
        // The diffusion of the density, by the slip and of its own, over the square of the force.
        let lost = |(p, &r): (&SurfacePoint<D>, &f64)| {
            let stiffness = self.law.stiffness(r) * r;
            // The tangential force `grad_S E'(r)`.
            let along = space.gradient(rest_density, p.at.cell, &p.at.barycentric);
            let pull = (p.tangential(&along) * (-stiffness * r)).norm_squared();
            let own = if pull > 0.0 { self.diffusivity / stiffness } else { 0.0 };
            p.at.weight * (slip(space, p, self.viscosity) + own) * pull
        };
        self.dissipation = self.points.iter().zip(&self.stretch).map(lost).sum();
        Ok(())
    }
    /// Prepares the force of an interface, which errors name; implicit over a step.
    fn prepare_at(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        implicit: Option<f64>,
    ) -> Result<()> {
        let (phi, density) = (at.fields.scalar(of.level_set()), at.fields.scalar(self.rest.field));
        self.prepare(at.space, phi, density, implicit).map_err(|e| {
            let place = format!("`{}`, {}", of.name, e.place());
            e.at(place)
        })
    }
    /// Rejects a surfactant so dense that nothing is left of the tension.
    fn check_tension(&self) -> Result<()> {
        let AreaLaw::Surfactant { tension, elasticity } = self.law else { return Ok(()) };
        let points = self.points.iter().zip(&self.stretch);
        let Some((p, r)) = points.min_by(|a, b| a.1.total_cmp(b.1)) else { return Ok(()) };
        let densest = 1.0 / r;
        if tension > elasticity * densest {
            return Ok(());
        }
        Err(Error::computation("a surfactant is so dense that no surface tension is left")
            .value(format!(
                "largest concentration {densest:.4}, none is left from {:.4}",
                tension / elasticity
            ))
            .remedy("give the surfactant a smaller elasticity, or a larger diffusivity")
            .at(format!("x = {:?}", p.at.x.as_slice())))
    }
    /// Elastic energy of the prepared interface.
    pub fn energy(&self) -> f64 {
        self.points
            .iter()
            .zip(&self.stretch)
            .map(|(p, &r)| p.at.weight * self.law.energy(r) / r)
            .sum()
    }
    /// Dissipation rate of the slip.
    pub fn dissipation(&self) -> f64 {
        self.dissipation
    }
    /// Largest tension `E'(r)` on the prepared interface; 0 without tension, up to rounding.
    pub fn largest_tension(&self) -> f64 {
        let largest = self.stretch.iter().map(|&r| self.law.tension(r)).fold(0.0, f64::max);
        if largest > ROUNDING * self.law.modulus() { largest } else { 0.0 }
    }
}

impl<const D: usize> MomentumTerm<D> for SharpMembrane<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Points(&self.places)
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        let tension = self.law.tension(self.stretch[at.q]);
        (SVector::zeros(), self.points[at.q].projection() * -tension)
    }
    fn is_implicit(&self) -> bool {
        self.implicit_step.is_some()
    }
    fn stiffness(
        &self,
        at: &At<D>,
        _: &SVector<f64, D>,
        grad_u: &SMatrix<f64, D, D>,
    ) -> VectorForm<D> {
        let Some(dt) = self.implicit_step else { return (SVector::zeros(), SMatrix::zeros()) };
        let r = self.stretch[at.q];
        let weights = [self.law.stiffness(r) * r, self.law.tension(r).max(0.0)];
        let form = self.law.implicit_form(&self.points[at.q].normal, grad_u, weights);
        (SVector::zeros(), form * dt)
    }
}

impl<const D: usize> InterfaceForce<D> for SharpMembrane<D> {
    fn begin(
        &mut self,
        of: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        self.rest.begin(of, host, self.initial.as_deref(), fields)
    }
    fn term(&self) -> Option<&dyn MomentumTerm<D>> {
        Some(self)
    }
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()> {
        self.prepare_at(of, at, at.step.filter(|_| of.coupling == Coupling::Implicit))
    }
    /// Moves the level set onto the points of the interface that were carried by the fluid, and
    /// carries the length at rest with its slip; constant tension does not depend on it.
    fn advance(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &mut Moved<'_, D>,
        fields: &mut Fields<D>,
    ) -> Result<()> {
        if matches!(self.law, AreaLaw::Tension { .. }) {
            return if by.ahead { Ok(()) } else { self.rest.cuts.follow(of, by, fields).map(drop) };
        }
        let space = Arc::clone(by.carrier.tracer.space());
        let (mut rest, dt) = (std::mem::take(&mut self.rest), by.dt);
        let advanced = rest.advance(of, (by, fields), 0.0, |p, r| {
            dt * (slip(&space, p, self.viscosity) * self.law.stiffness(r) * r + self.diffusivity)
        });
        self.rest = rest;
        advanced
    }
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        _: &Basis<D>,
    ) -> Result<f64> {
        self.prepare_at(of, at, None)?;
        Ok(SharpMembrane::energy(self))
    }
    fn dissipation(&self) -> f64 {
        self.dissipation
    }
    fn tension(&self) -> f64 {
        self.largest_tension()
    }
    fn tension_at(&self, stretch: f64) -> Option<f64> {
        Some(self.law.tension(stretch))
    }
    /// The force acts on the surrounding fluid within one edge on each side.
    fn step_limit(&self, medium: &Medium) -> f64 {
        explicit_step_limit(medium, medium.edge, self.largest_tension())
    }
    fn check_coupling(&self, coupling: Coupling) -> Result<()> {
        coupling.refuse_semi_implicit(
            "the semi-implicit scheme (3.62)-(3.64) predicts the interface by diffusion in its \
             band, and a sharp one has none",
            Cause::SharpForce,
        )
    }
    fn reach(&self, _: &ImmersedInterface<D>) -> f64 {
        0.0
    }
    fn keeps_distance(&self) -> bool {
        true
    }
    fn surface_density(&self) -> Option<(FieldId, Density)> {
        let of = match self.law {
            AreaLaw::Tension { .. } => return None,
            AreaLaw::Surfactant { .. } => Density::Concentration,
            _ => Density::Rest,
        };
        Some((self.rest.field, of))
    }
}
