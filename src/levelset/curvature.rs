//! Curvatures of a level set, at the vertices of the mesh.

use super::bounds::Bounds;
use crate::base::parallel;
use crate::fem::{Derivatives, Recovery, Space};
use crate::mesh::Mesh;
use nalgebra::{SMatrix, SVector};

/// The normal `n = grad phi / |grad phi|` and its gradient: row `i`, column `j` is
/// `d n_i / d x_j = (I - n n^T) D^2 phi / |grad phi|`. `None` where the gradient vanishes.
pub fn normal_gradient<const D: usize>(
    phi: &Derivatives<D>,
) -> Option<(SVector<f64, D>, SMatrix<f64, D, D>)> {
    let slope = phi.gradient.norm();
    if slope <= 0.0 || !slope.is_finite() {
        return None;
    }
    let n = phi.gradient / slope;
    let across = n.transpose() * phi.hessian;
    Some((n, (phi.hessian - n * across) / slope))
}

/// Mean and Gauss curvature of the level lines or surfaces of a function, P1 functions with a value
/// for each vertex of the mesh.
///
/// The mean curvature is `H = div n` (1.9), the sum of the principal curvatures, positive on a
/// sphere; the Gauss curvature is `G = ((tr grad n)^2 - tr (grad n)^2)/2` (1.10), their product in
/// space, zero in the plane. Both come from recovered gradients and Hessians ([`Recovery`]); `phi`
/// need not be a distance. For a P2 level set they are of order 2. Where the gradient vanishes they
/// are 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curvature {
    /// The mean curvature, 1/length.
    pub mean: Vec<f64>,
    /// The Gauss curvature, 1/length^2.
    pub gauss: Vec<f64>,
}

impl Curvature {
    /// The curvatures of the level set `phi` of `space` at the vertices `vertices` of the mesh,
    /// zero at the others; `recovery` is that of its mesh.
    ///
    /// On the interface only the vertices of [`vertices_near`] are needed.
    pub fn new<const D: usize>(
        recovery: &Recovery<D>,
        space: &Space<D>,
        phi: &[f64],
        vertices: &[u32],
    ) -> Curvature {
        let found = recovery.at_points(space, phi, vertices);
        let zero = || vec![0.0; space.mesh().points().len()];
        let mut all = Curvature { mean: zero(), gauss: zero() };
        for (&v, derivatives) in vertices.iter().zip(&found) {
            if let Some((_, gradient)) = normal_gradient(derivatives) {
                (all.mean[v as usize], all.gauss[v as usize]) = invariants(&gradient);
            }
        }
        all
    }
    /// The mean curvature in cell `c` of the mesh at barycentric coordinates `l`.
    pub fn mean_at<const D: usize>(&self, mesh: &Mesh<D>, c: usize, l: &[f64; 4]) -> f64 {
        at(&self.mean, mesh.cell(c), l)
    }
    /// The Gauss curvature in cell `c` of the mesh at barycentric coordinates `l`.
    pub fn gauss_at<const D: usize>(&self, mesh: &Mesh<D>, c: usize, l: &[f64; 4]) -> f64 {
        at(&self.gauss, mesh.cell(c), l)
    }
}

fn at(values: &[f64], vertices: &[u32], l: &[f64; 4]) -> f64 {
    vertices.iter().zip(l).map(|(&v, l)| values[v as usize] * l).sum()
}

/// `H` (1.9) and `G` (1.10) of the gradient of the normal.
fn invariants<const D: usize>(gradient: &SMatrix<f64, D, D>) -> (f64, f64) {
    let mean = gradient.trace();
    (mean, if D == 2 { 0.0 } else { 0.5 * (mean * mean - (gradient * gradient).trace()) })
}

