//! Structures immersed in a flow: the interface between constitutive laws and the simulation.
//!
//! A [`Structure`] declares its fields, prepares for a step, gives momentum terms and blocks,
//! updates fields that are not convected, and gives energy, dissipation, step limit and enclosed
//! fluid. The simulation depends on no law, and a law on no simulation.

mod carrier;
mod coupling;
mod fields;
mod interface;
mod level_set;
mod markers;
mod medium;
mod place;
mod surface_strain;

pub use carrier::{Carrier, REMAP};
pub use coupling::Coupling;
pub use fields::{
    Carry, DISPLACEMENT, Data, Declaration, Field, FieldId, Fields, InitialFunction, Rule,
};
pub use interface::{Density, Immersed, ImmersedInterface, InterfaceForce};
pub use level_set::LevelSet;
pub use markers::{follow_markers, polygon_area, polygon_length};
pub use medium::Medium;
pub use place::{Host, Moved, Place, Velocity};
pub use surface_strain::{LagrangianInvariants, SurfaceStrain, area_change_by_level_set};

use crate::base::{Result, Warning, parallel};
use crate::fem::{Basis, Space, SurfacePoint};
use crate::flow::Fluid;
use crate::flow::block::Block;
use crate::flow::term::MomentumTerm;
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};

/// Position at rest of the material at a point at time 0: `Y` at time 0.
pub type RestMap<const D: usize> = dyn Fn(&Point<D>) -> Point<D> + Send + Sync;

/// `map(x + d(x)) - x` at the nodes `x`, for the displacement `d` back to time 0.
pub fn rest_displacement<const D: usize>(
    map: &RestMap<D>,
    nodes: &[SVector<f64, D>],
    displacement: &[SVector<f64, D>],
) -> Vec<SVector<f64, D>> {
    let mut rest = vec![SVector::zeros(); nodes.len()];
    parallel::fill(&mut rest, 1, |first, part| {
        for (i, v) in part.iter_mut().enumerate() {
            let x = &nodes[first + i];
            *v = map(&(x + displacement[first + i])) - x;
        }
    });
    rest
}

/// Fluid inside a level set, and mass of its interface, by (3.19).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// Level set, negative inside.
    pub level_set: FieldId,
    /// Half-width of the band over which properties change, a length.
    pub thickness: f64,
    /// The fluid inside; `None` for that outside.
    pub fluid: Option<Fluid>,
    /// Mass per area at rest of the interface.
    pub surface_mass: f64,
}

