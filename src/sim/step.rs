//! The time step.

use super::budget::{Budget, Energies};
use super::carrier::Carrier;
use super::clock::Pacing;
use super::markers;
use super::segment::Descent;
use super::setup::{Configuration, Coupling, LevelSet, Settings, State, Structure};
use crate::base::{Error, PHASES, Phase, Phases, Result};
use crate::elastic::{Predictor, SharpMembrane};
use crate::fem::{At, Basis, Cells, Element, Projector, Rule, Space, Translation, VelocityFunction, integrate};
use crate::flow::term::MomentumTerm;
use crate::flow::{FlowSolver, FlowState, History, Load, Step, StepReport, kinetic_outflow};
use crate::levelset::{Redistancing, Segmentation};
use crate::mesh::{Mesh, Point};
use crate::transport::{Feet, Method, Tracer, Wind};
use nalgebra::SVector;
use std::sync::Arc;

/// A simulation in progress.
pub struct Simulation<const D: usize> {
    pub(super) settings: Settings<D>,
    pub(super) space: Arc<Space<D>>,
    /// `None` when the velocity is prescribed.
    pub(super) flow: Option<FlowSolver<D>>,
    /// The velocity, when it is prescribed.
    pub(super) given: Option<VelocityFunction<D>>,
    /// The segmentation of an image, in a simulation without a flow.
    pub(super) descent: Option<Descent<D>>,
    pub(super) translations: Vec<Translation<D>>,
    pub(super) carrier: Carrier<D>,
    /// One a structure with the semi-implicit coupling, else none.
    pub(super) predictors: Vec<Predictor<D>>,
    pub(super) pacing: Option<Pacing>,
    /// How level sets are redistanced, and after how many steps each time.
    pub(super) redistancing: Option<(u64, Redistancing<D>)>,
    pub(super) fine: Option<Basis<D>>,
    pub(super) structures: Vec<Structure<D>>,
    pub(super) passive: Vec<LevelSet<D>>,
    pub(super) state: State<D>,
    pub(super) feet: [Feet; 2],
    pub(super) wants_reactions: bool,
    pub(super) reactions: Option<Vec<SVector<f64, D>>>,
    pub(super) phases: Phases,
    pub(super) work: Work<D>,
}

/// Buffers of a step, which a warmed-up step fills again.
#[derive(Default)]
pub(super) struct Work<const D: usize> {
    /// The velocity at the start of the step.
    current: Vec<SVector<f64, D>>,
    /// The mean of two velocities.
    mean: Vec<SVector<f64, D>>,
    /// The flow at the end of the step.
    next: FlowState<D>,
    /// Level sets one step ahead.
    pub(super) ahead: Vec<Vec<f64>>,
    /// The displacement back to time 0, one step ahead.
    pub(super) ahead_displacement: Vec<SVector<f64, D>>,
}

/// Degree of the rule for energies of the band, in the plane and in space, where the rule has more points anyway: the weight is a cosine over
/// a few cells.
const ENERGY_DEGREE: [usize; 2] = [8, 6];

