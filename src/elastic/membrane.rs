//! The membrane with an area law: the stress (3.16) on a renormalised band, explicit or implicit in the velocity.

use super::area_law::AreaLaw;
use crate::fem::{At, Basis, Cells, VectorForm, integrate};
use crate::flow::term::MomentumTerm;
use crate::levelset as band;
use nalgebra::{SMatrix, SVector};

/// What a point of the band knows of the level set.
#[derive(Clone, Copy, Debug)]
struct BandPoint<const D: usize> {
    /// Unit normal, outward.
    n: SVector<f64, D>,
    /// Stretch `|grad phi|`.
    r: f64,
    /// `zeta(phi/(r eps))/(r eps)`; zero outside the band.
    w: f64,
}

/// An elastic membrane on the zero level of `phi`, smeared over the band `|phi| < r eps`.
///
/// The force is (3.16) integrated weakly, `F(v) = - int E'(r) r P : grad v w`, with `P = I - n n`; the energy is (3.12),
/// `int E(r) w`. Gradients are taken at the quadrature points. Implicit in the velocity, the form
/// `C(u, v) = dt int [E'' r^2 (P : grad u)(P : grad v) + max(E', 0) r (n grad u P) . (n grad v P)] w` is added to the matrix;
/// for constant tension and in 3-D the last product is `(grad u P) : (grad v P)`.
#[derive(Clone, Debug)]
pub struct Membrane<const D: usize> {
    law: AreaLaw,
    thickness: f64,
    points: usize,
    cells: Vec<u32>,
    /// Position of a cell in `cells`.
    slot: Vec<u32>,
    band: Vec<BandPoint<D>>,
    implicit_step: Option<f64>,
}

impl<const D: usize> Membrane<D> {
    /// A membrane whose band has the half-width `thickness` (`eps`, a length).
    pub fn new(law: AreaLaw, thickness: f64) -> Membrane<D> {
        Membrane {
            law,
            thickness,
            points: 0,
            cells: Vec::new(),
            slot: Vec::new(),
            band: Vec::new(),
            implicit_step: None,
        }
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
        self.cells = band_cells(basis, phi, self.thickness);
        self.slot.resize(basis.space().mesh().cell_count(), 0);
        self.band.clear();
        for (k, &c) in self.cells.iter().enumerate() {
            self.slot[c as usize] = k as u32;
            for q in 0..self.points {
                let at = basis.at(c as usize, q);
                self.band.push(band_point(basis, &at, phi, self.thickness));
            }
        }
    }
    fn point(&self, at: &At<D>) -> &BandPoint<D> {
        &self.band[self.slot[at.cell] as usize * self.points + at.q]
    }
    /// Elastic energy (3.12) of the membrane on `phi`. `basis` may have a finer rule than the flow's.
    pub fn energy(&self, basis: &Basis<D>, phi: &[f64]) -> f64 {
        let cells = band_cells(basis, phi, self.thickness);
        let [energy] = integrate(basis, Cells::Some(&cells), |at| {
            let b = band_point(basis, at, phi, self.thickness);
            [self.law.energy(b.r) * b.w]
        });
        energy
    }
    /// Largest tension `E'(r)` in the band that was prepared last; 0 when nothing is under tension.
    pub fn largest_tension(&self) -> f64 {
        self.band.iter().filter(|b| b.w > 0.0).map(|b| self.law.tension(b.r)).fold(0.0, f64::max)
    }
    /// The cells of the band that was prepared last.
    pub fn band_cells(&self) -> &[u32] {
        &self.cells
    }
}

/// Cells that may hold a point of the band: by the values and the spread of `phi` at the nodes.
fn band_cells<const D: usize>(basis: &Basis<D>, phi: &[f64], eps: f64) -> Vec<u32> {
    let space = basis.space();
    let mesh = space.mesh();
    let near = |c: usize| {
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for &n in space.cell_nodes(c) {
            lo = lo.min(phi[n as usize]);
            hi = hi.max(phi[n as usize]);
        }
        // The band is |phi| < r eps, and r is at most a few times the slope seen over the cell.
        let slope = (hi - lo) / mesh.diameter(c);
        let reach = 4.0 * slope * eps + (hi - lo);
        lo <= reach && hi >= -reach
    };
    (0..mesh.cell_count()).filter(|&c| near(c)).map(|c| c as u32).collect()
}

fn band_point<const D: usize>(basis: &Basis<D>, at: &At<D>, phi: &[f64], eps: f64) -> BandPoint<D> {
    let g = basis.gradient(at, phi);
    let r = g.norm();
    let w = band::surface_weight(basis.value(at, phi), r, eps);
    let n = if r > 0.0 { g / r } else { SVector::zeros() };
    BandPoint { n, r, w }
}

impl<const D: usize> MomentumTerm<D> for Membrane<D> {
    fn cells(&self) -> Cells<'_> {
        Cells::Some(&self.cells)
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        let b = self.point(at);
        let projection = SMatrix::<f64, D, D>::identity() - b.n * b.n.transpose();
        (SVector::zeros(), projection * (-self.law.tension(b.r) * b.r * b.w))
    }
    fn is_implicit(&self) -> bool {
        self.implicit_step.is_some()
    }
    fn stiffness(&self, at: &At<D>, grad_u: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
        let (b, Some(dt)) = (self.point(at), self.implicit_step) else { return SMatrix::zeros() };
        if b.w == 0.0 {
            return SMatrix::zeros();
        }
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
