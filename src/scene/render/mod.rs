//! Pictures, a film, charts and the report page of a run, generated from its folder alone.
//!
//! The output depends only on the folder: the same folder gives the same bytes.

mod balances;
mod charts;
mod folder;
mod overlay;
mod page;
mod pictures;
mod segmentation;
mod summary;
#[cfg(test)]
mod tests;
mod units;

pub use overlay::overlay;
pub use summary::{Balance, Summary};

use crate::base::{Error, Result, Warning};
use crate::output::{Figure, write_file};
use crate::scene::charts::Plot;
use folder::RunFolder;
use std::path::{Path, PathBuf};

/// The files that were made.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// All files, the report last.
    pub files: Vec<PathBuf>,
    /// The report page.
    pub report: PathBuf,
    /// Warnings of files that could not be made.
    pub warnings: Vec<Warning>,
}

/// Generates `pictures/NNNNNN.png`, `film.gif` (and `film.mp4` if the program `ffmpeg` is
/// available), `charts/NAME.svg` and `report.html` in the folder of a run. Existing files are
/// replaced.
///
/// # Errors
/// Of kind [`Input`](crate::base::Kind::Input): the folder is not that of a run; a file is missing
/// or corrupt; a file cannot be written. Of kind [`Scene`](crate::base::Kind::Scene): its
/// `scene.toml` is invalid.
pub fn render(folder: &Path) -> Result<Rendered> {
    render_with(folder, &[])
}

/// Keys that change how a run is shown.
const SHOWN: [&str; 5] = ["output.picture", "output.pictures", "output.film", "title", "units"];

/// Refuses changes of what was computed: the report would show what was not.
///
/// # Errors
/// Such a change.
fn check_overrides(overrides: &[String]) -> Result<()> {
    let key = |text: &str| text.split('=').next().unwrap_or_default().trim().to_string();
    let shows = |key: &str| {
        let of = |shown: &str| {
            key.strip_prefix(shown).is_some_and(|k| k.is_empty() || k.starts_with('.'))
        };
        SHOWN.iter().any(|shown| of(shown))
    };
    match overrides.iter().find(|text| !shows(&key(text))) {
        None => Ok(()),
        Some(text) => Err(Error::scene("a run is shown as it was computed, and this changes it")
            .at(format!("--set {text}"))
            .value(key(text))
            .remedy(format!("change {} alone, or compute a new run", SHOWN.join(", ")))),
    }
}

/// As [`render`], with single values of the scene overridden, each in the form `key.sub=value`:
/// `output.picture.field=speed`.
///
/// # Errors
/// As for [`render`]; an invalid value.
pub fn render_with(folder: &Path, overrides: &[String]) -> Result<Rendered> {
    check_overrides(overrides)?;
    let mut run = RunFolder::open(folder, overrides)?;
    let gallery = pictures::draw(&mut run)?;
    let charts: Vec<Figure> = charts::draw(&run).iter().map(Plot::figure).collect();
    let mut files = gallery.files.clone();
    if !charts.is_empty() {
        run.folder("charts")?;
    }
    for (name, bytes) in charts.iter().filter_map(Figure::file) {
        let path = run.path.join("charts").join(name);
        write_file(&path, bytes)?;
        files.push(path);
    }
    let report = run.path.join("report.html");
    write_file(&report, page::compose(&run, gallery, charts).html().as_bytes())?;
    files.push(report.clone());
    Ok(Rendered { files, report, warnings: run.warnings })
}
