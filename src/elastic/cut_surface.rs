//! The cut interface of a force, its way over a step, and the stretch that it carries.

use crate::base::Result;
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{CarriedSurface, surface};
use crate::structure::{
    Carry, Data, Declaration, FieldId, Fields, Host, ImmersedInterface, InitialFunction, Moved,
    Rule, Velocity,
};
use std::sync::Arc;

/// Number of cached interfaces: at the start of a step, predicted for its end, and at its end.
const KEPT: usize = 3;

/// Quadrature points on an interface.
pub(super) type Points<const D: usize> = Arc<[SurfacePoint<D>]>;

/// Cut interfaces with their level sets: a step uses each several times.
#[derive(Clone, Debug, Default)]
pub(super) struct CutSurface<const D: usize> {
    known: Vec<(Vec<f64>, Points<D>)>,
}

impl<const D: usize> CutSurface<D> {
    /// Quadrature points on the interface of `phi`.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn of(&mut self, space: &Space<D>, phi: &[f64]) -> Result<Points<D>> {
        if let Some((_, points)) = self.known.iter().find(|(known, _)| known == phi) {
            return Ok(Arc::clone(points));
        }
        let points: Points<D> = surface(space, phi)?.into();
        self.known.truncate(KEPT - 1);
        self.known.insert(0, (phi.to_vec(), Arc::clone(&points)));
        Ok(points)
    }
    /// Carries the interface over a step along the paths of its points, and moves the level set,
    /// unless it is predicted or composed of maps, onto them. Returns also the points on the new
    /// interface; `None` in a prescribed velocity, in which no force acts.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn follow<'a>(
        &mut self,
        of: &ImmersedInterface<D>,
        by: &'a Moved<'_, D>,
        fields: &mut Fields<D>,
    ) -> Result<Option<(CarriedSurface<'a, D>, Points<D>)>> {
        let Velocity::Computed { mean, .. } = by.velocity else { return Ok(None) };
        let tracer = &by.carrier.tracer;
        let (space, before) = (tracer.space(), by.before.scalar(of.level_set()));
        let from = self.of(space, before)?;
        let carried = CarriedSurface::new(tracer, (mean, by.dt), (from, before));
        if !by.ahead && fields.map.is_none() {
            let to = surface(space, fields.scalar(of.level_set()))?;
            carried.fit(&to, fields.scalar_mut(of.level_set()))?;
        }
        let to = self.of(space, fields.scalar(of.level_set()))?;
        Ok(Some((carried, to)))
    }
}

/// Least density, over the mean one at time 0, that is not taken for an error of the transport.
pub(super) const THINNEST: f64 = 1e-3;

/// The inverse of the stretch, length (in space: area) at rest per length, as a density that the
/// interface carries: `Dm/Dt + m P : grad u = 0`, see
/// [`Onto::density`](crate::levelset::Onto::density).
#[derive(Clone, Debug, Default)]
pub(super) struct RestDensity<const D: usize> {
    /// The interface that carries it.
    pub cuts: CutSurface<D>,
    /// Its field: values count at the nodes of cut cells.
    pub field: FieldId,
    /// The least density that is not taken for an error of the transport.
    least: f64,
}

impl<const D: usize> RestDensity<D> {
    /// Declares the field; its values at time 0 are those of `initial`, else the inverse of the
    /// stretch.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn begin(
        &mut self,
        of: &ImmersedInterface<D>,
        host: &Host<'_, D>,
        initial: Option<&InitialFunction<D>>,
        fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        let rule = Rule { carry: Carry::ByOwner, acts: true, written: false };
        let values: Vec<f64> = match initial {
            Some(density) => host.space.nodes().iter().map(density).collect(),
            None => vec![1.0 / of.stretch; host.space.len()],
        };
        // Far from the interface a function may have any values. On a later mesh the level set at
        // time 0 is not known, and the least density is.
        if of.phi.len() == host.space.len() {
            let at = |p: &SurfacePoint<D>| host.space.value(&values, p.at.cell, &p.at.barycentric);
            let points = surface(host.space, &of.phi)?;
            let amount: f64 = points.iter().map(|p| p.at.weight * at(p).abs()).sum();
            let size: f64 = points.iter().map(|p| p.at.weight).sum();
            self.least = if size > 0.0 { THINNEST * amount / size } else { 0.0 };
        }
        self.field = fields.add(&of.field_name("rest_density"), rule, || Data::Scalar(values));
        Ok(())
    }
    /// The stretch where the density has this value: its inverse.
    pub fn stretch(&self, density: f64) -> f64 {
        1.0 / density.max(self.least)
    }
    /// Moves the level set onto the points of the interface that were carried by the fluid, and
    /// carries the density with this diffusivity, a function of the stretch, times the step. The
    /// values continue along the normals as far as `reach`.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn advance(
        &mut self,
        of: &ImmersedInterface<D>,
        (by, fields): (&mut Moved<'_, D>, &mut Fields<D>),
        reach: f64,
        diffusivity: impl Fn(&SurfacePoint<D>, f64) -> f64,
    ) -> Result<()> {
        let Some((carried, to)) = self.cuts.follow(of, by, fields)? else { return Ok(()) };
        let (density, phi) = (by.before.scalar(self.field), fields.scalar(of.level_set()));
        let mut onto = carried.onto(&to, phi)?;
        let of_density = |p: &SurfacePoint<D>, m: f64| diffusivity(p, self.stretch(m));
        let mut after = onto.density(density, !by.ahead, of_density)?;
        if reach > 0.0 {
            onto.continue_to(reach, &mut after);
        }
        fields.scalar_mut(self.field).copy_from_slice(&after);
        Ok(())
    }
}
