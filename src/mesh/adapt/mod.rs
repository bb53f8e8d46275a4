//! Adaptation of triangular meshes to a metric by local operations: edges are split, collapsed and
//! swapped, vertices moved.

mod background;
mod collapse;
mod frozen;
mod measure;
mod metric;
mod parts;
mod smooth;
mod split;
mod swap;
mod tensor;
mod triangulation;

pub use metric::Metric;

use super::Mesh;
use crate::base::{Error, Result};
use background::Background;
use triangulation::Triangulation;

/// Metric length above which edges are split.
const LONG: f64 = std::f64::consts::SQRT_2;
/// Metric length below which edges are collapsed.
const SHORT: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Sweeps end when fewer than one vertex in this number is added or removed.
const SETTLED: usize = 2000;

/// Options of an adaptation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptOptions {
    /// Largest number of sweeps.
    pub sweeps: usize,
    /// Smallest size; 0 for a millionth of the extent of the domain.
    pub h_min: f64,
    /// Largest size; infinite for the extent of the domain.
    pub h_max: f64,
    /// True to keep the points and edges of the boundary, as required on periodic sides. Sizes near
    /// edges that are then too long are increased.
    pub keep_boundary: bool,
    /// Largest number of vertices of the new mesh.
    pub most_vertices: usize,
}

impl Default for AdaptOptions {
    fn default() -> AdaptOptions {
        AdaptOptions {
            sweeps: 30,
            h_min: 0.0,
            h_max: f64::INFINITY,
            keep_boundary: false,
            most_vertices: 2_000_000,
        }
    }
}

/// Agreement of a mesh with its metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptReport {
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Number of sweeps.
    pub sweeps: usize,
    /// Fraction of the edges whose length in the metric lies in `[1/sqrt 2, sqrt 2]`.
    pub unit_edges: f64,
    /// Smallest quality in the metric, `4 sqrt 3 area / (sum of squared sides)`: 1 for an
    /// equilateral triangle.
    pub worst_quality: f64,
    /// Mean quality in the metric.
    pub mean_quality: f64,
}

/// A mesh that fits a metric.
#[derive(Clone, Debug)]
pub struct Adapted {
    /// The mesh.
    pub mesh: Mesh<2>,
    /// Agreement with the metric.
    pub report: AdaptReport,
}

/// A mesh of the same domain that fits `metric`, which is given at the points of `mesh` and
/// interpolated on it.
///
/// Edges longer than `sqrt 2` in the metric are split, those shorter than `1/sqrt 2` are collapsed,
/// edges are swapped and vertices moved if the quality of triangles in the metric increases (see
/// Frey and George, *Mesh Generation*, chapters 18 and 21), until little changes. Every operation
/// gives a conforming mesh of positive triangles (by exact predicates).
///
/// Boundaries and regions keep their names and positions: corners of the boundary and of the lines
/// between regions are fixed, and vertices on straight parts move along them only. The result does
/// not depend on the number of threads.
///
/// # Errors
/// A metric that does not belong to the mesh or is not positive; bounds of sizes that are not in
/// order; a metric that requires more than `most_vertices` vertices.
pub fn adapt(mesh: &Mesh<2>, metric: &Metric, options: &AdaptOptions) -> Result<Adapted> {
    metric.check(mesh)?;
    let (h_min, h_max) = bounds(mesh, options)?;
    let mut metric = metric.bounded(h_min, h_max);
    if options.keep_boundary {
        frozen::relieve(&mut metric, mesh);
    }
    let expected = metric.expected_vertices(mesh)?;
    if expected > options.most_vertices as f64 {
        return Err(too_many(expected, options));
    }
    let mut t = Triangulation::new(Background::new(mesh, &metric), options.keep_boundary);
    smooth::mark_poor(&mut t);
    let mut sweeps = 0;
    while sweeps < options.sweeps {
        sweeps += 1;
        let removed = collapse::collapse_short(&mut t);
        let cut = split::split_long(&mut t, options.most_vertices);
        if t.vertex_count() >= options.most_vertices {
            return Err(too_many(expected.max(options.most_vertices as f64), options));
        }
        swap::swap_all(&mut t);
        smooth::smooth_all(&mut t);
        if (removed + cut) * SETTLED <= t.vertex_count() {
            break;
        }
    }
    for _ in 0..4 {
        swap::swap_all(&mut t);
        smooth::smooth_all(&mut t);
    }
    Ok(Adapted { mesh: t.mesh()?, report: report(&t, sweeps) })
}

/// Agreement of a mesh with a metric given at its points, without sweeps.
///
/// # Errors
/// A metric that does not belong to the mesh or is not positive.
pub fn assess(mesh: &Mesh<2>, metric: &Metric) -> Result<AdaptReport> {
    metric.check(mesh)?;
    Ok(report(&Triangulation::new(Background::new(mesh, metric), false), 0))
}

/// The bounds of sizes, with the default ones taken from the extent of the domain.
fn bounds(mesh: &Mesh<2>, options: &AdaptOptions) -> Result<(f64, f64)> {
    let (low, high) = mesh.bounding_box();
    let extent = (high - low).amax();
    let (h_min, h_max) = (options.h_min.max(1e-6 * extent), options.h_max.min(extent));
    if h_min <= h_max && options.h_min >= 0.0 {
        return Ok((h_min, h_max));
    }
    Err(Error::input("the bounds of the sizes of triangles are not in order")
        .value(format!(
            "h_min = {}, h_max = {} in a domain of extent {extent}",
            options.h_min, options.h_max
        ))
        .remedy("give 0 <= h_min <= h_max, h_min less than the extent of the domain"))
}

fn too_many(expected: f64, options: &AdaptOptions) -> Error {
    Error::computation("the metric asks for too many vertices")
        .value(format!("about {expected:.0}, more than {}", options.most_vertices))
        .remedy("make the smallest size or the error larger, or allow more vertices")
}

fn report(t: &Triangulation, sweeps: usize) -> AdaptReport {
    let lengths = t.sides().map(|s| t.ends(s)).map(|[a, b]| t.length(a, b));
    let (edges, unit) = lengths
        .fold((0, 0), |(n, unit), l| (n + 1, unit + usize::from((SHORT..=LONG).contains(&l))));
    let qualities = t.alive().map(|c| t.quality(t.triangles[c as usize].vertices));
    let (worst, sum, triangles) =
        qualities.fold((1.0f64, 0.0, 0), |(w, s, n), q| (w.min(q), s + q, n + 1));
    AdaptReport {
        vertices: t.vertex_count(),
        triangles,
        sweeps,
        unit_edges: unit as f64 / edges as f64,
        worst_quality: worst,
        mean_quality: sum / triangles as f64,
    }
}

#[cfg(test)]
mod tests;
