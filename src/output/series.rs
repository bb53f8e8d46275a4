//! CSV: time series that grow a row at a time, and tables written whole.
//!
//! Numbers are written with the fewest digits that read back as the same bits.

use super::file::{cannot_write, read_text, write_file};
use crate::base::{Error, Result};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A time series in the making. Its first column is `time`.
///
/// Every row is on its way to the disk when [`append`](Series::append) returns.
#[derive(Debug)]
pub struct Series {
    path: PathBuf,
    file: File,
    columns: usize,
    rows: usize,
    length: u64,
}

impl Series {
    /// A new series with the given columns after `time`; replaces a file of this name.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(path: &Path, names: &[&str]) -> Result<Series> {
        let file = File::create(path).map_err(|e| cannot_write(path, &e))?;
        let mut series = Series { path: path.into(), file, columns: names.len() + 1, rows: 0, length: 0 };
        series.write(&header(names))?;
        Ok(series)
    }
    /// Reopens a series to continue after its first `rows` rows; later rows, and one that was cut off, are dropped.
    ///
    /// # Errors
    /// The file cannot be opened, its columns are others, or it has fewer rows.
    pub fn resume(path: &Path, names: &[&str], rows: usize) -> Result<Series> {
        let text = read_text(path)?;
        let expected = header(names);
        let place = path.display().to_string();
        if !text.starts_with(&expected) {
            return Err(Error::input("the columns of the series are not those of this run")
                .at(place)
                .value(text.lines().next().unwrap_or_default())
                .remedy(
                    "resume with the scene the run was started with, or start again in another folder with --out",
                ));
        }
        let mut ends = text.match_indices('\n').map(|(i, _)| i + 1).skip(rows);
        let Some(length) = ends.next().map(|n| n as u64) else {
            return Err(Error::input("the series is shorter than the run that is to be resumed")
                .at(place)
                .value(format!("{} rows, {rows} wanted", text.matches('\n').count() - 1))
                .remedy("start the run again in another folder with --out"));
        };
        let open = || {
            let file = OpenOptions::new().append(true).open(path)?;
            file.set_len(length)?;
            Ok(file)
        };
        let file = open().map_err(|e| cannot_write(path, &e))?;
        Ok(Series { path: path.into(), file, columns: names.len() + 1, rows, length })
    }
    /// Writes one row: the time and a value for every other column.
    ///
    /// # Errors
    /// The file cannot be written (the rows before stay whole), or the number of values is wrong.
    pub fn append(&mut self, time: f64, values: &[f64]) -> Result<()> {
        if values.len() + 1 != self.columns {
            return Err(Error::internal("a row of the series has the wrong number of values")
                .at(self.path.display().to_string())
                .value(format!("{} for {} columns", values.len() + 1, self.columns)));
        }
        self.write(&row(std::iter::once(time).chain(values.iter().copied())))?;
        self.rows += 1;
        Ok(())
    }
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }
    fn write(&mut self, line: &str) -> Result<()> {
        self.file.write_all(line.as_bytes()).map_err(|e| {
            // A piece of a row would make the next one wrong; if the file cannot be cut either, resuming drops the piece.
            let _ = self.file.set_len(self.length);
            cannot_write(&self.path, &e)
        })?;
        self.length += line.len() as u64;
        Ok(())
    }
}

/// Named columns of equal length: a time series that was read, or a profile along a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names, the first column first.
    pub names: Vec<String>,
    /// One vector a column.
    pub columns: Vec<Vec<f64>>,
}

