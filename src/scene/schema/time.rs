//! `[time]`: end time and steps.

use crate::base::Result;
use crate::scene::keys::{Context, Count, Form, Item, Kind, Opt, Positive, Table, kinds, table};

table! {
    /// How long, in which steps.
    Time: Copy {
        /// The end, a multiple of the step; the start is 0.
        end: f64 [Positive, "s", Required("give the end: end = 1.0")],
        /// The time step.
        step: f64 [Positive, "s", Required("give the time step: step = 1e-3")],
        /// Lets the steps follow the error: what the relative errors of velocity and positions in
        /// all steps to `end` may add up to, as they are estimated; a step `dt` may make the part
        /// `dt/end` of it. `step` is then the first one. Needs `order = 2`.
        tolerance: Option<f64> [Opt<Tolerance>],
        /// With a tolerance: the shortest step; where the error asks for a shorter one, the run
        /// ends.
        step_min: Option<f64> [Opt<Positive>, "s", Derived("`time.step`/1e4")],
        /// With a tolerance: the longest step.
        step_max: Option<f64> [Opt<Positive>, "s", Derived("`time.end`")],
        /// Order of the backward difference formula (BDF1 to BDF3). Order 3 is for flows without
        /// structures in steps of one length, with `numerics.convection = "baker1982"` or false: at
        /// the same step and cost its error is a tenth, up to Courant numbers of about 5.
        order: usize [Count<1, 3>, Default(2)],
    } check Time::check;
}

kinds! {
    /// Bound of the sum of relative errors.
    Tolerance: f64 = Kind::Value(
        "number > 0, at most 0.1",
        Form::Number { least: 0.0, most: MOST_TOLERANCE, open: true },
    ), tolerance;
}

/// Relative rounding error allowed for a multiple of the step.
const ROUNDING: f64 = 1e-9;
const MOST_STEPS: f64 = 1e9;
const MOST_TOLERANCE: f64 = 0.1;
/// Default shortest step over the first step.
const LEAST: f64 = 1e-4;

impl Time {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        for key in ["step_min", "step_max"] {
            if let (Some(item), None) = (table.get(key), self.tolerance) {
                return Err(item
                    .key_error(format!(
                        "`{key}` bounds steps that follow the error, and these have one length"
                    ))
                    .remedy("add time.tolerance = 1e-2, or leave it out"));
            }
        }
        table.get("end").map_or(Ok(()), |end| self.check_end(&end))
    }

    fn check_end(&self, end: &Item) -> Result<()> {
        let ratio = self.end / self.step;
        if self.tolerance.is_some() && (1.0..=MOST_STEPS).contains(&ratio) {
            return Ok(());
        }
        if ratio > MOST_STEPS {
            return Err(end.error(format!("{ratio:.1e} time steps are too many")).remedy(format!(
                "give a larger step or an earlier end; at most {MOST_STEPS:e} steps are made"
            )));
        }
        if (ratio - ratio.round()).abs() <= ROUNDING * ratio && ratio.round() >= 1.0 {
            return Ok(());
        }
        let ends: Vec<String> = [ratio.floor(), ratio.ceil()]
            .iter()
            .filter(|n| **n >= 1.0)
            .map(|n| short(n * self.step))
            .collect();
        Err(end
            .error(format!("`time.end` is not a multiple of the step {}", self.step))
            .remedy(format!("the nearest ends are {}", ends.join(" and "))))
    }

    /// The shortest and the longest adaptive step.
    pub fn bounds(&self) -> [f64; 2] {
        [self.step_min.unwrap_or(LEAST * self.step), self.step_max.unwrap_or(self.end)]
    }

    /// The number of steps from 0 to `end`.
    pub fn steps(&self) -> usize {
        (self.end / self.step).round() as usize
    }

    /// The first step at or after the time `t`.
    pub fn step_at(&self, t: f64) -> usize {
        let ratio = t / self.step;
        (ratio - ROUNDING * ratio.max(1.0)).ceil().max(0.0) as usize
    }
}

fn tolerance(item: &Item, _: &Context) -> Result<f64> {
    let v = item.positive()?;
    if v <= MOST_TOLERANCE {
        return Ok(v);
    }
    Err(item
        .error(format!("a tolerance of {v} is no control"))
        .remedy(format!("give a number up to {MOST_TOLERANCE}, for example 1e-3")))
}

/// A number without the rounding error of its last digits.
fn short(v: f64) -> String {
    format!("{v:.12e}").parse::<f64>().unwrap_or(v).to_string()
}
