//! A symmetric matrix and a part beside it that need not be symmetric.

use super::SymmetricMatrix;
use crate::base::Result;

/// A part of an operator that is kept beside a [`SymmetricMatrix`] and need not be symmetric. It
/// couples only unknowns that the pattern of the matrix couples.
pub trait Addition {
    /// `y += N x`.
    fn add_product(&mut self, x: &[f64], y: &mut [f64]);
    /// Adds the upper triangles of `(N + N^T)/2` and `(N - N^T)/2` to two matrices of the pattern.
    ///
    /// # Errors
    /// An entry outside the pattern.
    fn add_halves(&self, symmetric: &mut SymmetricMatrix, skew: &mut SymmetricMatrix)
    -> Result<()>;
}

/// `A = M + N` with the symmetric `M`; `N` may be absent.
pub struct Operator<'a> {
    /// `M`.
    pub matrix: &'a SymmetricMatrix,
    /// `N`.
    pub addition: Option<&'a mut dyn Addition>,
}

impl<'a> From<&'a SymmetricMatrix> for Operator<'a> {
    fn from(matrix: &'a SymmetricMatrix) -> Operator<'a> {
        Operator { matrix, addition: None }
    }
}

impl Operator<'_> {
    /// `y = A x`.
    pub fn multiply(&mut self, x: &[f64], y: &mut [f64]) {
        self.matrix.multiply(x, y);
        if let Some(n) = &mut self.addition {
            n.add_product(x, y);
        }
    }
}
