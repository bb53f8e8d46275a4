//! The largest stable step of every combination, beside the formula (1.54).

use super::chart::chart;
use super::limit::StepLimit;
use super::search::{largest_stable_step, short};
use super::verdict::Verdict;
use super::{cells, check, columns, heading, per_cent, refusals, trial};
use crate::base::{Error, Kind, Result};
use crate::output::{Cell, KeyNumber, Page, Table, rounded};
use crate::scene::problem;
use crate::studies::axis::{Axis, Choice, assignments, combinations, in_words};
use crate::studies::{Campaign, Trial};

/// Growth of the energy beyond the balance above which a run counts as unstable. Of stable runs it
/// is below 1e-5 (the energy of the relaxing ellipse never rises); beyond the limit it grows by a
/// factor in each step, so that a tolerance of 0.5 % and one of 10 % give the same limit to a few
/// per cent; 2 % is what the recorded FreeFEM limits were taken with.
pub const TOLERANCE: f64 = 0.02;
/// The smallest and the largest step tried, over the formula, when none are given.
const RANGE: [f64; 2] = [0.05, 20.0];
/// The same over the step of the scene, where the formula does not apply.
const RANGE_OF_STEP: [f64; 2] = [0.01, 100.0];

/// Growth in a run of the largest stable step, over the tolerance, that is noted.
const SLOW: f64 = 0.05;

/// The search for the largest stable steps of a scene.
#[derive(Clone, Debug)]
pub struct LimitSearch {
    /// The parameters that differ: coupling, order, cells, other values.
    pub axes: Vec<Axis>,
    /// Steps of a run.
    pub steps: usize,
    /// The smallest step tried; a twentieth of the formula without it.
    pub least: Option<f64>,
    /// The largest step tried; twenty times the formula without it.
    pub most: Option<f64>,
    /// Relative width of the bracket.
    pub accuracy: f64,
    /// The [`TOLERANCE`], or another one.
    pub tolerance: f64,
}

impl LimitSearch {
    /// Finds the limits; the result is a page.
    ///
    /// # Errors
    /// Values that the scene does not take; as for [`Campaign::run`]. A run that fails or is
    /// refused is a result.
    pub fn conduct(&self, campaign: &mut Campaign<'_>) -> Result<Page> {
        check(campaign, &self.axes, &["time.step", "time.end"])?;
        if campaign.scene().acting().next().is_none() {
            return Err(Error::scene(
                "the scene has no membrane, whose coupling could be unstable",
            )
            .value("no [[membrane]]")
            .remedy("add one, or ask with --scan which values of another key are stable"));
        }
        let all = combinations(&self.axes);
        let mut probes = Table::new("probes", "Runs", columns(&self.axes, &PROBES));
        let mut limits = Vec::new();
        for (k, combination) in all.iter().enumerate() {
            limits.push(self.limit(campaign, combination, [k + 1, all.len()], &mut probes)?);
        }
        if let Some(reason) =
            limits.iter().map(|l| l.refused.as_deref()).collect::<Option<Vec<_>>>()
        {
            return Err(Error::scene("no combination could be run")
                .value(reason.first().copied().unwrap_or_default())
                .remedy(
                    "correct the scene or the values: `immersa explain SCENE` with them as --set \
                     says more",
                ));
        }
        let title = &campaign.scene().title;
        Ok(Page {
            title: format!("Stability: {title}"),
            subtitle: format!("Largest stable steps of {} combinations, by bisection", all.len()),
            statements: limits.iter().map(|l| statement(l, &limits)).collect(),
            notes: self.notes(&limits),
            key_numbers: limits.iter().take(4).map(headline).collect(),
            tables: vec![self.table(&limits)],
            details: vec![probes],
            charts: (0..self.axes.len()).filter_map(|k| chart(&self.axes, k, &limits)).collect(),
            ..Page::default()
        })
    }

