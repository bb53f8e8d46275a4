//! Measures the bandwidth of the memory.

use cpu_time::ThreadTime;
use std::hint::black_box;

/// Bytes copied per pass: larger than the caches.
const BLOCK: usize = 64 << 20;
const REPETITIONS: usize = 4;

/// Returns the bytes read and written per second when one thread copies a block of 64 MiB: the best
/// of four passes. The time is processor time, as for the phases of a step.
pub fn copy_bandwidth() -> f64 {
    let from = vec![1.0_f64; BLOCK / 8];
    let mut to = vec![0.0_f64; BLOCK / 8];
    let copy = |_| {
        let start = ThreadTime::now();
        to.copy_from_slice(black_box(&from));
        black_box(&mut to);
        start.elapsed().as_secs_f64()
    };
    // The first one finds the pages; it is never the best.
    2.0 * BLOCK as f64 / (0..=REPETITIONS).map(copy).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    #[test]
    fn memory_is_faster_than_a_disc_and_slower_than_the_registers() {
        let found = super::copy_bandwidth();
        assert!(found > 1e8 && found < 1e13, "{found:e}");
    }
}
