//! The immersed problem: a flow with structures.

mod factor;
mod materials;
mod measure;
mod pace;
mod remesh;
mod scheme;
mod settings;
mod step;
mod time_error;

pub use settings::SimulationSettings;

use super::balance::{Energies, EnergyBalance};
use super::carried::{Carried, largest};
use super::clock::Pacing;
use super::outlets::Outlets;
use super::state::State;
use crate::base::{Error, PHASES, Phases, Result};
use crate::fem::{Basis, Condition, Element, Rule, Space, condition_of_facets};
use crate::flow::{
    Backflow, ConvectionScheme, FlowSolver, FlowState, Fluid, GivenStress, GradientForm,
};
use crate::linalg::SolverOptions;
use crate::mesh::{Mesh, Point};
use crate::structure::{Coupling, Fields, Place, Structure};
use crate::transport::Feet;
use measure::Powers;
use nalgebra::SVector;
use std::borrow::Cow;
use std::sync::Arc;

/// A flow with structures, in progress.
///
/// # Examples
/// ```
/// use immersa::fem::Condition;
/// use immersa::mesh::{Diagonals, Point, rectangle};
/// use immersa::sim::{Fluid, Simulation, SimulationSettings};
/// use std::sync::Arc;
///
/// // The velocity (y, 0) is a steady solution of the Navier-Stokes equations.
/// let mesh = Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], Diagonals::UnionJack)?);
/// let shear = Condition::Velocity(Arc::new(|x, _| Point::<2>::new(x[1], 0.0)));
/// let fluid = Fluid { density: 1.0, viscosity: 0.1 };
/// let settings = SimulationSettings::new(0.05, fluid, vec![("walls".into(), shear)]);
/// let mut sim = Simulation::new(&mesh, settings, vec![], |x| Point::<2>::new(x[1], 0.0))?;
/// for _ in 0..3 {
///     sim.step()?;
/// }
/// assert!((sim.time() - 0.15).abs() < 1e-15);
/// assert!((sim.largest_speed() - 1.0).abs() < 1e-12);
/// assert!((sim.state().energies.kinetic - 1.0 / 6.0).abs() < 1e-12);
/// # Ok::<(), immersa::base::Error>(())
/// ```
pub struct Simulation<const D: usize> {
    settings: SimulationSettings<D>,
    carried: Carried<D>,
    flow: FlowSolver<D>,
    /// Open sides.
    outlets: Outlets<D>,
    backflow: Backflow<D>,
    /// Sides with a pressure, which have no such stress.
    with_pressure: Backflow<D>,
    given_stress: GivenStress<D>,
    gradient_form: Arc<GradientForm<D>>,
    pacing: Option<Pacing>,
    /// Velocity basis at the points of a finer rule, for energies; `None` without forces.
    fine: Option<Basis<D>>,
    state: State<D>,
    feet: [Feet; 2],
    keeps_reactions: bool,
    reactions: Option<Vec<SVector<f64, D>>>,
    phases: Phases,
    work: Work<D>,
}

/// Buffers of a step, allocated once.
#[derive(Default)]
struct Work<const D: usize> {
    /// Velocity at the start of the step.
    current: Vec<SVector<f64, D>>,
    /// Mean of two velocities.
    mean: Vec<SVector<f64, D>>,
    /// Velocity that convects implicitly; empty without.
    wind: Vec<SVector<f64, D>>,
    /// Flow at the end of the step.
    next: FlowState<D>,
    /// Fields predicted for the end of the step.
    ahead: Fields<D>,
    /// Fields carried by the velocity at the start, for the semi-implicit coupling.
    drifted: Fields<D>,
    /// Fields at the end of the step.
    moved: Fields<D>,
}

/// Degree of the rule for energies of the band, in the plane and in space, where the rule has more
/// points: the weight is a cosine over a few cells.
const ENERGY_DEGREE: [usize; 2] = [8, 6];

