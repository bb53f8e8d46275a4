//! Matrix-free solution with the mass matrix of a scalar space.

use super::element::MAX_LOCAL;
use super::numbering::Numbering;
use super::periodic::Translation;
use super::quadrature::Rule;
use super::space::Space;
use crate::base::{Error, Result};
use crate::mesh::NONE;
use std::sync::Arc;

/// Residual, relative to the right-hand side, at which the iteration ends.
const TOLERANCE: f64 = 1e-15;
/// Accepted residual if rounding stops the iteration.
const ENOUGH: f64 = 1e-13;
/// The scaled matrix of P2 has a condition below 8 on any mesh (Wathen 1987), so that 40 steps
/// suffice.
const STEPS: usize = 200;

/// Solves `(u, q) = m(q)` for all `q` of a space on triangles by conjugate gradients, scaled by the
/// diagonal.
pub(super) struct Mass {
    space: Arc<Space<2>>,
    unknowns: Vec<u32>,
    /// Mass matrix of a triangle of unit area.
    reference: [[f64; MAX_LOCAL]; MAX_LOCAL],
    diagonal: Vec<f64>,
}

impl Mass {
    /// Periodic nodes share their unknowns.
    pub fn new(space: &Arc<Space<2>>, translations: &[Translation<2>]) -> Mass {
        let (unknowns, order) = Numbering::scalar_unknowns(space, translations);
        let element = space.element();
        let rule = Rule::simplex(2, 2 * element.degree());
        let mut reference = [[0.0; MAX_LOCAL]; MAX_LOCAL];
        for (l, w) in rule.points.iter().zip(&rule.weights) {
            let values = element.values::<2>(l);
            for (row, a) in reference.iter_mut().zip(values) {
                row.iter_mut().zip(values).for_each(|(m, b)| *m += w * a * b);
            }
        }
        let mut mass =
            Mass { space: Arc::clone(space), unknowns, reference, diagonal: vec![0.0; order] };
        let mut diagonal = vec![0.0; order];
        mass.for_cells(|nodes, area| {
            nodes
                .iter()
                .enumerate()
                .for_each(|(a, &n)| diagonal[n as usize] += reference[a][a] * area);
        });
        mass.diagonal = diagonal;
        mass
    }

    pub fn space(&self) -> &Arc<Space<2>> {
        &self.space
    }

    /// Calls `visit` with the unknowns and the area of every cell.
    fn for_cells(&self, mut visit: impl FnMut(&[u32], f64)) {
        let mut unknowns = [NONE; MAX_LOCAL];
        for c in 0..self.space.mesh().cell_count() {
            let nodes = self.space.cell_nodes(c);
            unknowns.iter_mut().zip(nodes).for_each(|(u, &n)| *u = self.unknowns[n as usize]);
            visit(&unknowns[..nodes.len()], self.space.mesh().map(c).volume);
        }
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        self.for_cells(|unknowns, area| {
            for (row, &i) in self.reference.iter().zip(unknowns) {
                let sum: f64 = row.iter().zip(unknowns).map(|(m, &j)| m * x[j as usize]).sum();
                y[i as usize] += area * sum;
            }
        });
    }

    /// The function with the moments `m`, one per node.
    ///
    /// # Errors
    /// Computation, if the iteration does not converge.
    pub fn solve(&self, moments: &[f64]) -> Result<Vec<f64>> {
        let order = self.diagonal.len();
        let mut residual = vec![0.0; order];
        for (&u, m) in self.unknowns.iter().zip(moments).filter(|(u, _)| **u != NONE) {
            residual[u as usize] += m;
        }
        // Norms in the scaled space of the iteration.
        let scaled =
            |r: &[f64]| r.iter().zip(&self.diagonal).map(|(r, d)| r / d).collect::<Vec<f64>>();
        let (mut x, mut image) = (vec![0.0; order], vec![0.0; order]);
        let mut direction = scaled(&residual);
        let mut square = dot(&residual, &direction);
        let start = square;
        for _ in 0..STEPS {
            if square <= TOLERANCE * TOLERANCE * start {
                break;
            }
            self.multiply(&direction, &mut image);
            let step = square / dot(&direction, &image);
            x.iter_mut().zip(&direction).for_each(|(x, d)| *x += step * d);
            residual.iter_mut().zip(&image).for_each(|(r, i)| *r -= step * i);
            let next = scaled(&residual);
            let new = dot(&residual, &next);
            direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + new / square * *d);
            square = new;
        }
        if !square.is_finite() || square > ENOUGH * ENOUGH * start {
            return Err(Error::computation("a projection did not converge")
                .value(format!("residual {:e}", (square / start).sqrt()))
                .remedy(
                    "the field or the mesh holds numbers that are not finite or differ by many \
                     orders",
                ));
        }
        Ok(self.unknowns.iter().map(|&u| if u == NONE { 0.0 } else { x[u as usize] }).collect())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
