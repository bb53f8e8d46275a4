//! `immersa compare`: a scene and its FreeFEM twin.

use super::study::Common;
use crate::base::{Error, Result};
use crate::studies::{Bound, Comparison, Twin, compare as comparison, compare_meshes};
use std::num::NonZeroUsize;
use std::path::PathBuf;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// The FreeFEM script; twin.edp beside the scene without it
    #[arg(long, value_name = "FILE")]
    twin: Option<PathBuf>,
    /// Compare on several meshes, with these numbers of cells along the first side, and give the
    /// costs of all in one table
    #[arg(long, value_name = "N1,N2,...", value_delimiter = ',', conflicts_with = "record")]
    cells: Vec<NonZeroUsize>,
    /// Repetitions of both, in turn; of the times the least counts
    #[arg(long, value_name = "N", default_value = "2")]
    repeat: NonZeroUsize,
    /// Fail when a quantity differs by more than this part of its largest value; with COLUMN= for
    /// one quantity
    #[arg(long, value_name = "[COLUMN=]BOUND")]
    within: Vec<Bound>,
    /// Keep FreeFEM's result as data/NAME beside the twin, for where FreeFEM is not installed
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
}

pub(super) fn compare(arguments: &Arguments) -> Result<()> {
    let path =
        arguments.twin.clone().unwrap_or_else(|| Twin::beside(arguments.common.scene.path()));
    let twin = Twin::read(&path)?;
    let options = Comparison {
        repeat: arguments.repeat.get(),
        bounds: arguments.within.clone(),
        record: arguments.record.clone(),
    };
    let scene = arguments.common.scene.load_after(twin.settings())?;
    let mut cells: Vec<usize> = arguments.cells.iter().map(|n| n.get()).collect();
    cells.sort_unstable();
    cells.dedup();
    let found = arguments.common.conduct_with(&scene, "compare", |campaign| match cells[..] {
        [] => comparison(campaign, &twin, &options),
        _ => compare_meshes(campaign, &twin, &options, &cells),
    })?;
    if found.alarms.is_empty() {
        return Ok(());
    }
    Err(Error::computation("immersa and FreeFEM differ by more than --within allows")
        .value(found.alarms.join(" "))
        .remedy("see the differences in the report; without --within nothing is asserted"))
}
