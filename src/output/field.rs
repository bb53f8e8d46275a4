//! Fields as they are handed to the writers.

use crate::base::{Error, Result};
use crate::fem::{EDGES, Space};
use nalgebra::SVector;
use std::ops::{Add, Mul};

/// The values of a field, one a node of the space; on a P2 space also one a point of the mesh, for
/// a P1 field.
#[derive(Clone, Copy, Debug)]
pub enum FieldData<'a, const D: usize> {
    /// A number a node.
    Scalar(&'a [f64]),
    /// A vector a node.
    Vector(&'a [SVector<f64, D>]),
}

/// The values at the nodes of `space`, those of a P1 field interpolated.
pub(super) fn on_nodes<const D: usize, T>(space: &Space<D>, name: &str, f: &[T]) -> Result<Vec<T>>
where
    T: Copy + Add<Output = T> + Mul<f64, Output = T>,
{
    let points = space.mesh().points().len();
    if f.len() == space.len() {
        return Ok(f.to_vec());
    }
    if f.len() != points {
        return Err(Error::internal("a field to be written has the wrong length")
            .at(format!("field {name}"))
            .value(format!("{} values for {} nodes and {points} points", f.len(), space.len())));
    }
    let mut values = f.to_vec();
    values.resize(space.len(), f[0]);
    for c in 0..space.mesh().cell_count() {
        let nodes = space.cell_nodes(c);
        for (e, &node) in nodes[D + 1..].iter().enumerate() {
            let (i, j) = EDGES[e];
            values[node as usize] = (f[nodes[i] as usize] + f[nodes[j] as usize]) * 0.5;
        }
    }
    Ok(values)
}
