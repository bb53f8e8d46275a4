//! The oscillation of a drop that is nearly round, against the modes of two viscous fluids.

use crate::case::Case;
use nalgebra::{Complex, Matrix6};
use std::f64::consts::PI;

type C = Complex<f64>;

/// `I_n(z)` by the trapezoidal rule on its integral, which converges faster than any power.
fn bessel_i(n: f64, z: C) -> C {
    const POINTS: usize = 200;
    let term = |j: usize| {
        let angle = PI * j as f64 / POINTS as f64;
        let end = if j == 0 || j == POINTS { 0.5 } else { 1.0 };
        (z * angle.cos()).exp() * (end * (n * angle).cos() / POINTS as f64)
    };
    (0..=POINTS).map(term).sum()
}

/// `K_n(z)`, the same on `int_0^inf exp(-z cosh t) cosh(n t) dt`.
fn bessel_k(n: f64, z: C) -> C {
    const STEP: f64 = 0.02;
    let term = |j: usize| {
        let t = j as f64 * STEP;
        let end = if j == 0 { 0.5 } else { 1.0 };
        (-z * t.cosh()).exp() * (end * STEP * (n * t).cosh())
    };
    (0..400).map(term).sum()
}

/// A drop of radius `r` in a round box of radius `wall` without slip; densities and viscosities
/// inside and outside.
struct Drop {
    n: f64,
    r: f64,
    wall: f64,
    density: [f64; 2],
    viscosity: [f64; 2],
    tension: f64,
}

impl Drop {
    /// A stream function `f(r) sin n theta` of the linearised equations for `exp(s t)`, one of
    /// `r^n`, `r^-n`, `I_n(k r)`, `K_n(k r)`, `k^2 = s rho/mu`, with two derivatives.
    fn stream(&self, kind: usize, k: C, r: f64) -> [C; 3] {
        let (n, real) = (self.n, |v: f64| C::new(v, 0.0));
        match kind {
            0 => [r.powf(n), n * r.powf(n - 1.0), n * (n - 1.0) * r.powf(n - 2.0)].map(real),
            1 => [r.powf(-n), -n * r.powf(-n - 1.0), n * (n + 1.0) * r.powf(-n - 2.0)].map(real),
            _ => {
                let z = k * r;
                let (f, slope) = if kind == 2 {
                    (bessel_i(n, z), k * (bessel_i(n - 1.0, z) + bessel_i(n + 1.0, z)) * 0.5)
                } else {
                    (bessel_k(n, z), -k * (bessel_k(n - 1.0, z) + bessel_k(n + 1.0, z)) * 0.5)
                };
                [f, slope, (k * k + n * n / (r * r)) * f - slope / r]
            }
        }
    }

    /// The determinant of the conditions at the interface (velocity, shear stress and normal
    /// stress, with `s zeta = u_r` and the curvature `(n^2 - 1) zeta/r^2`) and at the wall; zero
    /// where `s` belongs to a mode.
    fn determinant(&self, s: C) -> C {
        let (n, r) = (self.n, self.r);
        let columns: [(usize, usize); 6] = [(0, 0), (0, 2), (1, 0), (1, 1), (1, 2), (1, 3)];
        let mut m = Matrix6::<C>::zeros();
        for (j, (side, kind)) in columns.into_iter().enumerate() {
            let (rho, mu) = (self.density[side], self.viscosity[side]);
            let k = (s * rho / mu).sqrt();
            let [f, slope, bend] = self.stream(kind, k, r);
            let pressure = if kind < 2 { -s * slope * (rho * r / n) } else { C::new(0.0, 0.0) };
            let (radial, along) = (f * (n / r), -slope);
            let normal = -pressure + (slope / r - f / (r * r)) * (2.0 * mu * n);
            let shear = (-bend - along / r - radial * (n / r)) * mu;
            let sign = if side == 1 { 1.0 } else { -1.0 };
            let pull = radial / s * (self.tension * (n * n - 1.0) / (r * r));
            let normal = if side == 0 { -normal - pull } else { normal };
            let [at_wall, along_wall, _] =
                if side == 1 { self.stream(kind, k, self.wall) } else { [C::new(0.0, 0.0); 3] };
            let column = [radial * sign, along * sign, shear * sign, normal, at_wall, along_wall];
            let scale = column.iter().map(|c| c.norm()).fold(0.0, f64::max);
            (0..6).for_each(|i| m[(i, j)] = column[i] / scale);
        }
        m.determinant()
    }

