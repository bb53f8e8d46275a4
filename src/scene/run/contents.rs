//! The files of a run folder: which are the program's, links among them, and removing them.

use crate::base::{Error, Result};
use crate::output::OF_CHART;
use crate::scene::kept::{CHECKPOINTS, MARK};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Files of a run folder.
const FILES: [&str; 16] = [
    "scene.toml",
    "series.csv",
    "summary.json",
    "log.txt",
    "fields.pvd",
    "fields.vtkhdf",
    "interfaces.pvd",
    "boundaries.vtp",
    "start.vtu",
    "report.html",
    "film.gif",
    "film.mp4",
    "contours.csv",
    "segmented.png",
    "mask.png",
    MARK,
];
/// True for a file that the program writes.
type IsOwn = fn(&Path) -> bool;

/// Folders of a run folder, and which of the files in them the program writes.
const FOLDERS: [(&str, IsOwn); 5] = [
    ("fields", |path| is_numbered(path, &["vtu", "vtp"])),
    ("checkpoint", |path| CHECKPOINTS.iter().any(|name| path.ends_with(name))),
    ("profiles", |path| begins(path, "csv", b"distance,x")),
    ("pictures", |path| is_numbered(path, &["png"])),
    ("charts", |path| begins(path, "svg", OF_CHART.as_bytes())),
];

/// True for the number of a step with one of these endings.
fn is_numbered(path: &Path, endings: &[&str]) -> bool {
    let stem = path.file_stem().unwrap_or_default().as_encoded_bytes();
    stem.len() >= 6
        && stem.iter().all(u8::is_ascii_digit)
        && path.extension().is_some_and(|e| endings.iter().any(|known| e == *known))
}

/// True for a file with this ending that begins with these bytes, as those of the program do.
fn begins(path: &Path, ending: &str, with: &[u8]) -> bool {
    let mut first = vec![0; with.len()];
    path.extension().is_some_and(|e| e == ending)
        && fs::File::open(path).and_then(|mut f| f.read_exact(&mut first)).is_ok()
        && first == with
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let read = fs::read_dir(folder).into_iter().flatten();
    read.filter_map(|entry| Some(entry.ok()?.path())).collect()
}

/// True if nothing but the mark is in a folder, or it does not exist.
pub(super) fn is_empty(folder: &Path) -> bool {
    entries(folder).iter().all(|path| path.ends_with(MARK))
}

/// Refuses links among the files of a run, through which a program would write elsewhere.
///
/// # Errors
/// The first link.
pub(super) fn check_links(folder: &Path) -> Result<()> {
    let files = FILES.iter().map(|name| folder.join(name));
    let folders = FOLDERS.iter().map(|(name, _)| folder.join(name));
    let inside = folders.clone().filter(|path| !path.is_symlink()).flat_map(|path| entries(&path));
    match files.chain(folders).chain(inside).find(|path| path.is_symlink()) {
        None => Ok(()),
        Some(link) => Err(Error::input("a file of the run folder is a link to another place")
            .at(link.display().to_string())
            .value(fs::read_link(&link).map_or("?".into(), |to| to.display().to_string()))
            .remedy("remove the link, or choose another folder with --out")),
    }
}

/// Removes what the program wrote to a run folder, except the mark, and nothing else.
///
/// # Errors
/// A file that cannot be removed.
pub(super) fn clear(folder: &Path) -> Result<()> {
    let own = |(name, is_own): &(&str, IsOwn)| {
        let inside = entries(&folder.join(name)).into_iter();
        inside.filter(|path| is_own(path)).collect::<Vec<_>>()
    };
    let files = FILES.iter().filter(|name| **name != MARK).map(|name| folder.join(name));
    for path in
        files.chain(FOLDERS.iter().flat_map(own)).filter(|path| path.is_file() || path.is_symlink())
    {
        fs::remove_file(&path).map_err(|e| {
            Error::input(format!("a file of the earlier run cannot be removed: {e}"))
                .at(path.display().to_string())
                .remedy("check the permissions of the run folder, or give another with --out")
        })?;
    }
    Ok(())
}
