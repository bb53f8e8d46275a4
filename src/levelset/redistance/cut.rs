//! Interfaces as straight pieces, in the plane and in space.

use super::super::contour::{Contour, LATTICE};
use super::super::isosurface::Isosurface;
use crate::base::Result;
use crate::fem::Space;
use crate::mesh::Point;

/// An interface as segments or triangles, with their cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces<const D: usize> {
    pub cells: Vec<u32>,
    pub corners: Vec<[Point<D>; D]>,
}

impl<const D: usize> Pieces<D> {
    fn push(&mut self, cell: u32, corners: [Point<D>; D]) {
        self.cells.push(cell);
        self.corners.push(corners);
    }
}

/// How the interface of a P2 function is cut and measured in `D` dimensions.
#[derive(Clone, Copy)]
pub struct Cutter<const D: usize> {
    /// Chords between the points of the curved pieces, which lie on the zero set.
    pub(super) pieces: fn(&Space<D>, &[f64]) -> Result<Pieces<D>>,
    /// What the interface encloses, an area or a volume, and its own length or area; zeros where there is none.
    pub(super) extents: fn(&Space<D>, &[f64]) -> Result<[f64; 2]>,
}

impl Cutter<2> {
    /// Curves of the plane, as [`Contour`].
    pub const PLANE: Cutter<2> = Cutter {
        pieces: |space, phi| {
            let mut pieces = Pieces { cells: Vec::new(), corners: Vec::new() };
            for s in Contour::new(space, phi)?.segments() {
                let [start, middle, end] = s.points;
                pieces.push(s.cell, [start, middle]);
                pieces.push(s.cell, [middle, end]);
            }
            Ok(pieces)
        },
        extents: |space, phi| {
            let measures = Contour::new(space, phi)?.measures();
            Ok(measures.map_or([0.0; 2], |m| [m.area, m.perimeter]))
        },
    };
}

impl Cutter<3> {
    /// Surfaces in space, as [`Isosurface`].
    pub const SPACE: Cutter<3> = Cutter {
        pieces: |space, phi| {
            let mut pieces = Pieces { cells: Vec::new(), corners: Vec::new() };
            for t in Isosurface::new(space, phi)?.triangles() {
                LATTICE.iter().for_each(|quarter| pieces.push(t.cell, quarter.map(|k| t.points[k])));
            }
            Ok(pieces)
        },
        extents: |space, phi| {
            let measures = Isosurface::new(space, phi)?.measures();
            Ok(measures.map_or([0.0; 2], |m| [m.volume, m.surface]))
        },
    };
}
