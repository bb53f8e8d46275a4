//! `immersa run`: computes a scene.

use super::SceneArguments;
use super::progress::Progress;
use crate::base::{Error, Kind, Result};
use crate::scene::Scene;
use crate::scene::render::render;
use crate::scene::run::{self, Observer, Options};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

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

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

pub(super) fn run(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    set_threads(arguments.threads)?;
    // Without a handler Ctrl-C ends the program at once, as it does when it comes again; the last checkpoint is still there.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(Kind::Interrupted.exit_code().into());
        }
    });
    let folder = arguments.out.clone().unwrap_or_else(|| default_folder(&scene));
    let mut progress = Progress::new(arguments.quiet, &scene.title);
    let options = Options { folder: folder.clone(), resume: arguments.resume, stop: &STOP };
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

fn set_threads(threads: Option<std::num::NonZeroUsize>) -> Result<()> {
    let Some(n) = threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n.get()).build_global();
    pool.map_err(|e| {
        Error::scene(format!("{n} threads cannot be started: {e}")).at("--threads").value(n).remedy("give fewer")
    })
}