impl Table {
    /// A table of named columns.
    pub fn new(columns: &[(&str, &[f64])]) -> Table {
        Table {
            names: columns.iter().map(|c| c.0.to_string()).collect(),
            columns: columns.iter().map(|c| c.1.to_vec()).collect(),
        }
    }
    /// The column of this name.
    ///
    /// # Errors
    /// There is none; the columns that exist are listed.
    pub fn column(&self, name: &str) -> Result<&[f64]> {
        let found = self.names.iter().position(|n| n == name).and_then(|i| self.columns.get(i));
        found.map(Vec::as_slice).ok_or_else(|| {
            Error::input("the table has no column of this name")
                .value(name)
                .remedy(format!("columns in this table: {}", self.names.join(", ")))
        })
    }
    /// The row whose `time` is the [same](same_time) as `t`, if there is one.
    ///
    /// # Errors
    /// There is no column `time`.
    pub fn row_at(&self, t: f64) -> Result<Option<usize>> {
        Ok(self.column("time")?.iter().position(|&s| same_time(s, t)))
    }
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }
    /// Writes the whole table.
    ///
    /// # Errors
    /// The columns differ in length, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        if self.columns.iter().any(|c| c.len() != self.rows()) || self.columns.len() != self.names.len() {
            return Err(Error::internal("the columns of a table differ in length").at(path.display().to_string()));
        }
        let mut text = self.names.iter().map(|n| quoted(n)).collect::<Vec<_>>().join(",") + "\n";
        for i in 0..self.rows() {
            text.push_str(&row(self.columns.iter().map(|c| c[i])));
        }
        write_file(path, text.as_bytes())
    }
    /// Reads a CSV file of numbers under a line of names. Empty lines, and a last row that was cut off in
    /// writing, are ignored.
    ///
    /// # Errors
    /// The file cannot be read, a row has too few or too many entries, or an entry is not a number.
    pub fn read(path: &Path) -> Result<Table> {
        let text = read_text(path)?;
        let mut lines = text.split_inclusive('\n').enumerate();
        let names = lines.next().map(|(_, l)| split(l)).unwrap_or_default();
        let mut columns = vec![Vec::new(); names.len()];
        for (i, line) in lines {
            if line.trim().is_empty() {
                continue;
            }
            let entries = split(line);
            if entries.len() != names.len() {
                if !line.ends_with('\n') {
                    break;
                }
                return Err(wrong(path, i, format!("{} entries for {} columns", entries.len(), names.len())));
            }
            for (column, entry) in columns.iter_mut().zip(&entries) {
                column.push(entry.trim().parse().map_err(|_| wrong(path, i, format!("{entry:?} is not a number")))?);
            }
        }
        Ok(Table { names, columns })
    }
}

/// Whether two times are the same but for the rounding of sums of steps.
pub fn same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs().max(1.0)
}

fn wrong(path: &Path, line: usize, value: String) -> Error {
    Error::input("a row of the table cannot be read")
        .at(format!("{}, line {}", path.display(), line + 1))
        .value(value)
        .remedy("correct this line, or remove it")
}

fn header(names: &[&str]) -> String {
    std::iter::once("time".to_string()).chain(names.iter().map(|n| quoted(n))).collect::<Vec<_>>().join(",") + "\n"
}

fn row(values: impl Iterator<Item = f64>) -> String {
    // Debug is the shortest text that reads back the same, with an exponent where digits would be many.
    values.map(|v| format!("{v:?}")).collect::<Vec<_>>().join(",") + "\n"
}

/// A name as CSV wants it (RFC 4180); a line break, which would end the header, becomes a space.
pub(super) fn quoted(name: &str) -> String {
    let name = name.replace(['\n', '\r'], " ");
    if name.contains([',', '"']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name }
}

