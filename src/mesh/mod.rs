//! Simplicial meshes: points, cells, named regions and boundaries, neighbours.

pub mod adapt;
mod bisect;
mod bytes;
pub mod freefem;
mod generate;
pub mod gmsh;
mod locate;
mod quality;
mod refine;
mod topology;

pub use bisect::{ball_in_box, graded_box};
pub use generate::{Diagonals, box_mesh, disc, rectangle};
pub use locate::{Location, Locator, TOLERANCE};
pub use quality::{Extreme, Quality, check, slit};
pub use refine::refine;

use crate::base::{Error, Result};
use nalgebra::{SMatrix, SVector};
use std::collections::BTreeMap;
use topology::connect;
pub(crate) use topology::facet_key;

/// A point of the plane or of space.
pub type Point<const D: usize> = SVector<f64, D>;

/// "No cell": the neighbour across a facet on the boundary.
pub const NONE: u32 = u32::MAX;

/// The affine map of a cell: barycentric coordinates are
/// `lambda_k = (inverse * (x - origin))_(k-1)` for `k = 1..=D`, `lambda_0 = 1 - sum`.
#[derive(Clone, Debug)]
pub struct Affine<const D: usize> {
    /// First vertex of the cell.
    pub origin: Point<D>,
    /// Row `k - 1` is the gradient of `lambda_k`.
    pub inverse: SMatrix<f64, D, D>,
    /// Area (D = 2) or volume (D = 3), positive.
    pub volume: f64,
}

impl<const D: usize> Affine<D> {
    /// Barycentric coordinates of `x`; entries `0..=D` are used.
    #[inline]
    pub fn barycentric(&self, x: &Point<D>) -> [f64; 4] {
        let l = self.inverse * (x - self.origin);
        let mut b = [0.0; 4];
        b[0] = 1.0;
        for k in 0..D {
            b[k + 1] = l[k];
            b[0] -= l[k];
        }
        b
    }
    /// Barycentric coordinates of the point at `step` from the point with coordinates `l`, if it
    /// lies in the cell.
    #[inline]
    pub fn moved(&self, l: &[f64; 4], step: &SVector<f64, D>) -> Option<[f64; 4]> {
        let (b, inside) = shifted(l, &(self.inverse * step));
        inside.then_some(b)
    }
    /// Gradient of barycentric coordinate `k`.
    pub fn gradient(&self, k: usize) -> SVector<f64, D> {
        if k == 0 {
            let mut g = SVector::<f64, D>::zeros();
            for i in 0..D {
                g -= self.inverse.row(i).transpose();
            }
            g
        } else {
            self.inverse.row(k - 1).transpose()
        }
    }
}

/// The barycentric coordinates `l` after `l_k`, `k = 1..=D`, have changed by `change`, and true if
/// they are those of a point of the cell.
#[inline(always)]
pub fn shifted<const D: usize>(l: &[f64; 4], change: &SVector<f64, D>) -> ([f64; 4], bool) {
    let (mut b, mut inside) = (*l, true);
    for k in 0..D {
        b[k + 1] += change[k];
        b[0] -= change[k];
        inside &= b[k + 1] >= -TOLERANCE;
    }
    (b, inside && b[0] >= -TOLERANCE)
}

/// A facet on the boundary of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facet {
    /// The cell it belongs to.
    pub cell: u32,
    /// The local vertex of that cell that lies opposite.
    pub opposite: u32,
}

