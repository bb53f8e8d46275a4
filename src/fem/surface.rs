//! Weak forms on a surface that cuts through the cells, given by quadrature points.

use super::assembly::At;
use super::element::MAX_LOCAL;
use super::points::gradients;
use super::quadrature::Rule;
use super::space::Space;
use crate::base::Result;
use crate::linalg::{Factor, Ordering, SymmetricMatrix};
use crate::mesh::{Location, NONE};
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

/// Weight of the gradient in all directions in the stabilisation. Where the surface cuts off a small
/// corner of a cell, nothing else determines the functions at the opposite nodes; as a diffusion it
/// is `1e-4 h^2` a solve.
const ALONG: f64 = 1e-4;

/// The L2 product on a surface for P2 functions on the cells that it cuts: a trace finite element
/// space.
///
/// The matrix is that of `int_S a b + k grad_S a . grad_S b` plus, over each cut cell of diameter
/// `h`, `h int (n . grad a)(n . grad b)` with `n` the normal of the level set (and a little of
/// `grad a . grad b`). The last term makes the functions constant along the normal to the order of the elements, and the matrix well
/// conditioned for any position of the surface in its cells (Grande, Lehrenfeld and Reusken, SIAM
/// J. Numer. Anal. 56, 2018). It vanishes for constants.
pub struct SurfaceMass {
    /// Unknown of every node; [`NONE`] for nodes of cells that are not cut.
    number: Vec<u32>,
    matrix: SymmetricMatrix,
    factor: Factor,
}

