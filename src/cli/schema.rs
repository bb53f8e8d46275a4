//! `immersa schema`: the scene format for editors.

use super::new;
use crate::base::Result;
use crate::scene::json_schema;
use std::io::ErrorKind;
use std::path::Path;

/// The file to which the first line of a new scene refers.
pub(super) const FILE: &str = "immersa.schema.json";

pub(super) fn schema() -> Result<()> {
    super::print(&json_schema())
}

/// Writes the schema for the scenes of a folder. A file that exists is left alone; true if it is the
/// schema of this version.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write_into(folder: &Path) -> Result<bool> {
    let (path, text) = (folder.join(FILE), json_schema());
    match new::create(&path, text.as_bytes()) {
        Err(e) if e.kind() == ErrorKind::AlreadyExists => {
            Ok(std::fs::read(&path).is_ok_and(|there| there == text.as_bytes()))
        }
        done => done.map(|()| true).map_err(|e| new::failed(&path, &e)),
    }
}
