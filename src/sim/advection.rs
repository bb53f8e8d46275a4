//! Level sets in a prescribed velocity: no flow is solved.

use super::carried::{Carried, Transport, largest};
use super::outlets::Outlets;
use super::state::State;
use super::transfer::{Bring, Transfer};
use crate::base::{PHASES, Phases, Result};
use crate::fem::{Conditions, Element, Space, VelocityFunction, periodic_pairs};
use crate::flow::{FlowState, StepReport};
use crate::linalg::SolveReport;
use crate::mesh::Mesh;
use crate::structure::{Fields, Structure, Velocity};
use nalgebra::SVector;
use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;

/// Structures transported by a prescribed velocity; there is no flow matrix and no pressure.
///
/// # Examples
/// ```
/// use immersa::fem::{Element, Space};
/// use immersa::mesh::{Diagonals, Point, rectangle};
/// use immersa::sim::{Advection, LevelSet, Transport};
/// use std::sync::Arc;
///
/// // The shear (y, 0) carries the line x = 1 to the line x = 1 + t y.
/// let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 1.0], [8, 4], Diagonals::Right)?);
/// let phi = Space::new(&mesh, Element::P2).interpolate(|x| x[0] - 1.0);
/// let velocity = Arc::new(|x: &Point<2>, _: f64| Point::<2>::new(x[1], 0.0));
/// let line = Box::new(LevelSet::new("line", phi));
/// let transport = (Transport::default(), &vec![]);
/// let mut advection = Advection::new(&mesh, (velocity, 0.1), transport, vec![line])?;
/// advection.step()?;
/// for (value, x) in advection.level_set(0).iter().zip(advection.space().nodes()) {
///     let exact = x[0] - 0.1 * x[1] - 1.0;
///     assert!((value - exact).abs() < 1e-12 || x[0] < 0.1); // inflow at x = 0
/// }
/// # Ok::<(), immersa::base::Error>(())
/// ```
pub struct Advection<const D: usize> {
    velocity: VelocityFunction<D>,
    dt: f64,
    conditions: Conditions<D>,
    carried: Carried<D>,
    outlets: Outlets<D>,
    state: State<D>,
    phases: Phases,
    moved: Fields<D>,
}

impl<const D: usize> Advection<D> {
    /// Structures on `mesh` in `velocity`, in steps of length `dt`. Only the periodic sides of
    /// `conditions` are used.
    ///
    /// # Errors
    /// Periodic sides that do not fit; a mass matrix that does not fit into the memory.
    pub fn new(
        mesh: &Arc<Mesh<D>>,
        (velocity, dt): (VelocityFunction<D>, f64),
        (transport, conditions): (Transport, &Conditions<D>),
        structures: Vec<Box<dyn Structure<D>>>,
    ) -> Result<Advection<D>> {
        let space = Arc::new(Space::new(mesh, Element::P2));
        let kept = Fields::default();
        Advection::build((velocity, dt), (space, conditions), (transport, &kept), structures)
    }

    fn build(
        (velocity, dt): (VelocityFunction<D>, f64),
        (space, conditions): (Arc<Space<D>>, &Conditions<D>),
        (transport, kept): (Transport, &Fields<D>),
        structures: Vec<Box<dyn Structure<D>>>,
    ) -> Result<Advection<D>> {
        let links = periodic_pairs(space.mesh(), conditions)?;
        let periodic: HashSet<u32> = links.iter().map(|l| l.facet).collect();
        let facets = 0..space.mesh().facets().len() as u32;
        let outlets = Outlets::new(&space, facets.filter(|f| !periodic.contains(f)));
        let (carried, fields) = Carried::new(&space, links, transport, structures, (None, kept))?;
        let flow = FlowState { u: space.interpolate(|x| velocity(x, 0.0)), p: Vec::new() };
        let state = State { flow, fields, ..State::default() };
        let (phases, moved, conditions) =
            (Phases::default(), Fields::default(), conditions.clone());
        Ok(Advection { velocity, dt, conditions, carried, outlets, state, phases, moved })
    }

