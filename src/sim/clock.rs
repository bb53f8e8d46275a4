//! Adaptive time steps: their lengths from the error.

use crate::base::{Cause, Error, Result};

/// Parameters of adaptive time steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Pacing {
    /// Tolerance for the sum of the errors of all steps within `memory`, relative: a step `dt` may
    /// have the error `tolerance dt / memory`.
    pub tolerance: f64,
    /// The time that an error stays: the whole run with structures, whose positions keep it; in a
    /// flow alone the time in which it is carried through the domain, at most the run.
    pub memory: f64,
    /// Length of the first two steps, if the error allows.
    pub first: f64,
    /// Shortest step.
    pub least: f64,
    /// Longest step.
    pub most: f64,
    /// Times after 0, ascending, at which a step must end; the last is the end.
    pub instants: Vec<f64>,
    /// Reference speed for errors of the velocity; a larger speed that occurs replaces it.
    pub speed: f64,
    /// Reference length for errors of positions.
    pub length: f64,
}

/// Position of a run between the instants, and the step that the error allows. The interval between
/// two instants is divided into `2^k` or `3 2^k` equal parts, and `k` changes inside: instants are
/// reached exactly, and the matrix takes few values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clock {
    /// Index of the interval.
    pub interval: u64,
    /// Completed parts of it.
    pub part: u64,
    /// Number of its parts.
    pub parts: u64,
    /// The step that the error allows.
    pub wanted: f64,
    /// The last step; 0 before it.
    pub last: f64,
    /// The one before; 0 before it.
    pub before: f64,
    /// Number of rejected steps.
    pub rejected: u64,
    /// The largest speed that has occurred.
    pub speed: f64,
}

/// Largest growth from step to step; BDF2 is zero-stable to `1 + sqrt(2)`.
const GROWTH: f64 = 2.0;
/// Safety factor of the predicted step.
const SAFETY: f64 = 0.9;
/// Least ratio at which a longer step is taken.
const WORTHWHILE: f64 = 1.4;
const ROUNDING: f64 = 1.0 + 1e-10;

impl Clock {
    /// The clock at time 0.
    pub fn new(pacing: &Pacing) -> Clock {
        Clock { wanted: pacing.first, parts: 1, ..Clock::default() }
    }
    /// True if the end is reached.
    pub fn is_done(&self, pacing: &Pacing) -> bool {
        self.interval as usize >= pacing.instants.len()
    }
    fn bounds(&self, pacing: &Pacing) -> [f64; 2] {
        let k = self.interval as usize;
        [if k == 0 { 0.0 } else { pacing.instants[k - 1] }, pacing.instants[k]]
    }
    /// The next step, at most `limit`; `count` of them fit before the next instant.
    ///
    /// # Errors
    /// A step shorter than `least`.
    pub fn propose(&mut self, pacing: &Pacing, limit: f64, count: u64) -> Result<f64> {
        let [from, to] = self.bounds(pacing);
        let length = to - from;
        let growth = if self.last > 0.0 { GROWTH * self.last } else { f64::INFINITY };
        let most = self.wanted.min(limit).min(pacing.most).min(growth) * ROUNDING;
        if most < pacing.least || most.is_nan() {
            return Err(Error::computation(
                "the step that the error allows is shorter than the shortest one",
            )
            .at(format!("time {:.6}", self.time(pacing)))
            .value(format!("step {most:.3e}, shortest step {:.3e}", pacing.least))
            .remedy(
                "make what changes at that time smooth, such as (1 - cos(pi*min(t, 1)))/2 in place of \
                 min(t, 1): an abrupt value or a kink has no short enough step; or allow a larger \
                 error or a shorter step",
            )
            .because(Cause::ShortestStep));
        }
        if self.part == 0 {
            self.parts = 1;
            while length / self.parts as f64 > most || self.parts < count {
                self.parts = if self.parts.is_power_of_two() && self.parts > 1 {
                    self.parts / 2 * 3
                } else {
                    (self.parts * 4 / 3).max(2)
                };
            }
        }
        while self.part.is_multiple_of(2)
            && self.parts.is_multiple_of(2)
            && length / (self.parts / 2) as f64 <= most
            && self.part > 0
        {
            (self.part, self.parts) = (self.part / 2, self.parts / 2);
        }
        while length / self.parts as f64 > most {
            (self.part, self.parts) = (2 * self.part, 2 * self.parts);
        }
        Ok(rounded(length / self.parts as f64))
    }
    /// The time; exactly an instant at its end.
    pub fn time(&self, pacing: &Pacing) -> f64 {
        if self.part == 0 {
            return if self.interval == 0 {
                0.0
            } else {
                pacing.instants[self.interval as usize - 1]
            };
        }
        let [from, to] = self.bounds(pacing);
        from + (to - from) * (self.part as f64 / self.parts as f64)
    }
    /// Advances by an accepted step.
    pub fn advance(&mut self, dt: f64) {
        self.part += 1;
        if self.part == self.parts {
            (self.interval, self.part, self.parts) = (self.interval + 1, 0, 1);
        }
        (self.before, self.last) = (self.last, dt);
    }
    /// Computes the next step from a step `dt` with the error `error`, relative to the tolerance
    /// and of order `dt^2`. Returns true if the step is accepted.
    pub fn judge(&mut self, dt: f64, error: f64) -> bool {
        let ideal = if error.is_finite() {
            dt * (SAFETY / error.sqrt()).clamp(0.2, 10.0)
        } else {
            0.5 * dt
        };
        let accepted = error <= 1.0;
        self.wanted = match accepted {
            true if ideal >= WORTHWHILE * dt => ideal,
            true => dt.min(ideal / SAFETY),
            false => ideal.min(0.7 * dt),
        };
        accepted
    }
}

