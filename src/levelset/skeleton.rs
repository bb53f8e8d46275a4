//! An interface as a mesh of straight pieces, for files.

use super::interface::coarse_pieces;
use crate::base::Result;
use crate::fem::{At, Space, SurfacePoint};
use crate::mesh::Point;
use std::collections::HashMap;

/// Straight pieces of an interface, segments in the plane and triangles in space, whose corners lie
/// on the zero set and are shared by the pieces that meet there.
#[derive(Clone, Debug)]
pub struct Skeleton<const D: usize> {
    /// The corners, each with a cell that it lies in; their weights are zero. The normals point to
    /// where the level set grows.
    pub points: Vec<SurfacePoint<D>>,
    /// Numbers of the corners of each piece.
    pub pieces: Vec<[u32; D]>,
}

impl<const D: usize> Skeleton<D> {
    /// The pieces of the interface of a P2 function.
    ///
    /// # Errors
    /// A space that is not P2, a value that is not finite.
    pub fn new(space: &Space<D>, phi: &[f64]) -> Result<Skeleton<D>> {
        let found = coarse_pieces(space, phi)?;
        let mut made = Skeleton { points: Vec::new(), pieces: Vec::new() };
        let mut numbers: HashMap<[u64; D], u32> = HashMap::new();
        for (cell, corners) in found.cells.iter().zip(&found.corners) {
            let mut number = |x: &Point<D>| {
                // Corners are the same bits from both sides; zeros may differ in their signs.
                let key = std::array::from_fn(|k| (x[k] + 0.0).to_bits());
                *numbers.entry(key).or_insert_with(|| {
                    made.points.push(corner(space, phi, (*cell as usize, *x), made.points.len()));
                    made.points.len() as u32 - 1
                })
            };
            let piece: [u32; D] = std::array::from_fn(|k| number(&corners[k]));
            let is_degenerate = (1..D).any(|k| piece[..k].contains(&piece[k]));
            if !is_degenerate {
                made.pieces.push(piece);
            }
        }
        Ok(made)
    }
}

fn corner<const D: usize>(
    space: &Space<D>,
    phi: &[f64],
    (cell, x): (usize, Point<D>),
    q: usize,
) -> SurfacePoint<D> {
    let barycentric = space.mesh().map(cell).barycentric(&x);
    let normal = space.gradient(phi, cell, &barycentric);
    let at = At { cell, q, barycentric, x, weight: 0.0 };
    SurfacePoint { at, normal: normal.try_normalize(0.0).unwrap_or(normal) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, box_mesh, rectangle};
    use std::collections::HashMap;
    use std::sync::Arc;

    #[test]
    fn a_circle_is_one_closed_polygon() {
        let mesh = rectangle([-1.0; 2], [1.0; 2], [9, 9], Diagonals::UnionJack).unwrap();
        let space = Space::new(&Arc::new(mesh), Element::P2);
        let phi = space.interpolate(|x| x.norm_squared() - 0.36);
        let Skeleton { points, pieces } = Skeleton::new(&space, &phi).unwrap();
        let mut ends = vec![[0; 2]; points.len()];
        pieces.iter().for_each(|p| [0, 1].iter().for_each(|&k| ends[p[k] as usize][k] += 1));
        assert!(ends.iter().all(|e| *e == [1, 1]), "each corner ends one piece and begins one");
        let length =
            |p: &[u32; 2]| (points[p[0] as usize].at.x - points[p[1] as usize].at.x).norm();
        let perimeter: f64 = pieces.iter().map(length).sum();
        assert!((perimeter / (std::f64::consts::TAU * 0.6) - 1.0).abs() < 2e-3, "{perimeter}");
        for p in &points {
            assert!((p.normal - p.at.x / 0.6).norm() < 1e-9 && (p.at.x.norm() - 0.6).abs() < 1e-9);
            assert!(space.value(&phi, p.at.cell, &p.at.barycentric).abs() < 1e-9);
        }
    }

    #[test]
    fn every_side_of_the_triangles_of_a_sphere_belongs_to_two() {
        let mesh = box_mesh([-1.0; 3], [1.0; 3], [5; 3]).unwrap();
        let space = Space::new(&Arc::new(mesh), Element::P2);
        let phi = space.interpolate(|x| x.norm_squared() - 0.4);
        let Skeleton { points, pieces } = Skeleton::new(&space, &phi).unwrap();
        let mut sides: HashMap<(u32, u32), usize> = HashMap::new();
        for [a, b, c] in &pieces {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                *sides.entry((*a.min(b), *a.max(b))).or_default() += 1;
            }
        }
        assert!(sides.values().all(|n| *n == 2));
        // Of a sphere (Euler).
        assert_eq!(points.len() + pieces.len() - sides.len(), 2);
    }
}
