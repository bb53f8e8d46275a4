//! Energies, their rates, and forces on boundaries.

use super::{Energies, Simulation};
use crate::base::Result;
use crate::fem::{At, Cells, condition_of_facets, integrate};
use crate::flow::block::Block;
use crate::flow::term::MomentumTerm;
use crate::flow::{Load, kinetic_outflow, nodal_traction};
use crate::mesh::Point;
use crate::structure::Place;
use nalgebra::SVector;
use std::collections::BTreeSet;

/// Powers in a step.
#[derive(Clone, Copy, Default)]
pub(super) struct Powers {
    /// Of the walls on the flow.
    pub walls: f64,
    /// Of the flow on elastic structures.
    pub structures: f64,
    /// The same with each point counted positive.
    pub traffic: f64,
}

impl<const D: usize> Simulation<D> {
    /// Energies and rates of the current state, with the powers of a step.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub(super) fn measure(&mut self, powers: Powers) -> Result<Energies> {
        let [kinetic, dissipation, grad_div, div2] = self.flow.energies(&self.state.flow);
        let leaving = self.leaving_at(&self.state.fields);
        let elastic = self.elastic_energy(|k| !leaving[k])?;
        let acting = self.carried.structures.iter().zip(&leaving).filter(|(_, leaves)| !**leaves);
        let slip: f64 = acting.map(|(s, _)| s.dissipation()).sum();
        Ok(Energies {
            kinetic,
            elastic,
            dissipation: dissipation + slip,
            grad_div,
            power: powers.walls + self.body_power() - self.carried_out(),
            divergence: div2.sqrt(),
            elastic_power: powers.structures - slip,
            elastic_traffic: powers.traffic,
        })
    }

    /// Power of the flow on structures whose forces are derivatives of their energies: the sum over
    /// the points of their forces, and that of the absolute values. `u` is the new velocity and
    /// `change` what it differs by from that of the explicit part of the forces. Zero if there are
    /// other structures too.
    pub(super) fn structure_power(
        &self,
        leaving: &[bool],
        u: &[SVector<f64, D>],
        change: &[SVector<f64, D>],
    ) -> [f64; 2] {
        let acting = || self.carried.structures.iter().zip(leaving).filter(|(s, _)| s.acts());
        if acting().any(|(s, _)| !s.conserves_energy()) {
            return [0.0; 2];
        }
        let mut terms: Vec<&dyn MomentumTerm<D>> = Vec::new();
        acting().filter(|(_, leaves)| !**leaves).for_each(|(s, _)| s.terms(&mut terms));
        let (space, basis) = (self.space(), self.flow.velocity());
        let powers = |term: &&dyn MomentumTerm<D>| {
            let at_point = |at: &At<D>| {
                let (c, l) = (at.cell, &at.barycentric);
                let (v, g) = (space.value(u, c, l), space.jacobian(u, c, l));
                let (f0, f1) = term.force(at);
                let mut power = -(f0.dot(&v) + f1.dot(&g));
                if term.is_implicit() {
                    let (dv, dg) = (space.value(change, c, l), space.jacobian(change, c, l));
                    let (f0, f1) = term.stiffness(at, &dv, &dg);
                    power += f0.dot(&v) + f1.dot(&g);
                }
                [power, power.abs()]
            };
            let cells = integrate(basis, term.support().cells(), at_point);
            let of_points = term.support().points().iter().map(|at| {
                let [power, traffic] = at_point(at);
                [power * at.weight, traffic * at.weight]
            });
            of_points.fold(cells, |a, b| [a[0] + b[0], a[1] + b[1]])
        };
        let mut blocks: Vec<&dyn Block<D>> = Vec::new();
        acting().filter(|(_, leaves)| !**leaves).for_each(|(s, _)| s.blocks(&mut blocks));
        let own = match blocks.is_empty() {
            true => [0.0; 2],
            false => self.flow.block_power(&blocks, u),
        };
        terms.iter().map(powers).fold(own, |a, b| [a[0] + b[0], a[1] + b[1]])
    }

    /// Elastic energy brought by structures that have left or come back to an open side since they
    /// were `leaving` there: negative if it has left with them.
    pub(super) fn energy_at_outlets(&mut self, leaving: &[bool]) -> Result<f64> {
        let now = self.leaving_at(&self.state.fields);
        if now == leaving {
            return Ok(0.0);
        }
        let brought = self.elastic_energy(|k| leaving[k] && !now[k])?;
        Ok(brought - self.elastic_energy(|k| now[k] && !leaving[k])?)
    }

    /// Sum of the energies of the structures with these numbers.
    fn elastic_energy(&mut self, of: impl Fn(usize) -> bool) -> Result<f64> {
        let Some(fine) = &self.fine else { return Ok(0.0) };
        let at = Place::new(&self.carried.space, &self.flow, &self.state.fields, self.state.time);
        let acting =
            self.carried.structures.iter_mut().enumerate().filter(|(k, s)| s.acts() && of(*k));
        acting.map(|(_, s)| s.energy(&at, fine)).try_fold(0.0, |sum, e| Ok(sum + e?))
    }

    /// Rate of outflow of kinetic energy through the boundary.
    fn carried_out(&self) -> f64 {
        // No outflow through walls at rest; periodic sides cancel.
        let numbering = self.flow.numbering();
        let closed = !numbering.is_open() && numbering.is_homogeneous();
        if closed || self.is_stokes() || self.settings.convection.is_none() {
            return 0.0;
        }
        let density = self.density();
        kinetic_outflow(self.space(), |cell, l| density(cell, l), &self.state.flow)
    }

    /// Power of gravity and body force.
    fn body_power(&self) -> f64 {
        let gravity = self.settings.gravity;
        if gravity.norm() == 0.0 && self.settings.body_force.is_none() {
            return 0.0;
        }
        let (basis, time) = (self.flow.velocity(), self.time());
        let [power] = integrate(basis, Cells::All, |at| {
            let force = self.settings.body_force.as_ref();
            let force = force.map_or(SVector::zeros(), |f| f(&at.x, time));
            let total = gravity * self.flow.weight(at) + force;
            [total.dot(&basis.value(at, &self.state.flow.u))]
        });
        power
    }

    /// Force of the fluid on a named boundary by the residual of the momentum equation in the last
    /// step, and its moment about a point; `None` before the first. At a node that the boundary
    /// shares with another one, or with a periodic side, the residual has the stress on both: that
    /// on the other is subtracted. An open side has none.
    ///
    /// # Errors
    /// A boundary that the mesh does not have.
    pub fn reaction(&self, boundary: &str, about: &Point<D>) -> Result<Option<Load<D>>> {
        let (space, mesh) = (self.space(), self.space().mesh());
        let Some(residual) = &self.reactions else { return Ok(None) };
        let on_facet = |f: u32| space.facet_nodes(&mesh.facets()[f as usize]);
        let own = mesh.boundary(boundary)?;
        let nodes: BTreeSet<u32> = own.iter().flat_map(|&f| on_facet(f)).collect();
        let (own, mut load) = (own.iter().collect::<BTreeSet<_>>(), Load::ZERO);
        let arm = |n: u32| space.nodes()[n as usize] - about;
        nodes.iter().for_each(|&n| load.add(&arm(n), &-residual[n as usize]));
        let conditions = &self.settings.conditions;
        let open = |k: Option<usize>| k.is_some_and(|k| conditions[k].1.is_open());
        let stressed = condition_of_facets(mesh, conditions)?.into_iter().filter(|c| !open(c.1));
        let mut others: Vec<u32> = stressed.map(|c| c.0).filter(|f| !own.contains(f)).collect();
        others.retain(|f| on_facet(*f).any(|n| nodes.contains(&n)));
        let (flow, spaces) =
            (&self.state.flow, [space, self.flow.pressure().space()].map(|s| &**s));
        let shared = |n: u32| nodes.contains(&n);
        for (n, force) in nodal_traction(spaces, self.viscosity(), flow, &others, shared) {
            load.add(&arm(n), &-force);
        }
        Ok(Some(load))
    }
}
