//! `immersa render`: pictures, film, charts and report of finished runs, and a page that overlays
//! several.

use super::Overrides;
use crate::base::Result;
use crate::scene::render::{overlay, render_with};
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Run folders; the series of several are drawn over each other on a page of its own
    #[arg(required = true, value_name = "DIR")]
    runs: Vec<PathBuf>,
    /// The page of several runs; overlay.html in the folder that holds them without it
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
}

pub(super) fn render(arguments: &Arguments) -> Result<()> {
    let set = &arguments.overrides.set;
    // `render runs/*` may name the page that it wrote before.
    let is_run = |path: &&PathBuf| !(path.is_file() && path.ends_with("overlay.html"));
    let runs: Vec<PathBuf> = arguments.runs.iter().filter(is_run).cloned().collect();
    // The files are written; a closed terminal changes nothing about that.
    let say = |text: String| drop(writeln!(std::io::stdout().lock(), "{text}"));
    for folder in &runs {
        let rendered = render_with(folder, set)?;
        for warning in &rendered.warnings {
            let _ = writeln!(std::io::stderr().lock(), "warning: {warning}");
        }
        let (count, report) = (rendered.files.len(), rendered.report.display());
        say(format!("{count} files are written; open {report}"));
    }
    if runs.len() > 1 || arguments.out.is_some() {
        let page = overlay(&runs, set, arguments.out.as_deref())?;
        say(format!("the runs are drawn over each other in {}", page.display()));
    }
    Ok(())
}
