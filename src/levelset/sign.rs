//! Cells with a change of sign of a P2 level set.

use crate::base::{Error, Result};
use crate::fem::{Element, Space};
use rayon::prelude::*;

/// The cells at whose nodes `phi` has both signs, in their order; 0 counts as positive.
///
/// # Errors
/// A space that is not P2, a value of `phi` that is not finite.
pub(super) fn cut_cells<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Vec<usize>> {
    if space.element() != Element::P2 || phi.len() != space.len() {
        return Err(Error::internal("a contour needs a P2 function").value(format!(
            "{:?} with {} values for {} nodes",
            space.element(),
            phi.len(),
            space.len()
        )));
    }
    if let Some(i) = phi.iter().position(|v| !v.is_finite()) {
        return Err(Error::computation("the level set has a value that is not finite")
            .at(format!("node {i} at {:?}", space.nodes()[i].as_slice()))
            .value(phi[i])
            .remedy("the computation has blown up: reduce the time step"));
    }
    Ok((0..space.mesh().cell_count())
        .into_par_iter()
        .with_min_len(1024)
        .filter(|&c| {
            let nodes = space.cell_nodes(c);
            let negative = phi[nodes[0] as usize] < 0.0;
            nodes.iter().any(|&n| (phi[n as usize] < 0.0) != negative)
        })
        .collect())
}

/// The slope `|grad phi|` at the centres of the cells that the interface may cut.
///
/// # Errors
/// A space that is not P2, a value of `phi` that is not finite.
pub fn slopes<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Vec<f64>> {
    let mut centre = [0.0; 4];
    centre[..=D].fill(1.0 / (D + 1) as f64);
    let slope = |c: usize| space.gradient(phi, c, &centre).norm();
    Ok(cut_cells(space, phi)?.into_iter().map(slope).collect())
}