/// Rounds off the last bits of a step, so that equal parts of equal intervals have the same matrix.
fn rounded(dt: f64) -> f64 {
    const LOST: u64 = 1 << 16;
    f64::from_bits((dt.to_bits() + LOST / 2) & !(LOST - 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pacing() -> Pacing {
        let instants = vec![0.1, 0.2, 0.25, 1.0];
        Pacing {
            tolerance: 1e-3,
            memory: 1.0,
            first: 0.004,
            least: 1e-6,
            most: 0.3,
            instants,
            speed: 1.0,
            length: 1.0,
        }
    }

    /// Steps of all sizes that are wanted in turn: each instant is a time of the clock to the last
    /// bit, no step is longer than wanted, allowed or than twice the last, and the times are the
    /// sum of the steps.
    #[test]
    fn instants_are_hit_exactly_and_growth_is_bounded() {
        let p = pacing();
        let mut clock = Clock::new(&p);
        let (mut hit, mut sum, mut k) = (vec![], 0.0, 0);
        while !clock.is_done(&p) {
            clock.wanted = [0.004, 0.05, 0.0013, 0.7, 0.02][k / 3 % 5];
            let dt = clock.propose(&p, 0.06, 1).unwrap();
            assert!(
                dt <= clock.wanted.min(0.06) * ROUNDING
                    && (clock.last == 0.0 || dt <= 2.0 * clock.last * ROUNDING)
            );
            clock.advance(dt);
            sum += dt;
            assert!((clock.time(&p) - sum).abs() < 1e-10);
            if clock.part == 0 {
                hit.push(clock.time(&p));
            }
            k += 1;
            assert!(k < 2000);
        }
        assert_eq!(hit, p.instants);
    }

    #[test]
    fn a_step_that_is_too_wrong_is_rejected_and_a_shorter_one_proposed_until_the_least() {
        let p = pacing();
        let mut clock = Clock::new(&p);
        let dt = clock.propose(&p, f64::INFINITY, 1).unwrap();
        assert!(!clock.judge(dt, 4.0) && clock.wanted < 0.5 * dt);
        assert!(!clock.judge(dt, f64::INFINITY) && clock.wanted <= 0.5 * dt);
        assert!(clock.judge(dt, 0.9) && clock.wanted <= dt);
        assert!(clock.judge(dt, 0.01) && clock.wanted > 5.0 * dt);
        clock.wanted = 1e-7;
        let e = clock.propose(&p, f64::INFINITY, 1).unwrap_err();
        assert!(
            e.cause() == Some(Cause::ShortestStep) && e.to_string().contains("shortest step"),
            "{e}"
        );
    }

    /// The step that an error suggests, over the one that made it.
    #[test]
    fn the_wanted_step_follows_the_root_of_the_error() {
        for (error, accepted, ratio) in [
            (0.0, true, 10.0),
            (0.25, true, 1.8),
            // Not worth a new matrix.
            (0.81, true, 1.0),
            (1.0, true, 1.0),
            (1.01, false, 0.7),
            (4.0, false, 0.45),
            (1e6, false, 0.2),
            (f64::NAN, false, 0.5),
        ] {
            let mut clock = Clock::default();
            assert_eq!(clock.judge(0.5, error), accepted, "{error}");
            assert!((clock.wanted - 0.5 * ratio).abs() < 1e-15, "{error}: {}", clock.wanted);
        }
    }

    /// An interval is cut into 1, 2, 3, 4, 6, 8 .. parts; at an even one of an even number two
    /// become one.
    #[test]
    fn parts_of_an_interval_are_two_or_three_times_a_power_of_two() {
        let p = pacing();
        for (wanted, parts) in
            [(0.2, 1), (0.09, 2), (0.04, 3), (0.03, 4), (0.02, 6), (0.015, 8), (0.011, 12)]
        {
            let mut clock = Clock { wanted, ..Clock::new(&p) };
            let dt = clock.propose(&p, f64::INFINITY, 1).unwrap();
            assert_eq!(clock.parts, parts, "{wanted}");
            assert!((dt * parts as f64 - 0.1).abs() < 1e-12);
        }
        let mut clock = Clock { wanted: 0.03, ..Clock::new(&p) };
        let mut walk = |wanted| {
            clock.wanted = wanted;
            let dt = clock.propose(&p, f64::INFINITY, 1).unwrap();
            clock.advance(dt);
            (clock.interval, clock.part, clock.parts)
        };
        // A longer step has to wait for an even part; a shorter one does not; the end of the
        // interval is the start of the next.
        assert_eq!(
            [0.03, 0.09, 0.09, 0.01].map(&mut walk),
            [(0, 1, 4), (0, 2, 4), (1, 0, 1), (1, 1, 12)]
        );
    }

    /// Two steps before the next instant, as the start needs.
    #[test]
    fn as_many_steps_fit_before_the_next_instant_as_are_asked_for() {
        let p = pacing();
        let mut clock = Clock { wanted: 1.0, ..Clock::new(&p) };
        clock.propose(&p, f64::INFINITY, 2).unwrap();
        assert_eq!(clock.parts, 2);
    }
}
