//! Weak forms summed over given points in the cells: surfaces that cut the mesh, single points.

use super::assembly::{At, VectorForm};
use super::element::{Element, MAX_LOCAL};
use super::numbering::Numbering;
use super::space::Space;
use crate::base::Result;
use crate::linalg::SymmetricMatrix;
use nalgebra::{SMatrix, SVector};

/// Gradients of the local basis functions of an element at a point.
pub(super) fn gradients<const D: usize>(
    space: &Space<D>,
    element: Element,
    at: &At<D>,
) -> [SVector<f64, D>; MAX_LOCAL] {
    let inverse = &space.mesh().map(at.cell).inverse;
    element.reference_gradients::<D>(&at.barycentric).map(|g| inverse.tr_mul(&g))
}

/// Adds the linear form `f(point) = (f0, f1)`, that is `f0 . v + f1 : grad v`, summed over `points`
/// with their weights, to `out` (one vector per node).
pub fn add_point_vector<const D: usize>(
    space: &Space<D>,
    points: &[At<D>],
    out: &mut [SVector<f64, D>],
    f: impl Fn(&At<D>) -> VectorForm<D>,
) {
    for at in points {
        let n = space.element().values::<D>(&at.barycentric);
        let g = gradients(space, space.element(), at);
        let (f0, f1) = f(at);
        for (a, &node) in space.cell_nodes(at.cell).iter().enumerate() {
            out[node as usize] += (f0 * n[a] + f1 * g[a]) * at.weight;
        }
    }
}

/// Adds a symmetric form, summed over `points` (those of a cell one after the other), to the
/// velocity block of `matrix`. `f(point, u, grad u)` gives the pair tested with `(v, grad v)`.
///
/// # Errors
/// A cell whose unknowns the matrix does not couple.
pub fn add_point_matrix<const D: usize>(
    space: &Space<D>,
    numbering: &Numbering<D>,
    points: &[At<D>],
    matrix: &mut SymmetricMatrix,
    f: impl Fn(&At<D>, &SVector<f64, D>, &SMatrix<f64, D, D>) -> VectorForm<D>,
) -> Result<()> {
    let nb = space.local_count();
    let m = D * nb;
    let (mut local, mut unknowns) = (vec![0.0; m * m], Vec::with_capacity(m));
    for group in points.chunk_by(|a, b| a.cell == b.cell) {
        local.fill(0.0);
        for at in group {
            let n = space.element().values::<D>(&at.barycentric);
            let g = gradients(space, space.element(), at);
            for (b, j) in (0..nb).flat_map(|b| (0..D).map(move |j| (b, j))) {
                let mut u = SVector::<f64, D>::zeros();
                u[j] = n[b];
                let mut grad = SMatrix::<f64, D, D>::zeros();
                grad.set_row(j, &g[b].transpose());
                let (f0, f1) = f(at, &u, &grad);
                let (f0, f1) = (f0 * at.weight, f1 * at.weight);
                for a in 0..nb {
                    let v = f0 * n[a] + f1 * g[a];
                    (0..D).for_each(|i| local[(D * a + i) * m + D * b + j] += v[i]);
                }
            }
        }
        let nodes = space.cell_nodes(group[0].cell);
        numbering.rotate_local(nodes, m, &mut local);
        numbering.cell_unknowns(nodes, None, &mut unknowns);
        matrix.add_group(&unknowns, &local)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Condition, Conditions};
    use crate::mesh::{Diagonals, Point, rectangle};
    use std::sync::Arc;

    fn space(n: usize) -> Space<2> {
        let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [n, n], Diagonals::UnionJack).unwrap();
        Space::new(&Arc::new(mesh), Element::P2)
    }
    /// Two points in each of some cells, with weights.
    fn points(space: &Space<2>) -> Vec<At<2>> {
        let mut points = Vec::new();
        for cell in [3, 17, 30] {
            for l in [[0.2, 0.5, 0.3, 0.0], [0.6, 0.1, 0.3, 0.0]] {
                let corners =
                    space.mesh().cell(cell).iter().map(|&v| space.mesh().points()[v as usize]);
                let x = corners.zip(l).fold(Point::<2>::zeros(), |s, (x, l)| s + x * l);
                let weight = 0.3 + 0.1 * points.len() as f64;
                points.push(At { cell, q: points.len(), barycentric: l, x, weight });
            }
        }
        points
    }

    /// `(x, 0) . v + I : grad v` for `v = (x^2, y)`, exact in P2.
    #[test]
    fn vectors_sum_what_the_form_says() {
        let space = space(6);
        let points = points(&space);
        let mut out = vec![SVector::<f64, 2>::zeros(); space.len()];
        let form = |at: &At<2>| (Point::<2>::new(at.x[0], 0.0), SMatrix::identity());
        add_point_vector(&space, &points, &mut out, form);
        let v = space.interpolate(|x| Point::<2>::new(x[0] * x[0], x[1]));
        let sum: f64 = out.iter().zip(&v).map(|(f, v)| f.dot(v)).sum();
        let exact: f64 =
            points.iter().map(|p| p.weight * (p.x[0].powi(3) + 2.0 * p.x[0] + 1.0)).sum();
        assert!((sum - exact).abs() < 1e-13, "{sum} {exact}");
    }

    /// The matrix and the vector of the same form agree: `F(v) = C(u, v)` for all `v`.
    #[test]
    fn a_matrix_times_a_velocity_is_the_vector_of_the_form() {
        let space = space(6);
        let pressure = Space::new(space.mesh(), Element::P1);
        let mesh = space.mesh();
        let all = (0..mesh.facets().len() as u32).collect();
        let mut named = (**mesh).clone();
        named.set_boundary("walls", all);
        let conditions: Conditions<2> = vec![("walls".into(), Condition::Open)];
        let space = Space::new(&Arc::new(named), Element::P2);
        let numbering = Numbering::new(&space, &pressure, &conditions).unwrap();
        let groups = (0..space.mesh().cell_count()).map(|c| {
            let mut list = Vec::new();
            numbering.cell_unknowns(space.cell_nodes(c), None, &mut list);
            list
        });
        let mut matrix = SymmetricMatrix::from_groups(numbering.order(), groups).unwrap();
        let points = points(&space);
        let form = |_: &At<2>, u: &SVector<f64, 2>, grad: &SMatrix<f64, 2, 2>| {
            (u * 3.0, (grad + grad.transpose()) * 0.5)
        };
        add_point_matrix(&space, &numbering, &points, &mut matrix, form).unwrap();
        let u =
            space.interpolate(|x| Point::<2>::new((3.0 * x[0]).sin() * x[1], x[0] - x[1] * x[1]));
        let mut expected = vec![SVector::<f64, 2>::zeros(); space.len()];
        add_point_vector(&space, &points, &mut expected, |at| {
            let l = &at.barycentric;
            form(at, &space.value(&u, at.cell, l), &space.jacobian(&u, at.cell, l))
        });
        let no_pressure = vec![0.0; pressure.len()];
        let zero = vec![SVector::<f64, 2>::zeros(); space.len()];
        let (mut x, mut rhs) = (vec![0.0; numbering.order()], vec![0.0; numbering.order()]);
        numbering.restrict(&u, &no_pressure, &zero, &mut x);
        numbering.gather(&expected, &no_pressure, &mut rhs);
        let mut product = vec![0.0; numbering.order()];
        matrix.multiply(&x, &mut product);
        let error = product.iter().zip(&rhs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(error < 1e-13 && rhs.iter().any(|v| v.abs() > 0.1), "{error}");
    }
}
