//! The flow of a scene with its structures.

mod numbers;
mod told;
mod waves;

use super::flow_plan::FlowPlan;
use super::ground::{self, QUADRATURE};
use super::resolution::unresolved;
use super::{fields, flow_advice, forces, interfaces, scales};
use crate::base::{Cause, Error, Kind, PHASES, Result, Warning, fnv1a};
use crate::flow::{BodyForce, ConvectionScheme, StepReport};
use crate::levelset::band_edges;
use crate::mesh::{self, Mesh, Point, Quality};
use crate::scene::adapt::{self, Lengths};
use crate::scene::checks::check_flow;
use crate::scene::initial::{self, InitialFlow};
use crate::scene::measure::{self, Probes};
use crate::scene::pacing::pacing;
use crate::scene::plan::{self, Plan};
use crate::scene::problem::{
    Advice, ElasticWave, Facts, Gap, Limits, Moment, Problem, ProfileColumn,
};
use crate::scene::redistance::redistance;
use crate::scene::remedies::{of_step, tables_of, with_keys};
use crate::scene::row::Row;
use crate::scene::schema::WALLS;
use crate::scene::sides::spread;
use crate::scene::site::{Site, vector, wall_facets};
use crate::scene::start::start;
use crate::scene::view::View;
use crate::scene::{CONVECTED, Scene};
use crate::sim::{Energies, EnergyBalance, Simulation, SimulationSettings, State, Transfer};
use crate::structure::Structure;
use nalgebra::SVector;
use std::any::Any;
use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

/// Number of times at which prescribed velocities are checked to balance.
const INSTANTS: usize = 16;
/// Default relative residual of iterations with an old factor, and with implicit convection.
const RESIDUAL: f64 = 1e-10;
const CONVECTED_RESIDUAL: f64 = 1e-6;

/// The flow of a scene with its structures, ready to run.
pub struct ImmersedFlow<const D: usize = 2> {
    /// The simulation, initially at time 0.
    pub simulation: Simulation<D>,
    /// Warnings before the first step.
    pub warnings: Vec<Warning>,
    /// Largest stable step of the explicit coupling (1.54) at the start, if there is one.
    pub explicit_limit: Option<f64>,
    /// The same once the membranes that have less stretch at the start have some.
    stretched_limit: Option<f64>,
    /// Radius of the circle (in space: sphere) that holds as much as each structure at the start.
    radii: Vec<f64>,
    /// Shortest and longest edge in the bands when the mesh was built.
    pub band_edges: Option<[f64; 2]>,
    /// Half-width of the bands.
    pub thickness: Option<f64>,
    /// Velocity scale from which grad-div was derived, if it was.
    pub velocity_scale: Option<f64>,
    /// Quality of the mesh.
    pub quality: Quality<D>,
    /// The scene.
    pub(in crate::scene) scene: Scene,
    /// Target lengths of an adapted mesh.
    pub(in crate::scene) lengths: Option<Lengths>,
    /// The start, where it is taken from another run.
    initial: Option<InitialFlow<D>>,
    /// Velocities that the scene gives.
    given: scales::Given,
    /// The time that an error of velocity stays, in a flow whose error in time is estimated.
    memory: Option<f64>,
    /// Nodes on the boundary without periodic and open sides, with the longest edge of a cell
    /// there.
    walls: Vec<(u32, f64)>,
    probes: Probes<D>,
    force_sites: Vec<forces::Site<D>>,
    carried_bands: Vec<Option<f64>>,
}

