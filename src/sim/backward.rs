//! The backward characteristics `Y` as a carried field.

use super::carrier::InitialFunction;
use super::step::Simulation;
use crate::base::{Error, Result, parallel};
use crate::elastic::SurfaceStrain;
use crate::fem::{Basis, Cells, Rule, SurfacePoint, integrate};
use crate::levelset::Bounds;
use crate::mesh::determinant;
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
    /// `Y_rest(x) - x` of interface number `k` at the nodes, for the displacement back to time 0 `displacement`: where its material is at rest. A
    /// passive interface is at rest at time 0.
    pub(super) fn rest_of<'a>(&self, k: usize, displacement: &'a [SVector<f64, D>]) -> Cow<'a, [SVector<f64, D>]> {
        let Some(map) = self.structures.get(k).and_then(|s| s.shear.as_ref()?.map()) else {
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
    /// `Y_rest(x) - x` of interface number `k` at the nodes now.
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
    /// The strain of interface number `k` at points of it: by the law of a membrane that resists shear, of any other structure since it was at
    /// rest, of a passive interface since time 0.
    pub fn surface_strain(&self, k: usize, points: &[SurfacePoint<D>]) -> Vec<SurfaceStrain<D>> {
        let (phi, rest) = (self.level_set(k), self.rest_displacement(k));
        points.iter().map(|p| self.strain_at(k, &phi, &rest, p.at.cell, &p.at.barycentric)).collect()
    }
    /// Area and shear, `Z1` and `Z2`, of the level sets of interface number `k` at the nodes, means over the cells about each; 1 farther than
    /// `reach` (a length) from it.
    pub fn nodal_strain(&self, k: usize, reach: f64) -> [Vec<f64>; 2] {
        let (phi, rest) = (self.level_set(k), self.rest_displacement(k));
        let mut sums = vec![[0.0; 3]; self.space.len()];
        for c in 0..self.space.mesh().cell_count() {
            let bounds = Bounds::of_cell(&self.space, &phi, c);
            if !bounds.meet(reach * bounds.slope) {
                continue;
            }
            let volume = self.space.mesh().map(c).volume;
            for (a, &n) in self.space.cell_nodes(c).iter().enumerate() {
                let s = self.strain_at(k, &phi, &rest, c, &self.space.element().node(a, D));
                if s.z1.is_finite() && s.z2.is_finite() {
                    let [z1, z2, sum] = &mut sums[n as usize];
                    (*z1, *z2, *sum) = (*z1 + volume * s.z1, *z2 + volume * s.z2, *sum + volume);
                }
            }
        }
        let mean = |k: usize| sums.iter().map(|s| if s[2] > 0.0 { s[k] / s[2] } else { 1.0 }).collect();
        [mean(0), mean(1)]
    }
    /// The strain of the level set `phi` of interface number `k` through a place in the mesh.
    fn strain_at(
        &self,
        k: usize,
        phi: &[f64],
        rest: &[SVector<f64, D>],
        cell: usize,
        l: &[f64; 4],
    ) -> SurfaceStrain<D> {
        let (slope, gradient) = (self.space.gradient(phi, cell, l), self.space.jacobian(rest, cell, l));
        let structure = self.structures.get(k);
        match structure.and_then(|s| s.shear.as_ref()) {
            Some(membrane) => membrane.strain(&slope, &gradient),
            None => {
                let stretch = structure.map_or(1.0, |s| s.stretch);
                SurfaceStrain::new(&slope.normalize(), &(SMatrix::identity() + gradient), stretch)
            }
        }
    }
}