/// A structure in a flow: one body, or many of the same kind.
///
/// # Examples
/// ```
/// use immersa::elastic::{AreaLaw, Membrane};
/// use immersa::fem::{Element, Space};
/// use immersa::mesh::{Diagonals, Point, rectangle};
/// use immersa::sim::{Fluid, Simulation, SimulationSettings};
/// use immersa::structure::{Immersed, ImmersedInterface};
/// use std::sync::Arc;
///
/// // A flat membrane that is not stretched exerts no force: the fluid stays at rest.
/// let mesh = Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [6, 6], Diagonals::UnionJack)?);
/// let phi = Space::new(&mesh, Element::P2).interpolate(|x| x[0] - 0.5);
/// let law = AreaLaw::Linear { modulus: 1.0 };
/// let interface = ImmersedInterface::new("sheet", phi, 0.3);
/// let sheet = Immersed::boxed(interface, Membrane::new(law, 0.3));
/// let settings = SimulationSettings::new(0.1, Fluid { density: 1.0, viscosity: 0.1 }, vec![]);
/// let mut sim = Simulation::new(&mesh, settings, vec![sheet], |_| Point::<2>::zeros())?;
/// sim.step()?;
/// assert_eq!(sim.structures()[0].name(), "sheet");
/// assert!(sim.largest_speed() < 1e-12);
/// # Ok::<(), immersa::base::Error>(())
/// ```
pub trait Structure<const D: usize>: Send + Sync {
    /// Name in results; unique in a simulation.
    fn name(&self) -> &str;
    /// Declares the fields of this structure, and builds data that depend on the mesh. Called once
    /// per mesh.
    ///
    /// # Errors
    /// A factor that does not fit into the memory.
    fn begin(&mut self, host: &Host<'_, D>, fields: &mut Declaration<'_, D>) -> Result<()>;
    /// Level set whose zero is the interface, if there is one.
    fn level_set(&self) -> Option<FieldId> {
        None
    }
    /// Slope of the level set at time 0, which redistancing restores.
    fn slope(&self) -> f64 {
        1.0
    }
    /// True if the slope of its level set has no meaning, so that redistancing may restore it.
    fn keeps_distance(&self) -> bool {
        false
    }
    /// True if it exerts a force or encloses a fluid; false if it is passive.
    fn acts(&self) -> bool {
        true
    }
    /// Coupling of its force with the step.
    fn coupling(&self) -> Coupling {
        Coupling::Explicit
    }
    /// Checks that its coupling is possible in steps of order `order` with least density
    /// `lightest`.
    ///
    /// # Errors
    /// A coupling that is not.
    fn check_coupling(&self, order: usize, lightest: f64) -> Result<()> {
        self.coupling().check(order, lightest)
    }
    /// Precomputes forces and forms for the fields of `at`.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn prepare(&mut self, _at: &Place<'_, D>) -> Result<()> {
        Ok(())
    }
    /// Appends the terms prepared last.
    fn terms<'a>(&'a self, _out: &mut Vec<&'a dyn MomentumTerm<D>>) {}
    /// Appends the blocks of unknowns prepared last.
    fn blocks<'a>(&'a self, _out: &mut Vec<&'a dyn Block<D>>) {}
    /// Updates the fields of this structure that are not convected, after the transport of the
    /// others: `by.before` holds all fields at the start of the step.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn advance(&mut self, _by: &mut Moved<'_, D>, _fields: &mut Fields<D>) -> Result<()> {
        Ok(())
    }
    /// Enclosed fluid and mass of the interface; `None` without either.
    fn held(&self) -> Option<Held> {
        None
    }
    /// What shows that its results are not to be trusted, with a remedy; a sentence each, without a
    /// full stop.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn distrust(&self, _space: &Space<D>, _fields: &Fields<D>) -> Result<Option<Warning>> {
        Ok(None)
    }
    /// Distance from the interface within which the force acts.
    fn reach(&self) -> f64 {
        0.0
    }
    /// Elastic energy for the fields of `at`; `rule` may be finer than that of the flow.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn energy(&mut self, _at: &Place<'_, D>, _rule: &Basis<D>) -> Result<f64> {
        Ok(0.0)
    }
    /// Dissipation rate of the model itself, in addition to the viscosity of the flow.
    fn dissipation(&self) -> f64 {
        0.0
    }
    /// Largest tension of the prepared fields, which drives its elastic waves; 0 or less without
    /// any.
    fn tension(&self) -> f64 {
        0.0
    }
    /// Tension where the interface is stretched by `stretch` (the inverse of a density that it
    /// carries), if it depends on nothing else.
    fn tension_at(&self, _stretch: f64) -> Option<f64> {
        None
    }
    /// Largest stable step of the explicit coupling in this medium, (1.54), for the prepared
    /// fields; infinite if there is no limit.
    fn step_limit(&self, _medium: &Medium) -> f64 {
        f64::INFINITY
    }
    /// Position at rest of the material at time 0; `None` for the identity.
    fn rest_map(&self) -> Option<&RestMap<D>> {
        None
    }
    /// Strain of the interface for the gradient `slope` of the level set and the gradient
    /// `gradient` of the displacement `Y(x) - x` to the position at rest.
    fn strain(&self, slope: &SVector<f64, D>, gradient: &SMatrix<f64, D, D>) -> SurfaceStrain<D> {
        SurfaceStrain::new(&slope.normalize(), &(SMatrix::identity() + gradient), self.slope())
    }
    /// True if its force is the derivative of its energy, up to a dissipation that it tells.
    fn conserves_energy(&self) -> bool {
        false
    }
    /// True if its interface carries its strain, [`strain_at`](Self::strain_at).
    fn carries_strain(&self) -> bool {
        false
    }
    /// The density that its interface carries, and what it is a density of.
    fn surface_density(&self) -> Option<(FieldId, Density)> {
        None
    }
    /// Strain at a point of its interface, if the interface carries it; otherwise it follows from
    /// the backward characteristics by [`strain`](Self::strain).
    fn strain_at(
        &self,
        _space: &Space<D>,
        _fields: &Fields<D>,
        _point: &SurfacePoint<D>,
    ) -> Option<SurfaceStrain<D>> {
        None
    }
    /// True if its force needs the backward characteristics.
    fn resists_shear(&self) -> bool {
        false
    }
    /// Bytes of storage that grows with the mesh, without fields.
    fn bytes(&self) -> usize {
        0
    }
    /// A copy for another mesh; [`begin`](Self::begin) prepares it there.
    fn boxed(&self) -> Box<dyn Structure<D>>;
}
