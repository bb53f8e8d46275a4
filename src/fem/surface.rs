//! Weak forms on a surface that cuts through the cells, given by quadrature points.

use super::assembly::At;
use super::element::Element;
use super::points::gradients;
use super::space::Space;
use crate::base::Result;
use crate::linalg::{Factor, Ordering, SymmetricMatrix};
use crate::mesh::NONE;
use nalgebra::{SMatrix, SVector};

/// A quadrature point on a surface: its location in the mesh, its weight (a length; in 3-D an
/// area), and the unit normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint<const D: usize> {
    /// The point; `q` is its number in the list it came in.
    pub at: At<D>,
    /// Unit normal.
    pub normal: SVector<f64, D>,
}

impl<const D: usize> SurfacePoint<D> {
    /// Tangential part: `P a = a - n (n . a)`.
    pub fn tangential(&self, a: &SVector<f64, D>) -> SVector<f64, D> {
        a - self.normal * self.normal.dot(a)
    }
    /// `P = I - n n`.
    pub fn projection(&self) -> SMatrix<f64, D, D> {
        SMatrix::identity() - self.normal * self.normal.transpose()
    }
}

/// Integrands of [`surface_solve`] at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceForm<const D: usize> {
    /// `k >= 0`: the diffusivity.
    pub diffusivity: f64,
    /// `g`: the source.
    pub source: f64,
    /// `f`: the flux; its normal part has no effect.
    pub flux: SVector<f64, D>,
}

/// Finds the P1 function `s` with `int s q + k grad_S s . grad_S q = int g q + f . grad_S q` for
/// all P1 functions `q`, where `int` is the sum over `points` and `grad_S = P grad`; the first term
/// is lumped. One number per vertex; NaN at the vertices of cells that the surface does not cut.
///
/// The lumped mass gives every vertex a local average, so without diffusion this is a filter of
/// second order in the mesh size that reproduces constants, for any position of the surface in its
/// cells.
///
/// # Errors
/// A matrix that cannot be factored.
pub fn surface_solve<const D: usize>(
    space: &Space<D>,
    points: &[SurfacePoint<D>],
    form: impl Fn(&SurfacePoint<D>) -> SurfaceForm<D>,
) -> Result<Vec<f64>> {
    let mesh = space.mesh();
    let cells: Vec<&[SurfacePoint<D>]> = points.chunk_by(|a, b| a.at.cell == b.at.cell).collect();
    let mut number = vec![NONE; mesh.points().len()];
    let mut order = 0;
    for &v in cells.iter().flat_map(|group| mesh.cell(group[0].at.cell)) {
        if number[v as usize] == NONE {
            number[v as usize] = order;
            order += 1;
        }
    }
    let group_of =
        |c: usize| mesh.cell(c).iter().map(|&v| number[v as usize]).collect::<Vec<u32>>();
    let mut out = vec![f64::NAN; number.len()];
    if order == 0 {
        return Ok(out);
    }
    let mut matrix =
        SymmetricMatrix::from_groups(order as usize, cells.iter().map(|g| group_of(g[0].at.cell)))?;
    let (m, mut rhs) = (D + 1, vec![0.0; order as usize]);
    for cell in &cells {
        let unknowns = group_of(cell[0].at.cell);
        let mut local = vec![0.0; m * m];
        for point in *cell {
            let (at, form) = (&point.at, form(point));
            let g = gradients(space, Element::P1, at).map(|g| point.tangential(&g));
            for a in 0..m {
                // A point that was moved onto the surface may lie slightly outside of its cell.
                let share = at.weight * at.barycentric[a].max(SMALLEST_SHARE);
                local[a * m + a] += share;
                rhs[unknowns[a] as usize] += share * form.source + at.weight * form.flux.dot(&g[a]);
                (0..m).for_each(|b| {
                    local[a * m + b] += at.weight * form.diffusivity * g[a].dot(&g[b])
                });
            }
        }
        matrix.add_group(&unknowns, &local)?;
    }
    let mut factor = Factor::analyse(&matrix, Ordering::plain(&matrix)?)?;
    factor.refactor(&matrix)?;
    let mut x = vec![0.0; order as usize];
    factor.solve(&matrix, &rhs, &mut x)?;
    for (out, &k) in out.iter_mut().zip(&number).filter(|(_, k)| **k != NONE) {
        *out = x[k as usize];
    }
    Ok(out)
}

