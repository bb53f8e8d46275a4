//! Tables of texts and numbers: written for the terminal, as CSV, JSON, Markdown and HTML.

use super::csv;
use super::file::write_file;
use super::markup::{address, escape, prose};
use super::numbers::{per_cent, rounded};
use crate::base::Result;
use serde_json::{Map, Value, json};
use std::path::Path;

/// A cell of a [`Table`].
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// A file beside the page, by its path.
    File(String),
    /// A number and its notation for readers; files hold all of its digits. NaN stands for no
    /// value.
    Number(f64, Notation),
}

/// Notation of a number for readers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// At most this many significant digits.
    Digits(usize),
    /// In per cent, with at most this many significant digits.
    PerCent(usize),
}

impl Cell {
    /// A text.
    pub fn text(text: impl Into<String>) -> Cell {
        Cell::Text(text.into())
    }
    /// A file beside the page.
    pub fn file(path: impl Into<String>) -> Cell {
        Cell::File(path.into())
    }
    /// A number of which readers see `digits` significant digits.
    pub fn number(v: f64, digits: usize) -> Cell {
        Cell::Number(v, Notation::Digits(digits))
    }
    /// A number that may be missing.
    pub fn optional(v: Option<f64>, digits: usize) -> Cell {
        Cell::number(v.unwrap_or(f64::NAN), digits)
    }
    /// A fraction that is shown in per cent, and may be missing.
    pub fn per_cent(v: Option<f64>, digits: usize) -> Cell {
        Cell::Number(v.unwrap_or(f64::NAN), Notation::PerCent(digits))
    }
    /// A count that may be missing.
    pub fn count(n: Option<u64>) -> Cell {
        Cell::optional(n.map(|n| n as f64), 9)
    }
    /// The text for readers; a dash for a missing number.
    pub fn shown(&self) -> String {
        match self {
            Cell::Text(text) | Cell::File(text) => text.clone(),
            Cell::Number(v, _) if v.is_nan() => "-".into(),
            Cell::Number(v, Notation::Digits(digits)) => rounded(*v, *digits),
            Cell::Number(v, Notation::PerCent(digits)) => per_cent(*v, *digits),
        }
    }
    /// The entry of a CSV file.
    fn stored(&self) -> String {
        match self {
            Cell::Text(text) | Cell::File(text) => csv::quoted(text),
            Cell::Number(v, _) => csv::number(*v),
        }
    }
    /// The content of a cell of a page.
    pub(super) fn html(&self) -> String {
        match self {
            Cell::File(path) => format!("<a href=\"{}\">{}</a>", address(path), escape(path)),
            cell => prose(&cell.shown()),
        }
    }
    /// The number in it, if it is one.
    pub fn value(&self) -> Option<f64> {
        if let Cell::Number(v, _) = self { Some(*v) } else { None }
    }
}

impl From<&Cell> for Value {
    /// A number that is not finite is `null`.
    fn from(cell: &Cell) -> Value {
        match cell {
            Cell::Text(text) | Cell::File(text) => Value::from(text.as_str()),
            Cell::Number(v, _) => Value::from(*v),
        }
    }
}

/// A column of a [`Table`]; it is aligned to the right where all of its cells are numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Column {
    /// Heading; may be empty.
    pub heading: String,
    /// Unit of its numbers; may be empty.
    pub unit: String,
}

impl Column {
    /// Heading and unit: the name of the column in files and on the terminal.
    pub fn name(&self) -> String {
        if self.unit.is_empty() {
            self.heading.clone()
        } else {
            format!("{} {}", self.heading, self.unit)
        }
    }
}

impl<H: Into<String>> From<H> for Column {
    fn from(heading: H) -> Column {
        Column { heading: heading.into(), unit: String::new() }
    }
}

/// A table of texts and numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name of its file, without ending; empty if it has none.
    pub name: String,
    /// Title.
    pub title: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// Rows, with a cell a column.
    pub rows: Vec<Vec<Cell>>,
    /// Explanation; may be empty.
    pub caption: String,
}

