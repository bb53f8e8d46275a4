//! Structures that consist of one closed interface with a force: membranes and drops.

use super::fields::{Carry, Data, Declaration, FieldId, Fields, InitialFunction, Rule};
use super::place::{Host, Moved, Place};
use super::{Coupling, Held, Medium, RestMap, Structure, SurfaceStrain};
use crate::base::{Result, Warning};
use crate::fem::{Basis, Space, SurfacePoint};
use crate::flow::Fluid;
use crate::flow::block::Block;
use crate::flow::term::MomentumTerm;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// A closed interface: the zero of a level set. It encloses a fluid and may have mass.
#[derive(Clone)]
pub struct ImmersedInterface<const D: usize> {
    /// Name in results.
    pub name: String,
    /// Level set at time 0 at the nodes, negative inside; its slope at the interface is the
    /// stretch, (3.11).
    pub phi: Vec<f64>,
    /// The function with these nodal values, if it is known between the nodes.
    pub function: Option<Arc<InitialFunction<D>>>,
    /// Stretch at time 0, constant over the interface.
    pub stretch: f64,
    /// Half-width of the band of force and fluid properties, a length.
    pub thickness: f64,
    /// The fluid inside; `None` for that outside.
    pub inside: Option<Fluid>,
    /// Mass per area at rest.
    pub surface_mass: f64,
    /// Coupling of the force with the step.
    pub coupling: Coupling,
    /// True if the level set is `phi0(Y)`, (2.5), instead of being transported.
    pub mapped: bool,
    /// Index of the level set among the fields, once declared.
    pub field: FieldId,
}

impl<const D: usize> ImmersedInterface<D> {
    /// An interface with stretch 1, no mass, the outer fluid inside, implicit coupling, and a band
    /// of half-width `thickness`.
    pub fn new(name: impl Into<String>, phi: Vec<f64>, thickness: f64) -> ImmersedInterface<D> {
        ImmersedInterface {
            name: name.into(),
            phi,
            function: None,
            stretch: 1.0,
            thickness,
            inside: None,
            surface_mass: 0.0,
            coupling: Coupling::default(),
            mapped: false,
            field: FieldId::default(),
        }
    }
    /// The same interface with this stretch at time 0.
    pub fn stretched(self, stretch: f64) -> ImmersedInterface<D> {
        ImmersedInterface { stretch, ..self }
    }
    /// The same interface with another coupling.
    pub fn coupled(self, coupling: Coupling) -> ImmersedInterface<D> {
        ImmersedInterface { coupling, ..self }
    }
    /// The same interface with a fluid of its own inside.
    pub fn filled(self, fluid: Fluid) -> ImmersedInterface<D> {
        ImmersedInterface { inside: Some(fluid), ..self }
    }
    /// The same interface with mass.
    pub fn heavy(self, surface_mass: f64) -> ImmersedInterface<D> {
        ImmersedInterface { surface_mass, ..self }
    }
    /// Index of the level set among the fields.
    pub fn level_set(&self) -> FieldId {
        self.field
    }
    /// Name of field `what` of this interface.
    pub fn field_name(&self, what: &str) -> String {
        format!("{}.{what}", self.name)
    }
    fn begin(&mut self, fields: &mut Declaration<'_, D>) {
        let carry = match (self.mapped, &self.function) {
            (true, Some(f)) => Carry::OfBackwardMap(f.clone()),
            (_, f) => Carry::Convected(f.clone()),
        };
        let rule = Rule { carry, acts: true, written: true };
        self.field =
            fields.add(&self.field_name("level_set"), rule, || Data::Scalar(self.phi.clone()));
    }
}

/// What a density that an interface carries is of, per length (in space: area).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Density {
    /// Of length (area) at rest: the inverse of the stretch.
    Rest,
    /// Of a dissolved substance: its concentration.
    Concentration,
}

