//! The backward map of the flow as a chain of short maps (characteristic mapping; Mercier, Yin and
//! Nave 2020).

use super::feet::{Feet, Tracer};
use crate::base::parallel;
use crate::fem::Space;
use crate::mesh::{Location, determinant};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// A submap, stored as the displacement `d` of `x + d(x)`, a P2 function.
type Submap<const D: usize> = Vec<SVector<f64, D>>;

/// The backward map `Y`: `Y(x)` is the position at time 0 of the particle that is at `x` now,
/// (2.2).
///
/// `Y = Y_1 o Y_2 o ... o Y_k` with submaps `Y_j(x) = x + d_j(x)`, each a P2 displacement over a
/// short time. Only the last one is advanced: `d_k <- X - x + d_k o X` with the feet `X` of a step.
/// When its gradient is too large for the elements it is closed, and a new submap starts with
/// `d = 0`. A field `f = f_0 o Y` is thus never interpolated; only maps near the identity are.
///
/// Limits: no inflow, because a particle that was outside at time 0 has no value. Each submap costs
/// one vector field of memory, and one walk through the mesh per evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacteristicMap<const D: usize> {
    /// In order of time; never empty.
    submaps: Vec<Arc<Submap<D>>>,
}

impl<const D: usize> CharacteristicMap<D> {
    /// The identity on a space of `nodes` nodes.
    pub fn identity(nodes: usize) -> CharacteristicMap<D> {
        CharacteristicMap { submaps: vec![Arc::new(vec![SVector::zeros(); nodes])] }
    }
    /// A map from its displacements, in order of time; `None` if there are none.
    pub fn from_submaps(submaps: Vec<Vec<SVector<f64, D>>>) -> Option<CharacteristicMap<D>> {
        (!submaps.is_empty())
            .then(|| CharacteristicMap { submaps: submaps.into_iter().map(Arc::new).collect() })
    }
    /// The displacements of the submaps, in order of time.
    pub fn submaps(&self) -> impl ExactSizeIterator<Item = &[SVector<f64, D>]> {
        self.submaps.iter().map(|s| s.as_slice())
    }
    /// Advances the map by a step whose feet at the nodes are given.
    pub fn advance(&mut self, tracer: &Tracer<D>, feet: &Feet) {
        let Some(last) = self.submaps.last_mut() else { return };
        let space = tracer.space();
        let mut next = vec![SVector::zeros(); space.len()];
        parallel::fill(&mut next, 1, |first, part| {
            for (i, d) in part.iter_mut().enumerate() {
                let foot = feet.get(first + i);
                let start = space.mesh().point_at(&tracer.node_location(first + i));
                let step = tracer.unwrapped(space.mesh().point_at(foot) - start);
                *d = step + space.value(last, foot.cell as usize, &foot.barycentric);
            }
        });
        *last = Arc::new(next);
    }
    /// Starts a new submap if `|grad d|` (Frobenius) of the last exceeds `largest` at a vertex of a
    /// cell.
    pub fn restart_beyond(&mut self, space: &Space<D>, largest: f64) {
        let steep = self.submaps.last().is_some_and(|d| steepest(space, d) > largest);
        if steep {
            self.submaps.push(Arc::new(vec![SVector::zeros(); space.len()]));
        }
    }
    /// `Y` at a point.
    pub fn foot(&self, tracer: &Tracer<D>, at: Location) -> Location {
        self.submaps.iter().rev().fold(at, |at, d| {
            tracer.displaced(at, tracer.space().value(d, at.cell as usize, &at.barycentric))
        })
    }
    /// `Y` and `grad Y` at a point (row `i`, column `j` is `d Y_i / d x_j`).
    pub fn foot_and_gradient(
        &self,
        tracer: &Tracer<D>,
        at: Location,
    ) -> (Location, SMatrix<f64, D, D>) {
        self.submaps.iter().rev().fold((at, SMatrix::identity()), |(at, product), d| {
            let (space, cell, l) = (tracer.space(), at.cell as usize, &at.barycentric);
            let gradient = SMatrix::identity() + space.jacobian(d, cell, l);
            (tracer.displaced(at, space.value(d, cell, l)), gradient * product)
        })
    }
    /// `f o Y` at the nodes.
    pub fn carry(&self, tracer: &Tracer<D>, f: impl Fn(&Location) -> f64 + Sync, out: &mut [f64]) {
        parallel::fill(out, 1, |first, part| {
            for (i, v) in part.iter_mut().enumerate() {
                *v = f(&self.foot(tracer, tracer.node_location(first + i)));
            }
        });
    }
    /// Root mean square of `det grad Y - 1` over the cell centres: zero in a divergence-free flow,
    /// hence an error estimate of the map without a second run, (3.68).
    pub fn determinant_error(&self, tracer: &Tracer<D>) -> f64 {
        let mesh = tracer.space().mesh();
        let mut centre = [0.0; 4];
        centre[..=D].fill(1.0 / (D + 1) as f64);
        let [sum] = parallel::sum(mesh.cell_count(), |c| {
            let at = Location { cell: c as u32, barycentric: centre };
            let (_, gradient) = self.foot_and_gradient(tracer, at);
            [mesh.map(c).volume * (determinant(&gradient) - 1.0).powi(2)]
        });
        (sum / mesh.volume()).sqrt()
    }
    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.submaps.iter().map(|s| size_of_val(s.as_slice())).sum()
    }
}

