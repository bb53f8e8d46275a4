//! Assembly of pointwise weak forms. Cells are evaluated in parallel into a buffer and added in
//! order, so that the result is bit-identical for any number of threads.

use super::element::MAX_LOCAL;
use super::numbering::Numbering;
use super::quadrature::Rule;
use super::space::{Space, Value, most_local};
use crate::base::{Result, parallel};
use crate::linalg::SymmetricMatrix;
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// A quadrature point of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At<const D: usize> {
    /// The cell.
    pub cell: usize,
    /// The number of the point in its rule.
    pub q: usize,
    /// Barycentric coordinates (entries `0..=D`).
    pub barycentric: [f64; 4],
    /// Position.
    pub x: Point<D>,
    /// Weight times volume of the cell.
    pub weight: f64,
}

/// Cells of an assembly.
#[derive(Clone, Copy, Debug)]
pub enum Cells<'a> {
    /// All of them.
    All,
    /// Those listed, in ascending order.
    Some(&'a [u32]),
}

impl Cells<'_> {
    fn count(&self, all: usize) -> usize {
        match self {
            Cells::All => all,
            Cells::Some(list) => list.len(),
        }
    }
    fn get(&self, i: usize) -> usize {
        match self {
            Cells::All => i,
            Cells::Some(list) => list[i] as usize,
        }
    }
}

/// The basis functions of a space tabulated at the points of a quadrature rule.
#[derive(Clone, Debug)]
pub struct Basis<const D: usize> {
    space: Arc<Space<D>>,
    rule: Arc<Rule>,
    values: Vec<[f64; MAX_LOCAL]>,
    gradients: Vec<[SVector<f64, D>; MAX_LOCAL]>,
}

impl<const D: usize> Basis<D> {
    /// Tabulates `space` at the points of `rule`.
    pub fn new(space: &Arc<Space<D>>, rule: &Arc<Rule>) -> Basis<D> {
        let e = space.element();
        Basis {
            space: Arc::clone(space),
            rule: Arc::clone(rule),
            values: rule.points.iter().map(|l| e.values::<D>(l)).collect(),
            gradients: rule.points.iter().map(|l| e.reference_gradients::<D>(l)).collect(),
        }
    }
    /// The space.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }
    /// The rule.
    pub fn rule(&self) -> &Arc<Rule> {
        &self.rule
    }
    /// Point `q` of cell `c`.
    #[inline]
    pub fn at(&self, c: usize, q: usize) -> At<D> {
        let l = self.rule.points[q];
        let mesh = self.space.mesh();
        let mut x = Point::<D>::zeros();
        for (k, &v) in mesh.cell(c).iter().enumerate() {
            x += mesh.points()[v as usize] * l[k];
        }
        At { cell: c, q, barycentric: l, x, weight: self.rule.weights[q] * mesh.map(c).volume }
    }
    /// Values of the basis functions at point `q`; zero beyond the last.
    #[inline]
    pub fn values(&self, q: usize) -> &[f64; MAX_LOCAL] {
        &self.values[q]
    }
    /// Gradients of the basis functions at point `q` in the coordinates of the reference cell; zero
    /// beyond the last.
    #[inline]
    pub fn reference_gradients(&self, q: usize) -> &[SVector<f64, D>; MAX_LOCAL] {
        &self.gradients[q]
    }
    /// Weight times volume of the cell.
    #[inline]
    pub fn weight(&self, c: usize, q: usize) -> f64 {
        self.rule.weights[q] * self.space.mesh().map(c).volume
    }
    /// Value of a function of the space.
    #[inline]
    pub fn value<T: Value>(&self, at: &At<D>, f: &[T]) -> T {
        self.space.on_cell(f, at.cell).combined(&self.values[at.q])
    }
    /// Gradient of a scalar function of the space.
    #[inline]
    pub fn gradient(&self, at: &At<D>, f: &[f64]) -> SVector<f64, D> {
        let g = self.space.on_cell(f, at.cell).reference_gradient(&self.gradients[at.q]);
        self.space.mesh().map(at.cell).inverse.tr_mul(&g)
    }
    /// Gradient of a vector function of the space: row `i`, column `j` is `d f_i / d x_j`.
    #[inline]
    pub fn jacobian(&self, at: &At<D>, f: &[SVector<f64, D>]) -> SMatrix<f64, D, D> {
        self.space.on_cell(f, at.cell).reference_jacobian(&self.gradients[at.q])
            * self.space.mesh().map(at.cell).inverse
    }
    /// Gradients of the local basis functions in physical coordinates.
    #[inline]
    fn physical_gradients(&self, at: &At<D>) -> [SVector<f64, D>; MAX_LOCAL] {
        let inverse = &self.space.mesh().map(at.cell).inverse;
        let mut g = [SVector::<f64, D>::zeros(); MAX_LOCAL];
        for a in 0..self.space.local_count() {
            g[a] = inverse.tr_mul(&self.gradients[at.q][a]);
        }
        g
    }
}

