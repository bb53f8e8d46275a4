//! The exact small capillary wave between two fluids without walls (Prosperetti 1981).

use nalgebra::Complex;
use std::f64::consts::PI;
use std::sync::LazyLock;

type C = Complex<f64>;

/// A wave `y = a(t) cos(k x)` that starts at rest, of small amplitude, between two fluids of the
/// same density and viscosity.
#[derive(Clone, Copy)]
pub struct CapillaryWave {
    pub density: f64,
    pub viscosity: f64,
    pub tension: f64,
    /// `k`, 2 pi over the wavelength.
    pub number: f64,
    /// `a(0)`.
    pub amplitude: f64,
}

impl CapillaryWave {
    /// Frequency without viscosity: `omega^2 = sigma k^3 / (2 rho)`.
    pub fn frequency(&self) -> f64 {
        (self.tension * self.number.powi(3) / (2.0 * self.density)).sqrt()
    }
    /// `e = nu k^2`.
    fn damping(&self) -> f64 {
        self.viscosity / self.density * self.number * self.number
    }
    /// The roots of `z^4 - e^{1/2} z^3 - e z^2 + e^{3/2} z + omega^2`, by Durand and Kerner's
    /// iteration.
    fn roots(&self) -> [C; 4] {
        let (e, w) = (self.damping(), self.frequency());
        let p = |z: C| (((z - e.sqrt()) * z - e) * z + e * e.sqrt()) * z + w * w;
        let mut z = [0, 1, 2, 3].map(|k| C::new(0.4, 0.9).powi(k) * w.sqrt());
        for _ in 0..200 {
            for i in 0..4 {
                let others: C = (0..4).filter(|j| *j != i).map(|j| z[i] - z[j]).product();
                z[i] -= p(z[i]) / others;
            }
        }
        z
    }
    /// The amplitude: `sum_i z_i/Z_i omega^2 a_0/(z_i^2 - e) exp((z_i^2 - e) t) erfc(z_i t^{1/2})`,
    /// `Z_i` the product of the differences of the other roots to `z_i`.
    pub fn at(&self, t: f64) -> f64 {
        let (e, w, z) = (self.damping(), self.frequency(), self.roots());
        let part = |i: usize| {
            let others: C = (0..4).filter(|j| *j != i).map(|j| z[j] - z[i]).product();
            z[i] / others * (w * w * self.amplitude) / (z[i] * z[i] - e)
                * scaled_erfc(z[i] * t.sqrt())
        };
        (-e * t).exp() * (0..4).map(part).sum::<C>().re
    }
}

const TERMS: usize = 40;

fn length() -> f64 {
    (TERMS as f64 / 2f64.sqrt()).sqrt()
}

/// The Fourier coefficients of `exp(-s^2) (L^2 + s^2)` with `s = L tan(theta/2)`.
static COEFFICIENTS: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let (points, length) = (2 * TERMS as i32, length());
    let part = |n: usize, k: i32| {
        let theta = PI * f64::from(k) / f64::from(points);
        let s = length * (0.5 * theta).tan();
        (-s * s).exp() * (length * length + s * s) * (n as f64 * theta).cos()
    };
    let coefficient =
        |n: usize| (1 - points..points).map(|k| part(n, k)).sum::<f64>() / f64::from(2 * points);
    (0..=TERMS).map(coefficient).collect()
});

/// `exp(z^2) erfc(z)` by Weideman's rational series (1994) of 40 terms.
fn scaled_erfc(z: C) -> C {
    if z.re < 0.0 {
        return 2.0 * (z * z).exp() - scaled_erfc(-z);
    }
    let length = length();
    let ratio = (length - z) / (length + z);
    let series = (1..=TERMS).rev().fold(C::new(0.0, 0.0), |sum, n| sum * ratio + COEFFICIENTS[n]);
    2.0 * series / ((length + z) * (length + z)) + 1.0 / (PI.sqrt() * (length + z))
}

const WAVE: CapillaryWave = CapillaryWave {
    density: 1.0,
    viscosity: 0.0182571749,
    tension: 1.0,
    number: 2.0 * PI,
    amplitude: 0.01,
};

#[test]
fn it_starts_at_rest_and_swings_without_viscosity() {
    assert!((WAVE.at(0.0) - 0.01).abs() < 1e-12, "{}", WAVE.at(0.0));
    let speed = (WAVE.at(1e-6) - WAVE.at(0.0)) / 1e-6;
    assert!(speed.abs() < 1e-4 * WAVE.frequency() * 0.01, "{speed}");
    let free = CapillaryWave { viscosity: 1e-10, ..WAVE };
    for t in [0.1, 0.3, 1.0] {
        let exact = 0.01 * (free.frequency() * t).cos();
        assert!((free.at(t) - exact).abs() < 1e-5, "{} {exact}", free.at(t));
    }
}

/// The Laplace transform of a sheet of force in an unbounded fluid, `a_0 s / (s^2 + omega^2 (1 -
/// (e/(s + e))^{1/2}))`: the velocity in the plane of a force `f` on it is `f k/(2 rho s) (1 -
/// (e/(s + e))^{1/2})` in the transform, and the force is `-sigma k^2 a`.
#[test]
fn its_transform_is_that_of_a_sheet_of_force() {
    let (e, w, dt) = (WAVE.damping(), WAVE.frequency(), 1e-3);
    for s in [3.0, 10.0, 30.0] {
        let of = |i: usize| (-s * dt * i as f64).exp() * WAVE.at(dt * i as f64);
        // Simpson's rule.
        let n = 6000;
        let inner: f64 = (1..n).map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * of(i)).sum();
        let found = (of(0) + inner + of(n)) * dt / 3.0;
        let exact = 0.01 * s / (s * s + w * w * (1.0 - (e / (s + e)).sqrt()));
        assert!((found - exact).abs() < 1e-6 * exact, "s = {s}: {found}, {exact}");
    }
}
