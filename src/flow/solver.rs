//! One step of the coupled velocity-pressure system.

use super::coefficient::Coefficient;
use super::step::{FlowState, Step, StepReport};
use super::term::MomentumTerm;
use crate::base::{Error, PHASES, Phase, Phases, Result, parallel};
use crate::fem::{
    At, Basis, Cells, Conditions, Numbering, Rule, Space, VectorForm, add_surface_matrix, add_surface_vector,
    assemble_flow_matrix, assemble_scalar, assemble_source, assemble_vector,
};
use crate::linalg::{Change, Factor, LaggedFactor, LaggedReport, Ledger, Ordering, SymmetricMatrix};
use crate::mesh::Mesh;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Assembles and solves the coupled system; keeps the factor while the matrix does not change.
pub struct FlowSolver<const D: usize> {
    velocity: Basis<D>,
    /// The velocity basis at the points of a rule that is exact for products of gradients.
    gradients: Basis<D>,
    pressure: Basis<D>,
    numbering: Numbering<D>,
    /// Weight of the grad-div term, in units of viscosity.
    grad_div: f64,
    density: Coefficient,
    viscosity: Coefficient,
    /// The part of the matrix that stays, and `weight / dt` that it was made with; NaN when it is stale.
    base: Option<(SymmetricMatrix, f64)>,
    matrix: SymmetricMatrix,
    factor: Option<LaggedFactor>,
    /// Relative residual of iterations with an old factor; 0 where every matrix is to be factored.
    tolerance: f64,
    /// Whether `factor` belongs to `base` alone.
    factor_is_base: bool,
    /// `weight / dt` of the matrix that was factored last.
    factored_weight: f64,
    /// Whether that matrix was `base` alone.
    factored_plain: bool,
    /// Whether the step will change.
    expects_changes: bool,
    boundary_cells: Vec<u32>,
    work: Work<D>,
    phases: Phases,
    /// How often the factor was read, each time twice.
    substitutions: u64,
}

/// Buffers of a step.
struct Work<const D: usize> {
    load: Vec<SVector<f64, D>>,
    residual: Vec<SVector<f64, D>>,
    continuity: Vec<f64>,
    lift: Vec<SVector<f64, D>>,
    rhs: Vec<f64>,
    x: Vec<f64>,
    vectors: Vec<SVector<f64, D>>,
    scalars: Vec<f64>,
    pressure_mass: Vec<f64>,
}

impl<const D: usize> FlowSolver<D> {
    /// A solver on the spaces of `velocity` (P2) and `pressure` (P1), integrated with `rule`.
    ///
    /// `grad_div` is the factor `gamma >= 0` of the term `gamma (div u, div v)`: without it P2-P1 conserves mass only on average,
    /// and a membrane gains energy.
    ///
    /// # Errors
    /// Wrong boundary names or conditions.
    pub fn new(
        velocity: &Arc<Space<D>>,
        pressure: &Arc<Space<D>>,
        rule: &Arc<Rule>,
        conditions: &Conditions<D>,
        grad_div: f64,
    ) -> Result<FlowSolver<D>> {
        let numbering = Numbering::new(velocity, pressure, conditions)?;
        let mesh = velocity.mesh();
        let groups = (0..mesh.cell_count()).map(|c| {
            let mut list = Vec::new();
            numbering.cell_unknowns(velocity.cell_nodes(c), Some(pressure.cell_nodes(c)), &mut list);
            list
        });
        let matrix = SymmetricMatrix::from_groups(numbering.order(), groups)?;
        let mut prescribed = vec![false; velocity.len()];
        numbering.prescribed_nodes().for_each(|n| prescribed[n as usize] = true);
        let touches = |c: usize| velocity.cell_nodes(c).iter().any(|&n| prescribed[n as usize]);
        let boundary_cells = (0..mesh.cell_count()).filter(|&c| touches(c)).map(|c| c as u32).collect();
        let gradients = Basis::new(velocity, &Arc::new(Rule::simplex(D, 2)));
        let (velocity, pressure) = (Basis::new(velocity, rule), Basis::new(pressure, rule));
        let nodes = velocity.space().len();
        let mut pressure_mass = vec![0.0; pressure.space().len()];
        assemble_scalar(&pressure, Cells::All, &mut pressure_mass, &mut Vec::new(), |_| (1.0, SVector::zeros()));
        let zero = SVector::<f64, D>::zeros();
        let work = Work {
            load: vec![zero; nodes],
            residual: vec![zero; nodes],
            continuity: vec![0.0; pressure.space().len()],
            lift: vec![zero; nodes],
            rhs: vec![0.0; numbering.order()],
            x: vec![0.0; numbering.order()],
            vectors: Vec::new(),
            scalars: Vec::new(),
            pressure_mass,
        };
        Ok(FlowSolver {
            velocity,
            gradients,
            pressure,
            numbering,
            grad_div,
            density: Coefficient::Constant(1.0),
            viscosity: Coefficient::Constant(1.0),
            base: None,
            matrix,
            factor: None,
            tolerance: 0.0,
            factor_is_base: false,
            factored_weight: f64::NAN,
            factored_plain: false,
            expects_changes: false,
            boundary_cells,
            work,
            phases: Phases::default(),
            substitutions: 0,
        })
    }

