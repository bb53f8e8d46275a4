//! Transport of all fields by one method.

use super::fields::{Carry, Data, Fields, InitialFunction, Rule};
use crate::base::{Result, parallel};
use crate::fem::{Projector, Space};
use crate::mesh::Location;
use crate::transport::{
    AdvectingVelocity, CharacteristicMap, Feet, Tracer, carry_displacement_nodal,
    carry_displacement_projected, carry_nodal, carry_projected,
};
use nalgebra::SVector;
use std::sync::Arc;

/// Default largest gradient of the displacement of a submap (tests/convergence/README.md, "The
/// vortex").
pub const REMAP: f64 = 1.0;

/// A level set at time 0, for composed transport.
struct Initial<const D: usize> {
    nodal: Vec<f64>,
    function: Option<Arc<InitialFunction<D>>>,
}

impl<const D: usize> Initial<D> {
    fn value(&self, space: &Space<D>, at: &Location) -> f64 {
        match &self.function {
            Some(f) => f(&space.mesh().point_at(at)),
            None => space.value(&self.nodal, at.cell as usize, &at.barycentric),
        }
    }
}

/// Transports fields with a velocity.
pub struct Carrier<const D: usize> {
    /// Finds the feet of characteristics.
    pub tracer: Tracer<D>,
    /// Mass matrix of projected transport.
    pub projector: Option<Projector<D>>,
    /// `|grad d|` of a submap beyond which the next one begins.
    pub remap: f64,
    /// Convected fields at time 0 by index, for composed transport; `None` for other fields.
    initial: Vec<Option<Initial<D>>>,
    feet: Feet,
}

impl<const D: usize> Carrier<D> {
    /// Nodal or projected transport.
    pub fn new(tracer: Tracer<D>, projector: Option<Projector<D>>) -> Carrier<D> {
        Carrier { tracer, projector, remap: REMAP, initial: Vec::new(), feet: Feet::default() }
    }

    /// Starts composed transport at time 0: convected fields are then evaluated by the backward
    /// map. Fields without effect on the flow are evaluated on demand, and lose their nodal values.
    pub fn compose(&mut self, fields: &mut Fields<D>, rules: &[Rule<D>]) {
        let initial = |(field, rule): (&mut super::Field<D>, &Rule<D>)| {
            let (Data::Scalar(nodal), Carry::Convected(function)) = (&mut field.data, &rule.carry)
            else {
                return None;
            };
            let kept = if rule.acts { nodal.clone() } else { std::mem::take(nodal) };
            Some(Initial { nodal: kept, function: function.clone() })
        };
        self.initial = fields.iter_mut().zip(rules).map(initial).collect();
        if self.initial.iter().any(Option::is_some) {
            let nodes = self.tracer.space().len();
            fields.map.get_or_insert_with(|| CharacteristicMap::identity(nodes));
        }
    }

    /// Carries the fields `from` over one step into `to`. With `ahead`, a prediction, only fields
    /// with an effect on the flow are carried, and no submap is started.
    ///
    /// # Errors
    /// A projection that fails.
    pub fn carry(
        &mut self,
        (from, rules): (&Fields<D>, &[Rule<D>]),
        advecting: &AdvectingVelocity<'_, D>,
        dt: f64,
        ahead: bool,
        to: &mut Fields<D>,
    ) -> Result<()> {
        to.clone_from(from);
        match &mut to.map {
            Some(map) => {
                self.tracer.feet_of_nodes(advecting, dt, &mut self.feet);
                map.advance(&self.tracer, &self.feet);
                if !ahead {
                    map.restart_beyond(self.tracer.space(), self.remap);
                }
            }
            None => self.find_feet(advecting, dt),
        }
        let map = to.map.take();
        for (k, (field, rule)) in to.iter_mut().zip(rules).enumerate() {
            if ahead && !rule.acts {
                continue;
            }
            let before = from.iter().nth(k).map(|f| &f.data);
            match (&mut field.data, before, &rule.carry) {
                (Data::Scalar(out), Some(Data::Scalar(f)), Carry::Convected(_)) => {
                    match (&map, self.initial.get(k).and_then(Option::as_ref)) {
                        (Some(map), Some(initial)) if rule.acts => {
                            self.compose_into(map, initial, out)
                        }
                        (Some(_), Some(_)) => {}
                        _ => self.carry_scalar(f, out)?,
                    }
                }
                (Data::Vector(out), Some(Data::Vector(d)), Carry::BackwardMap) => match &map {
                    Some(map) => self.displacement(map, out),
                    None => self.carry_displacement(d, out)?,
                },
                _ => {}
            }
        }
        to.map = map;
        self.evaluate_mapped(rules, to);
        Ok(())
    }

