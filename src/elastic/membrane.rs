//! The membrane with an area law: the stress (3.16) on a renormalised band, explicit or implicit in the velocity.

use super::area_law::AreaLaw;
use crate::base::parallel;
use crate::fem::{At, Basis, Cells, OnCell, VectorForm};
use crate::flow::term::MomentumTerm;
use crate::levelset::{self as band, Bounds};
use crate::mesh::NONE;
use nalgebra::{SMatrix, SVector};

/// What a point of the band knows of the level set.
#[derive(Clone, Copy, Debug)]
struct BandPoint<const D: usize> {
    /// Unit normal, outward.
    n: SVector<f64, D>,
    /// Stretch `|grad phi|`.
    r: f64,
    /// `zeta(phi/(s eps))/(s eps)` with `s` the slope by [`Band`]; zero outside the band.
    w: f64,
}

/// Over which values of its level set a membrane is spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Band {
    /// `|phi| < r eps` with the local `r` (the renormalisation of (1.32)-(1.35)): of half-width `eps` in space however the
    /// membrane is stretched. Its weight is not carried by the fluid, so the force is the derivative of the energy but for terms
    /// of first order in `eps`: energy comes from nowhere slowly, and a drop that should rest breaks up in the end.
    Renormalised,
    /// `|phi| < s eps`, `s` being the slope of the level set at the start: moves with the fluid, so that the force is the
    /// derivative of the energy; of half-width `eps s / r` in space.
    Carried,
}

/// An elastic membrane on the zero level of `phi`, smeared over a band.
///
/// The force is (3.16) integrated weakly, `F(v) = - int E'(r) r P : grad v w`, with `P = I - n n`; the energy is (3.12),
/// `int E(r) w`. Gradients are taken at the quadrature points. Implicit in the velocity, the form
/// `C(u, v) = dt int [E'' r^2 (P : grad u)(P : grad v) + max(E', 0) r (n grad u P) . (n grad v P)] w` is added to the matrix;
/// for constant tension and in 3-D the last product is `(grad u P) : (grad v P)`.
#[derive(Clone, Debug)]
pub struct Membrane<const D: usize> {
    law: AreaLaw,
    thickness: f64,
    /// The slope that the band is measured with; `None` for the local one.
    slope: Option<f64>,
    points: usize,
    cells: Vec<u32>,
    /// Position of a cell in `cells`; [`NONE`] for the others.
    slot: Vec<u32>,
    /// For every cell whether the band may have a point in it.
    near: Vec<bool>,
    band: Vec<BandPoint<D>>,
    implicit_step: Option<f64>,
}

impl<const D: usize> Membrane<D> {
    /// A membrane whose band, renormalised, has the half-width `thickness` (`eps`, a length).
    pub fn new(law: AreaLaw, thickness: f64) -> Membrane<D> {
        Membrane {
            law,
            thickness,
            slope: None,
            points: 0,
            cells: Vec::new(),
            slot: Vec::new(),
            near: Vec::new(),
            band: Vec::new(),
            implicit_step: None,
        }
    }
    /// The same membrane over another band; `slope` is that of the level set at the start.
    pub fn with_band(self, band: Band, slope: f64) -> Membrane<D> {
        Membrane { slope: (band == Band::Carried).then_some(slope), ..self }
    }
    /// The law.
    pub fn law(&self) -> AreaLaw {
        self.law
    }
    /// Half-width of the band.
    pub fn thickness(&self) -> f64 {
        self.thickness
    }
    /// Takes stock of the band of `phi`, a function of the space of `basis`, which must have the rule of the flow.
    /// With `implicit_step`, a time step, the stiffness goes into the matrix.
    pub fn prepare(&mut self, basis: &Basis<D>, phi: &[f64], implicit_step: Option<f64>) {
        self.implicit_step = implicit_step;
        self.points = basis.rule().len();
        self.find_cells(basis, phi);
        let nowhere = BandPoint { n: SVector::zeros(), r: 0.0, w: 0.0 };
        let mut band = std::mem::take(&mut self.band);
        band.resize(self.cells.len() * self.points, nowhere);
        parallel::fill(&mut band, self.points, |first, part| {
            for (i, points) in part.chunks_exact_mut(self.points).enumerate() {
                let c = self.cells[first + i] as usize;
                let own = basis.space().on_cell(phi, c);
                points.iter_mut().enumerate().for_each(|(q, p)| *p = self.band_point(basis, c, q, &own));
            }
        });
        self.band = band;
    }
    /// Lists the cells of the band.
    fn find_cells(&mut self, basis: &Basis<D>, phi: &[f64]) {
        let mut near = std::mem::take(&mut self.near);
        near.resize(basis.space().mesh().cell_count(), false);
        parallel::fill(&mut near, 1, |first, part| {
            part.iter_mut().enumerate().for_each(|(i, near)| *near = self.is_near(basis, phi, first + i));
        });
        self.cells.iter().for_each(|&c| self.slot[c as usize] = NONE);
        self.slot.resize(near.len(), NONE);
        self.cells.clear();
        for c in (0..near.len()).filter(|&c| near[c]) {
            self.slot[c] = self.cells.len() as u32;
            self.cells.push(c as u32);
        }
        self.near = near;
    }
    /// What was found at a quadrature point; `None` outside the band.
    fn point(&self, at: &At<D>) -> Option<&BandPoint<D>> {
        let slot = self.slot[at.cell];
        (slot != NONE).then(|| &self.band[slot as usize * self.points + at.q]).filter(|b| b.w > 0.0)
    }
    /// Elastic energy (3.12) of the membrane on `phi`. `basis` may have a finer rule than the flow's.
    pub fn energy(&self, basis: &Basis<D>, phi: &[f64]) -> f64 {
        let [energy] = parallel::sum(basis.space().mesh().cell_count(), |c| {
            if !self.is_near(basis, phi, c) {
                return [0.0];
            }
            let own = basis.space().on_cell(phi, c);
            let at = |q: usize| {
                let b = self.band_point(basis, c, q, &own);
                basis.weight(c, q) * self.law.energy(b.r) * b.w
            };
            [(0..basis.rule().len()).map(at).sum()]
        });
        energy
    }
    /// Largest tension `E'(r)` in the band that was prepared last; 0 when nothing is under tension.
    pub fn largest_tension(&self) -> f64 {
        self.band.iter().filter(|b| b.w > 0.0).map(|b| self.law.tension(b.r)).fold(0.0, f64::max)
    }
    /// Whether the band may have a point in cell `c`.
    fn is_near(&self, basis: &Basis<D>, phi: &[f64], c: usize) -> bool {
        let bounds = Bounds::of_cell(basis.space(), phi, c);
        bounds.meet(self.slope.unwrap_or(bounds.slope) * self.thickness)
    }
    /// What there is at point `q` of cell `c`, where the level set is `own`.
    fn band_point(&self, basis: &Basis<D>, c: usize, q: usize, own: &OnCell<f64, D>) -> BandPoint<D> {
        let inverse = &basis.space().mesh().map(c).inverse;
        let g = inverse.tr_mul(&own.reference_gradient(basis.reference_gradients(q)));
        let r = g.norm();
        let w = band::surface_weight(own.combined(basis.values(q)), self.slope.unwrap_or(r), self.thickness);
        let n = if r > 0.0 { g / r } else { SVector::zeros() };
        BandPoint { n, r, w }
    }
}

impl<const D: usize> MomentumTerm<D> for Membrane<D> {
    fn cells(&self) -> Cells<'_> {
        Cells::Some(&self.cells)
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
