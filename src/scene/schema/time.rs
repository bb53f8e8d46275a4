//! `[time]`: how long, in which steps.

use crate::base::Result;
use crate::scene::keys::Item;
use crate::scene::keys::{Absent::*, Keys, Kind::Value, row};
use crate::scene::keys::{Writer, number};

/// The time grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// The end; the start is 0.
    pub end: f64,
    /// The time step, `end` being a multiple of it; with a tolerance the first one.
    pub step: f64,
    /// What relative errors of all steps may add up to; `None` for steps of one length.
    pub tolerance: Option<f64>,
    /// The shortest step that the error may ask for.
    pub step_min: Option<f64>,
    /// The longest step.
    pub step_max: Option<f64>,
    /// Order of the backward difference formula, 1 or 2.
    pub order: usize,
}

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "How long, in which steps.",
    keys: &[
        row("end", Value("number > 0"), "s", Required, "The end, a multiple of the step; the start is 0."),
        row("step", Value("number > 0"), "s", Required, "The time step."),
        row(
            "tolerance",
            Value("number > 0, at most 0.1"),
            "",
            Optional,
            "Lets the steps follow the error: what the relative errors of velocity and positions in all steps to `end` may add up to, as they \
             are estimated; a step `dt` may make the part `dt/end` of it. `step` is then the first one. Needs `order = 2`.",
        ),
        row(
            "step_min",
            Value("number > 0"),
            "s",
            Derived("`time.step`/1e4"),
            "With a tolerance: the shortest step; where the error asks for a shorter one, the run ends.",
        ),
        row("step_max", Value("number > 0"), "s", Derived("`time.end`"), "With a tolerance: the longest step."),
        row("order", Value("1 or 2"), "", Default("2"), "Order of the backward difference formula (BDF1 or BDF2)."),
    ],
};

/// Relative rounding that a multiple of the step may have.
const ROUNDING: f64 = 1e-9;
const MOST_STEPS: f64 = 1e9;
const MOST_TOLERANCE: f64 = 0.1;
/// The shortest step over the first, where the scene does not say.
const LEAST: f64 = 1e-4;

impl Time {
    pub(in crate::scene) fn read(item: &Item) -> Result<Time> {
        let table = item.table(&KEYS)?;
        let time = Time {
            tolerance: table.optional("tolerance", tolerance)?,
            step_min: table.optional("step_min", Item::positive)?,
            step_max: table.optional("step_max", Item::positive)?,
            end: table.required("end", "give the end: end = 1.0", Item::positive)?,
            step: table.required("step", "give the time step: step = 1e-3", Item::positive)?,
            order: table.optional("order", |i| i.count(1, 2))?.unwrap_or(2),
        };
        for key in ["step_min", "step_max"] {
            if let (Some(item), None) = (table.get(key), time.tolerance) {
                return Err(item
                    .key_error(format!("`{key}` bounds steps that follow the error, and these have one length"))
                    .remedy("add time.tolerance = 1e-2, or leave it out"));
            }
        }
        table.optional("end", |i| time.check(i))?;
        Ok(time)
    }

    fn check(&self, end: &Item) -> Result<()> {
        let ratio = self.end / self.step;
        if self.tolerance.is_some() && (1.0..=MOST_STEPS).contains(&ratio) {
            return Ok(());
        }
        if ratio > MOST_STEPS {
            return Err(end
                .error(format!("{ratio:.1e} time steps are too many"))
                .remedy(format!("give a larger step or an earlier end; at most {MOST_STEPS:e} steps are made")));
        }
        if (ratio - ratio.round()).abs() <= ROUNDING * ratio && ratio.round() >= 1.0 {
            return Ok(());
        }
        let ends: Vec<String> =
            [ratio.floor(), ratio.ceil()].iter().filter(|n| **n >= 1.0).map(|n| short(n * self.step)).collect();
        Err(end
            .error(format!("`time.end` is not a multiple of the step {}", self.step))
            .remedy(format!("the nearest ends are {}", ends.join(" and "))))
    }

    /// The shortest and the longest step that the error may ask for.
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

    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        out.header("[time]");
        out.entry("end", number(self.end));
        out.entry("step", number(self.step));
        let optional = [("tolerance", self.tolerance), ("step_min", self.step_min), ("step_max", self.step_max)];
        for (key, value) in optional {
            value.into_iter().for_each(|v| out.entry(key, number(v)));
        }
        out.entry("order", self.order);
    }
}

fn tolerance(item: &Item) -> Result<f64> {
    let v = item.positive()?;
    if v <= MOST_TOLERANCE {
        return Ok(v);
    }
    Err(item
        .error(format!("a tolerance of {v} is no control"))
        .remedy(format!("give a number up to {MOST_TOLERANCE}, for example 1e-3")))
}

/// A number without the rounding of its last digits.
fn short(v: f64) -> String {
    format!("{v:.12e}").parse::<f64>().unwrap_or(v).to_string()
}
