//! `immersa study precision`: what accuracy costs.

use super::Common;
use crate::base::{Error, Result};
use crate::studies::precision::{self as study, Measurement, Precision, Truth};
use crate::studies::{Axis, Method, Twin};
use std::num::NonZeroUsize;

#[derive(clap::Args)]
#[command(group = clap::ArgGroup::new("truth").required(true).args(["reference", "exact"]))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// A method, as in "BDF2 implicit: time.order=2 numerics.coupling=implicit"; steps=0.01,0.005
    /// or cells=30 there are its own
    #[arg(long, value_name = "NAME: KEY=VALUE ...")]
    method: Vec<Method>,
    /// Values that a key takes in turn, as in numerics.grad_div=1,5; all are combined
    #[arg(long, value_name = "KEY=V1,V2")]
    vary: Vec<String>,
    /// Cells along the first axis of the mesh, as in 30,60
    #[arg(long, value_name = "N1,N2", value_delimiter = ',')]
    cells: Vec<NonZeroUsize>,
    /// Time steps, as in 0.02,0.01
    #[arg(long, value_name = "DT1,DT2", value_delimiter = ',', value_parser = positive)]
    steps: Vec<f64>,
    /// A column of series.csv at a time, the end without it; of several the largest relative error
    /// counts
    #[arg(long, value_name = "COLUMN[@T]", required = true)]
    quantity: Vec<Measurement>,
    /// The run that errors are taken against, as in "cells=120 step=0.0025 time.order=2"; it should
    /// be the finest of all
    #[arg(long, value_name = "KEY=VALUE ...")]
    reference: Option<String>,
    /// The exact value of a quantity; once for each, in their order
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    exact: Vec<f64>,
    /// Errors for which the cheapest setting is reported, as in 1e-2,1e-3
    #[arg(long, value_name = "E1,E2", value_delimiter = ',', value_parser = positive, default_value = "0.01,0.001")]
    tolerance: Vec<f64>,
    /// Run the FreeFEM twin, twin.edp beside the scene, on the same meshes with the same steps
    #[arg(long)]
    twin: bool,
    /// The same with settings of its own, as in "FreeFEM, thin: cells=60 steps=0.005
    /// numerics.thickness=0.05"; once for each
    #[arg(long, value_name = "NAME: KEY=VALUE ...")]
    twin_method: Vec<Method>,
    /// Repetitions of all runs; of the times the least counts
    #[arg(long, value_name = "N", default_value = "2")]
    repeat: NonZeroUsize,
}

/// Does the study.
pub(super) fn precision(arguments: &Arguments) -> Result<()> {
    let options = options(arguments)?;
    arguments.common.conduct("precision", |campaign| study::precision(campaign, &options))
}

fn options(a: &Arguments) -> Result<Precision> {
    let truth = match &a.reference {
        Some(text) => Truth::Reference(Method::settings(text).map_err(|what| {
            let remedy = "write for example --reference \"cells=120 step=0.0025 time.order=2\"";
            Error::scene(what).at("--reference").value(text).remedy(remedy)
        })?),
        None => Truth::Exact(a.exact.clone()),
    };
    Ok(Precision {
        methods: a.method.clone(),
        factors: a.vary.iter().map(|text| Axis::parse(text, "--vary")).collect::<Result<_>>()?,
        cells: a.cells.iter().map(|n| n.get()).collect(),
        steps: a.steps.clone(),
        quantities: a.quantity.clone(),
        truth,
        tolerances: a.tolerance.clone(),
        twin_methods: a.twin_method.clone(),
        twin: if a.twin || !a.twin_method.is_empty() {
            Some(Twin::read(&Twin::beside(a.common.scene.path()))?)
        } else {
            None
        },
        repeat: a.repeat.get(),
    })
}

fn positive(text: &str) -> std::result::Result<f64, String> {
    let number = text.trim().parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite());
    number.ok_or_else(|| "give positive numbers, separated by commas".into())
}
