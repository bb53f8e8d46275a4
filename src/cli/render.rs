//! `immersa render`: pictures and a film of finished runs.

use super::Overrides;
use crate::base::{Error, Result};
use crate::scene::Scene;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Run folders
    #[arg(required = true, value_name = "DIR")]
    runs: Vec<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn render(arguments: &Arguments) -> Result<()> {
    for folder in &arguments.runs {
        load(folder, &arguments.overrides.set)?;
    }
    Ok(())
}

/// The resolved scene of a run folder.
fn load(folder: &Path, overrides: &[String]) -> Result<Scene> {
    let scene = folder.join("scene.toml");
    if scene.is_file() {
        return Scene::load(&scene, overrides);
    }
    Err(Error::input("this is not the folder of a run: it has no scene.toml")
        .at(folder.display().to_string())
        .value(folder.display())
        .remedy("give a folder that `immersa run` has written"))
}
