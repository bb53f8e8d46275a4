//! Forces on walls and energies.

use super::FlowSolver;
use super::load::{cell_terms, stiffness_of};
use crate::base::parallel;
use crate::fem::{Cells, add_point_vector, assemble_vector};
use crate::flow::step::{FlowState, Step};
use nalgebra::SVector;

impl<const D: usize> FlowSolver<D> {
    /// Power of prescribed boundary velocities: the sum over nodes of reaction times velocity,
    /// after [`step`](Self::step) with the same data.
    pub fn wall_power(&mut self, step: &Step<'_, D>, state: &FlowState<D>) -> f64 {
        if self.numbering.is_homogeneous() {
            return 0.0;
        }
        // The buffers of the solve are free now.
        let mut r = std::mem::take(&mut self.work.residual);
        let mut scratch = std::mem::take(&mut self.work.vectors);
        self.find_reaction(step, state, Cells::Some(&self.boundary_cells), &mut r, &mut scratch);
        let power = self
            .numbering
            .prescribed_nodes()
            .map(|n| r[n as usize].dot(&state.u[n as usize]))
            .sum();
        (self.work.residual, self.work.vectors) = (r, scratch);
        power
    }

    /// Residual of the momentum equation, `a(u, v) - (p, div v) - F(v)`, for all `v` supported in
    /// `cells`. At nodes on a wall it is the force of the wall on the fluid. Valid after
    /// [`step`](Self::step) with the same data.
    pub fn reaction(
        &self,
        step: &Step<'_, D>,
        state: &FlowState<D>,
        cells: Cells<'_>,
    ) -> Vec<SVector<f64, D>> {
        let mut r = self.work.load.clone();
        self.find_reaction(step, state, cells, &mut r, &mut Vec::new());
        r
    }

    /// [`reaction`](Self::reaction), written to `r`.
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
            let u = velocity.value(at, &state.u);
            let (mut f0, mut f1) = form(at, &u, &grad);
            for term in cell_terms(step) {
                let (g0, g1) = term.stiffness(at, &u, &grad);
                (f0, f1) = (f0 + g0, f1 + g1);
            }
            let p = pressure.value(at, &state.p);
            for i in 0..D {
                f1[(i, i)] -= p;
            }
            (f0, f1)
        });
        self.transport.add(velocity, cells, &state.u, (r, scratch));
        for term in self.implicit_terms(step) {
            let space = velocity.space();
            add_point_vector(space, term.support().points(), r, |at| {
                stiffness_of(term, space, at, &state.u)
            });
        }
        self.add_block_forces(step.blocks, r);
    }

    /// Integrals of kinetic energy `rho |u|^2 / 2`, viscous dissipation `2 mu |D(u)|^2`, grad-div
    /// dissipation `gamma (div u)^2` and `|div u|^2`. With constant viscosity the gradients are
    /// integrated with a rule of degree 2, which is exact.
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
