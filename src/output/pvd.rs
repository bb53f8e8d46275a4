//! PVD: the list of VTU files of a run with their times, opened by ParaView as one animation.

use super::file::{read_text, write_file};
use super::markup::{attribute, escape};
use crate::base::{Error, Result};
use std::fmt::Write;
use std::path::Path;

/// Writes the whole list of `(time, file)`; files are named relative to the folder of `path`.
///
/// # Errors
/// The file cannot be written.
pub fn write_pvd(path: &Path, entries: &[(f64, String)]) -> Result<()> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n",
    );
    for (time, file) in entries {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "<DataSet timestep=\"{time:?}\" file=\"{}\"/>", escape(file));
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    write_file(path, text.as_bytes())
}

/// The `(time, file)` entries of a list, in the order of the file.
///
/// # Errors
/// The file cannot be read, or an entry has no time or no file.
pub fn read_pvd(path: &Path) -> Result<Vec<(f64, String)>> {
    let text = read_text(path)?;
    let broken = |what: &str| {
        Error::input(what).at(path.display().to_string()).remedy("run the scene again")
    };
    if !text.contains("type=\"Collection\"") {
        return Err(broken("this is not a PVD file"));
    }
    text.split("<DataSet")
        .skip(1)
        .map(|entry| {
            let tag = entry.split('>').next().unwrap_or_default();
            let time = attribute(tag, "timestep").and_then(|t| t.parse().ok());
            time.zip(attribute(tag, "file"))
                .ok_or_else(|| broken("an entry of the list has no time or no file").value(tag))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_comes_back_as_it_was_written() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("fields.pvd");
        let entries = vec![
            (0.0, "fields/a.vtu".to_string()),
            (0.1 + 0.2, "R&D \"b\".vtu".to_string()),
            (1e-9, "c".into()),
        ];
        write_pvd(&path, &entries).unwrap();
        assert_eq!(read_pvd(&path).unwrap(), entries);
    }

    #[test]
    fn other_files_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.pvd");
        for text in
            ["hello", "<VTKFile type=\"Collection\"><DataSet timestep=\"soon\" file=\"a\"/>"]
        {
            std::fs::write(&path, text).unwrap();
            assert!(read_pvd(&path).unwrap_err().place().contains("a.pvd"));
        }
    }
}
