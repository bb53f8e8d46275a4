//! A passive level set.

use super::Structure;
use super::fields::{Carry, Data, Declaration, FieldId, Fields, InitialFunction, Rule};
use super::markers::follow_markers;
use super::place::{Host, Moved, Velocity};
use crate::base::{Result, parallel};
use crate::mesh::Point;
use crate::transport::path;
use std::sync::Arc;

/// A passive level set, optionally with markers on its interface.
#[derive(Clone)]
pub struct LevelSet<const D: usize> {
    /// Name in results.
    pub name: String,
    /// Values at the nodes at time 0, negative inside.
    pub phi: Vec<f64>,
    /// The function with these nodal values, if it is known between the nodes.
    pub function: Option<Arc<InitialFunction<D>>>,
    /// Particles on the interface at time 0, in the order of a closed polygon; may be none.
    pub markers: Vec<Point<D>>,
    field: FieldId,
}

impl<const D: usize> LevelSet<D> {
    /// A level set of these nodal values.
    pub fn new(name: impl Into<String>, phi: Vec<f64>) -> LevelSet<D> {
        LevelSet {
            name: name.into(),
            phi,
            function: None,
            markers: Vec::new(),
            field: FieldId::default(),
        }
    }
    /// Sets the function with these nodal values.
    pub fn with_function(self, function: Arc<InitialFunction<D>>) -> LevelSet<D> {
        LevelSet { function: Some(function), ..self }
    }
    /// Adds markers on the interface.
    pub fn with_markers(self, markers: Vec<Point<D>>) -> LevelSet<D> {
        LevelSet { markers, ..self }
    }
    /// Name of the field of its markers.
    pub fn markers_field(name: &str) -> String {
        format!("{name}.markers")
    }
}

impl<const D: usize> Structure<D> for LevelSet<D> {
    fn name(&self) -> &str {
        &self.name
    }
    fn begin(&mut self, _: &Host<'_, D>, fields: &mut Declaration<'_, D>) -> Result<()> {
        let rule =
            Rule { carry: Carry::Convected(self.function.clone()), acts: false, written: true };
        let name = format!("{}.level_set", self.name);
        self.field = fields.add(&name, rule, || Data::Scalar(self.phi.clone()));
        if !self.markers.is_empty() {
            let rule = Rule { carry: Carry::ByOwner, acts: false, written: false };
            let name = LevelSet::<D>::markers_field(&self.name);
            fields.add(&name, rule, || Data::Points(self.markers.clone()));
        }
        Ok(())
    }
    fn level_set(&self) -> Option<FieldId> {
        Some(self.field)
    }
    fn acts(&self) -> bool {
        false
    }
    fn advance(&mut self, by: &mut Moved<'_, D>, fields: &mut Fields<D>) -> Result<()> {
        let Some(id) = fields.find(&LevelSet::<D>::markers_field(&self.name)) else {
            return Ok(());
        };
        let (list, dt) = (fields.vector_mut(id), by.dt);
        match by.velocity {
            Velocity::Computed { ends, mean } => {
                let tracer = &by.carrier.tracer;
                let steps = (tracer.courant(mean, dt).ceil() as usize).clamp(1, 100);
                follow_markers(list, tracer, ends, dt, steps);
            }
            Velocity::Given { velocity, start, courant } => {
                let steps = ((0.5 * courant).ceil() as usize).clamp(1, 100);
                parallel::fill(list, 1, |_, part| {
                    part.iter_mut().for_each(|x| *x = path(velocity, *x, start, dt, steps));
                });
            }
        }
        Ok(())
    }
    fn boxed(&self) -> Box<dyn Structure<D>> {
        Box::new(self.clone())
    }
}