/// A conforming simplicial mesh with named parts.
///
/// Cells are positively oriented. Neighbour `k` of a cell lies across the facet opposite to its
/// local vertex `k`.
///
/// # Examples
/// ```
/// use immersa::mesh::{Diagonals, rectangle};
///
/// let mesh = rectangle([0.0, 0.0], [2.0, 1.0], [4, 2], Diagonals::UnionJack)?;
/// assert_eq!((mesh.points().len(), mesh.cell_count()), (15, 16));
/// assert!((mesh.volume() - 2.0).abs() < 1e-14);
/// assert_eq!(mesh.boundary("left")?.len(), 2);
/// # Ok::<(), immersa::base::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Mesh<const D: usize> {
    points: Vec<Point<D>>,
    cells: Vec<u32>,
    neighbours: Vec<u32>,
    maps: Vec<Affine<D>>,
    facets: Vec<Facet>,
    boundaries: BTreeMap<String, Vec<u32>>,
    regions: BTreeMap<String, Vec<u32>>,
    reoriented: Vec<u32>,
}

/// Refuses cells that are none of dimension `D`, too many of them, and coordinates that are not
/// finite.
fn check_sizes<const D: usize>(points: &[Point<D>], cells: &[u32]) -> Result<()> {
    if cells.is_empty() || !cells.len().is_multiple_of(D + 1) {
        return Err(Error::input(format!("the mesh has no cells of dimension {D}"))
            .remedy("check that the mesh holds triangles (2-D) or tetrahedra (3-D)"));
    }
    if cells.len() >= NONE as usize || points.len() >= NONE as usize {
        return Err(Error::input("the mesh is too large")
            .value(format!("{} points, {} cells", points.len(), cells.len() / (D + 1)))
            .remedy(format!("use fewer than {} points and cells", NONE / (D as u32 + 1))));
    }
    if let Some(i) = points.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(Error::input("a coordinate is not a finite number")
            .at(format!("point {i} (counted from 0)"))
            .value(format!("{:?}", points[i].as_slice())));
    }
    Ok(())
}

/// Makes cell `c` positively oriented. Returns its map, and true if its orientation has changed.
fn oriented<const D: usize>(
    points: &[Point<D>],
    c: usize,
    cell: &mut [u32],
) -> Result<(Affine<D>, bool)> {
    if let Some(&bad) = cell.iter().find(|&&v| v as usize >= points.len()) {
        return Err(Error::input("a cell uses a point that does not exist")
            .at(format!("cell {c} (counted from 0)"))
            .value(format!("point {bad} of {}", points.len())));
    }
    let edge = |cell: &[u32], k: usize| points[cell[k + 1] as usize] - points[cell[0] as usize];
    let jacobian = |cell: &[u32]| SMatrix::<f64, D, D>::from_fn(|i, k| edge(cell, k)[i]);
    let mut j = jacobian(cell);
    let mut det = determinant(&j);
    let turned = det < 0.0;
    if turned {
        cell.swap(D - 1, D);
        j = jacobian(cell);
        det = determinant(&j);
    }
    let size = (0..D).map(|k| edge(cell, k).norm()).fold(0.0, f64::max);
    let inverse = j.try_inverse().filter(|_| det > 1e-14 * size.powi(D as i32));
    let Some(inverse) = inverse else {
        let at: Vec<_> = cell.iter().map(|&v| points[v as usize].as_slice().to_vec()).collect();
        return Err(Error::input("a cell is degenerate: it has no volume")
            .at(format!("cell {c} (counted from 0) with vertices {at:?}"))
            .value(format!("{det:e}"))
            .remedy(
                "remove or merge the points in the mesh generator (gmsh: Coherence; or \
                 Mesh.ToleranceInitialDelaunay)",
            ));
    };
    let factorial = if D == 2 { 2.0 } else { 6.0 };
    let map = Affine { origin: points[cell[0] as usize], inverse, volume: det / factorial };
    Ok((map, turned))
}

