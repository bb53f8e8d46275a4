//! Parallel loops whose result does not depend on the number of threads.
//!
//! Work is cut into chunks of a fixed size; every chunk writes only its own part of the output, and
//! sums over chunks are taken in the order of the chunks.

use rayon::prelude::*;

/// Items per chunk. Fixed, so that sums are grouped in the same way whatever the number of threads.
pub const CHUNK: usize = 256;

/// Calls `work(first_item, part)` on consecutive parts of `out`, `stride` entries an item, in
/// parallel.
pub fn fill<T: Send>(out: &mut [T], stride: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    out.par_chunks_mut(CHUNK * stride.max(1))
        .enumerate()
        .for_each(|(k, part)| work(k * CHUNK, part));
}

/// Number of partial sums. It does not grow with the number of terms, so that a sum allocates
/// nothing.
const PARTS: usize = 64;

/// Sum over `0..n` of `term`, as an array of `N` sums, bit-identical for any number of threads.
pub fn sum<const N: usize>(n: usize, term: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N] {
    let size = n.div_ceil(PARTS).max(CHUNK);
    let mut parts = [[0.0; N]; PARTS];
    parts[..n.div_ceil(size)].par_iter_mut().enumerate().for_each(|(k, s)| {
        for i in k * size..((k + 1) * size).min(n) {
            let t = term(i);
            for j in 0..N {
                s[j] += t[j];
            }
        }
    });
    let mut s = [0.0; N];
    for p in parts {
        for j in 0..N {
            s[j] += p[j];
        }
    }
    s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_do_not_depend_on_the_number_of_threads() {
        let term = |i: usize| [(i as f64).sin(), 1.0];
        let run = |n| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(n)
                .build()
                .unwrap()
                .install(|| sum(10_001, term))
        };
        assert_eq!(run(1), run(2));
        assert_eq!(run(1)[1], 10_001.0);
    }
}
