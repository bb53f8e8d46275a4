//! Derivatives of finite-element functions, recovered at the points of the mesh by fitting cubics.

use super::element::Element;
use super::space::Space;
use crate::base::parallel;
use crate::mesh::{Mesh, NONE, Point};
use nalgebra::{SMatrix, SVector};

/// Number of terms of a cubic polynomial in the plane and in space.
const TERMS: [usize; 2] = [10, 20];
/// Least number of nodes for the fit of a cubic, in the plane and in space; with fewer the next
/// layer of cells is added.
const ENOUGH: [usize; 2] = [16, 32];
/// Largest number of layers of cells around a point.
const RINGS: usize = 3;

/// The derivatives of a function at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Derivatives<const D: usize> {
    /// The gradient.
    pub gradient: SVector<f64, D>,
    /// The second derivatives, symmetric.
    pub hessian: SMatrix<f64, D, D>,
    /// The third derivatives: `third[k]` is the derivative of the Hessian along `x_k`.
    pub third: [SMatrix<f64, D, D>; D],
}

impl<const D: usize> Derivatives<D> {
    /// The derivatives of a constant.
    pub const fn zero() -> Derivatives<D> {
        let hessian = SMatrix::from_array_storage(nalgebra::ArrayStorage([[0.0; D]; D]));
        let gradient = SVector::from_array_storage(nalgebra::ArrayStorage([[0.0; D]; 1]));
        Derivatives { gradient, hessian, third: [hessian; D] }
    }
    /// The third derivative along `a` and `b`, a vector.
    pub fn third_along(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> SVector<f64, D> {
        SVector::from_fn(|k, _| a.dot(&(self.third[k] * b)))
    }
    /// The derivatives of the same cubic function at a point shifted by `step`.
    pub fn moved(&self, step: &SVector<f64, D>) -> Derivatives<D> {
        let mut hessian = self.hessian;
        (0..D).for_each(|k| hessian += self.third[k] * step[k]);
        let gradient = self.gradient + (self.hessian + hessian) * step * 0.5;
        Derivatives { gradient, hessian, third: self.third }
    }
    /// `self + other * weight`.
    pub fn plus(mut self, other: &Derivatives<D>, weight: f64) -> Derivatives<D> {
        self.gradient += other.gradient * weight;
        self.hessian += other.hessian * weight;
        (0..D).for_each(|k| self.third[k] += other.third[k] * weight);
        self
    }
}

/// Recovery of derivatives at the points of a mesh (polynomial-preserving recovery, Zhang and Naga
/// 2005, with cubics): derivatives of the cubic that is the least-squares fit to the nodes of the
/// cells around a point.
///
/// Exact for the interpolants of cubics; for smooth functions gradients are of order three,
/// Hessians of order two, third derivatives of order one (two for nodes symmetric about the point),
/// with larger errors on the boundary. The nodes are first scaled to isotropic second moments, so
/// that stretched cells lose no accuracy. On a mesh with too few nodes, and at points of no cell,
/// the result is the mean of the derivatives of the cells (or zero).
///
/// Stores data of the mesh only: the cells around each point.
#[derive(Clone, Debug)]
pub struct Recovery<const D: usize> {
    /// Index of the first cell of a point in `cells`.
    start: Vec<u32>,
    cells: Vec<u32>,
}

impl<const D: usize> Recovery<D> {
    /// The recovery on a mesh.
    pub fn new(mesh: &Mesh<D>) -> Recovery<D> {
        let mut start = vec![0; mesh.points().len() + 1];
        let vertices = || {
            (0..mesh.cell_count())
                .flat_map(|c| mesh.cell(c).iter().map(move |&v| (v as usize, c as u32)))
        };
        vertices().for_each(|(v, _)| start[v + 1] += 1);
        (1..start.len()).for_each(|v| start[v] += start[v - 1]);
        let (mut next, mut cells) = (start.clone(), vec![0; (D + 1) * mesh.cell_count()]);
        for (v, c) in vertices() {
            cells[next[v] as usize] = c;
            next[v] += 1;
        }
        Recovery { start, cells }
    }
    /// The cells around a point of the mesh, ascending.
    pub fn around(&self, point: usize) -> &[u32] {
        &self.cells[self.start[point] as usize..self.start[point + 1] as usize]
    }
    /// The derivatives of the function `field` of `space`, P1 or P2 on the mesh of this recovery,
    /// at the points of the mesh numbered `points`, in their order.
    pub fn at_points(
        &self,
        space: &Space<D>,
        field: &[f64],
        points: &[u32],
    ) -> Vec<Derivatives<D>> {
        let mut out = vec![Derivatives::zero(); points.len()];
        parallel::fill(&mut out, 1, |first, part| {
            let mut patch = Patch::default();
            for (i, found) in part.iter_mut().enumerate() {
                *found = at_point(space, field, self, points[first + i] as usize, &mut patch);
            }
        });
        out
    }
}

/// Recovered derivatives at some vertices of the mesh, evaluated in the cells whose vertices are
/// all among them.
#[derive(Clone, Debug)]
pub struct Recovered<const D: usize> {
    /// Position of a vertex in `known`; [`NONE`] for the others.
    slot: Vec<u32>,
    known: Vec<Derivatives<D>>,
}

impl<const D: usize> Recovered<D> {
    /// The derivatives of the function `field` of `space` at `vertices`; `recovery` is that of its
    /// mesh.
    pub fn new(
        recovery: &Recovery<D>,
        space: &Space<D>,
        field: &[f64],
        vertices: &[u32],
    ) -> Recovered<D> {
        let mut slot = vec![NONE; space.mesh().points().len()];
        vertices.iter().zip(0..).for_each(|(&v, k)| slot[v as usize] = k);
        Recovered { slot, known: recovery.at_points(space, field, vertices) }
    }
    /// The derivatives at a vertex; zero at a vertex that was not given.
    pub fn at_vertex(&self, v: u32) -> Derivatives<D> {
        self.known.get(self.slot[v as usize] as usize).copied().unwrap_or(Derivatives::zero())
    }
    /// The derivatives in cell `c` at barycentric coordinates `l`: the mean, with the weights `l`,
    /// of the cubics of its vertices evaluated there. Continuous across the sides of cells.
    pub fn in_cell(&self, mesh: &Mesh<D>, c: usize, l: &[f64; 4]) -> Derivatives<D> {
        let cell = mesh.cell(c);
        let point = |k: usize| mesh.points()[cell[k] as usize];
        let x = (0..=D).fold(Point::<D>::zeros(), |x, k| x + point(k) * l[k]);
        let add = |sum: Derivatives<D>, k: usize| {
            sum.plus(&self.at_vertex(cell[k]).moved(&(x - point(k))), l[k])
        };
        (0..=D).fold(Derivatives::zero(), add)
    }
}

/// Hessians of a scalar function at all points of its mesh, by [`Recovery`].
pub fn hessians<const D: usize>(space: &Space<D>, field: &[f64]) -> Vec<SMatrix<f64, D, D>> {
    let points: Vec<u32> = (0..space.mesh().points().len() as u32).collect();
    let found = Recovery::new(space.mesh()).at_points(space, field, &points);
    found.iter().map(|d| d.hessian).collect()
}

/// Cells and nodes around a point.
#[derive(Default)]
struct Patch {
    cells: Vec<u32>,
    nodes: Vec<u32>,
}

impl Patch {
    /// The cells of the point, those that share a point with them (`rings` times), and their nodes.
    fn gather<const D: usize>(
        &mut self,
        space: &Space<D>,
        around: &Recovery<D>,
        point: usize,
        rings: usize,
    ) {
        self.cells.clear();
        self.cells.extend_from_slice(around.around(point));
        for _ in 1..rings {
            let inner = self.cells.len();
            for i in 0..inner {
                let vertices = space.mesh().cell(self.cells[i] as usize);
                vertices
                    .iter()
                    .for_each(|&v| self.cells.extend_from_slice(around.around(v as usize)));
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

fn at_point<const D: usize>(
    space: &Space<D>,
    field: &[f64],
    around: &Recovery<D>,
    point: usize,
    patch: &mut Patch,
) -> Derivatives<D> {
    let centre = space.mesh().points()[point];
    for rings in 1..=RINGS {
        patch.gather(space, around, point, rings);
        if patch.nodes.len() < ENOUGH[D - 2] {
            continue;
        }
        let found = match D {
            2 => fit::<D, { TERMS[0] }>(space, field, &patch.nodes, &centre),
            _ => fit::<D, { TERMS[1] }>(space, field, &patch.nodes, &centre),
        };
        if let Some(derivatives) = found {
            return derivatives;
        }
    }
    let volume: f64 = patch.cells.iter().map(|&c| space.mesh().map(c as usize).volume).sum();
    patch.cells.iter().fold(Derivatives::zero(), |sum, &c| {
        let c = c as usize;
        sum.plus(&of_cell(space, field, c, &centre), space.mesh().map(c).volume / volume)
    })
}

/// The derivatives at `centre` of the cubic with `T` terms that fits the nodes best; `None` if they
/// do not determine it.
fn fit<const D: usize, const T: usize>(
    space: &Space<D>,
    field: &[f64],
    nodes: &[u32],
    centre: &Point<D>,
) -> Option<Derivatives<D>> {
    let offset = |&n: &u32| space.nodes()[n as usize] - centre;
    let moments: SMatrix<f64, D, D> = nodes.iter().map(offset).map(|d| d * d.transpose()).sum();
    let to_unit = (moments / nodes.len() as f64).cholesky()?.l().try_inverse()?;
    let mut matrix = SMatrix::<f64, T, T>::zeros();
    let mut rhs = SVector::<f64, T>::zeros();
    for n in nodes {
        let x = to_unit * offset(n);
        let terms = monomials::<D, T>(&x);
        // Near nodes have larger weights: the polynomial is evaluated at the centre.
        let weight = 1.0 / (0.2 + x.norm_squared());
        matrix += terms * (terms.transpose() * weight);
        rhs += terms * (field[*n as usize] * weight);
    }
    let smallest = 1e-10 * matrix.diagonal().max();
    let factor = matrix.cholesky()?;
    if factor.l_dirty().diagonal().iter().any(|d| d * d < smallest) {
        return None;
    }
    let unit = differentiated::<D, T>(&factor.solve(&rhs));
    let turned = unit.third.map(|m| to_unit.transpose() * m * to_unit);
    let third = std::array::from_fn(|k| {
        (0..D).fold(SMatrix::<f64, D, D>::zeros(), |sum, i| sum + turned[i] * to_unit[(i, k)])
    });
    let gradient = to_unit.tr_mul(&unit.gradient);
    Some(Derivatives { gradient, hessian: to_unit.transpose() * unit.hessian * to_unit, third })
}

/// The terms `1, x_i, x_i x_j, x_i x_j x_k` with `i <= j <= k`, in lexicographic order.
fn monomials<const D: usize, const T: usize>(x: &SVector<f64, D>) -> SVector<f64, T> {
    let mut terms = SVector::<f64, T>::zeros();
    let (mut quadratic, mut cubic) = (1 + D, 1 + D + D * (D + 1) / 2);
    terms[0] = 1.0;
    for i in 0..D {
        terms[1 + i] = x[i];
        for j in i..D {
            let product = x[i] * x[j];
            terms[quadratic] = product;
            quadratic += 1;
            for k in j..D {
                terms[cubic] = product * x[k];
                cubic += 1;
            }
        }
    }
    terms
}

/// The derivatives at the origin of the polynomial with the coefficients `c` for [`monomials`].
fn differentiated<const D: usize, const T: usize>(c: &SVector<f64, T>) -> Derivatives<D> {
    let mut out = Derivatives::zero();
    let (mut quadratic, mut cubic) = (1 + D, 1 + D + D * (D + 1) / 2);
    for i in 0..D {
        out.gradient[i] = c[1 + i];
        for j in i..D {
            let second = if i == j { 2.0 * c[quadratic] } else { c[quadratic] };
            (out.hessian[(i, j)], out.hessian[(j, i)]) = (second, second);
            quadratic += 1;
            for k in j..D {
                let equal = usize::from(i == j) + usize::from(j == k);
                let value = [1.0, 2.0, 6.0][equal] * c[cubic];
                for [a, b, d] in [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]]
                {
                    out.third[a][(b, d)] = value;
                }
                cubic += 1;
            }
        }
    }
    out
}

/// The derivatives of a function at `x` in its cell `c`; second ones of a linear function are zero,
/// as all third ones.
fn of_cell<const D: usize>(
    space: &Space<D>,
    field: &[f64],
    c: usize,
    x: &Point<D>,
) -> Derivatives<D> {
    let map = space.mesh().map(c);
    let gradient = space.gradient(field, c, &map.barycentric(x));
    if space.element() == Element::P1 {
        return Derivatives { gradient, ..Derivatives::zero() };
    }
    let corner = |k: usize| space.gradient(field, c, &space.element().node(k, D));
    let first = corner(0);
    // The gradient is linear: its slopes along the free barycentric coordinates.
    let mut slopes = SMatrix::<f64, D, D>::zeros();
    (0..D).for_each(|k| slopes.set_column(k, &(corner(k + 1) - first)));
    let hessian = slopes * map.inverse;
    Derivatives { gradient, hessian: (hessian + hessian.transpose()) * 0.5, ..Derivatives::zero() }
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
        let errors: Vec<f64> =
            found.iter().zip(mesh.points()).map(|(h, x)| (h - exact(x)).norm()).collect();
        [
            errors.iter().copied().fold(0.0, f64::max),
            errors.iter().sum::<f64>() / errors.len() as f64,
        ]
    }

    #[test]
    fn cubics_have_their_hessians_also_on_stretched_cells_and_at_corners() {
        let f = |x: &Point<2>| {
            x[0].powi(3) - 2.0 * x[0] * x[0] * x[1] + x[1].powi(3) + x[0] * x[1] - 1.0
        };
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

    #[test]
    fn in_space_cubics_have_all_their_derivatives_and_those_at_another_point() {
        let f = |x: &Point<3>| {
            x[0].powi(3) - 2.0 * x[0] * x[1] * x[2] + x[1] * x[2] * x[2] + 3.0 * x[0] * x[2] - x[1]
        };
        let gradient = |x: &Point<3>| {
            let [x, y, z] = [x[0], x[1], x[2]];
            Point::<3>::new(
                3.0 * x * x - 2.0 * y * z + 3.0 * z,
                z * z - 2.0 * x * z - 1.0,
                2.0 * y * z - 2.0 * x * y + 3.0 * x,
            )
        };
        let mesh = Arc::new(crate::mesh::box_mesh([0.0; 3], [1.0, 1.2, 0.9], [3, 2, 3]).unwrap());
        let space = Space::new(&mesh, Element::P2);
        let (phi, points) =
            (space.interpolate(f), (0..mesh.points().len() as u32).collect::<Vec<_>>());
        let found = Recovery::new(&mesh).at_points(&space, &phi, &points);
        let step = Point::<3>::new(0.1, -0.3, 0.2);
        for (d, x) in found.iter().zip(mesh.points()) {
            let moved = d.moved(&step);
            assert!(
                (d.gradient - gradient(x)).norm() < 1e-9
                    && (moved.gradient - gradient(&(x + step))).norm() < 1e-8
            );
            assert!(
                (d.hessian[(0, 1)] + 2.0 * x[2]).abs() < 1e-8
                    && (moved.hessian[(2, 2)] - 2.0 * (x[1] + step[1])).abs() < 1e-8
            );
            assert!(
                (d.third[0][(0, 0)] - 6.0).abs() < 1e-7 && (d.third[2][(0, 1)] + 2.0).abs() < 1e-7
            );
            let along = d.third_along(&step, &step);
            assert!(
                (along[1] - (2.0 * step[2] * step[2] - 4.0 * step[0] * step[2])).abs() < 1e-7,
                "{along}"
            );
        }
        assert_eq!(hessians(&space, &phi)[5], found[5].hessian);
    }

    #[test]
    fn gradients_are_of_order_three_and_cubics_are_exact_inside_of_cells_too() {
        let f = |x: &Point<2>| (3.0 * x[0]).sin() * x[1].exp();
        let gradient = |x: &Point<2>| {
            Point::<2>::new(3.0 * (3.0 * x[0]).cos(), (3.0 * x[0]).sin()) * x[1].exp()
        };
        let errors = [10, 20, 40].map(|n| {
            let mesh = irregular(n);
            let space = Space::new(&mesh, Element::P2);
            let points: Vec<u32> = (0..mesh.points().len() as u32).collect();
            let found = Recovery::new(&mesh).at_points(&space, &space.interpolate(f), &points);
            let error = |(d, x): (&Derivatives<2>, &Point<2>)| (d.gradient - gradient(x)).norm();
            found.iter().zip(mesh.points()).map(error).fold(0.0, f64::max)
        });
        assert!((errors[0] / errors[2]).log2() / 2.0 > 2.4 && errors[2] < 2e-3, "{errors:?}");
        let cubic = |x: &Point<2>| x[0].powi(3) - 2.0 * x[0] * x[1] * x[1] + x[1];
        let mesh = irregular(5);
        let space = Space::new(&mesh, Element::P2);
        let points: Vec<u32> = (0..mesh.points().len() as u32).collect();
        let known =
            Recovered::new(&Recovery::new(&mesh), &space, &space.interpolate(cubic), &points);
        for c in 0..mesh.cell_count() {
            let l = [0.2, 0.3, 0.5, 0.0];
            let x = mesh
                .cell(c)
                .iter()
                .zip(l)
                .fold(Point::<2>::zeros(), |x, (&v, l)| x + mesh.points()[v as usize] * l);
            let d = known.in_cell(&mesh, c, &l);
            let exact =
                Point::<2>::new(3.0 * x[0] * x[0] - 2.0 * x[1] * x[1], 1.0 - 4.0 * x[0] * x[1]);
            assert!(
                (d.gradient - exact).norm() < 1e-9 && (d.hessian[(0, 1)] + 4.0 * x[1]).abs() < 1e-8
            );
        }
        assert_eq!(
            Recovered::new(&Recovery::new(&mesh), &space, &vec![1.0; space.len()], &[])
                .at_vertex(3),
            Derivatives::zero()
        );
    }
}
