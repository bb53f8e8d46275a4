//! VTU: fields on a mesh for ParaView, VisIt and meshio.
//!
//! Binary data stand at the end of the file ("appended raw"), cut into blocks that are compressed
//! one by one: VTK file formats,
//! <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>. P2 fields are written
//! as quadratic cells, so nothing is lost.

use super::field::{FieldData, on_nodes};
use super::file::write_file;
use super::markup::escape;
use crate::base::{Error, Result};
use crate::fem::{Element, Space};
use flate2::{Compression, write::ZlibEncoder};
use nalgebra::SVector;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

/// Bytes that are compressed together.
pub(super) const BLOCK: usize = 32 * 1024;

/// The type number that VTK gives to a cell of `element` in dimension `d`.
pub(super) fn cell_type(element: Element, d: usize) -> u8 {
    match (element, d) {
        (Element::P1 | Element::P1P0, 2) => 5,
        (Element::P1 | Element::P1P0, _) => 10,
        (Element::P2, 2) => 22,
        (Element::P2, _) => 24,
    }
}

/// Writes `fields` on the nodes of `space`, and for every region of the mesh a cell field `region
/// NAME` that is 1 in it.
///
/// Vectors get three components, as VTK wants. A P1 field on a P2 space is interpolated to the
/// midpoints of the edges, which is exact.
///
/// # Errors
/// The file cannot be written, or a field has neither a value a node nor one a point of the mesh.
pub fn write_vtu<const D: usize>(
    path: &Path,
    space: &Space<D>,
    time: f64,
    fields: &[(&str, FieldData<D>)],
) -> Result<()> {
    let mut file = Document::default();
    let cells = space.mesh().cell_count();
    file.open("FieldData");
    file.array("Float64", "TimeValue", " NumberOfTuples=\"1\"", &time.to_le_bytes());
    file.close("FieldData");
    file.line(&format!("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{cells}\">", space.len()));
    file.open("PointData");
    for (name, field) in fields {
        match field {
            FieldData::Scalar(f) => {
                file.array("Float64", name, "", &bytes(&on_nodes(space, name, f)?))
            }
            FieldData::Vector(f) => {
                file.array("Float64", name, THREE, &bytes(&padded(&on_nodes(space, name, f)?)))
            }
        }
    }
    file.close("PointData");
    file.open("CellData");
    for (name, members) in space.mesh().regions() {
        let mut inside = vec![0u8; cells];
        members
            .iter()
            .filter_map(|&c| Some(c as usize).filter(|&c| c < cells))
            .for_each(|c| inside[c] = 1);
        file.array("UInt8", &format!("region {name}"), "", &inside);
    }
    file.close("CellData");
    file.open("Points");
    file.array("Float64", "Points", THREE, &bytes(&padded(space.nodes())));
    file.close("Points");
    let n = space.local_count();
    let nodes =
        (0..cells).flat_map(|c| space.cell_nodes(c)).flat_map(|&v| i64::from(v).to_le_bytes());
    file.open("Cells");
    file.array("Int64", "connectivity", "", &nodes.collect::<Vec<u8>>());
    let ends = (1..=cells).flat_map(|c| ((c * n) as i64).to_le_bytes());
    file.array("Int64", "offsets", "", &ends.collect::<Vec<u8>>());
    file.array("UInt8", "types", "", &vec![cell_type(space.element(), D); cells]);
    file.close("Cells");
    write_file(path, &file.finish()?)
}

const THREE: &str = " NumberOfComponents=\"3\"";

/// Vectors with three components.
fn padded<const D: usize>(f: &[SVector<f64, D>]) -> Vec<f64> {
    f.iter().flat_map(|v| (0..3).map(|k| if k < D { v[k] } else { 0.0 })).collect()
}

fn bytes(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A file in the making: the XML head and the binary data it points into.
#[derive(Default)]
struct Document {
    head: String,
    data: Vec<u8>,
    failed: Option<std::io::Error>,
}

impl Document {
    fn line(&mut self, text: &str) {
        self.head.push_str(text);
        self.head.push('\n');
    }
    fn open(&mut self, tag: &str) {
        self.line(&format!("<{tag}>"));
    }
    fn close(&mut self, tag: &str) {
        self.line(&format!("</{tag}>"));
    }
    /// A data array: its tag in the head, and its compressed blocks behind a table of their sizes.
    fn array(&mut self, number: &str, name: &str, more: &str, raw: &[u8]) {
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
    /// The whole file.
    fn finish(self) -> Result<Vec<u8>> {
        if let Some(e) = self.failed {
            return Err(Error::internal("cannot compress the fields").value(e));
        }
        let mut out = HEAD.as_bytes().to_vec();
        out.extend_from_slice(self.head.as_bytes());
        out.extend_from_slice(TAIL.as_bytes());
        out.extend_from_slice(&self.data);
        out.extend_from_slice(b"\n</AppendedData>\n</VTKFile>\n");
        Ok(out)
    }
}

/// Beginning of every file; the reader asks for exactly this.
pub(super) const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" \
    version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
    compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n";
/// The text between the head and the binary data.
pub(super) const TAIL: &str = "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";

fn compress(block: &[u8]) -> std::io::Result<Vec<u8>> {
    // Level 1: a tenth of the time of level 6 for files a few per cent larger.
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(1));
    encoder.write_all(block)?;
    encoder.finish()
}