impl<const D: usize> ImmersedFlow<D> {
    /// Builds the flow of a scene.
    ///
    /// # Errors
    /// Of kind `Scene` or `Input`: invalid values, with their position; a scene that does not have
    /// `D` dimensions.
    pub fn new(scene: &Scene) -> Result<ImmersedFlow<D>> {
        check_flow(scene)?;
        let (mut site, lengths) = ground::site::<D>(scene)?;
        let placed = ground::place(scene, &site)?;
        let thickness = ground::thickness(scene, &site, &placed)?;
        let structures = ground::structures(scene, &mut site, placed, thickness)?;
        let initial = initial::flow(scene, &site)?;
        let given = scales::given(scene, &site, &initial.flow.u);
        let scales = [scales::velocity(scene, &site, &given), site.size()];
        let grad_div = scene.numerics.grad_div.unwrap_or_else(|| scales::grad_div(scene, scales));
        let least_energy = scales::least_energy(scene, &site, scales);
        let reynolds = scales::reynolds(scene, scales[0], given.side);
        let convection = scene.convection(reynolds);
        let settings = settings(scene, &site, (grad_div, convection));
        let of_coupling = settings.check_couplings(&structures);
        of_coupling.map_err(|e| scene.blame(&["numerics", "coupling"], e))?;
        let start = start(scene, &site, &initial.given)?;
        site.warnings.extend(start.warnings);
        let Site { mesh, quality, mut warnings, .. } = site;
        let bare = |e: &Error| {
            let unnamed = e.wrong_value().split(", ").any(|n| ["walls", "unnamed"].contains(&n));
            e.cause() == Some(Cause::BareBoundary) && unnamed
        };
        // A mesh may have a part `walls` of its own, which is not the rest of the boundary.
        let own_walls = scene.boundaries.iter().any(|b| b.name == WALLS);
        let of_boundary = |e: Error| match (e.kind(), bare(&e).then(|| mesh::slit(&mesh))) {
            (_, Some(Some(slit))) => {
                let what = "a part of the boundary has no condition: it is no side but a slit";
                let e = Error::scene(what).value(slit.what).remedy(slit.remedy);
                scene.blame(&["mesh"], e)
            }
            (Kind::Scene, _) if e.cause() == Some(Cause::BareBoundary) && own_walls => {
                let plain = Error::scene(e.what()).value(e.wrong_value());
                let remedy = format!(
                    "add {} to the scene: [boundary.walls] is the part of the mesh of this name",
                    tables_of(e.wrong_value())
                );
                scene.blame(&["boundary"], plain.remedy(remedy))
            }
            (Kind::Scene, _) => scene.blame(&["boundary"], e),
            _ => e,
        };
        let flow = initial.flow.clone();
        let mut simulation =
            Simulation::from_flow(&mesh, settings, structures, flow).map_err(of_boundary)?;
        for k in 0..INSTANTS {
            let balanced = simulation.flow().check_outflow(scene.time.end * spread(k));
            balanced.map_err(|e| scene.blame(&["boundary"], e))?;
        }
        redistance(scene, simulation.carried_mut());
        let walls = closed_nodes(&simulation);
        forces::check(scene)?;
        warnings.extend(forces::warnings(scene));
        if convection.is_some() {
            warnings.extend(numbers::coarse(scene, &quality, &given));
            if reynolds > CONVECTED {
                warnings.extend(numbers::unestimated(scene, convection));
            }
        }
        simulation.keep_reactions(!scene.output.forces.is_empty());
        let mut flow = ImmersedFlow {
            band_edges: edges_in_bands(&simulation, thickness),
            probes: Probes::new(scene, &mesh)?,
            // After the probes, which say where a name of a boundary is wrong.
            force_sites: forces::sites(scene, (&mesh, &simulation.settings().conditions))?,
            carried_bands: ground::carried_bands(scene),
            velocity_scale: scene.numerics.grad_div.is_none().then_some(scales[0]),
            scene: scene.clone(),
            explicit_limit: None,
            stretched_limit: None,
            radii: Vec::new(),
            initial: scene.initial.is_some().then_some(initial),
            simulation,
            warnings,
            thickness,
            quality,
            walls,
            lengths,
            given,
            memory: (scene.structures().is_empty() && convection.is_some() && reynolds > CONVECTED)
                .then(|| scales::memory(scene, scales)),
        };
        flow.check_outlets()?;
        flow.explicit_limit = flow.step_limit();
        flow.stretched_limit = flow.limit_when_stretched();
        flow.radii = flow.equal_radii()?;
        let least = scales::least_elastic_energy::<D>(scene, &flow.radii);
        flow.simulation.neglect_energy(least_energy + least);
        if start.impulsive {
            flow.simulation.start_at_once();
        }
        flow.warn_of_waves();
        flow.follow_error(scales).map(|()| flow)
    }

    /// Rejects structures that leave through an open side at the start.
    fn check_outlets(&self) -> Result<()> {
        let Some(name) = self.simulation.leaving().next() else { return Ok(()) };
        let k = self.scene.structures().iter().position(|s| s.name() == name).unwrap_or(0);
        let [list, number] = self.scene.structure_keys(k);
        let e = Error::scene(format!("`{name}` is at an open side, where it would exert no force"))
            .value("less than one edge of the mesh, or its band, from the side")
            .remedy(
                "move the shape away from the open side, or take a finer mesh or a longer domain",
            );
        Err(self.scene.blame(&[&list, &number, "shape"], e))
    }

