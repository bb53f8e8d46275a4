//! The distance to the zero set of a P2 function.

use super::super::distance::Tree;
use super::super::interface::Pieces;
use super::super::quadratic::{Quadratic, barycentric_direction};
use crate::base::parallel;
use crate::fem::{Space, Translation, image_shifts};
use crate::mesh::{NONE, Point};
use nalgebra::{SMatrix, SVector};

/// Largest number of steps of Newton's method; it starts nearby and converges quadratically.
const MOST_STEPS: usize = 12;
/// Largest number of cells in the search for a foot.
const MOST_CELLS: usize = 4;
/// Largest distance of a foot from its cell, in barycentric coordinates: the extension of the
/// function beyond a face has an error of the size of the jump of its gradient, times this.
const OUTSIDE: f64 = 0.02;

/// The zero set of a P2 function, to which the distance can be computed.
///
/// The nearest of the straight pieces of the cut interface, found by a tree, gives the cell; there
/// Newton's method solves `y - x + l grad phi(y) = 0`, `phi(y) = 0` for the foot `y`. If the foot
/// lies outside of the cell, the neighbour is searched; if neither has one, as at a corner or
/// beyond a periodic side, the nearest point of the pieces, moved onto the zero set along the
/// gradient, replaces it.
pub(super) struct Surface<'a, const D: usize> {
    pub space: &'a Space<D>,
    phi: &'a [f64],
    cells: Vec<u32>,
    shifts: Vec<Point<D>>,
    tree: Tree<D>,
}

impl<'a, const D: usize> Surface<'a, D> {
    /// The zero set of `phi` with the given pieces, and its periodic images.
    pub(super) fn new(
        space: &'a Space<D>,
        phi: &'a [f64],
        pieces: Pieces<D>,
        translations: &[Translation<D>],
    ) -> Surface<'a, D> {
        let shifts = image_shifts(translations);
        let image = |s: &Point<D>| {
            let s = *s;
            pieces.corners.iter().map(move |corners| corners.map(|x| x + s))
        };
        let tree = Tree::new(shifts.iter().flat_map(image).collect());
        Surface { space, phi, cells: pieces.cells, shifts, tree }
    }
    /// The cells that the interface crosses, in their order, each at least once.
    pub(super) fn cells(&self) -> &[u32] {
        &self.cells
    }
    /// The distance at all nodes.
    pub(super) fn distances(&self) -> Vec<f64> {
        let mut out = vec![0.0; self.space.len()];
        parallel::fill(&mut out, 1, |first, part| {
            for (d, x) in part.iter_mut().zip(&self.space.nodes()[first..]) {
                *d = self.distance(x);
            }
        });
        out
    }
    /// The distance from `x`, not negative.
    pub(super) fn distance(&self, x: &Point<D>) -> f64 {
        let (number, difference) = self.tree.nearest(x);
        let (image, cell) =
            (number / self.cells.len(), self.cells[number % self.cells.len()] as usize);
        let x = x - self.shifts[image];
        let near = self.lifted(cell, x - difference);
        let farthest = (x - near).norm();
        let foot = self.foot(cell, &x, near).map_or(f64::INFINITY, |y| (x - y).norm());
        // The point lies on the zero set: a foot that is farther away is not the nearest.
        foot.min(farthest)
    }
    /// The point moved along the gradient onto the zero set of the function of `cell`.
    fn lifted(&self, cell: usize, y: Point<D>) -> Point<D> {
        let mesh = self.space.mesh();
        let l = mesh.map(cell).barycentric(&y);
        let Some(along) = self.space.gradient(self.phi, cell, &l).try_normalize(0.0) else {
            return y;
        };
        let step = along * mesh.diameter(cell);
        let s = Quadratic::on_line(self.space, self.phi, cell, &l, &step).roots()[0];
        // The pieces deviate by a small fraction of a cell; a root farther away is another branch.
        if s.abs() < 0.1 { y + step * s } else { y }
    }
    /// The foot of `x`, found from `start` in `cell` or a cell nearby.
    fn foot(&self, mut cell: usize, x: &Point<D>, start: Point<D>) -> Option<Point<D>> {
        let mesh = self.space.mesh();
        let mut y = start;
        for _ in 0..MOST_CELLS {
            y = self.newton(cell, x, y)?;
            if (y - start).norm() > mesh.diameter(cell) {
                return None;
            }
            let l = mesh.map(cell).barycentric(&y);
            let farthest = (0..=D).min_by(|&i, &j| l[i].total_cmp(&l[j]))?;
            if l[farthest] >= -OUTSIDE {
                return Some(y);
            }
            cell = match mesh.neighbours(cell)[farthest] {
                NONE => return None,
                next => next as usize,
            };
        }
        None
    }
    /// The point `y` of the zero set of the function of `cell` whose gradient points to `x`, by
    /// Newton's method from `start`.
    fn newton(&self, cell: usize, x: &Point<D>, start: Point<D>) -> Option<Point<D>> {
        let (mesh, space) = (self.space.mesh(), self.space);
        let map = mesh.map(cell);
        let hessian = self.hessian(cell);
        let gradient = |y: &Point<D>| space.gradient(self.phi, cell, &map.barycentric(y));
        let small = 1e-14 * mesh.diameter(cell);
        let mut y = start;
        let g = gradient(&y);
        let mut factor = (x - y).dot(&g) / g.norm_squared();
        for _ in 0..MOST_STEPS {
            let (g, value) = (gradient(&y), space.value(self.phi, cell, &map.barycentric(&y)));
            let inverse = (SMatrix::<f64, D, D>::identity() + hessian * factor).try_inverse()?;
            let rest: SVector<f64, D> = inverse * (y - x + g * factor);
            let along: SVector<f64, D> = inverse * g;
            let change = (value - g.dot(&rest)) / g.dot(&along);
            let step = rest + along * change;
            factor += change;
            y -= step;
            if !y.iter().all(|c| c.is_finite()) {
                return None;
            }
            if step.norm() <= small {
                return Some(y);
            }
        }
        None
    }
    /// The second derivatives in a cell, in which they are constant.
    fn hessian(&self, cell: usize) -> SMatrix<f64, D, D> {
        let gradient = |l: &[f64; 4]| self.space.gradient(self.phi, cell, l);
        let origin = [1.0, 0.0, 0.0, 0.0];
        let g = gradient(&origin);
        SMatrix::from_columns(&std::array::from_fn::<SVector<f64, D>, D, _>(|k| {
            let axis = SVector::<f64, D>::from_fn(|i, _| if i == k { 1.0 } else { 0.0 });
            let dl = barycentric_direction(self.space, cell, &axis);
            gradient(&std::array::from_fn(|i| origin[i] + dl[i])) - g
        }))
    }
}