impl SurfaceMass {
    /// The functions on the cells that the surface of `points` cuts; [`diffuse`](Self::diffuse)
    /// then makes the matrix. `unknowns` has one number per node, equal for nodes that periodic
    /// sides identify. `None` without points.
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn new<const D: usize>(
        space: &Space<D>,
        unknowns: &[u32],
        points: &[SurfacePoint<D>],
    ) -> Result<Option<SurfaceMass>> {
        let cells: Vec<&[SurfacePoint<D>]> =
            points.chunk_by(|a, b| a.at.cell == b.at.cell).collect();
        let mut numbers = vec![NONE; unknowns.len()];
        let mut order = 0;
        for &n in cells.iter().flat_map(|group| space.cell_nodes(group[0].at.cell)) {
            let number = &mut numbers[unknowns[n as usize] as usize];
            if *number == NONE {
                *number = order;
                order += 1;
            }
        }
        if order == 0 {
            return Ok(None);
        }
        let of_node = |&u: &u32| numbers.get(u as usize).copied().unwrap_or(NONE);
        let number: Vec<u32> = unknowns.iter().map(of_node).collect();
        let of_cell = |c: usize| -> Vec<u32> {
            space.cell_nodes(c).iter().map(|&n| number[n as usize]).collect()
        };
        let groups = cells.iter().map(|g| of_cell(g[0].at.cell));
        let matrix = SymmetricMatrix::from_groups(order as usize, groups)?;
        let factor = Factor::analyse(&matrix, Ordering::minimum_degree(&matrix)?)?;
        Ok(Some(SurfaceMass { number, matrix, factor }))
    }
    /// Makes the matrix with the diffusivity `k` at each point; the surface is the zero set of
    /// `phi`, and `points` are those of [`new`](Self::new).
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn diffuse<const D: usize>(
        &mut self,
        space: &Space<D>,
        (points, phi): (&[SurfacePoint<D>], &[f64]),
        diffusivity: impl Fn(&SurfacePoint<D>) -> f64,
    ) -> Result<()> {
        let m = space.local_count();
        self.stabilised(space, (points, phi), |p, local| {
            let (at, k) = (&p.at, diffusivity(p));
            add_square(&space.element().values::<D>(&at.barycentric), at.weight, m, local);
            if k != 0.0 {
                let g = gradients(space, space.element(), at).map(|g| p.tangential(&g));
                for (a, b) in pairs(m) {
                    local[a * m + b] += at.weight * k * g[a].dot(&g[b]);
                }
            }
        })?;
        self.factor.refactor(&self.matrix)
    }
    /// Makes the matrix `sum w a(x) b(x)` over samples with a place in a cut cell or close to it and
    /// a weight, with the same stabilisation; otherwise as [`diffuse`](Self::diffuse). Its solutions
    /// are fitted to values at the samples by weighted least squares.
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn weigh<const D: usize>(
        &mut self,
        space: &Space<D>,
        (points, phi): (&[SurfacePoint<D>], &[f64]),
        samples: impl Iterator<Item = (Location, f64)>,
    ) -> Result<()> {
        self.stabilised(space, (points, phi), |_, _| {})?;
        let m = space.local_count();
        let (mut cell, mut local) = (NONE, vec![0.0; m * m]);
        // Samples of one cell mostly follow each other.
        for (at, weight) in samples {
            if at.cell != cell {
                if cell != NONE {
                    self.add(space, cell as usize, &mut local)?;
                }
                local.fill(0.0);
                cell = at.cell;
            }
            let v = space.element().values::<D>(&at.barycentric);
            add_square(&v, weight, m, &mut local);
        }
        if cell != NONE {
            self.add(space, cell as usize, &mut local)?;
        }
        self.factor.refactor(&self.matrix)
    }
    /// Makes the matrix of the stabilisation and of what `of_point` adds to that of the cell of each
    /// point, without a factor.
    fn stabilised<const D: usize>(
        &mut self,
        space: &Space<D>,
        (points, phi): (&[SurfacePoint<D>], &[f64]),
        of_point: impl Fn(&SurfacePoint<D>, &mut [f64]),
    ) -> Result<()> {
        self.matrix.zero();
        let mut local = vec![0.0; space.local_count().pow(2)];
        for group in points.chunk_by(|a, b| a.at.cell == b.at.cell) {
            local.fill(0.0);
            group.iter().for_each(|p| of_point(p, &mut local));
            stabilise(space, group[0].at.cell, phi, &mut local);
            self.add(space, group[0].at.cell, &mut local)?;
        }
        Ok(())
    }
    /// Adds a symmetric local matrix, of which only the entries of [`pairs`] are set.
    fn add<const D: usize>(
        &mut self,
        space: &Space<D>,
        cell: usize,
        local: &mut [f64],
    ) -> Result<()> {
        let m = space.local_count();
        pairs(m).for_each(|(a, b)| local[b * m + a] = local[a * m + b]);
        let mut unknowns = [0; MAX_LOCAL];
        let nodes = space.cell_nodes(cell);
        for (unknown, &n) in unknowns.iter_mut().zip(nodes) {
            *unknown = self.number[n as usize];
        }
        self.matrix.add_group(&unknowns[..nodes.len()], local)
    }
    /// An empty right-hand side of [`solve`](Self::solve).
    pub fn load(&self) -> Vec<f64> {
        vec![0.0; self.matrix.order()]
    }
    /// Adds `amount v(x)` to a right-hand side, for all functions `v` of the space, at a point of a
    /// cut cell or close to it.
    pub fn deposit<const D: usize>(
        &self,
        space: &Space<D>,
        (cell, barycentric): (usize, &[f64; 4]),
        amount: f64,
        load: &mut [f64],
    ) {
        let v = space.element().values::<D>(barycentric);
        for (&n, v) in space.cell_nodes(cell).iter().zip(v) {
            load[self.number[n as usize] as usize] += amount * v;
        }
    }
    /// Adds `- weight T : grad (v e_i)` to the right-hand side `i`, for all functions `v` of the space,
    /// at a point of a cut cell.
    pub fn deposit_divergence<const D: usize>(
        &self,
        space: &Space<D>,
        p: &SurfacePoint<D>,
        tensor: &SMatrix<f64, D, D>,
        loads: &mut [Vec<f64>; D],
    ) {
        let g = gradients(space, space.element(), &p.at);
        for (&n, g) in space.cell_nodes(p.at.cell).iter().zip(g) {
            let amount = tensor * g * -p.at.weight;
            for (load, amount) in loads.iter_mut().zip(amount.iter()) {
                load[self.number[n as usize] as usize] += amount;
            }
        }
    }
    /// Solves for the function with this right-hand side and writes its values to the nodes of cut
    /// cells; other nodes are not changed.
    ///
    /// # Errors
    /// A solve that fails.
    pub fn solve(&mut self, load: &[f64], nodes: &mut [f64]) -> Result<()> {
        let mut x = vec![0.0; load.len()];
        self.factor.solve(&self.matrix, load, &mut x)?;
        for (out, &k) in nodes.iter_mut().zip(&self.number).filter(|(_, k)| **k != NONE) {
            *out = x[k as usize];
        }
        Ok(())
    }
}

