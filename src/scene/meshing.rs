//! The mesh of a scene before it is adapted.

use super::refined::refined;
use super::schema::MeshSource;
use super::script::Script;
use crate::base::{Error, Result, Warning, same};
use crate::mesh::{self, Mesh, gmsh};

/// Name of the cells of a mesh, in the plural.
pub(super) fn cells(dimension: usize) -> &'static str {
    if dimension == 2 { "triangles" } else { "tetrahedra" }
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
