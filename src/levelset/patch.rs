//! A curved triangle in space: the quadratic map of six points.

use crate::fem::Element;
use crate::mesh::Point;
use nalgebra::SVector;

/// A piece of a surface inside one cell: the image of the reference triangle under the quadratic
/// map through six points.
///
/// Its corners are ordered such that the normal points out of `phi < 0` (right-hand rule).
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle {
    /// The cell.
    pub cell: u32,
    /// The corners 0, 1, 2, then the points half-way along the sides (0,1), (1,2), (2,0).
    pub points: [Point<3>; 6],
    /// Barycentric coordinates of the six points in the cell; the middles may lie outside of it by
    /// a little.
    pub barycentric: [[f64; 4]; 6],
}

impl Triangle {
    /// The point with the barycentric coordinates `t[..3]` in the triangle.
    pub fn point(&self, t: &[f64; 4]) -> Point<3> {
        let n = Element::P2.values::<2>(t);
        (1..6).fold(self.points[0] * n[0], |x, a| x + self.points[a] * n[a])
    }
    /// Barycentric coordinates in the cell of that point.
    pub fn barycentric_at(&self, t: &[f64; 4]) -> [f64; 4] {
        let n = Element::P2.values::<2>(t);
        std::array::from_fn(|k| (0..6).map(|a| n[a] * self.barycentric[a][k]).sum())
    }
    /// The two tangents: derivatives with respect to `t[1]` and `t[2]`, with
    /// `t[0] = 1 - t[1] - t[2]`.
    pub fn tangents(&self, t: &[f64; 4]) -> [SVector<f64, 3>; 2] {
        let g = Element::P2.reference_gradients::<2>(t);
        [0, 1].map(|i| (0..6).fold(SVector::<f64, 3>::zeros(), |v, a| v + self.points[a] * g[a][i]))
    }
    /// The normal, half as long as the area of the tangents' parallelogram: summed with the weights
    /// of a rule on the triangle it is the area as a vector.
    pub fn area_vector(&self, t: &[f64; 4]) -> SVector<f64, 3> {
        let [u, v] = self.tangents(t);
        u.cross(&v) * 0.5
    }
    /// The longest straight line between two corners.
    pub fn size(&self) -> f64 {
        let side = |i: usize, j: usize| (self.points[i] - self.points[j]).norm();
        side(0, 1).max(side(1, 2)).max(side(2, 0))
    }
    /// The largest and the smallest coordinate along `axis` (0, 1, 2), those inside of the triangle
    /// included.
    pub(super) fn range(&self, axis: usize) -> (f64, f64) {
        let v: [f64; 6] = std::array::from_fn(|a| self.points[a][axis]);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut see = |x: f64| (low, high) = (low.min(x), high.max(x));
        (0..3).for_each(|k| see(v[k]));
        for (a, b, middle) in [(v[0], v[1], v[3]), (v[1], v[2], v[4]), (v[2], v[0], v[5])] {
            let (d0, d1) = (4.0 * middle - 3.0 * a - b, 3.0 * b + a - 4.0 * middle);
            // The derivative along a side is linear.
            if d0 * d1 < 0.0 {
                let t = d0 / (d0 - d1);
                see((1.0 - t) * (1.0 - 2.0 * t) * a
                    + 4.0 * t * (1.0 - t) * middle
                    + t * (2.0 * t - 1.0) * b);
            }
        }
        let gradient = |t: [f64; 4]| self.tangents(&t).map(|d| d[axis]);
        let (g, gu, gv) = (
            gradient([1.0, 0.0, 0.0, 0.0]),
            gradient([0.0, 1.0, 0.0, 0.0]),
            gradient([0.0, 0.0, 1.0, 0.0]),
        );
        let (a, b, c, d) = (gu[0] - g[0], gv[0] - g[0], gu[1] - g[1], gv[1] - g[1]);
        let (t1, t2) =
            ((b * g[1] - d * g[0]) / (a * d - b * c), (c * g[0] - a * g[1]) / (a * d - b * c));
        if t1 > 0.0 && t2 > 0.0 && t1 + t2 < 1.0 {
            see(self.point(&[1.0 - t1 - t2, t1, t2, 0.0])[axis]);
        }
        (low, high)
    }
}
