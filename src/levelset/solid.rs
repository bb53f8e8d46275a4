//! Measures of a surface: volume, area, axes, extents.

use super::isosurface::Isosurface;
use super::patch::Triangle;
use crate::base::{Error, Result, parallel};
use crate::fem::Rule;
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};

/// Degree at which the second moments of the region under a curved triangle are exact: cubes of
/// quadratic functions times two tangents.
const DEGREE: usize = 8;

/// Geometry of the set `phi < 0` in space and of its surface, in the units of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidMeasures {
    /// Volume of the set `phi < 0`, cut off at the boundary of the mesh.
    pub volume: f64,
    /// Area of the surface; the boundary of the mesh does not count.
    pub surface: f64,
    /// Centroid of the set.
    pub centroid: Point<3>,
    /// Largest semi-axis of the ellipsoid that has the same volume-weighted second moments as the
    /// set.
    pub axis_1: f64,
    /// Middle semi-axis of that ellipsoid.
    pub axis_2: f64,
    /// Smallest semi-axis of that ellipsoid.
    pub axis_3: f64,
    /// Directions of its axes, largest axis first, orthonormal, each with its largest component
    /// positive. Arbitrary for equal axes.
    pub directions: [SVector<f64, 3>; 3],
    /// Half the extent of the surface in x.
    pub extent_x: f64,
    /// Half the extent of the surface in y.
    pub extent_y: f64,
    /// Half the extent of the surface in z.
    pub extent_z: f64,
}

impl Isosurface {
    /// Area of the surface.
    pub fn area(&self) -> f64 {
        let rule = Rule::simplex(2, DEGREE);
        let of = |t: &Triangle| {
            rule.points.iter().zip(&rule.weights).map(|(p, w)| w * t.area_vector(p).norm()).sum()
        };
        parallel::sum(self.triangles().len(), |i| [of(&self.triangles()[i])])[0]
    }

    /// Volume, area, centroid, axes and extents. The integrals over `phi < 0` become integrals over
    /// its boundary by the divergence theorem, exact for the curved triangles.
    ///
    /// # Errors
    /// No surface, or a set without volume.
    pub fn measures(&self) -> Result<SolidMeasures> {
        let Some((low, high)) = self.bounds() else {
            return Err(Error::computation(
                "there is no interface: the level set does not change its sign in the mesh",
            )
            .remedy("the structure is smaller than a cell, or has left the domain"));
        };
        // Moments about a point nearby, against cancellation.
        let origin = (low + high) * 0.5;
        let [volume, x, y, z, xx, yy, zz, xy, yz, zx] = self.moments(&origin);
        if volume <= 0.0 {
            return Err(Error::computation("the interface encloses no volume").value(volume));
        }
        let shift = SVector::<f64, 3>::new(x, y, z) / volume;
        let second = SMatrix::<f64, 3, 3>::new(xx, xy, zx, xy, yy, yz, zx, yz, zz) / volume;
        let (axes, directions) = principal(&(second - shift * shift.transpose()));
        let half = (high - low) * 0.5;
        Ok(SolidMeasures {
            volume,
            surface: self.area(),
            centroid: origin + shift,
            axis_1: axes[0],
            axis_2: axes[1],
            axis_3: axes[2],
            directions,
            extent_x: half[0],
            extent_y: half[1],
            extent_z: half[2],
        })
    }

    /// Lower and upper corner of the box around the surface, extremes inside of triangles included.
    pub fn bounds(&self) -> Option<(Point<3>, Point<3>)> {
        let first = self.triangles().first()?.points[0];
        Some(self.triangles().iter().fold((first, first), |(mut low, mut high), t| {
            for axis in 0..3 {
                let (least, most) = t.range(axis);
                (low[axis], high[axis]) = (low[axis].min(least), high[axis].max(most));
            }
            (low, high)
        }))
    }

