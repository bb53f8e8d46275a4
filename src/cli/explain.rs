//! `immersa explain`: the plan of a scene.

use super::SceneArguments;
use crate::base::Result;
use crate::scene;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Print sizes, limits, columns, warnings and the plan as JSON, for other programs
    #[arg(long)]
    json: bool,
}

pub(super) fn explain(arguments: &Arguments) -> Result<()> {
    let scene = arguments.scene.load()?;
    let explained = scene::explain(&scene)?;
    super::print(&match arguments.json {
        true => format!("{:#}\n", explained.json()),
        false => explained.text(),
    })
}
