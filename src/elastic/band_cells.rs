//! The band of a membrane and its data at quadrature points, stored for the cells of the band only.

use crate::base::parallel;
use crate::fem::{At, Basis, Numbering, OnCell, Space};
use crate::levelset::{Bounds, Kernel, Norm};
use crate::mesh::NONE;
use crate::structure::Host;
use nalgebra::SVector;
use std::cell::RefCell;
use std::sync::Arc;

/// Distance from the interface, in half-widths, beyond which the band has no point whatever the
/// level set says there.
const FARTHEST: f64 = 3.0;

/// Kinds of cells: without a point of the band, near by its values, cut by the interface.
const FAR: u8 = 0;
const NEAR: u8 = 1;
const CUT: u8 = 2;

/// Lists for the search of the cells of a band, kept from step to step.
#[derive(Default)]
struct Scratch {
    /// Kind of each cell.
    kinds: Vec<u8>,
    near: Vec<u32>,
    /// Distance of each node from the cut cells.
    away: Vec<f64>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

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
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BandWidth {
    /// Half-width `eps`, a length.
    pub thickness: f64,
    /// The slope that the band is measured with; `None` for the local one.
    pub slope: Option<f64>,
    /// The cut-off function.
    pub kernel: Kernel,
    /// The norm of the local slope.
    pub norm: Norm,
    /// One number per node, equal for nodes that periodic sides identify; empty without.
    unknowns: Arc<[u32]>,
}

impl BandWidth {
    /// A renormalised band.
    pub fn new(thickness: f64) -> BandWidth {
        BandWidth {
            thickness,
            slope: None,
            kernel: Kernel::default(),
            norm: Norm::default(),
            unknowns: Arc::new([]),
        }
    }
    /// Makes the band continue through periodic sides.
    pub fn begin<const D: usize>(&mut self, host: &Host<'_, D>) {
        if !host.translations.is_empty() {
            self.unknowns = Numbering::scalar_unknowns(host.space, host.translations).0.into();
        }
    }
    /// A band of another kind; `slope` is that of the level set at time 0.
    pub fn with_band(self, band: Band, slope: f64) -> BandWidth {
        BandWidth { slope: (band == Band::Carried).then_some(slope), ..self }
    }
    /// A band with another cut-off function, and another norm for the local slope.
    pub fn with_kernel(self, kernel: Kernel, norm: Norm) -> BandWidth {
        BandWidth { kernel, norm, ..self }
    }
    /// Calls `then` with the cells that the band may have a point in, in ascending order. A level set
    /// that the flow has wound up is small over its slope also far from its zero: what is farther
    /// away than [`FARTHEST`] half-widths is no part of the band.
    pub fn with_cells<const D: usize, R>(
        &self,
        basis: &Basis<D>,
        phi: &[f64],
        then: impl FnOnce(&[u32]) -> R,
    ) -> R {
        // Another band may be looked for by this thread meanwhile: it then has lists of its own.
        let mut scratch = SCRATCH.take();
        let Scratch { kinds, near, .. } = &mut scratch;
        let space = basis.space();
        kinds.clear();
        kinds.resize(space.mesh().cell_count(), FAR);
        parallel::fill(kinds, 1, |first, part| {
            for (i, kind) in part.iter_mut().enumerate() {
                let bounds = Bounds::of_cell(space, phi, first + i);
                let slope = self.slope.unwrap_or(bounds.slope * self.norm.largest(D));
                if bounds.meet(slope * self.thickness) {
                    let is_cut = bounds.low <= 0.0 && bounds.high >= 0.0;
                    *kind = if is_cut { CUT } else { NEAR };
                }
            }
        });
        near.clear();
        near.extend((0..kinds.len() as u32).filter(|&c| kinds[c as usize] != FAR));
        self.leave_out_far(space, &mut scratch);
        let result = then(&scratch.near);
        SCRATCH.set(scratch);
        result
    }
    /// Keeps the cells of the list that lie close to one that is cut, through cells of the list.
    fn leave_out_far<const D: usize>(&self, space: &Space<D>, scratch: &mut Scratch) {
        let Scratch { kinds, near, away } = scratch;
        let unknown = |&n: &u32| self.unknowns.get(n as usize).copied().unwrap_or(n) as usize;
        let nodes = |c: u32| space.cell_nodes(c as usize);
        let reach = FARTHEST * self.thickness;
        away.clear();
        away.resize(space.len(), f64::INFINITY);
        for n in near.iter().filter(|&&c| kinds[c as usize] == CUT).flat_map(|&c| nodes(c)) {
            away[unknown(n)] = 0.0;
        }
        let nearest = |away: &[f64], c: u32| {
            nodes(c).iter().map(|n| away[unknown(n)]).fold(f64::INFINITY, f64::min)
        };
        // Lengths of ways from node to node, longer than distances by a third at most.
        let mut changes = true;
        while changes {
            changes = false;
            for &c in near.iter() {
                let least = nearest(away, c);
                if least > reach {
                    continue;
                }
                let from = nodes(c).iter().find(|n| away[unknown(n)] == least);
                let from = from.map(|&n| space.nodes()[n as usize]);
                for n in nodes(c) {
                    let step = from.map_or(0.0, |x| (space.nodes()[*n as usize] - x).norm());
                    if least + step < away[unknown(n)] {
                        (away[unknown(n)], changes) = (least + step, true);
                    }
                }
            }
        }
        near.retain(|&c| nearest(away, c) <= reach);
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
        self.with_cells(basis, phi, |near| {
            let [sum] = parallel::sum(basis.space().mesh().cell_count(), |c| {
                if near.binary_search(&(c as u32)).is_err() {
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
        })
    }
}

/// One `P` per quadrature point of each cell that a band may have a point in.
#[derive(Clone, Debug)]
pub(super) struct BandCells<P> {
    points: usize,
    cells: Vec<u32>,
    /// Position of a cell in `cells`; [`NONE`] for the others.
    slot: Vec<u32>,
    values: Vec<P>,
}

impl<P> Default for BandCells<P> {
    fn default() -> BandCells<P> {
        BandCells { points: 0, cells: Vec::new(), slot: Vec::new(), values: Vec::new() }
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
        self.cells.iter().for_each(|&c| self.slot[c as usize] = NONE);
        self.slot.resize(basis.space().mesh().cell_count(), NONE);
        self.cells.clear();
        width.with_cells(basis, phi, |cells| self.cells.extend_from_slice(cells));
        for (slot, &c) in self.cells.iter().enumerate() {
            self.slot[c as usize] = slot as u32;
        }
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
