//! The membrane with an area law whose force acts on the interface itself (sharp interface).

use super::area_law::AreaLaw;
use super::waves::explicit_step_limit;
use crate::base::{Cause, Result};
use crate::fem::{At, Basis, Space, SurfaceForm, SurfacePoint, VectorForm, surface_solve};
use crate::flow::term::{MomentumTerm, Support};
use crate::levelset::surface;
use crate::structure::{
    Carry, Coupling, Data, Declaration, FieldId, Fields, Host, ImmersedInterface, InterfaceForce,
    Medium, Moved, Place, Rule, Velocity,
};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Support of the force of a membrane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Force {
    /// In a band: [`Membrane`](super::Membrane). First order in the half-width of the band.
    Smeared,
    /// On the interface: [`SharpMembrane`].
    Sharp,
}

/// An elastic membrane on the zero level `S` of `phi`.
///
/// The force is the limit of (3.16) for a band of zero width, `F(v) = - int_S E'(r) P : grad v ds`
/// with `P = I - n n`, and the energy that of (3.12), `int_S E(r)/r ds`. Two choices make the force
/// the derivative of the energy on the mesh, so that no spurious energy is produced for any
/// stiffness:
///
/// - `n` is the normal of the cut interface, whose length the force shortens, not that of a
///   gradient;
/// - the stretch is not `|grad phi|` but transported by `D(log r)/Dt = P : grad u`, with the same
///   `P : grad u` as in the force. For divergence-free velocities this equals `|grad phi|`; on a
///   mesh the force amplifies the error of `|grad phi|` in short waves.
///
/// A tangential force gives the velocity a kink, which P2 smooths over a cell of extent `l` across
/// the interface: the interface moves too slowly, by `l/(15 mu) grad_S E'(r)` in the mean over its
/// positions in the cell (in one dimension, the Galerkin error at a point force at `x` of a P2
/// element is `[x(1-x) - 3 x^2 (1-x)^2] l/mu`). This *slip* is added:
/// `D(log r)/Dt = P : grad u + div_S(l/(15 mu) grad_S E'(r))`, solved implicitly. It dissipates
/// `int_S l/(15 mu) |grad_S E'|^2 ds` per time, the dissipation in the unresolved part of the kink.
/// It does not move the interface along its normal.
///
/// Limits: an interface that reaches a wall with a prescribed velocity, because the stiffness is
/// omitted in the lift of boundary values; a fluid that crosses more than four cells in a step,
/// because the stretch is known no farther from the interface.
///
/// Implicit in the velocity, `C(u, v) = dt int_S [E'' r (P : grad u)(P : grad v) + max(E', 0) (n
/// grad u P) . (n grad v P)] ds` is added to the matrix; for constant tension and in 3-D the last
/// product is `(grad u P) : (grad v P)`.
#[derive(Clone, Debug)]
pub struct SharpMembrane<const D: usize> {
    law: AreaLaw,
    /// Cached cut interfaces with their level sets: a step uses each several times.
    cuts: Vec<(Vec<f64>, Arc<[SurfacePoint<D>]>)>,
    /// Viscosity of the surrounding fluid.
    viscosity: f64,
    points: Arc<[SurfacePoint<D>]>,
    /// The same points without normals.
    places: Vec<At<D>>,
    /// Stretch at the points.
    stretch: Vec<f64>,
    /// Dissipation rate of the slip.
    dissipation: f64,
    implicit_step: Option<f64>,
    /// Field of the logarithm of the stretch.
    log_stretch: FieldId,
}

/// The slip is `extent / (SLIP mu)` times the tangential force.
const SLIP: f64 = 15.0;
/// Number of cached interfaces: at the start of a step, predicted for its end, and at its end.
const KEPT: usize = 3;
/// Number of layers of vertices around the cut cells to which the rate of stretch is extended. It
/// covers the feet of the characteristics of these nodes if the fluid crosses fewer cells in a
/// step.
const RINGS: usize = 4;

