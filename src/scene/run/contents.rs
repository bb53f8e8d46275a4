//! The files of a run folder: which are the program's, links among them, and removing them.

use crate::base::{Error, Result};
use crate::scene::kept::MARK;
use std::fs;
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
/// Folders of a run folder, with the endings of the files in them.
const FOLDERS: [(&str, &[&str]); 5] = [
    ("fields", &["vtu", "vtp"]),
    ("checkpoint", &["bin"]),
    ("profiles", &["csv"]),
    ("pictures", &["png"]),
    ("charts", &["svg"]),
];

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
pub(in crate::scene) fn check_links(folder: &Path) -> Result<()> {
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
    let own = |(name, endings): &(&str, &[&str])| {
        let of_run = |path: &PathBuf| {
            path.extension().is_some_and(|e| endings.iter().any(|known| e == *known))
        };
        let inside = entries(&folder.join(name));
        inside.into_iter().filter(of_run).collect::<Vec<_>>()
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
