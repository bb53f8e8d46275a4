//! The cut interface of a sharp force, and its way over a step.

use crate::base::Result;
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{CarriedSurface, surface};
use crate::structure::{Fields, ImmersedInterface, Moved, Velocity};
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