    fn limit(
        &self,
        campaign: &mut Campaign<'_>,
        combination: &[Choice],
        [k, of]: [usize; 2],
        probes: &mut Table,
    ) -> Result<StepLimit> {
        let mut limit = StepLimit { combination: combination.to_vec(), ..StepLimit::default() };
        let scene = campaign.scene_of(&Trial::new("", assignments(combination)))?;
        match problem(&scene).map(|p| p.limits()) {
            Ok(found) => {
                limit.edge = found.band_edges.map(|e| e[0]);
                limit.formula = found.explicit_limit;
                limit.is_slack = found.stretched_limit.is_some();
            }
            Err(e) if e.kind() == Kind::Scene => {
                campaign.listener().note(&format!("[{k}/{of}] {}: refused", in_words(combination)));
                return Ok(StepLimit { refused: Some(e.to_string()), ..limit });
            }
            Err(e) => return Err(e),
        }
        let (unit, factors) =
            limit.formula.map_or((scene.time.step, RANGE_OF_STEP), |f| (f, RANGE));
        let range = range(self.least, self.most, unit, factors);
        // What the formula does not bind may well be stable at the largest step.
        let guess = if scene.numerics.coupling.is_explicit() { unit } else { range[1] };
        let (mut refused, mut best) = (None, (0.0, Verdict::default()));
        limit.bracket = largest_stable_step(guess, range, self.accuracy, |dt| {
            if refused.is_some() {
                return Ok(false);
            }
            let verdict = Verdict::of(
                &campaign.run(&trial(combination, dt, self.steps), k, of)?,
                self.tolerance,
            )?;
            refused.clone_from(&verdict.refused);
            probes.rows.push(probe(combination, dt, &verdict));
            let stable = verdict.is_stable();
            if stable && dt > best.0 {
                best = (dt, verdict);
            }
            Ok(stable)
        })?;
        (limit.refused, limit.verdict) = (refused, best.1);
        Ok(limit)
    }

    fn table(&self, limits: &[StepLimit]) -> Table {
        let header = ["edge", "stable", "unstable", "formula", "ratio", "growth", "rate", "remark"];
        let mut table = Table::new("limits", "Largest stable steps", columns(&self.axes, &header));
        for l in limits {
            let of_stable = |v: f64| l.bracket.stable.map(|_| v);
            let mut row = cells(&l.combination);
            row.extend([
                Cell::optional(l.edge, 4),
                Cell::optional(l.bracket.stable, 4),
                Cell::optional(l.bracket.unstable, 4),
                Cell::optional(l.formula, 4),
                Cell::optional(l.ratio(), 3),
                Cell::optional(of_stable(l.verdict.growth), 2),
                Cell::optional(of_stable(l.verdict.rate), 2),
                Cell::text(l.remark()),
            ]);
            table.rows.push(row);
        }
        table.caption = "Formula: (1.54) with the density, the tension at the start and dx = 2 h/sqrt(60), \
            h the shortest edge in the band; of order 2 with half the viscosity. Ratio: the measured limit over it. Growth: of the \
            energy beyond the balance at the largest stable step, the most in the run. Rate: its \
            change per time in the second half of that run, negative while energy is lost."
            .into();
        table
    }

    fn notes(&self, limits: &[StepLimit]) -> Vec<String> {
        let mut notes = vec![format!(
            "A run of {} steps is unstable when it fails, or when kinetic and elastic energy \
             exceed the energy at the start and the work put in by more than {}. Steps are known \
             to {}.",
            self.steps,
            per_cent(self.tolerance),
            per_cent(self.accuracy)
        )];
        for l in limits {
            let name = heading(&l.combination);
            if let (Some(stable), false) = (l.bracket.stable, l.bracket.islands.is_empty()) {
                let islands =
                    l.bracket.islands.iter().map(|s| rounded(*s, 4)).collect::<Vec<_>>().join(", ");
                notes.push(format!(
                    "{name}unstable at {islands} although stable at {}: no bound.",
                    rounded(stable, 4)
                ));
            }
            if l.is_slack {
                notes.push(format!(
                    "{name}at the start there is little tension or none, and the formula gives no \
                     bound: it falls as the membrane is stretched."
                ));
            }
            if l.bracket
                .stable
                .is_some_and(|dt| l.verdict.rate * dt * self.steps as f64 > SLOW * self.tolerance)
            {
                notes.push(format!(
                    "{name}at the largest stable step the energy grows by {} per time: with more \
                     --steps the limit may be lower.",
                    per_cent(l.verdict.rate)
                ));
            }
        }
        notes.extend(refusals(
            limits.iter().filter_map(|l| Some((&l.combination[..], l.refused.as_deref()?))),
        ));
        notes
    }
}

