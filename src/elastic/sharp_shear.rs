//! The membrane with area and shear resistance whose force acts on the interface itself.

use super::cut_surface::{CutSurface, Points, stretch};
use super::shear::{Strained, step_limit, wave_stiffnesses};
use super::slip::{nodal_slip, slip};
use super::surface_law::SurfaceLaw;
use crate::base::{Cause, Result};
use crate::fem::{At, Basis, Numbering, Space, SurfacePoint, VectorForm};
use crate::flow::term::{MomentumTerm, Support};
use crate::levelset::{Path, continue_vectors, surface_divergence};
use crate::mesh::Point;
use crate::structure::{
    Carry, Coupling, Data, Declaration, FieldId, Fields, Host, ImmersedInterface, InterfaceForce,
    Medium, Moved, Place, RestMap, Rule, SurfaceStrain, Velocity,
};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Components of the logarithm of the shape, row and column, with the names of their fields.
const COMPONENTS: [(usize, usize, &str); 6] = [
    (0, 0, "log_shape_xx"),
    (0, 1, "log_shape_xy"),
    (0, 2, "log_shape_xz"),
    (1, 1, "log_shape_yy"),
    (1, 2, "log_shape_yz"),
    (2, 2, "log_shape_zz"),
];
/// Step of the derivatives of the map at time 0, in lengths of the mesh.
const STEP: f64 = 1e-6;

/// An elastic membrane in space on the zero level `S` of `phi` that resists area change and shear.
///
/// The force is the limit of that of [`ShearMembrane`](super::ShearMembrane) for a band of zero
/// width, `F(v) = - int_S T : grad v / Z1 ds`, and the energy `int_S W(Z1, Z2) / Z1 ds`: both are
/// integrals over the area at rest.
///
/// The strain is carried by the interface. With `F` the deformation gradient of the material and
/// `P0` the projection on its tangent plane at rest, the surface tensor is `A = F P0 (F P0)^T`, so
/// that `DA/Dt = grad u A + A grad u^T` exactly; it maps normals to zero. `1/Z1` is a conserved
/// density as in [`SharpMembrane`](super::SharpMembrane); the shape `A/Z1`, of determinant 1 in the
/// tangent plane, is that where a point comes from, `Phi A Phi^T` with `Phi` the gradient of the
/// flow over the step, made tangential and scaled. Of it the logarithm is carried, which stays that
/// of a shape whatever a projection makes of its components. Nothing is read off the interface,
/// where backward characteristics wind up.
///
/// The interface moves along itself with the fluid and a [`slip`] of `l/(15 mu)` times the
/// tangential force `P div_S T`, which is projected and smoothed along the interface, implicit Euler
/// for the diffusion that it is.
#[derive(Clone)]
pub struct SharpShearMembrane<const D: usize> {
    law: SurfaceLaw,
    /// `Y` at time 0; `None` for the identity.
    map: Option<Arc<RestMap<D>>>,
    cuts: CutSurface<D>,
    points: Points<D>,
    /// The same points without normals.
    places: Vec<At<D>>,
    strained: Vec<Strained<D>>,
    implicit_step: Option<f64>,
    /// Viscosity of the surrounding fluid.
    viscosity: f64,
    /// One number per node, equal for nodes that periodic sides identify.
    unknowns: Arc<[u32]>,
    /// Dissipation rate of the slip.
    dissipation: f64,
    rest_density: FieldId,
    log_shape: [FieldId; 6],
}