    /// Takes one step.
    ///
    /// # Errors
    /// A velocity that is not finite or crosses the domain in a step.
    pub fn step(&mut self) -> Result<StepReport> {
        let (dt, start, velocity) = (self.dt, self.state.time, self.velocity.clone());
        let at = |t: f64| self.carried.space.interpolate(|x| velocity(x, t));
        let next = at(start + dt);
        self.carried.check_speed(&next, dt, start + dt)?;
        let tracer = &self.carried.carrier.tracer;
        let fastest = |u: &[SVector<f64, D>]| tracer.courant(u, dt);
        let courant = fastest(&self.state.flow.u).max(fastest(&at(start + 0.5 * dt)));
        let courant = courant.max(fastest(&next));
        self.phases.begin();
        let given = Velocity::Given { velocity: &velocity, start, courant };
        let of = (dt, start + dt, self.state.steps + 1);
        let with = (&[][..], &mut self.phases);
        self.carried.carry(&self.state.fields, given, of, with, &mut self.moved)?;
        std::mem::swap(&mut self.state.fields, &mut self.moved);
        self.state.flow.u = next;
        self.state.steps += 1;
        self.state.time = self.state.steps as f64 * dt;
        Ok(nothing_solved())
    }
    /// Continues from a state of the same problem.
    ///
    /// # Errors
    /// Fields or sizes that do not fit.
    pub fn restore(&mut self, state: State<D>) -> Result<()> {
        self.state.check_fits(&state)?;
        self.state = state;
        Ok(())
    }
    /// Time step.
    pub fn dt(&self) -> f64 {
        self.dt
    }
    /// Current time.
    pub fn time(&self) -> f64 {
        self.state.time
    }
    /// The structures and their transport.
    pub fn carried(&self) -> &Carried<D> {
        &self.carried
    }
    /// The same, mutable, for options such as [`redistance_when`](Carried::redistance_when).
    pub fn carried_mut(&mut self) -> &mut Carried<D> {
        &mut self.carried
    }
    /// The P2 space of velocity and level sets.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.carried.space
    }
    /// The state; its pressure is empty.
    pub fn state(&self) -> &State<D> {
        &self.state
    }
    /// Level set of structure number `k` at the nodes.
    pub fn level_set(&self, k: usize) -> Cow<'_, [f64]> {
        self.carried.level_set(&self.state.fields, k)
    }
    /// Names of the structures that have reached a part of the boundary that the velocity crosses.
    pub fn leaving(&self) -> impl Iterator<Item = &str> {
        let (fields, u) = (&self.state.fields, &self.state.flow.u);
        let reached = |s: &dyn Structure<D>| self.outlets.are_reached(s, fields, Some(u));
        self.carried.structures.iter().filter(move |s| reached(&***s)).map(|s| s.name())
    }
    /// Largest speed at a node.
    pub fn largest_speed(&self) -> f64 {
        largest(&self.state.flow.u)
    }
    /// Courant number `max |u| dt / h`.
    pub fn courant(&self) -> f64 {
        self.carried.carrier.tracer.courant(&self.state.flow.u, self.dt)
    }
    /// Processor seconds by [phase](PHASES) since the last call.
    pub fn take_costs(&mut self) -> [f64; PHASES.len()] {
        self.phases.take()
    }
    /// Estimated bytes of storage that grows with the mesh.
    pub fn bytes(&self) -> usize {
        self.carried.factor_bytes() + self.carried.field_bytes(1)
    }
}

impl Advection<2> {
    /// This advection at the same time on `mesh`, another mesh of the same domain with the same
    /// names.
    ///
    /// # Errors
    /// Those of [`Advection::new`]; a mesh that does not cover the domain.
    pub fn on_mesh(&self, mesh: &Arc<Mesh<2>>, transfer: Transfer) -> Result<Advection<2>> {
        let to = Arc::new(Space::new(mesh, Element::P2));
        let links = periodic_pairs(mesh, &self.conditions)?;
        let bring = Bring::new(transfer, self.space(), &to, &links)?;
        let structures = self.carried.structures.iter().map(|s| s.boxed()).collect();
        let (velocity, kept) =
            ((self.velocity.clone(), self.dt), bring.fields(&self.state.fields)?);
        let transport = (self.carried.transport, &kept);
        let mut moved = Advection::build(velocity, (to, &self.conditions), transport, structures)?;
        moved.carried.redistancing = self.carried.redistancing;
        moved.state.flow.u = bring.vector(&self.state.flow.u)?;
        (moved.state.steps, moved.state.time) = (self.state.steps, self.state.time);
        Ok(moved)
    }
}

/// The report of a step without a flow solve.
pub(super) fn nothing_solved() -> StepReport {
    let solve = SolveReport { residual: 0.0, refinements: 0, iterations: 0 };
    StepReport { solve, refactored: false, given_up: false }
}
