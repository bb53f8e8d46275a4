//! Exact solutions.

use crate::tools::point;
use immersa::mesh::Point;
use nalgebra::{SMatrix, SVector};

pub type V = SVector<f64, 2>;
pub type M = SMatrix<f64, 2, 2>;

/// A Stokes flow with a body force: `u = curl(sin(2 x + 1) sin(3 y))`, `p = cos(3 x + y)`,
/// viscosity `mu`.
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

/// The Taylor-Green vortex on a period of `2 pi`, carried along by a uniform stream: an exact
/// solution of the Navier-Stokes equations without force (density 1).
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

/// Ethier and Steinman's solution of the Navier-Stokes equations in space without force (density 1;
/// Int. J. Numer. Meth. Fluids 19, 1994), with their `a = pi/4`, `d = pi/2`: a Beltrami flow, whose
/// convection is balanced by the pressure alone.
#[derive(Clone, Copy)]
pub struct EthierSteinman {
    pub viscosity: f64,
}

impl EthierSteinman {
    const A: f64 = std::f64::consts::FRAC_PI_4;
    const D: f64 = std::f64::consts::FRAC_PI_2;

    fn decay(&self, t: f64) -> f64 {
        (-self.viscosity * Self::D * Self::D * t).exp()
    }
    /// `u_i = -a [e^(a x_i) sin(a x_j + d x_k) + e^(a x_k) cos(a x_i + d x_j)]`, `i j k` in cyclic
    /// order.
    pub fn velocity(&self, x: &Point<3>, t: f64) -> SVector<f64, 3> {
        let (a, d) = (Self::A, Self::D);
        SVector::<f64, 3>::from_fn(|i, _| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            -a * ((a * x[i]).exp() * (a * x[j] + d * x[k]).sin()
                + (a * x[k]).exp() * (a * x[i] + d * x[j]).cos())
        }) * self.decay(t)
    }
    pub fn gradient(&self, x: &Point<3>, t: f64) -> SMatrix<f64, 3, 3> {
        let (a, d) = (Self::A, Self::D);
        let mut g = SMatrix::<f64, 3, 3>::zeros();
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let (e, (s, c)) = ((a * x[i]).exp(), (a * x[j] + d * x[k]).sin_cos());
            let (f, (q, r)) = ((a * x[k]).exp(), (a * x[i] + d * x[j]).sin_cos());
            g[(i, i)] = -a * a * (e * s - f * q);
            g[(i, j)] = -a * (a * e * c - d * f * q);
            g[(i, k)] = -a * (d * e * c + a * f * r);
        }
        g * self.decay(t)
    }
    /// `p = -a^2/2 sum_i [e^(2 a x_i) + 2 sin(a x_i + d x_j) cos(a x_k + d x_i) e^(a (x_j +
    /// x_k))]`.
    pub fn pressure(&self, x: &Point<3>, t: f64) -> (f64, SVector<f64, 3>) {
        let (a, d) = (Self::A, Self::D);
        let (mut p, mut g) = (0.0, SVector::<f64, 3>::zeros());
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let square = (2.0 * a * x[i]).exp();
            let (s, c) = (a * x[i] + d * x[j]).sin_cos();
            let (q, r) = (a * x[k] + d * x[i]).sin_cos();
            let e = 2.0 * (a * (x[j] + x[k])).exp();
            p += square + e * s * r;
            g[i] += 2.0 * a * square + e * (a * c * r - d * s * q);
            g[j] += e * (d * c * r + a * s * r);
            g[k] += e * (-a * s * q + a * s * r);
        }
        let scale = -0.5 * a * a * self.decay(t).powi(2);
        (p * scale, g * scale)
    }
}