impl<const D: usize> Simulation<D> {
    /// A simulation on `mesh` that starts from `initial` velocity (one vector at a position) and the level sets of `structures`.
    ///
    /// Allocates no more than the scene needs: no mass matrix without projected transport, no feet without convection or structures, no
    /// predictor without the semi-implicit coupling.
    ///
    /// # Errors
    /// Boundary conditions that do not fit the mesh, a coupling that cannot be had ([`Settings::check_coupling`]), too little memory.
    pub fn new(
        mesh: &Arc<Mesh<D>>,
        settings: Settings<D>,
        structures: Vec<Structure<D>>,
        initial: impl Fn(&Point<D>) -> SVector<f64, D>,
    ) -> Result<Simulation<D>> {
        settings.check_coupling(&structures)?;
        let space = Arc::new(Space::new(mesh, Element::P2));
        let pressure = Arc::new(Space::new(mesh, settings.pressure));
        let rule = Arc::new(Rule::simplex(D, settings.quadrature));
        let mut flow = FlowSolver::new(&space, &pressure, &rule, &settings.conditions, settings.grad_div)?;
        flow.solve_by(settings.solving);
        let implicit = settings.coupling == Coupling::Implicit && !structures.is_empty();
        // A matrix that stays is factored once.
        if implicit || !settings.has_constant_materials(&structures) {
            flow.iterate(settings.solve_tolerance);
        }
        let translations = flow.numbering().translations().to_vec();
        let projected = settings.transport == Method::Projected && !structures.is_empty();
        let projector = if projected { Some(Projector::new(flow.velocity().clone(), &translations)?) } else { None };
        let carrier = Carrier::new(Tracer::new(&space, &translations), projector);
        let semi = settings.coupling == Coupling::SemiImplicit;
        let predictors = structures.iter().filter(|_| semi);
        let predictors =
            predictors.map(|_| Predictor::new(flow.velocity().clone(), &translations)).collect::<Result<_>>()?;
        let fine = (!structures.is_empty())
            .then(|| Basis::new(&space, &Arc::new(Rule::simplex(D, ENERGY_DEGREE[D - 2].max(settings.quadrature)))));
        let mut state_flow = flow.at_rest();
        state_flow.u = space.interpolate(initial);
        flow.impose(0.0, &mut state_flow.u);
        let state = State {
            steps: 0,
            time: 0.0,
            pace: None,
            earlier_u: state_flow.u.clone(),
            flow: state_flow,
            phi: structures.iter().map(|s| s.phi.clone()).collect(),
            stretch: Vec::new(),
            displacement: Vec::new(),
            map: None,
            markers: Vec::new(),
            factored: None,
            energies: Energies::default(),
            budget: Budget::default(),
        };
        let mut sim = Simulation {
            settings,
            space,
            flow: None,
            given: None,
            descent: None,
            translations,
            carrier,
            predictors,
            pacing: None,
            redistancing: None,
            fine,
            structures,
            passive: Vec::new(),
            state,
            feet: Default::default(),
            wants_reactions: false,
            reactions: None,
            phases: Phases::default(),
            work: Work::default(),
        };
        sim.set_materials(&mut flow, &sim.state.phi);
        sim.begin_stretch();
        if sim.structures.iter().any(|s| s.shear.is_some()) {
            sim.carry_backward_map();
        }
        let State { phi, stretch, displacement, .. } = sim.state.clone();
        sim.prepare_structures(
            &flow,
            Configuration { phi: &phi, stretch: &stretch, displacement: &displacement },
            None,
        )?;
        sim.state.energies = sim.measure(&flow, 0.0);
        sim.state.budget = Budget::new(&sim.state.energies);
        sim.flow = Some(flow);
        sim.begin_map();
        Ok(sim)
    }

    /// One step: predict the interface, solve the flow with the force that it exerts, move the interface with the new velocity.
    ///
    /// Order 1 is the book's scheme (section 3.6.1): the force of `phi^n`, backward Euler along the characteristics of `u^n`, transport
    /// by `u^{n+1}`; semi-implicit, the force is that of [`Predictor`]'s level set; implicit, it is linearised in `u^{n+1}`. Order 2 takes the force of `phi^n` carried on by `u^n`,
    /// linearised in `u^{n+1} - u^n`, BDF2 along the characteristics, and transport by `(u^n + u^{n+1})/2`. All three are
    /// of second order, and the scheme is stable for any step when the stiffness in the matrix is at least half the
    /// true one; with the extrapolated velocity in place of `u^n` it is not (ARCHITECTURE.md, "The time step").
    ///
    /// # Errors
    /// A solve that fails, or a blow-up: a particle would cross the whole domain in one step.
    pub fn step(&mut self) -> Result<StepReport> {
        let Some(pacing) = self.pacing.take() else { return self.single_step() };
        let result = self.paced_step(&pacing);
        self.pacing = Some(pacing);
        result
    }

