//! The slip of a sharp force along its interface.

use crate::fem::{Space, SurfacePoint};
use nalgebra::SVector;

/// The slip is `extent / (SLIP mu)` times the tangential force.
const SLIP: f64 = 15.0;

/// Slip velocity over tangential force in a fluid of viscosity `mu`.
///
/// A tangential force on an interface gives the velocity a kink, which P2 smooths over a cell of
/// extent `l` across the interface: the interface moves too slowly, by `l/(15 mu)` times the force
/// in the mean over its positions in the cell (in one dimension, the Galerkin error at a point force
/// at `x` of a P2 element is `[x(1-x) - 3 x^2 (1-x)^2] l/mu`). This *slip* is added to the motion of
/// the interface along itself. It dissipates the power of the force on it, the dissipation in the
/// unresolved part of the kink.
pub(super) fn slip<const D: usize>(space: &Space<D>, p: &SurfacePoint<D>, viscosity: f64) -> f64 {
    extent(space, p) / (SLIP * viscosity)
}

/// The same at the nodes of cut cells, in the mean over these cells; in the mean over all of them at
/// other nodes.
pub(super) fn nodal_slip<const D: usize>(
    space: &Space<D>,
    points: &[SurfacePoint<D>],
    viscosity: f64,
) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); space.len()];
    let (mut total, mut cells) = (0.0, 0.0);
    for group in points.chunk_by(|a, b| a.at.cell == b.at.cell) {
        let own = slip(space, &group[0], viscosity);
        (total, cells) = (total + own, cells + 1.0);
        for &n in space.cell_nodes(group[0].at.cell) {
            let (sum, count) = &mut sums[n as usize];
            (*sum, *count) = (*sum + own, *count + 1.0);
        }
    }
    let mean = |(sum, count): (f64, f64)| if count > 0.0 { sum / count } else { total / cells };
    sums.into_iter().map(mean).collect()
}

/// Extent of the cell of a point across the interface.
fn extent<const D: usize>(space: &Space<D>, p: &SurfacePoint<D>) -> f64 {
    let mesh = space.mesh();
    let along = |v: &u32| SVector::dot(&mesh.points()[*v as usize], &p.normal);
    let heights = mesh.cell(p.at.cell).iter().map(along);
    let (low, high) =
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    high - low
}
