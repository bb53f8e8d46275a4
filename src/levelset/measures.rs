//! Measures of a contour: area, perimeter, axes, extents, integrals.

use super::contour::{Contour, Segment};
use super::quadratic::{Quadratic, barycentric_direction};
use crate::base::{Error, Result};
use crate::fem::{At, Space, gauss_legendre};
use crate::mesh::Point;
use nalgebra::SVector;

/// Gauss points on a segment. Four make the second moments of the region under a parabola exact
/// (degree 7).
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
    /// Direction of its larger axis in degrees, counterclockwise from x, in (-90, 90]. Without
    /// meaning for a circle.
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

impl ContourPoint {
    /// The point with its number in a list.
    pub(super) fn at(&self, q: usize) -> At<2> {
        let (cell, barycentric) = (self.cell as usize, self.barycentric);
        At { cell, q, barycentric, x: self.point, weight: self.weight }
    }
}

impl Contour {
    /// Length of the contour.
    pub fn perimeter(&self) -> f64 {
        let gauss = gauss_legendre(GAUSS);
        self.segments()
            .iter()
            .map(|s| gauss.iter().map(|&(t, w)| w * s.derivative(t).norm()).sum::<f64>())
            .sum()
    }

    /// Area, perimeter, centroid, axes and extents. The integrals over `phi < 0` become integrals
    /// over its boundary by Green's theorem, exact for the parabolic segments.
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
        if area <= 0.0 {
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
            let mut box_ =
                (low.inf(&s.points[0]).inf(&s.points[2]), high.sup(&s.points[0]).sup(&s.points[2]));
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

    /// Quadrature points: Gauss points of the segments, moved along the normal onto the P2 zero set
    /// of `phi`, which must be the function that the contour was made from.
    pub fn quadrature(&self, space: &Space<2>, phi: &[f64]) -> Vec<ContourPoint> {
        let gauss = gauss_legendre(GAUSS);
        self.segments()
            .iter()
            .flat_map(|s| gauss.iter().map(|&(t, w)| quadrature_point(space, phi, s, t, w)))
            .collect()
    }

    /// Integral of `f(cell, barycentric coordinates, point)` over the contour of `phi`, by
    /// [`Contour::quadrature`].
    pub fn integrate(
        &self,
        space: &Space<2>,
        phi: &[f64],
        f: impl Fn(u32, &[f64; 4], &Point<2>) -> f64,
    ) -> f64 {
        self.quadrature(space, phi)
            .iter()
            .map(|q| q.weight * f(q.cell, &q.barycentric, &q.point))
            .sum()
    }
}

fn quadrature_point(
    space: &Space<2>,
    phi: &[f64],
    segment: &Segment,
    t: f64,
    w: f64,
) -> ContourPoint {
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
    ContourPoint {
        cell: segment.cell,
        barycentric: l,
        point,
        normal: across / length,
        weight: w * length,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::levelset::{Circle, Ellipse, Shape, signed_distance};
    use crate::mesh::{Diagonals, disc, rectangle};
    use proptest::prelude::*;
    use std::f64::consts::PI;
    use std::sync::Arc;

    const PERIMETER: f64 = 3.966359897;

    fn p(x: f64, y: f64) -> Point<2> {
        Point::<2>::new(x, y)
    }
    fn cut(n: usize, shape: &dyn Shape<2>) -> (Space<2>, Vec<f64>, Contour) {
        let space = Space::new(
            &Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [n, n], Diagonals::Right).unwrap()),
            Element::P2,
        );
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

    /// Root mean square of the relative errors over eight placements of the ellipse .75 / .5: on a
    /// single one the error falls unevenly. Perimeter, area, larger and smaller semi-axis, extents,
    /// half-chord, integral of x^2, centroid, angle.
    fn errors(n: usize) -> [f64; 9] {
        // int x^2 ds in the frame of the ellipse, by the trapezoidal rule, which is exact here to
        // rounding.
        let k = 4000;
        let moment: f64 = (0..k)
            .map(|i| 2.0 * PI * i as f64 / k as f64)
            .map(|t| {
                (0.75 * t.cos()).powi(2) * (0.75 * t.sin()).hypot(0.5 * t.cos()) * 2.0 * PI
                    / k as f64
            })
            .sum();
        let mut sums = [0.0; 9];
        for i in 0..8 {
            let (centre, angle) =
                (p(1.0 + 0.011 * f64::from(i), 1.0 - 0.017 * f64::from(i)), 23.0 * f64::from(i));
            let shape = Ellipse::new(centre, p(0.75, 0.5), angle).unwrap();
            let (space, phi, c) = cut(n, &shape);
            let m = c.measures().unwrap();
            let (sine, cosine) = angle.to_radians().sin_cos();
            let axis = p(cosine, sine);
            let half = (shape.bounds().1 - shape.bounds().0) * 0.5;
            let integral = c.integrate(&space, &phi, |_, _, x| (x - centre).dot(&axis).powi(2));
            let relative = |a: f64, b: f64| a / b - 1.0;
            let e = [
                relative(m.perimeter, PERIMETER),
                relative(m.area, PI * 0.375),
                relative(m.axis_1, 0.75),
                relative(m.axis_2, 0.5),
                relative(m.extent_x, half[0]).hypot(relative(m.extent_y, half[1])),
                relative(c.half_chord(&space, &phi, &centre, &axis).unwrap(), 0.75),
                relative(integral, moment),
                (m.centroid - centre).norm(),
                (m.angle - angle).to_radians().sin(),
            ];
            e.iter().zip(&mut sums).for_each(|(e, s)| *s += e * e / 8.0);
            assert!(m.angle > -90.0 && m.angle <= 90.0, "{}", m.angle);
        }
        sums.map(f64::sqrt)
    }

    #[test]
    fn the_measures_of_an_ellipse_converge() {
        let meshes = [15, 30, 60, 120];
        let e = meshes.map(errors);
        // Integrals gain on the interpolation of phi, of order 3, by cancellation; the others are
        // pointwise.
        let bounds = [
            ("perimeter", 1.5e-8, 3.2..4.0),
            ("area", 2e-8, 3.2..4.0),
            ("axis_1", 2e-8, 3.2..4.0),
            ("axis_2", 1e-8, 3.2..4.0),
            ("extents", 3e-7, 2.8..3.6),
            ("half-chord", 4e-7, 2.8..3.6),
            ("integral of x^2", 6e-8, 3.2..4.0),
            ("centroid", 1.5e-8, 3.0..4.0),
            ("angle", 3e-8, 3.2..4.0),
        ];
        for (k, (name, last, slope)) in bounds.into_iter().enumerate() {
            let errors = e.map(|e| e[k]);
            let order = order(&meshes, &errors);
            assert!(
                errors[3] < last && slope.contains(&order),
                "{name}: {errors:?}, order {order}"
            );
        }
    }

    #[test]
    fn a_level_function_in_the_space_shows_the_error_of_the_segments_alone() {
        let meshes = [15, 30, 60];
        let e = meshes.map(|n| {
            let space = Space::new(
                &Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [n, n], Diagonals::Right).unwrap()),
                Element::P2,
            );
            let phi = space.interpolate(|x| {
                ((x[0] - 1.03) / 0.75).powi(2) + ((x[1] - 0.98) / 0.5).powi(2) - 1.0
            });
            let c = Contour::new(&space, &phi).unwrap();
            let m = c.measures().unwrap();
            // The half-chord comes from phi itself, exact here.
            let half = c.half_chord(&space, &phi, &p(1.03, 0.98), &p(1.0, 1.0)).unwrap();
            assert!((half - (2.0 / (1.0 / 0.5625 + 1.0 / 0.25f64)).sqrt()).abs() < 1e-14);
            c.quadrature(&space, &phi).iter().for_each(|q| {
                assert!(space.value(&phi, q.cell as usize, &q.barycentric).abs() < 1e-14)
            });
            [
                (m.perimeter / PERIMETER - 1.0).abs(),
                (m.area / (PI * 0.375) - 1.0).abs(),
                (m.axis_1 / 0.75 - 1.0).abs(),
            ]
        });
        for k in 0..3 {
            let order = order(&meshes, &e.map(|e| e[k]));
            assert!(e[2][k] < 3e-9 && (3.4..4.4).contains(&order), "{e:?} {order}");
        }
    }

    #[test]
    fn a_region_cut_off_by_the_walls_is_measured_up_to_them() {
        // A quarter of a disc around a corner, and the domain outside of it.
        for outside in [false, true] {
            let space = Space::new(
                &Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [20, 20], Diagonals::Right).unwrap()),
                Element::P2,
            );
            let sign = if outside { -1.0 } else { 1.0 };
            let phi = space.interpolate(|x| sign * (x.norm_squared() - 0.81));
            let c = Contour::new(&space, &phi).unwrap();
            let m = c.measures().unwrap();
            let quarter = PI * 0.81 / 4.0;
            let first = 0.9f64.powi(3) / 3.0;
            let (area, first) =
                if outside { (4.0 - quarter, 4.0 - first) } else { (quarter, first) };
            assert!((m.area - area).abs() < 1e-7);
            assert!((m.perimeter - 0.45 * PI).abs() < 1e-7);
            assert!((m.centroid - p(first, first) / area).norm() < 1e-7);
            assert!((m.extent_x - 0.45).abs() < 1e-9);
            assert!(!c.lines()[0].closed);
        }
    }

    #[test]
    fn the_measures_do_not_need_a_regular_mesh() {
        let space = Space::new(&Arc::new(disc([0.3, -0.2], 1.0, 20).unwrap()), Element::P2);
        let phi =
            signed_distance(&space, &Ellipse::new(p(0.25, -0.15), p(0.6, 0.4), 30.0).unwrap());
        let m = Contour::new(&space, &phi).unwrap().measures().unwrap();
        assert!((m.area / (PI * 0.24) - 1.0).abs() < 1e-5);
        assert!((m.axis_1 / 0.6 - 1.0).abs() < 1e-5 && (m.axis_2 / 0.4 - 1.0).abs() < 1e-5);
        assert!((m.centroid - p(0.25, -0.15)).norm() < 1e-5 && (m.angle - 30.0).abs() < 1e-2);
        // A contour that leaves through a polygonal wall: the set is the whole polygon less the
        // half of it.
        let phi = space.interpolate(|x| x[0] - 0.3);
        let m = Contour::new(&space, &phi).unwrap().measures().unwrap();
        assert!((2.0 * m.area / space.mesh().volume() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn no_interface_is_an_error() {
        let space = Space::new(
            &Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [4, 4], Diagonals::Right).unwrap()),
            Element::P2,
        );
        for v in [1.0, -1.0] {
            let c = Contour::new(&space, &vec![v; space.len()]).unwrap();
            assert!(c.is_empty());
            assert!(c.measures().unwrap_err().to_string().contains("no interface"));
            assert!(
                c.half_chord(&space, &vec![v; space.len()], &p(1.0, 1.0), &p(1.0, 0.0)).is_none()
            );
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        /// Gauss' theorem on the contour: the normals add up to 0, and x . n to twice the area.
        #[test]
        fn circles_anywhere_are_measured(cx in 0.7..1.3f64, cy in 0.7..1.3f64, r in 0.2..0.6f64, stretch in 0.3..3.0f64) {
            let shape = Circle::new(p(cx, cy), r).unwrap();
            let space = Space::new(&Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [30, 30], Diagonals::Right).unwrap()), Element::P2);
            let phi: Vec<f64> = signed_distance(&space, &shape).iter().map(|d| stretch * d).collect();
            let c = Contour::new(&space, &phi).unwrap();
            let m = c.measures().unwrap();
            // Of order (h / r)^3.
            let tolerance = 2e-6 / r.powi(3);
            prop_assert!((m.area / (PI * r * r) - 1.0).abs() < tolerance);
            prop_assert!((m.perimeter / (2.0 * PI * r) - 1.0).abs() < tolerance);
            prop_assert!((m.axis_1 / r - 1.0).abs() < tolerance && (m.axis_2 / r - 1.0).abs() < tolerance);
            prop_assert!((m.centroid - p(cx, cy)).norm() < tolerance);
            let points = c.quadrature(&space, &phi);
            let sum: Point<2> = points.iter().map(|q| q.normal * q.weight).sum();
            prop_assert!(sum.norm() < 1e-12);
            let flux: f64 = points.iter().map(|q| q.weight * q.normal.dot(&q.point)).sum();
            prop_assert!((flux / (2.0 * m.area) - 1.0).abs() < tolerance);
            for q in &points {
                prop_assert!(q.normal.dot(&(q.point - p(cx, cy))) > 0.99 * r);
            }
        }

        /// Every half-chord through the centre of a circle is its radius; along mesh lines and
        /// through nodes too.
        #[test]
        fn half_chords_of_a_circle_are_its_radius(turn in 0.0..360.0f64, eighth in 0..8i32) {
            let shape = Circle::new(p(1.0, 1.0), 0.6).unwrap();
            let (space, phi, c) = cut(20, &shape);
            for angle in [turn.to_radians(), f64::from(eighth) * 0.25 * PI] {
                let half = c.half_chord(&space, &phi, &p(1.0, 1.0), &(p(angle.cos(), angle.sin()) * 7.0)).unwrap();
                // The interpolation error of phi at the middle of a diagonal edge.
                prop_assert!((half - 0.6).abs() < 2e-4, "{}", half);
            }
            prop_assert!(c.half_chord(&space, &phi, &p(1.0, 1.0), &p(0.0, 0.0)).is_none());
            prop_assert!(c.half_chord(&space, &phi, &p(1.9, 1.0), &p(1.0, 0.1)).is_none());
        }
    }
}
