//! Nested dissection by METIS, the only foreign library that is called directly.

use std::ffi::c_int;
use std::ptr;
use std::sync::{Mutex, PoisonError};

use crate::base::{Error, Result};

/// METIS has one generator of random numbers for the whole process, seeded in every call:
/// simultaneous calls would not be reproducible.
static ONE_CALL_AT_A_TIME: Mutex<()> = Mutex::new(());

const SEED: i32 = 1;

/// An undirected graph without loops: vertex `v` has the neighbours
/// `neighbours[starts[v]..starts[v + 1]]`.
pub(super) struct Graph {
    pub starts: Vec<i32>,
    pub neighbours: Vec<i32>,
    /// One positive weight per vertex.
    pub weights: Vec<i32>,
}

impl Graph {
    /// A fill-reducing order of the vertices: entry `k` is the vertex that is eliminated `k`-th.
    ///
    /// G. Karypis and V. Kumar, *A fast and high quality multilevel scheme for partitioning
    /// irregular graphs*, 1998.
    ///
    /// # Errors
    /// Computation, if METIS fails (only for lack of memory).
    pub fn nested_dissection(&mut self) -> Result<Vec<usize>> {
        let count = self.weights.len();
        if self.neighbours.is_empty() {
            return Ok((0..count).collect());
        }
        let mut vertices = size(count)?;
        let mut order = vec![0; count];
        let mut position = vec![0; count];
        let _guard = ONE_CALL_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let status = self.call(&mut vertices, &mut order, &mut position);
        if status != metis_sys::rstatus_et_METIS_OK {
            return Err(Error::computation("METIS could not order the unknowns of a matrix")
                .at(format!("a graph of {count} vertices and {} edges", self.neighbours.len() / 2))
                .value(format!("METIS status {status}"))
                .remedy("use a coarser mesh or a machine with more memory"));
        }
        Ok(order.into_iter().map(|vertex: i32| vertex as usize).collect())
    }

    #[allow(
        unsafe_code,
        reason = "METIS is a C library; its safe wrapper has no nested dissection"
    )]
    fn call(&mut self, vertices: &mut i32, order: &mut [i32], position: &mut [i32]) -> c_int {
        let mut options = [0; metis_sys::METIS_NOPTIONS as usize];
        // SAFETY: `options` has METIS_NOPTIONS entries. The graph is one of `vertices` vertices in
        // the form that METIS documents (checked in the tests of `ordering`); all arrays live,
        // exclusively borrowed, until the call returns.
        unsafe {
            metis_sys::METIS_SetDefaultOptions(options.as_mut_ptr());
            options[metis_sys::moptions_et_METIS_OPTION_SEED as usize] = SEED;
            metis_sys::METIS_NodeND(
                ptr::from_mut(vertices),
                self.starts.as_mut_ptr(),
                self.neighbours.as_mut_ptr(),
                self.weights.as_mut_ptr(),
                options.as_mut_ptr(),
                order.as_mut_ptr(),
                position.as_mut_ptr(),
            )
        }
    }
}

/// A size as an integer of METIS, 32 bits.
///
/// # Errors
/// Computation, if it does not fit.
pub(super) fn size(count: usize) -> Result<i32> {
    i32::try_from(count).map_err(|_| {
        Error::computation("a matrix is too large for its unknowns to be ordered")
            .value(format!("{count} is more than METIS can count, {}", i32::MAX))
            .remedy("use a coarser mesh")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_do_not_fit_are_refused() {
        assert_eq!(size(7).unwrap(), 7);
        assert!(size(1 << 31).unwrap_err().to_string().contains("2147483648"));
    }
}
