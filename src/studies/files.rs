//! The files of a study: its page, its charts, and its tables as CSV, Markdown and JSON.

use crate::base::{Error, Result};
use crate::output::{Figure, Page, Table, write_file};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Content of `study.json`: title, statements, notes, alarms, and the tables by name; `command`
/// makes the study again.
pub fn json(page: &Page, command: &str) -> Value {
    let tables: serde_json::Map<String, Value> =
        page.all_tables().map(|t| (t.name.clone(), t.json())).collect();
    json!({
        "title": page.title,
        "version": env!("CARGO_PKG_VERSION"),
        "command": command,
        "alarms": page.alarms,
        "statements": page.statements,
        "notes": page.notes,
        "tables": tables,
    })
}

/// Writes `study.json`, `NAME.csv` and `NAME.md` for each table, `charts/NAME.svg` for each chart
/// and `report.html` into the folder of a study, replacing those that are there; the result is the
/// path of the report.
///
/// # Errors
/// A file that cannot be written.
pub fn write(page: &Page, folder: &Path, command: &str) -> Result<PathBuf> {
    let charts = folder.join("charts");
    std::fs::create_dir_all(&charts).map_err(|e| {
        Error::input(format!("the folder of the study cannot be made: {e}"))
            .at(charts.display().to_string())
            .remedy("choose a folder that can be written with --out")
    })?;
    page.all_tables().try_for_each(|t| write_table(t, folder))?;
    for (name, bytes) in page.charts.iter().filter_map(Figure::file) {
        write_file(&charts.join(name), bytes)?;
    }
    let json = serde_json::to_string_pretty(&json(page, command))
        .map_err(|e| Error::internal(format!("the results cannot be written: {e}")))?;
    write_file(&folder.join("study.json"), json.as_bytes())?;
    let report = folder.join("report.html");
    write_file(&report, with_origin(page, command).html().as_bytes())?;
    Ok(report)
}

fn write_table(table: &Table, folder: &Path) -> Result<()> {
    table.write(&folder.join(format!("{}.csv", table.name)))?;
    write_file(&folder.join(format!("{}.md", table.name)), table.markdown().as_bytes())
}

/// The page with the command that made it and a description of the files beside it.
fn with_origin(page: &Page, command: &str) -> Page {
    let mut page = page.clone();
    page.texts.push(("The command".into(), command.into()));
    page.footer = format!(
        "Made by immersa {}. The tables are beside this page as CSV, all of it in study.json, \
         every run in runs/ with a report of its own to be had by `immersa render`.",
        env!("CARGO_PKG_VERSION")
    );
    page
}
