//! `immersa explain`: the plan of a scene.

use super::SceneArguments;
use crate::base::Result;

#[derive(clap::Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
}

pub(super) fn explain(arguments: &Arguments) -> Result<()> {
    arguments.scene.load()?;
    Ok(())
}
