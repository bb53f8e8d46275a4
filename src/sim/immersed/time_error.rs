//! Estimate of the error that the length of the steps makes.

use super::Simulation;
use super::scheme::Scheme;
use crate::fem::{Cells, integrate};
use crate::flow::ConvectionScheme;
use nalgebra::SVector;

impl<const D: usize> Simulation<D> {
    /// Estimate of the error of the velocity due to the length of the last step, relative to the
    /// velocity, both as root mean squares over the domain; NaN before the third step, for steps of
    /// order 1 along characteristics, which know one foot, and in a Stokes flow, whose velocity
    /// depends on no step.
    ///
    /// It is the error of the discrete acceleration `Du/Dt`, times `memory`, the time for which an
    /// error stays in the domain. The error has the parts
    /// - of backward Euler `dt u''/2`, of BDF2 `dt^2 u'''/3`, of BDF3 `dt^3 u''''/4`, where each
    ///   further derivative is taken as a factor `|u''|/|u'|` (an oscillation has exactly this), and
    ///   derivatives are along the paths where convection is: those do not vanish in a steady flow;
    /// - of extrapolated convection, `dt^2 (u'' . grad) u`, in order 1 `dt (u' . grad) u`, in order 3
    ///   `dt^3 (u''' . grad) u`; twice for the explicit form.
    ///
    /// It tells the size of the error, not its sign, and knows nothing of what the error does to a
    /// force. Costs one pass over the cells.
    pub fn time_error(&self, memory: f64) -> f64 {
        let (state, before) = (&self.state, &self.work.current);
        if self.is_stokes() || state.steps < 3 || before.len() != state.flow.u.len() {
            return f64::NAN;
        }
        let (basis, space) = (self.flow.velocity(), self.space());
        let points = basis.rule().len();
        let dt = self.settings.dt;
        let last = state.pace.map_or(dt, |clock| clock.before);
        let scheme = Scheme { dt, ratio: dt / last, ..self.scheme() };
        if scheme.traces() && !scheme.second {
            return f64::NAN;
        }
        let earlier = [&state.earlier_u, before];
        let extrapolated = match scheme.convection {
            Some(ConvectionScheme::Implicit) => 1.0,
            Some(ConvectionScheme::Explicit) => 2.0,
            _ => 0.0,
        };
        let sums = integrate(basis, Cells::All, |at| {
            let u = basis.value(at, &state.flow.u);
            let gradient = basis.jacobian(at, &state.flow.u);
            let [now, then] = std::array::from_fn(|k| match scheme.traces() {
                true => {
                    let foot = self.feet[k].get(at.cell * points + at.q);
                    space.value(earlier[k], foot.cell as usize, &foot.barycentric)
                }
                false => basis.value(at, earlier[k]),
            });
            let (first, slope) = ((u - now) / dt, (now - then) / last);
            let bend = (first - slope) * (2.0 / (dt + last));
            let rate = first + bend * (0.5 * dt);
            let convected = gradient * bend;
            [u, rate, bend, convected, gradient * rate].map(|v: SVector<f64, D>| v.norm_squared())
        });
        let [u, rate, bend, convected, convected_rate] = sums.map(f64::sqrt);
        // Steps over the time in which the velocity changes.
        let change = match rate * dt > ROUNDING * u {
            true => dt * bend / rate.hypot(dt * bend),
            false => 0.0,
        };
        let derivative = match scheme.order() {
            1 => 0.5 * dt * bend,
            2 => last * bend * change / 3.0,
            _ => dt * bend * change * change / 4.0,
        };
        let extrapolation = match scheme.order() {
            1 => extrapolated * dt * convected_rate,
            3 => extrapolated * dt * dt * convected * change,
            _ => extrapolated * dt * last * convected,
        };
        if u > 0.0 { memory * (derivative + extrapolation) / u } else { 0.0 }
    }
}

/// Relative change of the velocity in a step that is not told from rounding and iterations.
const ROUNDING: f64 = 1e-6;
