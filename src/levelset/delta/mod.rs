//! Discrete delta functions: integrals over the interface of a level set, and over the set that it
//! encloses (section 1.5 of the book).

mod lattice;
mod smeared;
mod smereka;
mod towers;

pub use smeared::{Smeared, Width};

use super::interface::{enclosed, quadrature};
use super::sign::cut_cells;
use crate::base::Result;
use crate::fem::{At, Space};

/// A discrete delta function, points and weights from a level set:
/// `int_{phi = 0} f ~ sum weight f(point)`.
///
/// Each is defined on triangles and tetrahedra for any `phi` with a gradient at the interface,
/// distance or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Delta {
    /// Smeared over a band, by quadrature: (1.24), renormalised or carried.
    Smeared(Smeared),
    /// Smereka's first delta at the nodes (J. Comput. Phys. 211 (2006) 77-90): the Laplacian of a
    /// function whose normal derivative jumps by 1.
    Smereka1,
    /// Smereka's second: includes the jump of the second derivatives, from the curvature.
    Smereka2,
    /// Towers' (section 1.5.4) at the nodes: `(Lap I - H Lap phi)/|grad phi|` with
    /// `I = max(phi, 0)`, `H = grad I . grad phi/|grad phi|^2`.
    Towers,
    /// The zero set of the P2 function itself, by curved segments or triangles.
    Cut,
}

impl Delta {
    /// Points and weights for the level set `phi`, a function of the P2 `space`, numbered by
    /// `at.q`. Points at nodes have one of the cells of the node; there is one per node.
    ///
    /// # Errors
    /// A space that is not P2, a value of `phi` that is not finite.
    pub fn points<const D: usize>(&self, space: &Space<D>, phi: &[f64]) -> Result<Vec<At<D>>> {
        match self {
            Delta::Smeared(smeared) => smeared.points(space, phi),
            Delta::Smereka1 => smereka::points(space, phi, false),
            Delta::Smereka2 => smereka::points(space, phi, true),
            Delta::Towers => towers::points(space, phi),
            Delta::Cut => quadrature(space, phi),
        }
    }
    /// The integral of `f` over the interface.
    ///
    /// # Errors
    /// Those of [`Delta::points`].
    pub fn integrate<const D: usize>(
        &self,
        space: &Space<D>,
        phi: &[f64],
        f: impl Fn(&At<D>) -> f64,
    ) -> Result<f64> {
        Ok(self.points(space, phi)?.iter().map(|at| at.weight * f(at)).sum())
    }
    /// Length (in the plane) or area (in space) of the interface.
    ///
    /// # Errors
    /// Those of [`Delta::points`].
    pub fn measure<const D: usize>(&self, space: &Space<D>, phi: &[f64]) -> Result<f64> {
        self.integrate(space, phi, |_| 1.0)
    }
    /// True if the delta function has a Heaviside function; Smereka's have none.
    pub fn has_inside(&self) -> bool {
        !matches!(self, Delta::Smereka1 | Delta::Smereka2)
    }
    /// Area or volume of the set `phi < 0` by the Heaviside function of this delta function; `None`
    /// if it has none.
    ///
    /// # Errors
    /// Those of [`Delta::points`].
    pub fn inside<const D: usize>(&self, space: &Space<D>, phi: &[f64]) -> Result<Option<f64>> {
        Ok(match self {
            Delta::Smeared(smeared) => Some(smeared.inside(space, phi)?),
            Delta::Smereka1 | Delta::Smereka2 => None,
            Delta::Towers => Some(towers::inside(space, phi)?),
            Delta::Cut => Some(enclosed(space, phi)?),
        })
    }
}

/// Points at the nodes with these nonzero weights, in the order of the nodes, each in the first of
/// its `cells`.
fn at_nodes<const D: usize>(
    space: &Space<D>,
    cells: impl Iterator<Item = usize>,
    weights: &[f64],
) -> Vec<At<D>> {
    let mut points = Vec::new();
    let mut seen = vec![false; weights.len()];
    for cell in cells {
        for (a, &n) in space.cell_nodes(cell).iter().enumerate() {
            let node = n as usize;
            if !std::mem::replace(&mut seen[node], true) && weights[node] != 0.0 {
                let barycentric = space.element().node(a, D);
                points.push((
                    n,
                    At { cell, q: 0, barycentric, x: space.nodes()[node], weight: weights[node] },
                ));
            }
        }
    }
    points.sort_unstable_by_key(|(n, _)| *n);
    let numbered = points.into_iter().enumerate();
    numbered.map(|(q, (_, at))| At { q, ..at }).collect()
}

#[cfg(test)]
mod tests;
