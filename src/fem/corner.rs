//! The velocity at nodes where parts of the boundary meet.

use super::condition::VelocityFunction;
use crate::mesh::Point;
use nalgebra::SVector;

/// Facets whose normals differ by less (sine of the angle) are one smooth boundary.
const SMOOTH: f64 = 0.5;

/// A facet at a node, and the velocity that its part of the boundary prescribes; `None` for zero.
#[derive(Clone)]
pub(super) struct Side<const D: usize> {
    /// Number of the condition; `None` for the walls of a mesh without conditions, and for those
    /// that slip.
    pub condition: Option<usize>,
    /// Outward unit normal.
    pub normal: SVector<f64, D>,
    /// The velocity.
    pub velocity: Option<VelocityFunction<D>>,
}

/// The velocity prescribed at a node.
///
/// At the junction of parts each keeps its own normal velocity: the lid of a driven cavity has no
/// flux through the side walls, and an inflow keeps its flux up to the wall. The remaining
/// components are those of the part of highest priority.
#[derive(Clone)]
pub(super) struct Prescribed<const D: usize> {
    /// By descending priority; a single one if all have the same condition. Not empty.
    sides: Vec<Side<D>>,
}

impl<const D: usize> Prescribed<D> {
    /// From all facets at the node, by ascending priority (those that slip first); `None` when
    /// every velocity there is zero.
    pub fn new(sides: &[Side<D>]) -> Option<Prescribed<D>> {
        let last = sides.last()?;
        if sides.iter().all(|s| s.velocity.is_none()) {
            return None;
        }
        let same = sides.iter().all(|s| s.condition == last.condition);
        let sides = if same { vec![last.clone()] } else { sides.iter().rev().cloned().collect() };
        Some(Prescribed { sides })
    }

    /// The velocity at the node, which lies at `x`, at time `t`.
    pub fn at(&self, x: &Point<D>, t: f64) -> SVector<f64, D> {
        let velocity = |s: &Side<D>| s.velocity.as_ref().map_or(SVector::zeros(), |g| g(x, t));
        let mut u = self.sides.first().map_or(SVector::zeros(), velocity);
        if self.sides.len() == 1 {
            return u;
        }
        // Orthonormal axes that span the normals, each with its component of `u`.
        let mut axes: Vec<(SVector<f64, D>, f64)> = Vec::new();
        for side in &self.sides {
            let (mut rest, mut component) = (side.normal, side.normal.dot(&velocity(side)));
            for (axis, along) in &axes {
                let share = side.normal.dot(axis);
                rest -= axis * share;
                component -= along * share;
            }
            let length = rest.norm();
            if length > SMOOTH {
                axes.push((rest / length, component / length));
            }
        }
        for (axis, component) in axes {
            u += axis * (component - u.dot(&axis));
        }
        u
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    type V = SVector<f64, 2>;

    fn side(condition: usize, normal: [f64; 2], velocity: [f64; 2]) -> Side<2> {
        let v = V::from(velocity);
        let moves = v != V::zeros();
        Side {
            condition: Some(condition),
            normal: V::from(normal).normalize(),
            velocity: moves.then(|| Arc::new(move |_: &V, _| v) as _),
        }
    }
    fn at(sides: &[Side<2>]) -> V {
        Prescribed::new(sides).map_or(V::zeros(), |p| p.at(&V::zeros(), 0.0))
    }

    #[test]
    fn parts_that_meet_keep_their_normal_velocities() {
        let (lid, wall) = (side(1, [0.0, 1.0], [1.0, 0.0]), side(0, [-1.0, 0.0], [0.0, 0.0]));
        assert_eq!(at(&[wall.clone(), lid.clone()]), V::zeros());
        let inflow = side(1, [-1.0, 0.0], [2.0, 0.0]);
        let bed = side(0, [0.0, -1.0], [0.0, 0.0]);
        // The one of higher priority.
        assert_eq!(at(&[bed.clone(), inflow.clone()]), V::new(2.0, 0.0));
        assert_eq!(at(&[inflow, bed]), V::new(2.0, 0.0));
        // An oblique wall: nothing through the lid, nothing through the wall.
        let oblique = side(2, [-1.0, -1.0], [0.0, 0.0]);
        let u = at(&[lid.clone(), oblique]);
        assert!(u.norm() < 1e-15, "{u:?}");
        // A bend of 10 degrees is no corner: the higher priority wins.
        let bend = side(2, [0.17, 0.98], [0.0, 0.0]);
        assert_eq!(at(&[bend.clone(), lid.clone()]), V::new(1.0, 0.0));
        assert_eq!(at(&[lid.clone(), bend]), V::zeros());
        // A single part, or equal conditions, keep their velocity.
        assert_eq!(at(&[side(1, [1.0, 0.0], [1.0, 0.0]), lid]), V::new(1.0, 0.0));
        assert!(Prescribed::new(&[wall]).is_none());
    }
}
