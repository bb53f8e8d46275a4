//! `immersa new`: a commented scene to start from.

use super::cases::{CASES, Case};
use crate::base::{Error, Result};
use crate::scene::json_schema;
use clap::builder::{PossibleValue, PossibleValuesParser};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// The case; without it, all are listed
    #[arg(value_parser = PossibleValuesParser::new(
        CASES.iter().map(|c| PossibleValue::new(c.name).help(c.about))
    ))]
    case: Option<String>,
    /// The file to write; CASE.toml without it. A file that exists is left alone
    #[arg(long, value_name = "FILE", requires = "case")]
    out: Option<PathBuf>,
}

/// The file to which the first line of every case refers.
const SCHEMA: &str = "immersa.schema.json";

pub(super) fn new(arguments: &Arguments) -> Result<()> {
    let named = |name: &String| CASES.iter().find(|c| c.name == name);
    match arguments.case.as_ref().and_then(named) {
        None => super::print(&list()),
        Some(case) => write(case, arguments.out.clone()),
    }
}

/// All cases with a line each.
fn list() -> String {
    let line = |c: &Case| format!("  {:<11} {}\n", c.name, c.about);
    let lines: String = CASES.iter().map(line).collect();
    format!("Cases for `immersa new CASE`, each a commented scene to start from:\n\n{lines}")
}

/// Writes a case, its files and the schema of scenes, and says what to do next.
fn write(case: &Case, out: Option<PathBuf>) -> Result<()> {
    let path = out.unwrap_or_else(|| PathBuf::from(format!("{}.toml", case.name)));
    let folder = path.parent().unwrap_or(Path::new(""));
    let files = case.files.iter().map(|(name, content)| (folder.join(name), *content));
    let scene = (path.clone(), case.scene.as_bytes());
    let all = std::iter::once(scene).chain(files.clone());
    if let Some((there, _)) = all.clone().find(|(path, _)| path.exists()) {
        return Err(failed(&there, &ErrorKind::AlreadyExists.into()));
    }
    for (path, content) in all {
        create(&path, content).map_err(|e| failed(&path, &e))?;
    }
    let known = write_schema(folder)?;
    let mut said = next(case, &path, folder);
    if !known {
        said += &format!(
            "{} is of another version and left alone; write it anew with: immersa schema > {0}\n",
            folder.join(SCHEMA).display()
        );
    }
    super::print(&said)
}

/// Writes the schema for the scenes of a folder. A file that exists is left alone; true if it is the
/// schema of this version.
fn write_schema(folder: &Path) -> Result<bool> {
    let (path, text) = (folder.join(SCHEMA), json_schema());
    match create(&path, text.as_bytes()) {
        Err(e) if e.kind() == ErrorKind::AlreadyExists => {
            Ok(std::fs::read(&path).is_ok_and(|there| there == text.as_bytes()))
        }
        done => done.map(|()| true).map_err(|e| failed(&path, &e)),
    }
}

/// What was written, and what to do next.
fn next(case: &Case, path: &Path, folder: &Path) -> String {
    let (path, mut before) = (path.display(), case.before.to_string());
    let mut said = format!("{path} is written");
    for (name, _) in case.files {
        let file = folder.join(name).display().to_string();
        said += &format!(", and {file} beside it");
        before = before.replace(name, &file);
    }
    if !before.is_empty() {
        said += &format!("\nmake its mesh: {before}");
    }
    said + &format!("\ncompute it: immersa run {path}\n")
}

/// Writes a file that must not exist.
fn create(path: &Path, content: &[u8]) -> std::io::Result<()> {
    std::fs::File::create_new(path)?.write_all(content)
}

/// The error for a file that cannot be written.
fn failed(path: &Path, e: &std::io::Error) -> Error {
    Error::input(format!("the file cannot be written: {e}"))
        .at(path.display().to_string())
        .value(path.display())
        .remedy("name a file in another folder with --out; one that exists is never overwritten")
}
