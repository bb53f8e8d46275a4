//! `immersa explain`: the plan of a scene.

use super::SceneArguments;
use crate::base::Result;
use crate::scene;
use std::io::Write;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
}

pub(super) fn explain(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    let (plan, warnings) = scene::explain(&scene)?;
    let mut out = std::io::stdout().lock();
    // A closed pipe is no reason to fail.
    let _ = writeln!(out, "{}\n\n{plan}", scene.title);
    for w in &warnings {
        let _ = writeln!(out, "warning: {w}");
    }
    Ok(())
}
