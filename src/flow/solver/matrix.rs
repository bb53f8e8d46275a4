//! The matrix of a step and the operators of its preconditioner.

use super::FlowSolver;
use crate::base::{Error, Phase, Result};
use crate::fem::{
    At, Cells, VectorForm, add_point_matrix, assemble_flow_matrix, assemble_scalar_matrix,
};
use crate::flow::convection::{Convection, OnNodes, OnUnknowns};
use crate::flow::term::{MomentumTerm, Support};
use crate::linalg::{
    CONSTRAINED, Change, LaggedFactor, Multipliers, Saddle, SolveCost, SymmetricMatrix,
};
use nalgebra::{SMatrix, SVector};

/// Diagonal entry that fixes a pressure at zero.
const FIXED: f64 = 1e30;

impl<const D: usize> FlowSolver<D> {
    /// The viscous, grad-div and inertial parts of the bilinear form.
    pub(super) fn form<'a>(
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

    /// Assembles the constant part of the matrix for `weight / dt`, and analyses it without
    /// factoring.
    pub fn analyse(&mut self, weight: f64) -> Result<()> {
        self.phases.begin();
        self.assemble_base(weight)?;
        self.phases.end(Phase::Assembly);
        let Some((base, _)) = &self.base else {
            return Err(Error::internal("the flow matrix is missing"));
        };
        if self.factor.is_none() {
            let multipliers = Multipliers {
                first: self.numbering.first_pressure(),
                first_late: self.numbering.first_constant(),
                first_unpaired: usize::MAX,
            };
            let saddle = || self.saddle(weight);
            let factor =
                LaggedFactor::choose(base, multipliers, self.options, self.tolerance, saddle)?;
            self.factor = Some(factor);
            self.factor_is_base = false;
        }
        self.phases.end(Phase::Factor);
        Ok(())
    }

    /// Input of the Schur solver: components of the velocity, and operators on the pressure without
    /// values. A Stokes flow has no second operator.
    fn saddle(&self, weight: f64) -> Result<Saddle> {
        let (space, unknowns) = (self.pressure.space(), self.numbering.pressure_unknowns());
        let count = self.numbering.order() - self.numbering.first_pressure();
        let groups = (0..space.mesh().cell_count())
            .map(|c| space.cell_nodes(c).iter().map(|&n| unknowns[n as usize]).collect::<Vec<_>>());
        let operator = SymmetricMatrix::from_groups(count, groups)?;
        let operators = vec![operator; if weight > 0.0 { 2 } else { 1 }];
        Ok(Saddle { components: self.numbering.components(), operators })
    }

    /// Fills the operators on the pressure, if the solver has any: the mass matrix over
    /// `2 mu + gamma`, and the Laplacian over `rho weight/dt`, zero at open boundaries.
    fn fill_operators(&mut self, weight: f64) -> Result<()> {
        let Some(factor) = &mut self.factor else { return Ok(()) };
        if factor.operators_mut().is_empty() {
            return Ok(());
        }
        let (density, viscosity, grad_div) = (&self.density, &self.viscosity, self.grad_div);
        let unknowns = self.numbering.pressure_unknowns();
        for (k, operator) in factor.operators_mut().iter_mut().enumerate() {
            operator.zero();
            if k == 0 {
                assemble_scalar_matrix(&self.pressure, &unknowns, operator, |at| {
                    (1.0 / (2.0 * viscosity.at(at) + grad_div), 0.0)
                })?;
                continue;
            }
            let mut free = unknowns.clone();
            for &n in &self.open_nodes {
                let unknown = std::mem::replace(&mut free[n as usize], CONSTRAINED);
                if unknown != CONSTRAINED {
                    operator.add_group(&[unknown], &[FIXED])?;
                }
            }
            assemble_scalar_matrix(&self.pressure, &free, operator, |at| {
                (0.0, 1.0 / (weight * density.at(at)))
            })?;
        }
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
        if let Some(term) = &self.kept {
            let (space, points) = (self.velocity.space(), term.support().points());
            add_point_matrix(space, &self.numbering, points, &mut matrix, |at, u, grad| {
                term.stiffness(at, u, grad)
            })?;
        }
        self.base = Some((matrix, weight));
        self.factor_is_base = false;
        Ok(())
    }

    /// Updates the matrix for the step. Returns the change since the factorisation.
    pub(super) fn prepare(
        &mut self,
        weight: f64,
        terms: &[&dyn MomentumTerm<D>],
        convection: Convection<'_, D>,
    ) -> Result<Change> {
        let implicit = terms.iter().any(|t| t.is_implicit());
        self.analyse(weight)?;
        let wind = match convection {
            Convection::Implicit(w) => Some(w),
            _ => None,
        };
        let materials = (&self.density, &self.viscosity);
        let rate = self.stabilises.then_some(weight);
        self.transport.prepare(&self.velocity, materials, wind, rate);
        if self.factor_is_base && !implicit && wind.is_none() {
            return Ok(Change::None);
        }
        let Some((base, _)) = &self.base else {
            return Err(Error::internal("the flow matrix is missing"));
        };
        self.matrix.copy_values_from(base)?;
        for term in terms.iter().filter(|t| t.is_implicit()) {
            let form = |at: &At<D>, u: &SVector<f64, D>, grad: &SMatrix<f64, D, D>| {
                term.stiffness(at, u, grad)
            };
            match term.support() {
                Support::Cells(cells) => assemble_flow_matrix(
                    &self.velocity,
                    None,
                    &self.numbering,
                    cells,
                    &mut self.matrix,
                    &mut self.work.scalars,
                    form,
                )?,
                Support::Points(points) => {
                    let space = self.velocity.space();
                    add_point_matrix(space, &self.numbering, points, &mut self.matrix, form)?;
                }
            }
        }
        self.fill_operators(weight)?;
        self.phases.end(Phase::Assembly);
        let constant = !implicit
            && wind.is_none()
            && self.density.is_constant()
            && self.viscosity.is_constant();
        self.factor_is_base = constant && self.factored_plain && self.factored_weight == weight;
        if self.factor_is_base {
            return Ok(Change::None);
        }
        // The first step has another coefficient than the following ones: its factor would be a bad
        // preconditioner for them.
        let lasting = !self.expects_changes && (constant || self.factored_weight != weight);
        Ok(if lasting { Change::Lasting } else { Change::Passing })
    }

    /// Computes the factor of an interrupted run again: with `weight / dt`, the current materials,
    /// `terms` and `convection`.
    ///
    /// # Errors
    /// A factorisation that fails.
    pub fn restore_factor(
        &mut self,
        weight: f64,
        terms: &[&dyn MomentumTerm<D>],
        convection: Convection<'_, D>,
        solve_cost: SolveCost,
    ) -> Result<()> {
        self.prepare(weight, terms, convection)?;
        let Some(factor) = &mut self.factor else {
            return Err(Error::internal("the flow matrix was not analysed"));
        };
        let (transport, velocity, numbering) = (&self.transport, &self.velocity, &self.numbering);
        self.factored_weight = weight;
        self.factored_plain = !transport.is_active() && terms.iter().all(|t| !t.is_implicit());
        let mut work = OnNodes::default();
        let mut convection = OnUnknowns { transport, velocity, numbering, work: &mut work };
        factor.restore(convection.beside(&self.matrix), solve_cost)
    }
}
