//! Transfer of fields to another mesh of the same domain.

use crate::base::Result;
use crate::fem::{Interpolation, Projection, Space, Translation};
use crate::structure::{Data, Fields};
use nalgebra::SVector;
use std::sync::Arc;

/// Method of the transfer to a new mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// The values of the old fields at the new nodes; order 3 for P2, not conservative.
    Interpolation,
    /// The L2 projection over the intersections of old and new cells; conservative.
    Projection,
}

/// A [`Transfer`] from one space to another, prepared for any number of fields.
pub(super) enum Bring<'a> {
    Interpolation(&'a Space<2>, Interpolation),
    Projection(&'a Space<2>, Box<Projection>),
}

impl<'a> Bring<'a> {
    pub fn new(
        transfer: Transfer,
        from: &'a Space<2>,
        to: &Arc<Space<2>>,
        translations: &[Translation<2>],
    ) -> Result<Bring<'a>> {
        Ok(match transfer {
            Transfer::Interpolation => {
                Bring::Interpolation(from, Interpolation::new(from.mesh(), to)?)
            }
            Transfer::Projection => {
                Bring::Projection(from, Box::new(Projection::new(from.mesh(), to, translations)?))
            }
        })
    }
    /// A field with one number per node; an empty one stays empty.
    pub fn scalar(&self, f: &[f64]) -> Result<Vec<f64>> {
        match self {
            _ if f.is_empty() => Ok(Vec::new()),
            Bring::Interpolation(from, places) => Ok(places.apply(from, f)),
            Bring::Projection(from, projection) => projection.scalar(from, f),
        }
    }
    /// A field with one vector per node; an empty one stays empty.
    pub fn vector(&self, f: &[SVector<f64, 2>]) -> Result<Vec<SVector<f64, 2>>> {
        match self {
            _ if f.is_empty() => Ok(Vec::new()),
            Bring::Interpolation(from, places) => Ok(places.apply(from, f)),
            Bring::Projection(from, projection) => projection.vector(from, f),
        }
    }
}

impl Bring<'_> {
    /// All fields; those that are not nodal do not change.
    pub fn fields(&self, fields: &Fields<2>) -> Result<Fields<2>> {
        let mut brought = fields.clone();
        for field in brought.iter_mut() {
            match &mut field.data {
                Data::Scalar(values) => *values = self.scalar(values)?,
                Data::Vector(values) => *values = self.vector(values)?,
                Data::Points(_) | Data::Numbers(_) | Data::Labels(_) => {}
            }
        }
        Ok(brought)
    }
}