impl<const D: usize> SharpMembrane<D> {
    /// A membrane in a fluid of this viscosity (between two fluids, their mean).
    pub fn new(law: AreaLaw, viscosity: f64) -> SharpMembrane<D> {
        SharpMembrane {
            law,
            cuts: Vec::new(),
            viscosity,
            points: Arc::default(),
            places: Vec::new(),
            stretch: Vec::new(),
            dissipation: 0.0,
            implicit_step: None,
            log_stretch: FieldId::default(),
        }
    }
    /// Quadrature points on the interface of `phi`.
    fn cut(&mut self, space: &Space<D>, phi: &[f64]) -> Result<Arc<[SurfacePoint<D>]>> {
        if let Some((_, points)) = self.cuts.iter().find(|(known, _)| known == phi) {
            return Ok(Arc::clone(points));
        }
        let points: Arc<[SurfacePoint<D>]> = surface(space, phi)?.into();
        self.cuts.truncate(KEPT - 1);
        self.cuts.insert(0, (phi.to_vec(), Arc::clone(&points)));
        Ok(points)
    }
    /// Precomputes the force on the interface of `phi`; `log_stretch` is the logarithm of the
    /// stretch at the nodes. With `implicit_step`, a time step, the stiffness enters the matrix.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn prepare(
        &mut self,
        space: &Space<D>,
        phi: &[f64],
        log_stretch: &[f64],
        implicit_step: Option<f64>,
    ) -> Result<()> {
        self.implicit_step = implicit_step;
        self.points = self.cut(space, phi)?;
        self.places = self.points.iter().map(|p| p.at).collect();
        let stretch =
            |p: &SurfacePoint<D>| space.value(log_stretch, p.at.cell, &p.at.barycentric).exp();
        self.stretch = self.points.iter().map(stretch).collect();
        self.dissipation = self
            .points
            .iter()
            .map(|p| {
                let (slip, pull) = (self.slip(space, p), self.pull(space, p, log_stretch));
                p.at.weight * slip * pull.norm_squared()
            })
            .sum();
        Ok(())
    }
    /// Elastic energy of the prepared interface.
    pub fn energy(&self) -> f64 {
        self.points
            .iter()
            .zip(&self.stretch)
            .map(|(p, &r)| p.at.weight * self.law.energy(r) / r)
            .sum()
    }
    /// Dissipation rate of the slip.
    pub fn dissipation(&self) -> f64 {
        self.dissipation
    }
    /// Largest tension `E'(r)` on the prepared interface; 0 without tension.
    pub fn largest_tension(&self) -> f64 {
        self.stretch.iter().map(|&r| self.law.tension(r)).fold(0.0, f64::max)
    }
    /// Adds to `log_stretch` (one number per node) the growth on the interface of `phi` in the
    /// velocity `u` over the time `dt`, constant along the normal for some cells on both sides.
    /// Nothing for constant tension, which does not depend on the stretch.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn grow(
        &mut self,
        space: &Space<D>,
        phi: &[f64],
        u: &[SVector<f64, D>],
        dt: f64,
        log_stretch: &mut [f64],
    ) -> Result<()> {
        if matches!(self.law, AreaLaw::Tension { .. }) {
            return Ok(());
        }
        let points = self.cut(space, phi)?;
        let mut rate = surface_solve(space, &points, |p| {
            let at = &p.at;
            let grad = space.jacobian(u, at.cell, &at.barycentric);
            let r = space.value(log_stretch, at.cell, &at.barycentric).exp();
            let slip = self.slip(space, p);
            SurfaceForm {
                diffusivity: slip * dt * self.law.stiffness(r) * r,
                source: grad.trace() - p.normal.dot(&(grad * p.normal)),
                flux: self.pull(space, p, log_stretch) * -slip,
            }
        })?;
        continue_outward(space, &mut rate);
        let mesh = space.mesh();
        let mut done = vec![false; space.len()];
        for c in 0..mesh.cell_count() {
            let cell = mesh.cell(c);
            if cell.iter().any(|&v| rate[v as usize].is_nan()) {
                continue;
            }
            for (a, &node) in space.cell_nodes(c).iter().enumerate() {
                if !std::mem::replace(&mut done[node as usize], true) {
                    let l = space.element().node(a, D);
                    log_stretch[node as usize] +=
                        dt * cell.iter().zip(l).map(|(&v, l)| l * rate[v as usize]).sum::<f64>();
                }
            }
        }
        Ok(())
    }
    /// Slip velocity over tangential force.
    fn slip(&self, space: &Space<D>, p: &SurfacePoint<D>) -> f64 {
        let mesh = space.mesh();
        let heights =
            mesh.cell(p.at.cell).iter().map(|&v| mesh.points()[v as usize].dot(&p.normal));
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        (high - low) / (SLIP * self.viscosity)
    }
    /// `grad_S E'(r)`, the tangential force.
    fn pull(&self, space: &Space<D>, p: &SurfacePoint<D>, log_stretch: &[f64]) -> SVector<f64, D> {
        let (cell, l) = (p.at.cell, &p.at.barycentric);
        let r = space.value(log_stretch, cell, l).exp();
        p.tangential(&space.gradient(log_stretch, cell, l)) * (self.law.stiffness(r) * r)
    }
}

