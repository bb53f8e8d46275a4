//! The backward characteristics `Y` as a carried field.

use super::carrier::InitialFunction;
use super::step::Simulation;
use crate::base::{Error, Result, parallel};
use crate::fem::{Basis, Cells, Rule, SurfacePoint, integrate};
use crate::mesh::{Point, determinant};
use crate::transport::CharacteristicMap;
use nalgebra::{SMatrix, SVector};
use std::borrow::Cow;
use std::sync::Arc;

/// Degree of the rule for the determinant of `grad Y`, whose square is of degree 6 in space.
const DEGREE: usize = 6;

impl<const D: usize> Simulation<D> {
    /// From now on, at time 0, carries the backward characteristics (2.2) as the displacement `Y(x) - x`.
    pub fn carry_backward_map(&mut self) {
        self.state.displacement = vec![SVector::zeros(); self.space.len()];
    }
    /// Whether the backward characteristics are carried.
    pub fn has_backward_map(&self) -> bool {
        !self.state.displacement.is_empty()
    }
    /// Takes level sets as `phi0(Y)`, (2.5), in place of carrying them: `functions` are those at time 0, one a level set of a structure.
    ///
    /// # Errors
    /// Backward characteristics that are not carried, periodic sides (a particle that has passed one has left the domain of `phi0`).
    pub fn map_level_sets(&mut self, functions: Vec<Option<Arc<InitialFunction<D>>>>) -> Result<()> {
        if !self.has_backward_map() {
            return Err(Error::scene("a level set can be taken as phi0(Y) only where Y is carried")
                .remedy("give a membrane a law of shear, or carry the level set"));
        }
        if !self.translations.is_empty() {
            return Err(Error::scene("a level set cannot be taken as phi0(Y) where particles pass periodic sides")
                .remedy("carry the level set"));
        }
        self.carrier.mapped = functions;
        Ok(())
    }
    /// `Y_rest(x) - x` of structure number `k` at the nodes, for the displacement back to time 0 `displacement`: where its material is at rest.
    pub(super) fn rest_of<'a>(&self, k: usize, displacement: &'a [SVector<f64, D>]) -> Cow<'a, [SVector<f64, D>]> {
        let Some(map) = self.structures[k].shear.as_ref().and_then(|s| s.map()) else {
            return Cow::Borrowed(displacement);
        };
        let nodes = self.space.nodes();
        let mut rest = vec![SVector::zeros(); nodes.len()];
        parallel::fill(&mut rest, 1, |first, part| {
            for (i, v) in part.iter_mut().enumerate() {
                let x = &nodes[first + i];
                *v = map(&(x + displacement[first + i])) - x;
            }
        });
        Cow::Owned(rest)
    }
    /// `Y_rest(x) - x` of structure number `k` at the nodes now.
    pub fn rest_displacement(&self, k: usize) -> Cow<'_, [SVector<f64, D>]> {
        self.rest_of(k, &self.state.displacement)
    }
    /// The displacement of the chain of submaps of composed transport, where it is wanted.
    pub(super) fn compose_displacement(&self, map: &CharacteristicMap<D>, out: &mut Vec<SVector<f64, D>>) {
        out.resize(self.state.displacement.len(), SVector::zeros());
        if !out.is_empty() {
            self.carrier.displacement(map, out);
        }
    }
    /// Root mean square of `det grad Y - 1` over the domain, (5.21) of the paper, (3.68) of the book: zero in a flow without divergence.
    pub fn determinant_error(&self) -> f64 {
        let basis = Basis::new(&self.space, &Arc::new(Rule::simplex(D, DEGREE)));
        let square = |gradient: SMatrix<f64, D, D>| (determinant(&(SMatrix::identity() + gradient)) - 1.0).powi(2);
        let [sum] = integrate(&basis, Cells::All, |at| [square(basis.jacobian(at, &self.state.displacement))]);
        (sum / self.space.mesh().volume()).sqrt()
    }
    /// The same over an interface, given by its quadrature points.
    pub fn determinant_error_on(&self, interface: &[SurfacePoint<D>]) -> f64 {
        let mut sums = [0.0; 2];
        for p in interface {
            let (cell, l) = (p.at.cell, &p.at.barycentric);
            let gradient = self.space.jacobian(&self.state.displacement, cell, l);
            let error = determinant(&(SMatrix::identity() + gradient)) - 1.0;
            sums = [sums[0] + p.at.weight * error * error, sums[1] + p.at.weight];
        }
        (sums[0] / sums[1]).sqrt()
    }
    /// Where the particle at node `n` was at time 0.
    pub fn origin(&self, n: usize) -> Point<D> {
        self.space.nodes()[n] + self.state.displacement[n]
    }
}
