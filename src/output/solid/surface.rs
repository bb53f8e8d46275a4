//! Lit surfaces of triangles, coloured by a number or by the pattern of the material.

use super::super::colours::Colours;
use super::camera::{Camera, in_space};
use super::canvas::Facet;
use super::light::Lights;
use super::pattern::Pattern;
use crate::base::{Error, Result};
use crate::mesh::Point;
use nalgebra::SVector;

/// A surface of flat triangles, lit as if it were as smooth as its normals.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The points.
    pub points: Vec<Point<3>>,
    /// The outward normal at each point, of any length but zero.
    pub normals: Vec<SVector<f64, 3>>,
    /// Three point numbers a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Its colours.
    pub paint: Paint,
}

/// Colours of a surface.
#[derive(Clone, Debug)]
pub enum Paint {
    /// One colour, red, green and blue.
    Plain([u8; 3]),
    /// By a number at each point, in the scale of the picture.
    Scalar(Vec<f64>),
    /// By where the material of each point was in the reference state, and the pattern that it had
    /// there.
    Checkerboard {
        /// The backward characteristic Y at each point.
        material: Vec<Point<3>>,
        /// The pattern of the reference state.
        pattern: Pattern,
    },
}

impl Paint {
    /// A light grey blue that leaves the colours to other things.
    pub const PLAIN: Paint = Paint::Plain([176, 196, 214]);
}

/// The two colours of a checkerboard.
const CHECKERS: [[f32; 3]; 2] = [[246.0, 240.0, 226.0], [40.0, 84.0, 138.0]];

impl Surface {
    /// # Errors
    /// Numbers of values, or of points, that do not fit.
    pub(super) fn check(&self) -> Result<()> {
        let n = self.points.len();
        let values = match &self.paint {
            Paint::Plain(_) => n,
            Paint::Scalar(f) => f.len(),
            Paint::Checkerboard { material, .. } => material.len(),
        };
        let largest = self.triangles.iter().flatten().max().map_or(0, |&k| k as usize + 1);
        if self.normals.len() == n && values == n && largest <= n {
            return Ok(());
        }
        let lengths = format!(
            "{n} points, {} normals, {values} values, points to {largest}",
            self.normals.len()
        );
        Err(Error::internal("the arrays of a surface do not fit together").value(lengths))
    }
    /// Its triangles in the picture.
    pub(super) fn facets(&self, camera: &Camera, part: u32) -> Vec<Facet> {
        let spots: Vec<_> = self.points.iter().map(|p| camera.project(p)).collect();
        let facet = |(i, t): (usize, &[u32; 3])| Facet {
            spots: t.map(|k| spots[k as usize]),
            part,
            number: i as u32,
        };
        self.triangles.iter().enumerate().map(facet).collect()
    }
    /// Its colour at a point of a triangle, whose corners have the weights `l` in the picture.
    pub(super) fn shade(
        &self,
        f: &Facet,
        l: [f64; 3],
        camera: &Camera,
        lights: &Lights,
        bar: &Colours,
    ) -> [f32; 3] {
        let triangle = self.triangles[f.number as usize].map(|k| k as usize);
        let l = in_space(&f.spots, l);
        let at = |f: &[SVector<f64, 3>]| {
            f[triangle[0]] * l[0] + f[triangle[1]] * l[1] + f[triangle[2]] * l[2]
        };
        let rgb = match &self.paint {
            Paint::Plain(rgb) => rgb.map(f32::from),
            Paint::Scalar(f) => bar.of((0..3).map(|k| l[k] * f[triangle[k]]).sum()).map(f32::from),
            Paint::Checkerboard { material, pattern } => {
                CHECKERS[usize::from(pattern.is_odd(&at(material)))]
            }
        };
        let (n, eye) = (at(&self.normals), camera.to_eye(&at(&self.points)));
        let n = n.try_normalize(0.0).unwrap_or(eye) * self.side(triangle, &eye);
        lights.shade(rgb, &n, &eye)
    }
    /// 1 where a triangle is seen from outside, -1 from inside, where the other side is lit. At the
    /// rim of a body normals may point a little away from the viewer.
    fn side(&self, [a, b, c]: [usize; 3], eye: &SVector<f64, 3>) -> f64 {
        let n = self.normals[a] + self.normals[b] + self.normals[c];
        if n.dot(eye) < -0.25 * n.norm() { -1.0 } else { 1.0 }
    }
}
