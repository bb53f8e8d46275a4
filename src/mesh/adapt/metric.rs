//! Metrics: requested size and shape of triangles.

use super::measure;
use super::tensor::Tensor;
use crate::base::{Error, Result};
use crate::mesh::{Facet, Mesh};
use nalgebra::SMatrix;
use std::collections::VecDeque;

/// Triangles per unit of area in the metric: `4/sqrt 3` if all were equilateral with unit edges; 8
/// % more was measured.
const TRIANGLES_PER_AREA: f64 = 2.5;
/// Smallest eigenvalue of a metric from Hessians, relative to the largest of all: an edge 1e6 times
/// as long.
const FLAT: f64 = 1e-12;

/// A metric: one symmetric positive tensor `M` at every point of a mesh. The length of an edge `e`
/// is the integral of `sqrt(e^T M e)` along it. The edges of a mesh that fits the metric have
/// length 1: an isotropic size `h` is `M = I/h^2`.
///
/// Between the points the logarithm of `M` is linear on every triangle (Arsigny and others 2006),
/// so that it stays positive.
#[derive(Clone, Debug, PartialEq)]
pub struct Metric {
    /// One tensor per point of the mesh, in 1/length^2.
    pub tensors: Vec<SMatrix<f64, 2, 2>>,
}

impl Metric {
    /// An isotropic metric, `I/h^2` with one `h` per point.
    pub fn isotropic(sizes: &[f64]) -> Metric {
        Metric { tensors: sizes.iter().map(|h| SMatrix::identity() / (h * h)).collect() }
    }

    /// The metric in which linear interpolation of a function with these Hessians has at most the
    /// error `error`: `M = (2/9) |H| / error`, `|H|` with the moduli of the eigenvalues (Frey and
    /// Alauzet 2005). For quadratic interpolation it is not a bound, but places triangles according
    /// to the curvature of the function.
    ///
    /// If the Hessian vanishes, the size is `1e6` times the smallest of all; see
    /// [`bounded`](Self::bounded).
    pub fn from_hessians(hessians: &[SMatrix<f64, 2, 2>], error: f64) -> Metric {
        let scaled: Vec<Tensor> =
            hessians.iter().map(|h| Tensor::of(h) * (2.0 / (9.0 * error))).collect();
        let greatest =
            scaled.iter().flat_map(Tensor::eigenvalues).fold(0.0, |m: f64, l| m.max(l.abs()));
        let floor = if greatest > 0.0 { FLAT * greatest } else { f64::MIN_POSITIVE.sqrt() };
        Metric::of(scaled.iter().map(|t| t.map(|l| l.map(|l| l.abs().max(floor)))))
    }

    fn of(tensors: impl Iterator<Item = Tensor>) -> Metric {
        Metric { tensors: tensors.map(|t| t.matrix()).collect() }
    }

    fn map(&self, f: impl Fn([f64; 2]) -> [f64; 2]) -> Metric {
        Metric::of(self.tensors.iter().map(|m| Tensor::of(m).map(&f)))
    }

    /// Sizes in all directions between `h_min` and `h_max`.
    pub fn bounded(&self, h_min: f64, h_max: f64) -> Metric {
        let (low, high) = (1.0 / (h_max * h_max), 1.0 / (h_min * h_min));
        self.map(|l| l.map(|l| l.max(low).min(high)))
    }

    /// The largest size at most `ratio` (at least 1) times the smallest at every point; the
    /// smallest stays.
    pub fn limited_anisotropy(&self, ratio: f64) -> Metric {
        self.map(|[a, b]| [a, b.max(a / (ratio * ratio))])
    }

    /// The coarsest metric that is at least as fine as both, by simultaneous reduction.
    ///
    /// # Errors
    /// Internal, if the two belong to different meshes.
    pub fn intersect(&self, other: &Metric) -> Result<Metric> {
        if self.tensors.len() != other.tensors.len() {
            return Err(Error::internal("two metrics have different numbers of points")
                .value(format!("{} and {}", self.tensors.len(), other.tensors.len())));
        }
        let pairs = self.tensors.iter().zip(&other.tensors);
        Ok(Metric::of(pairs.map(|(a, b)| Tensor::of(a).intersection(&Tensor::of(b)))))
    }

    /// The metric with graded sizes: along an edge of metric length `l` (at its finer end) sizes
    /// grow at most by the factor `1 + l ln ratio`, so that neighbouring edges differ by about
    /// `ratio` (Alauzet 2010, growth in the metric).
    ///
    /// Directions are kept: each tensor is intersected with the bounds of its neighbours until
    /// nothing changes.
    ///
    /// # Errors
    /// As [`check`](Self::check), or a ratio that is not above 1.
    pub fn graded(&self, mesh: &Mesh<2>, ratio: f64) -> Result<Metric> {
        self.check(mesh)?;
        if !(ratio > 1.0 && ratio.is_finite()) {
            return Err(Error::input("the gradation of a metric must be above 1")
                .value(ratio)
                .remedy("1.3 is usual"));
        }
        let (starts, others) = point_neighbours(mesh);
        let mut tensors: Vec<Tensor> = self.tensors.iter().map(Tensor::of).collect();
        let mut queued = vec![true; tensors.len()];
        let mut queue: VecDeque<u32> = fine_first(&tensors).into();
        // Every visit makes a neighbour finer by a finite factor; the bound only guards against
        // rounding.
        let mut visits = 1000 * tensors.len();
        while let Some(p) = queue.pop_front() {
            let p = p as usize;
            queued[p] = false;
            for &q in &others[starts[p] as usize..starts[p + 1] as usize] {
                let q = q as usize;
                let e = mesh.points()[q] - mesh.points()[p];
                let growth = 1.0 + tensors[p].square(&e).sqrt() * ratio.ln();
                let allowed = tensors[p] * (1.0 / (growth * growth));
                let finer = tensors[q].intersection(&allowed);
                if finer.determinant() > 1.001 * tensors[q].determinant() {
                    tensors[q] = finer;
                    if !std::mem::replace(&mut queued[q], true) {
                        queue.push_back(q as u32);
                    }
                }
            }
            visits -= 1;
            if visits == 0 {
                break;
            }
        }
        Ok(Metric::of(tensors.into_iter()))
    }