/// The force of an interface; implementations differ by constitutive law.
pub trait InterfaceForce<const D: usize>: Clone + Send + Sync + 'static {
    /// Declares fields in addition to the level set, and builds data that depend on the mesh.
    ///
    /// # Errors
    /// A factor that does not fit into the memory.
    fn begin(
        &mut self,
        _of: &ImmersedInterface<D>,
        _host: &Host<'_, D>,
        _fields: &mut Declaration<'_, D>,
    ) -> Result<()> {
        Ok(())
    }
    /// The momentum term of the last [`prepare`](Self::prepare), if there is one.
    fn term(&self) -> Option<&dyn MomentumTerm<D>> {
        None
    }
    /// The block of unknowns of the last [`prepare`](Self::prepare), if there is one.
    fn block(&self) -> Option<&dyn Block<D>> {
        None
    }
    /// Precomputes the force.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn prepare(&mut self, of: &ImmersedInterface<D>, at: &Place<'_, D>) -> Result<()>;
    /// Updates the declared fields that are not convected.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn advance(
        &mut self,
        _of: &ImmersedInterface<D>,
        _by: &mut Moved<'_, D>,
        _fields: &mut Fields<D>,
    ) -> Result<()> {
        Ok(())
    }
    /// Elastic energy.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn energy(
        &mut self,
        of: &ImmersedInterface<D>,
        at: &Place<'_, D>,
        rule: &Basis<D>,
    ) -> Result<f64>;
    /// Dissipation rate of the model itself.
    fn dissipation(&self) -> f64 {
        0.0
    }
    /// Largest tension.
    fn tension(&self) -> f64;
    /// Tension where the interface is stretched by `stretch`, if it depends on nothing else.
    fn tension_at(&self, _stretch: f64) -> Option<f64> {
        None
    }
    /// Largest stable step of the explicit coupling.
    fn step_limit(&self, medium: &Medium) -> f64;
    /// Rejects couplings that are not implemented.
    ///
    /// # Errors
    /// A coupling that is not implemented.
    fn check_coupling(&self, _coupling: Coupling) -> Result<()> {
        Ok(())
    }
    /// Rejects steps of an order that is not implemented.
    ///
    /// # Errors
    /// An order that is not implemented.
    fn check_order(&self, _order: usize) -> Result<()> {
        Ok(())
    }
    /// What shows that its results are not to be trusted, with a remedy.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn distrust(
        &self,
        _of: &ImmersedInterface<D>,
        _space: &Space<D>,
        _fields: &Fields<D>,
    ) -> Result<Option<Warning>> {
        Ok(None)
    }
    /// Distance from the interface within which the force acts.
    fn reach(&self, of: &ImmersedInterface<D>) -> f64 {
        of.thickness
    }
    /// Position at rest of the material.
    fn rest_map(&self) -> Option<&RestMap<D>> {
        None
    }
    /// Strain, if it does not follow from the position at rest alone.
    fn strain(
        &self,
        _slope: &SVector<f64, D>,
        _gradient: &SMatrix<f64, D, D>,
    ) -> Option<SurfaceStrain<D>> {
        None
    }
    /// True if the force is the derivative of the energy, up to [`dissipation`](Self::dissipation).
    fn conserves_energy(&self) -> bool {
        true
    }
    /// True if the interface carries its strain, [`strain_at`](Self::strain_at).
    fn carries_strain(&self) -> bool {
        false
    }
    /// Strain at a point of the interface, if it is carried by the interface.
    fn strain_at(
        &self,
        _space: &Space<D>,
        _fields: &Fields<D>,
        _point: &SurfacePoint<D>,
    ) -> Option<SurfaceStrain<D>> {
        None
    }
    /// True if the force does not depend on the slope of the level set.
    fn keeps_distance(&self) -> bool {
        false
    }
    /// The density that the interface carries, and what it is a density of.
    fn surface_density(&self) -> Option<(FieldId, Density)> {
        None
    }
    /// True if the force needs the backward characteristics.
    fn resists_shear(&self) -> bool {
        false
    }
    /// Bytes of storage that grows with the mesh.
    fn bytes(&self) -> usize {
        0
    }
}

/// An interface with its force: a structure.
#[derive(Clone)]
pub struct Immersed<const D: usize, F> {
    /// The interface.
    pub interface: ImmersedInterface<D>,
    /// The force on it.
    pub force: F,
}

