//! Criterion of stability.

use crate::base::Result;
use crate::studies::{End, Outcome};

/// Stability of a run, judged by its energy.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Reason for which the scene with these values could not be run.
    pub refused: Option<String>,
    /// Largest growth beyond the balance: kinetic and elastic energy less what was there and was
    /// put in, over that. A flow that loses energy from its first step on has 0.
    pub growth: f64,
    /// Time at which the growth first exceeded the tolerance, or the run failed.
    pub unstable_from: Option<f64>,
    /// Residual of the energy balance (3.23) over the energy in play: the value of the largest
    /// magnitude.
    pub residual: f64,
    /// The rate at which the growth changes in the second half of the run, per time: negative where
    /// energy is dissipated, positive where an instability grows that has not come far yet.
    pub rate: f64,
    /// Relative change of an enclosed area, the largest; NaN without membranes.
    pub area: f64,
}

impl Verdict {
    /// Judges a run by its series, with a row a step. It is unstable when it failed, or when at
    /// some time kinetic and elastic energy are above `1 + tolerance` times the energy at the start
    /// and the work put in.
    ///
    /// # Errors
    /// A series without the columns of the energy.
    pub fn of(outcome: &Outcome, tolerance: f64) -> Result<Verdict> {
        if let End::Refused { reason } = &outcome.end {
            let nan = f64::NAN;
            let refused = Some(reason.clone());
            return Ok(Verdict {
                refused,
                growth: nan,
                residual: nan,
                rate: nan,
                area: nan,
                unstable_from: None,
            });
        }
        let column = |name: &str| outcome.series.column(name);
        let (time, kinetic, elastic) =
            (column("time")?, column("energy_kinetic")?, column("energy_elastic")?);
        let (work, balance) = (column("work")?, column("energy_balance")?);
        let energy: Vec<f64> = kinetic.iter().zip(elastic).map(|(k, e)| k + e).collect();
        let excess = excess(&energy, work);
        let beyond = excess.iter().position(|g| *g > tolerance).and_then(|i| time.get(i)).copied();
        let failed = match &outcome.end {
            End::Failed { time, .. } => Some(*time),
            _ => None,
        };
        Ok(Verdict {
            refused: None,
            growth: excess.iter().copied().fold(0.0, f64::max),
            unstable_from: beyond.or(failed),
            residual: largest(balance.iter().copied()),
            rate: late_rate(time, &excess),
            area: largest(outcome.summary.balance.area.values().flatten().copied()),
        })
    }
    /// True if it was run and is stable.
    pub fn is_stable(&self) -> bool {
        self.refused.is_none() && self.unstable_from.is_none()
    }
    /// In a few words.
    pub fn in_words(&self) -> String {
        match (&self.refused, self.unstable_from) {
            (Some(_), _) => "refused".into(),
            (None, Some(t)) => format!("unstable from t = {}", crate::output::rounded(t, 3)),
            (None, None) => "stable".into(),
        }
    }
}

/// At each time, the energy less what was there and was put in, over the largest value of the
/// latter so far.
fn excess(energy: &[f64], work: &[f64]) -> Vec<f64> {
    let initial = energy.first().copied().unwrap_or(0.0);
    let mut scale: f64 = 0.0;
    let at = |(e, w): (&f64, &f64)| {
        scale = scale.max(initial + w);
        let excess = e - (initial + w);
        // Without any energy there is nothing to compare with, and nothing that could grow.
        if excess == 0.0 { 0.0 } else { excess / scale }
    };
    energy.iter().zip(work).map(at).collect()
}

/// Mean slope of a column over the second half of its times; NaN for fewer than three rows.
fn late_rate(time: &[f64], values: &[f64]) -> f64 {
    let half = time.len() / 2;
    match (time.get(half), time.last(), values.get(half), values.last()) {
        (Some(t0), Some(t1), Some(v0), Some(v1)) if t1 > t0 => (v1 - v0) / (t1 - t0),
        _ => f64::NAN,
    }
}

/// The value of the largest magnitude; NaN if there is none.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::NAN, |a, b| if a.is_nan() || b.abs() > a.abs() { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Series;
    use crate::studies::Trial;

    fn outcome(kinetic: &[f64], work: &[f64]) -> Outcome {
        let n = kinetic.len();
        let (time, rest): (Vec<f64>, Vec<f64>) = ((0..n).map(|i| i as f64).collect(), vec![1.0; n]);
        let series = Series::new(&[
            ("time", &time),
            ("energy_kinetic", kinetic),
            ("energy_elastic", &rest),
            ("work", work),
            ("energy_balance", kinetic),
        ]);
        Outcome { trial: Trial::default(), end: End::Finished, series, summary: Default::default() }
    }

    #[test]
    fn work_is_no_growth_and_spurious_energy_is() {
        let judge =
            |kinetic: &[f64], work: &[f64]| Verdict::of(&outcome(kinetic, work), 0.02).unwrap();
        let driven = judge(&[0.0, 1.0, 2.0], &[0.0, 1.1, 2.2]);
        assert!(driven.is_stable() && driven.growth == 0.0);
        let fed = judge(&[0.0, 0.01, 0.03, 0.0], &[0.0; 4]);
        assert!(fed.unstable_from == Some(2.0) && (fed.growth - 0.03).abs() < 1e-12, "{fed:?}");
        assert_eq!(fed.in_words(), "unstable from t = 2");
        // Twice the work: half of the energy at the end is spurious.
        assert!((judge(&[0.0, 1.0, 5.0], &[0.0, 1.0, 2.0]).growth - 1.0).abs() < 1e-12);
        assert!((judge(&[0.0, 0.0, 0.0, 0.01], &[0.0; 4]).rate - 0.01).abs() < 1e-12);
        assert!(driven.rate < 0.0);
    }

    #[test]
    fn a_run_that_failed_is_unstable_and_one_that_was_refused_is_neither() {
        let mut failed = outcome(&[0.0, 0.0], &[0.0, 0.0]);
        failed.end = End::Failed { time: 0.7, reason: "the computation blew up".into() };
        assert_eq!(Verdict::of(&failed, 0.02).unwrap().unstable_from, Some(0.7));
        let refused =
            Verdict::of(&Outcome::refused(&Trial::default(), "too thin".into()), 0.02).unwrap();
        assert!(!refused.is_stable() && refused.in_words() == "refused");
    }
}
