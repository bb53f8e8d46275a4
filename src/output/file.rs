//! Writing and reading whole files, with errors that say what the user can do.

use crate::base::{Error, Result, read_plain};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Replaces the file at `path` by `bytes`: they are written beside it and renamed, so that a stop
/// at any moment leaves the old or the new file.
///
/// # Errors
/// The folder does not exist or may not be written to, or the disk is full; the remedy says which.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, bytes, |_| Ok(()))
}

/// As [`write_file`], and the content is on the disk when this returns: it outlives a power cut.
///
/// # Errors
/// As [`write_file`].
pub fn write_durably(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, bytes, File::sync_all)?;
    // The name is in the folder; not every system can open one.
    if let Some(Ok(folder)) = path.parent().map(File::open) {
        let _ = folder.sync_all();
    }
    Ok(())
}

fn replace(path: &Path, bytes: &[u8], then: impl Fn(&File) -> io::Result<()>) -> Result<()> {
    let beside = temporary(path);
    // What another run left, or a link to elsewhere.
    let _ = fs::remove_file(&beside);
    let write = || {
        let mut file = File::create_new(&beside)?;
        file.write_all(bytes)?;
        then(&file)?;
        fs::rename(&beside, path)
    };
    write().map_err(|e| {
        // Nothing more can be done for the user if the half-written file cannot be removed either.
        let _ = fs::remove_file(&beside);
        cannot_write(path, &e)
    })
}

/// Path of the file that holds the new content until it is complete.
fn temporary(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    path.with_file_name(name)
}

/// The error for a file that cannot be written.
pub fn cannot_write(path: &Path, e: &io::Error) -> Error {
    let remedy = match e.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "free space on this disk, or choose a folder on another one with --out"
        }
        _ => "choose a folder that exists and may be written to with --out",
    };
    Error::input("cannot write a file").at(path.display().to_string()).value(e).remedy(remedy)
}

/// The content of a file.
///
/// # Errors
/// The file cannot be read.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    read_plain(path).map_err(|e| {
        Error::input("cannot read a file")
            .at(path.display().to_string())
            .value(e)
            .remedy("check the name and whether you may read it")
    })
}

/// The content of a text file.
///
/// # Errors
/// The file cannot be read, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read(path)?).map_err(|e| {
        Error::input("a text file is not valid UTF-8")
            .at(path.display().to_string())
            .value(e.utf8_error())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Kind;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_is_left_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write_file(&path, b"old and long").unwrap();
        write_file(&path, b"new").unwrap();
        assert_eq!(read_text(&path).unwrap(), "new");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_that_cannot_be_written_to_names_path_and_remedy() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("file"), "").unwrap();
        for bad in ["missing/a.txt", "file/a.txt", ""] {
            let e = write_file(&dir.path().join(bad), b"x").unwrap_err();
            assert_eq!(e.kind(), Kind::Input);
            assert!(e.place().contains(bad) && e.advice().contains("--out"), "{e}");
        }
    }

    #[test]
    fn a_full_disk_advises_to_free_space() {
        let e = cannot_write(Path::new("out/a.vtu"), &ErrorKind::StorageFull.into());
        assert!(e.advice().contains("free space"), "{e}");
    }
}