/// Value of a linear form at a quadrature point: the pair `(f0, f1)` of `f0 . v + f1 : grad v`,
/// where `f1[(i, j)]` multiplies `d v_i / d x_j`.
pub type VectorForm<const D: usize> = (SVector<f64, D>, SMatrix<f64, D, D>);

/// Sum over cells and quadrature points of `f`, `N` integrals at once.
pub fn integrate<const D: usize, const N: usize>(
    basis: &Basis<D>,
    cells: Cells<'_>,
    f: impl Fn(&At<D>) -> [f64; N] + Sync,
) -> [f64; N] {
    parallel::sum(cells.count(basis.space.mesh().cell_count()), |i| {
        let mut s = [0.0; N];
        for q in 0..basis.rule.len() {
            let at = basis.at(cells.get(i), q);
            let v = f(&at);
            for j in 0..N {
                s[j] += at.weight * v[j];
            }
        }
        s
    })
}

/// Adds the linear form `f(at) = (f0, f1)`, tested with the vector functions of the space, to `out`
/// (one vector per node).
///
/// `scratch` is a buffer for repeated calls.
pub fn assemble_vector<const D: usize>(
    basis: &Basis<D>,
    cells: Cells<'_>,
    out: &mut [SVector<f64, D>],
    scratch: &mut Vec<SVector<f64, D>>,
    f: impl Fn(&At<D>) -> VectorForm<D> + Sync,
) {
    assemble_local(basis, cells, out, scratch, SVector::<f64, D>::zeros(), |c, local| {
        let inverse = &basis.space.mesh().map(c).inverse;
        for q in 0..basis.rule.len() {
            let at = basis.at(c, q);
            let (f0, f1) = f(&at);
            let (f0, f1) = (f0 * at.weight, f1 * inverse.transpose() * at.weight);
            let (n, g) = (&basis.values[q], &basis.gradients[q]);
            for a in 0..most_local(D) {
                local[a] += f0 * n[a] + f1 * g[a];
            }
        }
    });
}

/// Adds `(f, v)`, for all vector functions `v` of the space, to `out`: [`assemble_vector`] with
/// `f1 = 0`. `source(c, load)` adds the values of `f` at the quadrature points of cell `c` to
/// `load`.
pub fn assemble_source<const D: usize>(
    basis: &Basis<D>,
    out: &mut [SVector<f64, D>],
    scratch: &mut Vec<SVector<f64, D>>,
    source: impl Fn(usize, &mut CellLoad<'_, D>) + Sync,
) {
    assemble_local(basis, Cells::All, out, scratch, SVector::<f64, D>::zeros(), |c, local| {
        source(c, &mut CellLoad { basis, volume: basis.space.mesh().map(c).volume, local });
    });
}

/// Contribution of a cell to a linear form.
pub struct CellLoad<'a, const D: usize> {
    basis: &'a Basis<D>,
    volume: f64,
    local: &'a mut [SVector<f64, D>; MAX_LOCAL],
}