/// Largest Frobenius norm of the gradient at the vertices of the cells; the gradient is linear in a
/// cell, so this is its maximum.
fn steepest<const D: usize>(space: &Space<D>, d: &[SVector<f64, D>]) -> f64 {
    let in_cell = |c: usize| {
        let vertices =
            (0..=D).map(|k| space.jacobian(d, c, &space.element().node(k, D)).norm_squared());
        vertices.fold(0.0, f64::max)
    };
    let cells = space.mesh().cell_count();
    let mut squares = vec![0.0; cells];
    parallel::fill(&mut squares, 1, |first, part| {
        part.iter_mut().enumerate().for_each(|(i, v)| *v = in_cell(first + i));
    });
    squares.into_iter().fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, Point, rectangle};

    /// The shear `u = (y, 0)`; fluid that enters stays within three cells of the sides.
    fn sheared(restart: f64, steps: usize) -> (Tracer<2>, CharacteristicMap<2>) {
        let mesh = Arc::new(rectangle([-2.0; 2], [2.0; 2], [16, 16], Diagonals::Right).unwrap());
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let tracer = Tracer::new(&space, &[]);
        let u = space.interpolate(|x| Point::<2>::new(x[1], 0.0));
        let mut map = CharacteristicMap::identity(space.len());
        let mut feet = Feet::default();
        for _ in 0..steps {
            tracer.from_nodes(&u, 0.1, &mut feet);
            map.advance(&tracer, &feet);
            map.restart_beyond(&space, restart);
        }
        (tracer, map)
    }

    #[test]
    fn a_shear_is_mapped_back_exactly_with_one_submap_and_with_many() {
        for (restart, one) in [(10.0, true), (0.25, false)] {
            let (tracer, map) = sheared(restart, 4);
            assert_eq!(map.submaps().len() == 1, one);
            for x in [[0.3, 0.4], [-0.7, -0.2], [0.1, 0.9]].map(Point::<2>::from) {
                let at = tracer.locate(&x).unwrap();
                let (foot, gradient) = map.foot_and_gradient(&tracer, at);
                let exact = Point::<2>::new(x[0] - 0.4 * x[1], x[1]);
                let error = (tracer.space().mesh().point_at(&foot) - exact).norm();
                assert!(error < 1e-14, "{error:e}");
                let shear = SMatrix::<f64, 2, 2>::new(1.0, -0.4, 0.0, 1.0);
                assert!((gradient - shear).norm() < 1e-13, "{gradient}");
            }
        }
    }

    #[test]
    fn a_carried_function_is_the_first_one_at_the_feet() {
        let (tracer, map) = sheared(10.0, 3);
        let (space, mesh) = (tracer.space(), tracer.space().mesh());
        let mut carried = vec![0.0; space.len()];
        // No polynomial: nothing of it is interpolated.
        let f = |x: Point<2>| (3.0 * x[0]).sin() + x[1].exp();
        map.carry(&tracer, |at| f(mesh.point_at(at)), &mut carried);
        for (x, v) in space.nodes().iter().zip(&carried).filter(|(x, _)| x.norm() < 1.0) {
            let exact = f(Point::<2>::new(x[0] - 0.3 * x[1], x[1]));
            assert!((v - exact).abs() < 1e-13, "{x} {v} {exact}");
        }
    }
}
