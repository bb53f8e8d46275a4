//! The largest stable step by bisection.

use crate::base::Result;
use crate::output::rounded;

/// Digits of the steps that are tried.
const DIGITS: usize = 5;
/// Steps below the limit, over it, that are tried too.
const BELOW: [f64; 3] = [0.8, 0.6, 0.4];

/// Bounds of the largest stable step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bracket {
    /// The largest step that was found stable; `None` when the smallest one tried is unstable.
    pub stable: Option<f64>,
    /// The smallest unstable step above it; `None` when the largest one tried is stable.
    pub unstable: Option<f64>,
    /// Unstable steps below `stable`: it is no bound then.
    pub islands: Vec<f64>,
}

impl Bracket {
    /// The limit: the geometric mean of the two steps around it, or the one that is known.
    pub fn limit(&self) -> Option<f64> {
        match (self.stable, self.unstable) {
            (Some(s), Some(u)) => Some((s * u).sqrt()),
            (s, u) => s.or(u),
        }
    }
}

/// Finds the largest step between `range[0]` and `range[1]` that `is_stable`, with a relative
/// accuracy.
///
/// Starts at `guess` and goes by factors of two until a stable and an unstable step are found, then
/// bisects on the logarithm; tries 0.8, 0.6 and 0.4 of what was found, too, for steps that are
/// unstable below stable ones.
///
/// # Errors
/// Those of `is_stable`.
pub fn largest_stable_step(
    guess: f64,
    range: [f64; 2],
    accuracy: f64,
    mut is_stable: impl FnMut(f64) -> Result<bool>,
) -> Result<Bracket> {
    let [least, most] = range;
    let within = |step: f64| {
        if step > least && step < most {
            short(step).clamp(least, most)
        } else {
            step.clamp(least, most)
        }
    };
    let mut bracket = Bracket::default();
    let mut step = within(guess);
    loop {
        *(if is_stable(step)? { &mut bracket.stable } else { &mut bracket.unstable }) = Some(step);
        step = match (bracket.stable, bracket.unstable) {
            (Some(s), Some(u)) if u > (1.0 + accuracy) * s => within((s * u).sqrt()),
            (Some(s), None) if s < most => within(2.0 * s),
            (None, Some(u)) if u > least => within(0.5 * u),
            _ => break,
        };
    }
    if let Some(stable) = bracket.stable {
        for below in BELOW.map(|f| short(f * stable)).into_iter().filter(|b| *b >= least) {
            if !is_stable(below)? {
                bracket.islands.push(below);
            }
        }
    }
    Ok(bracket)
}

/// A number with few digits.
pub(super) fn short(v: f64) -> f64 {
    rounded(v, DIGITS).parse().unwrap_or(v)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_found_from_below_and_from_above() {
        for guess in [1e-3, 0.0165, 0.9] {
            let mut tried = 0;
            let found = largest_stable_step(guess, [1e-4, 1.0], 0.05, |dt| {
                tried += 1;
                Ok(dt < 0.0165)
            });
            let found = found.unwrap();
            let (s, u) = (found.stable.unwrap(), found.unstable.unwrap());
            assert!(
                s < 0.0165 && 0.0165 <= u && u <= 1.05 * s && found.islands.is_empty(),
                "{found:?}"
            );
            assert!(tried < 15, "{tried} runs");
        }
    }

    #[test]
    fn ends_and_islands_are_results() {
        let find = |is_stable: fn(f64) -> bool| {
            largest_stable_step(0.3, [0.1, 3.0], 0.01, |dt| Ok(is_stable(dt))).unwrap()
        };
        assert_eq!(find(|_| true), Bracket { stable: Some(3.0), unstable: None, islands: vec![] });
        assert_eq!(find(|_| false), Bracket { stable: None, unstable: Some(0.1), islands: vec![] });
        let island = find(|dt| dt < 1.0 && !(0.35..0.45).contains(&dt));
        assert!(
            island.stable.is_some_and(|s| (0.98..1.0).contains(&s)) && island.islands.len() == 1,
            "{island:?}"
        );
        assert_eq!(
            Bracket { stable: Some(1.0), unstable: Some(4.0), islands: vec![] }.limit(),
            Some(2.0)
        );
    }
}
