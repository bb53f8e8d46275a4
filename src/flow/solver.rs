//! One step of the coupled velocity-pressure system.

use super::coefficient::Coefficient;
use super::convection::{OnNodes, OnUnknowns, Transport};
use super::step::{FlowState, Step, StepReport};
use super::term::MomentumTerm;
use crate::base::{Error, PHASES, Phase, Phases, Result};
use crate::fem::{At, Basis, Cells, Conditions, Numbering, Rule, Space, assemble_scalar};
use crate::linalg::{
    Change, Factor, FactorSize, LaggedFactor, LaggedReport, SolveCost, SolverKind, SolverOptions,
    SymmetricMatrix,
};
use nalgebra::SVector;
use std::sync::Arc;

mod balance;
mod load;
mod matrix;
mod system;

/// Assembles and solves the system of velocity and pressure; keeps the factor while the matrix does
/// not change.
///
/// # Examples
/// ```
/// use immersa::fem::{Condition, Element, Rule, Space};
/// use immersa::flow::{Coefficient, FlowSolver, Step};
/// use immersa::mesh::{Diagonals, Point, rectangle};
/// use std::sync::Arc;
///
/// // Stokes flow with the velocity (y, 0) on the walls: the solution is (y, 0), and P2 has it.
/// let mesh = Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], Diagonals::UnionJack)?);
/// let [p2, p1] = [Element::P2, Element::P1].map(|e| Arc::new(Space::new(&mesh, e)));
/// let shear = Condition::Velocity(Arc::new(|x, _| Point::<2>::new(x[1], 0.0)));
/// let rule = Arc::new(Rule::simplex(2, 4));
/// let mut flow = FlowSolver::new(&p2, &p1, &rule, &vec![("walls".into(), shear)], 0.0)?;
/// flow.set_materials(Coefficient::Constant(0.0), Coefficient::Constant(1.0));
/// let mut state = flow.at_rest();
/// flow.step(&Step { weight: 0.0, ..Step::backward_euler(0.1, 0.1, &[]) }, &mut state)?;
/// for (u, x) in state.u.iter().zip(p2.nodes()) {
///     assert!((u - Point::<2>::new(x[1], 0.0)).norm() < 1e-12);
/// }
/// # Ok::<(), immersa::base::Error>(())
/// ```
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
    /// Mass per volume that gravity acts on; `None` for the density.
    buoyancy: Option<Coefficient>,
    /// Implicit convection in the present step.
    transport: Transport,
    /// The constant part of the matrix, and its `weight / dt`; NaN when it is out of date.
    base: Option<(SymmetricMatrix, f64)>,
    matrix: SymmetricMatrix,
    factor: Option<LaggedFactor>,
    /// Relative residual of iterations with an old factor; 0 factors every matrix.
    tolerance: f64,
    /// Allowed linear solvers.
    options: SolverOptions,
    /// A term of the constant part of the matrix beside those of the fluid.
    kept: Option<Arc<dyn MomentumTerm<D> + Send>>,
    /// Nodes of the pressure on open boundaries.
    open_nodes: Vec<u32>,
    /// True if `factor` is that of `base` without terms.
    factor_is_base: bool,
    /// `weight / dt` of the factored matrix.
    factored_weight: f64,
    /// True if the factored matrix was `base` without terms.
    factored_plain: bool,
    /// True if the length of the step will change.
    expects_changes: bool,
    /// True if implicit convection is stabilised in coarse cells.
    stabilises: bool,
    boundary_cells: Vec<u32>,
    /// The system with unknowns of structures, where there are any.
    blocks: Option<system::BlockSystem>,
    /// Values of the unknowns of blocks in the last step.
    block_values: Vec<Vec<f64>>,
    work: Work<D>,
    phases: Phases,
    /// Number of substitutions; each reads the factor twice.
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
    products: OnNodes<D>,
    /// The pressure at the start of the step among zeros, and what it holds of the right-hand side.
    pressure: Vec<f64>,
    held: Vec<f64>,
}

