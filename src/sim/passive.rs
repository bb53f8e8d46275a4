//! Level sets that act on nothing, in a flow or in a prescribed velocity, and how composed level sets are read.

use super::budget::{Budget, Energies};
use super::carrier::{Carrier, Initial, InitialFunction};
use super::markers;
use super::setup::{LevelSet, Settings, State};
use super::step::Simulation;
use crate::base::{Error, Phase, Result};
use crate::fem::{Basis, Element, Projector, Rule, Space, VelocityFunction, periodic_pairs};
use crate::flow::{FlowState, StepReport};
use crate::levelset::{Interface, Sample};
use crate::linalg::SolveReport;
use crate::mesh::Mesh;
use crate::transport::{CharacteristicMap, Method, Tracer, Wind, path};
use nalgebra::SVector;
use std::borrow::Cow;
use std::sync::Arc;

impl<const D: usize> Simulation<D> {
    /// A simulation without a flow: the velocity is given, level sets and markers are carried by it. Of `settings` the step, the
    /// transport, the quadrature and the periodic sides matter; no matrix of a flow and no pressure is ever made.
    ///
    /// # Errors
    /// Periodic sides that do not fit.
    pub fn prescribed(
        mesh: &Arc<Mesh<D>>,
        settings: Settings<D>,
        velocity: VelocityFunction<D>,
        level_sets: Vec<LevelSet<D>>,
    ) -> Result<Simulation<D>> {
        let space = Arc::new(Space::new(mesh, Element::P2));
        let translations = periodic_pairs(mesh, &settings.conditions)?;
        let carrier = Carrier::new(Tracer::new(&space, &translations), None);
        let u = space.interpolate(|x| velocity(x, 0.0));
        let state = State {
            steps: 0,
            time: 0.0,
            pace: None,
            flow: FlowState { u, p: Vec::new() },
            phi: Vec::new(),
            stretch: Vec::new(),
            displacement: Vec::new(),
            earlier_u: Vec::new(),
            map: None,
            markers: Vec::new(),
            factored: None,
            energies: Energies::default(),
            budget: Budget::default(),
        };
        let sim = Simulation {
            settings,
            space,
            flow: None,
            given: Some(velocity),
            descent: None,
            translations,
            carrier,
            predictors: Vec::new(),
            pacing: None,
            redistancing: None,
            fine: None,
            structures: Vec::new(),
            passive: Vec::new(),
            state,
            feet: Default::default(),
            wants_reactions: false,
            reactions: None,
            phases: Default::default(),
            work: Default::default(),
        };
        sim.with_passive(level_sets)
    }

    /// Adds level sets that are carried and act on nothing, at time 0.
    ///
    /// # Errors
    /// A mass matrix for projected transport that does not fit into the memory.
    pub fn with_passive(mut self, level_sets: Vec<LevelSet<D>>) -> Result<Simulation<D>> {
        self.passive = level_sets;
        self.state.markers = self.passive.iter().map(|s| s.markers.clone()).collect();
        if self.settings.transport == Method::Composed {
            self.state.phi.extend(self.passive.iter().map(|_| Vec::new()));
        } else {
            self.state.phi.extend(self.passive.iter().map(|s| s.phi.clone()));
        }
        let projected = self.settings.transport == Method::Projected && !self.passive.is_empty();
        if projected && self.carrier.projector.is_none() {
            let basis = Basis::new(&self.space, &Arc::new(Rule::simplex(D, self.settings.quadrature)));
            self.carrier.projector = Some(Projector::new(basis, &self.translations)?);
        }
        self.begin_map();
        Ok(self)
    }

    /// The backward map of composed transport, at time 0, and the functions that it carries.
    pub(super) fn begin_map(&mut self) {
        if self.settings.transport != Method::Composed {
            return;
        }
        let structures = self.structures().iter().map(|s| Initial { nodal: s.phi.clone(), function: None });
        let passive = self.passive.iter().map(|s| Initial { nodal: s.phi.clone(), function: s.function.clone() });
        self.carrier.initial = structures.chain(passive).collect();
        let used = !self.carrier.initial.is_empty();
        self.state.map = used.then(|| CharacteristicMap::identity(self.space.len()));
    }

    /// For composed transport, at time 0: the functions whose values the level sets of the structures are, one a structure, and
    /// the steepness `|grad d|` of a submap beyond which the next one begins (`None` for the default).
    pub fn compose(&mut self, functions: Vec<Arc<InitialFunction<D>>>, remap: Option<f64>) {
        for (initial, f) in self.carrier.initial.iter_mut().zip(functions) {
            initial.function = Some(f);
        }
        self.carrier.remap = remap.unwrap_or(super::REMAP);
    }
    /// The steepness of a submap beyond which the next one begins.
    pub fn remap(&self) -> f64 {
        self.carrier.remap
    }