    /// `int 1, x, y, z, x^2, y^2, z^2, x y, y z, z x` over the set `phi < 0`, with coordinates from
    /// `origin`.
    fn moments(&self, origin: &Point<3>) -> [f64; 10] {
        let rule = Rule::simplex(2, DEGREE);
        let of = |t: &Triangle| {
            let mut m = [0.0; 10];
            for (p, w) in rule.points.iter().zip(&rule.weights) {
                let (d, n) = (t.point(p) - origin, t.area_vector(p) * *w);
                let (x, y, z) = (d[0], d[1], d[2]);
                m[0] += d.dot(&n) / 3.0;
                for i in 0..3 {
                    m[1 + i] += 0.5 * d[i] * d[i] * n[i];
                    m[4 + i] += d[i] * d[i] * d[i] * n[i] / 3.0;
                }
                m[7] += 0.5 * x * x * y * n[0];
                m[8] += 0.5 * y * y * z * n[1];
                m[9] += 0.5 * z * z * x * n[2];
            }
            m
        };
        let surface = parallel::sum(self.triangles().len(), |i| of(&self.triangles()[i]));
        let walls = parallel::sum(self.walls().len(), |i| of(&self.walls()[i]));
        std::array::from_fn(|k| surface[k] + walls[k])
    }
}