    /// A step of the length that is set.
    pub(super) fn single_step(&mut self) -> Result<StepReport> {
        let Some(mut flow) = self.flow.take() else {
            return if self.descent.is_some() { self.descend() } else { self.drift() };
        };
        let mut work = std::mem::take(&mut self.work);
        let result = self.flow_step(&mut flow, &mut work);
        (self.flow, self.work) = (Some(flow), work);
        result
    }

    fn flow_step(&mut self, solver: &mut FlowSolver<D>, work: &mut Work<D>) -> Result<StepReport> {
        let second = self.settings.order == 2 && self.state.steps > 0;
        let (dt, time) = (self.settings.dt, self.time() + self.settings.dt);
        // Over the last step.
        let ratio = self.state.pace.as_ref().map_or(1.0, |p| if p.clock.last > 0.0 { dt / p.clock.last } else { 1.0 });
        let (inertia, structures) = (!self.is_stokes(), !self.structures.is_empty());
        let convection = inertia && self.settings.convection;
        let Work { current, mean, next, ahead, ahead_displacement: displacement } = work;
        current.clone_from(&self.state.flow.u);
        self.phases.begin();

        // Where the interface will be.
        let predicts = second && structures;
        if predicts {
            self.predict(current, ahead, displacement)?;
        } else {
            ahead.clone_from(&self.state.phi);
            displacement.clone_from(&self.state.displacement);
        }
        let stretch = if predicts && self.is_sharp() {
            self.stretched(current, &self.state.phi.clone(), ahead)?
        } else {
            self.state.stretch.clone()
        };
        let diffused = self.diffused(solver, current)?;
        self.phases.end(Phase::Transport);

        // Where the fluid comes from.
        if convection && second {
            combine(1.0 + 0.5 * ratio, current, -0.5 * ratio, &self.state.earlier_u, mean);
            self.carrier.tracer.from_quadrature(mean, dt, solver.velocity(), &mut self.feet[0]);
            let (both, beyond) = (dt + dt / ratio, 0.5 * (ratio - 1.0));
            combine(1.0 + beyond, current, -beyond, &self.state.earlier_u, mean);
            let middle: &[_] = if ratio == 1.0 { current } else { mean };
            self.carrier.tracer.from_quadrature(middle, both, solver.velocity(), &mut self.feet[1]);
        } else if convection {
            self.carrier.tracer.from_quadrature(current, dt, solver.velocity(), &mut self.feet[0]);
        }
        self.phases.end(Phase::Feet);

        // Forces and materials there.
        self.set_materials(solver, ahead);
        self.phases.end(Phase::Assembly);
        let implicit = (self.settings.coupling == Coupling::Implicit).then_some(dt);
        let of = Configuration { phi: diffused.as_deref().unwrap_or(ahead), stretch: &stretch, displacement };
        self.prepare_structures(solver, of, implicit)?;
        self.phases.end(Phase::Force);

        // The coupled system of velocity and pressure.
        let feet = |k: usize| convection.then_some(&self.feet[k]);
        let history = match (inertia, second) {
            (false, _) => vec![],
            (true, false) => vec![History { weight: 1.0, u: current, feet: feet(0) }],
            (true, true) => vec![
                History { weight: 1.0 + ratio, u: current, feet: feet(0) },
                History { weight: -ratio * ratio / (1.0 + ratio), u: &self.state.earlier_u, feet: feet(1) },
            ],
        };
        let terms: Vec<&dyn MomentumTerm<D>> = self.structures.iter().map(Structure::term).collect();
        let weight = if second { (1.0 + 2.0 * ratio) / (1.0 + ratio) } else { 1.0 };
        let step = Step {
            time,
            dt,
            weight: if inertia { weight } else { 0.0 },
            history: &history,
            terms: &terms,
            predicted: second.then_some(&current[..]),
            body_force: self.settings.body_force.as_deref(),
            gravity: self.settings.gravity,
        };
        // The way of solving must be known, in a run that goes on too.
        solver.analyse(step.weight / dt)?;
        self.extrapolate(solver, ratio, next);
        let report = solver.step(&step, next)?;
        let weight = step.weight;
        self.phases.begin();
        let wall_power = solver.wall_power(&step, next);
        self.reactions = self.wants_reactions.then(|| solver.reaction(&step, next, Cells::All));
        self.check_speed(&next.u, time)?;
        self.note_factor(solver, &report, weight, Configuration { phi: ahead, stretch: &stretch, displacement });
        self.phases.end(Phase::Diagnostics);

        // The interface follows, and the fluids with it.
        if structures || !self.passive.is_empty() || self.has_backward_map() {
            if second {
                combine(0.5, current, 0.5, &next.u, mean)
            } else if self.settings.coupling == Coupling::FullyExplicit {
                mean.clone_from(current)
            } else {
                mean.clone_from(&next.u)
            }
            let before = self.is_sharp().then(|| self.state.phi.clone());
            self.carry(&Wind::Nodal(mean), ahead, displacement)?;
            if let Some(before) = before {
                self.state.stretch = self.stretched(mean, &before, &self.state.phi.clone())?;
            }
            self.follow_markers([current, &next.u], mean);
            self.redistance(self.state.steps + 1)?;
        }
        self.phases.end(Phase::Transport);
        std::mem::swap(&mut self.state.flow, next);
        std::mem::swap(&mut self.state.earlier_u, current);
        self.state.steps += 1;
        self.state.time = if self.state.pace.is_some() { time } else { self.state.steps as f64 * dt };
        if !self.has_constant_materials() {
            self.set_materials(solver, &self.state.phi);
        }
        self.prepare_sharp()?;
        self.phases.end(Phase::Assembly);
        let now = self.measure(solver, wall_power);
        self.state.budget.advance(&self.state.energies, &now, dt, if second { 2 } else { 1 });
        self.state.energies = now;
        self.phases.end(Phase::Diagnostics);
        Ok(report)
    }