/// The steps that are searched: the ends that are given, and else `factors` of `unit`; an end that
/// is given moves the other one along, so that there is something between them.
fn range(least: Option<f64>, most: Option<f64>, unit: f64, factors: [f64; 2]) -> [f64; 2] {
    let low = || short(factors[0] * most.map_or(unit, |m| m.min(unit)));
    let high = || short(factors[1] * least.map_or(unit, |l| l.max(unit)));
    [least.unwrap_or_else(low), most.unwrap_or_else(high)]
}

/// Columns after those of the axes in the table of all runs.
const PROBES: [&str; 6] =
    ["step", "growth", "energy_from_nowhere", "rate", "area_change", "outcome"];

fn probe(combination: &[Choice], dt: f64, v: &Verdict) -> Vec<Cell> {
    let numbers = [dt, v.growth, v.residual, v.rate, v.area].map(|v| Cell::number(v, 4));
    [cells(combination), numbers.to_vec(), vec![Cell::text(v.in_words())]].concat()
}

/// The limit of the explicit coupling where all but the scheme is the same, of the same order if it
/// was asked for.
fn explicit<'a>(limit: &StepLimit, all: &'a [StepLimit]) -> Option<&'a StepLimit> {
    let has = |l: &StepLimit, of: &StepLimit, name: &str| {
        l.combination.iter().find(|c| c.name == name)
            == of.combination.iter().find(|c| c.name == name)
    };
    let mut found: Vec<&StepLimit> = all
        .iter()
        .filter(|l| l.physics() == limit.physics() && l.bracket.stable.is_some())
        .filter(|l| l.combination.iter().any(|c| c.name == "coupling" && c.value == "explicit"))
        .collect();
    found.sort_by_key(|l| !has(l, limit, "order"));
    found.first().copied().filter(|l| l.combination != limit.combination)
}

fn statement(limit: &StepLimit, all: &[StepLimit]) -> String {
    let number = |v: f64| rounded(v, 3);
    let b = &limit.bracket;
    let found = match (&limit.refused, b.stable, b.unstable) {
        (Some(_), ..) => return format!("{}refused.", heading(&limit.combination)),
        (None, Some(s), Some(u)) => format!("stable at {}, unstable at {}", number(s), number(u)),
        (None, Some(s), None) => format!("stable at {}, the largest step tried", number(s)),
        (None, None, u) => {
            format!("unstable at {}, the smallest step tried", number(u.unwrap_or(f64::NAN)))
        }
    };
    let mut text = format!("{}{found}", heading(&limit.combination));
    if let (Some(s), Some(e)) = (b.stable, explicit(limit, all).and_then(|l| l.bracket.stable)) {
        text += &format!(": {} times the explicit limit", number(s / e));
    } else if let Some(formula) = limit.formula {
        text += &format!("; formula (1.54) {}", number(formula));
        text += &limit.ratio().map_or_else(String::new, |r| format!(" (ratio {r:.2})"));
    }
    text + "."
}

fn headline(limit: &StepLimit) -> KeyNumber {
    let number = |v: f64| rounded(v, 3);
    let value = match (limit.bracket.stable, limit.bracket.unstable) {
        (Some(s), None) => format!("at least {}", number(s)),
        (None, Some(u)) => format!("below {}", number(u)),
        _ => limit.limit().map_or_else(|| "refused".into(), number),
    };
    let note = limit.formula.map_or_else(String::new, |f| format!("(1.54): {}", number(f)));
    KeyNumber { label: in_words(&limit.combination), value, note }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_something_between_the_ends_of_the_search() {
        for (least, most) in
            [(None, None), (Some(5.0), None), (None, Some(1e-5)), (Some(1e-3), Some(0.5))]
        {
            let [a, b] = range(least, most, 0.01, RANGE);
            assert!(
                a < b && least.is_none_or(|l| l == a) && most.is_none_or(|m| m == b),
                "{a} .. {b}"
            );
        }
    }
}
