//! The flow at the start: given by expressions, or taken from an earlier run.

mod stored;

use super::Scene;
use super::site::{Site, vector};
use crate::base::{Error, Result, fnv1a};
use crate::fem::{Basis, Cells, Element, Interpolation, Rule, Space, integrate};
use crate::flow::{FlowState, solenoidal};
use crate::mesh::Mesh;
use crate::output::{FieldData, read_vtu, write_vtu};
use nalgebra::SVector;
use std::path::Path;
use std::sync::Arc;
use stored::Stored;

/// The flow at the start.
pub(super) struct InitialFlow<const D: usize> {
    /// The velocity that was given, at the nodes: it may miss boundary values and have a
    /// divergence.
    pub given: Vec<SVector<f64, D>>,
    /// What the flow starts with, before boundary values are set.
    pub flow: FlowState<D>,
    /// Time in the run that it was taken from.
    pub time: f64,
}

/// The flow at the start of a scene.
///
/// # Errors
/// A folder in `initial.from` that holds no run, or none of a flow of this dimension; a time that
/// is not stored; a mesh that covers more than that of the run.
pub(super) fn flow<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> Result<InitialFlow<D>> {
    match (&scene.initial, &scene.start) {
        (None, _) => {
            let u = vector(&scene.fluid.initial_velocity);
            let given = site.space.interpolate(|x| u(x, 0.0));
            let flow = FlowState { u: given.clone(), p: vec![0.0; pressures(scene, &site.mesh)] };
            Ok(InitialFlow { given, flow, time: 0.0 })
        }
        (Some(_), Some(file)) => InitialFlow::read(file, scene, site),
        (Some(initial), None) => taken(stored::read(scene, initial)?, scene, site),
    }
}

/// Number of unknowns of the pressure.
fn pressures<const D: usize>(scene: &Scene, mesh: &Mesh<D>) -> usize {
    let jumps = scene.numerics.pressure == Element::P1P0;
    mesh.points().len() + if jumps { mesh.cell_count() } else { 0 }
}

/// Brings a stored flow to the mesh of a scene: as it is if the mesh is the same, or else
/// interpolated and projected to velocities without divergence.
fn taken<const D: usize>(
    stored: Stored<D>,
    scene: &Scene,
    site: &Site<'_, D>,
) -> Result<InitialFlow<D>> {
    let Stored { space: old, u, mut p, time } = stored;
    if old.coincides(&site.space) {
        p.resize(pressures(scene, &site.mesh), 0.0);
        return Ok(InitialFlow { given: u.clone(), flow: FlowState { u, p }, time });
    }
    let places = Interpolation::within(old.mesh(), &site.space).map_err(|e| {
        let what = "the mesh of the scene covers more than that of the run it starts from";
        let remedy = "start from a run on a mesh that covers this one, or from \
            fluid.initial_velocity without [initial]";
        let e = Error::input(what).value(e.wrong_value()).remedy(remedy);
        scene.blame(&["initial", "from"], e)
    })?;
    let given: Vec<SVector<f64, D>> = places.apply(&old, &u);
    let mut p = places.apply(&Space::new(old.mesh(), Element::P1), &p);
    p.truncate(site.mesh.points().len());
    p.resize(pressures(scene, &site.mesh), 0.0);
    let numerics = &scene.numerics;
    let (conditions, solver) = (&site.conditions, numerics.solver());
    let u = solenoidal(&site.space, numerics.pressure, conditions, solver, &given)?;
    Ok(InitialFlow { given, flow: FlowState { u, p }, time })
}

/// Names of the fields of a start in its file.
const FIELDS: [&str; 3] = ["velocity", "interpolated velocity", "pressure"];

impl<const D: usize> InitialFlow<D> {
    /// Writes the start to a field file, so that the run can go on without the earlier one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, path: &Path, space: &Space<D>) -> Result<()> {
        let p = &self.flow.p[..space.mesh().points().len()];
        let [u, given, pressure] = FIELDS;
        let fields = [
            (u, FieldData::Vector(&self.flow.u)),
            (given, FieldData::Vector(&self.given)),
            (pressure, FieldData::Scalar(p)),
        ];
        write_vtu(path, space, self.time, &fields)
    }

    /// Reads what [`write`](Self::write) has written.
    fn read(path: &Path, scene: &Scene, site: &Site<'_, D>) -> Result<InitialFlow<D>> {
        let kept = read_vtu::<D>(path)?;
        if !kept.space.coincides(&site.space) {
            return Err(Error::input("the start of the run is on another mesh than the scene")
                .at(path.display().to_string())
                .value(format!("{} nodes", kept.space.len()))
                .remedy("put back the mesh that the run was started with"));
        }
        let [u, given, pressure] = FIELDS;
        let mut p = kept.scalar(pressure)?[..site.mesh.points().len()].to_vec();
        p.resize(pressures(scene, &site.mesh), 0.0);
        let flow = FlowState { u: kept.vector(u)?.to_vec(), p };
        Ok(InitialFlow { given: kept.vector(given)?.to_vec(), flow, time: kept.time })
    }

    /// Identifies the velocity.
    pub fn hash(&self) -> u64 {
        let numbers = self.flow.u.iter().flat_map(|u| u.iter().flat_map(|v| v.to_le_bytes()));
        fnv1a(&numbers.collect::<Vec<u8>>())
    }

    /// Where the start comes from, for the plan; `None` for expressions.
    pub fn in_words(&self, scene: &Scene, space: &Arc<Space<D>>) -> Option<String> {
        let from = scene.initial.as_ref()?.from.display();
        let basis = Basis::new(space, &Arc::new(Rule::simplex(D, 4)));
        let [change, all] = integrate(&basis, Cells::All, |at| {
            let [u, given] = [&self.flow.u, &self.given].map(|u| basis.value(at, u));
            [(u - given).norm_squared(), given.norm_squared()]
        });
        let how = match self.flow.u == self.given {
            true => "on the same mesh, as they are".to_string(),
            false => format!(
                "interpolated from another mesh; the velocity was then made free of divergence, \
                 which changed it by {:.1e} of its norm",
                (change / all).sqrt()
            ),
        };
        Some(format!("starts with velocity and pressure of {from} at t = {}: {how}", self.time))
    }
}
