//! The membrane with an area law: the stress (3.16) on a renormalised band, explicit or implicit in
//! the velocity.

use super::area_law::AreaLaw;
use super::band_cells::{Band, BandCells, BandPoint, BandWidth};
use super::cut_surface::RestDensity;
use super::predictor::Predictor;
use super::waves::explicit_step_limit;
use crate::base::Result;
use crate::fem::{At, Basis, Cells, VectorForm};
use crate::flow::term::{MomentumTerm, Support};
use crate::levelset::{Kernel, Norm};
use crate::structure::{
    Coupling, Declaration, Density, FieldId, Fields, Host, ImmersedInterface, InterfaceForce,
    Medium, Moved, Place,
};
use nalgebra::{SMatrix, SVector};

/// An elastic membrane on the zero level of `phi`, smeared over a band.
///
/// The force is (3.16) integrated weakly, `F(v) = - int E'(r) r P : grad v w`, with `P = I - n n`;
/// the energy is (3.12), `int E(r) w`. Gradients are taken at the quadrature points. Implicit in
/// the velocity, the form `C(u, v) = dt int [E'' r^2 (P : grad u)(P : grad v) + max(E', 0) r (n
/// grad u P) . (n grad v P)] w` is added to the matrix; for constant tension and in 3-D the last
/// product is `(grad u P) : (grad v P)`.
///
/// The stretch `r` is the slope `|grad phi|`, or [that which the interface
/// carries](Self::with_carried_stretch): a flow that shears the fluid beside the interface changes
/// the slope there and in the end everywhere, and it is a stretch no more.
pub struct Membrane<const D: usize> {
    law: AreaLaw,
    width: BandWidth,
    band: BandCells<BandPoint<D>>,
    implicit_step: Option<f64>,
    /// Predicts the level set in the semi-implicit scheme.
    predictor: Option<Predictor<D>>,
    /// The carried stretch; `None` where it is the slope of the level set.
    rest: Option<RestDensity<D>>,
}

impl<const D: usize> Clone for Membrane<D> {
    /// Without the predictor, which depends on the mesh.
    fn clone(&self) -> Self {
        Membrane {
            law: self.law,
            width: self.width.clone(),
            band: self.band.clone(),
            implicit_step: self.implicit_step,
            predictor: None,
            rest: self.rest.clone(),
        }
    }
}

impl<const D: usize> Membrane<D> {
    /// A membrane whose band, renormalised, has the half-width `thickness` (`eps`, a length).
    pub fn new(law: AreaLaw, thickness: f64) -> Membrane<D> {
        let (width, band) = (BandWidth::new(thickness), BandCells::default());
        Membrane { law, width, band, implicit_step: None, predictor: None, rest: None }
    }
    /// The same membrane with the stretch that its interface carries, in place of the slope of the
    /// level set.
    pub fn with_carried_stretch(self) -> Membrane<D> {
        Membrane { rest: Some(RestDensity::default()), ..self }
    }
    /// The same membrane over another band; `slope` is that of the level set at time 0.
    pub fn with_band(self, band: Band, slope: f64) -> Membrane<D> {
        Membrane { width: self.width.with_band(band, slope), ..self }
    }
    /// The same membrane over a band with another cut-off function; `norm` is that of the local
    /// slope of a renormalised one.
    pub fn with_kernel(self, kernel: Kernel, norm: Norm) -> Membrane<D> {
        Membrane { width: self.width.with_kernel(kernel, norm), ..self }
    }
    /// The law.
    pub fn law(&self) -> AreaLaw {
        self.law
    }
    /// Half-width of the band.
    pub fn thickness(&self) -> f64 {
        self.width.thickness
    }
    /// Precomputes the force on the band of `phi`, a function of the space of `basis`, which must
    /// have the rule of the flow. With `implicit_step`, a time step, the stiffness enters the
    /// matrix.
    pub fn prepare(&mut self, basis: &Basis<D>, phi: &[f64], implicit_step: Option<f64>) {
        self.prepare_with(basis, (phi, None), implicit_step);
    }
    /// The same for a carried length (area) at rest per length, if there is one.
    fn prepare_with(
        &mut self,
        basis: &Basis<D>,
        (phi, rest_density): (&[f64], Option<&[f64]>),
        implicit_step: Option<f64>,
    ) {
        self.implicit_step = implicit_step;
        let carried = self.rest.as_ref().zip(rest_density);
        self.band.prepare(&self.width, basis, phi, BandPoint::outside(), |c, q, b| {
            let r = stretch_at(basis, (c, q), b, carried);
            // The length at rest in `w` is that of the stretch.
            if r == b.r { *b } else { BandPoint { r, w: b.w * b.r / r, ..*b } }
        });
    }
    /// Band data at a quadrature point; `None` outside the band.
    fn point(&self, at: &At<D>) -> Option<&BandPoint<D>> {
        self.band.get(at).filter(|b| b.w > 0.0)
    }
    /// Elastic energy (3.12) of the membrane on `phi`. `basis` may have a finer rule than the
    /// flow's.
    pub fn energy(&self, basis: &Basis<D>, phi: &[f64]) -> f64 {
        self.energy_with(basis, (phi, None))
    }
    fn energy_with(&self, basis: &Basis<D>, (phi, rest): (&[f64], Option<&[f64]>)) -> f64 {
        let carried = self.rest.as_ref().zip(rest);
        self.width.integrate(basis, phi, |c, q, b| {
            let r = stretch_at(basis, (c, q), b, carried);
            self.law.energy(r) * if r == b.r { 1.0 } else { b.r / r }
        })
    }
    /// Largest tension `E'(r)` in the prepared band; 0 without tension.
    pub fn largest_tension(&self) -> f64 {
        self.band
            .values()
            .iter()
            .filter(|b| b.w > 0.0)
            .map(|b| self.law.tension(b.r))
            .fold(0.0, f64::max)
    }
}

