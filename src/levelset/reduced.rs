//! Forms of a given size and reduced area or volume.

use std::f64::consts::PI;

/// Points of the periodic trapezoidal rule for lengths and areas.
const POINTS: usize = 4000;
/// Halvings of an interval.
const HALVINGS: usize = 200;

/// The root of a decreasing function in an interval.
fn root([mut low, mut high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if f(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Mean over a full turn.
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    let angle = |k: usize| 2.0 * PI * (k as f64 + 0.5) / POINTS as f64;
    (0..POINTS).map(|k| f(angle(k))).sum::<f64>() / POINTS as f64
}

/// Semi-axes of the ellipse with the area of the unit circle and the reduced area `4 pi A/L^2` in
/// (.02, 1].
pub fn reduced_ellipse(reduced_area: f64) -> [f64; 2] {
    let length = |a: f64| 2.0 * PI * mean(|t| (a * t.sin()).hypot(t.cos() / a));
    let a = root([1.0, 100.0], |a| 4.0 * PI * PI / length(a).powi(2) - reduced_area);
    [a, 1.0 / a]
}

/// Cassini's oval, the curve `|x - f| |x + f| = c^2` with foci `+-f` on the x-axis, with the area of
/// the unit circle and a reduced area between .79 (where it has a waist of zero) and 1: `[f, c]`.
pub fn reduced_cassini(reduced_area: f64) -> [f64; 2] {
    // In polar coordinates r^2 = e cos 2t + sqrt(1 - e^2 sin^2 2t), e = (f/c)^2.
    let square = |e: f64, t: f64| {
        e * (2.0 * t).cos() + (1.0 - (e * (2.0 * t).sin()).powi(2)).max(0.0).sqrt()
    };
    // r (dr/dt) = -e sin 2t r^2 / sqrt(..), and the length is the integral of r^2 -> 1/sqrt(..).
    let length = |e: f64| {
        2.0 * PI * mean(|t| square(e, t).sqrt() / (1.0 - (e * (2.0 * t).sin()).powi(2)).sqrt())
    };
    let area = |e: f64| PI * mean(|t| square(e, t));
    let reduced = |e: f64| 4.0 * PI * area(e) / length(e).powi(2);
    let e = root([0.0, 1.0 - 1e-9], |e| reduced(e) - reduced_area);
    let c = (PI / area(e)).sqrt();
    [e.sqrt() * c, c]
}

/// Semi-axes along the axis and across it of the spheroid with the volume of the unit sphere and
/// the reduced volume `V/(4/3 pi (S/4 pi)^(3/2))` in (.1, 1].
pub fn reduced_spheroid(reduced_volume: f64, oblate: bool) -> [f64; 2] {
    // Axes b c^2 = 1; `ratio` is the longer over the shorter.
    let axes = |ratio: f64| {
        let along = if oblate { ratio.powf(-2.0 / 3.0) } else { ratio.powf(2.0 / 3.0) };
        [along, along.powf(-0.5)]
    };
    let surface = |[b, c]: [f64; 2]| {
        // Meridian (c sin t, b cos t), over half a turn.
        2.0 * PI * PI * mean(|t| (c * t.sin()).abs() * (c * t.cos()).hypot(b * t.sin()))
    };
    let reduced = |ratio: f64| (4.0 * PI / surface(axes(ratio))).powf(1.5);
    axes(root([1.0, 1000.0], |ratio| reduced(ratio) - reduced_volume))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_have_the_size_that_is_asked_for() {
        assert!(reduced_ellipse(1.0).iter().all(|a| (a - 1.0).abs() < 1e-6));
        // Axes of the ellipse of reduced area .8, by a quadrature of its length elsewhere.
        let [a, b] = reduced_ellipse(0.8);
        assert!((a - 1.485_836_474_96).abs() < 1e-9 && (a * b - 1.0).abs() < 1e-12, "{a} {b}");
        // Closed formula of the surface of a prolate spheroid.
        let [b, c] = reduced_spheroid(0.8, false);
        let e = (1.0 - c * c / (b * b)).sqrt();
        let surface = 2.0 * PI * c * c * (1.0 + b / (c * e) * e.asin());
        let volume = 4.0 / 3.0 * PI * b * c * c;
        let reduced = volume / (4.0 / 3.0 * PI * (surface / (4.0 * PI)).powf(1.5));
        assert!(b > c && (reduced - 0.8).abs() < 1e-5, "{reduced}");
        let [b, c] = reduced_spheroid(0.8, true);
        assert!(b < c && (b * c * c - 1.0).abs() < 1e-12);
        // The oval is on its curve, by its polygon.
        let [f, c] = reduced_cassini(0.9);
        let point = |t: f64| {
            let e = (f / c).powi(2);
            let r = c * (e * (2.0 * t).cos() + (1.0 - (e * (2.0 * t).sin()).powi(2)).sqrt()).sqrt();
            [r * t.cos(), r * t.sin()]
        };
        let line: Vec<[f64; 2]> = (0..20_000).map(|k| point(f64::from(k) * PI / 1e4)).collect();
        let next = line.iter().cycle().skip(1);
        let (mut length, mut area) = (0.0, 0.0);
        for (p, q) in line.iter().zip(next) {
            length += (q[0] - p[0]).hypot(q[1] - p[1]);
            area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
        }
        assert!((area - PI).abs() < 1e-5, "{area}");
        assert!((4.0 * PI * area / length.powi(2) - 0.9).abs() < 1e-5);
    }
}
