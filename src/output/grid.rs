//! Tables of texts and numbers: for the terminal, as CSV, as JSON, on a page.

use super::file::write_file;
use super::numbers::rounded;
use super::report::Listing;
use super::series::quoted;
use crate::base::Result;
use serde_json::{Map, Value};
use std::path::Path;

/// A cell of a [`Grid`].
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// A number, and the digits of it that people are shown; files hold all of them. NaN stands for no value.
    Number(f64, usize),
}

impl Cell {
    /// A text.
    pub fn text(text: impl Into<String>) -> Cell {
        Cell::Text(text.into())
    }
    /// As people are shown it; a number that is NaN as a dash.
    pub fn shown(&self) -> String {
        match self {
            Cell::Text(text) => text.clone(),
            Cell::Number(v, _) if v.is_nan() => "-".into(),
            Cell::Number(v, digits) => rounded(*v, *digits),
        }
    }
    /// As files hold it.
    fn stored(&self) -> String {
        match self {
            Cell::Text(text) => quoted(text),
            Cell::Number(v, _) => format!("{v:?}"),
        }
    }
    /// The number in it, if it is one.
    pub fn number(&self) -> Option<f64> {
        if let Cell::Number(v, _) = self { Some(*v) } else { None }
    }
}

impl From<&Cell> for Value {
    /// A number that is not finite is `null`.
    fn from(cell: &Cell) -> Value {
        match cell {
            Cell::Text(text) => Value::from(text.as_str()),
            Cell::Number(v, _) => Value::from(*v),
        }
    }
}

/// A table of texts and numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Name of its file, without ending.
    pub name: String,
    /// Title.
    pub title: String,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Rows, with a cell a column.
    pub rows: Vec<Vec<Cell>>,
    /// What it says; may be empty.
    pub caption: String,
}

impl Grid {
    /// A grid without rows.
    pub fn new<H: Into<String>>(name: &str, title: &str, header: impl IntoIterator<Item = H>) -> Grid {
        let header = header.into_iter().map(Into::into).collect();
        Grid { name: name.into(), title: title.into(), header, ..Grid::default() }
    }
    /// The table for a terminal: aligned columns, numbers to the right.
    pub fn text(&self) -> String {
        let shown: Vec<Vec<String>> = self.rows.iter().map(|r| r.iter().map(Cell::shown).collect()).collect();
        let width = |i: usize| {
            let cells = shown.iter().filter_map(|r| r.get(i)).chain(self.header.get(i));
            cells.map(|c| c.chars().count()).max().unwrap_or(0)
        };
        let numbers = |i: usize| self.rows.iter().all(|r| matches!(r.get(i), Some(Cell::Number(..))));
        let line = |cells: &[String]| {
            let padded = cells.iter().enumerate().map(|(i, c)| {
                let room = " ".repeat(width(i) - c.chars().count());
                if numbers(i) { format!("{room}{c}") } else { format!("{c}{room}") }
            });
            padded.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
        };
        let mut text = format!("{}\n{}", self.title, line(&self.header));
        shown.iter().for_each(|row| text += &line(row));
        if !self.caption.is_empty() {
            text += &format!("{}\n", self.caption);
        }
        text
    }
    /// Writes the table as CSV (RFC 4180), numbers with all their digits.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let header = self.header.iter().map(|h| quoted(h)).collect::<Vec<_>>().join(",");
        let rows = self.rows.iter().map(|r| r.iter().map(Cell::stored).collect::<Vec<_>>().join(","));
        let text: String = std::iter::once(header).chain(rows).map(|line| line + "\n").collect();
        write_file(path, text.as_bytes())
    }
    /// The table for a page in Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<String>| {
            let cells: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let mut text = line(self.header.clone()) + &"|---".repeat(self.header.len()) + "|\n";
        self.rows.iter().for_each(|row| text += &line(row.iter().map(Cell::shown).collect()));
        text
    }
    /// A list of objects, one a row, with the names of the columns as keys.
    pub fn json(&self) -> Value {
        let object = |row: &Vec<Cell>| {
            let entries = self.header.iter().cloned().zip(row.iter().map(Value::from));
            Value::Object(entries.collect::<Map<_, _>>())
        };
        self.rows.iter().map(object).collect()
    }
    /// The table for a page.
    pub fn listing(&self) -> Listing {
        Listing {
            title: self.title.clone(),
            header: self.header.clone(),
            rows: self.rows.iter().map(|r| r.iter().map(Cell::shown).collect()).collect(),
            caption: self.caption.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        let mut grid = Grid::new("steps", "Steps", ["run", "error"]);
        grid.rows.push(vec![Cell::text("n = 30, \"a\""), Cell::Number(0.012345678, 3)]);
        grid.rows.push(vec![Cell::text("n = 60"), Cell::Number(f64::NAN, 3)]);
        grid
    }

    #[test]
    fn people_see_few_digits_and_files_hold_all() {
        assert_eq!(grid().text(), "Steps\nrun           error\nn = 30, \"a\"  0.0123\nn = 60            -\n");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("steps.csv");
        grid().write(&path).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert_eq!(text, "run,error\n\"n = 30, \"\"a\"\"\",0.012345678\nn = 60,NaN\n");
        assert_eq!(grid().markdown(), "| run | error |\n|---|---|\n| n = 30, \"a\" | 0.0123 |\n| n = 60 | - |\n");
        let json = grid().json();
        assert_eq!(json[0]["error"], 0.012345678);
        assert!(json[1]["error"].is_null());
    }
}
