//! `immersa run`: computes a scene.

use super::SceneArguments;
use crate::base::{Error, Result};
use crate::scene::Scene;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The run folder; runs/NAME without it, NAME being that of the scene file, or of its folder for a scene.toml
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue the interrupted run of the run folder
    #[arg(long)]
    resume: bool,
    /// Threads that compute; all cores without it
    #[arg(long, value_name = "N")]
    threads: Option<std::num::NonZeroUsize>,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    set_threads(arguments.threads)?;
    let _folder = arguments.out.clone().unwrap_or_else(|| default_folder(&scene));
    Ok(())
}

fn default_folder(scene: &Scene) -> PathBuf {
    Path::new("runs").join(scene.name())
}

fn set_threads(threads: Option<std::num::NonZeroUsize>) -> Result<()> {
    let Some(n) = threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n.get()).build_global();
    pool.map_err(|e| {
        Error::scene(format!("{n} threads cannot be started: {e}")).at("--threads").value(n).remedy("give fewer")
    })
}
