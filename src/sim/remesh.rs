//! Going on with a simulation on another mesh of the same domain.

use super::setup::{LevelSet, Pace, State, Structure};
use super::step::Simulation;
use crate::base::Result;
use crate::fem::{Element, Interpolation, Projection, Space, Translation, periodic_pairs};
use crate::flow::FlowState;
use crate::mesh::Mesh;
use nalgebra::SVector;
use std::sync::Arc;

/// How fields are brought to a new mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// The values of the old fields at the new nodes; of order 3 for P2, conserves nothing.
    Interpolation,
    /// The L2 projection over the intersections of old and new cells; conserves the integrals.
    Projection,
}

/// A [`Transfer`] from one space to another, ready for any number of fields.
enum Bring<'a> {
    Interpolation(&'a Space<2>, Interpolation),
    Projection(&'a Space<2>, Box<Projection>),
}

impl<'a> Bring<'a> {
    fn new(
        transfer: Transfer,
        from: &'a Space<2>,
        to: &Arc<Space<2>>,
        translations: &[Translation<2>],
    ) -> Result<Bring<'a>> {
        Ok(match transfer {
            Transfer::Interpolation => Bring::Interpolation(from, Interpolation::new(from.mesh(), to)?),
            Transfer::Projection => Bring::Projection(from, Box::new(Projection::new(from.mesh(), to, translations)?)),
        })
    }
    /// A field with one number a node; an empty one stays empty.
    fn scalar(&self, f: &[f64]) -> Result<Vec<f64>> {
        match self {
            _ if f.is_empty() => Ok(Vec::new()),
            Bring::Interpolation(from, places) => Ok(places.apply(from, f)),
            Bring::Projection(from, projection) => projection.scalar(from, f),
        }
    }
    fn scalars(&self, fields: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        fields.iter().map(|f| self.scalar(f)).collect()
    }
    /// A field with one vector a node; an empty one stays empty.
    fn vector(&self, f: &[SVector<f64, 2>]) -> Result<Vec<SVector<f64, 2>>> {
        match self {
            _ if f.is_empty() => Ok(Vec::new()),
            Bring::Interpolation(from, places) => Ok(places.apply(from, f)),
            Bring::Projection(from, projection) => projection.vector(from, f),
        }
    }
}

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
    pub fn on_mesh(&self, mesh: &Arc<Mesh<2>>, transfer: Transfer) -> Result<Simulation<2>> {
        let old = &self.state;
        let to = Arc::new(Space::new(mesh, Element::P2));
        let translations = periodic_pairs(mesh, &self.settings.conditions)?;
        let bring = Bring::new(transfer, self.space(), &to, &translations)?;
        let phi = bring.scalars(&old.phi)?;
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
                let (from, to) = (from.pressure().space(), to.pressure().space());
                Bring::new(transfer, from, to, &translations)?.scalar(&old.flow.p)?
            }
            _ => Vec::new(),
        };
        let flow = FlowState { u: bring.vector(&old.flow.u)?, p };
        let (stretch, earlier_u) = (bring.scalars(&old.stretch)?, bring.vector(&old.earlier_u)?);
        let displacement = bring.vector(&old.displacement)?;
        let pace = match &old.pace {
            Some(pace) => Some(Pace { earliest_u: bring.vector(&pace.earliest_u)?, ..pace.clone() }),
            None => None,
        };
        sim.state = State { flow, phi, stretch, displacement, earlier_u, pace, factored: None, ..old.clone() };
        sim.pacing.clone_from(&self.pacing);
        sim.redistancing = self.redistancing;
        if let (Some(flow), true) = (&mut sim.flow, sim.pacing.is_some()) {
            flow.expect_changes();
        }
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