    /// The passive level sets, which follow those of the structures in [`level_set`](Self::level_set).
    pub fn passive(&self) -> &[LevelSet<D>] {
        &self.passive
    }
    /// Whether the velocity is prescribed and no flow is solved.
    pub fn is_prescribed(&self) -> bool {
        self.given.is_some()
    }

    /// Level set number `k` at the nodes: those of the structures, then the passive ones.
    pub fn level_set(&self, k: usize) -> Cow<'_, [f64]> {
        match &self.state.map {
            Some(map) if k >= self.structures().len() => Cow::Owned(self.carrier.composed(map, k)),
            _ => Cow::Borrowed(self.state.phi.get(k).map_or(&[], Vec::as_slice)),
        }
    }

    /// With composed transport, the number of submaps and the error of the map by its determinant.
    pub fn map_error(&self) -> Option<(usize, f64)> {
        let map = self.state.map.as_ref()?;
        Some((map.submaps().len(), map.determinant_error(&self.carrier.tracer)))
    }

    /// L2 norm of the divergence of the velocity, by a rule that is exact for P2.
    pub fn divergence(&self) -> f64 {
        let basis = Basis::new(&self.space, &Arc::new(Rule::simplex(D, 2)));
        let [square] = crate::fem::integrate(&basis, crate::fem::Cells::All, |at| {
            [basis.jacobian(at, &self.state.flow.u).trace().powi(2)]
        });
        square.sqrt()
    }

    /// One step of level sets and markers in the prescribed velocity.
    pub(super) fn drift(&mut self) -> Result<StepReport> {
        let Some(velocity) = self.given.clone() else {
            return Err(Error::internal("there is neither a flow nor a velocity"));
        };
        let (dt, start) = (self.settings.dt, self.time());
        let at = |t: f64| self.space.interpolate(|x| velocity(x, t));
        let next = at(start + dt);
        self.check_speed(&next, start + dt)?;
        let fastest = |u: &[SVector<f64, D>]| self.carrier.tracer.courant(u, dt);
        let courant = fastest(&self.state.flow.u).max(fastest(&at(start + 0.5 * dt))).max(fastest(&next));
        let steps = ((0.5 * courant).ceil() as usize).clamp(1, 100);
        self.phases.begin();
        let mut ahead = std::mem::take(&mut self.work.ahead);
        let mut displacement = std::mem::take(&mut self.work.ahead_displacement);
        let wind = Wind::Given { velocity: &velocity, arrival: start + dt, courant };
        let carried = self.carry(&wind, &mut ahead, &mut displacement);
        (self.work.ahead, self.work.ahead_displacement) = (ahead, displacement);
        carried?;
        self.redistance(self.state.steps + 1)?;
        self.phases.end(Phase::Transport);
        for list in &mut self.state.markers {
            crate::base::parallel::fill(list, 1, |_, part| {
                part.iter_mut().for_each(|x| *x = path(&velocity, *x, start, dt, steps));
            });
        }
        self.state.flow.u = next;
        self.state.steps += 1;
        self.state.time = self.state.steps as f64 * dt;
        Ok(nothing_solved())
    }
}

/// The report of a step that solves no flow.
pub(super) fn nothing_solved() -> StepReport {
    let solve = SolveReport { residual: 0.0, refinements: 0, iterations: 0 };
    StepReport { solve, refactored: false, given_up: false }
}

impl Simulation<2> {
    /// The interface of level set number `k`. With composed transport it is cut on halved cells where the mesh is too coarse for
    /// what the map says.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn interface(&self, k: usize) -> Result<Interface> {
        let Some((map, initial)) = self.state.map.as_ref().zip(self.carrier.initial.get(k)) else {
            return Interface::of_nodes(&self.space, self.level_set(k).into_owned());
        };
        let slope = initial.slope(&self.space);
        Interface::of_function(&self.space, initial.depth(), |at| {
            let (value, slope) = self.carrier.sample(map, k, slope, at);
            Sample { value, slope }
        })
    }
    /// Length and area of the polygon of the markers of passive level set number `k`.
    pub fn marker_polygon(&self, k: usize) -> Option<[f64; 2]> {
        let list = self.state.markers.get(k).filter(|list| !list.is_empty())?;
        Some([markers::polygon_length(list), markers::polygon_area(list)])
    }
}
