//! `immersa explain`: the plan of a scene.

use super::SceneArguments;
use crate::base::Result;
use crate::scene;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
}

pub(super) fn explain(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    let (plan, warnings) = scene::explain(&scene)?;
    let warnings = warnings.iter().map(|w| format!("warning: {w}\n"));
    super::print(&format!("{}\n\n{plan}\n{}", scene.title, warnings.collect::<String>()))
}
