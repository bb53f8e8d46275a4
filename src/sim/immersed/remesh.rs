//! Continuation of a simulation on another mesh of the same domain.

use super::measure::Powers;
use super::{Energies, Simulation};
use crate::base::Result;
use crate::fem::{Element, Space, periodic_pairs};
use crate::flow::FlowState;
use crate::mesh::Mesh;
use crate::sim::State;
use crate::sim::transfer::{Bring, Transfer};
use std::sync::Arc;

impl Simulation<2> {
    /// This simulation at the same time on `mesh`, another mesh of the same domain with the same
    /// names.
    ///
    /// Matrices, orderings and factors are those of the new mesh. The change of kinetic and elastic
    /// energy by the transfer is added to
    /// [`EnergyBalance::transferred`](crate::sim::EnergyBalance::transferred) and stays in the
    /// residual of the energy balance. The velocity is not projected to discretely divergence-free
    /// functions on the new mesh: old velocities enter the next step through its right-hand side
    /// only, and the step computes a divergence-free velocity.
    ///
    /// # Errors
    /// Those of [`Simulation::new`]; a mesh that does not cover the domain.
    pub fn on_mesh(&self, mesh: &Arc<Mesh<2>>, transfer: Transfer) -> Result<Simulation<2>> {
        let old = &self.state;
        let to = Arc::new(Space::new(mesh, Element::P2));
        let links = periodic_pairs(mesh, &self.settings.conditions)?;
        let bring = Bring::new(transfer, self.space(), &to, &links)?;
        let structures = self.structures().iter().map(|s| s.boxed()).collect();
        let fields = bring.fields(&old.fields)?;
        let mut sim = Simulation::build(mesh, self.settings.clone(), structures, &fields)?;
        let (from, to) = (self.flow.pressure().space(), sim.flow.pressure().space());
        let p = Bring::new(transfer, from, to, &links)?.scalar(&old.flow.p)?;
        let earliest_u = match old.earliest_u.is_empty() {
            true => Vec::new(),
            false => bring.vector(&old.earliest_u)?,
        };
        sim.state = State {
            steps: old.steps,
            time: old.time,
            pace: old.pace,
            flow: FlowState { u: bring.vector(&old.flow.u)?, p },
            earlier_u: bring.vector(&old.earlier_u)?,
            earliest_u,
            fields: sim.state.fields,
            factored: None,
            energies: old.energies,
            balance: old.balance,
        };
        sim.pacing.clone_from(&self.pacing);
        sim.carried.redistancing = self.carried.redistancing;
        if sim.pacing.is_some() {
            sim.flow.expect_changes();
        }
        sim.keeps_reactions = self.keeps_reactions;
        sim.recount_energies()?;
        Ok(sim)
    }

    /// Computes the energies of the current state and adds their change since the last step to the
    /// transferred energy.
    fn recount_energies(&mut self) -> Result<()> {
        let time = self.time();
        self.flow.impose(time, &mut self.state.flow.u);
        self.set_materials_now();
        self.prepare_now()?;
        let before = self.state.energies;
        let Energies { power, elastic_power, elastic_traffic, .. } = before;
        let now =
            Energies { power, elastic_power, elastic_traffic, ..self.measure(Powers::default())? };
        self.state.balance.transferred += now.total() - before.total();
        self.state.energies = now;
        Ok(())
    }
}
