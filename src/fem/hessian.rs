//! Second derivatives of quadratic functions, recovered at the points of the mesh.

use super::element::Element;
use super::space::Space;
use crate::base::parallel;
use crate::mesh::{Mesh, Point};
use nalgebra::{SMatrix, SVector};

/// Terms of a cubic polynomial in the plane.
const TERMS: usize = 10;
/// Nodes that the fit of a cubic wants at least; with fewer the next ring of cells is taken too.
const ENOUGH: usize = 16;
/// Most rings of cells around a point.
const RINGS: usize = 3;

/// Hessians of a scalar function at the points of its mesh: the cubic that fits best, in the mean over the nodes of the cells around a
/// point, is differentiated there (polynomial-preserving recovery, Zhang and Naga 2005, with cubics).
///
/// Exact for the interpolants of cubics; of order two for smooth functions, with a larger error on the boundary. The nodes are first brought
/// into isotropic position by their second moments, so that stretched cells lose nothing. On a mesh with too few nodes, and at
/// points of no cell, the mean of the cells' own second derivatives (or zero) is given.
pub fn hessians(space: &Space<2>, field: &[f64]) -> Vec<SMatrix<f64, 2, 2>> {
    let mesh = space.mesh();
    let around = cells_around(mesh);
    let mut out = vec![SMatrix::zeros(); mesh.points().len()];
    parallel::fill(&mut out, 1, |first, part| {
        let mut patch = Patch::default();
        for (i, hessian) in part.iter_mut().enumerate() {
            *hessian = at_point(space, field, &around, first + i, &mut patch);
        }
    });
    out
}

/// Cells and nodes around a point.
#[derive(Default)]
struct Patch {
    cells: Vec<u32>,
    nodes: Vec<u32>,
}

impl Patch {
    /// The cells of the point, then those that share a point with them, `rings` times, and their nodes.
    fn gather(&mut self, space: &Space<2>, around: &[Vec<u32>], point: usize, rings: usize) {
        self.cells.clear();
        self.cells.extend_from_slice(&around[point]);
        for _ in 1..rings {
            let inner = self.cells.len();
            for i in 0..inner {
                let vertices = space.mesh().cell(self.cells[i] as usize);
                vertices.iter().for_each(|&v| self.cells.extend_from_slice(&around[v as usize]));
            }
            self.cells.sort_unstable();
            self.cells.dedup();
        }
        self.nodes.clear();
        self.cells.iter().for_each(|&c| self.nodes.extend_from_slice(space.cell_nodes(c as usize)));
        self.nodes.sort_unstable();
        self.nodes.dedup();
    }
}

fn at_point(
    space: &Space<2>,
    field: &[f64],
    around: &[Vec<u32>],
    point: usize,
    patch: &mut Patch,
) -> SMatrix<f64, 2, 2> {
    let centre = space.mesh().points()[point];
    for rings in 1..=RINGS {
        patch.gather(space, around, point, rings);
        if patch.nodes.len() >= ENOUGH
            && let Some(hessian) = fit(space, field, &patch.nodes, &centre)
        {
            return hessian;
        }
    }
    let volume: f64 = patch.cells.iter().map(|&c| space.mesh().map(c as usize).volume).sum();
    let weighted = |&c: &u32| of_cell(space, field, c as usize) * (space.mesh().map(c as usize).volume / volume);
    patch.cells.iter().map(weighted).sum()
}

/// The Hessian at `centre` of the cubic that fits the nodes best; `None` if they do not determine it.
fn fit(space: &Space<2>, field: &[f64], nodes: &[u32], centre: &Point<2>) -> Option<SMatrix<f64, 2, 2>> {
    let offset = |&n: &u32| space.nodes()[n as usize] - centre;
    let moments: SMatrix<f64, 2, 2> = nodes.iter().map(offset).map(|d| d * d.transpose()).sum();
    let to_unit = (moments / nodes.len() as f64).cholesky()?.l().try_inverse()?;
    let mut matrix = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut rhs = SVector::<f64, TERMS>::zeros();
    for n in nodes {
        let x = to_unit * offset(n);
        let terms = monomials(x[0], x[1]);
        // Near nodes count more: the polynomial is wanted at the centre.
        let weight = 1.0 / (0.2 + x.norm_squared());
        matrix += terms * (terms.transpose() * weight);
        rhs += terms * (field[*n as usize] * weight);
    }
    let smallest = 1e-10 * matrix.diagonal().max();
    let factor = matrix.cholesky()?;
    if factor.l_dirty().diagonal().iter().any(|d| d * d < smallest) {
        return None;
    }
    let c = factor.solve(&rhs);
    let hessian = SMatrix::<f64, 2, 2>::new(2.0 * c[3], c[4], c[4], 2.0 * c[5]);
    Some(to_unit.transpose() * hessian * to_unit)
}

