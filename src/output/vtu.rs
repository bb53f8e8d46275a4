//! VTU: fields on a mesh for ParaView, VisIt and meshio.
//!
//! P2 fields are written as quadratic cells, so nothing is lost.

use super::appended::{Document, THREE, bytes, padded};
use super::field::{FieldData, on_nodes};
use super::file::write_file;
use crate::base::Result;
use crate::fem::{Element, Space};
use std::path::Path;

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
    write_file(path, &file.finish(HEAD, TAIL)?)
}

/// Beginning of every file; the reader asks for exactly this.
pub(super) const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" \
    version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
    compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n";
/// The text between the head and the binary data.
pub(super) const TAIL: &str = "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_";