impl<const D: usize> Mesh<D> {
    /// A mesh from points and cells (`D + 1` point numbers per cell, flat). Negatively oriented
    /// cells are reoriented and listed in [`Mesh::reoriented`].
    ///
    /// # Errors
    /// A point number out of range, a coordinate that is not finite, a degenerate cell (volume
    /// below `1e-14` of the cube of its longest edge, in 2-D of the square), a facet shared by more
    /// than two cells, or two cells on the same side of a facet (they overlap). Each names the cell
    /// and its coordinates.
    pub fn new(points: Vec<Point<D>>, mut cells: Vec<u32>) -> Result<Mesh<D>> {
        check_sizes(&points, &cells)?;
        let mut maps = Vec::with_capacity(cells.len() / (D + 1));
        let mut reoriented = Vec::new();
        for (c, cell) in cells.chunks_exact_mut(D + 1).enumerate() {
            let (map, turned) = oriented(&points, c, cell)?;
            maps.push(map);
            reoriented.extend(turned.then_some(c as u32));
        }
        let (neighbours, facets) = connect::<D>(&points, &cells)?;
        Ok(Mesh {
            points,
            cells,
            neighbours,
            maps,
            facets,
            boundaries: BTreeMap::new(),
            regions: BTreeMap::new(),
            reoriented,
        })
    }

    /// The points.
    pub fn points(&self) -> &[Point<D>] {
        &self.points
    }
    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.maps.len()
    }
    /// The `D + 1` point numbers of cell `c`.
    pub fn cell(&self, c: usize) -> &[u32] {
        &self.cells[c * (D + 1)..(c + 1) * (D + 1)]
    }
    /// The `D + 1` neighbours of cell `c`; [`NONE`] on the boundary.
    pub fn neighbours(&self, c: usize) -> &[u32] {
        &self.neighbours[c * (D + 1)..(c + 1) * (D + 1)]
    }
    /// The affine map of cell `c`.
    pub fn map(&self, c: usize) -> &Affine<D> {
        &self.maps[c]
    }
    /// The facets on the boundary.
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }
    /// Point numbers of a boundary facet, oriented so that the normal of [`Mesh::facet_normal`]
    /// points outward.
    pub fn facet_points(&self, f: &Facet) -> impl Iterator<Item = u32> + '_ {
        let opposite = f.opposite as usize;
        self.cell(f.cell as usize)
            .iter()
            .enumerate()
            .filter(move |(k, _)| *k != opposite)
            .map(|(_, &v)| v)
    }
    /// Outward unit normal of a boundary facet and its length (2-D) or area (3-D).
    pub fn facet_normal(&self, f: &Facet) -> (SVector<f64, D>, f64) {
        let map = self.map(f.cell as usize);
        let g = map.gradient(f.opposite as usize);
        let norm = g.norm();
        (-g / norm, D as f64 * map.volume * norm)
    }
    /// Names of boundary parts, with the numbers of their facets in [`Mesh::facets`].
    pub fn boundaries(&self) -> &BTreeMap<String, Vec<u32>> {
        &self.boundaries
    }
    /// Names of regions, with the numbers of their cells.
    pub fn regions(&self) -> &BTreeMap<String, Vec<u32>> {
        &self.regions
    }
    /// Names a boundary part. Numbers are those of [`Mesh::facets`].
    pub fn set_boundary(&mut self, name: impl Into<String>, facets: Vec<u32>) {
        self.boundaries.insert(name.into(), facets);
    }
    /// Names a set of cells.
    pub fn set_region(&mut self, name: impl Into<String>, cells: Vec<u32>) {
        self.regions.insert(name.into(), cells);
    }
    /// The cells given with negative orientation, which were reoriented.
    pub fn reoriented(&self) -> &[u32] {
        &self.reoriented
    }
    /// Total area or volume.
    pub fn volume(&self) -> f64 {
        self.maps.iter().map(|m| m.volume).sum()
    }
    /// Longest edge of cell `c`.
    pub fn diameter(&self, c: usize) -> f64 {
        let v = self.cell(c);
        let mut d: f64 = 0.0;
        for a in 0..=D {
            for b in 0..a {
                d = d.max((self.points[v[a] as usize] - self.points[v[b] as usize]).norm());
            }
        }
        d
    }
    /// Lower and upper corner of the bounding box.
    pub fn bounding_box(&self) -> (Point<D>, Point<D>) {
        let first = self.points[self.cells[0] as usize];
        self.cells.iter().fold((first, first), |(lo, hi), &v| {
            let p = &self.points[v as usize];
            (lo.inf(p), hi.sup(p))
        })
    }
    /// The facets of a named boundary part, or an error that lists the names that exist.
    pub fn boundary(&self, name: &str) -> Result<&[u32]> {
        self.boundaries.get(name).map(Vec::as_slice).ok_or_else(|| {
            let known: Vec<_> = self.boundaries.keys().cloned().collect();
            Error::input("the mesh has no boundary of this name")
                .value(name)
                .remedy(format!("names in this mesh: {}", known.join(", ")))
        })
    }
}

