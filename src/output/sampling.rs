//! Fields of a plane mesh evaluated on a lattice of points, such as the centres of pixels.

use crate::mesh::Mesh;
use nalgebra::SVector;
use rayon::prelude::*;

/// A lattice of points: `origin + (column * step_x, row * step_y)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lattice {
    pub origin: [f64; 2],
    pub step: [f64; 2],
    pub columns: usize,
    pub rows: usize,
}

/// Rows that are worked on together.
const BAND: usize = 32;

impl Lattice {
    /// The value at every point, row by row, of `value(cell, barycentric coordinates)`; `empty`
    /// outside of the mesh.
    pub fn sample<T>(
        &self,
        mesh: &Mesh<2>,
        empty: T,
        value: impl Fn(usize, &[f64; 4]) -> T + Sync,
    ) -> Vec<T>
    where
        T: Copy + Send + Sync,
    {
        let mut out = vec![empty; self.columns * self.rows];
        if out.is_empty() {
            return out;
        }
        let boxes: Vec<[usize; 4]> =
            (0..mesh.cell_count()).into_par_iter().map(|c| self.bounds(mesh, c)).collect();
        out.par_chunks_mut(self.columns * BAND).enumerate().for_each(|(k, part)| {
            let (first, end) = (k * BAND, k * BAND + part.len() / self.columns);
            for (c, b) in boxes.iter().enumerate() {
                for row in b[2].max(first)..b[3].min(end) {
                    let line = &mut part[(row - first) * self.columns..][..self.columns];
                    self.fill_row(mesh, c, row, b[0]..b[1], line, &value);
                }
            }
        });
        out
    }
    fn fill_row<T>(
        &self,
        mesh: &Mesh<2>,
        c: usize,
        row: usize,
        columns: std::ops::Range<usize>,
        line: &mut [T],
        value: &impl Fn(usize, &[f64; 4]) -> T,
    ) {
        let map = mesh.map(c);
        let (a, b) = (self.point(0, row), self.point(1, row));
        let (a, b) = (map.barycentric(&a), map.barycentric(&b));
        for column in columns {
            let l: [f64; 4] = std::array::from_fn(|k| a[k] + column as f64 * (b[k] - a[k]));
            // A point on an edge belongs to both cells; the tolerance keeps rounding from leaving
            // it to none.
            if l[0] >= -1e-9 && l[1] >= -1e-9 && l[2] >= -1e-9 {
                line[column] = value(c, &l);
            }
        }
    }
    pub fn point(&self, column: usize, row: usize) -> SVector<f64, 2> {
        SVector::<f64, 2>::new(
            self.origin[0] + column as f64 * self.step[0],
            self.origin[1] + row as f64 * self.step[1],
        )
    }
    /// First column, end of columns, first row and end of rows of the points that may lie in a
    /// cell.
    fn bounds(&self, mesh: &Mesh<2>, c: usize) -> [usize; 4] {
        let range = |axis: usize, count: usize| {
            let at = mesh
                .cell(c)
                .iter()
                .map(|&v| (mesh.points()[v as usize][axis] - self.origin[axis]) / self.step[axis]);
            let (low, high) =
                at.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            let (low, high) = ((low - 1e-6).ceil().max(0.0) as usize, (high + 1e-6).floor());
            (low.min(count), if high < 0.0 { 0 } else { (high as usize + 1).min(count) })
        };
        let ((a, b), (c, d)) = (range(0, self.columns), range(1, self.rows));
        [a, b, c, d]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Element, Space};
    use crate::mesh::{Diagonals, rectangle};
    use std::sync::Arc;

    #[test]
    fn a_quadratic_is_exact_at_every_point_and_nothing_is_left_out() {
        let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 1.0], [7, 5], Diagonals::Right).unwrap());
        let space = Space::new(&mesh, Element::P2);
        let exact = |x: &SVector<f64, 2>| 1.0 + x[0] * x[1] - 2.0 * x[0] * x[0];
        let f = space.interpolate(exact);
        // Points on edges, on vertices and outside are among them; the second axis points down.
        let lattice =
            Lattice { origin: [-0.5, 1.25], step: [0.0625, -0.0625], columns: 50, rows: 30 };
        let samples = lattice.sample(&mesh, f64::NAN, |c, l| space.value(&f, c, l));
        for (i, v) in samples.iter().enumerate() {
            let x = lattice.point(i % 50, i / 50);
            let inside = (0.0..=2.0).contains(&x[0]) && (0.0..=1.0).contains(&x[1]);
            assert_eq!(inside, v.is_finite(), "{x:?}");
            assert!(!inside || (v - exact(&x)).abs() < 1e-12);
        }
    }
}
