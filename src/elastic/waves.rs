//! Elastic waves: the largest step that the explicit coupling bears, and their period.

use crate::structure::Medium;

/// Largest stable step of the explicit coupling (1.54):
/// `dt <= (mu eps + sqrt(mu^2 eps^2 + rho lambda eps dx^2 / 2)) / lambda`, with `lambda` the tension
/// `E'(r)` and `dx = 2 h / sqrt(60)`, from the largest eigenvalue `60/h^2` of the P2 Laplacian on
/// edges `h`. Infinite without tension; `2 mu eps / lambda` without inertia.
///
/// The book prints it for `rho = 1` and steps of order 1. In steps of order 2 the velocity at the
/// start of the step carries the interface half of the way, and viscosity damps half as much:
/// `mu/2` replaces `mu`.
pub fn explicit_step_limit(medium: &Medium, thickness: f64, tension: f64) -> f64 {
    if tension <= 0.0 {
        return f64::INFINITY;
    }
    let dx = 2.0 * medium.edge / 60f64.sqrt();
    let damping = medium.viscosity * thickness / medium.order as f64;
    let inertia = 0.5 * medium.density * tension * thickness * dx * dx;
    (damping + (damping * damping + inertia).sqrt()) / tension
}

/// Period of the slowest elastic wave of a circle of radius `R` under the tension `lambda`, in
/// which it becomes an ellipse: `2 pi / sqrt(3 lambda / (rho R^3) - (3 mu / (rho R^2))^2)`, with
/// `rho` and `mu` the means of inside and outside. Infinite where viscosity leaves no wave.
///
/// Source: potential flow on both sides, and the Stokes flow that the same shape relaxes in, at the
/// rate `lambda / (2 mu R)`. A sphere is quicker, by a factor of 1.3.
pub fn wave_period(density: f64, viscosity: f64, radius: f64, tension: f64) -> f64 {
    let inertia = density * radius * radius;
    let damping = 3.0 * viscosity / inertia;
    let square = 3.0 * tension / (inertia * radius) - damping * damping;
    if square > 0.0 { std::f64::consts::TAU / square.sqrt() } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEDIUM: Medium = Medium { density: 1.0, viscosity: 0.01, edge: 0.1, order: 1 };

    fn near(value: f64, expected: f64) -> bool {
        (value / expected - 1.0).abs() < 1e-12
    }

    /// The shortest wave, `k^2 = 120 / h^2`, of `rho du/dt = -mu k^2 u + k^2 lambda phi / eps`,
    /// `dphi/dt = -u` changes its sign in each step. Backward Euler with the force at `phi^n` gives
    /// `q = 4 rho + 2 d`, with `q = k^2 lambda dt^2 / eps` and `d = mu k^2 dt`; BDF2 with the force
    /// at `phi^n - dt u^n` and `phi` carried by the mean velocity gives `q = 4 rho + d`.
    #[test]
    fn the_limit_is_that_of_the_shortest_wave() {
        let (thickness, tension) = (0.15, 2.0);
        let square = 120.0 / (MEDIUM.edge * MEDIUM.edge);
        for (order, density) in [(1, 1e-3), (1, 1.0), (1, 1e3), (2, 1e-3), (2, 1e3), (1, 0.0)] {
            let medium = Medium { density, order, ..MEDIUM };
            let dt = explicit_step_limit(&medium, thickness, tension);
            let q = square * tension * dt * dt / thickness;
            let d = medium.viscosity * square * dt * if order == 1 { 2.0 } else { 1.0 };
            assert!(near(q, 4.0 * density + d), "order {order}, density {density}");
        }
    }

    #[test]
    fn the_limit_has_the_dimension_of_a_time() {
        let [length, time, mass] = [8.0, 0.25, 64.0];
        let scaled = Medium {
            density: MEDIUM.density * mass / length.powi(3),
            viscosity: MEDIUM.viscosity * mass / (length * time),
            edge: MEDIUM.edge * length,
            order: 1,
        };
        let limit = explicit_step_limit(&MEDIUM, 0.15, 0.3);
        let other = explicit_step_limit(&scaled, 0.15 * length, 0.3 * mass / (time * time));
        assert!(near(other, limit * time));
        let period = wave_period(MEDIUM.density, MEDIUM.viscosity, 0.6, 0.3);
        let (rho, mu) = (scaled.density, scaled.viscosity);
        assert!(near(
            wave_period(rho, mu, 0.6 * length, 0.3 * mass / (time * time)),
            period * time
        ));
    }

    #[test]
    fn without_inertia_the_limit_is_viscous_and_without_tension_there_is_none() {
        let medium = Medium { density: 0.0, ..MEDIUM };
        assert!(near(explicit_step_limit(&medium, 0.15, 0.3), 2.0 * 0.01 * 0.15 / 0.3));
        for tension in [0.0, -1.0] {
            assert_eq!(explicit_step_limit(&MEDIUM, 0.15, tension), f64::INFINITY);
            assert_eq!(wave_period(1.0, 0.01, 0.6, tension), f64::INFINITY);
        }
    }

    #[test]
    fn a_wave_needs_inertia_and_little_viscosity() {
        assert_eq!(wave_period(0.0, 0.01, 0.6, 1.0), f64::INFINITY);
        assert_eq!(wave_period(1.0, 10.0, 0.6, 1.0), f64::INFINITY);
        // A circle of radius 1 between equal fluids: `omega^2 = 6 lambda / (2 rho R^3)`.
        let period = wave_period(2.0, 0.0, 1.0, 6.0);
        assert!(near(period, std::f64::consts::TAU / 3.0));
    }
}
