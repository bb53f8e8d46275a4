//! Finite-element spaces: nodes of cells, values and gradients of functions.

use super::element::{EDGES, Element, MAX_LOCAL};
use crate::mesh::{Facet, Mesh, Point};
use nalgebra::{ArrayStorage, SMatrix, SVector};
use std::collections::HashMap;
use std::ops::{Add, Mul};
use std::sync::Arc;

/// Type of a nodal value: a number or a vector.
pub trait Value: Copy + Send + Sync + Add<Output = Self> + Mul<f64, Output = Self> {
    /// The zero.
    const ZERO: Self;
}
impl Value for f64 {
    const ZERO: f64 = 0.0;
}
impl<const D: usize> Value for SVector<f64, D> {
    const ZERO: Self = SVector::<f64, D>::from_array_storage(ArrayStorage([[0.0; D]; 1]));
}

/// A Lagrange space on a mesh, continuous except for the constants of cells in P1 + P0. A function
/// is a slice with one [`Value`] per node.
///
/// The nodes of P1 are the points of the mesh; those of P2 are the points, then the midpoints of
/// the edges; those of P1 + P0 are the points, then the centres of the cells, whose values are
/// added constants.
///
/// # Examples
/// ```
/// use immersa::fem::{Element, Space};
/// use immersa::mesh::{Diagonals, rectangle};
/// use std::sync::Arc;
///
/// let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 1.0], [4, 2], Diagonals::Right)?);
/// let space = Space::new(&mesh, Element::P2);
/// assert_eq!(space.len(), 9 * 5);
///
/// // A quadratic function is in the space: its interpolant has the exact gradient.
/// let f = space.interpolate(|x| x[0] * x[0]);
/// let centre = [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0];
/// let x = mesh.point_at(&immersa::mesh::Location { cell: 3, barycentric: centre });
/// assert!((space.gradient(&f, 3, &centre)[0] - 2.0 * x[0]).abs() < 1e-13);
/// # Ok::<(), immersa::base::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Space<const D: usize> {
    mesh: Arc<Mesh<D>>,
    element: Element,
    cell_nodes: Vec<u32>,
    nodes: Vec<Point<D>>,
}

impl<const D: usize> Space<D> {
    /// The space of `element` on `mesh`.
    pub fn new(mesh: &Arc<Mesh<D>>, element: Element) -> Space<D> {
        let mut nodes = mesh.points().to_vec();
        let mut cell_nodes = Vec::with_capacity(mesh.cell_count() * element.local_count(D));
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        for c in 0..mesh.cell_count() {
            let cell = mesh.cell(c);
            cell_nodes.extend_from_slice(cell);
            if element == Element::P1P0 {
                cell_nodes.push(nodes.len() as u32);
                nodes.push(
                    cell.iter().map(|&v| mesh.points()[v as usize]).sum::<Point<D>>()
                        / (D as f64 + 1.0),
                );
            } else if element == Element::P2 {
                for &(i, j) in &EDGES[..D * (D + 1) / 2] {
                    let (a, b) = (cell[i].min(cell[j]), cell[i].max(cell[j]));
                    let node = *edges.entry((a, b)).or_insert_with(|| {
                        nodes.push((mesh.points()[a as usize] + mesh.points()[b as usize]) * 0.5);
                        nodes.len() as u32 - 1
                    });
                    cell_nodes.push(node);
                }
            }
        }
        Space { mesh: Arc::clone(mesh), element, cell_nodes, nodes }
    }
    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh<D>> {
        &self.mesh
    }
    /// The element.
    pub fn element(&self) -> Element {
        self.element
    }
    /// The nodes.
    pub fn nodes(&self) -> &[Point<D>] {
        &self.nodes
    }
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }
    /// True if `other` has the same nodes and cells under the same numbers.
    pub fn coincides(&self, other: &Space<D>) -> bool {
        self.element == other.element
            && self.nodes == other.nodes
            && self.cell_nodes == other.cell_nodes
    }
    /// True if there are no nodes (never, on a valid mesh).
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
    /// Number of basis functions on a cell.
    pub fn local_count(&self) -> usize {
        self.element.local_count(D)
    }
    /// The nodes of cell `c`, in the order of the local basis.
    pub fn cell_nodes(&self, c: usize) -> &[u32] {
        let n = self.local_count();
        &self.cell_nodes[c * n..(c + 1) * n]
    }
    /// For every node: true if it belongs to a cell. A mesh may have points of no cell.
    pub fn used_nodes(&self) -> Vec<bool> {
        let mut used = vec![false; self.len()];
        self.cell_nodes.iter().for_each(|&n| used[n as usize] = true);
        used
    }
    /// The nodes on a boundary facet.
    pub fn facet_nodes(&self, f: &Facet) -> impl Iterator<Item = u32> + '_ {
        let opposite = f.opposite as usize;
        let nodes = self.cell_nodes(f.cell as usize);
        let on = move |a: usize| {
            if a <= D {
                a != opposite
            } else if self.element == Element::P1P0 {
                false
            } else {
                let (i, j) = EDGES[a - D - 1];
                i != opposite && j != opposite
            }
        };
        (0..nodes.len()).filter(move |&a| on(a)).map(|a| nodes[a])
    }
    /// The interpolant of `f`.
    pub fn interpolate<T: Value>(&self, f: impl Fn(&Point<D>) -> T) -> Vec<T> {
        self.nodes.iter().map(f).collect()
    }
    /// A function on cell `c`: its values at the nodes of the cell, gathered once.
    #[inline(always)]
    pub fn on_cell<T: Value>(&self, f: &[T], c: usize) -> OnCell<T, D> {
        let (nodes, mut values) = (self.cell_nodes(c), [T::ZERO; MAX_LOCAL]);
        if nodes.len() == most_local(D) {
            (0..most_local(D)).for_each(|a| values[a] = f[nodes[a] as usize]);
        } else {
            nodes.iter().zip(&mut values).for_each(|(&n, v)| *v = f[n as usize]);
        }
        OnCell { element: self.element, values }
    }
    /// Value of a function in cell `c` at barycentric coordinates `l`.
    #[inline]
    pub fn value<T: Value>(&self, f: &[T], c: usize, l: &[f64; 4]) -> T {
        self.on_cell(f, c).value(l)
    }
    /// Gradient of a scalar function in cell `c` at barycentric coordinates `l`.
    #[inline]
    pub fn gradient(&self, f: &[f64], c: usize, l: &[f64; 4]) -> SVector<f64, D> {
        let g = self.on_cell(f, c).reference_gradient(&self.element.reference_gradients::<D>(l));
        self.mesh.map(c).inverse.tr_mul(&g)
    }
    /// Gradient of a vector function: row `i`, column `j` is `d f_i / d x_j`.
    #[inline]
    pub fn jacobian(&self, f: &[SVector<f64, D>], c: usize, l: &[f64; 4]) -> SMatrix<f64, D, D> {
        self.on_cell(f, c).reference_jacobian(&self.element.reference_gradients::<D>(l))
            * self.mesh.map(c).inverse
    }
}