impl Table {
    /// A table without rows.
    pub fn new<C: Into<Column>>(
        name: &str,
        title: &str,
        columns: impl IntoIterator<Item = C>,
    ) -> Table {
        let columns = columns.into_iter().map(Into::into).collect();
        Table { name: name.into(), title: title.into(), columns, ..Table::default() }
    }
    /// The same with a unit in the column of this heading.
    #[must_use]
    pub fn with_unit(mut self, heading: &str, unit: &str) -> Table {
        self.columns.iter_mut().filter(|c| c.heading == heading).for_each(|c| c.unit = unit.into());
        self
    }
    /// The same with a caption.
    #[must_use]
    pub fn with_caption(self, caption: impl Into<String>) -> Table {
        Table { caption: caption.into(), ..self }
    }
    /// The same with these rows.
    #[must_use]
    pub fn with_rows(self, rows: impl IntoIterator<Item = Vec<Cell>>) -> Table {
        Table { rows: rows.into_iter().collect(), ..self }
    }
    /// Number of the column of this name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name() == name)
    }
    /// True if all cells of a column are numbers.
    fn is_numeric(&self, column: usize) -> bool {
        self.rows.iter().all(|r| matches!(r.get(column), Some(Cell::Number(..))))
    }
    fn names(&self) -> Vec<String> {
        self.columns.iter().map(Column::name).collect()
    }
    fn shown(&self) -> impl Iterator<Item = Vec<String>> {
        self.rows.iter().map(|row| row.iter().map(Cell::shown).collect())
    }

    /// The table for a terminal, in aligned columns.
    pub fn text(&self) -> String {
        let (names, rows) = (self.names(), self.shown().collect::<Vec<_>>());
        let width = |i: usize| {
            let cells = rows.iter().filter_map(|r| r.get(i)).chain(names.get(i));
            cells.map(|c| c.chars().count()).max().unwrap_or(0)
        };
        let line = |cells: &[String]| {
            let padded = cells.iter().enumerate().map(|(i, c)| {
                let room = " ".repeat(width(i) - c.chars().count());
                if self.is_numeric(i) { format!("{room}{c}") } else { format!("{c}{room}") }
            });
            padded.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
        };
        let mut text = format!("{}\n{}", self.title, line(&names));
        rows.iter().for_each(|row| text += &line(row));
        if !self.caption.is_empty() {
            text += &format!("{}\n", self.caption);
        }
        text
    }

    /// Writes the table as CSV, numbers with all their digits.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let names = self.names();
        let header = csv::names(names.iter().map(String::as_str));
        let rows = self.rows.iter().map(|row| csv::line(row.iter().map(Cell::stored)));
        write_file(path, (header + &rows.collect::<String>()).as_bytes())
    }

    /// The table in Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: Vec<String>| {
            let cells: Vec<String> = cells.iter().map(|c| c.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let head = line(self.names()) + &"|---".repeat(self.columns.len()) + "|\n";
        head + &self.shown().map(line).collect::<String>()
    }

    /// A list of objects, one a row, with the names of the columns as keys.
    pub fn json(&self) -> Value {
        let names = self.names();
        let object = |row: &Vec<Cell>| {
            let entries = names.iter().cloned().zip(row.iter().map(Value::from));
            Value::Object(entries.collect::<Map<_, _>>())
        };
        self.rows.iter().map(object).collect()
    }

    /// Names of the columns, and the rows as lists of numbers with at most six digits.
    pub(super) fn numbers(&self) -> Value {
        let short = |v: f64| rounded(v, 6).parse::<f64>().map_or(Value::Null, Value::from);
        let row = |row: &Vec<Cell>| {
            row.iter().map(|c| c.value().map_or(Value::Null, short)).collect::<Value>()
        };
        let heading = |c: &Column| match c.unit.as_str() {
            "" => c.heading.clone(),
            unit => format!("{} ({unit})", c.heading),
        };
        json!({
            "columns": self.columns.iter().map(heading).collect::<Value>(),
            "rows": self.rows.iter().map(row).collect::<Value>(),
        })
    }

    /// The element `table` of HTML, without title and caption.
    pub(super) fn html(&self) -> String {
        let class = |i: usize| if self.is_numeric(i) { " class=\"number\"" } else { "" };
        let heading = |(i, c): (usize, &Column)| {
            let unit = match c.unit.as_str() {
                "" => String::new(),
                unit => format!(" <span class=\"unit\">{}</span>", escape(unit)),
            };
            format!("<th{}>{}{unit}</th>", class(i), escape(&c.heading))
        };
        let headings: String = self.columns.iter().enumerate().map(heading).collect();
        let row = |cells: &Vec<Cell>| {
            let cell = |(i, c): (usize, &Cell)| format!("<td{}>{}</td>", class(i), c.html());
            format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
        };
        let rows: String = self.rows.iter().map(row).collect();
        let head = if headings.is_empty() {
            headings
        } else {
            format!("<thead><tr>{headings}</tr></thead>\n")
        };
        format!("<div class=\"scroll\"><table>\n{head}<tbody>\n{rows}</tbody></table></div>")
    }
}

#[cfg(test)]
mod tests {
    use super::super::markup::tests::assert_well_formed;
    use super::*;

    fn table() -> Table {
        let mut table = Table::new("steps", "Steps", ["run", "error", "CPU"]).with_unit("CPU", "s");
        table.rows.push(vec![
            Cell::text("n = 30, \"a\""),
            Cell::number(0.012345678, 3),
            Cell::number(0.5, 2),
        ]);
        table.rows.push(vec![Cell::text("n = 60"), Cell::optional(None, 3), Cell::count(Some(12))]);
        table
    }

    #[test]
    fn readers_see_few_digits_and_files_hold_all() {
        let text = "Steps\n\
            run           error  CPU s\n\
            n = 30, \"a\"  0.0123    0.5\n\
            n = 60            -     12\n";
        assert_eq!(table().text(), text);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("steps.csv");
        table().write(&path).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        assert_eq!(
            text,
            "run,error,CPU s\n\"n = 30, \"\"a\"\"\",0.012345678,0.5\nn = 60,NaN,12.0\n"
        );
        let markdown = table().markdown();
        assert!(markdown.starts_with(
            "| run | error | CPU s |\n|---|---|---|\n| n = 30, \"a\" | 0.0123 | 0.5 |\n"
        ));
        let json = table().json();
        assert_eq!(
            (&json[0]["error"], &json[1]["CPU s"]),
            (&Value::from(0.012345678), &Value::from(12.0))
        );
        assert!(json[1]["error"].is_null());
    }

    #[test]
    fn numbers_are_aligned_and_units_are_set_apart_on_a_page() {
        let html = table().html();
        assert_well_formed(&html);
        for part in ["<th>run</th>", "<th class=\"number\">CPU <span class=\"unit\">s</span></th>"]
        {
            assert!(html.contains(part), "{html}");
        }
        assert!(
            html.contains("<td>n = 30, &quot;a&quot;</td><td class=\"number\">0.0123</td>"),
            "{html}"
        );
    }

    #[test]
    fn fractions_are_shown_in_per_cent() {
        let cell = Cell::per_cent(Some(0.01234), 3);
        assert_eq!((cell.shown(), cell.stored()), ("1.23 %".into(), "0.01234".into()));
        assert_eq!(Cell::per_cent(None, 3).shown(), "-");
    }
}
