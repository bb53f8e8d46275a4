//! What is measured on a contour: area, perimeter, axes, extents, integrals.

use super::contour::{Contour, Quadratic, Segment, barycentric_direction};
use crate::base::{Error, Result};
use crate::fem::{Space, gauss_legendre};
use crate::mesh::Point;
use nalgebra::SVector;

/// Gauss points on a segment. Four make the second moments of the region under a parabola exact (degree 7).
const GAUSS: usize = 4;

/// Geometry of the set `phi < 0` and of its contour, in the units of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Measures {
    /// Area of the set `phi < 0`, cut off at the boundary of the mesh.
    pub area: f64,
    /// Length of the contour; the boundary of the mesh does not count.
    pub perimeter: f64,
    /// Centroid of the set.
    pub centroid: Point<2>,
    /// Larger semi-axis of the ellipse that has the same area-weighted second moments as the set.
    pub axis_1: f64,
    /// Smaller semi-axis of that ellipse.
    pub axis_2: f64,
    /// Direction of its larger axis in degrees, counterclockwise from x, in (-90, 90]. Without meaning for a circle.
    pub angle: f64,
    /// Half the extent of the contour in x.
    pub extent_x: f64,
    /// Half the extent of the contour in y.
    pub extent_y: f64,
}

/// A quadrature point on the contour.
#[derive(Clone, Debug, PartialEq)]
pub struct ContourPoint {
    /// The cell.
    pub cell: u32,
    /// Barycentric coordinates in it.
    pub barycentric: [f64; 4],
    /// The point, on the P2 zero set.
    pub point: Point<2>,
    /// Unit normal of the contour, out of `phi < 0`.
    pub normal: SVector<f64, 2>,
    /// Weight: a length.
    pub weight: f64,
}

impl Contour {
    /// Length of the contour.
    pub fn perimeter(&self) -> f64 {
        let gauss = gauss_legendre(GAUSS);
        self.segments().iter().map(|s| gauss.iter().map(|&(t, w)| w * s.derivative(t).norm()).sum::<f64>()).sum()
    }

    /// Area, perimeter, centroid, axes and extents. The integrals over `phi < 0` become integrals over its boundary by
    /// Green's theorem, exact for the parabolic segments.
    ///
    /// # Errors
    /// No contour, or a set without area.
    pub fn measures(&self) -> Result<Measures> {
        let Some((low, high)) = self.bounds() else {
            return Err(Error::computation(
                "there is no interface: the level set does not change its sign in the mesh",
            )
            .remedy("the structure is smaller than a cell, or has left the domain"));
        };
        // Moments about a point nearby, against cancellation.
        let origin = (low + high) * 0.5;
        let m = self.moments(&origin);
        let area = m[0];
        if !(area > 0.0) {
            return Err(Error::computation("the interface encloses no area").value(area));
        }
        let shift = SVector::<f64, 2>::new(m[1], m[2]) / area;
        let xx = m[3] / area - shift[0] * shift[0];
        let xy = m[4] / area - shift[0] * shift[1];
        let yy = m[5] / area - shift[1] * shift[1];
        let (mean, deviation) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let half_turn = 0.5 * (2.0 * xy).atan2(xx - yy).to_degrees();
        // int x^2 over an ellipse is area a^2 / 4.
        let axis = |moment: f64| 2.0 * moment.max(0.0).sqrt();
        Ok(Measures {
            area,
            perimeter: self.perimeter(),
            centroid: origin + shift,
            axis_1: axis(mean + deviation),
            axis_2: axis(mean - deviation),
            angle: if half_turn <= -90.0 { 90.0 } else { half_turn },
            extent_x: 0.5 * (high[0] - low[0]),
            extent_y: 0.5 * (high[1] - low[1]),
        })
    }

    /// Lower and upper corner of the box around the contour, extremes inside of segments included.
    pub fn bounds(&self) -> Option<(Point<2>, Point<2>)> {
        let first = self.segments().first()?.points[0];
        Some(self.segments().iter().fold((first, first), |(low, high), s| {
            let mut box_ = (low.inf(&s.points[0]).inf(&s.points[2]), high.sup(&s.points[0]).sup(&s.points[2]));
            let (d0, d1) = (s.derivative(0.0), s.derivative(1.0));
            for axis in 0..2 {
                // The derivative is linear.
                if d0[axis] * d1[axis] < 0.0 {
                    let x = s.point(d0[axis] / (d0[axis] - d1[axis]))[axis];
                    box_.0[axis] = box_.0[axis].min(x);
                    box_.1[axis] = box_.1[axis].max(x);
                }
            }
            box_
        }))
    }

    /// `int 1, x, y, x^2, x y, y^2` over the set `phi < 0`, with coordinates from `origin`.
    fn moments(&self, origin: &Point<2>) -> [f64; 6] {
        let mut m = [0.0; 6];
        let mut add = |p: Point<2>, d: SVector<f64, 2>| {
            let (x, y) = (p[0] - origin[0], p[1] - origin[1]);
            m[0] += 0.5 * (x * d[1] - y * d[0]);
            m[1] += 0.5 * x * x * d[1];
            m[2] -= 0.5 * y * y * d[0];
            m[3] += x * x * x * d[1] / 3.0;
            m[4] += 0.5 * x * x * y * d[1];
            m[5] -= y * y * y * d[0] / 3.0;
        };
        let gauss = gauss_legendre(GAUSS);
        for &(t, w) in &gauss {
            self.segments().iter().for_each(|s| add(s.point(t), s.derivative(t) * w));
            self.walls().iter().for_each(|[a, b]| add(a + (b - a) * t, (b - a) * w));
        }
        m
    }

