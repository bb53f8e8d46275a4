//! The membrane with an area law: the stress (3.16) on a renormalised band, explicit or implicit in the velocity.

use super::area_law::AreaLaw;
use super::band_cells::{Band, BandCells, BandPoint, BandWidth};
use crate::fem::{At, Basis, Cells, VectorForm};
use crate::flow::term::MomentumTerm;
use crate::levelset::{Kernel, Norm};
use nalgebra::{SMatrix, SVector};

/// An elastic membrane on the zero level of `phi`, smeared over a band.
///
/// The force is (3.16) integrated weakly, `F(v) = - int E'(r) r P : grad v w`, with `P = I - n n`; the energy is (3.12),
/// `int E(r) w`. Gradients are taken at the quadrature points. Implicit in the velocity, the form
/// `C(u, v) = dt int [E'' r^2 (P : grad u)(P : grad v) + max(E', 0) r (n grad u P) . (n grad v P)] w` is added to the matrix;
/// for constant tension and in 3-D the last product is `(grad u P) : (grad v P)`.
#[derive(Clone, Debug)]
pub struct Membrane<const D: usize> {
    law: AreaLaw,
    width: BandWidth,
    band: BandCells<BandPoint<D>>,
    implicit_step: Option<f64>,
}

impl<const D: usize> Membrane<D> {
    /// A membrane whose band, renormalised, has the half-width `thickness` (`eps`, a length).
    pub fn new(law: AreaLaw, thickness: f64) -> Membrane<D> {
        Membrane { law, width: BandWidth::new(thickness), band: BandCells::default(), implicit_step: None }
    }
    /// The same membrane over another band; `slope` is that of the level set at the start.
    pub fn with_band(self, band: Band, slope: f64) -> Membrane<D> {
        Membrane { width: self.width.with_band(band, slope), ..self }
    }
    /// The same membrane over a band with another cut-off function; `norm` is that of the local slope of a renormalised one.
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
    /// Takes stock of the band of `phi`, a function of the space of `basis`, which must have the rule of the flow.
    /// With `implicit_step`, a time step, the stiffness goes into the matrix.
    pub fn prepare(&mut self, basis: &Basis<D>, phi: &[f64], implicit_step: Option<f64>) {
        self.implicit_step = implicit_step;
        self.band.prepare(&self.width, basis, phi, BandPoint::nowhere(), |_, _, b| *b);
    }
    /// What was found at a quadrature point; `None` outside the band.
    fn point(&self, at: &At<D>) -> Option<&BandPoint<D>> {
        self.band.get(at).filter(|b| b.w > 0.0)
    }
    /// Elastic energy (3.12) of the membrane on `phi`. `basis` may have a finer rule than the flow's.
    pub fn energy(&self, basis: &Basis<D>, phi: &[f64]) -> f64 {
        self.width.integrate(basis, phi, |_, _, b| self.law.energy(b.r))
    }
    /// Largest tension `E'(r)` in the band that was prepared last; 0 when nothing is under tension.
    pub fn largest_tension(&self) -> f64 {
        self.band.values().iter().filter(|b| b.w > 0.0).map(|b| self.law.tension(b.r)).fold(0.0, f64::max)
    }
}

impl<const D: usize> MomentumTerm<D> for Membrane<D> {
    fn cells(&self) -> Cells<'_> {
        Cells::Some(self.band.cells())
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        let Some(b) = self.point(at) else { return (SVector::zeros(), SMatrix::zeros()) };
        let projection = SMatrix::<f64, D, D>::identity() - b.n * b.n.transpose();
        (SVector::zeros(), projection * (-self.law.tension(b.r) * b.r * b.w))
    }
    fn is_implicit(&self) -> bool {
        self.implicit_step.is_some()
    }
    fn stiffness(&self, at: &At<D>, grad_u: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        let (Some(b), Some(dt)) = (self.point(at), self.implicit_step) else { return SMatrix::zeros() };
        let weights = [self.law.stiffness(b.r) * b.r * b.r, self.law.tension(b.r).max(0.0) * b.r];
        self.law.implicit_form(&b.n, grad_u, weights) * (dt * b.w)
    }
}

/// Largest stable step of the explicit coupling (1.54):
/// `dt <= (mu eps + sqrt(mu^2 eps^2 + lambda eps dx^2 / 2)) / lambda`,
/// with `lambda` the tension `E'(r)` and `dx = 2 h / sqrt(60)`, the length that the largest eigenvalue `60/h^2` of the P2
/// Laplacian on edges `h` stands for. Infinite without tension.
pub fn explicit_step_limit(viscosity: f64, thickness: f64, tension: f64, edge: f64) -> f64 {
    if tension <= 0.0 {
        return f64::INFINITY;
    }
    let dx = 2.0 * edge / 60f64.sqrt();
    let damping = viscosity * thickness;
    (damping + (damping * damping + 0.5 * tension * thickness * dx * dx).sqrt()) / tension
}
