//! The Lagrange elements P1 and P2 on a simplex, in barycentric coordinates.

use nalgebra::SVector;

/// Largest number of local basis functions: P2 on a tetrahedron.
pub const MAX_LOCAL: usize = 10;

/// The edges of a simplex in the order of VTK's quadratic cells; the first 3 are those of a
/// triangle.
pub const EDGES: [(usize, usize); 6] = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)];

/// An element: Lagrange, or Lagrange with a constant per cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Element {
    /// Continuous, linear: one node per vertex.
    P1,
    /// Continuous, quadratic: vertices, then the midpoints of the edges in the order of [`EDGES`].
    P2,
    /// P1 plus a constant per cell, discontinuous: vertices, then the cell. Not nodal: a value is
    /// the sum of both, and constants are represented twice.
    P1P0,
}

impl Element {
    /// Number of basis functions on a cell of dimension `d`.
    pub const fn local_count(self, d: usize) -> usize {
        match self {
            Element::P1 => d + 1,
            Element::P2 => (d + 1) * (d + 2) / 2,
            Element::P1P0 => d + 2,
        }
    }
    /// Polynomial degree.
    pub const fn degree(self) -> usize {
        match self {
            Element::P1 | Element::P1P0 => 1,
            Element::P2 => 2,
        }
    }
    /// Values of all basis functions at the barycentric coordinates `l` (entries `0..=D`).
    #[inline]
    pub fn values<const D: usize>(self, l: &[f64; 4]) -> [f64; MAX_LOCAL] {
        let mut n = [0.0; MAX_LOCAL];
        match self {
            Element::P1 => n[..=D].copy_from_slice(&l[..=D]),
            Element::P1P0 => {
                n[..=D].copy_from_slice(&l[..=D]);
                n[D + 1] = 1.0;
            }
            Element::P2 => {
                for k in 0..=D {
                    n[k] = l[k] * (2.0 * l[k] - 1.0);
                }
                for (e, &(i, j)) in EDGES[..D * (D + 1) / 2].iter().enumerate() {
                    n[D + 1 + e] = 4.0 * l[i] * l[j];
                }
            }
        }
        n
    }
    /// Gradients of all basis functions with respect to the free barycentric coordinates
    /// `(l_1, .., l_D)`, with `l_0 = 1 - l_1 - .. - l_D`.
    #[inline]
    pub fn reference_gradients<const D: usize>(self, l: &[f64; 4]) -> [SVector<f64, D>; MAX_LOCAL] {
        let mut g = [SVector::<f64, D>::zeros(); MAX_LOCAL];
        // d N / d l_k in the free coordinates.
        let mut add = |n: usize, k: usize, v: f64| {
            if k == 0 {
                g[n].add_scalar_mut(-v);
            } else {
                g[n][k - 1] += v;
            }
        };
        match self {
            Element::P1 | Element::P1P0 => (0..=D).for_each(|k| add(k, k, 1.0)),
            Element::P2 => {
                for k in 0..=D {
                    add(k, k, 4.0 * l[k] - 1.0);
                }
                for (e, &(i, j)) in EDGES[..D * (D + 1) / 2].iter().enumerate() {
                    add(D + 1 + e, i, 4.0 * l[j]);
                    add(D + 1 + e, j, 4.0 * l[i]);
                }
            }
        }
        g
    }
    /// Barycentric coordinates of node `a`; that of a cell is its centre.
    pub fn node(self, a: usize, d: usize) -> [f64; 4] {
        let mut l = [0.0; 4];
        if a <= d {
            l[a] = 1.0;
        } else if self == Element::P1P0 {
            l[..=d].fill(1.0 / (d as f64 + 1.0));
        } else {
            let (i, j) = EDGES[a - d - 1];
            l[i] = 0.5;
            l[j] = 0.5;
        }
        l
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn barycentric(d: usize, r: [f64; 4]) -> [f64; 4] {
        let s: f64 = r[..=d].iter().sum();
        let mut l = [0.0; 4];
        for k in 0..=d {
            l[k] = r[k] / s;
        }
        l
    }

    /// Nodality, partition of unity, derivative against difference, at random points.
    fn check<const D: usize>(e: Element, r: [f64; 4]) {
        let n = e.local_count(D);
        for a in 0..n {
            let v = e.values::<D>(&e.node(a, D));
            for b in 0..n {
                assert_eq!(v[b], if a == b { 1.0 } else { 0.0 }, "nodality of {e:?}");
            }
        }
        let l = barycentric(D, r);
        let (v, g) = (e.values::<D>(&l), e.reference_gradients::<D>(&l));
        assert!((v[..n].iter().sum::<f64>() - 1.0).abs() < 1e-14);
        let sum = g[..n].iter().fold(SVector::<f64, D>::zeros(), |s, x| s + x);
        assert!(sum.norm() < 1e-13);
        for k in 0..D {
            let step = 1e-6;
            let moved = |s: f64| {
                let mut m = l;
                m[k + 1] += s;
                m[0] -= s;
                e.values::<D>(&m)
            };
            let (p, m) = (moved(step), moved(-step));
            for a in 0..n {
                assert!(((p[a] - m[a]) / (2.0 * step) - g[a][k]).abs() < 1e-8);
            }
        }
    }

    proptest! {
        #[test]
        fn every_element_obeys_the_rules(r in prop::array::uniform4(0.01..1.0f64)) {
            for e in [Element::P1, Element::P2] {
                check::<2>(e, r);
                check::<3>(e, r);
            }
        }
    }
}
