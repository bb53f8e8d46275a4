//! The way of a particle through one cell, in its barycentric coordinates.

use super::passage::Passage;
use crate::base::parallel;
use crate::fem::{Element, Space};
use crate::mesh::{Location, shifted};
use nalgebra::SVector;

/// The displacement `tau u` on one cell, with a P2 velocity `u`, as a polynomial of the free
/// barycentric coordinates: component `k - 1` is the change of `l_k`.
///
/// The same numbers as the values of `u` times the gradients of the coordinates, to rounding, at
/// half the cost.
#[derive(Clone, Debug)]
pub struct Drift<const D: usize> {
    constant: SVector<f64, D>,
    linear: [SVector<f64, D>; D],
    squares: [SVector<f64, D>; D],
    /// Of `l_k l_(k+1)`, in the order of a circle; the plane has one.
    mixed: [SVector<f64, D>; D],
}

impl<const D: usize> Default for Drift<D> {
    fn default() -> Drift<D> {
        let zero = SVector::zeros();
        Drift { constant: zero, linear: [zero; D], squares: [zero; D], mixed: [zero; D] }
    }
}

/// Number of products of two different coordinates.
const fn pairs(d: usize) -> usize {
    d * (d - 1) / 2
}

/// Places of the midpoints of the edges `(0, k)` and `(k, k + 1)` (in the order of a circle) among
/// the nodes of P2, after the vertices.
const SPOKES: [usize; 3] = [0, 2, 3];
const CIRCLE: [usize; 3] = [1, 5, 4];

impl<const D: usize> Drift<D> {
    /// The displacement over a time `tau` on cell `c`.
    #[inline]
    pub fn new(space: &Space<D>, u: &[SVector<f64, D>], tau: f64, c: usize) -> Drift<D> {
        let (nodes, inverse) = (space.cell_nodes(c), &space.mesh().map(c).inverse);
        debug_assert!(space.element() == Element::P2);
        let at = |a: usize| inverse * (u[nodes[a] as usize] * tau);
        let (constant, zero) = (at(0), SVector::zeros());
        let (mut linear, mut squares, mut mixed) = ([zero; D], [zero; D], [zero; D]);
        let (mut ends, mut spokes) = ([zero; D], [zero; D]);
        for k in 0..D {
            (ends[k], spokes[k]) = (at(k + 1), at(D + 1 + SPOKES[k]));
        }
        for k in 0..D {
            linear[k] = spokes[k] * 4.0 - constant * 3.0 - ends[k];
            squares[k] = (constant + ends[k]) * 2.0 - spokes[k] * 4.0;
        }
        for k in 0..pairs(D) {
            let middle = at(D + 1 + CIRCLE[k]);
            mixed[k] = (constant - spokes[k] - spokes[(k + 1) % D] + middle) * 4.0;
        }
        Drift { constant, linear, squares, mixed }
    }
    /// The displacement of the particle at the barycentric coordinates `l`.
    #[inline(always)]
    pub fn at(&self, l: &[f64; 4]) -> SVector<f64, D> {
        let mut d = self.constant;
        for k in 0..D {
            let mut slope = self.linear[k] + self.squares[k] * l[k + 1];
            if k < pairs(D) {
                slope += self.mixed[k] * l[(k + 1) % D + 1];
            }
            d += slope * l[k + 1];
        }
        d
    }
}

/// The drifts of all cells in one substep.
#[derive(Clone, Debug, Default)]
pub struct Drifts<const D: usize>(Vec<Drift<D>>);

impl<const D: usize> Drifts<D> {
    /// Computes those of the P2 velocity `u` in a time `tau`.
    pub fn compute(&mut self, space: &Space<D>, u: &[SVector<f64, D>], tau: f64) {
        self.0.resize(space.mesh().cell_count(), Drift::default());
        parallel::fill(&mut self.0, 1, |first, part| {
            for (i, drift) in part.iter_mut().enumerate() {
                *drift = Drift::new(space, u, tau, first + i);
            }
        });
    }
    /// Where the particle at `start` is after so many substeps of the midpoint rule, and false if the
    /// path leaves the domain, at that place.
    pub fn end(&self, passage: &Passage<D>, steps: usize, start: Location) -> (Location, bool) {
        let (drifts, mesh) = (&self.0, passage.mesh());
        let mut here = start;
        for _ in 0..steps {
            let c = here.cell as usize;
            let point =
                |l: &[f64; 4]| mesh.point_at(&Location { cell: here.cell, barycentric: *l });
            let half = drifts[c].at(&here.barycentric) * 0.5;
            let (middle, within) = shifted(&here.barycentric, &half);
            let (end, x, target) = if within {
                let (end, within) = shifted(&here.barycentric, &drifts[c].at(&middle));
                if within {
                    here.barycentric = end;
                    continue;
                }
                (end, point(&here.barycentric), point(&end))
            } else {
                let (x, mut at) = (point(&here.barycentric), here);
                passage.reach(&mut at, &middle, x, point(&middle));
                let step = drifts[at.cell as usize].at(&at.barycentric);
                let step = mesh.spanned(at.cell as usize, &step);
                let (end, _) = shifted(&here.barycentric, &(mesh.map(c).inverse * step));
                (end, x, x + step)
            };
            if !passage.reach(&mut here, &end, x, target) {
                return (here, false);
            }
        }
        (here, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Diagonals, Mesh, box_mesh, rectangle};
    use std::sync::Arc;

    /// The change of the barycentric coordinates that the value of `u` gives, at nodes and between.
    fn agrees_with_values<const D: usize>(mesh: Mesh<D>) {
        let mesh = Arc::new(mesh);
        let space = Space::new(&mesh, Element::P2);
        let noise = |i: usize, k: usize| ((i * (7 + 6 * k)) as f64).sin();
        let u: Vec<_> =
            (0..space.len()).map(|i| SVector::<f64, D>::from_fn(|k, _| noise(i, k))).collect();
        let mut drifts = Drifts::default();
        drifts.compute(&space, &u, -0.3);
        let mut between = [0.0; 4];
        for (k, l) in between[..=D].iter_mut().enumerate() {
            *l = (k + 1) as f64 / ((D + 1) * (D + 2) / 2) as f64;
        }
        let nodes = (0..space.local_count()).map(|a| Element::P2.node(a, D));
        let points: Vec<_> = nodes.chain([between]).collect();
        for c in 0..mesh.cell_count() {
            for l in &points {
                let step = space.value(&u, c, l) * -0.3;
                let drift = drifts.0[c].at(l);
                let scale = mesh.map(c).inverse.norm();
                assert!((mesh.map(c).inverse * step - drift).norm() < 1e-14 * scale, "{c} {l:?}");
                assert!((mesh.spanned(c, &drift) - step).norm() < 1e-14, "{c} {l:?}");
            }
        }
    }

    #[test]
    fn a_drift_is_the_velocity_in_barycentric_coordinates() {
        agrees_with_values(rectangle([0.0; 2], [3.0, 1.0], [3, 2], Diagonals::Right).unwrap());
        agrees_with_values(box_mesh([0.0; 3], [1.0, 2.0, 1.0], [2, 2, 1]).unwrap());
    }
}
