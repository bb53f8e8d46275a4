//! `immersa render`: pictures, film, charts and report of finished runs.

use super::Overrides;
use super::progress::Progress;
use crate::base::Result;
use crate::scene::render::render_with;
use crate::scene::run::Observer;
use std::io::Write;
use std::path::PathBuf;

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
        let rendered = render_with(folder, &arguments.overrides.set)?;
        let mut progress = Progress::new(false, "");
        rendered.warnings.iter().for_each(|w| progress.warning(w));
        // A closed pipe is no reason to fail.
        let _ = writeln!(std::io::stdout().lock(), "report:  {}", rendered.report.display());
    }
    Ok(())
}
