//! Level sets of a scene in a prescribed velocity.

use super::{fields, ground, interfaces};
use crate::base::{Error, PHASES, Result, Warning, fnv1a, same};
use crate::flow::StepReport;
use crate::mesh::{self, Mesh, Quality};
use crate::scene::Scene;
use crate::scene::adapt::{self, Lengths};
use crate::scene::expression::Expression;
use crate::scene::measure::{self, Probes};
use crate::scene::plan::{self, Plan};
use crate::scene::problem::{Advice, Facts, Limits, Moment, Problem, ProfileColumn};
use crate::scene::redistance::{in_words, redistance};
use crate::scene::remedies::{of_step, with_keys};
use crate::scene::row::Row;
use crate::scene::site::{Site, vector};
use crate::scene::view::View;
use crate::sim::{Advection, State, Transfer};
use crate::transport::Method;
use std::any::Any;
use std::path::Path;
use std::sync::Arc;

/// Level sets of a scene in a prescribed velocity, ready to run.
pub struct Advected<const D: usize = 2> {
    /// The advection, initially at time 0.
    pub advection: Advection<D>,
    /// Warnings before the first step.
    pub warnings: Vec<Warning>,
    /// Quality of the mesh.
    pub quality: Quality<D>,
    pub(in crate::scene) scene: Scene,
    pub(in crate::scene) lengths: Option<Lengths>,
    probes: Probes<D>,
    carried_bands: Vec<Option<f64>>,
    /// True if fluid may come in through the boundary.
    takes_in: bool,
}

impl<const D: usize> Advected<D> {
    /// Builds the advection of a scene.
    ///
    /// # Errors
    /// A velocity without a finite value at some node; shapes that do not lie on the mesh.
    pub fn new(scene: &Scene) -> Result<Advected<D>> {
        let (mut site, lengths) = ground::site::<D>(scene)?;
        let Some(velocity) = &scene.fluid.prescribed_velocity else {
            return Err(Error::internal("no velocity is prescribed"));
        };
        let placed = ground::place(scene, &site)?;
        let structures = ground::structures(scene, &mut site, placed, None)?;
        let takes_in = ground::inflow(scene, &site.mesh, &site.pairs).is_some();
        let Site { mesh, conditions, quality, warnings, .. } = site;
        let velocity = (Arc::new(vector(velocity)) as _, scene.time.step);
        let transport = (ground::transport(scene), &conditions);
        let mut advection = Advection::new(&mesh, velocity, transport, structures)?;
        redistance(scene, advection.carried_mut());
        let (probes, carried_bands) = (Probes::new(scene, &mesh)?, ground::carried_bands(scene));
        let scene = scene.clone();
        Ok(Advected {
            advection,
            warnings,
            quality,
            scene,
            lengths,
            probes,
            carried_bands,
            takes_in,
        })
    }

    /// Transfers the problem to another mesh of the domain.
    fn continue_on(&mut self, mesh: Mesh<D>, transfer: Transfer) -> Result<()> {
        let this: &mut dyn Any = self;
        let (Some(problem), Some(mesh)) = (this.downcast_mut::<Advected<2>>(), same(mesh)) else {
            return Err(Error::internal("a mesh of tetrahedra was adapted"));
        };
        problem.advection = problem.advection.on_mesh(&Arc::new(mesh), transfer)?;
        let mesh = problem.advection.space().mesh();
        (problem.quality, _) = mesh::check(mesh);
        problem.probes = Probes::new(&problem.scene, mesh)?;
        Ok(())
    }

    pub(in crate::scene) fn view(&self) -> View<'_, D> {
        View {
            tables: &self.scene,
            carried: self.advection.carried(),
            state: self.advection.state(),
            flow: None,
            thickness: None,
            carried_bands: &self.carried_bands,
        }
    }
}