    /// Enables adaptive steps if the scene gives a tolerance.
    fn follow_error(&mut self, scales: [f64; 2]) -> Result<()> {
        let Some(tolerance) = self.scene.time.tolerance else { return Ok(()) };
        let memory = scales::memory(&self.scene, scales);
        let pacing = pacing(&self.scene, [tolerance, memory], scales);
        self.simulation.pace(pacing).map_err(|e| self.scene.blame(&["time", "tolerance"], e))
    }

    /// A view of the current state.
    pub(in crate::scene) fn view(&self) -> View<'_, D> {
        View {
            tables: &self.scene,
            carried: self.simulation.carried(),
            state: self.simulation.state(),
            flow: Some(self.simulation.flow()),
            thickness: self.thickness,
            carried_bands: &self.carried_bands,
        }
    }

    /// Transfers the problem to another mesh of the domain.
    fn continue_on(&mut self, mesh: Mesh<D>, transfer: Transfer) -> Result<()> {
        let this: &mut dyn Any = self;
        let (Some(flow), Some(mesh)) =
            (this.downcast_mut::<ImmersedFlow<2>>(), crate::base::same(mesh))
        else {
            return Err(crate::base::Error::internal("a mesh of tetrahedra was adapted"));
        };
        flow.simulation = flow.simulation.on_mesh(&Arc::new(mesh), transfer)?;
        let sim = &flow.simulation;
        flow.band_edges = edges_in_bands(sim, flow.thickness);
        (flow.quality, _) = mesh::check(sim.space().mesh());
        flow.walls = closed_nodes(sim);
        flow.probes = Probes::new(&flow.scene, sim.space().mesh())?;
        let site = (&**sim.space().mesh(), &sim.settings().conditions);
        flow.force_sites = forces::sites(&flow.scene, site)?;
        Ok(())
    }

    /// Measures energies, their balance, and data of the step.
    fn measure_flow(&self, row: &mut Row) {
        let (sim, state) = (&self.simulation, self.simulation.state());
        let e = state.energies;
        row.put("energy_kinetic", e.kinetic);
        row.put("energy_elastic", e.elastic);
        row.put("dissipation", e.dissipation);
        row.put("energy_balance", state.balance.residual(&e));
        if self.scene.acting().next().is_some() {
            row.put("elastic_balance", state.balance.elastic_residual(&e));
        }
        row.put("work", state.balance.work);
        row.put("velocity_max", sim.largest_speed());
        row.put("divergence", e.divergence);
        row.put("cfl", sim.courant());
        if let Some(memory) = self.memory {
            row.put("time_error", sim.time_error(memory));
        }
        let over_limit = self.step_limit().map_or(0.0, |limit| sim.settings().dt / limit);
        row.put("step_over_limit", over_limit);
    }
}

