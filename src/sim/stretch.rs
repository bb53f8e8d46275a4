//! The stretch of sharp membranes, carried beside their level sets.

use super::setup::{Configuration, Structure};
use super::step::Simulation;
use crate::base::Result;
use crate::flow::FlowSolver;
use crate::transport::Wind;
use nalgebra::SVector;

impl<const D: usize> Simulation<D> {
    /// Whether some membrane is sharp.
    pub(super) fn is_sharp(&self) -> bool {
        self.structures.iter().any(|s| s.sharp.is_some())
    }
    /// The stretch at time 0: the slope of the level set, which is that of a distance times a number.
    pub(super) fn begin_stretch(&mut self) {
        let nodes = self.space.len();
        let initial = |s: &Structure<D>| match s.sharp {
            Some(_) => vec![s.stretch.ln(); nodes],
            None => Vec::new(),
        };
        self.state.stretch = self.structures.iter().map(initial).collect();
    }
    /// Takes stock of the structures where they are as `of` says.
    pub(super) fn prepare_structures(
        &mut self,
        flow: &FlowSolver<D>,
        of: Configuration<'_, D>,
        implicit_step: Option<f64>,
    ) -> Result<()> {
        for (k, (phi, stretch)) in of.phi.iter().zip(of.stretch).enumerate().take(self.structures.len()) {
            let rest = self.rest_of(k, of.displacement);
            let s = &mut self.structures[k];
            match (&mut s.shear, &mut s.sharp) {
                (Some(shear), _) => shear.prepare(flow.velocity(), phi, &rest, implicit_step),
                (None, Some(sharp)) => sharp.prepare(&self.space, phi, stretch, implicit_step)?,
                (None, None) => match &mut s.continuum {
                    Some(force) => force.prepare(flow.velocity(), phi),
                    None => s.membrane.prepare(flow.velocity(), phi, implicit_step),
                },
            }
        }
        Ok(())
    }
    /// Takes stock of the sharp membranes where they are, for their energies.
    pub(super) fn prepare_sharp(&mut self) -> Result<()> {
        for ((s, phi), stretch) in self.structures.iter_mut().zip(&self.state.phi).zip(&self.state.stretch) {
            if let Some(sharp) = &mut s.sharp {
                sharp.prepare(&self.space, phi, stretch, None)?;
            }
        }
        Ok(())
    }
    /// The stretch after a step with the velocity `w`, which brings the level sets from `before` to `after`: half of the growth on the old
    /// interface, carried, and half on the new one. Of second order.
    pub(super) fn stretched(
        &mut self,
        w: &[SVector<f64, D>],
        before: &[Vec<f64>],
        after: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>> {
        let mut stretch = self.state.stretch.clone();
        if !self.is_sharp() {
            return Ok(stretch);
        }
        let dt = self.settings.dt;
        self.grow(w, before, &mut stretch)?;
        for list in stretch.iter_mut().filter(|s| !s.is_empty()) {
            let mut moved = Vec::new();
            self.carrier.carry(std::slice::from_ref(list), &Wind::Nodal(w), dt, &mut moved)?;
            *list = moved.into_iter().flatten().collect();
        }
        self.grow(w, after, &mut stretch)?;
        Ok(stretch)
    }
    /// Half a step of growth on the interfaces of `level_sets`.
    fn grow(&self, w: &[SVector<f64, D>], level_sets: &[Vec<f64>], stretch: &mut [Vec<f64>]) -> Result<()> {
        for ((s, phi), stretch) in self.structures.iter().zip(level_sets).zip(stretch) {
            if let Some(sharp) = &s.sharp {
                sharp.grow(&self.space, phi, w, 0.5 * self.settings.dt, stretch)?;
            }
        }
        Ok(())
    }
}