fn monomials(x: f64, y: f64) -> SVector<f64, TERMS> {
    SVector::from([1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y])
}

/// The constant Hessian of a quadratic function in a cell; zero for a linear one.
fn of_cell(space: &Space<2>, field: &[f64], c: usize) -> SMatrix<f64, 2, 2> {
    if space.element() == Element::P1 {
        return SMatrix::zeros();
    }
    let middle = space.gradient(field, c, &[1.0, 0.0, 0.0, 0.0]);
    // The gradient is linear: its slopes along the free barycentric coordinates.
    let slopes = [[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]].map(|l| space.gradient(field, c, &l) - middle);
    let hessian = SMatrix::<f64, 2, 2>::from_columns(&slopes) * space.mesh().map(c).inverse;
    (hessian + hessian.transpose()) * 0.5
}

fn cells_around(mesh: &Mesh<2>) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); mesh.points().len()];
    for c in 0..mesh.cell_count() {
        mesh.cell(c).iter().for_each(|&v| around[v as usize].push(c as u32));
    }
    around
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::adapt::{AdaptOptions, Metric, adapt};
    use crate::mesh::{Diagonals, rectangle};
    use std::sync::Arc;

    fn irregular(n: usize) -> Arc<Mesh<2>> {
        let mesh = rectangle([0.0; 2], [1.0; 2], [n, n], Diagonals::Right).unwrap();
        let sizes: Vec<f64> = mesh.points().iter().map(|x| (1.0 + x[0]) / n as f64).collect();
        Arc::new(adapt(&mesh, &Metric::isotropic(&sizes), &AdaptOptions::default()).unwrap().mesh)
    }

    /// Largest error at the points of the mesh, and the mean.
    fn error(
        mesh: &Arc<Mesh<2>>,
        f: impl Fn(&Point<2>) -> f64,
        exact: impl Fn(&Point<2>) -> SMatrix<f64, 2, 2>,
    ) -> [f64; 2] {
        let space = Space::new(mesh, Element::P2);
        let found = hessians(&space, &space.interpolate(f));
        let errors: Vec<f64> = found.iter().zip(mesh.points()).map(|(h, x)| (h - exact(x)).norm()).collect();
        [errors.iter().copied().fold(0.0, f64::max), errors.iter().sum::<f64>() / errors.len() as f64]
    }

    #[test]
    fn cubics_have_their_hessians_also_on_stretched_cells_and_at_corners() {
        let f = |x: &Point<2>| x[0].powi(3) - 2.0 * x[0] * x[0] * x[1] + x[1].powi(3) + x[0] * x[1] - 1.0;
        let exact = |x: &Point<2>| {
            let xy = 1.0 - 4.0 * x[0];
            SMatrix::<f64, 2, 2>::new(6.0 * x[0] - 4.0 * x[1], xy, xy, 6.0 * x[1])
        };
        assert!(error(&irregular(6), f, exact)[0] < 1e-9);
        let stretched = rectangle([0.0; 2], [1.0, 0.01], [6, 6], Diagonals::Right).unwrap();
        assert!(error(&Arc::new(stretched), f, exact)[0] < 1e-6);
    }

    #[test]
    fn smooth_functions_are_recovered_with_order_two_up_to_the_boundary() {
        let f = |x: &Point<2>| (3.0 * x[0]).sin() * x[1].exp();
        let exact = |x: &Point<2>| {
            let (s, c) = (3.0 * x[0]).sin_cos();
            SMatrix::<f64, 2, 2>::new(-9.0 * s, 3.0 * c, 3.0 * c, s) * x[1].exp()
        };
        let errors = [10, 20, 40].map(|n| error(&irregular(n), f, exact));
        let order = |kind: usize| (errors[0][kind] / errors[2][kind]).log2() / 2.0;
        assert!(order(0) > 1.4 && order(1) > 1.9, "{errors:?}");
        assert!(errors[2][0] < 0.3 && errors[2][1] < 0.013, "{errors:?}");
    }

    #[test]
    fn a_mesh_of_two_triangles_gives_the_hessian_of_a_quadratic() {
        let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [1, 1], Diagonals::Right).unwrap());
        let f = |x: &Point<2>| x[0] * x[0] - 3.0 * x[0] * x[1];
        assert!(error(&mesh, f, |_| SMatrix::<f64, 2, 2>::new(2.0, -3.0, -3.0, 0.0))[0] < 1e-12);
    }
}
