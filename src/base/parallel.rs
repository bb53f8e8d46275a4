//! Parallel loops whose result does not depend on the number of threads.
//!
//! Work is cut into chunks of a fixed size; every chunk writes only its own part of the output, and sums over chunks
//! are taken in the order of the chunks.

use rayon::prelude::*;

/// Items per chunk. Fixed, so that sums are grouped in the same way whatever the number of threads.
pub const CHUNK: usize = 256;

/// Calls `work(first_item, part)` on consecutive parts of `out`, `stride` entries an item, in parallel.
pub fn fill<T: Send>(out: &mut [T], stride: usize, work: impl Fn(usize, &mut [T]) + Sync) {
    out.par_chunks_mut(CHUNK * stride.max(1)).enumerate().for_each(|(k, part)| work(k * CHUNK, part));
}

/// Sum over `0..n` of `term`, as an array of `N` sums, bit-identical for any number of threads.
pub fn sum<const N: usize>(n: usize, term: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N] {
    let parts: Vec<[f64; N]> = (0..n.div_ceil(CHUNK))
        .into_par_iter()
        .map(|k| {
            let mut s = [0.0; N];
            for i in k * CHUNK..((k + 1) * CHUNK).min(n) {
                let t = term(i);
                for j in 0..N {
                    s[j] += t[j];
                }
            }
            s
        })
        .collect();
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
        let run = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(|| sum(10_001, term));
        assert_eq!(run(1), run(2));
        assert_eq!(run(1)[1], 10_001.0);
    }
}
