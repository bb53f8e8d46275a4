//! What a study found, and the files and pages made of it.

use crate::base::{Error, Result};
use crate::output::{Content, Figure, Grid, Number, Report, Section, write_file};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A chart that is ready.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Drawing {
    /// Name of its file, without ending.
    pub name: String,
    /// Title.
    pub title: String,
    /// The drawing, by [`Chart::svg`](crate::output::Chart::svg).
    pub svg: String,
    /// What it says.
    pub caption: String,
}

/// What a study found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Title of the page.
    pub title: String,
    /// One line under it.
    pub subtitle: String,
    /// What the reader must know before believing the rest.
    pub alarms: Vec<String>,
    /// What the study says, in sentences.
    pub statements: Vec<String>,
    /// Runs that failed, what was left out, how errors were taken.
    pub notes: Vec<String>,
    /// The numbers that matter.
    pub headline: Vec<Number>,
    /// The tables.
    pub grids: Vec<Grid>,
    /// Tables that only files hold: every run of a search.
    pub details: Vec<Grid>,
    /// The charts.
    pub drawings: Vec<Drawing>,
    /// The command that makes the study again.
    pub command: String,
}

impl Findings {
    /// What a terminal shows.
    pub fn text(&self) -> String {
        let mut parts: Vec<String> = self.grids.iter().map(Grid::text).collect();
        parts.push(self.notes.iter().map(|n| format!("note: {n}\n")).collect());
        parts.push(self.statements.iter().map(|s| format!("{s}\n")).collect());
        parts.retain(|p| !p.is_empty());
        parts.join("\n")
    }
    /// What other programs read: title, statements, notes, alarms, and the tables by name.
    pub fn json(&self) -> Value {
        let tables: serde_json::Map<String, Value> = self.files().map(|g| (g.name.clone(), g.json())).collect();
        json!({
            "title": self.title,
            "version": env!("CARGO_PKG_VERSION"),
            "command": self.command,
            "alarms": self.alarms,
            "statements": self.statements,
            "notes": self.notes,
            "tables": tables,
        })
    }
    /// Writes `study.json`, `NAME.csv` and `NAME.md` a table, `charts/NAME.svg` a chart and `report.html` into the folder, replacing those that
    /// are there, and gives the path of the report.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<PathBuf> {
        let charts = folder.join("charts");
        std::fs::create_dir_all(&charts).map_err(|e| {
            Error::input(format!("the folder of the study cannot be made: {e}"))
                .at(charts.display().to_string())
                .remedy("choose a folder that can be written with --out")
        })?;
        for grid in self.files() {
            grid.write(&folder.join(format!("{}.csv", grid.name)))?;
            write_file(&folder.join(format!("{}.md", grid.name)), grid.markdown().as_bytes())?;
        }
        for drawing in &self.drawings {
            write_file(&charts.join(format!("{}.svg", drawing.name)), drawing.svg.as_bytes())?;
        }
        let json = serde_json::to_string_pretty(&self.json())
            .map_err(|e| Error::internal(format!("the findings cannot be written: {e}")))?;
        write_file(&folder.join("study.json"), json.as_bytes())?;
        let page = folder.join("report.html");
        write_file(&page, self.page().html().as_bytes())?;
        Ok(page)
    }
    /// The tables that files hold.
    fn files(&self) -> impl Iterator<Item = &Grid> {
        self.grids.iter().chain(&self.details)
    }
    fn page(&self) -> Report {
        let figure = |d: &Drawing| Figure {
            title: d.title.clone(),
            content: Content::Svg(d.svg.clone()),
            caption: d.caption.clone(),
        };
        let mut sections = Vec::new();
        sections.push(Section::Text("What was found".into(), self.statements.join("\n")));
        sections.extend(self.grids.iter().map(|g| Section::Table(g.listing())));
        sections.push(Section::Text("The command".into(), self.command.clone()));
        Report {
            title: self.title.clone(),
            subtitle: self.subtitle.clone(),
            alarms: self.alarms.clone(),
            notes: self.notes.clone(),
            headline: self.headline.clone(),
            charts: self.drawings.iter().map(figure).collect(),
            sections,
            footer: format!(
                "Made by immersa {}. The tables are beside this page as CSV, all of it in study.json, every run in runs/ with a \
                 report of its own to be had by `immersa render`.",
                env!("CARGO_PKG_VERSION")
            ),
            ..Report::default()
        }
    }
}
