//! Coefficients of the time discretisation.

use super::Simulation;
use crate::flow::ConvectionScheme;
use nalgebra::SVector;

/// A step of backward Euler (order 1), of BDF2 with variable steps, or of BDF3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scheme {
    /// True for BDF2 and BDF3.
    pub second: bool,
    /// True for BDF3, with steps of one length.
    pub third: bool,
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
            _ if self.third => 11.0 / 6.0,
            (true, false) => 1.0,
            (true, true) => (1.0 + 2.0 * self.ratio) / (1.0 + self.ratio),
        }
    }
    /// Coefficients of the velocity now, one and two steps earlier.
    pub fn history(&self) -> [f64; 3] {
        match self.second {
            false => [1.0, 0.0, 0.0],
            _ if self.third => [3.0, -1.5, 1.0 / 3.0],
            true => [1.0 + self.ratio, -self.ratio * self.ratio / (1.0 + self.ratio), 0.0],
        }
    }
    /// Coefficients of the same velocities in their extrapolation to the end of the step.
    pub fn extrapolation(&self) -> [f64; 3] {
        match self.second {
            false => [1.0, 0.0, 0.0],
            _ if self.third => [3.0, -3.0, 1.0],
            true => [1.0 + self.ratio, -self.ratio, 0.0],
        }
    }
    /// True if convection is along characteristics.
    pub fn traces(&self) -> bool {
        self.convection == Some(ConvectionScheme::Characteristics)
    }
    /// Order of this step.
    pub fn order(&self) -> usize {
        1 + usize::from(self.second) + usize::from(self.third)
    }
}

impl<const D: usize> Simulation<D> {
    /// The scheme of the coming step.
    pub(super) fn scheme(&self) -> Scheme {
        let dt = self.settings.dt;
        let paced =
            |clock: &crate::sim::clock::Clock| if clock.last > 0.0 { dt / clock.last } else { 1.0 };
        let inertia = !self.is_stokes();
        Scheme {
            second: self.settings.order >= 2 && self.state.steps > 0,
            third: self.settings.order == 3 && self.state.steps > 1,
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

    /// BDF2 on unequal steps differentiates parabolas exactly, backward Euler lines, BDF3 cubics; the
    /// extrapolations are exact for one degree less.
    #[test]
    fn the_coefficients_differentiate_polynomials_of_their_order() {
        for ratio in [0.4, 1.0, 1.9f64] {
            for (second, third) in [(false, false), (true, false), (true, true)] {
                if third && ratio != 1.0 {
                    continue;
                }
                let (dt, time) = (0.3, 0.7);
                let s = Scheme { second, third, dt, time, ratio, inertia: true, convection: None };
                for power in 0..=s.order() as i32 {
                    let f = |t: f64| t.powi(power);
                    let earlier = [1.0, 1.0 + 1.0 / ratio, 2.0 + 1.0 / ratio];
                    let sum = |weights: [f64; 3]| {
                        let terms = weights.iter().zip(earlier).map(|(w, k)| w * f(time - k * dt));
                        terms.sum::<f64>()
                    };
                    let value = s.weight() * f(time) - sum(s.history());
                    if power < s.order() as i32 {
                        assert!((sum(s.extrapolation()) - f(time)).abs() < 1e-12);
                    }
                    let exact = f64::from(power) * time.powi(power - 1);
                    assert!((value / dt - exact).abs() < 1e-12, "{ratio} {second} {power}");
                }
            }
        }
    }
}
