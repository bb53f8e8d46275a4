//! `immersa study stability`.

use super::Common;
use crate::base::{Error, Result};
use crate::output::Page;
use crate::studies::{Axis, Campaign, stability};
use std::num::NonZeroUsize;

/// The largest stable time step, by bisection, beside the formula (1.54); or, with --scan, which
/// other values are stable.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Couplings of the membrane's force [default: explicit,implicit; with --scan the scene's]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    coupling: Vec<String>,
    /// Orders in time [default: the scene's]
    #[arg(long, value_name = "ORDERS", value_delimiter = ',')]
    order: Vec<String>,
    /// Cells of a generated mesh along its first side [default: the scene's]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    cells: Vec<NonZeroUsize>,
    /// Other values to compare, as in --vary membrane.0.area.linear.modulus=1,10
    #[arg(long, value_name = "KEY=V1,V2")]
    vary: Vec<String>,
    /// Keep the step of the scene and change this instead, as in --scan numerics.thickness=0.1,0.2
    #[arg(long, value_name = "KEY=V1,V2", conflicts_with_all = ["min_step", "max_step", "accuracy"])]
    scan: Vec<String>,
    /// Steps of a run [default: 60; with --scan as many as the scene has]
    #[arg(long, value_name = "N")]
    steps: Option<NonZeroUsize>,
    /// The smallest step tried [default: a twentieth of the formula]
    #[arg(long, value_name = "DT")]
    min_step: Option<f64>,
    /// The largest step tried [default: twenty times the formula]
    #[arg(long, value_name = "DT")]
    max_step: Option<f64>,
    /// Relative width of the bracket around the limit
    #[arg(long, value_name = "FRACTION", default_value = "0.05")]
    accuracy: f64,
    /// Growth of the energy beyond the balance, as a fraction, above which a run is unstable
    #[arg(long, value_name = "FRACTION", default_value_t = stability::TOLERANCE)]
    growth: f64,
}

/// Steps of a run of the bisection.
const STEPS: usize = 60;

impl Arguments {
    pub(super) fn conduct(&self) -> Result<()> {
        self.check()?;
        self.common.conduct("stability", |campaign| self.study(campaign))
    }

    fn study(&self, campaign: &mut Campaign<'_>) -> Result<Page> {
        let mut axes =
            self.scan.iter().map(|t| Axis::parse(t, "--scan")).collect::<Result<Vec<_>>>()?;
        let both = ["explicit".to_string(), "implicit".to_string()];
        match (&self.coupling[..], axes.is_empty()) {
            ([], true) => axes.push(Axis::coupling(&both)),
            ([], false) => {}
            (given, _) => axes.push(Axis::coupling(given)),
        }
        if !self.order.is_empty() {
            axes.push(Axis::order(&self.order));
        }
        if !self.cells.is_empty() {
            let cells: Vec<usize> = self.cells.iter().map(|n| n.get()).collect();
            axes.push(Axis::cells(campaign.scene(), &cells)?);
        }
        for text in &self.vary {
            axes.push(Axis::parse(text, "--vary")?);
        }
        let tolerance = self.growth;
        if !self.scan.is_empty() {
            return stability::Scan { axes, steps: self.steps.map(NonZeroUsize::get), tolerance }
                .conduct(campaign);
        }
        let (least, most, accuracy) = (self.min_step, self.max_step, self.accuracy);
        let steps = self.steps.map_or(STEPS, NonZeroUsize::get);
        stability::LimitSearch { axes, steps, least, most, accuracy, tolerance }.conduct(campaign)
    }

    /// Refuses numbers that make no sense.
    fn check(&self) -> Result<()> {
        let wrong = |what: &str, option: &str, value: f64, remedy: &str| {
            Err(Error::scene(what).at(option).value(value).remedy(remedy))
        };
        let positive = |v: f64| v > 0.0 && v.is_finite();
        for (option, value) in [
            ("--min-step", self.min_step),
            ("--max-step", self.max_step),
            ("--growth", Some(self.growth)),
        ] {
            if let Some(v) = value.filter(|v| !positive(*v)) {
                return wrong(
                    "a positive number is wanted",
                    option,
                    v,
                    &format!("write {option} 0.01"),
                );
            }
        }
        if let (Some(least), Some(most)) = (self.min_step, self.max_step)
            && least >= most
        {
            return wrong(
                "the smallest step is not below the largest one",
                "--min-step",
                least,
                "give --min-step below --max-step",
            );
        }
        if !(1e-3..=1.0).contains(&self.accuracy) {
            let remedy = "give a fraction between 0.001 and 1, as in --accuracy 0.05";
            return wrong("no such accuracy can be had", "--accuracy", self.accuracy, remedy);
        }
        Ok(())
    }
}