    /// Seconds of all processors by [phase](PHASES) that the steps since it was asked last took, and how often they read the factor of
    /// the flow, each time twice.
    pub fn take_costs(&mut self) -> ([f64; PHASES.len()], u64) {
        let (flow, substitutions) = self.flow.as_mut().map_or(Default::default(), FlowSolver::take_costs);
        let mine = self.phases.take();
        (std::array::from_fn(|k| mine[k] + flow[k]), substitutions)
    }

    /// The level sets of the structures and the displacement back to time 0 carried over one step with the velocity `w`, without any change
    /// of the state.
    fn predict(
        &mut self,
        w: &[SVector<f64, D>],
        ahead: &mut Vec<Vec<f64>>,
        displacement: &mut Vec<SVector<f64, D>>,
    ) -> Result<()> {
        let (wind, dt, count) = (Wind::Nodal(w), self.settings.dt, self.structures.len());
        let Some(mut map) = self.state.map.clone() else {
            self.carrier.carry(&self.state.phi[..count], &wind, dt, ahead)?;
            self.carrier.carry_displacement(&self.state.displacement, displacement)?;
            self.carrier.map_level_sets(displacement, &mut ahead[..count]);
            return Ok(());
        };
        self.carrier.advance(&mut map, &wind, dt);
        *ahead = (0..count).map(|k| self.carrier.composed(&map, k)).collect();
        self.compose_displacement(&map, displacement);
        Ok(())
    }