/// Sets vertices without a value to the mean of their neighbours, layer by layer.
fn continue_outward<const D: usize>(space: &Space<D>, values: &mut [f64]) {
    let mesh = space.mesh();
    for _ in 0..RINGS {
        let mut sums: Vec<(f64, u32)> = vec![(0.0, 0); values.len()];
        for c in 0..mesh.cell_count() {
            let cell = mesh.cell(c);
            let known = cell.iter().map(|&v| values[v as usize]).filter(|v| !v.is_nan());
            let (sum, count) = known.fold((0.0, 0), |(s, n), v| (s + v, n + 1));
            if count > 0 && count <= D as u32 {
                for &v in cell.iter().filter(|&&v| values[v as usize].is_nan()) {
                    let (s, n) = &mut sums[v as usize];
                    (*s, *n) = (*s + sum, *n + count);
                }
            }
        }
        for (v, (sum, count)) in values.iter_mut().zip(sums).filter(|(_, s)| s.1 > 0) {
            *v = sum / f64::from(count);
        }
    }
}

impl<const D: usize> MomentumTerm<D> for SharpMembrane<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Points(&self.places)
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        let tension = self.law.tension(self.stretch[at.q]);
        (SVector::zeros(), self.points[at.q].projection() * -tension)
    }
    fn is_implicit(&self) -> bool {
        self.implicit_step.is_some()
    }
    fn stiffness(
        &self,
        at: &At<D>,
        _: &SVector<f64, D>,
        grad_u: &SMatrix<f64, D, D>,
    ) -> VectorForm<D> {
        let Some(dt) = self.implicit_step else { return (SVector::zeros(), SMatrix::zeros()) };
        let r = self.stretch[at.q];
        let weights = [self.law.stiffness(r) * r, self.law.tension(r).max(0.0)];
        let form = self.law.implicit_form(&self.points[at.q].normal, grad_u, weights);
        (SVector::zeros(), form * dt)
    }
}

impl<const D: usize> InterfaceForce<D> for SharpMembrane<D> {
    fn begin(
        &mut self,
        of: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        let rule = Rule { carry: Carry::ByOwner, acts: true, written: false };
        let initial = || Data::Scalar(vec![of.stretch.ln(); host.space.len()]);
        self.log_stretch = fields.add(&of.field_name("log_stretch"), rule, initial);
        Ok(())
    }
    fn term(&self) -> &dyn MomentumTerm<D> {
        self
    }
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()> {
        let implicit = at.step.filter(|_| of.coupling == Coupling::Implicit);
        let (phi, stretch) = (at.fields.scalar(of.level_set()), at.fields.scalar(self.log_stretch));
        SharpMembrane::prepare(self, at.space, phi, stretch, implicit)
    }
    /// Half of the growth of the stretch on the old interface, transported, and half on the new
    /// one: second order.
    fn advance(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &mut Moved<'_, D>,
        fields: &mut Fields<D>,
    ) -> Result<()> {
        let Velocity::Computed { mean, .. } = by.velocity else { return Ok(()) };
        let (space, half) = (by.carrier.tracer.space().clone(), 0.5 * by.dt);
        let mut stretch = by.before.scalar(self.log_stretch).to_vec();
        self.grow(&space, by.before.scalar(of.level_set()), mean, half, &mut stretch)?;
        let mut moved = by.convect(&stretch)?;
        self.grow(&space, fields.scalar(of.level_set()), mean, half, &mut moved)?;
        fields.scalar_mut(self.log_stretch).copy_from_slice(&moved);
        Ok(())
    }
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        _: &Basis<D>,
    ) -> Result<f64> {
        let (phi, stretch) = (at.fields.scalar(of.level_set()), at.fields.scalar(self.log_stretch));
        SharpMembrane::prepare(self, at.space, phi, stretch, None)?;
        Ok(SharpMembrane::energy(self))
    }
    fn dissipation(&self) -> f64 {
        self.dissipation
    }
    fn tension(&self) -> f64 {
        self.largest_tension()
    }
    /// The force acts on the surrounding fluid within one edge on each side.
    fn step_limit(&self, medium: &Medium) -> f64 {
        explicit_step_limit(medium, medium.edge, self.largest_tension())
    }
    fn check_coupling(&self, coupling: Coupling) -> Result<()> {
        coupling.refuse_semi_implicit(
            "the semi-implicit scheme (3.62)-(3.64) predicts the interface by diffusion in its \
             band, and a sharp one has none",
            Cause::SharpForce,
        )
    }
    fn reach(&self, _: &ImmersedInterface<D>) -> f64 {
        0.0
    }
}
