//! Segmentation of an image by active contours (1.29): a level set follows the gradient flow of an
//! energy; there is no flow.

use super::advection::nothing_solved;
use super::carried::{Carried, Transport, When};
use super::state::State;
use crate::base::{Error, PHASES, Phase, Phases, Result};
use crate::fem::Space;
use crate::flow::StepReport;
use crate::levelset::{Redistancing, Segmentation, SegmentationFit, parts_inside};
use crate::structure::{Fields, LevelSet};
use std::borrow::Cow;
use std::sync::Arc;

/// A level set that segments an image, in progress.
pub struct Segmenting<const D: usize> {
    segmentation: Segmentation<D>,
    /// The image at the nodes, for output.
    nodal: Vec<f64>,
    dt: f64,
    carried: Carried<D>,
    state: State<D>,
    phases: Phases,
}

impl<const D: usize> Segmenting<D> {
    /// The level set `contour` on `space` in the gradient flow of the energy of `segmentation`, in
    /// pseudo-time steps of length `dt`. It is redistanced after every `rebuild` steps by `method`.
    /// `nodal` is the image at the nodes.
    ///
    /// # Errors
    /// Internal, if the fields cannot be declared.
    pub fn new(
        space: &Arc<Space<D>>,
        (segmentation, nodal): (Segmentation<D>, Vec<f64>),
        (dt, rebuild, method): (f64, usize, Redistancing),
        contour: LevelSet<D>,
    ) -> Result<Segmenting<D>> {
        let none = Fields::default();
        let (transport, structures) = (Transport::default(), vec![Box::new(contour) as _]);
        let (mut carried, fields) =
            Carried::new(space, Vec::new(), transport, structures, (None, &none))?;
        carried.redistance_when(When::Every(rebuild as u64), method);
        let mut state = State { fields, ..State::default() };
        state.flow.u = vec![nalgebra::SVector::zeros(); space.len()];
        Ok(Segmenting { segmentation, nodal, dt, carried, state, phases: Phases::default() })
    }

    /// Takes one step of the gradient flow.
    ///
    /// # Errors
    /// One of the two sides is empty.
    pub fn step(&mut self) -> Result<StepReport> {
        let (dt, steps) = (self.dt, self.state.steps + 1);
        let time = steps as f64 * dt;
        let place = |e: Error| e.at(format!("time {time:.6}"));
        let Some(id) = self.carried.structures.first().and_then(|s| s.level_set()) else {
            return Err(Error::internal("there is no level set to segment an image with"));
        };
        self.phases.begin();
        let mut phi = self.state.fields.scalar(id).to_vec();
        self.segmentation.step(dt, &mut phi).map_err(place)?;
        self.state.fields.scalar_mut(id).copy_from_slice(&phi);
        self.phases.end(Phase::Transport);
        if self.carried.redistance(steps, &mut self.state.fields).map_err(place)? {
            self.phases.end(Phase::Redistance);
        }
        (self.state.steps, self.state.time) = (steps, time);
        Ok(nothing_solved())
    }
    /// Continues from a state of the same problem.
    ///
    /// # Errors
    /// Fields or sizes that do not fit.
    pub fn restore(&mut self, state: State<D>) -> Result<()> {
        self.state.check_fits(&state)?;
        self.state = state;
        Ok(())
    }
    /// Energy of the level set on the image, and number of connected parts of its inside.
    ///
    /// # Errors
    /// One of the two sides is empty.
    pub fn fit(&self) -> Result<(SegmentationFit, usize)> {
        let phi = self.level_set();
        Ok((self.segmentation.fit(&phi)?, parts_inside(&self.carried.space, &phi)))
    }
    /// The energy.
    pub fn segmentation(&self) -> &Segmentation<D> {
        &self.segmentation
    }
    /// The image at the nodes.
    pub fn image(&self) -> &[f64] {
        &self.nodal
    }
    /// The level set at the nodes.
    pub fn level_set(&self) -> Cow<'_, [f64]> {
        self.carried.level_set(&self.state.fields, 0)
    }
    /// Pseudo-time step.
    pub fn dt(&self) -> f64 {
        self.dt
    }
    /// The level set and its transport.
    pub fn carried(&self) -> &Carried<D> {
        &self.carried
    }
    /// The state; its velocity is zero.
    pub fn state(&self) -> &State<D> {
        &self.state
    }
    /// Processor seconds by [phase](PHASES) since the last call.
    pub fn take_costs(&mut self) -> [f64; PHASES.len()] {
        self.phases.take()
    }
    /// Estimated bytes of storage that grows with the mesh.
    pub fn bytes(&self) -> usize {
        self.segmentation.bytes() + self.carried.factor_bytes() + self.carried.field_bytes(1)
    }
    /// Bytes of the factors.
    pub fn factor_bytes(&self) -> usize {
        self.segmentation.bytes() + self.carried.factor_bytes()
    }
}
