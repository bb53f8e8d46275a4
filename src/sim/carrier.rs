//! Carrying level sets by the method of a scene.

use crate::base::{Result, parallel};
use crate::fem::{Projector, Space};
use crate::mesh::{Location, Point};
use crate::transport::{
    CharacteristicMap, Feet, Tracer, Wind, carry_displacement_nodal, carry_displacement_projected, carry_nodal,
    carry_projected,
};
use nalgebra::SVector;
use std::sync::Arc;

/// A level set at time 0 as a function of position.
pub type InitialFunction<const D: usize> = dyn Fn(&Point<D>) -> f64 + Send + Sync;

/// A level set at time 0.
pub(super) struct Initial<const D: usize> {
    /// Its values at the nodes.
    pub nodal: Vec<f64>,
    /// The function, where it is known between the nodes.
    pub function: Option<Arc<InitialFunction<D>>>,
}

impl<const D: usize> Initial<D> {
    /// The value at a point of the mesh.
    fn value(&self, space: &Space<D>, at: &Location) -> f64 {
        match &self.function {
            Some(f) => f(&space.mesh().point_at(at)),
            None => space.value(&self.nodal, at.cell as usize, &at.barycentric),
        }
    }
    /// How deep the inside is.
    pub fn depth(&self) -> f64 {
        -self.nodal.iter().copied().fold(0.0, f64::min)
    }
    /// About the greatest slope of a distance times a stretch: that in the centres of the cells.
    pub fn slope(&self, space: &Space<D>) -> f64 {
        let mut centre = [0.0; 4];
        centre[..=D].fill(1.0 / (D + 1) as f64);
        let slopes = (0..space.mesh().cell_count()).map(|c| space.gradient(&self.nodal, c, &centre).norm());
        slopes.fold(0.0, f64::max)
    }
}

/// Moves level sets along a velocity.
pub(super) struct Carrier<const D: usize> {
    pub tracer: Tracer<D>,
    pub projector: Option<Projector<D>>,
    /// `|grad d|` of a submap beyond which the next one begins.
    pub remap: f64,
    /// All level sets at time 0, for composed transport alone.
    pub initial: Vec<Initial<D>>,
    /// Level sets at time 0 that are taken as `phi0(Y)` instead of being carried, one entry a level set; may be none at all.
    pub mapped: Vec<Option<Arc<InitialFunction<D>>>>,
    feet: Feet,
}

impl<const D: usize> Carrier<D> {
    pub fn new(tracer: Tracer<D>, projector: Option<Projector<D>>) -> Carrier<D> {
        Carrier { tracer, projector, remap: REMAP, initial: Vec::new(), mapped: Vec::new(), feet: Feet::default() }
    }
    /// Carries fields over one step by interpolation, nodal or projected, into `moved`.
    pub fn carry(&mut self, fields: &[Vec<f64>], wind: &Wind<'_, D>, dt: f64, moved: &mut Vec<Vec<f64>>) -> Result<()> {
        match &self.projector {
            Some(projector) => self.tracer.feet_of_quadrature(wind, dt, projector.basis(), &mut self.feet),
            None => self.tracer.feet_of_nodes(wind, dt, &mut self.feet),
        }
        moved.resize_with(fields.len(), Vec::new);
        for (phi, out) in fields.iter().zip(moved) {
            out.resize(phi.len(), 0.0);
            match &mut self.projector {
                Some(projector) => carry_projected(projector, phi, &self.feet, out)?,
                None => carry_nodal(self.tracer.space(), phi, &self.feet, out),
            }
        }
        Ok(())
    }
    /// Carries the displacement `Y(x) - x` with the feet that [`carry`](Self::carry) has just found: `Y` of the foot, less the node. Through
    /// a periodic side it goes on without a jump.
    pub fn carry_displacement(&mut self, field: &[SVector<f64, D>], moved: &mut Vec<SVector<f64, D>>) -> Result<()> {
        if field.is_empty() {
            return Ok(());
        }
        moved.resize(field.len(), SVector::zeros());
        match &mut self.projector {
            Some(projector) => carry_displacement_projected(&self.tracer, projector, field, &self.feet, moved),
            None => {
                carry_displacement_nodal(&self.tracer, field, &self.feet, moved);
                Ok(())
            }
        }
    }
    /// Sets level sets to `phi0(Y)` where that was asked for; `displacement` is `Y(x) - x`.
    pub fn map_level_sets(&self, displacement: &[SVector<f64, D>], level_sets: &mut [Vec<f64>]) {
        let nodes = self.tracer.space().nodes();
        for (f, phi) in self.mapped.iter().zip(level_sets) {
            let Some(f) = f else { continue };
            parallel::fill(phi, 1, |first, part| {
                let at = |n: usize| f(&(nodes[n] + displacement[n]));
                part.iter_mut().enumerate().for_each(|(i, v)| *v = at(first + i));
            });
        }
    }
    /// The displacement `Y(x) - x` of the backward map.
    pub fn displacement(&self, map: &CharacteristicMap<D>, out: &mut [SVector<f64, D>]) {
        let (mesh, nodes) = (self.tracer.space().mesh(), self.tracer.space().nodes());
        parallel::fill(out, 1, |first, part| {
            let at = |n: usize| mesh.point_at(&map.foot(&self.tracer, self.tracer.home(n))) - nodes[n];
            part.iter_mut().enumerate().for_each(|(i, v)| *v = at(first + i));
        });
    }
    /// The backward map one step later.
    pub fn advance(&mut self, map: &mut CharacteristicMap<D>, wind: &Wind<'_, D>, dt: f64) {
        self.tracer.feet_of_nodes(wind, dt, &mut self.feet);
        map.advance(&self.tracer, &self.feet);
    }
    /// Level set number `k` at the nodes, by the backward map.
    pub fn composed(&self, map: &CharacteristicMap<D>, k: usize) -> Vec<f64> {
        let (space, initial) = (self.tracer.space(), &self.initial[k]);
        let mut out = vec![0.0; space.len()];
        map.carry(&self.tracer, |at| initial.value(space, at), &mut out);
        out
    }
    /// Level set number `k` anywhere, by the backward map, and a bound of its slope when that of the initial one is `slope`.
    pub fn sample(&self, map: &CharacteristicMap<D>, k: usize, slope: f64, at: &Location) -> (f64, f64) {
        let (foot, gradient) = map.foot_and_gradient(&self.tracer, *at);
        (self.initial[k].value(self.tracer.space(), &foot), slope * gradient.norm())
    }
}

/// The steepest displacement that a submap may have when the scene does not say (tests/convergence/README.md, "The vortex").
pub const REMAP: f64 = 1.0;