impl<const D: usize> Simulation<D> {
    /// A flow on `mesh` with the initial velocity `initial` (a function of position) and
    /// `structures`.
    ///
    /// Allocates only what is used: no mass matrix without projected transport, no feet without
    /// convection or structures.
    ///
    /// # Errors
    /// Boundary conditions that do not fit the mesh, a coupling that is not possible
    /// ([`SimulationSettings::check_couplings`]), too little memory.
    pub fn new(
        mesh: &Arc<Mesh<D>>,
        settings: SimulationSettings<D>,
        structures: Vec<Box<dyn Structure<D>>>,
        initial: impl Fn(&Point<D>) -> SVector<f64, D>,
    ) -> Result<Simulation<D>> {
        let mut sim = Simulation::build(mesh, settings, structures, &Fields::default())?;
        sim.state.flow.u = sim.space().interpolate(initial);
        sim.begin()
    }

    /// The same with the velocity and the pressure of `flow`, values at the nodes of their spaces.
    ///
    /// # Errors
    /// Those of [`new`](Self::new); values of another number.
    pub fn from_flow(
        mesh: &Arc<Mesh<D>>,
        settings: SimulationSettings<D>,
        structures: Vec<Box<dyn Structure<D>>>,
        flow: FlowState<D>,
    ) -> Result<Simulation<D>> {
        let mut sim = Simulation::build(mesh, settings, structures, &Fields::default())?;
        let sizes = |flow: &FlowState<D>| [flow.u.len(), flow.p.len()];
        if sizes(&flow) != sizes(&sim.state.flow) {
            return Err(Error::internal("a flow is to start with values of another mesh")
                .value(format!("{:?} instead of {:?}", sizes(&flow), sizes(&sim.state.flow))));
        }
        sim.state.flow = flow;
        sim.begin()
    }

    /// Time 0 with the current flow.
    fn begin(mut self) -> Result<Simulation<D>> {
        let sim = &mut self;
        sim.flow.impose(0.0, &mut sim.state.flow.u);
        sim.state.earlier_u = sim.state.flow.u.clone();
        sim.set_materials_now();
        sim.prepare_now()?;
        sim.state.energies = sim.measure(Powers::default())?;
        sim.state.balance = EnergyBalance::new(&sim.state.energies);
        Ok(self)
    }

    /// Declares that the first step changes the velocity at once, as a flow that is set in motion by
    /// its sides does: what the balance misses then is kept apart, as that of the
    /// [start](EnergyBalance::start). Steps of higher order know the velocity before it for
    /// some steps more.
    pub fn start_at_once(&mut self) {
        let order = if self.is_stokes() { 1 } else { self.settings.order as u64 };
        self.state.balance.settling = if order == 1 { 1 } else { order + 1 };
    }

    /// Energies below `least` are errors of rounding or of the mesh, which the balance does not
    /// judge.
    pub fn neglect_energy(&mut self, least: f64) {
        self.state.balance.least = least;
    }

