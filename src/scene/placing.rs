//! Initial distances of the structures of a scene on its mesh.

use super::Scene;
use super::site::{Placed, Site};
use crate::base::Result;

/// The signed distances of all shapes of a scene, in the order of its structures.
///
/// # Errors
/// A shape that does not lie on the mesh.
pub(super) fn place<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
) -> Result<Vec<Option<Placed<D>>>> {
    let place = |k: usize| {
        let (structure, [list, number]) = (&scene.structures()[k], scene.structure_keys(k));
        let Some(shape) = structure.shape() else { return Ok(None) };
        // A passive interface may end on walls.
        let may_end = !structure.traits().acts;
        site.placed(shape, &[&list, &number, "shape"], may_end).map(Some)
    };
    (0..scene.structures().len()).map(place).collect()
}