impl<const D: usize> Work<D> {
    /// Buffers for `nodes` velocities and `order` unknowns.
    fn new(nodes: usize, pressure: &Basis<D>, order: usize) -> Work<D> {
        let mut pressure_mass = vec![0.0; pressure.space().len()];
        assemble_scalar(pressure, Cells::All, &mut pressure_mass, &mut Vec::new(), |_| {
            (1.0, SVector::zeros())
        });
        let zero = SVector::<f64, D>::zeros();
        Work {
            load: vec![zero; nodes],
            residual: vec![zero; nodes],
            continuity: vec![0.0; pressure.space().len()],
            lift: vec![zero; nodes],
            rhs: vec![0.0; order],
            x: vec![0.0; order],
            vectors: Vec::new(),
            scalars: Vec::new(),
            pressure_mass,
            products: OnNodes::default(),
            pressure: Vec::new(),
            held: Vec::new(),
        }
    }
}

/// The pattern of the matrix: all unknowns of a cell are coupled.
fn pattern<const D: usize>(
    numbering: &Numbering<D>,
    velocity: &Space<D>,
    pressure: &Space<D>,
) -> Result<SymmetricMatrix> {
    let groups = (0..velocity.mesh().cell_count()).map(|c| {
        let mut list = Vec::new();
        numbering.cell_unknowns(velocity.cell_nodes(c), Some(pressure.cell_nodes(c)), &mut list);
        list
    });
    SymmetricMatrix::from_groups(numbering.order(), groups)
}

/// Cells with a node whose velocity is prescribed.
fn cells_at_prescribed<const D: usize>(numbering: &Numbering<D>, velocity: &Space<D>) -> Vec<u32> {
    let mut prescribed = vec![false; velocity.len()];
    numbering.prescribed_nodes().for_each(|n| prescribed[n as usize] = true);
    let touches = |c: usize| velocity.cell_nodes(c).iter().any(|&n| prescribed[n as usize]);
    (0..velocity.mesh().cell_count()).filter(|&c| touches(c)).map(|c| c as u32).collect()
}

/// Nodes of the pressure on open boundaries, facet by facet.
fn nodes_on_open<const D: usize>(
    pressure: &Space<D>,
    conditions: &Conditions<D>,
) -> Result<Vec<u32>> {
    let (mesh, mut nodes) = (pressure.mesh(), Vec::new());
    for (name, _) in conditions.iter().filter(|(_, c)| c.is_open()) {
        let facets = mesh.boundary(name)?.iter().map(|&f| &mesh.facets()[f as usize]);
        nodes.extend(facets.flat_map(|facet| pressure.facet_nodes(facet).collect::<Vec<_>>()));
    }
    Ok(nodes)
}