impl<const D: usize, F: InterfaceForce<D>> Immersed<D, F> {
    /// The structure of this interface and this force.
    pub fn boxed(interface: ImmersedInterface<D>, force: F) -> Box<dyn Structure<D>> {
        Box::new(Immersed { interface, force })
    }
}

impl<const D: usize, F: InterfaceForce<D>> Structure<D> for Immersed<D, F> {
    fn name(&self) -> &str {
        &self.interface.name
    }
    fn begin(&mut self, host: &Host<'_, D>, fields: &mut Declaration<'_, D>) -> Result<()> {
        self.interface.begin(fields);
        self.force.begin(&self.interface, host, fields)
    }
    fn level_set(&self) -> Option<FieldId> {
        Some(self.interface.field)
    }
    fn slope(&self) -> f64 {
        self.interface.stretch
    }
    fn keeps_distance(&self) -> bool {
        self.force.keeps_distance() && self.interface.surface_mass == 0.0
    }
    fn coupling(&self) -> Coupling {
        self.interface.coupling
    }
    fn check_coupling(&self, order: usize, lightest: f64) -> Result<()> {
        self.force.check_coupling(self.interface.coupling)?;
        self.force.check_order(order)?;
        self.interface.coupling.check(order, lightest)
    }
    fn prepare(&mut self, at: &Place<'_, D>) -> Result<()> {
        self.force.prepare(&self.interface, at)
    }
    fn terms<'a>(&'a self, out: &mut Vec<&'a dyn MomentumTerm<D>>) {
        out.extend(self.force.term());
    }
    fn blocks<'a>(&'a self, out: &mut Vec<&'a dyn Block<D>>) {
        out.extend(self.force.block());
    }
    fn advance(&mut self, by: &mut Moved<'_, D>, fields: &mut Fields<D>) -> Result<()> {
        self.force.advance(&self.interface, by, fields)
    }
    fn held(&self) -> Option<Held> {
        let ImmersedInterface { field, thickness, inside, surface_mass, .. } = self.interface;
        (inside.is_some() || surface_mass > 0.0).then_some(Held {
            level_set: field,
            thickness,
            fluid: inside,
            surface_mass,
        })
    }
    fn distrust(&self, space: &Space<D>, fields: &Fields<D>) -> Result<Option<Warning>> {
        self.force.distrust(&self.interface, space, fields)
    }
    fn reach(&self) -> f64 {
        self.force.reach(&self.interface)
    }
    fn energy(&mut self, at: &Place<'_, D>, rule: &Basis<D>) -> Result<f64> {
        self.force.energy(&self.interface, at, rule)
    }
    fn dissipation(&self) -> f64 {
        self.force.dissipation()
    }
    fn tension(&self) -> f64 {
        self.force.tension()
    }
    fn tension_at(&self, stretch: f64) -> Option<f64> {
        self.force.tension_at(stretch)
    }
    fn step_limit(&self, medium: &Medium) -> f64 {
        self.force.step_limit(medium)
    }
    fn rest_map(&self) -> Option<&RestMap<D>> {
        self.force.rest_map()
    }
    fn strain(&self, slope: &SVector<f64, D>, gradient: &SMatrix<f64, D, D>) -> SurfaceStrain<D> {
        self.force.strain(slope, gradient).unwrap_or_else(|| {
            SurfaceStrain::new(&slope.normalize(), &(SMatrix::identity() + gradient), self.slope())
        })
    }
    fn conserves_energy(&self) -> bool {
        self.force.conserves_energy()
    }
    fn carries_strain(&self) -> bool {
        self.force.carries_strain()
    }
    fn surface_density(&self) -> Option<(FieldId, Density)> {
        self.force.surface_density()
    }
    fn strain_at(
        &self,
        space: &Space<D>,
        fields: &Fields<D>,
        point: &SurfacePoint<D>,
    ) -> Option<SurfaceStrain<D>> {
        self.force.strain_at(space, fields, point)
    }
    fn resists_shear(&self) -> bool {
        self.force.resists_shear()
    }
    fn bytes(&self) -> usize {
        self.force.bytes()
    }
    fn boxed(&self) -> Box<dyn Structure<D>> {
        Box::new(self.clone())
    }
}
