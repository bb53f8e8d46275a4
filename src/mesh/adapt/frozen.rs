//! Metrics near a boundary with fixed edges.

use super::metric::{Metric, point_neighbours};
use super::tensor::Tensor;
use super::{LONG, measure};
use crate::mesh::Mesh;
use std::collections::VecDeque;

/// Factor per metric unit of length by which sizes return to the requested ones away from the
/// boundary.
const RETURN: f64 = 1.5;

/// Coarsens the metric near boundary edges that are longer than it requests, to avoid flat
/// triangles: all sizes at such an edge are multiplied by the missing factor, and inside by factors
/// that fall to 1 as a [graded](Metric::graded) size grows.
pub(super) fn relieve(metric: &mut Metric, mesh: &Mesh<2>) {
    let tensors: Vec<Tensor> = metric.tensors.iter().map(Tensor::of).collect();
    let mut factors = vec![1.0f64; tensors.len()];
    for facet in mesh.facets() {
        let ends: Vec<usize> = mesh.facet_points(facet).map(|v| v as usize).collect();
        let &[a, b] = &ends[..] else { continue };
        let length =
            measure::length(&mesh.points()[a], &tensors[a], &mesh.points()[b], &tensors[b]);
        for v in ends {
            factors[v] = factors[v].max(length / LONG);
        }
    }
    let (starts, others) = point_neighbours(mesh);
    let mut queue: VecDeque<usize> = (0..factors.len()).filter(|&p| factors[p] > 1.0).collect();
    while let Some(p) = queue.pop_front() {
        for &q in &others[starts[p] as usize..starts[p + 1] as usize] {
            let q = q as usize;
            let e = mesh.points()[q] - mesh.points()[p];
            let length = tensors[p].square(&e).sqrt() / factors[p];
            let wanted = factors[p] / (1.0 + length * RETURN.ln());
            // Factors fall by a finite part from point to point, so this ends.
            if wanted > 1.001 * factors[q] {
                factors[q] = wanted;
                queue.push_back(q);
            }
        }
    }
    metric.tensors.iter_mut().zip(factors).for_each(|(m, f)| *m /= f * f);
}
