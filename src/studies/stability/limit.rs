//! The largest stable step of a combination.

use super::search::Bracket;
use super::verdict::Verdict;
use crate::studies::axis::Choice;

/// Bounds of the stable step of a combination.
#[derive(Clone, Debug, Default)]
pub(super) struct StepLimit {
    pub combination: Vec<Choice>,
    /// Shortest edge in the bands.
    pub edge: Option<f64>,
    /// (1.54) at the start.
    pub formula: Option<f64>,
    /// True if a membrane has less tension at the start than a small stretch gives it.
    pub is_slack: bool,
    pub bracket: Bracket,
    /// Of the largest stable step.
    pub verdict: Verdict,
    pub refused: Option<String>,
}

impl StepLimit {
    /// The measured limit over the formula.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.limit()? / self.formula?)
    }
    /// The limit as far as it is known; none for a combination that is unstable at every step or
    /// was refused.
    pub fn limit(&self) -> Option<f64> {
        self.bracket.stable.and_then(|_| self.bracket.limit())
    }
    /// Reason for which the search did not find both ends.
    pub fn remark(&self) -> &'static str {
        match (&self.refused, self.bracket.stable, self.bracket.unstable) {
            (Some(_), ..) => "refused",
            (None, Some(_), None) => "stable at the largest step tried",
            (None, None, _) => "unstable at the smallest step tried",
            (None, Some(_), Some(_)) if !self.bracket.islands.is_empty() => {
                "unstable at smaller steps too"
            }
            (None, Some(_), Some(_)) => "",
        }
    }
    /// The choices of the combination apart from the scheme.
    pub fn physics(&self) -> Vec<Choice> {
        self.combination.iter().filter(|c| !is_scheme(&c.name)).cloned().collect()
    }
}

pub(super) fn is_scheme(name: &str) -> bool {
    ["coupling", "order"].contains(&name)
}