    /// The metric times the factor `s` with which a mesh that fits it has about `vertices`
    /// vertices. By Euler's formula it has `t/2 + b/2 + 1` with `t` triangles and `b` sides on the
    /// boundary, `t = 2.5` times the [`complexity`](Self::complexity), which grows like `s`, and
    /// `b` the length of the boundary, which grows like `sqrt s`.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn scaled_to(&self, mesh: &Mesh<2>, vertices: usize) -> Result<Metric> {
        let (inside, along) =
            (0.5 * TRIANGLES_PER_AREA * self.complexity(mesh)?, 0.5 * self.perimeter(mesh));
        // inside x^2 + along x = vertices - 1 with s = x^2.
        let wanted = (vertices as f64 - 1.0).max(1.0);
        let root = 2.0 * wanted / (along + (along * along + 4.0 * inside * wanted).sqrt());
        Ok(Metric { tensors: self.tensors.iter().map(|m| m * (root * root)).collect() })
    }

    /// Length of the boundary in the metric.
    fn perimeter(&self, mesh: &Mesh<2>) -> f64 {
        let end = |v: u32| (&mesh.points()[v as usize], Tensor::of(&self.tensors[v as usize]));
        let length = |f: &Facet| {
            let mut ends = mesh.facet_points(f).map(end);
            let (Some((p, m)), Some((q, n))) = (ends.next(), ends.next()) else { return 0.0 };
            measure::length(p, &m, q, &n)
        };
        mesh.facets().iter().map(length).sum()
    }

    /// The area in the metric, the integral of `sqrt(det M)`.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn complexity(&self, mesh: &Mesh<2>) -> Result<f64> {
        self.check(mesh)?;
        let half_traces: Vec<f64> =
            self.tensors.iter().map(|m| 0.5 * Tensor::of(m).determinant().ln()).collect();
        let of_cell = |c: usize| {
            let v = mesh.cell(c);
            let at = |i: usize, j: usize| {
                (0.5 * (half_traces[v[i] as usize] + half_traces[v[j] as usize])).exp()
            };
            mesh.map(c).volume * (at(0, 1) + at(1, 2) + at(2, 0)) / 3.0
        };
        Ok((0..mesh.cell_count()).map(of_cell).sum())
    }

    /// Expected number of vertices of a mesh that fits the metric.
    pub(super) fn expected_vertices(&self, mesh: &Mesh<2>) -> Result<f64> {
        Ok(0.5 * (TRIANGLES_PER_AREA * self.complexity(mesh)? + self.perimeter(mesh)) + 1.0)
    }

    /// Checks that there is one symmetric positive tensor for every point.
    ///
    /// # Errors
    /// Internal if the number of tensors is not that of the points; computation if a tensor is not
    /// finite or not positive.
    pub fn check(&self, mesh: &Mesh<2>) -> Result<()> {
        if self.tensors.len() != mesh.points().len() {
            return Err(Error::internal("a metric needs one tensor a point of the mesh")
                .value(format!("{} tensors, {} points", self.tensors.len(), mesh.points().len())));
        }
        let bad = |m: &SMatrix<f64, 2, 2>| {
            let t = Tensor::of(m);
            !(t.xx > 0.0 && t.determinant() > 0.0 && t.determinant().is_finite())
        };
        match self.tensors.iter().position(bad) {
            None => Ok(()),
            Some(i) => Err(Error::computation("the metric is not positive and finite")
                .at(format!("point {i} (counted from 0) at {:?}", mesh.points()[i].as_slice()))
                .value(format!("{:?}", self.tensors[i].as_slice()))
                .remedy("bound the sizes from below and above")),
        }
    }
}

/// The points in the order of their smallest sizes: gradation starts from the finest.
fn fine_first(tensors: &[Tensor]) -> Vec<u32> {
    let mut order: Vec<(f64, u32)> =
        tensors.iter().zip(0..).map(|(t, p)| (-t.eigenvalues()[0], p)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.into_iter().map(|(_, p)| p).collect()
}

/// The points at the other ends of the edges of every point, those of inner edges twice: those of
/// `p` are `others[starts[p]..starts[p + 1]]`.
pub(super) fn point_neighbours(mesh: &Mesh<2>) -> (Vec<u32>, Vec<u32>) {
    let mut pairs = Vec::with_capacity(6 * mesh.cell_count());
    for c in 0..mesh.cell_count() {
        let v = mesh.cell(c);
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            pairs.extend([(v[i], v[j]), (v[j], v[i])]);
        }
    }
    pairs.sort_unstable();
    let mut starts = vec![0u32; mesh.points().len() + 1];
    pairs.iter().for_each(|(p, _)| starts[*p as usize + 1] += 1);
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    (starts, pairs.into_iter().map(|(_, q)| q).collect())
}
