//! The membrane with area and shear resistance whose force acts on the interface itself.

use super::cut_surface::{CutSurface, Points, THINNEST};
use super::shear::{Strained, largest_tension, step_limit, wave_stiffnesses};
use super::slip::{nodal_slip, slip};
use super::surface_law::SurfaceLaw;
use crate::base::{Cause, Result};
use crate::fem::{At, Basis, Numbering, Space, SurfacePoint, VectorForm};
use crate::flow::term::{MomentumTerm, Support};
use crate::levelset::{CarriedPoints, End, continue_vectors, surface, surface_divergence};
use crate::mesh::{Location, Point};
use crate::structure::{
    Carry, Coupling, Data, Declaration, Density, FieldId, Fields, Host, ImmersedInterface,
    InterfaceForce, Medium, Moved, Place, RestMap, Rule, SurfaceStrain, Velocity,
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
/// Least slope of a distance that points to the interface.
const FLATTEST: f64 = 0.1;
/// Step of the derivatives of the map at time 0, in lengths of the mesh.
const STEP: f64 = 1e-6;

/// An elastic membrane in space on the zero level `S` of `phi` that resists area change and shear.
///
/// The force is the limit of that of [`ShearMembrane`](super::ShearMembrane) for a band of zero
/// width, `F(v) = - int_S T : grad v / Z1 ds`, and the energy `int_S W(Z1, Z2) / Z1 ds`: both are
/// integrals over the area at rest.
///
/// The strain is carried by points of matter on the interface. With `F` the deformation gradient of
/// the material and `P0` the projection on its tangent plane at rest, the surface tensor is
/// `A = F P0 (F P0)^T`, so that `DA/Dt = grad u A + A grad u^T` exactly; it maps normals to zero.
/// Each point takes `A` along, `Phi A Phi^T` after a step with `Phi` the gradient of the flow over
/// it, and an area at rest; nothing is interpolated from step to step. To the points two functions
/// on the interface are fitted ([`CarriedPoints`]): `1/Z1`, and the logarithm of the shape `A/Z1`, of
/// determinant 1 in the tangent plane, which gives a shape whatever the fit makes of its components.
/// The level set is moved onto the points as well.
///
/// The interface moves along itself with the fluid and the slip of `l/(15 mu)` times the
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
    /// The slip velocity of a predicted step, which the step itself has as well.
    slip_ahead: Option<Vec<SVector<f64, D>>>,
    /// Points of matter on the interface, and their [`NUMBERS`].
    points_of_matter: FieldId,
    matter: FieldId,
    rest_density: FieldId,
    log_shape: [FieldId; 6],
    /// The least area at rest per area that is not taken for an error of a fit.
    least: f64,
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
            slip_ahead: None,
            points_of_matter: FieldId::default(),
            matter: FieldId::default(),
            rest_density: FieldId::default(),
            log_shape: [FieldId::default(); 6],
            least: 0.0,
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
    /// The strain at a point of the interface at time 0, where its unit normal is `normal`: by the
    /// map at rest and the stretch of the interface. `h` is the step of a difference quotient.
    fn initial(
        &self,
        (x, normal): (&Point<D>, &SVector<f64, D>),
        stretch: f64,
        h: f64,
    ) -> SurfaceStrain<D> {
        let gradient = match &self.map {
            None => SMatrix::identity(),
            Some(map) => {
                SMatrix::from_columns(&std::array::from_fn::<SVector<f64, D>, D, _>(|k| {
                    let mut step = Point::<D>::zeros();
                    step[k] = h;
                    (map(&(x + step)) - map(&(x - step))) / (2.0 * h)
                }))
            }
        };
        SurfaceStrain::new(normal, &gradient, stretch)
    }
    fn prepare_at(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        implicit: Option<f64>,
    ) -> Result<()> {
        self.implicit_step = implicit;
        (self.points, self.strained) =
            self.strains(of, (at.space, at.fields), implicit.is_some())?;
        self.places = self.points.iter().map(|p| p.at).collect();
        Ok(())
    }
    /// Points of the interface with their strains.
    fn strains(
        &mut self,
        of: &ImmersedInterface<D>,
        (space, fields): (&Space<D>, &Fields<D>),
        implicit: bool,
    ) -> Result<(Points<D>, Vec<Strained<D>>)> {
        let points = self.cuts.of(space, fields.scalar(of.level_set()))?;
        let strained = |p: &SurfacePoint<D>| {
            let strain = self.strain_of(space, fields, p);
            Strained::new(self.law, strain, 1.0 / strain.z1, implicit)
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
        let (points, strained) = self.strains(of, (space, by.before), false)?;
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
    /// Power of the tangential force on the slip, on the prepared interface.
    fn power_of_slip(&self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<f64> {
        let tension = |p: &SurfacePoint<D>| -self.strained[p.at.q].force();
        let on = (at.space, &*self.unknowns);
        let phi = at.fields.scalar(of.level_set());
        let force = surface_divergence(on, (&self.points, phi), tension, |_| 0.0)?;
        let power = |p: &SurfacePoint<D>| {
            let f = at.space.value(&force, p.at.cell, &p.at.barycentric);
            p.at.weight * slip(at.space, p, self.viscosity) * f.norm_squared()
        };
        Ok(self.points.iter().map(power).sum())
    }
    fn strain_of(
        &self,
        space: &Space<D>,
        fields: &Fields<D>,
        p: &SurfacePoint<D>,
    ) -> SurfaceStrain<D> {
        let value = |id: FieldId| space.value(fields.scalar(id), p.at.cell, &p.at.barycentric);
        let log_shape = matrix(self.log_shape.map(value));
        let z1 = 1.0 / value(self.rest_density).max(self.least);
        SurfaceStrain::from_log_shape(&p.normal, z1, &log_shape)
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

/// `Z1` of a surface tensor `A`, (3.40).
fn area_change<const D: usize>(a: &SMatrix<f64, D, D>) -> f64 {
    if D == 2 {
        return a.trace().sqrt();
    }
    (0.5 * (a.trace().powi(2) - (a * a).trace())).sqrt()
}

/// Numbers of a point of matter: its area at rest, and the components of `A`.
const NUMBERS: usize = 7;

/// A point of matter.
struct Matter<const D: usize> {
    /// Area at rest; 0 for a point that has left the domain.
    rest: f64,
    a: SMatrix<f64, D, D>,
}

impl<const D: usize> Matter<D> {
    fn read(numbers: &[f64]) -> Matter<D> {
        Matter { rest: numbers[0], a: matrix(std::array::from_fn(|i| numbers[i + 1])) }
    }
    fn write(&self, out: &mut [f64]) {
        out[0] = self.rest;
        out[1..NUMBERS].copy_from_slice(&components(&self.a));
    }
    /// Its area.
    fn area(&self) -> f64 {
        if self.rest > 0.0 { self.rest * area_change(&self.a) } else { 0.0 }
    }
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
        let (low, high) = host.space.mesh().bounding_box();
        let h = STEP * (high - low).norm();
        let points = surface(host.space, &of.phi)?;
        self.least = THINNEST / of.stretch;
        let mut matter = vec![0.0; NUMBERS * points.len()];
        for (p, numbers) in points.iter().zip(matter.chunks_exact_mut(NUMBERS)) {
            let strain = self.initial((&p.at.x, &p.normal), of.stretch, h);
            Matter { rest: p.at.weight / strain.z1, a: strain.tensor() }.write(numbers);
        }
        let places = || Data::Points(points.iter().map(|p| p.at.x).collect());
        self.points_of_matter = fields.add(&of.field_name("points_of_matter"), rule(), places);
        self.matter = fields.add(&of.field_name("matter"), rule(), || Data::Numbers(matter));
        // Constant along the normal: that of the nearest point of the interface.
        let axis = SVector::<f64, D>::from_fn(|i, _| if i == 0 { 1.0 } else { 0.0 });
        let nearest = |((x, g), phi): ((&Point<D>, &SVector<f64, D>), &f64)| {
            // On the medial axis of the shape no point is the nearest one.
            let (normal, near) = match g.try_normalize(FLATTEST * of.stretch) {
                Some(normal) => (normal, x - normal * (phi / g.norm())),
                None => (axis, *x),
            };
            self.initial((&near, &normal), of.stretch, h)
        };
        let slopes = host.space.means(|c, l| host.space.gradient(&of.phi, c, l));
        let nodes = host.space.nodes().iter().zip(&slopes).zip(&of.phi);
        let start: Vec<SurfaceStrain<D>> = nodes.map(nearest).collect();
        let density = || Data::Scalar(start.iter().map(|s| 1.0 / s.z1).collect());
        self.rest_density = fields.add(&of.field_name("rest_density"), rule(), density);
        for (k, (_, _, name)) in COMPONENTS.into_iter().enumerate() {
            let component = |s: &SurfaceStrain<D>| components(&s.log_shape())[k];
            let values = || Data::Scalar(start.iter().map(component).collect());
            self.log_shape[k] = fields.add(&of.field_name(name), rule(), values);
        }
        Ok(())
    }
    fn term(&self) -> Option<&dyn MomentumTerm<D>> {
        Some(self)
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
        let Velocity::Computed { mean, .. } = by.velocity else { return Ok(()) };
        let slip = match self.slip_ahead.take().filter(|_| !by.ahead) {
            Some(slip) => slip,
            None => self.slip(of, by)?,
        };
        let u: Vec<SVector<f64, D>> = mean.iter().zip(&slip).map(|(u, w)| u + w).collect();
        self.slip_ahead = by.ahead.then_some(slip);
        let (tracer, before) = (&by.carrier.tracer, by.before);
        let (space, level_set) = (tracer.space(), of.level_set());
        let starts = before.vector(self.points_of_matter);
        let carried = CarriedPoints::new(tracer, (&u, by.dt), starts);
        let numbers = before.scalar(self.matter).chunks_exact(NUMBERS);
        let matter = numbers.zip(carried.ends()).map(|(numbers, end)| {
            let Matter { rest, a } = Matter::<D>::read(numbers);
            match end {
                Some(End { deformation: phi, .. }) => Matter { rest, a: phi * a * phi.transpose() },
                None => Matter { rest: 0.0, a },
            }
        });
        let matter: Vec<Matter<D>> = matter.collect();
        let weights: Vec<f64> = matter.iter().map(Matter::area).collect();
        if !by.ahead && fields.map.is_none() {
            let to = surface(space, fields.scalar(level_set))?;
            carried.fit(&weights, &to, fields.scalar_mut(level_set))?;
        }
        let phi = fields.scalar(level_set);
        let to = self.cuts.of(space, phi)?;
        let value = |k: usize, at: &Location| {
            let a = &matter[k].a;
            let slope = space.gradient(phi, at.cell as usize, &at.barycentric);
            let log = match slope.try_normalize(0.0) {
                Some(n) => components(&SurfaceStrain::from_shape(&n, 1.0, a).log_shape()),
                None => [0.0; 6],
            };
            let [xx, xy, xz, yy, yz, zz] = log;
            [1.0 / area_change(a), xx, xy, xz, yy, yz, zz]
        };
        let fitted = carried.fields(&weights, (&to, phi), value)?;
        // The value of nodes that no force reads is any.
        let ids = std::iter::once(self.rest_density).chain(self.log_shape);
        for (k, (id, values)) in ids.zip(fitted).enumerate() {
            let anything = if k == 0 { 1.0 } else { 0.0 };
            let known = values.into_iter().map(|v| if v.is_nan() { anything } else { v });
            fields.scalar_mut(id).iter_mut().zip(known).for_each(|(f, v)| *f = v);
        }
        if !by.ahead {
            let places = fields.vector_mut(self.points_of_matter).iter_mut();
            for (x, end) in places.zip(carried.ends()) {
                *x = end.as_ref().map_or(*x, |end| space.mesh().point_at(&end.at));
            }
            let numbers = fields.scalar_mut(self.matter).chunks_exact_mut(NUMBERS);
            numbers.zip(&matter).for_each(|(numbers, matter)| matter.write(numbers));
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
        largest_tension(self.strained.iter())
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
    fn surface_density(&self) -> Option<(FieldId, Density)> {
        Some((self.rest_density, Density::Rest))
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