impl<const D: usize> Problem for ImmersedFlow<D> {
    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
    fn plan(&mut self) -> Result<Plan> {
        with_keys(self.simulation.analyse())?;
        let mesh = plan::mesh(&self.scene, &self.view(), (&self.quality, self.lengths.as_ref()));
        let flow = FlowPlan {
            scene: &self.scene,
            sim: &self.simulation,
            view: self.view(),
            limits: self.limits(),
            waves: self.elastic_waves(),
            numbers: self.find_numbers().into_iter().map(|n| n.line).collect(),
            velocity_scale: self.velocity_scale,
            start: self
                .initial
                .as_ref()
                .and_then(|i| i.in_words(&self.scene, self.simulation.space())),
        };
        Ok(Plan::new(std::iter::once(mesh).chain(flow.sections())))
    }
    fn limits(&self) -> Limits {
        let ImmersedFlow { thickness, band_edges, explicit_limit, stretched_limit, .. } = *self;
        Limits { thickness, band_edges, explicit_limit, stretched_limit }
    }
    fn step(&mut self) -> Result<StepReport> {
        of_step(self.simulation.step(), || self.advice())
    }
    fn moment(&self) -> Moment {
        let (sim, state) = (&self.simulation, self.simulation.state());
        Moment {
            steps: state.steps,
            time: state.time,
            dt: sim.settings().dt,
            at_instant: sim.is_at_instant(),
            done: sim.is_done(),
            rejected: state.pace.map(|clock| clock.rejected),
        }
    }
    fn row(&self) -> Result<Row> {
        let (mut row, view) = (Row::default(), self.view());
        measure::structures(&view, self.scene.structures(), &mut row)?;
        self.measure_flow(&mut row);
        measure::maps(&view, &mut row);
        if self.scene.adapt.is_some() {
            row.put("unknowns", self.simulation.flow().numbering().order() as f64);
            row.put("energy_transferred", self.simulation.state().balance.transferred);
        }
        self.probes.measure(&view, &mut row);
        forces::measure(&self.simulation, (&self.scene, &self.force_sites), &mut row)?;
        measure::rest(&view, &mut row)?;
        if self.scene.time.tolerance.is_some() {
            row.put("step", self.simulation.settings().dt);
        }
        Ok(row)
    }
    fn profile(&self, k: usize) -> Vec<ProfileColumn> {
        self.probes.profile(&self.view(), k)
    }
    fn profile_points(&self, k: usize) -> Vec<Vec<f64>> {
        self.probes.points(k)
    }
    fn write_fields(&self, path: &Path) -> Result<()> {
        fields::write(path, &self.view(), None, self.simulation.nodal_materials())
    }
    fn write_boundaries(&self, path: &Path) -> Result<()> {
        interfaces::write_boundaries(path, self.simulation.space().mesh())
    }
    fn follow(&mut self) -> Result<bool> {
        let this: &mut dyn Any = self;
        let Some(flow) = this.downcast_mut::<ImmersedFlow<2>>() else { return Ok(false) };
        let edges = flow.band_edges;
        let next = adapt::outgrown(&flow.scene, flow.lengths.as_ref(), &flow.view(), edges)?;
        let Some((mesh, transfer)) = next else { return Ok(false) };
        flow.continue_on(mesh, transfer).map(|()| true)
    }
    fn mesh_hash(&self) -> u64 {
        fnv1a(&self.simulation.carried().mesh().to_bytes())
    }
    fn start_hash(&self) -> Option<u64> {
        self.initial.as_ref().map(InitialFlow::hash)
    }
    fn write_start(&self, path: &Path) -> Result<()> {
        self.initial.as_ref().map_or(Ok(()), |start| start.write(path, self.simulation.space()))
    }
    fn save(&self, tag: u64) -> [Vec<u8>; 2] {
        let mesh = adapt::mesh_to_bytes(&self.scene, self.simulation.space().mesh());
        [mesh, self.simulation.state().to_bytes(tag)]
    }
    fn restore(
        &mut self,
        [mesh, state]: [&[u8]; 2],
        tag: u64,
        edges: Option<[f64; 2]>,
    ) -> Result<()> {
        if let Some((mesh, transfer)) = adapt::mesh_from_bytes(&self.scene, mesh)? {
            self.continue_on(mesh, transfer)?;
        }
        with_keys(State::from_bytes(state, tag).and_then(|state| self.simulation.restore(state)))?;
        self.band_edges = edges.or(self.band_edges);
        Ok(())
    }
    fn energies(&self) -> Option<(Energies, EnergyBalance)> {
        let state = self.simulation.state();
        Some((state.energies, state.balance))
    }
    fn take_costs(&mut self) -> ([f64; PHASES.len()], u64) {
        self.simulation.take_costs()
    }
    fn facts(&self) -> Facts {
        let (sim, flow) = (&self.simulation, self.simulation.flow());
        let velocity = flow.numbering().first_pressure();
        let pressure = flow.numbering().order() - velocity;
        Facts {
            cells: sim.space().mesh().cell_count(),
            edge: self.quality.greatest_diameter.value,
            memory: sim.bytes(),
            unknowns: [velocity, pressure, fields::level_set_unknowns(&self.view())],
            factor: flow.solver_size().map(|(_, size)| (size.entries, size.value_bytes())),
            adapted: self.lengths.is_some(),
        }
    }
    fn at_walls(&self) -> Vec<(String, Warning)> {
        let fields = &self.simulation.state().fields;
        let at_wall = |s: &dyn Structure<D>| {
            let phi = s.level_set().map_or(&[][..], |id| fields.scalar(id));
            let (band, name) = (s.reach() > 0.0, s.name());
            let near = |v: f64| if band { v.abs() < s.reach() } else { v < 0.0 };
            let reached = |(n, _): &(u32, f64)| phi.get(*n as usize).is_some_and(|v| near(*v));
            if !s.acts() || !self.walls.iter().any(reached) {
                return None;
            }
            let warning = match band {
                true => Warning::new(
                    format!("The band of `{name}` reached the boundary"),
                    "Its stress is cut off there: enlarge the mesh or give a smaller thickness",
                ),
                false => Warning::new(
                    format!("`{name}` reached the boundary"),
                    "What lies beyond is lost: enlarge the mesh, or make a side that fluid leaves \
                     through open",
                ),
            };
            Some((name.to_string(), warning))
        };
        self.simulation.structures().iter().filter_map(|s| at_wall(&**s)).collect()
    }
    fn waves(&self) -> Vec<ElasticWave> {
        self.elastic_waves()
    }
    fn numbers(&self) -> Vec<(String, f64)> {
        self.find_numbers().into_iter().flat_map(|n| n.values).collect()
    }
    fn leaving(&self) -> Vec<String> {
        self.simulation.leaving().map(str::to_string).collect()
    }
    fn hasty(&self, row: &Row) -> Option<Warning> {
        self.find_haste(row)
    }
    fn inflow(&self) -> Option<(String, Warning)> {
        self.find_inflow()
    }
    fn force_gaps(&self, row: &Row) -> Result<Vec<(String, Gap)>> {
        forces::gaps(&self.simulation, (&self.scene, &self.force_sites), row)
    }
    fn unresolved(&self) -> Result<Vec<(String, Warning)>> {
        let kinds = self.scene.structures();
        let wrinkles = |k: usize| kinds[k].traits().wrinkles;
        unresolved(&self.simulation, (self.thickness, &self.walls), wrinkles)
    }
    fn plane_mesh(&self) -> Option<&Mesh<2>> {
        ground::plane(self.simulation.space().mesh())
    }
    fn derived(&self) -> Vec<(&'static str, f64)> {
        let grad_div = ("grad_div", self.simulation.settings().grad_div);
        let thickness = self.thickness.map(|eps| ("thickness", eps));
        std::iter::once(grad_div).chain(thickness).collect()
    }
    fn advice(&self) -> Advice {
        flow_advice::advice(&self.scene)
    }
}

