//! Axes: the range of the values, and ticks at round numbers with their labels.

use super::super::numbers::tick_text;
use super::text::Label;

/// Most intervals between ticks with a label.
const MOST_TICKS: f64 = 8.0;
/// Decades from which on only powers of ten have labels.
const MANY_DECADES: f64 = 2.0;
/// Numbers of a decade that have labels on a short logarithmic axis.
const ROUND: [i32; 3] = [1, 2, 5];

/// A linear or logarithmic axis.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Ends; their decimal logarithms on a logarithmic axis.
    low: f64,
    high: f64,
    log: bool,
}

/// A tick of an axis.
#[derive(Clone, Debug)]
pub struct Tick {
    /// Position as a fraction of the axis.
    pub at: f64,
    /// Its number; minor ticks have none.
    pub label: Option<Label>,
}

impl Axis {
    /// The axis for finite values, positive if logarithmic, widened by the part `margin` of its
    /// length at both ends; none without values.
    pub fn of(values: impl Iterator<Item = f64>, log: bool, margin: f64) -> Option<Axis> {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = values.fold(ends, |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            return None;
        }
        if log {
            let (low, high) = (low.log10(), high.log10());
            // Less than a quarter of a decade looks like more than it is.
            let room = (margin * (high - low)).max(0.5 * (0.25 - (high - low))).max(0.02);
            return Some(Axis { low: low - room, high: high + room, log });
        }
        let largest = low.abs().max(high.abs());
        // Rounding must not be drawn as a curve.
        let flat = high - low <= 1e-12 * largest;
        let room = match (flat, largest) {
            (true, 0.0) => 1.0,
            (true, _) => 0.05 * largest.max(f64::MIN_POSITIVE * 1e9),
            (false, _) => margin * (high - low),
        };
        // The ends of what a number can be are no reason for an infinite axis.
        let within = |v: f64| v.clamp(f64::MIN, f64::MAX);
        Some(Axis { low: within(low - room), high: within(high + room), log })
    }
    /// The values at its ends.
    pub fn ends(&self) -> [f64; 2] {
        [self.low, self.high].map(|v| if self.log { 10f64.powf(v) } else { v })
    }
    /// The position of a value as a fraction of the axis.
    pub fn fraction(&self, value: f64) -> f64 {
        self.along(if self.log { value.log10() } else { value })
    }
    fn along(&self, v: f64) -> f64 {
        // Halved, lest the length of the axis overflow.
        (0.5 * v - 0.5 * self.low) / (0.5 * self.high - 0.5 * self.low)
    }
    /// Ticks from the lowest to the highest, as many labels as `fit`.
    pub fn ticks(&self, fit: impl Fn(&[Tick]) -> bool) -> Vec<Tick> {
        let mut choices = if self.log { self.log_ticks() } else { self.linear_ticks() };
        let few = |ticks: &[Tick]| labels(ticks) <= MOST_TICKS as usize + 1;
        let found = choices.iter().position(|ticks| few(ticks) && fit(ticks));
        // Two labels are the least from which an axis can be read, even if they touch.
        let found = found.or_else(|| choices.iter().rposition(|t| labels(t) > 1));
        found.map_or_else(Vec::new, |k| choices.swap_remove(k))
    }
    /// Multiples of 1, 2 and 5 times a power of ten, the closest first.
    fn linear_ticks(&self) -> Vec<Vec<Tick>> {
        let span = self.high - self.low;
        let (low, high) = (self.low, self.high);
        let largest = low.abs().max(high.abs());
        let label = |v: f64, step: f64| Some(Label::new(&tick_text(v, step, largest)));
        let tick = |v: f64, step: f64| Tick { at: self.along(v), label: label(v, step) };
        let ticks = |step: f64| multiples(low, high, step).map(|v| tick(v, step)).collect();
        steps(span).map(ticks).collect()
    }
    /// Powers of ten, and what fills a short axis: 1, 2 and 5 in a decade, or round numbers within
    /// one.
    fn log_ticks(&self) -> Vec<Vec<Tick>> {
        let span = self.high - self.low;
        let mut choices = Vec::new();
        if span < MANY_DECADES {
            choices.push(self.decades(1, &ROUND));
            if labels(&choices[0]) < 3 {
                let finer = self.within_a_decade();
                choices.splice(0..0, finer);
            }
        }
        for m in [1, 10, 100] {
            choices.extend([1, 2, 5].map(|step| self.decades(m * step, &[1])));
        }
        choices
    }
    /// Ticks at 1 to 9 times every power of ten, those with a label at `labelled` times every
    /// `stride`-th power.
    fn decades(&self, stride: i32, labelled: &[i32]) -> Vec<Tick> {
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let is_major = |m: i32, k: i32| labelled.contains(&m) && k.rem_euclid(stride) == 0;
        // Minor ticks between powers that are not labelled themselves would say nothing.
        let most = if stride == 1 { 9 } else { 1 };
        let all = (first..=last).flat_map(|k| (1..=most).map(move |m| (m, k)));
        let places = all.map(|(m, k)| (m, k, self.along(f64::from(m).log10() + f64::from(k))));
        let within = -1e-9..=1.0 + 1e-9;
        let inside: Vec<_> = places.filter(|(_, _, at)| within.contains(at)).collect();
        // Where all numbers are powers of ten, exponents are read faster than zeros.
        let plain = if labelled.len() > 1 { -4..=5 } else { -3..=4 };
        let powers = inside.iter().any(|(m, k, _)| is_major(*m, *k) && !plain.contains(k));
        let label = |m: i32, k: i32| match powers {
            true => Label::new(&format!("{m}e{k}")),
            false => Label::new(&tick_text(f64::from(m) * 10f64.powi(k), 10f64.powi(k), 1.0)),
        };
        let label = |m: i32, k: i32| is_major(m, k).then(|| label(m, k));
        inside.into_iter().map(|(m, k, at)| Tick { at, label: label(m, k) }).collect()
    }
    /// Round numbers as on a linear axis.
    fn within_a_decade(&self) -> Vec<Vec<Tick>> {
        let (low, high) = (10f64.powf(self.low), 10f64.powf(self.high));
        if !(low > 0.0 && high < f64::INFINITY) {
            return Vec::new();
        }
        let label = |v: f64, step: f64| Some(Label::new(&tick_text(v, step, high)));
        let tick = |v: f64, step: f64| Tick { at: self.fraction(v), label: label(v, step) };
        let positive = |step: f64| multiples(low, high, step).filter(|v| *v > 0.0);
        let ticks = |step: f64| positive(step).map(|v| tick(v, step)).collect();
        steps(high - low).map(ticks).collect()
    }
}

/// The number of ticks with a label.
fn labels(ticks: &[Tick]) -> usize {
    ticks.iter().filter(|t| t.label.is_some()).count()
}

/// Steps of 1, 2 and 5 times powers of ten between ticks, from the finest that an axis of this
/// length may have.
fn steps(span: f64) -> impl Iterator<Item = f64> {
    let finest = span / MOST_TICKS;
    // Subnormal numbers have no digits to spare for ticks.
    let sound = finest.is_finite() && finest > 1e6 * f64::MIN_POSITIVE;
    let decade = if sound { finest.log10().floor() as i32 } else { 0 };
    let all = (decade..decade + 3).flat_map(|k| ROUND.map(|m| f64::from(m) * 10f64.powi(k)));
    all.filter(move |step| sound && *step >= finest * (1.0 - 1e-9) && *step <= span)
}

/// The multiples of `step` in an interval.
fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step - 1e-9).ceil();
    let all = (0..=2 * MOST_TICKS as usize).map(move |k| (first + k as f64) * step);
    all.take_while(move |v| *v <= high + 1e-9 * step)
}