    /// Quadrature points: Gauss points of the segments, moved along the normal onto the P2 zero set of `phi`, which must
    /// be the function that the contour was made from.
    pub fn quadrature(&self, space: &Space<2>, phi: &[f64]) -> Vec<ContourPoint> {
        let gauss = gauss_legendre(GAUSS);
        self.segments().iter().flat_map(|s| gauss.iter().map(|&(t, w)| quadrature_point(space, phi, s, t, w))).collect()
    }

    /// Integral of `f(cell, barycentric coordinates, point)` over the contour of `phi`, by [`Contour::quadrature`].
    pub fn integrate(&self, space: &Space<2>, phi: &[f64], f: impl Fn(u32, &[f64; 4], &Point<2>) -> f64) -> f64 {
        self.quadrature(space, phi).iter().map(|q| q.weight * f(q.cell, &q.barycentric, &q.point)).sum()
    }
}

fn quadrature_point(space: &Space<2>, phi: &[f64], segment: &Segment, t: f64, w: f64) -> ContourPoint {
    let cell = segment.cell as usize;
    let tangent = segment.derivative(t);
    let (mut point, mut l) = (segment.point(t), segment.barycentric_at(t));
    let across = SVector::<f64, 2>::new(tangent[1], -tangent[0]);
    let s = Quadratic::on_line(space, phi, cell, &l, &across).roots()[0];
    // The parabola is within a small fraction of its length; a root farther away is another branch.
    if s.abs() < 0.1 {
        let dl = barycentric_direction(space, cell, &across);
        point += across * s;
        l = std::array::from_fn(|k| l[k] + s * dl[k]);
    }
    let length = tangent.norm();
    ContourPoint { cell: segment.cell, barycentric: l, point, normal: across / length, weight: w * length }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::levelset::{Circle, Ellipse, LevelFunction, Shape, signed_distance};
    use crate::mesh::rectangle;
    use proptest::prelude::*;
    use std::f64::consts::PI;
    use std::sync::Arc;

    const PERIMETER: f64 = 3.966359897;

    fn p(x: f64, y: f64) -> Point<2> {
        Point::<2>::new(x, y)
    }
    fn cut(n: usize, shape: &dyn Shape<2>) -> (Space<2>, Vec<f64>, Contour) {
        let space = Space::new(&Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [n, n]).unwrap()), Element::P2);
        let phi = signed_distance(&space, shape);
        let contour = Contour::new(&space, &phi).unwrap();
        (space, phi, contour)
    }
    /// Slope of log error over log n by least squares.
    fn order(n: &[usize], e: &[f64]) -> f64 {
        let x: Vec<f64> = n.iter().map(|&n| (n as f64).ln()).collect();
        let y: Vec<f64> = e.iter().map(|e| e.ln()).collect();
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let (mx, my) = (mean(&x), mean(&y));
        let top: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
        -top / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
    }

    #[test]
    fn the_measures_of_an_ellipse_converge() {
        let shape = Ellipse::new(p(1.0, 1.0), p(0.75, 0.5), 0.0).unwrap();
        let meshes = [15, 30, 60, 120];
        let mut errors = vec![Vec::new(); 6];
        for n in meshes {
            let (space, phi, c) = cut(n, &shape);
            let m = c.measures().unwrap();
            // int x^2 ds over the ellipse, by the trapezoidal rule, which is exact here to rounding.
            let k = 4000;
            let moment: f64 = (0..k)
                .map(|i| 2.0 * PI * i as f64 / k as f64)
                .map(|t| (0.75 * t.cos()).powi(2) * (0.75 * t.sin()).hypot(0.5 * t.cos()) * 2.0 * PI / k as f64)
                .sum();
            let measured = c.integrate(&space, &phi, |_, _, x| (x[0] - 1.0).powi(2));
            let relative = |a: f64, b: f64| (a / b - 1.0).abs();
            let e = [
                relative(m.perimeter, PERIMETER),
                relative(m.area, PI * 0.375),
                relative(m.axis_1, 0.75),
                relative(m.axis_2, 0.5),
                relative(m.extent_x, 0.75).max(relative(m.extent_y, 0.5)),
                relative(measured, moment),
            ];
            println!("{n:4} {}", e.map(|e| format!("{e:9.1e}")).join(" "));
            e.iter().zip(&mut errors).for_each(|(e, v)| v.push(*e));
            assert!((m.centroid - p(1.0, 1.0)).norm() < 1e-6);
            assert!(m.angle.abs() < 1e-3, "{}", m.angle);
        }
        println!("order {}", errors.iter().map(|e| format!("{:9.2}", order(&meshes, e))).collect::<Vec<_>>().join(" "));
    }
}