    /// A simulation with fluid at rest, whose fields are `kept` where these have them.
    fn build(
        mesh: &Arc<Mesh<D>>,
        settings: SimulationSettings<D>,
        structures: Vec<Box<dyn Structure<D>>>,
        kept: &Fields<D>,
    ) -> Result<Simulation<D>> {
        settings.check_couplings(&structures)?;
        let space = Arc::new(Space::new(mesh, Element::P2));
        let pressure = Arc::new(Space::new(mesh, settings.pressure));
        let rule = Arc::new(Rule::simplex(D, settings.quadrature));
        let (conditions, grad_div) = (&settings.conditions, settings.grad_div);
        let mut flow = FlowSolver::new(&space, &pressure, &rule, conditions, grad_div)?;
        let inertial = settings.fluids(&structures).any(|f| f.density > 0.0);
        let scheme = settings.convection.filter(|_| inertial);
        let unsymmetric = scheme == Some(ConvectionScheme::Implicit);
        flow.solve_by(SolverOptions { unsymmetric, ..settings.solver });
        let implicit = structures.iter().any(|s| s.acts() && s.coupling() == Coupling::Implicit);
        let open: Vec<(u32, usize)> = condition_of_facets(mesh, conditions)?
            .into_iter()
            .filter_map(|(facet, k)| Some((facet, k?)))
            .filter(|(_, k)| conditions[*k].1.is_open())
            .collect();
        let outlets = Outlets::new(&space, open.iter().map(|(facet, _)| *facet));
        let given_stress = GivenStress::new(mesh, &open, conditions);
        let with_gradient = open.iter().filter(|(_, k)| conditions[*k].1.has_gradient());
        let with_gradient = with_gradient.map(|(facet, _)| *facet).collect();
        let gradient_form =
            Arc::new(GradientForm::new(mesh, with_gradient, settings.fluid.viscosity));
        if !gradient_form.is_empty() {
            flow.keep(Arc::<GradientForm<D>>::clone(&gradient_form));
        }
        let (mut open, mut with_pressure): (Vec<_>, Vec<_>) =
            open.into_iter().partition(|(_, k)| conditions[*k].1.is_directional());
        // What comes in changes the matrix, where there is convection.
        if scheme.is_none() {
            open.clear();
            with_pressure.clear();
        }
        let varies = !settings.has_constant_materials(&structures) || !open.is_empty();
        // A constant matrix is factored once.
        if implicit || varies || unsymmetric {
            flow.iterate(settings.solve_tolerance);
        }
        let degree = ENERGY_DEGREE[D - 2].max(settings.quadrature);
        let acts = structures.iter().any(|s| s.acts());
        if acts {
            flow.leave_unstabilised();
        }
        let fine = acts.then(|| Basis::new(&space, &Arc::new(Rule::simplex(D, degree))));
        let [backflow, with_pressure] =
            [open, with_pressure].map(|facets| Backflow::new(&space, facets));
        let links = flow.numbering().translations().to_vec();
        let basis = (Some(flow.velocity()), kept);
        let (carried, fields) = Carried::new(&space, links, settings.transport, structures, basis)?;
        let state = State { flow: flow.at_rest(), fields, ..State::default() };
        Ok(Simulation {
            settings,
            carried,
            flow,
            outlets,
            backflow,
            with_pressure,
            given_stress,
            gradient_form,
            pacing: None,
            fine,
            state,
            feet: Default::default(),
            keeps_reactions: false,
            reactions: None,
            phases: Phases::default(),
            work: Work::default(),
        })
    }

    /// Prepares the structures for the current fields, for the size of their forces.
    fn prepare_now(&mut self) -> Result<()> {
        let at = Place::new(&self.carried.space, &self.flow, &self.state.fields, self.state.time);
        self.carried.structures.iter_mut().try_for_each(|s| s.prepare(&at))
    }