impl<const D: usize> CellLoad<'_, D> {
    /// Adds the value of `f` at point `q`.
    #[inline]
    pub fn add(&mut self, q: usize, f: SVector<f64, D>) {
        let (f, n) = (f * (self.basis.rule.weights[q] * self.volume), &self.basis.values[q]);
        for a in 0..most_local(D) {
            self.local[a] += f * n[a];
        }
    }
}

/// Adds the linear form `f(at) = (f0, f1)`, that is `f0 q + f1 . grad q`, to `out` (one number per
/// node).
pub fn assemble_scalar<const D: usize>(
    basis: &Basis<D>,
    cells: Cells<'_>,
    out: &mut [f64],
    scratch: &mut Vec<f64>,
    f: impl Fn(&At<D>) -> (f64, SVector<f64, D>) + Sync,
) {
    assemble_local(basis, cells, out, scratch, 0.0, |c, local| {
        let inverse = &basis.space.mesh().map(c).inverse;
        for q in 0..basis.rule.len() {
            let at = basis.at(c, q);
            let (f0, f1) = f(&at);
            let (f0, f1) = (f0 * at.weight, inverse * f1 * at.weight);
            let (n, g) = (&basis.values[q], &basis.gradients[q]);
            for a in 0..most_local(D) {
                local[a] += f0 * n[a] + f1.dot(&g[a]);
            }
        }
    });
}

/// The common loop of linear forms: `cell` adds the contribution of a cell to zeros, one entry per
/// local node. Cells are computed in parallel into the buffer, then added in order.
pub fn assemble_local<const D: usize, T: Copy + Send + Sync + std::ops::AddAssign>(
    basis: &Basis<D>,
    cells: Cells<'_>,
    out: &mut [T],
    scratch: &mut Vec<T>,
    zero: T,
    cell: impl Fn(usize, &mut [T; MAX_LOCAL]) + Sync,
) {
    let nb = basis.space.local_count();
    let count = cells.count(basis.space.mesh().cell_count());
    scratch.resize(count * nb, zero);
    parallel::fill(scratch, nb, |first, part| {
        for (i, local) in part.chunks_exact_mut(nb).enumerate() {
            let mut sums = [zero; MAX_LOCAL];
            cell(cells.get(first + i), &mut sums);
            local.copy_from_slice(&sums[..nb]);
        }
    });
    for (i, local) in scratch.chunks_exact(nb).enumerate() {
        for (a, &node) in basis.space.cell_nodes(cells.get(i)).iter().enumerate() {
            out[node as usize] += local[a];
        }
    }
}

/// Number of cells whose local matrices are stored at a time.
const WAVE: usize = 4096;

/// Adds a symmetric bilinear form on vector functions to the velocity block of `matrix`. At every
/// point, `f(at, u, grad u)` returns the pair tested with `(v, grad v)`; it must be linear in
/// `(u, grad u)` and symmetric.
///
/// With `pressure`, the blocks `-(p, div v)` and `-(q, div u)` are added too. `scratch` is
/// overwritten.
pub fn assemble_flow_matrix<const D: usize>(
    velocity: &Basis<D>,
    pressure: Option<&Basis<D>>,
    numbering: &Numbering<D>,
    cells: Cells<'_>,
    matrix: &mut SymmetricMatrix,
    scratch: &mut Vec<f64>,
    f: impl Fn(&At<D>, &SVector<f64, D>, &SMatrix<f64, D, D>) -> VectorForm<D> + Sync,
) -> Result<()> {
    let nb = velocity.space.local_count();
    let np = pressure.map_or(0, |p| p.space.local_count());
    let m = D * nb + np;
    let count = cells.count(velocity.space.mesh().cell_count());
    let mut unknowns = Vec::with_capacity(m);
    for start in (0..count).step_by(WAVE) {
        let size = WAVE.min(count - start);
        scratch.clear();
        scratch.resize(size * m * m, 0.0);
        let part = &mut scratch[..];
        parallel::fill(part, m * m, |first, part| {
            for (i, local) in part.chunks_exact_mut(m * m).enumerate() {
                let c = cells.get(start + first + i);
                for q in 0..velocity.rule.len() {
                    flow_matrix_at(velocity, pressure, &velocity.at(c, q), local, &f);
                }
                mirror(m, local);
                numbering.rotate_local(velocity.space.cell_nodes(c), m, local);
            }
        });
        for (i, local) in part.chunks_exact(m * m).enumerate() {
            let c = cells.get(start + i);
            numbering.cell_unknowns(
                velocity.space.cell_nodes(c),
                pressure.map(|p| p.space.cell_nodes(c)),
                &mut unknowns,
            );
            matrix.add_group(&unknowns, local)?;
        }
    }
    Ok(())
}

