//! The metric as a field on the mesh that it was given on.

use super::metric::Metric;
use super::tensor::Tensor;
use crate::mesh::{Location, Mesh, Point};

/// The metric at a point, and the location of the point in the background mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub tensor: Tensor,
    pub at: Location,
}

/// The original mesh with the logarithms of the metric at its points.
pub(super) struct Background<'a> {
    pub mesh: &'a Mesh<2>,
    logarithms: Vec<Tensor>,
}

impl<'a> Background<'a> {
    pub fn new(mesh: &'a Mesh<2>, metric: &Metric) -> Background<'a> {
        Background { mesh, logarithms: metric.tensors.iter().map(|m| Tensor::of(m).ln()).collect() }
    }

    /// The metric at a vertex of cell `c` of the background.
    pub fn at_vertex(&self, c: usize, k: usize) -> Sample {
        let mut barycentric = [0.0; 4];
        barycentric[k] = 1.0;
        self.sample(Location { cell: c as u32, barycentric })
    }

    /// The metric at `x`, found by a walk from a near location.
    pub fn at(&self, from: &Sample, x: &Point<2>) -> Sample {
        let start = self.mesh.point_at(&from.at);
        self.sample(self.mesh.walk(from.at.cell, &start, x).0)
    }

    fn sample(&self, at: Location) -> Sample {
        let v = self.mesh.cell(at.cell as usize);
        let logarithm = (0..3)
            .fold(Tensor::default(), |s, k| s + self.logarithms[v[k] as usize] * at.barycentric[k]);
        Sample { tensor: logarithm.exp(), at }
    }
}
