//! The right-hand side of a step.

use super::{FlowSolver, Work};
use crate::base::{Cause, Error, Phase, Result, rounded};
use crate::fem::{
    At, Cells, Space, VectorForm, add_point_vector, assemble_scalar, assemble_source,
    assemble_vector, integrate,
};
use crate::flow::convection::{Convection, explicit_force};
use crate::flow::step::Step;
use crate::flow::term::{MomentumTerm, Support};
use crate::mesh::Mesh;
use nalgebra::{SMatrix, SVector};

impl<const D: usize> FlowSolver<D> {
    /// Checks that the prescribed velocities at `time` let as much fluid out as in, if no boundary
    /// is open.
    ///
    /// # Errors
    /// They do not.
    pub fn check_outflow(&self, time: f64) -> Result<()> {
        if self.numbering.is_open() || self.numbering.is_homogeneous() {
            return Ok(());
        }
        let (velocity, space) = (&self.velocity, self.velocity.space());
        let mut g = vec![SVector::zeros(); space.len()];
        self.numbering.lift(space, time, &mut g);
        let cells = Cells::Some(&self.boundary_cells);
        let [through] = integrate(velocity, cells, |at| [velocity.jacobian(at, &g).trace()]);
        check_outflow(space.mesh(), space, &g, (through, time))
    }
    /// Assembles the right-hand side without boundary values, one vector per node, into
    /// `work.load`.
    /// `p` is the pressure at the start of the step.
    pub(super) fn assemble_load(&mut self, step: &Step<'_, D>, p: &[f64]) {
        self.work.load.fill(SVector::zeros());
        self.assemble_inertia(step);
        if let (Convection::Implicit(w), true) = (step.convection, self.transport.is_stabilised()) {
            self.assemble_stabilisation(step, w, p);
        }
        let (velocity, work) = (&self.velocity, &mut self.work);
        let weight = self.buoyancy.as_ref().unwrap_or(&self.density);
        let (load, scratch, space) = (&mut work.load, &mut work.vectors, velocity.space());
        if step.body_force.is_some() || step.gravity.norm() > 0.0 {
            assemble_source(velocity, load, scratch, |c, cell| {
                for q in 0..velocity.rule().len() {
                    let at = velocity.at(c, q);
                    let force = step.body_force.map_or(SVector::zeros(), |f| f(&at.x, step.time));
                    cell.add(q, step.gravity * weight.at(&at) + force);
                }
            });
        }
        if let Convection::Explicit(earlier) = step.convection {
            assemble_vector(velocity, Cells::All, load, scratch, |at| {
                explicit_force(velocity, &self.density, earlier, at)
            });
        }
        self.phases.end(Phase::Assembly);
        for &term in step.terms {
            let predicted = step.predicted.filter(|_| term.is_implicit());
            match term.support() {
                Support::Cells(cells) => assemble_vector(velocity, cells, load, scratch, |at| {
                    let Some(u) = predicted else { return term.force(at) };
                    let grad = velocity.jacobian(at, u);
                    plus(term.force(at), term.stiffness(at, &velocity.value(at, u), &grad))
                }),
                Support::Points(points) => add_point_vector(space, points, load, |at| {
                    let Some(u) = predicted else { return term.force(at) };
                    plus(term.force(at), stiffness_of(term, space, at, u))
                }),
            }
        }
        self.phases.end(Phase::Force);
    }

    /// The known part of the residual of the momentum equation, tested with `tau (w . grad) v`.
    fn assemble_stabilisation(&mut self, step: &Step<'_, D>, w: &[SVector<f64, D>], p: &[f64]) {
        let (velocity, pressure, density) = (&self.velocity, &self.pressure, &self.density);
        let (transport, work) = (&self.transport, &mut self.work);
        let weight = self.buoyancy.as_ref().unwrap_or(density);
        let balanced = p.iter().any(|p| *p != 0.0);
        assemble_vector(velocity, Cells::All, &mut work.load, &mut work.vectors, |at| {
            let shift = transport.shift(velocity, w, at);
            if shift.norm_squared() == 0.0 {
                return (shift, SMatrix::zeros());
            }
            let mut known = SVector::zeros();
            // Before the first step there is no pressure that would balance a force.
            if balanced {
                let force = step.body_force.map_or(SVector::zeros(), |f| f(&at.x, step.time));
                known = force + step.gravity * weight.at(at) - pressure.gradient(at, p);
            }
            for h in step.history {
                known += velocity.value(at, h.u) * (h.weight * density.at(at) / step.dt);
            }
            (SVector::zeros(), known * shift.transpose())
        });
    }

    /// `rho sum weight u o X / dt`. Each earlier velocity is gathered once per cell: most feet lie
    /// in the cell of their point.
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

