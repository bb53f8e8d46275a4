//! Numbers in named columns: a time series or a profile, read from a CSV file or written to one.

use super::csv;
use super::file::{read_text, write_file};
use crate::base::{Error, Result};
use std::path::Path;

/// Named columns of equal length: a time series that was read, or a profile along a line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Names, the first column first.
    pub names: Vec<String>,
    /// One vector a column.
    pub columns: Vec<Vec<f64>>,
}

impl Series {
    /// Named columns.
    pub fn new(columns: &[(&str, &[f64])]) -> Series {
        Series {
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
    /// Writes the file.
    ///
    /// # Errors
    /// The columns differ in length, or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        if self.columns.iter().any(|c| c.len() != self.rows())
            || self.columns.len() != self.names.len()
        {
            return Err(Error::internal("the columns of a table differ in length")
                .at(path.display().to_string()));
        }
        let mut text = csv::names(self.names.iter().map(String::as_str));
        for i in 0..self.rows() {
            text.push_str(&csv::numbers(self.columns.iter().map(|c| c[i])));
        }
        write_file(path, text.as_bytes())
    }
    /// Reads a CSV file of numbers under a line of names. Empty lines, and a last row that was cut
    /// off in writing, are ignored.
    ///
    /// # Errors
    /// The file cannot be read, a row has too few or too many entries, or an entry is not a number.
    pub fn read(path: &Path) -> Result<Series> {
        let text = read_text(path)?;
        let mut lines = text.split_inclusive('\n').enumerate();
        let names = lines.next().map(|(_, l)| csv::entries(l)).unwrap_or_default();
        let mut columns = vec![Vec::new(); names.len()];
        for (i, line) in lines {
            if line.trim().is_empty() {
                continue;
            }
            let entries = csv::entries(line);
            if entries.len() != names.len() {
                if !line.ends_with('\n') {
                    break;
                }
                return Err(wrong(
                    path,
                    i,
                    format!("{} entries for {} columns", entries.len(), names.len()),
                ));
            }
            for (column, entry) in columns.iter_mut().zip(&entries) {
                column.push(
                    entry
                        .trim()
                        .parse()
                        .map_err(|_| wrong(path, i, format!("{entry:?} is not a number")))?,
                );
            }
        }
        Ok(Series { names, columns })
    }
}

/// True for two times that differ by no more than the rounding of sums of steps.
pub fn same_time(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs().max(1.0)
}

fn wrong(path: &Path, line: usize, value: String) -> Error {
    Error::input("a row of the table cannot be read")
        .at(format!("{}, line {}", path.display(), line + 1))
        .value(value)
        .remedy("correct this line, or remove it")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::fs;

    #[test]
    fn rows_that_are_no_numbers_are_named_by_their_line() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        fs::write(&path, "x,y\n1,2\n\n3,4\n\n").unwrap();
        assert_eq!(Series::read(&path).unwrap().columns, [[1.0, 3.0], [2.0, 4.0]]);
        for text in ["x,y\n1,2\n3\n4,5\n", "x,y\n1,2\n3,four\n4,5\n"] {
            fs::write(&path, text).unwrap();
            assert!(Series::read(&path).unwrap_err().place().contains("line 3"));
        }
    }

    proptest! {
        #[test]
        fn tables_come_back_bit_by_bit(x in prop::collection::vec(any::<f64>(), 0..20), name in "[a-z,\" .]{1,8}") {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("a.csv");
            Series::new(&[("x", &x), (&name, &x)]).write(&path).unwrap();
            let back = Series::read(&path).unwrap();
            prop_assert_eq!(&back.names[1], &name);
            let same = |a: &f64, b: &f64| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
            prop_assert!(back.columns[1].len() == x.len() && back.columns[1].iter().zip(&x).all(|(a, b)| same(a, b)));
        }
    }
}
