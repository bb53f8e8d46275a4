//! VTK files in XML with their data at the end ("appended raw"), cut into blocks that are compressed
//! one by one: VTK file formats,
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use super::markup::escape;
use crate::base::{Error, Result};
use flate2::{Compression, write::ZlibEncoder};
use nalgebra::SVector;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::Write as _;

/// Bytes that are compressed together.
pub(super) const BLOCK: usize = 32 * 1024;

/// The attribute of an array of vectors.
pub(super) const THREE: &str = " NumberOfComponents=\"3\"";

/// Vectors with three components.
pub(super) fn padded<const D: usize>(f: &[SVector<f64, D>]) -> Vec<f64> {
    f.iter().flat_map(|v| (0..3).map(|k| if k < D { v[k] } else { 0.0 })).collect()
}

pub(super) fn bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A file in the making: the XML head and the binary data it points into.
#[derive(Default)]
pub(super) struct Document {
    head: String,
    data: Vec<u8>,
    failed: Option<std::io::Error>,
}

impl Document {
    /// A line of the head.
    pub fn line(&mut self, text: &str) {
        self.head.push_str(text);
        self.head.push('\n');
    }
    /// Opens an element.
    pub fn open(&mut self, tag: &str) {
        self.line(&format!("<{tag}>"));
    }
    /// Closes an element.
    pub fn close(&mut self, tag: &str) {
        self.line(&format!("</{tag}>"));
    }
    /// A data array: its tag in the head, and its compressed blocks behind a table of their sizes.
    pub fn array(&mut self, number: &str, name: &str, more: &str, raw: &[u8]) {
        // Writing to a String cannot fail.
        let _ = writeln!(
            self.head,
            "<DataArray type=\"{number}\" Name=\"{}\"{more} format=\"appended\" offset=\"{}\"/>",
            escape(name),
            self.data.len()
        );
        let blocks: std::io::Result<Vec<Vec<u8>>> = raw.par_chunks(BLOCK).map(compress).collect();
        match blocks {
            Err(e) => self.failed = Some(e),
            Ok(blocks) => {
                let table = [blocks.len(), BLOCK, raw.len() % BLOCK];
                let sizes = table.into_iter().chain(blocks.iter().map(Vec::len));
                self.data.extend(sizes.flat_map(|n| (n as u64).to_le_bytes()));
                blocks.iter().for_each(|b| self.data.extend_from_slice(b));
            }
        }
    }
    /// The whole file, with its first lines and those between the tags and the data.
    pub fn finish(self, head: &str, tail: &str) -> Result<Vec<u8>> {
        if let Some(e) = self.failed {
            return Err(Error::internal("cannot compress the fields").value(e));
        }
        let mut out = head.as_bytes().to_vec();
        out.extend_from_slice(self.head.as_bytes());
        out.extend_from_slice(tail.as_bytes());
        out.extend_from_slice(&self.data);
        out.extend_from_slice(b"\n</AppendedData>\n</VTKFile>\n");
        Ok(out)
    }
}

fn compress(block: &[u8]) -> std::io::Result<Vec<u8>> {
    // Level 1: a tenth of the time of level 6 for files a few per cent larger.
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(1));
    encoder.write_all(block)?;
    encoder.finish()
}