/// The entries `a <= b` of a local matrix of `m` rows, which determine a symmetric one.
fn pairs(m: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..m).flat_map(move |a| (a..m).map(move |b| (a, b)))
}

/// Adds `weight v v^T` to a local matrix of `m` rows.
fn add_square(v: &[f64; MAX_LOCAL], weight: f64, m: usize, local: &mut [f64]) {
    for (a, b) in pairs(m) {
        local[a * m + b] += weight * v[a] * v[b];
    }
}

/// Adds the stabilisation of a cut cell to its matrix; `phi` is the level set.
fn stabilise<const D: usize>(space: &Space<D>, cell: usize, phi: &[f64], local: &mut [f64]) {
    let (m, rule, map) = (space.local_count(), Rule::simplex(D, 2), space.mesh().map(cell));
    let (height, volume) = (space.mesh().diameter(cell), map.volume);
    for (l, w) in rule.points.iter().zip(&rule.weights) {
        let g = space.element().reference_gradients::<D>(l).map(|g| map.inverse.tr_mul(&g));
        let normal = space.gradient(phi, cell, l).try_normalize(0.0);
        let across = normal.map_or([0.0; MAX_LOCAL], |n| g.map(|g| n.dot(&g)));
        for (a, b) in pairs(m) {
            let along = ALONG * g[a].dot(&g[b]);
            local[a * m + b] += height * volume * w * (across[a] * across[b] + along);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
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

    /// The function with `int s v + k s' v' = int f v`, at the points.
    fn solved(space: &Space<2>, height: f64, k: f64, f: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let (points, phi) = (line(space, height), space.interpolate(|x| x[1] - height));
        let own: Vec<u32> = (0..space.len() as u32).collect();
        let mut mass = SurfaceMass::new(space, &own, &points).unwrap().unwrap();
        mass.diffuse(space, (&points, &phi), |_| k).unwrap();
        let mut load = mass.load();
        for p in &points {
            let amount = p.at.weight * f(p.at.x[0]);
            mass.deposit(space, (p.at.cell, &p.at.barycentric), amount, &mut load);
        }
        let mut s = vec![f64::NAN; space.len()];
        mass.solve(&load, &mut s).unwrap();
        points.iter().map(|p| (p.at.x[0], space.value(&s, p.at.cell, &p.at.barycentric))).collect()
    }

    /// `s - k s'' = (1 + k pi^2) cos(pi x)` has the solution `cos(pi x)`.
    #[test]
    fn projection_and_diffusion_along_a_line_are_of_third_order() {
        for k in [0.0, 0.05] {
            let error = |n: usize| {
                let s = solved(&space(n), 0.437, k, |x| (1.0 + k * PI * PI) * (PI * x).cos());
                s.iter().map(|(x, s)| (s - (PI * x).cos()).abs()).fold(0.0, f64::max)
            };
            let errors = [8, 16, 32].map(error);
            assert!(errors[2] < 1e-4 && errors[1] / errors[2] > 6.0, "{k}: {errors:?}");
        }
    }

    #[test]
    fn a_constant_stays_what_it_is_however_little_of_a_cell_is_cut() {
        let space = space(10);
        for height in [0.25, 0.3 + 1e-9, 0.3 - 1e-13] {
            let s = solved(&space, height, 0.7, |_| 3.0);
            assert!(s.len() >= 30 && s.iter().all(|(_, s)| (s - 3.0).abs() < 1e-9), "{s:?}");
        }
    }
}