    /// The mode near `s`, by the secant rule.
    fn mode(&self, s: C) -> C {
        let (mut a, mut b) = (s, s * C::new(1.0, 1e-3));
        let (mut fa, mut fb) = (self.determinant(a), self.determinant(b));
        for _ in 0..60 {
            let next = b - fb * (b - a) / (fb - fa);
            (a, fa) = (b, fb);
            (b, fb) = (next, self.determinant(next));
            if (b - a).norm() < 1e-10 * b.norm() {
                break;
            }
        }
        b
    }

    /// Frequency without viscosity, with the mass that the wall adds.
    fn inviscid(&self) -> f64 {
        let n = self.n;
        let q = (self.r / self.wall).powf(2.0 * n);
        let mass = self.density[0] + self.density[1] * (1.0 + q) / (1.0 - q);
        (n * (n * n - 1.0) * self.tension / (mass * self.r.powi(3))).sqrt()
    }
}

const DROP: Drop =
    Drop { n: 2.0, r: 0.5, wall: 1.0, density: [1.0; 2], viscosity: [0.01; 2], tension: 1.0 };

/// The modes tend to those without viscosity, like its square root.
#[test]
fn the_modes_have_the_inviscid_limit() {
    let frequency = |mu: f64| {
        let drop = Drop { viscosity: [mu; 2], ..DROP };
        drop.mode(C::new(-0.1, DROP.inviscid())).im / DROP.inviscid() - 1.0
    };
    let [a, b] = [1e-3, 2.5e-4].map(frequency);
    println!(
        "modes of a drop: frequency over the inviscid one {a:.4}, {b:.4} at viscosities 1e-3, \
         2.5e-4"
    );
    assert!(a.abs() < 0.06 && (a / b - 2.0).abs() < 0.2, "{a} {b}");
}

/// Damping rate and frequency of `y`, sampled every `dt`, by its extremes and zeros after the first
/// half period.
fn fit(y: &[f64], dt: f64) -> C {
    let (mut zeros, mut peaks) = (Vec::new(), Vec::new());
    for i in 1..y.len() - 1 {
        if y[i - 1] * y[i] < 0.0 {
            zeros.push((i as f64 - y[i] / (y[i] - y[i - 1])) * dt);
        }
        let (left, right) = (y[i - 1], y[i + 1]);
        if y[i].abs() >= left.abs() && y[i].abs() > right.abs() {
            let (bend, slope) = (0.5 * (left - 2.0 * y[i] + right), 0.5 * (right - left));
            peaks.push((
                (i as f64 - 0.5 * slope / bend) * dt,
                (y[i] - 0.25 * slope * slope / bend).abs(),
            ));
        }
    }
    let ([first, .., last], [low, .., high]) = (&zeros[1..], &peaks[1..]) else {
        panic!("{zeros:?} {peaks:?}")
    };
    let frequency = PI * (zeros.len() - 2) as f64 / (last - first);
    C::new(-(low.1 / high.1).ln() / (high.0 - low.0), frequency)
}

/// Frequency and damping of a drop elongated by 1 % are those of linear theory within 1 %.
#[test]
fn a_drop_oscillates_as_linear_theory_says() {
    let mut case = Case::new(
        "mesh.disc = { centre = [0, 0], radius = 1, cells = 30 }
        fluid.viscosity = 0.01
        time = { end = 3.2, step = 0.005 }
        numerics.pressure = \"P1+P0\"
        [[drop]]
        shape.ellipse = { centre = [0, 0], semi_axes = [0.505, 0.4950495] }
        tension = 1
        chords.x = { through = [0, 0], direction = [1, 0] }
        chords.y = { through = [0, 0], direction = [0, 1] }",
    );
    let (area, dt) = (case.get("drop.area"), 0.02);
    let elongation = |case: &Case| (case.get("drop.x") / case.get("drop.y")).ln();
    let mut y = vec![elongation(&case)];
    for _ in 0..160 {
        case.steps(4);
        y.push(elongation(&case));
    }
    let (found, exact) = (fit(&y, dt), DROP.mode(C::new(-0.4, 4.4)));
    let error = |a: f64, b: f64| a / b - 1.0;
    let (damping, frequency) = (error(found.re, exact.re), error(found.im, exact.im));
    let lost = case.get("drop.area") / area - 1.0;
    println!(
        "drop: damping {:.4} ({damping:+.2e}), frequency {:.4} ({frequency:+.2e}), exact {:.4}, \
         {:.4}; area {lost:+.1e}",
        -found.re, found.im, -exact.re, exact.im
    );
    assert!(damping.abs() < 0.01 && frequency.abs() < 0.01 && lost.abs() < 5e-4);
}
