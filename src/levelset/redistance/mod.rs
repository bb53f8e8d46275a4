//! Redistancing: a level set becomes the signed distance to its interface again, times its slope at the start.
//!
//! Book, sections 1.5.1 to 1.5.3. Transport draws a level set out: its slope is the stretch of the interface. That is information where the
//! interface is elastic, and redistancing destroys it; where nobody asks for the slope it may be straightened, at the price of a
//! displacement of the interface, because the new P2 function interpolates the distance and has another zero set.

mod exact;
mod fast_marching;
mod hamilton_jacobi;
mod lattice;
mod volume;

use super::interface::{extents, pieces};
use crate::base::Result;
use crate::fem::{Numbering, Translation};
use crate::transport::Tracer;
use exact::Surface;

/// How a distance is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Redistance {
    /// By pseudo-time steps of the Hamilton-Jacobi equation (1.35) along its characteristics; straight up to about `iterations` times the
    /// distance of two nodes.
    HamiltonJacobi {
        /// Number of pseudo-time steps.
        iterations: usize,
    },
    /// By fast marching on the lattice of the nodes, from the exact distance in the cells of the interface; of first order elsewhere.
    FastMarching,
    /// The distance to the zero set of the P2 function at each node.
    Exact,
}

/// A way to redistance level sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Redistancing {
    /// How the distance is found.
    pub method: Redistance,
    /// Whether a constant is added so that the cut interface encloses what it did before.
    pub volume: bool,
}

impl Redistancing {
    /// Makes `phi`, a function of the space of `tracer`, `slope` times the signed distance to its zero set; `translations` are the pairs of
    /// facets on periodic sides, through which distances are measured too. A function of one sign is left as it is. Signs at the nodes
    /// stay, except with [`Redistance::HamiltonJacobi`] and the correction of the volume.
    ///
    /// # Errors
    /// A space that is not P2, a value that is not finite.
    pub fn apply<const D: usize>(
        &self,
        tracer: &Tracer<D>,
        translations: &[Translation<D>],
        slope: f64,
        phi: &mut Vec<f64>,
    ) -> Result<()> {
        let space = tracer.space();
        let pieces = pieces(space, phi)?;
        if pieces.cells.is_empty() {
            return Ok(());
        }
        let before = if self.volume { Some(extents(space, phi)?) } else { None };
        let unknowns = || Numbering::scalar_unknowns(space, translations);
        match self.method {
            Redistance::HamiltonJacobi { iterations } => {
                hamilton_jacobi::straighten(tracer, &unknowns(), slope, iterations, &pieces.cells, phi);
            }
            Redistance::FastMarching => {
                let surface = Surface::new(space, phi, pieces, translations);
                let distance = fast_marching::distances(&surface, &unknowns());
                give(slope, distance, phi);
            }
            Redistance::Exact => {
                let distance = Surface::new(space, phi, pieces, translations).distances();
                give(slope, distance, phi);
            }
        }
        match before {
            Some([enclosed, _]) => volume::restore(space, enclosed, slope, phi),
            None => Ok(()),
        }
    }
}

/// Gives `phi` the modulus `slope` times `distance`, and its own sign.
fn give(slope: f64, distance: Vec<f64>, phi: &mut [f64]) {
    for (v, d) in phi.iter_mut().zip(distance) {
        // A node that is inside stays so: 0 counts as outside.
        *v = if *v < 0.0 { -(slope * d).max(f64::MIN_POSITIVE) } else { slope * d };
    }
}

#[cfg(test)]
mod tests;
