//! Periodic boundaries: identification of facets and nodes.

use super::condition::{Condition, Conditions};
use super::space::Space;
use crate::base::{Error, Partition, Result};
use crate::mesh::{Mesh, Point};
use nalgebra::SVector;
use std::collections::HashMap;

/// A periodic pair of facets: a particle that leaves through `facet` at `x` enters through
/// `partner` at `x + shift`.
#[derive(Clone, Debug)]
pub struct Translation<const D: usize> {
    /// Number of the facet in [`Mesh::facets`].
    pub facet: u32,
    /// Number of the facet on the other side.
    pub partner: u32,
    /// Translation from this side to the other.
    pub shift: SVector<f64, D>,
}

/// The pairs of facets of periodic conditions, each from both sides.
///
/// # Errors
/// A name that the mesh does not have, parts that are not translates of each other.
pub fn periodic_pairs<const D: usize>(
    mesh: &Mesh<D>,
    conditions: &Conditions<D>,
) -> Result<Vec<Translation<D>>> {
    let centre = |f: u32| {
        let facet = &mesh.facets()[f as usize];
        mesh.facet_points(facet).fold(Point::<D>::zeros(), |s, v| s + mesh.points()[v as usize])
            / D as f64
    };
    let (lo, hi) = mesh.bounding_box();
    let grid = 1e-7 * (hi - lo).norm();
    let key = |x: &Point<D>| -> [i64; 3] {
        std::array::from_fn(|i| if i < D { (x[i] / grid).round() as i64 } else { 0 })
    };
    let mut pairs = Vec::new();
    for (name, condition) in conditions {
        let Condition::Periodic(other) = condition else { continue };
        let mine = mesh.boundary(name)?;
        let theirs = mesh.boundary(other)?;
        let wrong = |what: String| {
            Error::scene("periodic boundaries must be translates of each other, facet by facet")
                .at(format!("boundaries {name} and {other}"))
                .value(what)
                .remedy(
                    "mesh both sides alike (gmsh: Periodic Curve or Surface) or name the right \
                     partner",
                )
        };
        if mine.len() != theirs.len() || mine.is_empty() {
            return Err(wrong(format!("{} facets against {}", mine.len(), theirs.len())));
        }
        let mean = |list: &[u32]| {
            list.iter().fold(Point::<D>::zeros(), |s, &f| s + centre(f)) / list.len() as f64
        };
        let shift = mean(theirs) - mean(mine);
        // A coordinate may fall on either side of a rounding boundary: look in the neighbouring
        // buckets too.
        let mut table: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for &f in theirs {
            table.entry(key(&centre(f))).or_default().push(f);
        }
        for &f in mine {
            let target = centre(f) + shift;
            let base = key(&target);
            let found = (0..27).find_map(|o: i64| {
                let bucket = [base[0] + o % 3 - 1, base[1] + (o / 3) % 3 - 1, base[2] + o / 9 - 1];
                table
                    .get(&bucket)?
                    .iter()
                    .copied()
                    .find(|&g| (centre(g) - target).norm() < 2.0 * grid)
            });
            let Some(partner) = found else {
                return Err(wrong(format!(
                    "no partner for the facet at {:?}",
                    centre(f).as_slice()
                )));
            };
            pairs.push(Translation { facet: f, partner, shift });
            pairs.push(Translation { facet: partner, partner: f, shift: -shift });
        }
    }
    Ok(pairs)
}

/// The translations to all periodic images, the zero translation first.
pub fn image_shifts<const D: usize>(pairs: &[Translation<D>]) -> Vec<Point<D>> {
    let mut shifts = vec![Point::<D>::zeros()];
    for pair in pairs {
        let near = |s: &Point<D>| (s - pair.shift).norm() < 1e-6 * pair.shift.norm();
        if !shifts.iter().any(near) {
            shifts = shifts.iter().flat_map(|s| [*s, s + pair.shift, s - pair.shift]).collect();
        }
    }
    shifts
}

/// For every node its master: the first of the nodes that it is identified with.
pub(super) fn identify<const D: usize>(
    space: &Space<D>,
    translations: &[Translation<D>],
) -> Vec<u32> {
    let mut same = Partition::new(space.len());
    let mesh = space.mesh();
    for t in translations {
        let (mine, theirs) = (&mesh.facets()[t.facet as usize], &mesh.facets()[t.partner as usize]);
        for a in space.facet_nodes(mine) {
            let target = space.nodes()[a as usize] + t.shift;
            let distance = |n: &u32| (space.nodes()[*n as usize] - target).norm();
            if let Some(b) =
                space.facet_nodes(theirs).min_by(|x, y| distance(x).total_cmp(&distance(y)))
            {
                same.join(a, b);
            }
        }
    }
    (0..space.len() as u32).map(|n| same.first(n)).collect()
}