    /// Lets a matrix that changes from step to step be solved for by iterations with an old factor, to the relative residual
    /// `tolerance`, where that is cheaper than factoring; 0 (as at the start) factors each. To be called before the first step.
    pub fn iterate(&mut self, tolerance: f64) {
        self.tolerance = tolerance;
    }
    /// Tells that the step will change, and with it the matrix: no change of it is taken to last.
    pub fn expect_changes(&mut self) {
        self.expects_changes = true;
    }
    /// Makes the next solve factor its matrix.
    pub fn forget_factor(&mut self) {
        (self.factor_is_base, self.factored_plain, self.factored_weight) = (false, false, f64::NAN);
        self.factor.iter_mut().for_each(LaggedFactor::forget);
    }
    /// Sets density and viscosity (dynamic); the matrix is made anew when they are not constant or have changed.
    pub fn set_materials(&mut self, density: Coefficient, viscosity: Coefficient) {
        if density != self.density || viscosity != self.viscosity || !density.is_constant() || !viscosity.is_constant()
        {
            // No weight equals NaN: the values are stale, the storage is kept.
            self.base.iter_mut().for_each(|(_, weight)| *weight = f64::NAN);
            self.factored_plain = false;
        }
        self.density = density;
        self.viscosity = viscosity;
    }
    /// The velocity basis at the points of the rule.
    pub fn velocity(&self) -> &Basis<D> {
        &self.velocity
    }
    /// The pressure basis at the points of the rule.
    pub fn pressure(&self) -> &Basis<D> {
        &self.pressure
    }
    /// The unknowns.
    pub fn numbering(&self) -> &Numbering<D> {
        &self.numbering
    }
    /// Density.
    pub fn density(&self) -> &Coefficient {
        &self.density
    }
    /// Viscosity.
    pub fn viscosity(&self) -> &Coefficient {
        &self.viscosity
    }
    /// Whether the factor in use is that of a matrix that stays.
    pub fn is_constant(&self) -> bool {
        !self.expects_changes && self.factor_is_base && self.density.is_constant() && self.viscosity.is_constant()
    }
    /// Weight of the grad-div term.
    pub fn grad_div(&self) -> f64 {
        self.grad_div
    }
    /// Stored entries of the matrix (one triangle).
    pub fn matrix_nonzeros(&self) -> usize {
        self.matrix.nonzeros()
    }
    /// The factor, once there is one.
    pub fn factor(&self) -> Option<&Factor> {
        self.factor.as_ref().map(LaggedFactor::factor)
    }
    /// How a matrix that changes from step to step is solved for, with a passive verb.
    pub fn way_of_solving(&self) -> String {
        match &self.factor {
            Some(f) if f.may_iterate() => format!(
                "solved by GMRES with an older factor to the relative residual {:e}, or factored anew, whichever is cheaper by count: \
                 a factorisation costs {:.1} iterations",
                self.tolerance,
                f.cost()
            ),
            _ => "factored in each step on a kept pattern".into(),
        }
    }
    /// Bytes of the factor and of the iterations with it.
    pub fn factor_bytes(&self) -> usize {
        self.factor.as_ref().map_or(0, LaggedFactor::bytes)
    }
    /// The books of the choice between iterations and a factorisation.
    pub fn ledger(&self) -> Ledger {
        self.factor.as_ref().map_or(Ledger::default(), LaggedFactor::ledger)
    }
    /// Seconds of all processors by phase since it was asked last, and how often the factor was read since, each time twice.
    pub fn take_costs(&mut self) -> ([f64; PHASES.len()], u64) {
        (self.phases.take(), std::mem::take(&mut self.substitutions))
    }
    /// Fluid at rest.
    pub fn at_rest(&self) -> FlowState<D> {
        FlowState { u: vec![SVector::zeros(); self.velocity.space().len()], p: vec![0.0; self.pressure.space().len()] }
    }
    /// Puts the prescribed velocities at time `t` into `u`.
    pub fn impose(&self, t: f64, u: &mut [SVector<f64, D>]) {
        let mut lift = vec![SVector::zeros(); u.len()];
        let space = self.velocity.space();
        self.numbering.lift(space, t, &mut lift);
        for n in self.numbering.prescribed_nodes() {
            u[n as usize] = lift[n as usize];
        }
    }

