//! Coefficients of the time discretisation.

use super::Simulation;
use crate::flow::ConvectionScheme;
use nalgebra::SVector;

/// A step of backward Euler (order 1) or of BDF2 with variable steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scheme {
    /// True for BDF2.
    pub second: bool,
    /// Length of the step.
    pub dt: f64,
    /// Time at its end.
    pub time: f64,
    /// Length over that of the last step.
    pub ratio: f64,
    /// True if the flow has inertia.
    pub inertia: bool,
    /// Convection, in a flow with inertia.
    pub convection: Option<ConvectionScheme>,
}

impl Scheme {
    /// Coefficient of the new velocity in the discrete time derivative, times the step; 0 for
    /// Stokes.
    pub fn weight(&self) -> f64 {
        match (self.inertia, self.second) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => (1.0 + 2.0 * self.ratio) / (1.0 + self.ratio),
        }
    }
    /// Coefficients of the velocity now and one step earlier.
    pub fn history(&self) -> [f64; 2] {
        match self.second {
            false => [1.0, 0.0],
            true => [1.0 + self.ratio, -self.ratio * self.ratio / (1.0 + self.ratio)],
        }
    }
    /// Coefficients of the same velocities in their extrapolation to the end of the step.
    pub fn extrapolation(&self) -> [f64; 2] {
        match self.second {
            false => [1.0, 0.0],
            true => [1.0 + self.ratio, -self.ratio],
        }
    }
    /// True if convection is along characteristics.
    pub fn traces(&self) -> bool {
        self.convection == Some(ConvectionScheme::Characteristics)
    }
    /// Order of this step.
    pub fn order(&self) -> usize {
        if self.second { 2 } else { 1 }
    }
}

impl<const D: usize> Simulation<D> {
    /// The scheme of the coming step.
    pub(super) fn scheme(&self) -> Scheme {
        let dt = self.settings.dt;
        let paced =
            |p: &crate::sim::Pace<D>| if p.clock.last > 0.0 { dt / p.clock.last } else { 1.0 };
        let inertia = !self.is_stokes();
        Scheme {
            second: self.settings.order == 2 && self.state.steps > 0,
            dt,
            time: self.time() + dt,
            ratio: self.state.pace.as_ref().map_or(1.0, paced),
            inertia,
            convection: self.settings.convection.filter(|_| inertia),
        }
    }
}

/// `out = a x + b y`.
pub(super) fn combine<const D: usize>(
    a: f64,
    x: &[SVector<f64, D>],
    b: f64,
    y: &[SVector<f64, D>],
    out: &mut Vec<SVector<f64, D>>,
) {
    out.clear();
    out.extend(x.iter().zip(y).map(|(x, y)| x * a + y * b));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// BDF2 on unequal steps differentiates parabolas exactly, backward Euler lines.
    #[test]
    fn the_coefficients_differentiate_polynomials_of_their_order() {
        for ratio in [0.4, 1.0, 1.9] {
            for second in [false, true] {
                let (dt, time) = (0.3, 0.7);
                let s = Scheme { second, dt, time, ratio, inertia: true, convection: None };
                for power in 0..=s.order() as i32 {
                    let f = |t: f64| t.powi(power);
                    let [a, b] = s.history();
                    let value =
                        s.weight() * f(time) - a * f(time - dt) - b * f(time - dt - dt / ratio);
                    let exact = f64::from(power) * time.powi(power - 1);
                    assert!((value / dt - exact).abs() < 1e-12, "{ratio} {second} {power}");
                }
            }
        }
    }
}
