//! The mesh of a scene before it is adapted.

use super::refined::refined;
use super::schema::{MeshSource, WALLS};
use super::script::Script;
use crate::base::{Error, Result, Warning, available_memory, readable_bytes, same};
use crate::mesh::{self, Mesh, gmsh};

/// Name of the cells of a mesh, in the plural.
pub(super) fn cells(dimension: usize) -> &'static str {
    if dimension == 2 { "triangles" } else { "tetrahedra" }
}

/// Least number of bytes that a cell costs in a run: mesh, fields and numbering.
const BYTES_OF_CELL: [f64; 2] = [400.0, 800.0];

/// Rejects a generated mesh that does not fit into the memory, before it is made.
fn check_size(script: &Script) -> Result<()> {
    let product = |cells: &[usize]| cells.iter().map(|&n| n as f64).product::<f64>();
    let (cells, key) = match &script.mesh {
        MeshSource::Rectangle(r) => (2.0 * product(&r.cells), "cells"),
        MeshSource::Box(b) => (6.0 * product(&b.cells), "cells"),
        MeshSource::BallInBox(b) => (6.0 * product(&b.cells), "cells"),
        _ => return Ok(()),
    };
    let bytes = cells * BYTES_OF_CELL[script.mesh.dimension() - 2];
    match available_memory() {
        Some(there) if bytes > there as f64 => {
            Err(Error::scene("the mesh does not fit into the memory")
                .value(format!(
                    "{cells:.1e} cells, at least {}; {} are available",
                    readable_bytes(bytes as usize),
                    readable_bytes(there)
                ))
                .remedy(format!("give fewer {key}")))
        }
        _ => Ok(()),
    }
}

/// The mesh of a scene in `D` dimensions, with warnings.
///
/// # Errors
/// A file that cannot be read or has another dimension; sizes that define no valid mesh.
pub(super) fn mesh<const D: usize>(script: &Script) -> Result<(Mesh<D>, Vec<Warning>)> {
    if let MeshSource::File { path, refine, geometry, .. } = &script.mesh {
        let (mesh, warnings) = gmsh::read::<D>(path)?;
        return Ok((refined(script, mesh, *refine, geometry)?, warnings));
    }
    let place = |e| script.blame(&["mesh"], e);
    check_size(script).map_err(place)?;
    let found = match &script.mesh {
        MeshSource::Rectangle(r) => {
            same(mesh::rectangle(r.min, r.max, r.cells, r.diagonals).map_err(place)?)
        }
        MeshSource::Disc(d) => same(mesh::disc(d.centre, d.radius, d.cells).map_err(place)?),
        source => match source.generated() {
            Some(made) => same(made.map_err(place)?),
            None => None,
        },
    };
    let mesh = found.ok_or_else(|| Error::internal("a mesh of another number of dimensions"))?;
    Ok((mesh, Vec::new()))
}

/// Adds the name `walls` for the whole boundary if the mesh does not have it.
pub(super) fn with_walls<const D: usize>(mut mesh: Mesh<D>) -> Mesh<D> {
    if !mesh.boundaries().contains_key(WALLS) {
        let all = (0..mesh.facets().len() as u32).collect();
        mesh.set_boundary(WALLS, all);
    }
    mesh
}
