//! Level sets that segment an image: no flow is solved, and the first passive level set descends along an energy.

use super::passive::nothing_solved;
use super::step::Simulation;
use crate::base::{Error, Phase, Result};
use crate::flow::StepReport;
use crate::levelset::{Segmentation, SegmentationFit, parts_inside};

/// The segmentation of an image in the course of a simulation.
pub(super) struct Descent<const D: usize> {
    segmentation: Segmentation<D>,
    /// The image at the nodes, for files.
    nodal: Vec<f64>,
}

impl<const D: usize> Simulation<D> {
    /// Lets the one passive level set of a simulation without a flow descend along the energy of a segmentation, which means that it
    /// [becomes a distance again](Self::redistance_every). `nodal` is the image at the nodes.
    pub fn descend_along(&mut self, segmentation: Segmentation<D>, nodal: Vec<f64>) {
        self.descent = Some(Descent { segmentation, nodal });
    }

    /// The image that is segmented, at the nodes.
    pub fn image(&self) -> Option<&[f64]> {
        self.descent.as_ref().map(|d| d.nodal.as_slice())
    }

    /// The segmentation, if there is one.
    pub fn segmentation(&self) -> Option<&Segmentation<D>> {
        self.descent.as_ref().map(|d| &d.segmentation)
    }

    /// The energy of the level set on the image, and the number of parts that it has inside; `None` where nothing is segmented.
    ///
    /// # Errors
    /// One of the two sides is gone.
    pub fn segmented(&self) -> Result<Option<(SegmentationFit, usize)>> {
        let Some(segmentation) = self.segmentation() else { return Ok(None) };
        let phi = self.level_set(0);
        Ok(Some((segmentation.fit(&phi)?, parts_inside(&self.space, &phi))))
    }

    /// One step down the energy.
    pub(super) fn descend(&mut self) -> Result<StepReport> {
        let (Some(Descent { segmentation, .. }), Some(phi)) = (&mut self.descent, self.state.phi.first_mut()) else {
            return Err(Error::internal("there is no level set to segment an image with"));
        };
        let (dt, steps) = (self.settings.dt, self.state.steps + 1);
        let time = steps as f64 * dt;
        let place = |e: Error| e.at(format!("time {time:.6}"));
        self.phases.begin();
        segmentation.step(dt, phi).map_err(place)?;
        self.redistance(steps).map_err(place)?;
        self.phases.end(Phase::Transport);
        self.state.steps = steps;
        self.state.time = time;
        Ok(nothing_solved())
    }
}
