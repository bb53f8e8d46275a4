//! The calls of faer for a factor: pattern, blocks, values.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::{LdltError, LdltRegularization};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::traits::ComplexField;
use faer::{Par, Side};

use crate::base::{Error, Result};
use crate::linalg::substitution::Supernodes;
use crate::linalg::{Ordering, SymmetricMatrix};

pub(super) fn symbolic_factor(
    matrix: &SymmetricMatrix,
    ordering: &Ordering,
) -> Result<SymbolicCholesky<usize>> {
    let n = matrix.order();
    if ordering.unknowns().len() != n {
        let sizes = format!("{} unknowns, ordering of {}", n, ordering.unknowns().len());
        return Err(Error::internal("an ordering does not belong to the matrix").value(sizes));
    }
    let pointers = matrix.upper().indptr();
    let permutation =
        faer::perm::PermRef::new_checked(ordering.unknowns(), ordering.positions(), n);
    let params = CholeskySymbolicParams {
        // Faster than the simplicial method from a few hundred unknowns on.
        supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
        ..Default::default()
    };
    let pattern = view_of_pattern(matrix, pointers.raw_storage());
    factorize_symbolic_cholesky(
        pattern,
        Side::Upper,
        SymmetricOrdering::Custom(permutation),
        params,
    )
    .map_err(|error| {
        Error::computation("the factor of a matrix could not be planned")
            .at(format!("{n} unknowns, {} entries", matrix.nonzeros()))
            .value(error)
            .remedy("use a coarser mesh or a machine with more memory")
    })
}

/// The blocks of the factor, independent of faer.
pub(super) fn supernodes(symbolic: &SymbolicCholesky<usize>) -> Result<Supernodes> {
    let SymbolicCholeskyRaw::Supernodal(blocks) = symbolic.raw() else {
        return Err(Error::internal("a factor has no supernodes"));
    };
    let block = |s: usize| {
        let [begin, end] = [blocks.supernode_begin()[s], blocks.supernode_end()[s]];
        let rows = blocks.supernode(s).pattern().iter().map(|&i| i as u32);
        (begin, end - begin, blocks.col_ptr_for_val()[s], rows)
    };
    Ok(Supernodes::new((0..blocks.n_supernodes()).map(block)))
}

pub(super) fn view_of_pattern<'a>(
    matrix: &'a SymmetricMatrix,
    pointers: &'a [usize],
) -> SymbolicSparseColMatRef<'a, usize> {
    let n = matrix.order();
    SymbolicSparseColMatRef::new_checked(n, n, pointers, None, matrix.upper().indices())
}

/// The numeric factorisation in the precision of `values` and `factor`. Sequential.
pub(super) fn numeric<T: ComplexField>(
    symbolic: &SymbolicCholesky<usize>,
    pattern: SymbolicSparseColMatRef<'_, usize>,
    values: &[T],
    factor: &mut [T],
    scratch: &mut MemBuffer,
) -> std::result::Result<(), LdltError> {
    let matrix = SparseColMatRef::new(pattern, values);
    let (stack, rule) = (MemStack::new(scratch), LdltRegularization::default());
    symbolic
        .factorize_numeric_ldlt(
            factor,
            matrix,
            Side::Upper,
            rule,
            Par::Seq,
            stack,
            Default::default(),
        )
        .map(|_| ())
}