/// Least weight of a point for each vertex of its cell, so that every vertex has a positive mass.
const SMALLEST_SHARE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, Point, rectangle};
    use std::f64::consts::PI;
    use std::sync::Arc;

    /// Gauss points on the horizontal line `y = height` through the unit square, cell by cell.
    fn line(space: &Space<2>, height: f64) -> Vec<SurfacePoint<2>> {
        let mesh = space.mesh();
        let mut points = Vec::new();
        for c in 0..mesh.cell_count() {
            let corners: Vec<Point<2>> =
                mesh.cell(c).iter().map(|&v| mesh.points()[v as usize]).collect();
            let mut ends: Vec<f64> = (0..3)
                .filter_map(|k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    ((a[1] < height) != (b[1] < height))
                        .then(|| a[0] + (b[0] - a[0]) * (height - a[1]) / (b[1] - a[1]))
                })
                .collect();
            ends.sort_by(f64::total_cmp);
            let [from, to] = ends[..] else { continue };
            for (t, w) in crate::fem::gauss_legendre(3) {
                let x = Point::<2>::new(from + t * (to - from), height);
                let l = mesh.map(c).inverse * (x - corners[0]);
                let at = At {
                    cell: c,
                    q: points.len(),
                    barycentric: [1.0 - l[0] - l[1], l[0], l[1], 0.0],
                    x,
                    weight: w * (to - from),
                };
                points.push(SurfacePoint { at, normal: Point::<2>::new(0.0, 1.0) });
            }
        }
        points
    }
    fn space(n: usize) -> Space<2> {
        Space::new(
            &Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [n, n], Diagonals::UnionJack).unwrap()),
            Element::P2,
        )
    }

    /// `s - k s'' = (1 + k pi^2) cos(pi x)` has the solution `cos(pi x)`; half of the right-hand
    /// side comes as a flux.
    #[test]
    fn diffusion_along_a_line_is_solved_to_second_order() {
        let k = 0.05;
        let error = |n: usize| {
            let space = space(n);
            let points = line(&space, 0.437);
            let form = |p: &SurfacePoint<2>| SurfaceForm {
                diffusivity: k,
                source: (PI * p.at.x[0]).cos(),
                flux: Point::<2>::new(-k * PI * (PI * p.at.x[0]).sin(), 7.0),
            };
            let s = surface_solve(&space, &points, form).unwrap();
            let at = |p: &SurfacePoint<2>| {
                let cell = space.mesh().cell(p.at.cell).iter().zip(p.at.barycentric);
                cell.map(|(&v, l)| l * s[v as usize]).sum::<f64>()
            };
            let square =
                |p: &SurfacePoint<2>| p.at.weight * (at(p) - (PI * p.at.x[0]).cos()).powi(2);
            points.iter().map(square).sum::<f64>().sqrt()
        };
        let errors = [8, 16, 32].map(error);
        assert!(errors[2] < 4e-3, "{errors:?}");
        assert!(errors[0] / errors[2] > 10.0, "{errors:?}");
    }

    #[test]
    fn a_constant_stays_what_it_is_however_little_of_a_cell_is_cut() {
        let space = space(10);
        for height in [0.25, 0.3 + 1e-9, 0.3 - 1e-13] {
            let points = line(&space, height);
            let form = |_: &SurfacePoint<2>| SurfaceForm {
                diffusivity: 0.7,
                source: 3.0,
                flux: SVector::zeros(),
            };
            let s = surface_solve(&space, &points, form).unwrap();
            let cut: Vec<f64> = s.into_iter().filter(|s| s.is_finite()).collect();
            assert!(cut.len() >= 11 && cut.iter().all(|s| (s - 3.0).abs() < 1e-9), "{cut:?}");
        }
    }
}
