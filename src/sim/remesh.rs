//! Going on with a simulation on another mesh of the same domain.

use super::setup::{LevelSet, State, Structure};
use super::step::Simulation;
use crate::base::Result;
use crate::fem::{Element, Space, Transfer, TransferMethod};
use crate::flow::FlowState;
use crate::mesh::Mesh;
use nalgebra::SVector;
use std::sync::Arc;

impl Simulation<2> {
    /// This simulation, at the same time, on `mesh`, another mesh of the same domain with the same names.
    ///
    /// Matrices, orderings and factors are made for the new mesh. What the transfer changes of the kinetic and elastic energy is added to
    /// [`Budget::transferred`](super::Budget::transferred) and stays in the residual of the energy identity. The velocity is not made free
    /// of discrete divergence on the new mesh: old velocities enter the next step through its right-hand side alone, and the step
    /// itself solves for a velocity that is.
    ///
    /// # Errors
    /// Those of [`Simulation::new`]; a mesh that does not cover the domain.
    pub fn on_mesh(&self, mesh: &Arc<Mesh<2>>, method: TransferMethod) -> Result<Simulation<2>> {
        let old = &self.state;
        let space = Space::new(mesh, Element::P2);
        let bring = Transfer::new(self.space(), &space, method)?;
        let phi = old.phi.iter().map(|phi| bring.apply(phi)).collect::<Result<Vec<_>>>()?;
        let (first, rest) = phi.split_at(self.structures.len());
        let structures = self.structures.iter().zip(first);
        let structures = structures.map(|(s, phi)| Structure { phi: phi.clone(), ..s.clone() }).collect();
        let passive =
            self.passive.iter().zip(rest).map(|(s, phi)| LevelSet { phi: phi.clone(), ..s.clone() }).collect();
        let settings = self.settings.clone();
        let mut sim = match &self.given {
            Some(velocity) => Simulation::prescribed(mesh, settings, velocity.clone(), passive)?,
            None => Simulation::new(mesh, settings, structures, |_| SVector::zeros())?.with_passive(passive)?,
        };
        let p = match (&self.flow, &sim.flow) {
            (Some(from), Some(to)) => {
                Transfer::new(from.pressure().space(), to.pressure().space(), method)?.apply(&old.flow.p)?
            }
            _ => Vec::new(),
        };
        let flow = FlowState { u: bring.apply(&old.flow.u)?, p };
        let earlier_u = if old.earlier_u.is_empty() { Vec::new() } else { bring.apply(&old.earlier_u)? };
        let stretch = old.stretch.iter().map(|s| if s.is_empty() { Ok(Vec::new()) } else { bring.apply(s) });
        let stretch = stretch.collect::<Result<Vec<_>>>()?;
        sim.state = State { flow, phi, stretch, earlier_u, ..old.clone() };
        sim.wants_reactions = self.wants_reactions;
        sim.recount_energies(old.energies.power)?;
        Ok(sim)
    }

    /// Measures the energies of the current state and books their change since they were measured last as transferred.
    fn recount_energies(&mut self, power: f64) -> Result<()> {
        let Some(mut flow) = self.flow.take() else { return Ok(()) };
        let time = self.time();
        flow.impose(time, &mut self.state.flow.u);
        self.set_materials(&mut flow, &self.state.phi);
        self.prepare_sharp()?;
        let now = super::Energies { power, ..self.measure(&flow, 0.0) };
        self.state.budget.transferred += now.total() - self.state.energies.total();
        self.state.energies = now;
        self.flow = Some(flow);
        Ok(())
    }
}