impl<const D: usize> SharpShearMembrane<D> {
    /// A membrane at rest at time 0 up to the stretch of its interface, in a fluid of this viscosity
    /// (between two fluids, their mean).
    pub fn new(law: SurfaceLaw, viscosity: f64) -> SharpShearMembrane<D> {
        SharpShearMembrane {
            law,
            map: None,
            cuts: CutSurface::default(),
            points: Points::default(),
            places: Vec::new(),
            strained: Vec::new(),
            implicit_step: None,
            viscosity,
            unknowns: Arc::new([]),
            dissipation: 0.0,
            rest_density: FieldId::default(),
            log_shape: [FieldId::default(); 6],
        }
    }
    /// The same membrane with the material position at rest given by `map`.
    pub fn with_map(self, map: Arc<RestMap<D>>) -> SharpShearMembrane<D> {
        SharpShearMembrane { map: Some(map), ..self }
    }
    /// Elastic energy of the prepared interface.
    fn sum_of_energies(&self) -> f64 {
        let energy = |(p, s): (&SurfacePoint<D>, &Strained<D>)| {
            p.at.weight * s.w * self.law.response(s.strain.z1, s.strain.z2).energy
        };
        self.points.iter().zip(&self.strained).map(energy).sum()
    }
    /// Strains of the nodes at time 0: by the map at rest and the stretch of the interface.
    fn initial(&self, of: &ImmersedInterface<D>, space: &Space<D>) -> Vec<SurfaceStrain<D>> {
        let (low, high) = space.mesh().bounding_box();
        let h = STEP * (high - low).norm();
        let gradient = |x: &Point<D>| match &self.map {
            None => SMatrix::identity(),
            Some(map) => {
                SMatrix::from_columns(&std::array::from_fn::<SVector<f64, D>, D, _>(|k| {
                    let mut step = Point::<D>::zeros();
                    step[k] = h;
                    (map(&(x + step)) - map(&(x - step))) / (2.0 * h)
                }))
            }
        };
        let axis = SVector::<f64, D>::from_fn(|i, _| if i == 0 { 1.0 } else { 0.0 });
        // Constant along the normal: that of the nearest point of the interface.
        let strain = |((x, g), phi): ((&Point<D>, &SVector<f64, D>), &f64)| {
            let (normal, near) = match g.try_normalize(0.0) {
                Some(normal) => (normal, x - normal * (phi / g.norm())),
                None => (axis, *x),
            };
            SurfaceStrain::new(&normal, &gradient(&near), of.stretch)
        };
        let slopes = space.means(|c, l| space.gradient(&of.phi, c, l));
        space.nodes().iter().zip(&slopes).zip(&of.phi).map(strain).collect()
    }
    fn prepare_at(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        implicit: Option<f64>,
    ) -> Result<()> {
        self.implicit_step = implicit;
        self.points = self.cuts.of(at.space, at.fields.scalar(of.level_set()))?;
        self.places = self.points.iter().map(|p| p.at).collect();
        let strained = |p: &SurfacePoint<D>| {
            let strain = self.strain_of(at.space, at.fields, p);
            Strained::new(self.law, strain, 1.0 / strain.z1, implicit.is_some())
        };
        self.strained = self.points.iter().map(strained).collect();
        Ok(())
    }
    /// Points of the interface with their strains.
    fn strains(
        &mut self,
        of: &ImmersedInterface<D>,
        space: &Space<D>,
        fields: &Fields<D>,
    ) -> Result<(Points<D>, Vec<Strained<D>>)> {
        let points = self.cuts.of(space, fields.scalar(of.level_set()))?;
        let strained = |p: &SurfacePoint<D>| {
            let strain = self.strain_of(space, fields, p);
            Strained::new(self.law, strain, 1.0 / strain.z1, false)
        };
        let all = points.iter().map(strained).collect();
        Ok((points, all))
    }
    /// The slip velocity at the nodes for the fields at the start of a step.
    fn slip(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &Moved<'_, D>,
    ) -> Result<Vec<SVector<f64, D>>> {
        let tracer = &by.carrier.tracer;
        let (space, phi) = (tracer.space(), by.before.scalar(of.level_set()));
        let (points, strained) = self.strains(of, space, by.before)?;
        let (law, viscosity) = (self.law, self.viscosity);
        let smoothing = |p: &SurfacePoint<D>| {
            let s = &strained[p.at.q];
            by.dt * slip(space, p, viscosity) * s.stiffest(law)
        };
        let tension = |p: &SurfacePoint<D>| -strained[p.at.q].force();
        let on = (&**space, tracer.unknowns());
        let mut velocity = surface_divergence(on, (&points, phi), tension, smoothing)?;
        let factors = nodal_slip(space, &points, viscosity);
        velocity.iter_mut().zip(factors).for_each(|(w, factor)| *w *= factor);
        continue_vectors(tracer, &points, &mut velocity);
        Ok(velocity)
    }
    /// Power of the tangential force on the slip.
    fn power_of_slip(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<f64> {
        let (points, strained) = self.strains(of, at.space, at.fields)?;
        let tension = |p: &SurfacePoint<D>| -strained[p.at.q].force();
        let on = (at.space, &*self.unknowns);
        let phi = at.fields.scalar(of.level_set());
        let force = surface_divergence(on, (&points, phi), tension, |_| 0.0)?;
        let power = |p: &SurfacePoint<D>| {
            let f = at.space.value(&force, p.at.cell, &p.at.barycentric);
            p.at.weight * slip(at.space, p, self.viscosity) * f.norm_squared()
        };
        Ok(points.iter().map(power).sum())
    }
    fn strain_of(
        &self,
        space: &Space<D>,
        fields: &Fields<D>,
        p: &SurfacePoint<D>,
    ) -> SurfaceStrain<D> {
        let value = |id: FieldId| space.value(fields.scalar(id), p.at.cell, &p.at.barycentric);
        let log_shape = matrix(self.log_shape.map(value));
        SurfaceStrain::from_log_shape(&p.normal, stretch(value(self.rest_density)), &log_shape)
    }
}

/// The symmetric matrix with these components.
fn matrix<const D: usize>(values: [f64; 6]) -> SMatrix<f64, D, D> {
    let mut m = SMatrix::zeros();
    for ((i, j, _), v) in COMPONENTS.into_iter().zip(values) {
        if j < D {
            (m[(i, j)], m[(j, i)]) = (v, v);
        }
    }
    m
}

/// The components of a symmetric matrix.
fn components<const D: usize>(m: &SMatrix<f64, D, D>) -> [f64; 6] {
    COMPONENTS.map(|(i, j, _)| if j < D { m[(i, j)] } else { 0.0 })
}

/// The logarithm of the shape at the end of a path from that at its start.
fn carried_shape<const D: usize>(before: [f64; 6], path: &Path<D>) -> [f64; 6] {
    let start = SurfaceStrain::from_log_shape(&path.normals[0], 1.0, &matrix(before)).tensor();
    let phi = path.deformation();
    let end = phi * start * phi.transpose();
    components(&SurfaceStrain::from_shape(&path.normals[1], 1.0, &end).log_shape())
}

impl<const D: usize> MomentumTerm<D> for SharpShearMembrane<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Points(&self.places)
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        (SVector::zeros(), self.strained[at.q].force())
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
        (SVector::zeros(), self.strained[at.q].stiffness(grad_u) * dt)
    }
}