/// Nodes on the boundary without periodic and open sides, with the longest edge of their cells.
fn closed_nodes<const D: usize>(sim: &Simulation<D>) -> Vec<(u32, f64)> {
    let (space, mesh) = (sim.space(), sim.space().mesh());
    let open: HashSet<u32> = sim.outlet_nodes().collect();
    let walls = wall_facets(mesh, sim.carried().translations());
    let nodes = walls.flat_map(|(_, facet)| {
        let edge = mesh.diameter(facet.cell as usize);
        space.facet_nodes(facet).map(move |n| (n, edge))
    });
    nodes.filter(|(n, _)| !open.contains(n)).collect()
}

/// Shortest and longest edge in the bands of the acting structures.
fn edges_in_bands<const D: usize>(sim: &Simulation<D>, thickness: Option<f64>) -> Option<[f64; 2]> {
    let eps = thickness?;
    let fields = &sim.state().fields;
    let acting = sim.structures().iter().filter(|s| s.acts()).filter_map(|s| s.level_set());
    let edges = acting.filter_map(|id| band_edges(sim.space(), fields.scalar(id), eps));
    let edges = edges.map(|e| [e.smallest, e.largest]);
    edges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

fn settings<const D: usize>(
    scene: &Scene,
    site: &Site<'_, D>,
    (grad_div, convection): (f64, Option<ConvectionScheme>),
) -> SimulationSettings<D> {
    let (fluid, numerics) = (&scene.fluid, &scene.numerics);
    let body_force = fluid.has_force().then(|| {
        let f = vector(&fluid.force);
        Arc::new(move |x: &Point<D>, t: f64| f(x, t)) as Arc<BodyForce<D>>
    });
    SimulationSettings {
        order: scene.time.order,
        transport: ground::transport(scene),
        convection,
        grad_div,
        solve_tolerance: numerics.solve_tolerance.unwrap_or(match convection {
            Some(ConvectionScheme::Implicit) => CONVECTED_RESIDUAL,
            _ => RESIDUAL,
        }),
        solver: numerics.solver(),
        quadrature: numerics.quadrature.unwrap_or(QUADRATURE),
        boussinesq: fluid.boussinesq,
        pressure: numerics.pressure,
        gravity: SVector::<f64, D>::from_iterator(fluid.gravity.iter().copied()),
        body_force,
        ..SimulationSettings::new(scene.time.step, scene.outside(), site.conditions.clone())
    }
}
