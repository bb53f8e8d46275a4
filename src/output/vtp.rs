//! VTP: lines in the plane and triangles in space for ParaView, VisIt and meshio.

use super::appended::{Document, THREE, bytes, padded};
use super::field::FieldData;
use super::file::write_file;
use crate::base::{Error, Result};
use crate::mesh::Point;
use std::path::Path;

/// Name of a part, and for every piece 1 where it belongs to that part.
pub type Mark = (String, Vec<u8>);

/// Writes straight pieces with two ends in the plane and three corners in space: `pieces` are
/// numbers of `points`, `fields` have a value a point, `marks` a value a piece.
///
/// # Errors
/// The file cannot be written, or a field or mark has a wrong number of values (a defect of the
/// caller).
pub fn write_vtp<const D: usize>(
    path: &Path,
    time: f64,
    (points, pieces): (&[Point<D>], &[[u32; D]]),
    fields: &[(&str, FieldData<D>)],
    marks: &[Mark],
) -> Result<()> {
    let length = |field: &FieldData<D>| match field {
        FieldData::Scalar(f) => f.len(),
        FieldData::Vector(f) => f.len(),
    };
    if fields.iter().any(|(_, f)| length(f) != points.len())
        || marks.iter().any(|(_, m)| m.len() != pieces.len())
    {
        return Err(Error::internal("the arrays of a file of pieces do not fit together")
            .at(path.display().to_string()));
    }
    let mut file = Document::default();
    file.open("FieldData");
    file.array("Float64", "TimeValue", " NumberOfTuples=\"1\"", &time.to_le_bytes());
    file.close("FieldData");
    let (own, other) = if D == 2 { ("Lines", "Polys") } else { ("Polys", "Lines") };
    file.line(&format!(
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOf{own}=\"{}\" \
         NumberOf{other}=\"0\" NumberOfStrips=\"0\">",
        points.len(),
        pieces.len()
    ));
    file.open("PointData");
    for (name, field) in fields {
        match field {
            FieldData::Scalar(f) => file.array("Float64", name, "", &bytes(f)),
            FieldData::Vector(f) => file.array("Float64", name, THREE, &bytes(&padded(f))),
        }
    }
    file.close("PointData");
    file.open("CellData");
    marks.iter().for_each(|(name, mark)| file.array("UInt8", name, "", mark));
    file.close("CellData");
    file.open("Points");
    file.array("Float64", "Points", THREE, &bytes(&padded(points)));
    file.close("Points");
    let corners = pieces.iter().flatten().flat_map(|&v| i64::from(v).to_le_bytes());
    file.open(own);
    file.array("Int64", "connectivity", "", &corners.collect::<Vec<u8>>());
    let ends = (1..=pieces.len()).flat_map(|k| ((k * D) as i64).to_le_bytes());
    file.array("Int64", "offsets", "", &ends.collect::<Vec<u8>>());
    file.close(own);
    write_file(path, &file.finish(HEAD, TAIL)?)
}

const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" \
    byte_order=\"LittleEndian\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n\
    <PolyData>\n";
const TAIL: &str = "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::markup::tests::assert_well_formed;

    fn head(bytes: &[u8]) -> String {
        let end = bytes.windows(TAIL.len()).position(|w| w == TAIL.as_bytes()).unwrap();
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        assert_well_formed(&format!("{head}</Piece></PolyData></VTKFile>"));
        head
    }

    #[test]
    fn lines_are_written_in_the_plane_and_triangles_in_space() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.vtp");
        let marks = [("R&D".to_string(), vec![1])];
        let plane = [[0.0, 0.0], [1.0, 0.0]].map(Point::<2>::from);
        let fields =
            [("stretch", FieldData::Scalar(&[1.0, 2.0])), ("u", FieldData::Vector(&plane))];
        write_vtp(&path, 0.5, (&plane, &[[0, 1]]), &fields, &marks).unwrap();
        let text = head(&std::fs::read(&path).unwrap());
        for part in
            ["NumberOfLines=\"1\"", "NumberOfPolys=\"0\"", "Name=\"R&amp;D\"", "\"stretch\""]
        {
            assert!(text.contains(part), "{part}: {text}");
        }
        assert!(write_vtp(&path, 0.5, (&plane, &[[0, 1], [1, 0]]), &[], &marks).is_err());
        let space = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point::<3>::from);
        write_vtp(&path, 0.0, (&space, &[[0, 1, 2]]), &[], &marks).unwrap();
        assert!(head(&std::fs::read(&path).unwrap()).contains("NumberOfPolys=\"1\""));
    }
}