    /// Carries all level sets and the displacement back to time 0 over one step; `moved` and `displaced` are buffers.
    pub(super) fn carry(
        &mut self,
        wind: &Wind<'_, D>,
        moved: &mut Vec<Vec<f64>>,
        displaced: &mut Vec<SVector<f64, D>>,
    ) -> Result<()> {
        let dt = self.settings.dt;
        let Some(mut map) = self.state.map.take() else {
            self.carrier.carry(&self.state.phi, wind, dt, moved)?;
            self.carrier.carry_displacement(&self.state.displacement, displaced)?;
            self.carrier.map_level_sets(displaced, moved);
            std::mem::swap(&mut self.state.phi, moved);
            std::mem::swap(&mut self.state.displacement, displaced);
            return Ok(());
        };
        self.carrier.advance(&mut map, wind, dt);
        map.restart_beyond(&self.space, self.carrier.remap);
        for (k, phi) in self.state.phi.iter_mut().take(self.structures.len()).enumerate() {
            *phi = self.carrier.composed(&map, k);
        }
        self.compose_displacement(&map, displaced);
        std::mem::swap(&mut self.state.displacement, displaced);
        self.state.map = Some(map);
        Ok(())
    }

    /// Moves the markers over a step with the velocities at its ends and their mean.
    fn follow_markers(&mut self, ends: [&[SVector<f64, D>]; 2], mean: &[SVector<f64, D>]) {
        if self.state.markers.iter().all(Vec::is_empty) {
            return;
        }
        let dt = self.settings.dt;
        let steps = (self.carrier.tracer.courant(mean, dt).ceil() as usize).clamp(1, 100);
        for list in &mut self.state.markers {
            markers::follow(list, &self.carrier.tracer, ends, dt, steps);
        }
    }

    /// The level sets whose force the semi-implicit coupling takes, from the velocity `u` of the current state; `None` with any other coupling.
    fn diffused(&mut self, flow: &FlowSolver<D>, u: &[SVector<f64, D>]) -> Result<Option<Vec<Vec<f64>>>> {
        if self.predictors.is_empty() {
            return Ok(None);
        }
        let mut level_sets = Vec::new();
        self.predict(u, &mut level_sets, &mut Vec::new())?;
        let (dt, density) = (self.settings.dt, flow.density());
        let parts = self.predictors.iter_mut().zip(&self.structures).zip(&self.state.phi).zip(&mut level_sets);
        for (((predictor, s), phi), carried) in parts {
            predictor.predict(&s.membrane, dt, (|at: &At<D>| density.at(at), density.is_constant()), phi, carried)?;
        }
        Ok(Some(level_sets))
    }

    /// Energies and rates of the current state.
    pub(super) fn measure(&self, flow: &FlowSolver<D>, wall_power: f64) -> Energies {
        let [kinetic, dissipation, grad_div, div2] = flow.energies(&self.state.flow);
        let elastic = match &self.fine {
            Some(fine) => {
                let energy = |(k, (s, phi)): (usize, (&Structure<D>, &Vec<f64>))| match (&s.shear, &s.sharp) {
                    (Some(shear), _) => shear.energy(fine, phi, &self.rest_displacement(k)),
                    (None, Some(sharp)) => sharp.energy(),
                    (None, None) => s.membrane.energy(fine, phi),
                };
                self.structures.iter().zip(&self.state.phi).enumerate().map(energy).sum()
            }
            None => 0.0,
        };
        let slip: f64 = self.structures.iter().filter_map(|s| s.sharp.as_ref()).map(SharpMembrane::dissipation).sum();
        Energies {
            kinetic,
            elastic,
            dissipation: dissipation + slip,
            grad_div,
            power: wall_power + self.body_power(flow) - self.carried_out(flow),
            divergence: div2.sqrt(),
        }
    }

    /// Kinetic energy that the flow carries out through the boundary per time.
    fn carried_out(&self, flow: &FlowSolver<D>) -> f64 {
        // Nothing leaves through walls that rest, or through one periodic side but what comes in at the other.
        let closed = !flow.numbering().is_open() && flow.numbering().is_homogeneous();
        if closed || self.is_stokes() || !self.settings.convection {
            return 0.0;
        }
        kinetic_outflow(&self.space, |cell, l| self.density_at(cell, l), &self.state.flow)
    }

