//! Storage of a factor in single precision.

use super::SymmetricMatrix;

/// A factor in single precision of the matrix `S A S`. The diagonal `S` of powers of two keeps all
/// numbers within the range of single precision in any units.
#[derive(Default)]
pub(super) struct Single {
    /// The factor.
    pub factor: Vec<f32>,
    /// The upper triangle of `S A S`.
    pub matrix: Vec<f32>,
    /// The diagonal of `S`.
    scale: Vec<f64>,
}

impl Single {
    /// Bytes in addition to the factor.
    pub fn extra_bytes(order: usize, entries: usize) -> usize {
        4 * entries + 8 * order
    }

    /// Copies the values of a matrix, scaled.
    pub fn take(&mut self, matrix: &SymmetricMatrix) {
        self.scale = scales(matrix);
        let mut entry = 0;
        for j in 0..matrix.order() {
            let (rows, values) = matrix.column(j);
            for (&i, v) in rows.iter().zip(values) {
                self.matrix[entry] = (v * self.scale[i] * self.scale[j]) as f32;
                entry += 1;
            }
        }
    }

    /// The diagonal of `S`.
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }
}

/// The diagonal `S` for a matrix: `S_j` is near `1/sqrt |a_jj|`, and where the diagonal is zero, or
/// small beside the entries above it (a pressure), near the reciprocal of the largest
/// `S_i |a_ij|`.
pub(super) fn scales(matrix: &SymmetricMatrix) -> Vec<f64> {
    let mut scale = Vec::with_capacity(matrix.order());
    for j in 0..matrix.order() {
        let (rows, values) = matrix.column(j);
        let above = rows.iter().zip(values).filter(|(i, _)| **i < j);
        let largest = above.map(|(&i, v)| scale[i] * v.abs()).fold(0.0, f64::max);
        let diagonal = values.last().map_or(0.0, |d| d.abs()).sqrt();
        scale.push(power_of_two_near(1.0 / diagonal.max(largest)));
    }
    scale
}

/// Nearest power of two; 1 if there is none.
fn power_of_two_near(v: f64) -> f64 {
    let power = v.log2().round().exp2();
    if power.is_normal() { power } else { 1.0 }
}