/// The vertices of the cells that meet the band `|phi| < reach` or in whose nodes `phi` changes its
/// sign, ascending; with `reach = 0` those near the interface. `phi` is a function of a P2 space;
/// `reach` is in its units.
pub fn vertices_near<const D: usize>(space: &Space<D>, phi: &[f64], reach: f64) -> Vec<u32> {
    let mesh = space.mesh();
    let mut near = vec![false; mesh.cell_count()];
    parallel::fill(&mut near, 1, |first, part| {
        for (i, near) in part.iter_mut().enumerate() {
            let nodes = space.cell_nodes(first + i);
            let negative = nodes.iter().filter(|&&n| phi[n as usize] < 0.0).count();
            *near = !(negative == 0 || negative == nodes.len())
                || Bounds::of_cell(space, phi, first + i).meet(reach);
        }
    });
    let mut wanted = vec![false; mesh.points().len()];
    let cells = (0..near.len()).filter(|&c| near[c]);
    cells.for_each(|c| mesh.cell(c).iter().for_each(|&v| wanted[v as usize] = true));
    (0..wanted.len() as u32).filter(|&v| wanted[v as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, Point, box_mesh, rectangle};
    use std::sync::Arc;

    /// The curvatures near the interface of a function, and the vertices where they are known.
    fn near<const D: usize>(
        mesh: Mesh<D>,
        f: impl Fn(&Point<D>) -> f64,
    ) -> (Arc<Mesh<D>>, Vec<u32>, Curvature) {
        let mesh = Arc::new(mesh);
        let space = Space::new(&mesh, Element::P2);
        let phi = space.interpolate(f);
        let vertices = vertices_near(&space, &phi, 0.0);
        let curvature = Curvature::new(&Recovery::new(&mesh), &space, &phi, &vertices);
        (mesh, vertices, curvature)
    }

    #[test]
    fn a_quadratic_level_set_has_its_curvatures_exactly() {
        // Quadratic functions are recovered exactly, and their level sets are spheres and circles
        // about the origin.
        let (mesh, vertices, found) =
            near(rectangle([-1.0; 2], [1.0; 2], [9, 8], Diagonals::Right).unwrap(), |x| {
                3.0 * (x.norm_squared() - 0.5)
            });
        for &v in &vertices {
            let r = mesh.points()[v as usize].norm();
            assert!(
                (found.mean[v as usize] * r - 1.0).abs() < 1e-10 && found.gauss[v as usize] == 0.0
            );
        }
        let (mesh, vertices, found) =
            near(box_mesh([-1.0; 3], [1.0; 3], [5, 6, 5]).unwrap(), |x| 0.4 - x.norm_squared());
        for &v in &vertices {
            // Inside out: the normal points to the centre, so that the mean curvature is negative.
            let r = mesh.points()[v as usize].norm();
            assert!(
                (found.mean[v as usize] * r + 2.0).abs() < 1e-9,
                "{}",
                found.mean[v as usize] * r
            );
            assert!((found.gauss[v as usize] * r * r - 1.0).abs() < 1e-9);
        }
        let cell = (0..mesh.cell_count())
            .find(|&c| mesh.cell(c).iter().all(|v| vertices.contains(v)))
            .unwrap();
        let [mean, gauss] = [&found.mean, &found.gauss].map(|f| f[mesh.cell(cell)[2] as usize]);
        let corner = [0.0, 0.0, 1.0, 0.0];
        assert_eq!(
            [found.mean_at(&mesh, cell, &corner), found.gauss_at(&mesh, cell, &corner)],
            [mean, gauss]
        );
    }

    #[test]
    fn vertices_on_both_sides_of_an_interface_along_edges_are_near_it_and_a_function_without_slope_is_flat()
     {
        let (_, vertices, found) =
            near(rectangle([-1.0; 2], [1.0; 2], [4, 4], Diagonals::Right).unwrap(), |x| x[0]);
        assert_eq!(vertices.len(), 10, "the two columns of the cells where phi is negative");
        assert!(found.mean.iter().all(|h| h.abs() < 1e-12));
        let (mesh, ..) =
            near(rectangle([-1.0; 2], [1.0; 2], [4, 4], Diagonals::Right).unwrap(), |_| 1.0);
        let space = Space::new(&mesh, Element::P2);
        assert!(vertices_near(&space, &vec![1.0; space.len()], 0.5).is_empty());
        let flat = Curvature::new(&Recovery::new(&mesh), &space, &vec![0.0; space.len()], &[0, 3]);
        assert!(flat.mean.iter().all(|h| *h == 0.0));
    }
}
