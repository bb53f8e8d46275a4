//! A preconditioner for saddle points whose factor does not fit: scalar factors of the components,
//! and an approximate Schur complement from operators on the multipliers.

use super::{CONSTRAINED, Factor, Ordering, Precision, SymmetricMatrix};
use crate::base::Result;

/// Structure of a saddle point `[A, B^T; B, -C]`, in addition to its entries.
#[derive(Clone, Debug)]
pub struct Saddle {
    /// Component of every unknown before the multipliers, counted from 0.
    pub components: Vec<u8>,
    /// Positive definite operators on the multipliers; the sum of their inverses approximates the
    /// inverse of `B A^-1 B^T`.
    pub operators: Vec<SymmetricMatrix>,
}

/// The block-triangular preconditioner `z_p = -(sum_k O_k^-1) r_p`,
/// `z_i = A_ii^-1 (r_i - sum_{j < i} A_ij z_j - B_i^T z_p)` for the components `i` in turn.
///
/// Each `A_ii` is a scalar operator with a factor of its own in single precision, which suffices
/// for a preconditioner and halves the memory. The sweep over the components (Gauss-Seidel)
/// includes their coupling: viscous stress, grad-div, implicit forces. For the flow the operators
/// `O_k` are those of J. Cahouet and J.-P. Chabard, *Some fast 3D finite element solvers for the
/// generalized Stokes problem*, 1988, with the grad-div weight added to the viscosity: with
/// `A = r + (2 mu + gamma) k^2` on gradients of wave number `k`, the Schur complement is `k^2/A`,
/// and its inverse `(2 mu + gamma) + r/k^2`.
pub(super) struct Schur {
    blocks: Vec<Block>,
    operators: Vec<SymmetricMatrix>,
    factors: Vec<Factor>,
    first_multiplier: usize,
    entries_of_matrix: usize,
    /// Working space: the result, a product, the part of a block, the part of the multipliers.
    z: Vec<f64>,
    product: Vec<f64>,
    part: Vec<f64>,
    sum: Vec<f64>,
    valid: bool,
}

/// One component.
struct Block {
    /// Its unknowns, ascending.
    unknowns: Vec<u32>,
    /// For every unknown of the whole its number in the block, or [`CONSTRAINED`].
    numbers: Vec<u32>,
    matrix: SymmetricMatrix,
    factor: Factor,
}

impl Schur {
    /// Symbolic factorisation of all factors; allocates no memory for their values.
    ///
    /// # Errors
    /// As [`Ordering::plain`].
    pub fn plan(matrix: &SymmetricMatrix, saddle: Saddle) -> Result<Schur> {
        let Saddle { components, operators } = saddle;
        let mut blocks: Vec<Block> = Vec::new();
        let mut ordering = None;
        let count = components.iter().max().map_or(0, |last| last + 1);
        for component in 0..count {
            let (mut numbers, mut unknowns) = (vec![CONSTRAINED; matrix.order()], Vec::new());
            for (i, _) in components.iter().enumerate().filter(|(_, c)| **c == component) {
                numbers[i] = unknowns.len() as u32;
                unknowns.push(i as u32);
            }
            let part = matrix.principal(&numbers)?;
            // Components that are fixed at the same nodes have the same pattern.
            let same = blocks.last().is_some_and(|b| b.matrix.same_pattern(&part));
            let order = match ordering.take() {
                Some(order) if same => order,
                _ => Ordering::plain(&part)?,
            };
            ordering = Some(order.clone());
            let factor = Factor::plan(&part, order)?.with_precision(Precision::Single);
            blocks.push(Block { unknowns, numbers, matrix: part, factor });
        }
        let plan = |m| Ok(Factor::plan(m, Ordering::plain(m)?)?.with_precision(Precision::Single));
        let factors = operators.iter().map(plan).collect::<Result<Vec<_>>>()?;
        let largest = blocks.iter().map(|b| b.unknowns.len()).max().unwrap_or(0);
        let multipliers = matrix.order() - components.len();
        Ok(Schur {
            blocks,
            operators,
            factors,
            first_multiplier: components.len(),
            entries_of_matrix: matrix.nonzeros(),
            z: vec![0.0; matrix.order()],
            product: vec![0.0; matrix.order()],
            part: vec![0.0; largest.max(multipliers)],
            sum: vec![0.0; multipliers],
            valid: false,
        })
    }

    /// The operators on the multipliers; the next [`refactor`](Self::refactor) uses their values.
    pub fn operators_mut(&mut self) -> &mut [SymmetricMatrix] {
        &mut self.operators
    }

    /// Factors the components of a matrix and the operators.
    ///
    /// # Errors
    /// As [`Factor::refactor`].
    pub fn refactor(&mut self, matrix: &SymmetricMatrix) -> Result<()> {
        self.valid = false;
        for block in &mut self.blocks {
            block.matrix.take_principal(matrix, &block.numbers);
            block.factor.refactor(&block.matrix)?;
        }
        self.factors.iter_mut().zip(&self.operators).try_for_each(|(f, m)| f.refactor(m))?;
        self.valid = true;
        Ok(())
    }

    /// True if the factors have values.
    pub fn is_valid(&self) -> bool {
        self.valid
    }

    /// Replaces `r` by the preconditioner times `r`.
    pub fn apply(&mut self, matrix: &SymmetricMatrix, r: &mut [f64]) {
        let Schur { blocks, factors, z, product, part, sum, first_multiplier, .. } = self;
        z.fill(0.0);
        sum.fill(0.0);
        for factor in factors {
            let part = &mut part[..sum.len()];
            part.copy_from_slice(&r[*first_multiplier..]);
            factor.substitute(part);
            sum.iter_mut().zip(part).for_each(|(sum, v)| *sum -= *v);
        }
        z[*first_multiplier..].copy_from_slice(sum);
        for Block { unknowns, factor, .. } in blocks {
            matrix.multiply(z, product);
            let part = &mut part[..unknowns.len()];
            part.iter_mut()
                .zip(&*unknowns)
                .for_each(|(v, &i)| *v = r[i as usize] - product[i as usize]);
            factor.substitute(part);
            unknowns.iter().zip(part).for_each(|(&i, v)| z[i as usize] = *v);
        }
        r.copy_from_slice(z);
    }

    fn all(&self) -> impl Iterator<Item = &Factor> {
        self.blocks.iter().map(|b| &b.factor).chain(&self.factors)
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.z.len()
    }

    /// Stored entries of all factors.
    pub fn nonzeros(&self) -> usize {
        self.all().map(Factor::nonzeros).sum()
    }

    /// Operations of a factorisation, as [`Factor::operations`].
    pub fn operations(&self) -> f64 {
        self.all().map(Factor::operations).sum()
    }

    /// Entries read by one application: those of the factors, and of the matrix once per component.
    pub fn entries_read(&self) -> usize {
        self.nonzeros() + self.blocks.len() * self.entries_of_matrix
    }

    /// Bytes of the factors with their matrices and all working space.
    pub fn bytes(&self) -> usize {
        let factors: usize = self.all().map(Factor::bytes).sum();
        let matrices = self.blocks.iter().map(|b| &b.matrix).chain(&self.operators);
        let matrices: usize = matrices.map(|m| 16 * m.nonzeros() + 8 * m.order()).sum();
        factors + matrices + (16 + 4 * self.blocks.len()) * self.z.len()
    }
}