    /// The viscous, grad-div and inertial parts of the bilinear form.
    fn form<'a>(
        &'a self,
        weight: f64,
    ) -> impl Fn(&At<D>, &SVector<f64, D>, &SMatrix<f64, D, D>) -> VectorForm<D> + Sync + 'a {
        move |at, u, grad| {
            let mut stress = (grad + grad.transpose()) * self.viscosity.at(at);
            let divergence = self.grad_div * grad.trace();
            for i in 0..D {
                stress[(i, i)] += divergence;
            }
            (u * (weight * self.density.at(at)), stress)
        }
    }

    /// Assembles the part of the matrix that stays, for `weight / dt`, and analyses it without factoring.
    pub fn analyse(&mut self, weight: f64) -> Result<()> {
        self.phases.begin();
        self.assemble_base(weight)?;
        self.phases.end(Phase::Assembly);
        let Some((base, _)) = &self.base else { return Err(Error::internal("the flow matrix is missing")) };
        if self.factor.is_none() {
            let ordering = Ordering::saddle_point(base, self.numbering.first_pressure())?;
            self.factor = Some(LaggedFactor::analyse(base, ordering, self.tolerance)?);
            self.factor_is_base = false;
        }
        self.phases.end(Phase::Factor);
        Ok(())
    }

    fn assemble_base(&mut self, weight: f64) -> Result<()> {
        if self.base.as_ref().is_some_and(|(_, w)| *w == weight) {
            return Ok(());
        }
        let mut matrix = match self.base.take() {
            Some((m, _)) => m,
            None => self.matrix.clone(),
        };
        matrix.zero();
        let form = self.form(weight);
        assemble_flow_matrix(
            &self.velocity,
            Some(&self.pressure),
            &self.numbering,
            Cells::All,
            &mut matrix,
            &mut Vec::new(),
            form,
        )?;
        self.base = Some((matrix, weight));
        self.factor_is_base = false;
        Ok(())
    }

    /// Makes the matrix fit the step. Returns what that means for the factor.
    fn prepare(&mut self, weight: f64, terms: &[&dyn MomentumTerm<D>]) -> Result<Change> {
        let implicit = terms.iter().any(|t| t.is_implicit());
        self.analyse(weight)?;
        if self.factor_is_base && !implicit {
            return Ok(Change::None);
        }
        let Some((base, _)) = &self.base else { return Err(Error::internal("the flow matrix is missing")) };
        self.matrix.copy_values_from(base)?;
        for term in terms.iter().filter(|t| t.is_implicit()) {
            assemble_flow_matrix(
                &self.velocity,
                None,
                &self.numbering,
                term.cells(),
                &mut self.matrix,
                &mut self.work.scalars,
                |at, _, grad| (SVector::zeros(), term.stiffness(at, grad)),
            )?;
            let (space, numbering) = (self.velocity.space(), &self.numbering);
            add_surface_matrix(space, numbering, term.surface(), &mut self.matrix, |p, grad| {
                term.surface_stiffness(p, grad)
            })?;
        }
        self.phases.end(Phase::Assembly);
        let constant = !implicit && self.density.is_constant() && self.viscosity.is_constant();
        self.factor_is_base = constant && self.factored_plain && self.factored_weight == weight;
        if self.factor_is_base {
            return Ok(Change::None);
        }
        // The formula begins with another coefficient than it goes on with: a factor of the first step would serve badly ever after.
        let lasting = !self.expects_changes && (constant || self.factored_weight != weight);
        Ok(if lasting { Change::Lasting } else { Change::Passing })
    }

    /// Makes the factor that a run had when it was interrupted: of `weight / dt`, the materials that were set last and `terms`.
    ///
    /// # Errors
    /// A factorisation that fails.
    pub fn restore_factor(&mut self, weight: f64, terms: &[&dyn MomentumTerm<D>], ledger: Ledger) -> Result<()> {
        self.prepare(weight, terms)?;
        let Some(factor) = &mut self.factor else { return Err(Error::internal("the flow matrix was not analysed")) };
        self.factored_weight = weight;
        self.factored_plain = terms.iter().all(|t| !t.is_implicit());
        factor.restore(&self.matrix, ledger)
    }

    /// Right-hand side before boundary values are brought in: one vector a node, into `work.load`.
    fn assemble_load(&mut self, step: &Step<'_, D>) {
        self.work.load.fill(SVector::zeros());
        self.assemble_inertia(step);
        let (velocity, density, work) = (&self.velocity, &self.density, &mut self.work);
        let (load, scratch, space) = (&mut work.load, &mut work.vectors, velocity.space());
        if step.body_force.is_some() || step.gravity.norm() > 0.0 {
            assemble_source(velocity, load, scratch, |c, cell| {
                for q in 0..velocity.rule().len() {
                    let at = velocity.at(c, q);
                    let force = step.body_force.map_or(SVector::zeros(), |f| f(&at.x, step.time));
                    cell.add(q, step.gravity * density.at(&at) + force);
                }
            });
        }
        self.phases.end(Phase::Assembly);
        for term in step.terms {
            assemble_vector(velocity, term.cells(), load, scratch, |at| {
                let (f0, mut f1) = term.force(at);
                if let (true, Some(u)) = (term.is_implicit(), step.predicted) {
                    f1 += term.stiffness(at, &velocity.jacobian(at, u));
                }
                (f0, f1)
            });
            add_surface_vector(space, term.surface(), load, |p| {
                let (f0, mut f1) = term.surface_force(p);
                if let (true, Some(u)) = (term.is_implicit(), step.predicted) {
                    f1 += term.surface_stiffness(p, &space.jacobian(u, p.at.cell, &p.at.barycentric));
                }
                (f0, f1)
            });
        }
        self.phases.end(Phase::Force);
    }

    /// `rho sum weight u o X / dt`, each earlier velocity gathered once a cell: most feet lie in the cell of their points.
    fn assemble_inertia(&mut self, step: &Step<'_, D>) {
        let (velocity, density, work) = (&self.velocity, &self.density, &mut self.work);
        let (space, points) = (velocity.space(), velocity.rule().len());
        if step.history.is_empty() {
            return;
        }
        assemble_source(velocity, &mut work.load, &mut work.vectors, |c, cell| {
            for h in step.history {
                let own = space.on_cell(h.u, c);
                for q in 0..points {
                    let u = match h.feet.map(|feet| feet.get(c * points + q)) {
                        None => own.combined(velocity.values(q)),
                        Some(foot) if foot.cell as usize == c => own.value(&foot.barycentric),
                        Some(foot) => space.value(h.u, foot.cell as usize, &foot.barycentric),
                    };
                    cell.add(q, u * (h.weight * density.value(c, q) / step.dt));
                }
            }
        });
    }

    /// Takes one step and writes the new velocity and pressure into `state`, whose values iterations start from.
    ///
    /// # Errors
    /// A factorisation or a solve that fails, boundary values that let more fluid in than out.
    pub fn step(&mut self, step: &Step<'_, D>, state: &mut FlowState<D>) -> Result<StepReport> {
        let change = self.prepare(step.weight / step.dt, step.terms)?;
        self.phases.begin();
        self.assemble_load(step);
        let mut work = std::mem::replace(&mut self.work, Work::empty());
        let result = self.solve(step, change, &mut work, state);
        self.work = work;
        let LaggedReport { solve, refactored, substitutions, factoring } = result?;
        self.substitutions += substitutions as u64;
        if refactored {
            self.factored_weight = step.weight / step.dt;
            self.factor_is_base = step.terms.iter().all(|t| !t.is_implicit());
            self.factored_plain = self.factor_is_base;
        }
        self.phases.end(Phase::Solve);
        self.phases.transfer(factoring, Phase::Solve, Phase::Factor);
        Ok(StepReport { solve, refactored })
    }

    fn solve(
        &mut self,
        step: &Step<'_, D>,
        change: Change,
        work: &mut Work<D>,
        state: &mut FlowState<D>,
    ) -> Result<LaggedReport> {
        work.residual.copy_from_slice(&work.load);
        work.continuity.fill(0.0);
        work.lift.fill(SVector::zeros());
        if !self.numbering.is_homogeneous() {
            self.bring_in_boundary_values(step, work)?;
        }
        self.numbering.gather(&work.residual, &work.continuity, &mut work.rhs);
        let Some(factor) = &mut self.factor else { return Err(Error::internal("the flow matrix was not factored")) };
        if change == Change::Passing {
            self.numbering.restrict(&state.u, &state.p, &work.lift, &mut work.x);
        }
        let report = factor.solve(&self.matrix, change, &work.rhs, &mut work.x).map_err(|e| {
            let place = format!("time {:.6}", step.time);
            if e.place().is_empty() { e.at(place) } else { e }
        })?;
        self.numbering.scatter(&work.x, &work.lift, &mut state.u, &mut state.p);
        if !self.numbering.is_open() {
            let mass: f64 = work.pressure_mass.iter().sum();
            let mean = state.p.iter().zip(&work.pressure_mass).map(|(p, m)| p * m).sum::<f64>() / mass;
            state.p.iter_mut().for_each(|p| *p -= mean);
        }
        Ok(report)
    }

    /// Moves the prescribed velocities `g` to the right-hand side: `- a(g, v)` and `(q, div g)`, less the mean of `div g` when the
    /// boundary is closed, so that what the interpolation of `g` lets through is spread evenly.
    fn bring_in_boundary_values(&mut self, step: &Step<'_, D>, work: &mut Work<D>) -> Result<()> {
        let space = self.velocity.space();
        self.numbering.lift(space, step.time, &mut work.lift);
        if let Some(n) = work.lift.iter().position(|g| g.iter().any(|v| !v.is_finite())) {
            return Err(Error::computation("a prescribed velocity is not a finite number")
                .at(format!("time {:.6}, node at {:?}", step.time, space.nodes()[n].as_slice()))
                .value(format!("{:?}", work.lift[n].as_slice()))
                .remedy("check the velocity expressions of the boundary"));
        }
        let cells = Cells::Some(&self.boundary_cells);
        let g = &work.lift;
        let velocity = &self.velocity;
        let form = self.form(step.weight / step.dt);
        assemble_vector(velocity, cells, &mut work.residual, &mut work.vectors, |at| {
            let grad = velocity.jacobian(at, g);
            let (f0, mut f1) = form(at, &velocity.value(at, g), &grad);
            for term in step.terms.iter().filter(|t| t.is_implicit()) {
                f1 += term.stiffness(at, &grad);
            }
            (-f0, -f1)
        });
        assemble_scalar(&self.pressure, cells, &mut work.continuity, &mut work.scalars, |at| {
            (velocity.jacobian(at, g).trace(), SVector::zeros())
        });
        if !self.numbering.is_open() {
            let mesh = space.mesh();
            let through: f64 = work.continuity.iter().sum();
            let [scale, along] = boundary_flow(mesh, space, g);
            // A wall that moves along itself may have a normal velocity of rounding, such as sin(pi).
            if through.abs() > 1e-3 * scale && scale > 1e-12 * along {
                return Err(Error::scene(
                    "the prescribed velocities let more fluid in than out, and no boundary is open",
                )
                .at(format!("time {:.6}", step.time))
                .value(format!("net outflow {through:e}, gross flow {scale:e}"))
                .remedy("balance the velocities, or set open = true on an outlet"));
            }
            let mean = through / mesh.volume();
            work.continuity.iter_mut().zip(&work.pressure_mass).for_each(|(c, m)| *c -= mean * m);
        }
        Ok(())
    }

    /// Power that the walls put into the flow through prescribed velocities: the sum over nodes of reaction times velocity,
    /// after [`step`](Self::step) with the same data.
    pub fn wall_power(&mut self, step: &Step<'_, D>, state: &FlowState<D>) -> f64 {
        if self.numbering.is_homogeneous() {
            return 0.0;
        }
        // The buffers of the solve are free now.
        let mut r = std::mem::take(&mut self.work.residual);
        let mut scratch = std::mem::take(&mut self.work.vectors);
        self.find_reaction(step, state, Cells::Some(&self.boundary_cells), &mut r, &mut scratch);
        let power = self.numbering.prescribed_nodes().map(|n| r[n as usize].dot(&state.u[n as usize])).sum();
        (self.work.residual, self.work.vectors) = (r, scratch);
        power
    }

    /// Residual of the momentum equation, `a(u, v) - (p, div v) - F(v)`, for all `v` whose support lies in `cells`: at nodes on
    /// a wall, the force of the wall on the fluid. Valid after [`step`](Self::step) with the same data.
    pub fn reaction(&self, step: &Step<'_, D>, state: &FlowState<D>, cells: Cells<'_>) -> Vec<SVector<f64, D>> {
        let mut r = self.work.load.clone();
        self.find_reaction(step, state, cells, &mut r, &mut Vec::new());
        r
    }

    /// [`reaction`](Self::reaction) in place of what `r` holds.
    fn find_reaction(
        &self,
        step: &Step<'_, D>,
        state: &FlowState<D>,
        cells: Cells<'_>,
        r: &mut [SVector<f64, D>],
        scratch: &mut Vec<SVector<f64, D>>,
    ) {
        r.iter_mut().zip(&self.work.load).for_each(|(r, f)| *r = -f);
        let (velocity, pressure) = (&self.velocity, &self.pressure);
        let form = self.form(step.weight / step.dt);
        assemble_vector(velocity, cells, r, scratch, |at| {
            let grad = velocity.jacobian(at, &state.u);
            let (f0, mut f1) = form(at, &velocity.value(at, &state.u), &grad);
            for term in step.terms.iter().filter(|t| t.is_implicit()) {
                f1 += term.stiffness(at, &grad);
            }
            let p = pressure.value(at, &state.p);
            for i in 0..D {
                f1[(i, i)] -= p;
            }
            (f0, f1)
        });
    }

    /// Kinetic energy `rho |u|^2 / 2`, viscous dissipation rate `2 mu |D(u)|^2`, grad-div rate `gamma (div u)^2` and `|div u|^2`,
    /// each integrated. With one viscosity the gradients are taken at the points of a rule of degree 2, which is exact.
    pub fn energies(&self, state: &FlowState<D>) -> [f64; 4] {
        let values = &self.velocity;
        let gradients = if self.viscosity.is_constant() { &self.gradients } else { values };
        let mesh = values.space().mesh();
        let [kinetic, dissipation, div2] = parallel::sum(mesh.cell_count(), |c| {
            let (u, map) = (values.space().on_cell(&state.u, c), mesh.map(c));
            let mut sums = [0.0; 3];
            for q in 0..values.rule().len() {
                let square = u.combined(values.values(q)).norm_squared();
                sums[0] += 0.5 * values.weight(c, q) * self.density.value(c, q) * square;
            }
            for q in 0..gradients.rule().len() {
                let grad = u.reference_jacobian(gradients.reference_gradients(q)) * map.inverse;
                let (weight, strain) = (gradients.weight(c, q), (grad + grad.transpose()) * 0.5);
                sums[1] += 2.0 * weight * self.viscosity.value(c, q) * strain.norm_squared();
                sums[2] += weight * grad.trace().powi(2);
            }
            sums
        });
        [kinetic, dissipation, self.grad_div * div2, div2]
    }
}

impl<const D: usize> Work<D> {
    fn empty() -> Work<D> {
        Work {
            load: Vec::new(),
            residual: Vec::new(),
            continuity: Vec::new(),
            lift: Vec::new(),
            rhs: Vec::new(),
            x: Vec::new(),
            vectors: Vec::new(),
            scalars: Vec::new(),
            pressure_mass: Vec::new(),
        }
    }
}

/// Integrals of `|g . n|` and `|g|` over the boundary, by the mean over the nodes of each facet: scales to judge the net flux with.
fn boundary_flow<const D: usize>(mesh: &Mesh<D>, space: &Space<D>, g: &[SVector<f64, D>]) -> [f64; 2] {
    let mut flow = [0.0; 2];
    for f in mesh.facets() {
        let (n, size) = mesh.facet_normal(f);
        let (mut sums, mut count) = ([0.0; 2], 0.0);
        for node in space.facet_nodes(f) {
            let g = g[node as usize];
            sums = [sums[0] + g.dot(&n).abs(), sums[1] + g.norm()];
            count += 1.0;
        }
        flow = [flow[0] + size * sums[0] / count, flow[1] + size * sums[1] / count];
    }
    flow
}