    /// Assembles the matrix of the coming steps and analyses it without factoring, so that its size
    /// is known.
    ///
    /// # Errors
    /// Too little memory.
    pub fn analyse(&mut self) -> Result<()> {
        // The first step is backward Euler for either order.
        let weight = if self.is_stokes() { 0.0 } else { 1.0 };
        self.flow.analyse(weight / self.settings.dt)
    }
    /// Continues from a state of the same simulation.
    ///
    /// # Errors
    /// Fields or sizes that do not fit.
    pub fn restore(&mut self, state: State<D>) -> Result<()> {
        self.state.check_fits(&state)?;
        self.state = state;
        self.restore_factor()?;
        self.set_materials_now();
        self.measure(Powers::default()).map(drop)
    }
    /// Current time.
    pub fn time(&self) -> f64 {
        self.state.time
    }
    /// True if the flow has no inertia.
    pub fn is_stokes(&self) -> bool {
        let structures = &self.carried.structures;
        self.settings.fluids(structures).all(|f| f.density == 0.0)
            && structures.iter().all(|s| s.held().is_none_or(|h| h.surface_mass == 0.0))
    }
    /// The settings.
    pub fn settings(&self) -> &SimulationSettings<D> {
        &self.settings
    }
    /// The structures and their transport.
    pub fn carried(&self) -> &Carried<D> {
        &self.carried
    }
    /// The P2 space of velocity and level sets.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.carried.space
    }
    /// The flow solver.
    pub fn flow(&self) -> &FlowSolver<D> {
        &self.flow
    }
    /// The structures.
    pub fn structures(&self) -> &[Box<dyn Structure<D>>] {
        &self.carried.structures
    }
    /// The state.
    pub fn state(&self) -> &State<D> {
        &self.state
    }
    /// Level set of structure number `k` at the nodes.
    pub fn level_set(&self, k: usize) -> Cow<'_, [f64]> {
        self.carried.level_set(&self.state.fields, k)
    }
    /// The structures and their transport, mutable, for options such as
    /// [`redistance_when`](Carried::redistance_when).
    pub fn carried_mut(&mut self) -> &mut Carried<D> {
        &mut self.carried
    }
    /// Enables [`reaction`](Self::reaction) after each step; costs one assembly per step.
    pub fn keep_reactions(&mut self, keep: bool) {
        self.keeps_reactions = keep;
    }
    /// Names of the structures that leave through an open side.
    pub fn leaving(&self) -> impl Iterator<Item = &str> {
        let leaving = self.leaving_at(&self.state.fields);
        self.structures().iter().zip(leaving).filter(|(_, leaves)| *leaves).map(|(s, _)| s.name())
    }
    /// For each structure, true if it leaves through an open side and exerts no force.
    fn leaving_at(&self, fields: &Fields<D>) -> Vec<bool> {
        let structures = self.structures().iter().map(|s| &**s);
        structures.map(|s| self.outlets.are_reached(s, fields, None)).collect()
    }
    /// Nodes on open sides, some of them several times.
    pub fn outlet_nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.outlets.nodes()
    }
    /// True if fluid that comes in through an open side changes the matrix.
    pub fn has_backflow(&self) -> bool {
        !self.backflow.is_empty()
    }
    /// Where fluid comes in most quickly through an open side that is not meant to let it in, by a
    /// total pressure: the name of the side, the speed inward, and the point.
    pub fn inflow(&self) -> Option<(&str, f64, Point<D>)> {
        let conditions = &self.settings.conditions;
        let told = |k: usize| !matches!(conditions[k].1, Condition::TotalPressure(_));
        let (speed, k, x) = self.backflow.greatest(self.space(), &self.state.flow.u, told)?;
        Some((&conditions[k].0, speed, x))
    }
    /// Where fluid comes in obliquely through a side with a pressure, as eddies do: the name of the
    /// side, the lesser of the speeds inward and along the side, and the point.
    pub fn oblique_inflow(&self) -> Option<(&str, f64, Point<D>)> {
        let (speed, k, x) =
            self.with_pressure.greatest_oblique(self.space(), &self.state.flow.u)?;
        Some((&self.settings.conditions[k].0, speed, x))
    }
    /// Largest speed at a node.
    pub fn largest_speed(&self) -> f64 {
        largest(&self.state.flow.u)
    }
    /// Courant number `max |u| dt / h`.
    pub fn courant(&self) -> f64 {
        self.carried.carrier.tracer.courant(&self.state.flow.u, self.settings.dt)
    }
    /// All fluids, that outside of the structures first.
    pub fn fluids(&self) -> impl Iterator<Item = Fluid> {
        self.settings.fluids(&self.carried.structures)
    }
    /// Processor seconds by [phase](PHASES), and number of substitutions with the factor of the
    /// flow, since the last call.
    pub fn take_costs(&mut self) -> ([f64; PHASES.len()], u64) {
        let (flow, substitutions) = self.flow.take_costs();
        let mine = self.phases.take();
        (std::array::from_fn(|k| mine[k] + flow[k]), substitutions)
    }
    /// Estimated bytes of storage that grows with the mesh: factors, matrices, feet, fields and
    /// mesh.
    pub fn bytes(&self) -> usize {
        let word = size_of::<f64>();
        let points = self.flow.velocity().rule().len() * self.space().mesh().cell_count();
        // The matrix and its constant part, an index and a value each; the projector's mass matrix
        // is small beside them.
        let matrices = 2 * 2 * word * self.flow.matrix_nonzeros();
        let traced = !self.is_stokes() || self.carried.carrier.projector.is_some();
        let feet = if traced { 2 * 5 * word * points } else { 0 };
        self.factor_bytes() + matrices + feet + self.carried.field_bytes(10)
    }
    /// Bytes of the factors.
    pub fn factor_bytes(&self) -> usize {
        self.flow.factor_bytes() + self.carried.factor_bytes()
    }
}