impl<const D: usize> Problem for Advected<D> {
    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
    fn plan(&mut self) -> Result<Plan> {
        let (scene, view) = (&self.scene, self.view());
        let velocity = scene.fluid.prescribed_velocity.iter().flatten();
        let velocity: Vec<&str> = velocity.map(Expression::text).collect();
        let no_flow = format!("no flow: the velocity is prescribed as ({})", velocity.join(", "));
        let solved = std::iter::once(no_flow).chain(plan::structures(scene));
        let memory = self.advection.bytes() as f64 / 1e6;
        let unknowns = plan::level_sets(&view).into_iter().chain(plan::map_memory(&view));
        let memory = format!("no matrix of a flow; memory about {memory:.0} MB");
        let numerics = [
            format!(
                "step {}, characteristics by the Runge-Kutta rule of order 4 through the \
                 prescribed velocity",
                scene.time.step
            ),
            plan::transport(scene, &view),
        ];
        let mut left_out = vec![
            "flow, pressure, boundary conditions and every matrix of them: the velocity is \
             prescribed"
                .into(),
        ];
        if in_words(scene).is_none() {
            left_out.push(
                "redistancing: the slope of the level set is the stretch of the interface".into(),
            );
        }
        left_out.extend(plan::third_dimension(D));
        Ok(Plan::new([
            plan::mesh(scene, &view, (&self.quality, self.lengths.as_ref())),
            ("Solved", solved.chain(plan::boundaries(scene)).collect()),
            ("Unknowns", unknowns.chain([memory]).collect()),
            ("Numerics", numerics.into_iter().chain(in_words(scene)).collect()),
            ("Left out", left_out),
            ("Steps", vec![plan::steps(scene)]),
        ]))
    }
    fn limits(&self) -> Limits {
        Limits::default()
    }
    fn step(&mut self) -> Result<StepReport> {
        of_step(self.advection.step(), || self.advice())
    }
    fn moment(&self) -> Moment {
        Moment::regular(self.advection.state().steps, self.advection.time(), self.advection.dt())
    }
    fn row(&self) -> Result<Row> {
        let (mut row, view, advection) = (Row::default(), self.view(), &self.advection);
        measure::structures(&view, self.scene.structures(), &mut row)?;
        row.put("velocity_max", advection.largest_speed());
        row.put("divergence", view.carried.divergence(&view.state.flow.u));
        row.put("cfl", advection.courant());
        measure::maps(&view, &mut row);
        if self.scene.adapt.is_some() {
            row.put("unknowns", 0.0);
            row.put("energy_transferred", 0.0);
        }
        self.probes.measure(&view, &mut row);
        measure::rest(&view, &mut row)?;
        Ok(row)
    }
    fn profile(&self, k: usize) -> Vec<ProfileColumn> {
        self.probes.profile(&self.view(), k)
    }
    fn profile_points(&self, k: usize) -> Vec<Vec<f64>> {
        self.probes.points(k)
    }
    fn write_fields(&self, path: &Path) -> Result<()> {
        fields::write(path, &self.view(), None, [None, None])
    }
    fn write_boundaries(&self, path: &Path) -> Result<()> {
        interfaces::write_boundaries(path, self.advection.space().mesh())
    }
    fn follow(&mut self) -> Result<bool> {
        let this: &mut dyn Any = self;
        let Some(problem) = this.downcast_mut::<Advected<2>>() else { return Ok(false) };
        let (scene, lengths) = (&problem.scene, problem.lengths.as_ref());
        let next = adapt::outgrown(scene, lengths, &problem.view(), None)?;
        let Some((mesh, transfer)) = next else { return Ok(false) };
        problem.continue_on(mesh, transfer).map(|()| true)
    }
    fn mesh_hash(&self) -> u64 {
        fnv1a(&self.advection.carried().mesh().to_bytes())
    }
    fn save(&self, tag: u64) -> [Vec<u8>; 2] {
        let mesh = adapt::mesh_to_bytes(&self.scene, self.advection.space().mesh());
        [mesh, self.advection.state().to_bytes(tag)]
    }
    fn restore(&mut self, [mesh, state]: [&[u8]; 2], tag: u64, _: Option<[f64; 2]>) -> Result<()> {
        if let Some((mesh, transfer)) = adapt::mesh_from_bytes(&self.scene, mesh)? {
            self.continue_on(mesh, transfer)?;
        }
        with_keys(State::from_bytes(state, tag).and_then(|state| self.advection.restore(state)))
    }
    fn take_costs(&mut self) -> ([f64; PHASES.len()], u64) {
        (self.advection.take_costs(), 0)
    }
    fn facts(&self) -> Facts {
        Facts {
            cells: self.advection.space().mesh().cell_count(),
            edge: self.quality.greatest_diameter.value,
            memory: self.advection.bytes(),
            unknowns: [0, 0, fields::level_set_unknowns(&self.view())],
            factor: None,
            adapted: self.lengths.is_some(),
        }
    }
    fn plane_mesh(&self) -> Option<&Mesh<2>> {
        ground::plane(self.advection.space().mesh())
    }
    fn derived(&self) -> Vec<(&'static str, f64)> {
        vec![("grad_div", 0.0)]
    }
    fn leaving(&self) -> Vec<String> {
        self.advection.leaving().map(str::to_string).collect()
    }
    fn advice(&self) -> Advice {
        let numerics = &self.scene.numerics;
        let bound = self.takes_in || self.scene.adapt.is_some() || numerics.redistance.is_some();
        let mut choices = vec!["a finer mesh".to_string()];
        match numerics.transport {
            Method::Composed => {}
            _ if !bound => choices.push("numerics.transport = \"composed\"".into()),
            Method::Projected => choices.push("numerics.transport = \"nodal\"".into()),
            Method::Nodal => {}
        }
        if numerics.transport != Method::Composed && numerics.redistance.is_none() {
            choices.push("numerics.redistance = { method = \"exact\", volume = true }".into());
        }
        let blow_up = vec![
            "a smaller time.step".to_string(),
            "a fluid.prescribed_velocity that stays bounded".into(),
        ];
        Advice { area: choices, blow_up, ..Advice::default() }
    }
}
