//! `immersa study precision`: what accuracy costs.

use super::Common;
use crate::base::{Error, Result};
use crate::studies::{Factor, Method, Precision, Quantity, Truth, Twin, numbers, precision as study};
use std::num::NonZeroUsize;

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("truth").required(true).args(["reference", "exact"]))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// A method, as in "BDF2 implicit: time.order=2 numerics.coupling=implicit"; steps=0.01,0.005 or cells=30 there are its own
    #[arg(long, value_name = "NAME: KEY=VALUE ...")]
    method: Vec<Method>,
    /// Values that a key takes in turn, as in numerics.grad_div=1,5; all are combined
    #[arg(long, value_name = "KEY=V1,V2")]
    vary: Vec<Factor>,
    /// Cells along the first axis of the mesh, as in 30,60
    #[arg(long, value_name = "N1,N2")]
    cells: Option<String>,
    /// Time steps, as in 0.02,0.01
    #[arg(long, value_name = "DT1,DT2")]
    steps: Option<String>,
    /// A column of series.csv at a time, the end without it; of several the largest relative error counts
    #[arg(long, value_name = "COLUMN[@T]", required = true)]
    quantity: Vec<Quantity>,
    /// The run that errors are taken against, as in "cells=120 step=0.0025 time.order=2"; it should be the finest of all
    #[arg(long, value_name = "KEY=VALUE ...")]
    reference: Option<String>,
    /// The exact value of a quantity; once for each, in their order
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    exact: Vec<f64>,
    /// Errors for which the cheapest setting is told, as in 1e-2,1e-3
    #[arg(long, value_name = "E1,E2", default_value = "0.01,0.001")]
    tolerance: String,
    /// Run the FreeFEM twin, twin.edp beside the scene, on the same meshes with the same steps
    #[arg(long)]
    twin: bool,
    /// How often everything is run; of the times the least counts
    #[arg(long, value_name = "N", default_value = "2")]
    repeat: NonZeroUsize,
}

/// Does the study.
pub(super) fn precision(arguments: &Arguments) -> Result<()> {
    let told = told(arguments)?;
    arguments.common.conduct("precision", |campaign| study(campaign, &told))
}

fn told(a: &Arguments) -> Result<Precision> {
    let wrong = |key: &'static str, value: &str| {
        let value = value.to_string();
        move |what: String| {
            Error::scene(what).at(key).value(value).remedy(format!("see `immersa study precision --help` for {key}"))
        }
    };
    let list = |text: &Option<String>| text.clone().unwrap_or_default();
    let cells = list(&a.cells);
    let steps = list(&a.steps);
    let truth = match &a.reference {
        Some(text) => Truth::Reference(Method::settings(text).map_err(wrong("--reference", text))?),
        None => Truth::Exact(a.exact.clone()),
    };
    Ok(Precision {
        methods: a.method.clone(),
        factors: a.vary.clone(),
        cells: if cells.is_empty() { vec![] } else { numbers(&cells).map_err(wrong("--cells", &cells))? },
        steps: if steps.is_empty() { vec![] } else { numbers(&steps).map_err(wrong("--steps", &steps))? },
        quantities: a.quantity.clone(),
        truth,
        tolerances: numbers(&a.tolerance).map_err(wrong("--tolerance", &a.tolerance))?,
        twin: if a.twin { Some(Twin::read(&Twin::beside(a.common.scene.path()))?) } else { None },
        repeat: a.repeat.get(),
    })
}