impl<const D: usize> FlowSolver<D> {
    /// A solver on the spaces of `velocity` (P2) and `pressure` (P1), integrated with `rule`.
    ///
    /// `grad_div` is the factor `gamma >= 0` of the term `gamma (div u, div v)`. Without it P2-P1
    /// conserves mass only on average, and a membrane gains spurious energy.
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
        let matrix = pattern(&numbering, velocity, pressure)?;
        let cells = cells_at_prescribed(&numbering, velocity);
        let open_nodes = nodes_on_open(pressure, conditions)?;
        let gradients = Basis::new(velocity, &Arc::new(Rule::simplex(D, 2)));
        let (velocity, pressure) = (Basis::new(velocity, rule), Basis::new(pressure, rule));
        Ok(FlowSolver {
            work: Work::new(velocity.space().len(), &pressure, numbering.order()),
            velocity,
            gradients,
            pressure,
            numbering,
            grad_div,
            density: Coefficient::Constant(1.0),
            viscosity: Coefficient::Constant(1.0),
            buoyancy: None,
            transport: Transport::default(),
            base: None,
            kept: None,
            matrix,
            factor: None,
            tolerance: 0.0,
            options: SolverOptions::default(),
            open_nodes,
            factor_is_base: false,
            factored_weight: f64::NAN,
            factored_plain: false,
            expects_changes: false,
            stabilises: true,
            boundary_cells: cells,
            blocks: None,
            block_values: Vec::new(),
            phases: Phases::default(),
            substitutions: 0,
        })
    }

    /// Solves with a matrix that changes from step to step by iterations with an old factor, to the
    /// relative residual `tolerance`, where this is cheaper than factoring; 0 (the default) factors
    /// every matrix. To be called before the first step.
    pub fn iterate(&mut self, tolerance: f64) {
        self.tolerance = tolerance;
    }
    /// Sets the allowed solvers and the memory of their factors. To be called before the first
    /// step.
    pub fn solve_by(&mut self, options: SolverOptions) {
        self.options = options;
    }
    /// Adds an implicit term without an explicit force that never changes, on points: it is part of
    /// the constant matrix. To be called before the first step.
    pub fn keep(&mut self, term: Arc<dyn MomentumTerm<D> + Send>) {
        self.kept = Some(term);
    }
    /// Declares that the length of the step, and with it the matrix, will change: no change is
    /// treated as lasting.
    pub fn expect_changes(&mut self) {
        self.expects_changes = true;
    }
    /// Leaves implicit convection as it is in coarse cells: the residual that stabilises knows no
    /// forces of structures.
    pub fn leave_unstabilised(&mut self) {
        self.stabilises = false;
    }
    /// Makes the next solve factor its matrix.
    pub fn invalidate_factor(&mut self) {
        (self.factor_is_base, self.factored_plain, self.factored_weight) = (false, false, f64::NAN);
        self.factor.iter_mut().for_each(LaggedFactor::invalidate);
    }
    /// Sets density and dynamic viscosity; the matrix is assembled again when they are not constant
    /// or have changed.
    pub fn set_materials(&mut self, density: Coefficient, viscosity: Coefficient) {
        if density != self.density
            || viscosity != self.viscosity
            || !density.is_constant()
            || !viscosity.is_constant()
        {
            // No weight equals NaN: the values are stale, the storage is kept.
            self.base.iter_mut().for_each(|(_, weight)| *weight = f64::NAN);
            self.factored_plain = false;
        }
        self.density = density;
        self.viscosity = viscosity;
    }
    /// Sets the mass per volume that gravity acts on in place of the density: in the Boussinesq
    /// form the difference from it.
    pub fn set_buoyancy(&mut self, buoyancy: Option<Coefficient>) {
        self.buoyancy = buoyancy;
    }
    /// Mass per volume that gravity acts on at a quadrature point.
    pub fn weight(&self, at: &At<D>) -> f64 {
        self.buoyancy.as_ref().unwrap_or(&self.density).at(at)
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
    /// True if the factor in use is that of a constant matrix.
    pub fn is_constant(&self) -> bool {
        !self.expects_changes
            && self.factor_is_base
            && self.density.is_constant()
            && self.viscosity.is_constant()
    }
    /// Weight of the grad-div term.
    pub fn grad_div(&self) -> f64 {
        self.grad_div
    }
    /// Stored entries of the matrix (one triangle).
    pub fn matrix_nonzeros(&self) -> usize {
        self.matrix.nonzeros()
    }
    /// The factor of the whole matrix, once there is one; `None` for the Schur solver.
    pub fn factor(&self) -> Option<&Factor> {
        self.factor.as_ref().and_then(LaggedFactor::factor)
    }
    /// The linear solver and the size of its factors, once they are planned.
    pub fn solver_size(&self) -> Option<(SolverKind, FactorSize)> {
        self.factor.as_ref().map(|f| (f.kind(), f.size()))
    }
    /// True if each system is solved by iterations, so that a good initial guess helps.
    pub fn always_iterates(&self) -> bool {
        self.factor.as_ref().is_some_and(LaggedFactor::always_iterates)
    }
    /// The linear solver with its sizes, and estimated times on one core of a server.
    pub fn solver_summary(&self) -> Option<String> {
        let (kind, size) = self.solver_size()?;
        Some(format!(
            "solved by {kind}: {:.3e} entries in the factors, {:.0} MB; estimated {:.1e} s a \
             factorisation ({:.1e} operations), {:.1e} s {}",
            size.entries as f64,
            size.bytes as f64 / 1e6,
            size.factoring_seconds(),
            size.operations,
            size.solving_seconds(),
            if kind == SolverKind::Direct { "a solve" } else { "an iteration" }
        ))
    }
    /// Describes the solution of systems whose matrix changes from step to step, as a participle
    /// phrase for the plan.
    pub fn solver_description(&self) -> String {
        match &self.factor {
            Some(f) if f.may_iterate() => format!(
                "solved by GMRES with an older factor to the relative residual {:e}, or factored \
                 anew, whichever is cheaper by count: a factorisation costs {:.1} iterations",
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
    /// Costs that decide between iterations and a factorisation.
    pub fn solve_cost(&self) -> SolveCost {
        self.factor.as_ref().map_or(SolveCost::default(), LaggedFactor::solve_cost)
    }
    /// Processor seconds by phase, and number of substitutions, since the last call.
    pub fn take_costs(&mut self) -> ([f64; PHASES.len()], u64) {
        (self.phases.take(), std::mem::take(&mut self.substitutions))
    }
    /// Fluid at rest.
    pub fn at_rest(&self) -> FlowState<D> {
        FlowState {
            u: vec![SVector::zeros(); self.velocity.space().len()],
            p: vec![0.0; self.pressure.space().len()],
        }
    }
    /// Writes the prescribed velocities at time `t` into `u`.
    pub fn impose(&self, t: f64, u: &mut [SVector<f64, D>]) {
        let mut lift = vec![SVector::zeros(); u.len()];
        let space = self.velocity.space();
        self.numbering.lift(space, t, &mut lift);
        for n in self.numbering.prescribed_nodes() {
            u[n as usize] = lift[n as usize];
        }
    }

    /// Takes one step and writes the new velocity and pressure into `state`, whose values are the
    /// initial guess of iterations.
    ///
    /// # Errors
    /// A factorisation or a solve that fails; boundary values with a net inflow.
    pub fn step(&mut self, step: &Step<'_, D>, state: &mut FlowState<D>) -> Result<StepReport> {
        let change = self.prepare(step.weight / step.dt, step.terms, step.convection)?;
        self.phases.begin();
        self.assemble_load(step, &state.p);
        let mut work = std::mem::replace(&mut self.work, Work::empty());
        let result = self.solve(step, change, &mut work, state);
        self.work = work;
        let LaggedReport { solve, refactored, given_up, substitutions, factoring } = result?;
        self.substitutions += substitutions as u64;
        if refactored {
            self.factored_weight = step.weight / step.dt;
            self.factor_is_base =
                !self.transport.is_active() && step.terms.iter().all(|t| !t.is_implicit());
            self.factored_plain = self.factor_is_base;
        }
        self.phases.end(Phase::Solve);
        self.phases.transfer(factoring, Phase::Solve, Phase::Factor);
        Ok(StepReport { solve, refactored, given_up })
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
        let report = if step.blocks.is_empty() {
            self.block_values.clear();
            self.solve_flow(change, work, state)
        } else {
            self.solve_with_blocks(step, work, state)
        };
        let report = report.map_err(|e| {
            let place = format!("time {:.6}", step.time);
            if e.place().is_empty() { e.at(place) } else { e }
        })?;
        if !self.numbering.is_open() {
            let points = self.numbering.pressure_points();
            let mass: f64 = work.pressure_mass[..points].iter().sum();
            let mean =
                state.p.iter().zip(&work.pressure_mass).map(|(p, m)| p * m).sum::<f64>() / mass;
            state.p.iter_mut().take(points).for_each(|p| *p -= mean);
        }
        Ok(report)
    }

    /// Solves for velocity and pressure without blocks, with the cheapest factor.
    fn solve_flow(
        &mut self,
        change: Change,
        work: &mut Work<D>,
        state: &mut FlowState<D>,
    ) -> Result<LaggedReport> {
        let Some(factor) = &mut self.factor else {
            return Err(Error::internal("the flow matrix was not factored"));
        };
        if change == Change::Passing || factor.always_iterates() {
            self.numbering.restrict(&state.u, &state.p, &work.lift, &mut work.x);
        }
        let (transport, velocity, numbering) = (&self.transport, &self.velocity, &self.numbering);
        let mut convection =
            OnUnknowns { transport, velocity, numbering, work: &mut work.products };
        let operator = convection.beside(&self.matrix);
        if !transport.is_active() {
            let report = factor.solve(operator, change, &work.rhs, &mut work.x)?;
            self.numbering.scatter(&work.x, &work.lift, &mut state.u, &mut state.p);
            return Ok(report);
        }
        // For the change of the pressure: a residual relative to a load that the pressure nearly
        // holds, such as a weight, would say nothing of the velocity.
        let first = numbering.first_pressure();
        work.pressure.clear();
        work.pressure.resize(first, 0.0);
        work.pressure.extend_from_slice(&work.x[first..]);
        work.held.resize(work.rhs.len(), 0.0);
        self.matrix.multiply(&work.pressure, &mut work.held);
        work.rhs.iter_mut().zip(&work.held).for_each(|(b, held)| *b -= held);
        work.x[first..].fill(0.0);
        let report = factor.solve(operator, change, &work.rhs, &mut work.x)?;
        work.x.iter_mut().zip(&work.pressure).for_each(|(x, p)| *x += p);
        self.numbering.scatter(&work.x, &work.lift, &mut state.u, &mut state.p);
        Ok(report)
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
            products: OnNodes::default(),
            pressure: Vec::new(),
            held: Vec::new(),
        }
    }
}
