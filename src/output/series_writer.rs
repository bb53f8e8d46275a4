//! CSV files of time series that grow a row at a time, and go on where an interrupted run stopped.

use super::csv;
use super::file::{cannot_write, read_text};
use crate::base::{Error, Result};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file of a time series that grows a row at a time. Its first column is `time`.
///
/// Every row has been handed to the operating system when [`append`](SeriesWriter::append) returns.
#[derive(Debug)]
pub struct SeriesWriter {
    path: PathBuf,
    file: File,
    columns: usize,
    rows: usize,
    length: u64,
}

impl SeriesWriter {
    /// A new series with the given columns after `time`; replaces a file of this name.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn create(path: &Path, names: &[&str]) -> Result<SeriesWriter> {
        let file = File::create(path).map_err(|e| cannot_write(path, &e))?;
        let mut series =
            SeriesWriter { path: path.into(), file, columns: names.len() + 1, rows: 0, length: 0 };
        series.write(&header(names))?;
        Ok(series)
    }
    /// Reopens a series to continue after its first `rows` rows; later rows, and one that was cut
    /// off, are dropped.
    ///
    /// # Errors
    /// The file cannot be opened, its columns are others, or it has fewer rows.
    pub fn resume(path: &Path, names: &[&str], rows: usize) -> Result<SeriesWriter> {
        let text = read_text(path)?;
        let expected = header(names);
        let place = path.display().to_string();
        if !text.starts_with(&expected) {
            return Err(Error::input("the columns of the series are not those of this run")
                .at(place)
                .value(text.lines().next().unwrap_or_default())
                .remedy(
                    "resume with the scene the run was started with, or start again in another \
                     folder with --out",
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
        Ok(SeriesWriter { path: path.into(), file, columns: names.len() + 1, rows, length })
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
        self.write(&csv::numbers(std::iter::once(time).chain(values.iter().copied())))?;
        self.rows += 1;
        Ok(())
    }
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }
    fn write(&mut self, line: &str) -> Result<()> {
        self.file.write_all(line.as_bytes()).map_err(|e| {
            // A piece of a row would make the next one wrong; if the file cannot be cut either,
            // resuming drops the piece.
            let _ = self.file.set_len(self.length);
            cannot_write(&self.path, &e)
        })?;
        self.length += line.len() as u64;
        Ok(())
    }
}

fn header(names: &[&str]) -> String {
    csv::names(std::iter::once("time").chain(names.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::super::Series;
    use super::*;
    use std::fs;

    const NAMES: [&str; 2] = ["membrane.area", "flux, \"left\""];

    fn fill(series: &mut SeriesWriter, rows: std::ops::Range<usize>) {
        for i in rows {
            let t = i as f64 * 0.1;
            series.append(t, &[t.sin() / 3.0, 1e-300 * t]).unwrap();
        }
    }

    #[test]
    fn a_resumed_series_has_the_bytes_of_one_that_was_never_stopped() {
        let dir = tempfile::tempdir().unwrap();
        let (whole, stopped) = (dir.path().join("a.csv"), dir.path().join("b.csv"));
        fill(&mut SeriesWriter::create(&whole, &NAMES).unwrap(), 0..20);
        fill(&mut SeriesWriter::create(&stopped, &NAMES).unwrap(), 0..13);
        // Killed in the middle of a row, after rows that the checkpoint does not know.
        OpenOptions::new().append(true).open(&stopped).unwrap().write_all(b"1.3,0.0").unwrap();
        assert_eq!(Series::read(&stopped).unwrap().rows(), 13);
        let mut series = SeriesWriter::resume(&stopped, &NAMES, 9).unwrap();
        fill(&mut series, 9..20);
        assert_eq!(series.rows(), 20);
        assert_eq!(fs::read(&whole).unwrap(), fs::read(&stopped).unwrap());
        let table = Series::read(&whole).unwrap();
        assert_eq!(table.names, ["time", NAMES[0], NAMES[1]]);
        assert_eq!(table.column("membrane.area").unwrap()[7], (7.0 * 0.1f64).sin() / 3.0);
        assert!(table.column("area").unwrap_err().advice().contains("membrane.area"));
    }

    #[test]
    fn resuming_the_wrong_series_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        fill(&mut SeriesWriter::create(&path, &NAMES).unwrap(), 0..5);
        assert!(
            SeriesWriter::resume(&path, &["pressure"], 2).unwrap_err().what().contains("columns")
        );
        assert!(
            SeriesWriter::resume(&path, &NAMES, 6).unwrap_err().wrong_value().contains("5 rows")
        );
        assert!(SeriesWriter::resume(&dir.path().join("b.csv"), &NAMES, 0).is_err());
        assert_eq!(Series::read(&path).unwrap().rows(), 5);
        assert_eq!(SeriesWriter::resume(&path, &NAMES, 5).unwrap().rows(), 5);
    }

    #[test]
    fn a_series_that_cannot_be_written_says_so() {
        let dir = tempfile::tempdir().unwrap();
        let e = SeriesWriter::create(&dir.path().join("none/a.csv"), &NAMES).unwrap_err();
        assert!(e.place().contains("a.csv") && e.advice().contains("--out"), "{e}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_an_error_with_advice() {
        let e = SeriesWriter::create(Path::new("/dev/full"), &NAMES).unwrap_err();
        assert!(e.place().contains("/dev/full") && e.advice().contains("free space"), "{e}");
    }
}