    /// Power of gravity and body force.
    fn body_power(&self, flow: &FlowSolver<D>) -> f64 {
        let gravity = self.settings.gravity;
        if gravity.norm() == 0.0 && self.settings.body_force.is_none() {
            return 0.0;
        }
        let (basis, time) = (flow.velocity(), self.time());
        let [power] = integrate(basis, Cells::All, |at| {
            let force = self.settings.body_force.as_ref().map_or(SVector::zeros(), |f| f(&at.x, time));
            [(gravity * flow.weight(at) + force).dot(&basis.value(at, &self.state.flow.u))]
        });
        power
    }

    pub(super) fn check_speed(&self, u: &[SVector<f64, D>], time: f64) -> Result<()> {
        let (lo, hi) = self.space.mesh().bounding_box();
        let size = (hi - lo).norm();
        let speed = largest(u);
        if speed.is_finite() && speed * self.settings.dt < size {
            return Ok(());
        }
        Err(Error::computation("the computation blew up: a particle would cross the whole domain in one step")
            .at(format!("time {time:.6}"))
            .value(format!("largest velocity {speed:.3e}"))
            .remedy("take a smaller time.step, coupling = \"implicit\", or a larger numerics.grad_div; `immersa explain` prints the step limit"))
    }

    /// Sets up the matrix of the coming steps and analyses it, without factoring: its size can be asked for then.
    pub fn analyse(&mut self) -> Result<()> {
        // The first step is one of backward Euler in either order.
        let weight = if self.is_stokes() { 0.0 } else { 1.0 };
        match &mut self.flow {
            Some(flow) => flow.analyse(weight / self.settings.dt),
            None => Ok(()),
        }
    }
    /// Force of the fluid on a named boundary by the residual of the momentum equation in the last step, and its moment about a
    /// point; `None` before the first. A node that the boundary shares with another one counts in full.
    pub fn reaction(&self, boundary: &str, about: &Point<D>) -> Result<Option<Load<D>>> {
        let mesh = self.space.mesh();
        let mut nodes: Vec<u32> = Vec::new();
        for &f in mesh.boundary(boundary)? {
            nodes.extend(self.space.facet_nodes(&mesh.facets()[f as usize]));
        }
        nodes.sort_unstable();
        nodes.dedup();
        Ok(self.reactions.as_ref().map(|r| {
            let mut load = Load::ZERO;
            nodes.iter().for_each(|&n| load.add(&(self.space.nodes()[n as usize] - about), &-r[n as usize]));
            load
        }))
    }
    /// Whether [`reaction`](Self::reaction) will be asked for; costs one assembly a step.
    pub fn keep_reactions(&mut self, keep: bool) {
        self.wants_reactions = keep;
    }
    /// Current time.
    pub fn time(&self) -> f64 {
        self.state.time
    }
    /// Whether the flow has no inertia.
    pub fn is_stokes(&self) -> bool {
        self.settings.fluids(&self.structures).all(|f| f.density == 0.0)
            && self.structures.iter().all(|s| s.surface_mass == 0.0)
    }
    /// What it was told.
    pub fn settings(&self) -> &Settings<D> {
        &self.settings
    }
    /// The P2 space of velocity and level sets.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }
    /// The flow solver; `None` when the velocity is prescribed.
    pub fn flow(&self) -> Option<&FlowSolver<D>> {
        self.flow.as_ref()
    }
    /// The pairs of facets on periodic sides.
    pub fn translations(&self) -> &[Translation<D>] {
        &self.translations
    }
    /// The structures; their current level sets are in [`State::phi`].
    pub fn structures(&self) -> &[Structure<D>] {
        &self.structures
    }
    /// The state.
    pub fn state(&self) -> &State<D> {
        &self.state
    }
    /// Goes on from a state of the same simulation.
    ///
    /// # Errors
    /// The sizes do not fit.
    pub fn restore(&mut self, state: State<D>) -> Result<()> {
        let sizes = |s: &State<D>| {
            let level_sets = s.phi.iter().map(Vec::len);
            let markers = s.markers.iter().map(Vec::len);
            let maps = s.map.iter().map(|m| m.submaps().all(|d| d.len() == s.flow.u.len()));
            let flow = [s.flow.u.len(), s.flow.p.len(), s.earlier_u.len(), s.displacement.len()];
            (flow, level_sets.collect::<Vec<_>>(), markers.collect::<Vec<_>>(), maps.collect::<Vec<_>>())
        };
        if sizes(&state) != sizes(&self.state) || state.pace.is_some() != self.state.pace.is_some() {
            return Err(Error::input("the checkpoint does not belong to this scene")
                .value(format!("{:?} instead of {:?}", sizes(&state), sizes(&self.state)))
                .remedy(
                    "resume with the scene that the run was started with, or start afresh in another folder with --out",
                ));
        }
        self.state = state;
        self.prepare_sharp()?;
        if let Some(mut flow) = self.flow.take() {
            let made = self.restore_factor(&mut flow);
            self.set_materials(&mut flow, &self.state.phi);
            self.flow = Some(flow);
            made?;
        }
        Ok(())
    }
    /// Largest speed at a node.
    pub fn largest_speed(&self) -> f64 {
        largest(&self.state.flow.u)
    }
    /// Courant number `max |u| dt / h`.
    pub fn courant(&self) -> f64 {
        self.carrier.tracer.courant(&self.state.flow.u, self.settings.dt)
    }
    /// Bytes of all that grows with the mesh: factors, matrices, feet, fields and the mesh itself. An estimate from the sizes.
    pub fn bytes(&self) -> usize {
        let word = size_of::<f64>();
        let (cells, nodes) = (self.space.mesh().cell_count(), self.space.len());
        let points = self.flow.as_ref().map_or(0, |flow| flow.velocity().rule().len());
        // The matrix and its constant part, an index and a value each; the projector's mass matrix is small beside them.
        let matrices = 2 * 2 * word * self.flow.as_ref().map_or(0, FlowSolver::matrix_nonzeros);
        let feet = if self.is_stokes() && self.carrier.projector.is_none() { 0 } else { 2 * 5 * word * cells * points };
        let local = self.space.local_count();
        let vectors = if self.flow.is_some() { 10 } else { 1 };
        let level_sets = self.structures.len() + self.passive.len();
        let fields = word * nodes * (vectors * D + 3 * level_sets) + word * cells * local * D;
        let mesh = cells * (2 * word + word * (D * D + D + 1) + 4 * local);
        self.factor_bytes() + matrices + feet + fields + mesh
    }
    /// Bytes of the factors that are held.
    pub fn factor_bytes(&self) -> usize {
        let flow = self.flow.as_ref().map_or(0, FlowSolver::factor_bytes);
        let predictors = self.predictors.iter().map(Predictor::bytes).sum::<usize>();
        let segmentation = self.segmentation().map_or(0, Segmentation::bytes);
        flow + self.carrier.projector.as_ref().map_or(0, Projector::bytes) + predictors + segmentation
    }
}

/// `out = a x + b y`.
fn combine<const D: usize>(
    a: f64,
    x: &[SVector<f64, D>],
    b: f64,
    y: &[SVector<f64, D>],
    out: &mut Vec<SVector<f64, D>>,
) {
    out.clear();
    out.extend(x.iter().zip(y).map(|(x, y)| x * a + y * b));
}

/// Largest norm; NaN if any is NaN.
pub(super) fn largest<const D: usize>(u: &[SVector<f64, D>]) -> f64 {
    let square = u.iter().map(|v| v.norm_squared()).fold(0.0, |m: f64, v| if v.is_nan() { v } else { m.max(v) });
    if u.iter().any(|v| v.iter().any(|c| c.is_nan())) { f64::NAN } else { square.sqrt() }
}
