//! The delta function smeared over a band.

use super::cut_cells;
use crate::base::{Result, parallel};
use crate::fem::{At, Element, Rule, Space};
use crate::levelset::{Bounds, Kernel, Norm};
use crate::mesh::{Location, Point};

/// A delta function smeared over a band, `zeta(phi/(s eps)) |grad phi|/(s eps)` (1.24), with the
/// Heaviside function `int zeta`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smeared {
    /// The cut-off function `zeta`.
    pub kernel: Kernel,
    /// The slope `s` of the band.
    pub width: Width,
    /// Half-width `eps` of the band, a length > 0.
    pub thickness: f64,
    /// Degree of exactness of the quadrature in a cell.
    pub degree: usize,
}

/// The slope `s` of a smeared delta function: it has the half-width `eps s/|grad phi|` in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Width {
    /// A constant: the slope of the level set at time 0, so that the band moves with the fluid.
    Carried(f64),
    /// A norm of the gradient at the point, the renormalisation of section 1.5.2.
    Renormalised(Norm),
}

impl Smeared {
    /// The slope `s` where the level set has the gradient `g`.
    fn slope<const D: usize>(&self, g: &Point<D>) -> f64 {
        match self.width {
            Width::Carried(slope) => slope,
            Width::Renormalised(norm) => norm.of(g),
        }
    }
    /// True if the band may have a point in a cell.
    fn meets<const D: usize>(&self, space: &Space<D>, phi: &[f64], c: usize) -> bool {
        let bounds = Bounds::of_cell(space, phi, c);
        let slope = match self.width {
            Width::Carried(slope) => slope,
            Width::Renormalised(norm) => bounds.slope * norm.largest(D),
        };
        bounds.meet(slope * self.thickness)
    }

    pub(super) fn points<const D: usize>(
        &self,
        space: &Space<D>,
        phi: &[f64],
    ) -> Result<Vec<At<D>>> {
        cut_cells(space, phi)?;
        let rule = Rule::simplex(D, self.degree);
        let mut points = Vec::new();
        for cell in (0..space.mesh().cell_count()).filter(|&c| self.meets(space, phi, c)) {
            let own = space.on_cell(phi, cell);
            let map = space.mesh().map(cell);
            for (l, w) in rule.points.iter().zip(&rule.weights) {
                let g = map
                    .inverse
                    .tr_mul(&own.reference_gradient(&Element::P2.reference_gradients::<D>(l)));
                let delta =
                    self.kernel.weight(own.value(l), self.slope(&g), self.thickness) * g.norm();
                if delta > 0.0 {
                    let weight = w * map.volume * delta;
                    let x = space.mesh().point_at(&Location { cell: cell as u32, barycentric: *l });
                    points.push(At { cell, q: points.len(), barycentric: *l, x, weight });
                }
            }
        }
        Ok(points)
    }

    pub(super) fn inside<const D: usize>(&self, space: &Space<D>, phi: &[f64]) -> Result<f64> {
        cut_cells(space, phi)?;
        let rule = Rule::simplex(D, self.degree);
        let [inside] = parallel::sum(space.mesh().cell_count(), |c| {
            let volume = space.mesh().map(c).volume;
            if !self.meets(space, phi, c) {
                let negative = phi[space.cell_nodes(c)[0] as usize] < 0.0;
                return [if negative { volume } else { 0.0 }];
            }
            let at = |(l, w): (&[f64; 4], &f64)| {
                let width = self.slope(&space.gradient(phi, c, l)) * self.thickness;
                let value = space.value(phi, c, l);
                let outside = if value.abs() < width {
                    self.kernel.heaviside(value / width)
                } else {
                    f64::from(value >= 0.0)
                };
                w * volume * (1.0 - outside)
            };
            [rule.points.iter().zip(&rule.weights).map(at).sum()]
        });
        Ok(inside)
    }
}