/// The carried stretch at a point of the band; without one the slope of the level set.
fn stretch_at<const D: usize>(
    basis: &Basis<D>,
    (c, q): (usize, usize),
    b: &BandPoint<D>,
    carried: Option<(&RestDensity<D>, &[f64])>,
) -> f64 {
    match carried {
        Some((rest, m)) if b.w > 0.0 => {
            rest.stretch(basis.space().on_cell(m, c).combined(basis.values(q)))
        }
        _ => b.r,
    }
}

impl<const D: usize> MomentumTerm<D> for Membrane<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Cells(Cells::Some(self.band.cells()))
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        let Some(b) = self.point(at) else { return (SVector::zeros(), SMatrix::zeros()) };
        let projection = SMatrix::<f64, D, D>::identity() - b.n * b.n.transpose();
        (SVector::zeros(), projection * (-self.law.tension(b.r) * b.r * b.w))
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
        let (Some(b), Some(dt)) = (self.point(at), self.implicit_step) else {
            return (SVector::zeros(), SMatrix::zeros());
        };
        let weights = [self.law.stiffness(b.r) * b.r * b.r, self.law.tension(b.r).max(0.0) * b.r];
        (SVector::zeros(), self.law.implicit_form(&b.n, grad_u, weights) * (dt * b.w))
    }
}

impl<const D: usize> InterfaceForce<D> for Membrane<D> {
    fn begin(
        &mut self,
        of: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        self.width.begin(host);
        if let Some(rest) = &mut self.rest {
            rest.begin(of, host, None, fields)?;
        }
        let basis = host.basis.filter(|_| of.coupling == Coupling::SemiImplicit);
        self.predictor = basis.map(|b| Predictor::new(b.clone(), host.translations)).transpose()?;
        Ok(())
    }
    fn term(&self) -> Option<&dyn MomentumTerm<D>> {
        Some(self)
    }
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()> {
        let implicit = at.step.filter(|_| of.coupling == Coupling::Implicit);
        let predicted = match (&mut self.predictor, at.step, at.drift) {
            (Some(predictor), Some(dt), Some([now, carried])) => {
                let mut carried = carried.scalar(of.level_set()).to_vec();
                let density = (|p: &At<D>| at.density.at(p), at.density.is_constant());
                let law = (self.law, self.width.thickness);
                predictor.predict(law, dt, density, now.scalar(of.level_set()), &mut carried)?;
                Some(carried)
            }
            _ => None,
        };
        let phi = predicted.as_deref().unwrap_or(at.fields.scalar(of.level_set()));
        let rest_density = self.rest.as_ref().map(|rest| at.fields.scalar(rest.field));
        self.prepare_with(at.basis, (phi, rest_density), implicit);
        Ok(())
    }
    fn advance(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &mut Moved<'_, D>,
        fields: &mut Fields<D>,
    ) -> Result<()> {
        let reach = self.width.thickness;
        let Some(rest) = &mut self.rest else { return Ok(()) };
        rest.advance(of, (by, fields), reach, |_, _| 0.0)
    }
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        rule: &Basis<D>,
    ) -> Result<f64> {
        let rest_density = self.rest.as_ref().map(|rest| at.fields.scalar(rest.field));
        Ok(self.energy_with(rule, (at.fields.scalar(of.level_set()), rest_density)))
    }
    fn tension(&self) -> f64 {
        self.largest_tension()
    }
    fn tension_at(&self, stretch: f64) -> Option<f64> {
        Some(self.law.tension(stretch))
    }
    fn step_limit(&self, medium: &Medium) -> f64 {
        explicit_step_limit(medium, self.width.thickness, self.largest_tension())
    }
    fn keeps_distance(&self) -> bool {
        self.rest.is_some()
    }
    fn surface_density(&self) -> Option<(FieldId, Density)> {
        Some((self.rest.as_ref()?.field, Density::Rest))
    }
    fn bytes(&self) -> usize {
        self.predictor.as_ref().map_or(0, Predictor::bytes)
    }
}
