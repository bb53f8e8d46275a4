//! Parts of the boundary through which fluid and structures leave.

use crate::fem::Space;
use crate::structure::{Fields, Structure};
use nalgebra::SVector;

/// A node of such a part.
struct Outlet<const D: usize> {
    node: u32,
    /// Outward normal.
    normal: SVector<f64, D>,
    /// Longest edge of its cell.
    edge: f64,
}

/// The nodes of parts of the boundary through which fluid passes.
///
/// A structure that reaches such a part leaves through it: what its force would need on the other
/// side is not there. From then on it exerts none, and follows the flow. Fluid that comes in is
/// that outside of all structures.
pub(super) struct Outlets<const D: usize>(Vec<Outlet<D>>);

impl<const D: usize> Outlets<D> {
    /// The nodes of these facets.
    pub fn new(space: &Space<D>, facets: impl Iterator<Item = u32>) -> Outlets<D> {
        let mesh = space.mesh();
        let of = |f: u32| {
            let facet = mesh.facets()[f as usize];
            let (normal, _) = mesh.facet_normal(&facet);
            let edge = mesh.diameter(facet.cell as usize);
            let nodes: Vec<u32> = space.facet_nodes(&facet).collect();
            nodes.into_iter().map(move |node| Outlet { node, normal, edge })
        };
        Outlets(facets.flat_map(of).collect())
    }
    /// The nodes, some of them several times.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.0.iter().map(|o| o.node)
    }
    /// True if the inside or the band of a structure has reached a part that fluid with the
    /// velocity `u` passes; of any velocity for `None`.
    pub fn are_reached(
        &self,
        by: &dyn Structure<D>,
        fields: &Fields<D>,
        u: Option<&[SVector<f64, D>]>,
    ) -> bool {
        let Some(id) = by.level_set() else { return false };
        let phi = fields.scalar(id);
        let fastest = u.map_or(0.0, super::carried::largest);
        let passes = |o: &Outlet<D>| {
            u.is_none_or(|u| u[o.node as usize].dot(&o.normal).abs() > 1e-9 * fastest)
        };
        // Composed transport keeps no values of passive fields.
        let near = |o: &Outlet<D>| phi.get(o.node as usize).is_some_and(|v| *v < margin(o, by));
        self.0.iter().any(|o| near(o) && passes(o))
    }
    /// Lets fluid from outside of all structures in where `u` goes inward: a level set that was
    /// negative there changes sign, and then grows with what has come in.
    pub fn let_in(
        &self,
        structures: &[Box<dyn Structure<D>>],
        u: &[SVector<f64, D>],
        dt: f64,
        fields: &mut Fields<D>,
    ) {
        for s in structures.iter().filter(|s| s.acts()) {
            let Some(id) = s.level_set() else { continue };
            let phi = fields.scalar_mut(id);
            for o in &self.0 {
                let inward = -u[o.node as usize].dot(&o.normal);
                let value = &mut phi[o.node as usize];
                if inward > 0.0 && *value < margin(o, &**s) {
                    *value = match *value < 0.0 {
                        true => (-*value).min(0.5 * s.slope() * o.edge),
                        false => *value + s.slope() * inward * dt,
                    };
                }
            }
        }
    }
}

/// Value of the level set below which a structure is at an outlet: that at the edge of its band, or
/// at a cell from the interface.
fn margin<const D: usize>(at: &Outlet<D>, by: &dyn Structure<D>) -> f64 {
    by.slope() * by.reach().max(at.edge)
}