/// Largest number of basis functions on a cell of dimension `d`. Loops to this constant are
/// unrolled; unused entries are zero.
pub(super) const fn most_local(d: usize) -> usize {
    Element::P2.local_count(d)
}

/// A function on one cell, to be evaluated at several points.
#[derive(Clone, Copy, Debug)]
pub struct OnCell<T, const D: usize> {
    element: Element,
    values: [T; MAX_LOCAL],
}

impl<T: Value, const D: usize> OnCell<T, D> {
    /// The values at the nodes of the cell, in the order of the local basis; zero beyond.
    #[inline]
    pub fn nodal(&self) -> &[T; MAX_LOCAL] {
        &self.values
    }
    /// The value at barycentric coordinates `l`.
    #[inline]
    pub fn value(&self, l: &[f64; 4]) -> T {
        match self.element {
            Element::P1 => self.combined(&Element::P1.values::<D>(l)),
            Element::P2 => self.combined(&Element::P2.values::<D>(l)),
            Element::P1P0 => self.combined(&Element::P1P0.values::<D>(l)),
        }
    }
    /// The value where the basis functions have the values `n`.
    #[inline(always)]
    pub fn combined(&self, n: &[f64; MAX_LOCAL]) -> T {
        let mut v = self.values[0] * n[0];
        for a in 1..most_local(D) {
            v = v + self.values[a] * n[a];
        }
        v
    }
}

impl<const D: usize> OnCell<f64, D> {
    /// The gradient in the coordinates of the reference cell, where the basis functions have the
    /// gradients `g`.
    #[inline(always)]
    pub fn reference_gradient(&self, g: &[SVector<f64, D>; MAX_LOCAL]) -> SVector<f64, D> {
        let mut r = g[0] * self.values[0];
        for a in 1..most_local(D) {
            r += g[a] * self.values[a];
        }
        r
    }
}

impl<const D: usize> OnCell<SVector<f64, D>, D> {
    /// The derivative with respect to the coordinates of the reference cell, where the basis
    /// functions have the gradients `g`.
    #[inline(always)]
    pub fn reference_jacobian(&self, g: &[SVector<f64, D>; MAX_LOCAL]) -> SMatrix<f64, D, D> {
        let mut r = SMatrix::<f64, D, D>::zeros();
        for a in 0..most_local(D) {
            for j in 0..D {
                for i in 0..D {
                    r[(i, j)] += self.values[a][i] * g[a][j];
                }
            }
        }
        r
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, rectangle};

    #[test]
    fn p2_reproduces_quadratics_and_their_gradients() {
        let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 1.0], [3, 2], Diagonals::Right).unwrap());
        let space = Space::new(&mesh, Element::P2);
        // Euler: edges = points + cells - 1 for a disc-like mesh.
        assert_eq!(space.len(), 2 * mesh.points().len() + mesh.cell_count() - 1);
        let f = space.interpolate(|x| 1.0 + x[0] * x[1] - 3.0 * x[1] * x[1]);
        let l = [0.2, 0.3, 0.5, 0.0];
        for c in 0..mesh.cell_count() {
            let mut x = Point::<2>::zeros();
            for (k, &v) in mesh.cell(c).iter().enumerate() {
                x += mesh.points()[v as usize] * l[k];
            }
            assert!(
                (space.value(&f, c, &l) - (1.0 + x[0] * x[1] - 3.0 * x[1] * x[1])).abs() < 1e-14
            );
            let g = space.gradient(&f, c, &l);
            assert!((g - Point::<2>::new(x[1], x[0] - 6.0 * x[1])).norm() < 1e-13);
        }
    }

    #[test]
    fn a_facet_has_three_p2_nodes_on_its_line() {
        let mesh = Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], Diagonals::Right).unwrap());
        let space = Space::new(&mesh, Element::P2);
        for &f in mesh.boundary("top").unwrap() {
            let nodes: Vec<_> = space.facet_nodes(&mesh.facets()[f as usize]).collect();
            assert_eq!(nodes.len(), 3);
            assert!(nodes.iter().all(|&n| space.nodes()[n as usize][1] == 1.0));
        }
    }
}
