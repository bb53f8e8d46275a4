//! The period of an oscillation in a column of a series, by its crossings of the middle.

/// A periodic oscillation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Its frequency: whole periods over the time that they take.
    pub frequency: f64,
    /// The largest distance of a single period from the mean one, over the latter.
    pub spread: f64,
    /// Number of periods.
    pub periods: usize,
}

/// Fewest periods that make an oscillation.
const FEWEST: usize = 3;
/// Fewest rows of a period: fewer may show a slower oscillation in place of a quicker one.
const FEWEST_ROWS: f64 = 8.0;
/// Single periods may differ from the mean one by this part of it.
const MOST_SPREAD: f64 = 0.1;
/// Part of the amplitude by which a signal must fall below the middle before it can cross it
/// again, so that noise there is not counted.
const BELOW: f64 = 0.25;
/// An amplitude below this part of the largest value is rounding.
const ROUNDING: f64 = 1e-6;

impl Oscillation {
    /// The oscillation in the second half of a signal, where a motion has set in; `None` if there
    /// are fewer than three periods or eight rows a period, or if they differ by more than a tenth.
    ///
    /// A period is the time between two upward crossings of the middle between the extreme values,
    /// interpolated linearly between rows. The error of one crossing is of second order in the
    /// number of rows per period, and that of the frequency is smaller by the number of periods.
    pub fn of(time: &[f64], signal: &[f64]) -> Option<Oscillation> {
        let largest = signal.iter().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
        let half = 0.5 * (time.first()? + time.last()?);
        let late: Vec<[f64; 2]> = (time.iter().zip(signal))
            .filter(|(t, v)| **t >= half && v.is_finite())
            .map(|(t, v)| [*t, *v])
            .collect();
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = late.iter().fold(ends, |(a, b), [_, v]| (a.min(*v), b.max(*v)));
        let (middle, amplitude) = (0.5 * (low + high), 0.5 * (high - low));
        if amplitude.is_nan() || amplitude <= ROUNDING * largest {
            return None;
        }
        let crossings = crossings(&late, middle, middle - BELOW * amplitude);
        let periods = crossings.len().checked_sub(1).filter(|n| *n >= FEWEST)?;
        let mean = (crossings[periods] - crossings[0]) / periods as f64;
        let [first, last] = [crossings[0], crossings[periods]];
        let rows = late.iter().filter(|[t, _]| (first..last).contains(t)).count();
        if (rows as f64) < FEWEST_ROWS * periods as f64 {
            return None;
        }
        let spread = crossings.windows(2).map(|c| ((c[1] - c[0]) / mean - 1.0).abs());
        let spread = spread.fold(0.0, f64::max);
        (spread <= MOST_SPREAD).then_some(Oscillation { frequency: 1.0 / mean, spread, periods })
    }
}

/// Times at which a signal rises through `middle` after it has been below `low`.
fn crossings(signal: &[[f64; 2]], middle: f64, low: f64) -> Vec<f64> {
    let (mut times, mut armed) = (Vec::new(), false);
    for pair in signal.windows(2) {
        let [[t, a], [s, b]] = [pair[0], pair[1]];
        armed |= a <= low;
        if armed && a < middle && b >= middle {
            times.push(t + (s - t) * (middle - a) / (b - a));
            armed = false;
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sampled(end: f64, rows: usize, f: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let time: Vec<f64> = (0..=rows).map(|k| end * k as f64 / rows as f64).collect();
        let signal = time.iter().map(|t| f(*t)).collect();
        (time, signal)
    }

    /// Rows a quarter of a period apart show no oscillation that could not be a quicker one.
    #[test]
    fn few_rows_a_period_give_no_frequency() {
        let wave = |t: f64| (TAU * t).sin();
        let of = |rows: usize| {
            let (time, signal) = sampled(20.0, rows, wave);
            Oscillation::of(&time, &signal)
        };
        assert!(of(20 * 4).is_none() && of(20 * 7).is_none());
        assert!((of(20 * 16).unwrap().frequency - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_sine_that_sets_in_has_its_frequency() {
        let wave = |t: f64| 0.3 + (1.0 - (-t).exp()) * (TAU * 0.7 * t).sin();
        let error = |rows| {
            let (t, s) = sampled(30.0, rows, wave);
            let found = Oscillation::of(&t, &s).unwrap();
            assert!(found.periods == 10 || found.periods == 9, "{found:?}");
            (found.frequency - 0.7).abs()
        };
        assert!(error(333) < 1e-5, "{}", error(333));
        assert!(error(3330) < 1e-7, "{}", error(3330));
    }

    #[test]
    fn what_does_not_oscillate_has_no_frequency() {
        let none = |f: &dyn Fn(f64) -> f64| {
            let (t, s) = sampled(10.0, 400, f);
            assert_eq!(Oscillation::of(&t, &s), None);
        };
        none(&|_| 2.0);
        none(&|t| 1.0 + (-t).exp());
        none(&|t| (TAU * 0.5 * t).sin()); // 2.5 periods in the second half
        none(&|t| 1.0 + 1e-9 * (TAU * 3.0 * t).sin()); // rounding
        none(&|t| (0.4 * t * t).sin() * 2.0); // a period that changes
        none(&|_| f64::NAN);
        assert_eq!(Oscillation::of(&[], &[]), None);
    }

    #[test]
    fn noise_at_the_middle_is_not_counted_and_rows_without_a_value_are_left_out() {
        let noise = |t: f64| 0.1 * (TAU * 61.0 * t).sin();
        let (t, mut s) = sampled(20.0, 2000, |t| (TAU * 0.5 * t).sin() + noise(t));
        s[0] = f64::NAN;
        let found = Oscillation::of(&t, &s).unwrap();
        assert!((found.frequency - 0.5).abs() < 0.01 && found.periods < 6, "{found:?}");
    }
}
