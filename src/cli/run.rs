//! `immersa run`: computes a scene.

use super::progress::Progress;
use super::{SceneArguments, set_threads, stop_on_interrupt};
use crate::base::{Kind, Result};
use crate::scene::Scene;
use crate::scene::render::render;
use crate::scene::run::{self, Observer, Options};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The run folder; runs/NAME without it, NAME being that of the scene file, or of its folder
    /// for a scene.toml
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
    let folder = arguments.out.clone().unwrap_or_else(|| default_folder(&scene));
    let mut progress = Progress::new(arguments.quiet, &scene.title);
    let options =
        Options { folder: folder.clone(), resume: arguments.resume, stop: stop_on_interrupt() };
    let result = run::run(&scene, &options, &mut progress);
    progress.finish();
    // A failed computation has kept its last good state: show that too.
    if matches!(&result, Err(e) if e.kind() != Kind::Computation) {
        return result.map(drop);
    }
    progress.phase("drawing pictures and the report");
    let rendered = render(&folder);
    let outcome = result?;
    let rendered = rendered?;
    rendered.warnings.iter().for_each(|w| progress.warning(w));
    progress.done(&outcome, &rendered.report);
    Ok(())
}

fn default_folder(scene: &Scene) -> PathBuf {
    Path::new("runs").join(scene.name())
}