/// Determinant of a 2 x 2 or 3 x 3 matrix (nalgebra's needs bounds that do not go through a generic
/// dimension).
pub(crate) fn determinant<const D: usize>(m: &SMatrix<f64, D, D>) -> f64 {
    match D {
        2 => m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)],
        _ => {
            m[(0, 0)] * (m[(1, 1)] * m[(2, 2)] - m[(1, 2)] * m[(2, 1)])
                - m[(0, 1)] * (m[(1, 0)] * m[(2, 2)] - m[(1, 2)] * m[(2, 0)])
                + m[(0, 2)] * (m[(1, 0)] * m[(2, 1)] - m[(1, 1)] * m[(2, 0)])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(points: &[[f64; 2]], cells: &[u32]) -> String {
        Mesh::<2>::new(points.iter().map(|&p| p.into()).collect(), cells.to_vec())
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn meshes_that_cannot_be_used_are_refused_with_cell_and_coordinates() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5]];
        for (cells, parts) in [
            (&[0, 1, 2, 0, 2, 3, 0, 2, 4][..], &["degenerate", "cell 2", "[0.5, 0.5]"][..]),
            (&[0, 1, 2, 0, 2, 3, 0, 2, 1], &["overlap", "cell 2", "[1.0, 0.0]", "cells [0, 2]"]),
            (&[0, 1, 3, 0, 1, 2], &["overlap", "cell 1", "[1.0, 0.0]", "cells [0, 1]"]),
            (&[0, 1, 4, 1, 2, 4, 0, 4, 2, 2, 3, 4], &["degenerate", "cell 2"]),
            (&[0, 1, 2, 0, 2, 9], &["does not exist", "cell 1", "point 9 of 5"]),
            (&[0, 1], &["no cells"]),
        ] {
            let message = refused(&square, cells);
            assert!(parts.iter().all(|p| message.contains(p)), "{cells:?}: {message}");
        }
        let message = refused(&[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [f64::NAN, 2.0]], &[0, 1, 2]);
        assert!(
            message.contains("not a finite number") && message.contains("point 3"),
            "{message}"
        );
        // Three triangles on one edge.
        let fan = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, -1.0]];
        let message = refused(&fan, &[0, 1, 2, 0, 3, 1, 0, 4, 1]);
        assert!(
            message.contains("more than two cells") && message.contains("cells [0, 1, 2]"),
            "{message}"
        );
    }

    #[test]
    fn tetrahedra_on_the_same_side_of_a_facet_are_refused() {
        let points: Vec<Point<3>> = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.2, 0.2, 2.0],
            [0.1, 0.1, -1.0],
        ]
        .map(|p| p.into())
        .to_vec();
        assert!(Mesh::<3>::new(points.clone(), vec![0, 1, 2, 3, 0, 1, 2, 5]).is_ok());
        let message = Mesh::<3>::new(points, vec![0, 1, 2, 3, 2, 0, 1, 4]).unwrap_err().to_string();
        assert!(message.contains("overlap"), "{message}");
    }
}