impl<const D: usize> InterfaceForce<D> for SharpShearMembrane<D> {
    fn begin(
        &mut self,
        of: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        let rule = || Rule { carry: Carry::ByOwner, acts: true, written: false };
        self.unknowns = Numbering::scalar_unknowns(host.space, host.translations).0.into();
        let start = self.initial(of, host.space);
        self.rest_density = fields.add(&of.field_name("rest_density"), rule(), || {
            Data::Scalar(start.iter().map(|s| 1.0 / s.z1).collect())
        });
        let shapes: Vec<[f64; 6]> =
            start.iter().map(|s| components(&s.log_shape())).collect();
        for (k, (_, _, name)) in COMPONENTS.into_iter().enumerate() {
            let values = || Data::Scalar(shapes.iter().map(|s| s[k]).collect());
            self.log_shape[k] = fields.add(&of.field_name(name), rule(), values);
        }
        Ok(())
    }
    fn term(&self) -> &dyn MomentumTerm<D> {
        self
    }
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()> {
        self.prepare_at(of, at, at.step.filter(|_| of.coupling == Coupling::Implicit))
    }
    fn advance(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &mut Moved<'_, D>,
        fields: &mut Fields<D>,
    ) -> Result<()> {
        if !matches!(by.velocity, Velocity::Computed { .. }) {
            return Ok(());
        }
        let slip = self.slip(of, by)?;
        let Some((carried, to)) = self.cuts.follow(of, by, Some(&slip), fields)? else {
            return Ok(());
        };
        let mut onto = carried.onto(&to, fields.scalar(of.level_set()))?;
        let before = |id: FieldId| by.before.scalar(id);
        let density = onto.density(before(self.rest_density), !by.ahead, |_, _| 0.0)?;
        let shape = onto.fields(self.log_shape.map(before), carried_shape)?;
        fields.scalar_mut(self.rest_density).copy_from_slice(&density);
        for (id, values) in self.log_shape.iter().zip(shape) {
            fields.scalar_mut(*id).copy_from_slice(&values);
        }
        Ok(())
    }
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        _: &Basis<D>,
    ) -> Result<f64> {
        self.prepare_at(of, at, None)?;
        self.dissipation = self.power_of_slip(of, at)?;
        Ok(self.sum_of_energies())
    }
    fn dissipation(&self) -> f64 {
        self.dissipation
    }
    /// The force acts on the surrounding fluid within one edge on each side.
    fn step_limit(&self, medium: &Medium) -> f64 {
        step_limit(wave_stiffnesses(self.law, self.strained.iter()), medium.edge, medium)
    }
    fn tension(&self) -> f64 {
        wave_stiffnesses(self.law, self.strained.iter())[0]
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
    fn keeps_distance(&self) -> bool {
        true
    }
    fn rest_map(&self) -> Option<&RestMap<D>> {
        self.map.as_deref()
    }
    fn carries_strain(&self) -> bool {
        true
    }
    fn rest_density(&self) -> Option<FieldId> {
        Some(self.rest_density)
    }
    fn strain_at(
        &self,
        space: &Space<D>,
        fields: &Fields<D>,
        point: &SurfacePoint<D>,
    ) -> Option<SurfaceStrain<D>> {
        Some(self.strain_of(space, fields, point))
    }
}
