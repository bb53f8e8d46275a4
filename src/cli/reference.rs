//! `immersa reference`: the keys of a scene.

use crate::base::Result;
use crate::scene::reference;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// A table of the scene, such as numerics or membrane.shape; all without it
    table: Option<String>,
}

pub(super) fn reference(arguments: &Arguments) -> Result<()> {
    let text = reference::reference(arguments.table.as_deref())?;
    super::print(&text)
}
