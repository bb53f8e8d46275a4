//! Half-chords: distances of the contour from a point along a line.

use super::contour::Contour;
use super::isosurface::Isosurface;
use super::quadratic::{Quadratic, barycentric_direction};
use crate::fem::Space;
use crate::mesh::Point;
use nalgebra::SVector;

/// Extension of a segment, as a fraction of its length, so that a line through a common end meets
/// one of the two.
const OVERLAP: f64 = 1e-9;

impl Contour {
    /// Half the distance between the first zeros of `phi` on both sides of `point` on the line
    /// along `direction` (of any length): the semi-axis of a centred shape along that line.
    ///
    /// The crossing with the contour gives the cell; in it `phi` on the line is quadratic and its
    /// zero exact. `phi` must be the function that the contour was made from. `None` if there is no
    /// contour on one of the sides.
    pub fn half_chord(
        &self,
        space: &Space<2>,
        phi: &[f64],
        point: &Point<2>,
        direction: &SVector<f64, 2>,
    ) -> Option<f64> {
        let along = direction.try_normalize(0.0)?;
        let normal = SVector::<f64, 2>::new(-along[1], along[0]);
        let mut crossings = Crossings::default();
        for segment in self.segments() {
            let height = segment.points.map(|p| (p - point).dot(&normal));
            // The parabola stays within twice the range of its three values.
            let (low, high) =
                (height[0].min(height[1]).min(height[2]), height[0].max(height[1]).max(height[2]));
            if low - (high - low) > 0.0 || high + (high - low) < 0.0 {
                continue;
            }
            for t in Quadratic::through(height[0], height[1], height[2]).roots() {
                if !(-OVERLAP..=1.0 + OVERLAP).contains(&t) {
                    continue;
                }
                let l = segment.barycentric_at(t);
                let step = along * (segment.points[2] - segment.points[0]).norm();
                let correction =
                    Quadratic::on_line(space, phi, segment.cell as usize, &l, &step).roots()[0];
                let mut s = (segment.point(t) - point).dot(&along);
                if correction.abs() < 0.1 {
                    s += correction * step.norm();
                }
                crossings.meet(s);
            }
        }
        crossings.half()
    }
}

impl Isosurface {
    /// Half the distance between the first zeros of `phi` on both sides of `point` on the line
    /// along `direction` (of any length): the semi-axis of a centred shape along that line.
    ///
    /// In every cell with a part of the surface, `phi` on the line is quadratic and its zeros are
    /// exact. `phi` must be the function that the surface was made from. `None` if there is no
    /// surface on one of the sides.
    pub fn half_chord(
        &self,
        space: &Space<3>,
        phi: &[f64],
        point: &Point<3>,
        direction: &SVector<f64, 3>,
    ) -> Option<f64> {
        let along = direction.try_normalize(0.0)?;
        let mut crossings = Crossings::default();
        for of_cell in self.triangles().chunk_by(|a, b| a.cell == b.cell) {
            let c = of_cell[0].cell as usize;
            let Some((from, to)) = passage(space, c, point, &along) else { continue };
            // Relative to the midpoint of the chord of the cell, against cancellation; with OVERLAP
            // no zero on a face is missed.
            let (middle, half) =
                (0.5 * (from + to), 0.5 * (to - from) + OVERLAP * space.mesh().diameter(c));
            let l = space.mesh().map(c).barycentric(&(point + along * middle));
            for t in Quadratic::on_line(space, phi, c, &l, &(along * half)).roots() {
                if t.abs() > 1.0 {
                    continue;
                }
                crossings.meet(middle + t * half);
            }
        }
        crossings.half()
    }
}

/// The nearest zeros on both sides of a point on a line.
struct Crossings {
    before: f64,
    after: f64,
}

impl Default for Crossings {
    fn default() -> Crossings {
        Crossings { before: f64::NEG_INFINITY, after: f64::INFINITY }
    }
}

impl Crossings {
    /// Records a zero at the signed distance `s` from the point.
    fn meet(&mut self, s: f64) {
        if s >= 0.0 {
            self.after = self.after.min(s);
        }
        if s <= 0.0 {
            self.before = self.before.max(s);
        }
    }
    /// Half the distance of the two zeros, if there are two.
    fn half(&self) -> Option<f64> {
        let half = 0.5 * (self.after - self.before);
        half.is_finite().then_some(half)
    }
}

/// Range of distances from `point` at which the line along `along` is in cell `c`, slightly
/// enlarged.
fn passage(
    space: &Space<3>,
    c: usize,
    point: &Point<3>,
    along: &SVector<f64, 3>,
) -> Option<(f64, f64)> {
    let l = space.mesh().map(c).barycentric(point);
    let dl = barycentric_direction(space, c, along);
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for k in 0..4 {
        let s = (-OVERLAP - l[k]) / dl[k];
        if dl[k] > 0.0 {
            from = from.max(s);
        } else if dl[k] < 0.0 {
            to = to.min(s);
        } else if l[k] < -OVERLAP {
            return None;
        }
    }
    (from <= to && from.is_finite() && to.is_finite()).then_some((from, to))
}