    /// Finds the feet for the following calls of [`carry_scalar`](Self::carry_scalar).
    pub fn find_feet(&mut self, advecting: &AdvectingVelocity<'_, D>, dt: f64) {
        match &self.projector {
            Some(p) => self.tracer.feet_of_quadrature(advecting, dt, p.basis(), &mut self.feet),
            None => self.tracer.feet_of_nodes(advecting, dt, &mut self.feet),
        }
    }
    /// Carries nodal values with the feet found last, by interpolation or projection.
    ///
    /// # Errors
    /// A projection that fails.
    pub fn carry_scalar(&mut self, f: &[f64], out: &mut [f64]) -> Result<()> {
        match &mut self.projector {
            Some(projector) => carry_projected(projector, f, &self.feet, out),
            None => {
                carry_nodal(self.tracer.space(), f, &self.feet, out);
                Ok(())
            }
        }
    }
    /// Carries the displacement `Y(x) - x`: `Y` at the foot, minus the node. It is continuous
    /// through periodic sides.
    fn carry_displacement(
        &mut self,
        d: &[SVector<f64, D>],
        out: &mut [SVector<f64, D>],
    ) -> Result<()> {
        match &mut self.projector {
            Some(p) => carry_displacement_projected(&self.tracer, p, d, &self.feet, out),
            None => {
                carry_displacement_nodal(&self.tracer, d, &self.feet, out);
                Ok(())
            }
        }
    }
    /// The displacement `Y(x) - x` of the chain of submaps.
    fn displacement(&self, map: &CharacteristicMap<D>, out: &mut [SVector<f64, D>]) {
        let (mesh, nodes) = (self.tracer.space().mesh(), self.tracer.space().nodes());
        parallel::fill(out, 1, |first, part| {
            let foot = |n: usize| map.foot(&self.tracer, self.tracer.node_location(n));
            let at = |n: usize| mesh.point_at(&foot(n)) - nodes[n];
            part.iter_mut().enumerate().for_each(|(i, v)| *v = at(first + i));
        });
    }
    /// Evaluates level sets of the form `phi0(Y)`, (2.5).
    fn evaluate_mapped(&self, rules: &[Rule<D>], fields: &mut Fields<D>) {
        let nodes = self.tracer.space().nodes();
        for k in 0..rules.len() {
            let Carry::OfBackwardMap(f) = &rules[k].carry else { continue };
            let displacement = fields.displacement().to_vec();
            let Some(Data::Scalar(phi)) = fields.iter_mut().nth(k).map(|f| &mut f.data) else {
                continue;
            };
            parallel::fill(phi, 1, |first, part| {
                let at = |n: usize| f(&(nodes[n] + displacement[n]));
                part.iter_mut().enumerate().for_each(|(i, v)| *v = at(first + i));
            });
        }
    }
    fn compose_into(&self, map: &CharacteristicMap<D>, initial: &Initial<D>, out: &mut Vec<f64>) {
        let space = self.tracer.space();
        out.resize(space.len(), 0.0);
        map.carry(&self.tracer, |at| initial.value(space, at), out);
    }

    /// Nodal values of field number `k` by the backward map; `None` without composed transport.
    pub fn composed(&self, map: &CharacteristicMap<D>, k: usize) -> Option<Vec<f64>> {
        let initial = self.initial.get(k)?.as_ref()?;
        let mut out = Vec::new();
        self.compose_into(map, initial, &mut out);
        Some(out)
    }
    /// Value of field number `k` at any location by the backward map, and a bound of its slope if
    /// that of the initial field is `slope`.
    pub fn sample(
        &self,
        map: &CharacteristicMap<D>,
        k: usize,
        slope: f64,
        at: &Location,
    ) -> (f64, f64) {
        let (foot, gradient) = map.foot_and_gradient(&self.tracer, *at);
        let initial = self.initial.get(k).and_then(Option::as_ref);
        let value = initial.map_or(f64::NAN, |f| f.value(self.tracer.space(), &foot));
        (value, slope * gradient.norm())
    }
    /// Depth of the inside and largest slope (at the cell centres) of composed field number `k` at
    /// time 0.
    pub fn initial_depth_and_slope(&self, k: usize) -> Option<[f64; 2]> {
        let nodal = &self.initial.get(k)?.as_ref()?.nodal;
        let space = self.tracer.space();
        let mut centre = [0.0; 4];
        centre[..=D].fill(1.0 / (D + 1) as f64);
        let slopes =
            (0..space.mesh().cell_count()).map(|c| space.gradient(nodal, c, &centre).norm());
        let depth = -nodal.iter().copied().fold(0.0, f64::min);
        Some([depth, slopes.fold(0.0, f64::max)])
    }
}
