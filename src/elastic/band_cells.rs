//! The band of a membrane and its data at quadrature points, stored for the cells of the band only.

use crate::base::parallel;
use crate::fem::{At, Basis, OnCell};
use crate::levelset::{Bounds, Kernel, Norm};
use crate::mesh::NONE;
use nalgebra::SVector;

/// Definition of the band by values of the level set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Band {
    /// `|phi| < r eps` with the local `r` (the renormalisation of (1.32)-(1.35)): half-width `eps`
    /// in space for any stretch of the membrane. Its weight is not transported by the fluid, so the
    /// force is the derivative of the energy only up to terms of first order in `eps`: spurious
    /// energy is produced slowly, and a drop at rest breaks up in the end.
    Renormalised,
    /// `|phi| < s eps`, with `s` the slope of the level set at time 0. The band moves with the
    /// fluid, so that the force is the derivative of the energy; its half-width in space is
    /// `eps s / r`.
    Carried,
}

/// Level set data at a point of the band.
#[derive(Clone, Copy, Debug)]
pub(super) struct BandPoint<const D: usize> {
    /// Unit normal, outward.
    pub n: SVector<f64, D>,
    /// Slope `|grad phi|`.
    pub r: f64,
    /// `zeta(phi/(s eps))/(s eps)` with `s` the slope by [`Band`]; zero outside the band.
    pub w: f64,
}

impl<const D: usize> BandPoint<D> {
    /// The data outside the band.
    pub fn outside() -> BandPoint<D> {
        BandPoint { n: SVector::zeros(), r: 0.0, w: 0.0 }
    }
}

/// Half-width and kind of a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BandWidth {
    /// Half-width `eps`, a length.
    pub thickness: f64,
    /// The slope that the band is measured with; `None` for the local one.
    pub slope: Option<f64>,
    /// The cut-off function.
    pub kernel: Kernel,
    /// The norm of the local slope.
    pub norm: Norm,
}

impl BandWidth {
    /// A renormalised band.
    pub fn new(thickness: f64) -> BandWidth {
        BandWidth { thickness, slope: None, kernel: Kernel::default(), norm: Norm::default() }
    }
    /// A band of another kind; `slope` is that of the level set at time 0.
    pub fn with_band(self, band: Band, slope: f64) -> BandWidth {
        BandWidth { slope: (band == Band::Carried).then_some(slope), ..self }
    }
    /// A band with another cut-off function, and another norm for the local slope.
    pub fn with_kernel(self, kernel: Kernel, norm: Norm) -> BandWidth {
        BandWidth { kernel, norm, ..self }
    }
    /// True if the band may have a point in cell `c`.
    pub fn is_near<const D: usize>(&self, basis: &Basis<D>, phi: &[f64], c: usize) -> bool {
        let bounds = Bounds::of_cell(basis.space(), phi, c);
        bounds.meet(self.slope.unwrap_or(bounds.slope * self.norm.largest(D)) * self.thickness)
    }
    /// Data at point `q` of cell `c`, where the level set is `own`.
    pub fn point<const D: usize>(
        &self,
        basis: &Basis<D>,
        c: usize,
        q: usize,
        own: &OnCell<f64, D>,
    ) -> BandPoint<D> {
        let inverse = &basis.space().mesh().map(c).inverse;
        let g = inverse.tr_mul(&own.reference_gradient(basis.reference_gradients(q)));
        let r = g.norm();
        let slope = self.slope.unwrap_or_else(|| self.norm.of(&g));
        let w = self.kernel.weight(own.combined(basis.values(q)), slope, self.thickness);
        let n = if r > 0.0 { g / r } else { SVector::zeros() };
        BandPoint { n, r, w }
    }
    /// Sum over the quadrature points of the band of `value(cell, point, band point)`, times the
    /// weights.
    pub fn integrate<const D: usize>(
        &self,
        basis: &Basis<D>,
        phi: &[f64],
        value: impl Fn(usize, usize, &BandPoint<D>) -> f64 + Sync,
    ) -> f64 {
        let [sum] = parallel::sum(basis.space().mesh().cell_count(), |c| {
            if !self.is_near(basis, phi, c) {
                return [0.0];
            }
            let own = basis.space().on_cell(phi, c);
            let at = |q: usize| {
                let b = self.point(basis, c, q, &own);
                basis.weight(c, q) * value(c, q, &b) * b.w
            };
            [(0..basis.rule().len()).map(at).sum()]
        });
        sum
    }
}

/// One `P` per quadrature point of each cell that a band may have a point in.
#[derive(Clone, Debug)]
pub(super) struct BandCells<P> {
    points: usize,
    cells: Vec<u32>,
    /// Position of a cell in `cells`; [`NONE`] for the others.
    slot: Vec<u32>,
    /// For every cell: true if the band may have a point in it.
    near: Vec<bool>,
    values: Vec<P>,
}

impl<P> Default for BandCells<P> {
    fn default() -> BandCells<P> {
        BandCells {
            points: 0,
            cells: Vec::new(),
            slot: Vec::new(),
            near: Vec::new(),
            values: Vec::new(),
        }
    }
}

impl<P: Copy + Send + Sync> BandCells<P> {
    /// Lists the cells of the band of `phi`, and computes `point(cell, q, band point)`; `nothing`
    /// is the initial value.
    pub fn prepare<const D: usize>(
        &mut self,
        width: &BandWidth,
        basis: &Basis<D>,
        phi: &[f64],
        nothing: P,
        point: impl Fn(usize, usize, &BandPoint<D>) -> P + Sync,
    ) {
        self.points = basis.rule().len();
        self.find_cells(basis.space().mesh().cell_count(), |c| width.is_near(basis, phi, c));
        let mut values = std::mem::take(&mut self.values);
        values.resize(self.cells.len() * self.points, nothing);
        parallel::fill(&mut values, self.points, |first, part| {
            for (i, points) in part.chunks_exact_mut(self.points).enumerate() {
                let c = self.cells[first + i] as usize;
                let own = basis.space().on_cell(phi, c);
                points
                    .iter_mut()
                    .enumerate()
                    .for_each(|(q, p)| *p = point(c, q, &width.point(basis, c, q, &own)));
            }
        });
        self.values = values;
    }
    fn find_cells(&mut self, count: usize, is_near: impl Fn(usize) -> bool + Sync) {
        let mut near = std::mem::take(&mut self.near);
        near.resize(count, false);
        parallel::fill(&mut near, 1, |first, part| {
            part.iter_mut().enumerate().for_each(|(i, near)| *near = is_near(first + i));
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
    /// The cells, in ascending order.
    pub fn cells(&self) -> &[u32] {
        &self.cells
    }
    /// All values.
    pub fn values(&self) -> &[P] {
        &self.values
    }
    /// The value at a quadrature point; `None` in other cells.
    #[inline]
    pub fn get<const D: usize>(&self, at: &At<D>) -> Option<&P> {
        let slot = self.slot[at.cell];
        (slot != NONE).then(|| &self.values[slot as usize * self.points + at.q])
    }
}
