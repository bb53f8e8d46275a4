//! `immersa run`: computes a scene.

use super::progress::Progress;
use super::{SceneArguments, set_threads, stop_on_interrupt};
use crate::base::{Kind, Result, fnv1a};
use crate::scene::Scene;
use crate::scene::render::render;
use crate::scene::run::{self, Earlier, Observer, Options};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// The run folder; runs/NAME without it, NAME being that of the scene file, or of its folder
    /// for a scene.toml, followed by the changes of --set
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue the run of the run folder, interrupted or finished; time.end and what [output]
    /// writes may have changed
    #[arg(long)]
    resume: bool,
    /// Replace the run of the run folder
    #[arg(long, conflicts_with = "resume")]
    overwrite: bool,
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
    let set = &arguments.scene.overrides.set;
    let folder = arguments.out.clone().unwrap_or_else(|| default_folder(&scene, set));
    let earlier = match (arguments.resume, arguments.overwrite) {
        (true, _) => Earlier::Resume,
        (_, true) => Earlier::Replace,
        _ => Earlier::Keep,
    };
    let mut progress = Progress::new(arguments.quiet, &scene.title);
    let command = std::env::args().collect::<Vec<_>>().join(" ");
    let options = Options { folder: folder.clone(), earlier, command, stop: stop_on_interrupt() };
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

/// Longest name of a folder for a scene with changes.
const LONGEST: usize = 120;

/// `runs/NAME`, with the changes of `--set` as `NAME,key=value,...`: signs that file systems or
/// shells do not like are left out, and a name that is too long ends in a hash.
fn default_folder(scene: &Scene, set: &[String]) -> PathBuf {
    let plain = |c: char| c.is_alphanumeric() || "._=-+".contains(c);
    let changes = set.iter().map(|change| change.chars().filter(|c| plain(*c)).collect());
    let name: String =
        std::iter::once(scene.name()).chain(changes).collect::<Vec<String>>().join(",");
    let short = match name.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}-{:016x}", &name[..end], fnv1a(set.join(",").as_bytes())),
        None => name,
    };
    Path::new("runs").join(short)
}
