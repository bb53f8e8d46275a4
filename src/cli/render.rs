//! `immersa render`: pictures, film, charts and report of finished runs.

use super::Overrides;
use crate::base::Result;
use crate::scene::render::render_with;
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
        // The files are written; a closed terminal changes nothing about that.
        for warning in &rendered.warnings {
            let _ = writeln!(std::io::stderr().lock(), "warning: {warning}");
        }
        let _ = writeln!(
            std::io::stdout().lock(),
            "{} files are written; open {}",
            rendered.files.len(),
            rendered.report.display()
        );
    }
    Ok(())
}
