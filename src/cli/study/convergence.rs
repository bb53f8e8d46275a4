//! `immersa study convergence`.

use super::Common;
use crate::base::{Error, Result};
use crate::studies::convergence::{Convergence, Halved, convergence};
use clap::ValueEnum;
use std::path::PathBuf;

/// Treatment of the mesh when the thickness is halved.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Thickness {
    /// Its size is halved too
    Scaled,
    /// It stays as it is
    Alone,
}

#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Levels; the scene is the coarsest
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u64).range(2..=12))]
    levels: u64,
    /// Halve the mesh size
    #[arg(long)]
    space: bool,
    /// Halve the time step
    #[arg(long)]
    time: bool,
    /// Halve mesh size and time step: what is done when nothing else is asked for
    #[arg(long)]
    both: bool,
    /// Halve the half-width of the band, and with it the mesh size, so that the band stays as many
    /// edges wide; --thickness=alone keeps the mesh
    #[arg(long, value_name = "HOW", num_args = 0..=1, require_equals = true, default_missing_value = "scaled")]
    thickness: Option<Thickness>,
    /// Take these mesh files, from coarse to fine, instead of halving
    #[arg(long, value_name = "FILES", value_delimiter = ',', conflicts_with_all = ["space", "time", "both", "thickness", "levels"])]
    meshes: Vec<PathBuf>,
    /// Columns of series.csv, or `interface` for the distances of the interfaces from level to
    /// level
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    quantity: Vec<String>,
    /// Times at which they are taken; the end of the scene without it
    #[arg(long, value_name = "T", value_delimiter = ',')]
    at: Vec<f64>,
    /// The order that theory gives: extrapolate with it
    #[arg(long, value_name = "P")]
    order: Option<f64>,
    /// Leave out the runs that show what the things do that are not refined
    #[arg(long)]
    no_checks: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let a = arguments;
    if a.order.is_some_and(|p| !(0.1..=10.0).contains(&p)) {
        return Err(Error::scene("the order is no order of a method")
            .at("--order")
            .remedy("give a number from 0.1 to 10"));
    }
    let nothing = !(a.space || a.time || a.both || a.thickness.is_some()) && a.meshes.is_empty();
    let settings = Convergence {
        halved: Halved {
            space: a.space
                || a.both
                || nothing
                || a.thickness == Some(Thickness::Scaled)
                || !a.meshes.is_empty(),
            time: a.time || a.both || nothing,
            thickness: a.thickness.is_some(),
        },
        levels: usize::try_from(a.levels).unwrap_or(usize::MAX),
        meshes: a.meshes.clone(),
        quantities: a.quantity.clone(),
        times: a.at.clone(),
        order: a.order,
        checks: !a.no_checks,
    };
    a.common.conduct("convergence", |campaign| convergence(campaign, &settings))
}
