//! Exact solutions.

use crate::tools::point;
use immersa::mesh::Point;
use nalgebra::{SMatrix, SVector};

pub type V = SVector<f64, 2>;
pub type M = SMatrix<f64, 2, 2>;

/// A Stokes flow with a body force: `u = curl(sin(2 x + 1) sin(3 y))`, `p = cos(3 x + y)`, viscosity `mu`.
pub mod stokes {
    use super::*;

    pub fn velocity(x: &Point<2>) -> V {
        let (s, c) = (2.0 * x[0] + 1.0).sin_cos();
        let (t, d) = (3.0 * x[1]).sin_cos();
        V::new(3.0 * s * d, -2.0 * c * t)
    }
    pub fn gradient(x: &Point<2>) -> M {
        let (s, c) = (2.0 * x[0] + 1.0).sin_cos();
        let (t, d) = (3.0 * x[1]).sin_cos();
        M::new(6.0 * c * d, -9.0 * s * t, 4.0 * s * t, -6.0 * c * d)
    }
    pub fn pressure(x: &Point<2>) -> (f64, V) {
        let (s, c) = (3.0 * x[0] + x[1]).sin_cos();
        (c, V::new(-3.0 * s, -s))
    }
    /// `- mu lap u + grad p`, as `lap u = -13 u`.
    pub fn force(mu: f64, x: &Point<2>) -> V {
        velocity(x) * (13.0 * mu) + pressure(x).1
    }
}

/// The Taylor-Green vortex on a period of `2 pi`, carried along by a uniform stream: an exact solution of the Navier-Stokes
/// equations without force (density 1).
#[derive(Clone, Copy)]
pub struct TaylorGreen {
    pub viscosity: f64,
    pub stream: V,
}

impl TaylorGreen {
    fn place(&self, x: &Point<2>, t: f64) -> (f64, Point<2>) {
        ((-2.0 * self.viscosity * t).exp(), x - self.stream * t)
    }
    pub fn velocity(&self, x: &Point<2>, t: f64) -> V {
        let (a, x) = self.place(x, t);
        self.stream + point(x[0].sin() * x[1].cos(), -x[0].cos() * x[1].sin()) * a
    }
    pub fn gradient(&self, x: &Point<2>, t: f64) -> M {
        let (a, x) = self.place(x, t);
        let (cc, ss) = (x[0].cos() * x[1].cos(), x[0].sin() * x[1].sin());
        M::new(cc, -ss, ss, -cc) * a
    }
    pub fn pressure(&self, x: &Point<2>, t: f64) -> (f64, V) {
        let (a, x) = self.place(x, t);
        let p = 0.25 * ((2.0 * x[0]).cos() + (2.0 * x[1]).cos());
        (p * a * a, point(-0.5 * (2.0 * x[0]).sin(), -0.5 * (2.0 * x[1]).sin()) * (a * a))
    }
}
