//! The element types of gmsh, by their numbers in files.

/// A simplex: its dimension and the number of its nodes, of which the first `dimension + 1` are the
/// vertices.
pub(super) struct Simplex {
    pub(super) dimension: usize,
    pub(super) nodes: usize,
}

/// The simplex with this number, or the name of the element and a remedy.
pub(super) fn simplex(code: i64) -> Result<Simplex, (String, &'static str)> {
    let (dimension, nodes) = match code {
        15 => (0, 1),
        1 => (1, 2),
        8 => (1, 3),
        2 => (2, 3),
        9 => (2, 6),
        4 => (3, 4),
        11 => (3, 10),
        _ => return Err(unreadable(code)),
    };
    Ok(Simplex { dimension, nodes })
}

fn unreadable(code: i64) -> (String, &'static str) {
    let split = "leave out Recombine and Transfinite, or set Mesh.SubdivisionAlgorithm = 0 and \
        mesh again, so that all elements are triangles and tetrahedra";
    let (kind, remedy) = match code {
        3 | 10 | 16 | 36..=41 | 47..=51 => ("quadrangles", split),
        5 | 12 | 17 | 92..=98 => ("hexahedra", split),
        6 | 13 | 18 | 90 | 91 => ("prisms", split),
        7 | 14 | 19 | 118 | 119 => ("pyramids", split),
        20..=33 | 42..=46 | 52..=75 => (
            "elements of order 3 or higher",
            "mesh with order 1 (gmsh -order 1, or SetOrder 1 on the finished mesh)",
        ),
        _ => (
            "elements of a type that is not known",
            "write points, lines, triangles and tetrahedra of order 1 only",
        ),
    };
    (format!("the mesh holds {kind} (gmsh type {code}), which cannot be read"), remedy)
}