/// Semi-axes of the ellipsoid with these central second moments per volume, largest first, and
/// their directions.
fn principal(moments: &SMatrix<f64, 3, 3>) -> ([f64; 3], [SVector<f64, 3>; 3]) {
    let eigen = moments.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    // int x^2 over an ellipsoid is volume a^2 / 5.
    let axes = order.map(|k| (5.0 * eigen.eigenvalues[k].max(0.0)).sqrt());
    let directions = order.map(|k| {
        let v: SVector<f64, 3> = eigen.eigenvectors.column(k).into_owned();
        v * v[v.iamax()].signum()
    });
    (axes, directions)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Element, Space};
    use crate::levelset::{Circle, signed_distance};
    use crate::mesh::box_mesh;
    use std::f64::consts::PI;
    use std::sync::Arc;

    fn p(x: f64, y: f64, z: f64) -> Point<3> {
        Point::<3>::new(x, y, z)
    }
    fn space(n: usize) -> Space<3> {
        Space::new(&Arc::new(box_mesh([-1.0; 3], [1.0; 3], [n, n, n]).unwrap()), Element::P2)
    }
    /// Observed orders between meshes of half the edge length.
    fn orders(e: [[f64; 5]; 3]) -> [[f64; 2]; 5] {
        std::array::from_fn(|k| [(e[0][k] / e[1][k]).log2(), (e[1][k] / e[2][k]).log2()])
    }

    #[test]
    fn the_measures_of_a_sphere_converge() {
        // Root mean squares over eight positions: for a single one the error decreases unevenly.
        let r = 0.55;
        let e = [6, 12, 24].map(|n| {
            let space = space(n);
            let mut sums = [0.0; 5];
            for i in 0..8 {
                let s = f64::from(i);
                let centre = p(0.011 * s, -0.017 * s, 0.023 * s - 0.05);
                let phi = signed_distance(&space, &Circle::new(centre, r).unwrap());
                let surface = Isosurface::new(&space, &phi).unwrap();
                let m = surface.measures().unwrap();
                let half =
                    surface.half_chord(&space, &phi, &centre, &p(1.0, 0.3 * s, -0.7)).unwrap();
                let e = [
                    m.volume / (4.0 / 3.0 * PI * r.powi(3)) - 1.0,
                    m.surface / (4.0 * PI * r * r) - 1.0,
                    m.axis_1 / r - 1.0,
                    (m.centroid - centre).norm(),
                    (m.extent_z / r - 1.0).hypot(half / r - 1.0),
                ];
                e.iter().zip(&mut sums).for_each(|(e, s)| *s += e * e / 8.0);
            }
            sums.map(f64::sqrt)
        });
        let orders = orders(e);
        let bounds = [4e-6, 5e-6, 2e-5, 2e-6, 6e-5];
        assert!(
            (0..5).all(|k| e[2][k] < bounds[k]) && orders.iter().all(|o| o[1] > 3.4),
            "{e:?} {orders:?}"
        );
    }

    #[test]
    fn an_ellipsoid_in_the_space_shows_the_error_of_the_triangles_alone() {
        let (axes, centre) = (p(0.8, 0.6, 0.45), p(0.03, -0.02, 0.04));
        let turn = nalgebra::Rotation3::new(p(0.3, -0.5, 0.7));
        // Surface of the ellipsoid by products of the trapezoidal and Gauss' rules in its
        // parameters.
        let mut area = 0.0;
        for (z, w) in crate::fem::gauss_legendre(60) {
            let z = 2.0 * z - 1.0;
            for k in 0..200 {
                let t = PI * f64::from(k) / 100.0;
                let n = p((1.0 - z * z).sqrt() * t.cos(), (1.0 - z * z).sqrt() * t.sin(), z)
                    .component_div(&axes);
                area += n.norm() * axes.product() * 2.0 * w * PI / 100.0;
            }
        }
        let e = [6, 12, 24].map(|n| {
            let space = space(n);
            let phi = space.interpolate(|x| {
                turn.inverse_transform_vector(&(x - centre)).component_div(&axes).norm_squared()
                    - 1.0
            });
            let s = Isosurface::new(&space, &phi).unwrap();
            let m = s.measures().unwrap();
            assert!(
                (0..3).all(|i| turn.matrix().column(i).dot(&m.directions[i]).abs() > 1.0 - 1e-4),
                "{m:?}"
            );
            let direction = p(0.4, -0.5, 0.6).normalize();
            let local = turn.inverse_transform_vector(&direction).component_div(&axes).norm();
            let half = s.half_chord(&space, &phi, &centre, &direction).unwrap();
            assert!((half * local - 1.0).abs() < 1e-13, "phi is in the space: {half}");
            assert!(s.half_chord(&space, &phi, &p(0.9, 0.9, 0.9), &p(1.0, 0.1, 0.0)).is_none());
            assert!(s.half_chord(&space, &phi, &centre, &p(0.0, 0.0, 0.0)).is_none());
            let extent =
                (0..3).map(|i| turn.matrix()[(0, i)] * axes[i]).map(|v| v * v).sum::<f64>().sqrt();
            [
                (m.volume / (4.0 / 3.0 * PI * axes.product()) - 1.0).abs(),
                (m.surface / area - 1.0).abs(),
                [m.axis_1 / axes[0], m.axis_2 / axes[1], m.axis_3 / axes[2]]
                    .map(|a| (a - 1.0).abs())
                    .iter()
                    .sum(),
                (m.centroid - centre).norm(),
                (m.extent_x / extent - 1.0).abs(),
            ]
        });
        let orders = orders(e);
        let bounds = [3e-7, 3e-7, 5e-7, 1e-8, 1e-8];
        assert!(
            (0..5).all(|k| e[2][k] < bounds[k]) && orders.iter().take(4).all(|o| o[1] > 3.8),
            "{e:?} {orders:?}"
        );
    }

    #[test]
    fn a_region_cut_off_by_the_walls_is_measured_up_to_them() {
        // An eighth of a ball about a corner, and the box outside of it.
        for outside in [false, true] {
            let space = space(12);
            let sign = if outside { -1.0 } else { 1.0 };
            let r: f64 = 0.93;
            let phi = space.interpolate(|x| sign * (x.add_scalar(1.0).norm_squared() - r * r));
            let m = Isosurface::new(&space, &phi).unwrap().measures().unwrap();
            let (eighth, first) = (PI * r.powi(3) / 6.0, PI * r.powi(4) / 16.0);
            let (volume, first) =
                if outside { (8.0 - eighth, 8.0 - first) } else { (eighth, first) };
            assert!((m.volume - volume).abs() < 2e-7, "{m:?}");
            assert!((m.surface - 0.5 * PI * r * r).abs() < 4e-7, "{m:?}");
            assert!(
                (m.centroid.add_scalar(1.0) - p(first, first, first) / volume).norm() < 1e-7,
                "{m:?}"
            );
            assert!((m.extent_x - 0.5 * r).abs() < 1e-14, "{m:?}");
        }
    }
}