/// Copies the upper triangle of a local matrix of order `m` to the lower one.
fn mirror(m: usize, local: &mut [f64]) {
    for r in 0..m {
        for c in 0..r {
            local[r * m + c] = local[c * m + r];
        }
    }
}

/// Contribution of one quadrature point to the upper triangle of the local matrix; unknown
/// `D a + i` is component `i` at local node `a`, pressures follow.
fn flow_matrix_at<const D: usize>(
    velocity: &Basis<D>,
    pressure: Option<&Basis<D>>,
    at: &At<D>,
    local: &mut [f64],
    f: &impl Fn(&At<D>, &SVector<f64, D>, &SMatrix<f64, D, D>) -> VectorForm<D>,
) {
    let nb = velocity.space.local_count();
    let np = pressure.map_or(0, |p| p.space.local_count());
    let m = D * nb + np;
    let n = &velocity.values[at.q];
    let g = velocity.physical_gradients(at);
    for b in 0..nb {
        for j in 0..D {
            let mut u = SVector::<f64, D>::zeros();
            u[j] = n[b];
            let mut grad = SMatrix::<f64, D, D>::zeros();
            grad.set_row(j, &g[b].transpose());
            let (f0, f1) = f(at, &u, &grad);
            let (f0, f1) = (f0 * at.weight, f1 * at.weight);
            let column = D * b + j;
            for a in 0..=b {
                let v = f0 * n[a] + f1 * g[a];
                for i in 0..D {
                    let row = D * a + i;
                    if row <= column {
                        local[row * m + column] += v[i];
                    }
                }
            }
        }
    }
    if let Some(p) = pressure {
        let psi = &p.values[at.q];
        for k in 0..np {
            for a in 0..nb {
                for i in 0..D {
                    local[(D * a + i) * m + D * nb + k] -= at.weight * psi[k] * g[a][i];
                }
            }
        }
    }
}

/// Adds `m (phi_a, phi_b) + k (grad phi_a, grad phi_b)`, with `(m, k) = form(at)`, to the matrix of
/// a scalar space whose unknowns are `unknowns[node]`.
pub fn assemble_scalar_matrix<const D: usize>(
    basis: &Basis<D>,
    unknowns: &[u32],
    matrix: &mut SymmetricMatrix,
    form: impl Fn(&At<D>) -> (f64, f64) + Sync,
) -> Result<()> {
    let nb = basis.space.local_count();
    let mut local = vec![0.0; nb * nb];
    let mut group = vec![0; nb];
    for c in 0..basis.space.mesh().cell_count() {
        local.fill(0.0);
        for q in 0..basis.rule.len() {
            let at = basis.at(c, q);
            let (m, k) = form(&at);
            let (m, k) = (m * at.weight, k * at.weight);
            let (n, g) = (&basis.values[q], basis.physical_gradients(&at));
            for a in 0..nb {
                for b in a..nb {
                    local[a * nb + b] += m * n[a] * n[b] + k * g[a].dot(&g[b]);
                }
            }
        }
        mirror(nb, &mut local);
        for (g, &node) in group.iter_mut().zip(basis.space.cell_nodes(c)) {
            *g = unknowns[node as usize];
        }
        matrix.add_group(&group, &local)?;
    }
    Ok(())
}
