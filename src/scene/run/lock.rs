//! The mark of a run folder, which is also its lock.

use super::contents::check_links;
use crate::base::{Error, Result};
use crate::scene::kept::{FIRST, MARK};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

/// The right to write to a run folder, which one process has at a time, until it is dropped.
#[derive(Debug)]
pub(in crate::scene) struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the lock of a folder that exists, and marks it.
    ///
    /// # Errors
    /// A file of the folder is a link, or its mark is not ours; another process has it; the file
    /// cannot be written.
    pub fn take(folder: &Path) -> Result<Lock> {
        // Before the mark is opened: it may be a link itself.
        check_links(folder)?;
        let path = folder.join(MARK);
        let failed = |e: std::io::Error| {
            Error::input(format!("the run folder cannot be locked: {e}"))
                .at(path.display().to_string())
                .remedy("choose a folder that can be written with --out")
        };
        let mut options = OpenOptions::new();
        let mut file = options.read(true).write(true).create(true).open(&path).map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {
                let mut kept = Vec::new();
                file.read_to_end(&mut kept).map_err(failed)?;
                if !kept.is_empty() && !kept.starts_with(FIRST.as_bytes()) {
                    return Err(Error::input(
                        "the folder has a file of this name that is not ours",
                    )
                    .at(path.display().to_string())
                    .remedy("move the file away, or choose another folder with --out"));
                }
            }
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                let _ = file.read_to_string(&mut text);
                let pid = text.lines().find_map(|l| l.strip_prefix("process ")).unwrap_or("?");
                return Err(Error::input("another process writes to this run folder")
                    .at(folder.display().to_string())
                    .value(format!("process {pid}"))
                    .remedy("wait for it to end, or choose another folder with --out"));
            }
            Err(TryLockError::Error(e)) => return Err(failed(e)),
        }
        let text =
            format!("{FIRST} {}\nprocess {}\n", env!("CARGO_PKG_VERSION"), std::process::id());
        // Never without a mark, wherever the process is killed: cut off only after it is written.
        file.rewind()
            .and_then(|()| file.write_all(text.as_bytes()))
            .and_then(|()| file.set_len(text.len() as u64))
            .map_err(failed)?;
        Ok(Lock { _file: file })
    }
}
