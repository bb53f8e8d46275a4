//! The membrane with an area law: the stress (3.16) on a renormalised band, explicit or implicit in the velocity.

use super::area_law::AreaLaw;
use crate::fem::{At, Basis, Cells, VectorForm, integrate};
use crate::flow::term::MomentumTerm;
use crate::levelset as band;
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
        self.cells.iter().for_each(|&c| self.slot[c as usize] = NONE);
        self.slot.resize(basis.space().mesh().cell_count(), NONE);
        self.cells = self.cells_of(basis, phi);
        self.band.clear();
        for (k, &c) in self.cells.iter().enumerate() {
            self.slot[c as usize] = k as u32;
            for q in 0..self.points {
                let at = basis.at(c as usize, q);
                let point = self.band_point(basis, &at, phi);
                self.band.push(point);
            }
        }
    }
    /// What was found at a quadrature point; `None` outside the band.
    fn point(&self, at: &At<D>) -> Option<&BandPoint<D>> {
        let slot = self.slot[at.cell];
        (slot != NONE).then(|| &self.band[slot as usize * self.points + at.q]).filter(|b| b.w > 0.0)
    }
    /// Elastic energy (3.12) of the membrane on `phi`. `basis` may have a finer rule than the flow's.
    pub fn energy(&self, basis: &Basis<D>, phi: &[f64]) -> f64 {
        let cells = self.cells_of(basis, phi);
        let [energy] = integrate(basis, Cells::Some(&cells), |at| {
            let b = self.band_point(basis, at, phi);
            [self.law.energy(b.r) * b.w]
        });
        energy
    }
    /// Largest tension `E'(r)` in the band that was prepared last; 0 when nothing is under tension.
    pub fn largest_tension(&self) -> f64 {
        self.band.iter().filter(|b| b.w > 0.0).map(|b| self.law.tension(b.r)).fold(0.0, f64::max)
    }
    /// Cells that may hold a point of the band: by the values and the spread of `phi` at the nodes.
    fn cells_of(&self, basis: &Basis<D>, phi: &[f64]) -> Vec<u32> {
        let space = basis.space();
        let mesh = space.mesh();
        let near = |c: usize| {
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            for &n in space.cell_nodes(c) {
                lo = lo.min(phi[n as usize]);
                hi = hi.max(phi[n as usize]);
            }
            // The local slope is at most a few times that over the cell.
            let slope = self.slope.unwrap_or(4.0 * (hi - lo) / mesh.diameter(c));
            let reach = slope * self.thickness + (hi - lo);
            lo <= reach && hi >= -reach
        };
        (0..mesh.cell_count()).filter(|&c| near(c)).map(|c| c as u32).collect()
    }
    fn band_point(&self, basis: &Basis<D>, at: &At<D>, phi: &[f64]) -> BandPoint<D> {
        let g = basis.gradient(at, phi);
        let r = g.norm();
        let w = band::surface_weight(basis.value(at, phi), self.slope.unwrap_or(r), self.thickness);
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
        let projection = SMatrix::<f64, D, D>::identity() - b.n * b.n.transpose();
        let tangential = grad_u * projection;
        let bent = if D == 2 && !matches!(self.law, AreaLaw::Tension { .. }) {
            b.n * (b.n.transpose() * tangential)
        } else {
            tangential
        };
        let stretched = projection * (self.law.stiffness(b.r) * b.r * b.r * tangential.trace());
        (stretched + bent * (self.law.tension(b.r).max(0.0) * b.r)) * (dt * b.w)
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
