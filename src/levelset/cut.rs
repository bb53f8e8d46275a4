//! The interface as quadrature points, ready for weak forms on it.

use super::contour::Contour;
use crate::base::Result;
use crate::fem::{At, Space, SurfacePoint};

/// Quadrature points on `phi = 0`, lifted onto the zero set of the P2 function, in the order of their cells, with the normals of the
/// contour, out of `phi < 0`. They are numbered by `at.q`.
///
/// # Errors
/// Those of [`Contour::new`].
pub fn surface(space: &Space<2>, phi: &[f64]) -> Result<Vec<SurfacePoint<2>>> {
    let mut points = Contour::new(space, phi)?.quadrature(space, phi);
    // A zero that is almost a node leaves pieces without length, hence without a normal.
    points.retain(|p| p.weight > 0.0 && p.normal.norm().is_finite());
    points.sort_by_key(|p| p.cell);
    let numbered = points.into_iter().enumerate();
    Ok(numbered
        .map(|(q, p)| {
            let at = At { cell: p.cell as usize, q, barycentric: p.barycentric, x: p.point, weight: p.weight };
            SurfacePoint { at, normal: p.normal }
        })
        .collect())
}
