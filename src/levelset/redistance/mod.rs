//! Redistancing: replaces a level set by the signed distance to its interface, times its slope at
//! time 0.
//!
//! Book, sections 1.5.1 to 1.5.3. Transport changes the slope of a level set, which is the stretch
//! of the interface. For an elastic interface this is needed, and redistancing destroys it. For
//! other interfaces the slope may be restored; this displaces the interface slightly, because the
//! new P2 function interpolates the distance and has another zero set.

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

/// Method that computes the distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Redistance {
    /// Pseudo-time steps of the Hamilton-Jacobi equation (1.35) along its characteristics; a
    /// distance up to about `iterations` times the spacing of the nodes.
    HamiltonJacobi {
        /// Number of pseudo-time steps.
        iterations: usize,
    },
    /// Fast marching on the lattice of the nodes, from the exact distance in the cells of the
    /// interface; first order elsewhere, (1.37).
    FastMarching,
    /// The exact distance to the zero set of the P2 function at each node, (1.37).
    Exact,
}

/// Redistancing of level sets: method and correction of the volume.
///
/// # Examples
/// ```
/// use immersa::fem::{Element, Space};
/// use immersa::levelset::{Redistance, Redistancing};
/// use immersa::mesh::{Diagonals, rectangle};
/// use immersa::transport::Tracer;
/// use std::sync::Arc;
///
/// let mesh = Arc::new(rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], Diagonals::Right)?);
/// let space = Arc::new(Space::new(&mesh, Element::P2));
/// let mut phi = space.interpolate(|x| 3.0 * (x[0] - 0.3)); // slope 3
/// let exact = Redistancing { method: Redistance::Exact, volume: false };
/// exact.apply(&Tracer::new(&space, &[]), &[], 1.0, &mut phi)?;
/// for (value, x) in phi.iter().zip(space.nodes()) {
///     assert!((value - (x[0] - 0.3)).abs() < 1e-12);
/// }
/// # Ok::<(), immersa::base::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Redistancing {
    /// Method that computes the distance.
    pub method: Redistance,
    /// True to add a constant such that the cut interface encloses the same area or volume as
    /// before.
    pub volume: bool,
}

impl Redistancing {
    /// Replaces `phi`, a function of the space of `tracer`, by `slope` times the signed distance to
    /// its zero set; `translations` are the pairs of facets on periodic sides, through which
    /// distances are measured too. A function of one sign does not change. Signs at the nodes are
    /// kept, except with [`Redistance::HamiltonJacobi`] and the correction of the volume.
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
                hamilton_jacobi::straighten(
                    tracer,
                    &unknowns(),
                    slope,
                    iterations,
                    &pieces.cells,
                    phi,
                );
            }
            Redistance::FastMarching => {
                let surface = Surface::new(space, phi, pieces, translations);
                let distance = fast_marching::distances(&surface, &unknowns());
                set_modulus(slope, distance, phi);
            }
            Redistance::Exact => {
                let distance = Surface::new(space, phi, pieces, translations).distances();
                set_modulus(slope, distance, phi);
            }
        }
        match before {
            Some([enclosed, _]) => volume::restore(space, enclosed, slope, phi),
            None => Ok(()),
        }
    }
}

/// Sets the modulus of `phi` to `slope` times `distance`, and keeps its sign.
fn set_modulus(slope: f64, distance: Vec<f64>, phi: &mut [f64]) {
    for (v, d) in phi.iter_mut().zip(distance) {
        // A node that is inside stays inside: 0 counts as outside.
        *v = if *v < 0.0 { -(slope * d).max(f64::MIN_POSITIVE) } else { slope * d };
    }
}

#[cfg(test)]
mod tests;