    /// The implicit terms of a step and the kept one.
    pub(super) fn implicit_terms<'a>(
        &'a self,
        step: &'a Step<'_, D>,
    ) -> impl Iterator<Item = &'a dyn MomentumTerm<D>> {
        let kept = self.kept.as_ref().map(|term| &**term as &dyn MomentumTerm<D>);
        step.terms.iter().copied().filter(|t| t.is_implicit()).chain(kept)
    }

    /// Moves the prescribed velocities `g` to the right-hand side: `- a(g, v)` and `(q, div g)`.
    /// With a closed boundary the mean of `div g`, an interpolation error, is subtracted.
    pub(super) fn bring_in_boundary_values(
        &mut self,
        step: &Step<'_, D>,
        work: &mut Work<D>,
    ) -> Result<()> {
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
            let (mut f0, mut f1) = form(at, &velocity.value(at, g), &grad);
            for term in cell_terms(step) {
                let (g0, g1) = term.stiffness(at, &velocity.value(at, g), &grad);
                (f0, f1) = (f0 + g0, f1 + g1);
            }
            (-f0, -f1)
        });
        for term in self.implicit_terms(step) {
            add_point_vector(space, term.support().points(), &mut work.residual, |at| {
                let (f0, f1) = stiffness_of(term, space, at, g);
                (-f0, -f1)
            });
        }
        // Minus the form of the boundary values: that of minus them.
        work.lift.iter_mut().for_each(|g| *g = -*g);
        let out = (&mut work.residual[..], &mut work.vectors);
        self.transport.add(velocity, cells, &work.lift, out);
        work.lift.iter_mut().for_each(|g| *g = -*g);
        let g = &work.lift;
        assemble_scalar(&self.pressure, cells, &mut work.continuity, &mut work.scalars, |at| {
            (velocity.jacobian(at, g).trace(), SVector::zeros())
        });
        if !self.numbering.is_open() {
            let mesh = space.mesh();
            let through: f64 = work.continuity[..self.numbering.pressure_points()].iter().sum();
            check_outflow(mesh, space, g, (through, step.time))?;
            let mean = through / mesh.volume();
            work.continuity.iter_mut().zip(&work.pressure_mass).for_each(|(c, m)| *c -= mean * m);
        }
        Ok(())
    }
}

/// Checks that velocities `g` on a closed boundary, with the net outflow `through`, balance.
///
/// # Errors
/// They do not.
fn check_outflow<const D: usize>(
    mesh: &Mesh<D>,
    space: &Space<D>,
    g: &[SVector<f64, D>],
    (through, time): (f64, f64),
) -> Result<()> {
    let [scale, along] = boundary_flow(mesh, space, g);
    // A wall that moves along itself may have a normal velocity of rounding, such as sin(pi).
    if through.abs() <= 1e-3 * scale || scale <= 1e-12 * along {
        return Ok(());
    }
    Err(Error::scene(
        "the prescribed velocities let more fluid in than out, and no boundary is open",
    )
    .at(format!("time {time:.6}"))
    .value(format!("net outflow {}, gross flow {}", rounded(through, 4), rounded(scale, 4)))
    .remedy("balance the velocities, or open an outlet")
    .because(Cause::Inflow))
}

/// Implicit terms on cells, part of the form of every cell.
pub(super) fn cell_terms<'a, const D: usize>(
    step: &Step<'a, D>,
) -> impl Iterator<Item = &'a dyn MomentumTerm<D>> {
    let on_cells = |t: &&dyn MomentumTerm<D>| matches!(t.support(), Support::Cells(_));
    step.terms.iter().copied().filter(|t| t.is_implicit()).filter(on_cells)
}

/// `C(u, v)` of a term at a point, for a velocity of the space.
pub(super) fn stiffness_of<const D: usize>(
    term: &dyn MomentumTerm<D>,
    space: &Space<D>,
    at: &At<D>,
    u: &[SVector<f64, D>],
) -> VectorForm<D> {
    let (cell, l) = (at.cell, &at.barycentric);
    term.stiffness(at, &space.value(u, cell, l), &space.jacobian(u, cell, l))
}

fn plus<const D: usize>(a: VectorForm<D>, b: VectorForm<D>) -> VectorForm<D> {
    (a.0 + b.0, a.1 + b.1)
}

/// Integrals of `|g . n|` and `|g|` over the boundary, by the mean over the nodes of each facet:
/// scales for the net flux.
fn boundary_flow<const D: usize>(
    mesh: &Mesh<D>,
    space: &Space<D>,
    g: &[SVector<f64, D>],
) -> [f64; 2] {
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