/// The entries of a line.
fn split(line: &str) -> Vec<String> {
    let mut entries = vec![String::new()];
    let mut inside = false;
    let mut characters = line.trim_end_matches(['\n', '\r']).chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if inside && characters.peek() == Some(&'"') => {
                characters.next();
                entries.last_mut().into_iter().for_each(|e| e.push('"'));
            }
            '"' => inside = !inside,
            ',' if !inside => entries.push(String::new()),
            c => entries.last_mut().into_iter().for_each(|e| e.push(c)),
        }
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::fs;

    const NAMES: [&str; 2] = ["membrane.area", "flux, \"left\""];

    fn fill(series: &mut Series, rows: std::ops::Range<usize>) {
        for i in rows {
            let t = i as f64 * 0.1;
            series.append(t, &[t.sin() / 3.0, 1e-300 * t]).unwrap();
        }
    }

    #[test]
    fn a_resumed_series_has_the_bytes_of_one_that_was_never_stopped() {
        let dir = tempfile::tempdir().unwrap();
        let (whole, stopped) = (dir.path().join("a.csv"), dir.path().join("b.csv"));
        fill(&mut Series::create(&whole, &NAMES).unwrap(), 0..20);
        fill(&mut Series::create(&stopped, &NAMES).unwrap(), 0..13);
        // Killed in the middle of a row, after rows that the checkpoint does not know.
        OpenOptions::new().append(true).open(&stopped).unwrap().write_all(b"1.3,0.0").unwrap();
        assert_eq!(Table::read(&stopped).unwrap().rows(), 13);
        let mut series = Series::resume(&stopped, &NAMES, 9).unwrap();
        fill(&mut series, 9..20);
        assert_eq!(series.rows(), 20);
        assert_eq!(fs::read(&whole).unwrap(), fs::read(&stopped).unwrap());
        let table = Table::read(&whole).unwrap();
        assert_eq!(table.names, ["time", NAMES[0], NAMES[1]]);
        assert_eq!(table.column("membrane.area").unwrap()[7], (7.0 * 0.1f64).sin() / 3.0);
        assert!(table.column("area").unwrap_err().advice().contains("membrane.area"));
    }

    #[test]
    fn resuming_the_wrong_series_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        fill(&mut Series::create(&path, &NAMES).unwrap(), 0..5);
        assert!(Series::resume(&path, &["pressure"], 2).unwrap_err().what().contains("columns"));
        assert!(Series::resume(&path, &NAMES, 6).unwrap_err().wrong_value().contains("5 rows"));
        assert!(Series::resume(&dir.path().join("b.csv"), &NAMES, 0).is_err());
        assert_eq!(Table::read(&path).unwrap().rows(), 5);
        assert_eq!(Series::resume(&path, &NAMES, 5).unwrap().rows(), 5);
    }

    #[test]
    fn rows_that_are_no_numbers_are_named_by_their_line() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        fs::write(&path, "x,y\n1,2\n\n3,4\n\n").unwrap();
        assert_eq!(Table::read(&path).unwrap().columns, [[1.0, 3.0], [2.0, 4.0]]);
        for text in ["x,y\n1,2\n3\n4,5\n", "x,y\n1,2\n3,four\n4,5\n"] {
            fs::write(&path, text).unwrap();
            assert!(Table::read(&path).unwrap_err().place().contains("line 3"));
        }
    }

    #[test]
    fn a_series_that_cannot_be_written_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let e = Series::create(&dir.path().join("none/a.csv"), &NAMES).unwrap_err();
        assert!(e.place().contains("a.csv") && e.advice().contains("--out"), "{e}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_with_advice() {
        let e = Series::create(Path::new("/dev/full"), &NAMES).unwrap_err();
        assert!(e.place().contains("/dev/full") && e.advice().contains("free space"), "{e}");
    }

    proptest! {
        #[test]
        fn tables_come_back_bit_by_bit(x in prop::collection::vec(any::<f64>(), 0..20), name in "[a-z,\" .]{1,8}") {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("a.csv");
            Table::new(&[("x", &x), (&name, &x)]).write(&path).unwrap();
            let back = Table::read(&path).unwrap();
            prop_assert_eq!(&back.names[1], &name);
            let same = |a: &f64, b: &f64| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
            prop_assert!(back.columns[1].len() == x.len() && back.columns[1].iter().zip(&x).all(|(a, b)| same(a, b)));
        }
    }
}
