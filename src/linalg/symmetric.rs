//! Sparse symmetric matrices; the upper triangle is stored.

use std::hash::{DefaultHasher, Hash, Hasher};

use sprs::CsMat;

use crate::base::{Error, Result};

/// Marks a position in a group without an unknown, because its value is prescribed; skipped
/// everywhere.
pub const CONSTRAINED: u32 = u32::MAX;

/// A square symmetric matrix `A`; only entries `A_ij` with `i <= j` are stored, by columns.
///
/// The pattern is built once, from groups of unknowns that couple with each other (the unknowns of
/// one cell), and never changes; values are set to zero and added again as often as needed. All
/// diagonal entries are in the pattern.
#[derive(Clone, Debug)]
pub struct SymmetricMatrix {
    upper: CsMat<f64>,
    pattern: u64,
}

impl SymmetricMatrix {
    /// The zero matrix of `order` unknowns in which all members of a group couple with each other.
    ///
    /// Entries of a group that are [`CONSTRAINED`] are skipped.
    ///
    /// # Errors
    /// Internal, if a group names an unknown that does not exist.
    pub fn from_groups<G: AsRef<[u32]>>(
        order: usize,
        groups: impl Iterator<Item = G>,
    ) -> Result<Self> {
        let incidence = Incidence::new(order, groups)?;
        let mut starts = Vec::with_capacity(order + 1);
        let mut rows: Vec<usize> = Vec::new();
        let mut last_column = vec![usize::MAX; order];
        starts.push(0);
        for column in 0..order {
            let start = rows.len();
            rows.push(column);
            last_column[column] = column;
            for row in incidence.neighbours(column) {
                let row = *row as usize;
                if row < column && last_column[row] != column {
                    last_column[row] = column;
                    rows.push(row);
                }
            }
            rows[start..].sort_unstable();
            starts.push(rows.len());
        }
        rows.shrink_to_fit();
        let values = vec![0.0; rows.len()];
        let upper =
            CsMat::try_new_csc((order, order), starts, rows, values).map_err(|(.., reason)| {
                Error::internal("a matrix pattern is not valid").value(reason)
            })?;
        let pattern = fingerprint(&upper);
        Ok(SymmetricMatrix { upper, pattern })
    }

    /// The principal submatrix of the unknowns (ascending) whose new index `number[i]` is not
    /// [`CONSTRAINED`].
    ///
    /// # Errors
    /// Internal, if the numbers do not ascend from 0.
    pub(super) fn principal(&self, number: &[u32]) -> Result<Self> {
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for j in (0..self.order()).filter(|&j| number[j] != CONSTRAINED) {
            rows.extend(
                self.column(j)
                    .0
                    .iter()
                    .map(|&i| number[i])
                    .filter(|&i| i != CONSTRAINED)
                    .map(|i| i as usize),
            );
            starts.push(rows.len());
        }
        let (order, values) = (starts.len() - 1, vec![0.0; rows.len()]);
        let upper =
            CsMat::try_new_csc((order, order), starts, rows, values).map_err(|(.., reason)| {
                Error::internal("a principal submatrix is not valid").value(reason)
            })?;
        let pattern = fingerprint(&upper);
        let mut part = SymmetricMatrix { upper, pattern };
        part.take_principal(self, number);
        Ok(part)
    }

    /// Copies the values of the principal submatrix of `whole`; `number` as in
    /// [`principal`](Self::principal).
    pub(super) fn take_principal(&mut self, whole: &SymmetricMatrix, number: &[u32]) {
        let mut to = self.upper.data_mut().iter_mut();
        for j in (0..whole.order()).filter(|&j| number[j] != CONSTRAINED) {
            let (rows, values) = whole.column(j);
            let kept = rows.iter().zip(values).filter(|(i, _)| number[**i] != CONSTRAINED);
            kept.zip(&mut to).for_each(|((_, v), to)| *to = *v);
        }
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.upper.cols()
    }

    /// Number of stored entries: the upper triangle with the diagonal.
    pub fn nonzeros(&self) -> usize {
        self.upper.nnz()
    }

    /// The upper triangle, in compressed columns.
    pub fn upper(&self) -> &CsMat<f64> {
        &self.upper
    }

    /// The rows and the values of the stored entries of column `j`; rows ascend and the last one is
    /// `j`.
    pub(super) fn column(&self, j: usize) -> (&[usize], &[f64]) {
        let range = self.upper.indptr().outer_inds_sz(j);
        (&self.upper.indices()[range.clone()], &self.upper.data()[range])
    }

    /// The stored values, column by column.
    pub fn values(&self) -> &[f64] {
        self.upper.data()
    }

    /// The stored values, column by column, mutable.
    pub fn values_mut(&mut self) -> &mut [f64] {
        self.upper.data_mut()
    }

    /// Sets all values to zero and keeps the pattern.
    pub fn zero(&mut self) {
        self.values_mut().fill(0.0);
    }

    /// Adds a full symmetric `local` matrix (`m x m`, by rows) to the entries of the `m` unknowns.
    ///
    /// [`CONSTRAINED`] unknowns are skipped; an unknown may occur more than once (periodic
    /// boundaries).
    ///
    /// # Errors
    /// Internal, if `local` is not `m x m` or couples two unknowns that no group of the pattern
    /// holds together.
    pub fn add_group(&mut self, unknowns: &[u32], local: &[f64]) -> Result<()> {
        let m = unknowns.len();
        if local.len() != m * m {
            return Err(Error::internal(format!(
                "a local matrix of {m} unknowns has {} entries",
                local.len()
            )));
        }
        for (b, &j) in unknowns.iter().enumerate() {
            if j == CONSTRAINED {
                continue;
            }
            let Some(mut column) = self.upper.outer_view_mut(j as usize) else {
                return Err(not_in_pattern(j, j));
            };
            for (a, &i) in unknowns.iter().enumerate() {
                // Also skips the constrained ones, whose number is larger than any other.
                if i <= j {
                    *column.get_mut(i as usize).ok_or_else(|| not_in_pattern(i, j))? +=
                        local[a * m + b];
                }
            }
        }
        Ok(())
    }

    /// `y = A x`; both have [`order`](Self::order) entries.
    pub fn multiply(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for j in 0..self.order() {
            let (rows, values) = self.column(j);
            let mut sum = 0.0;
            for (&i, a) in rows.iter().zip(values) {
                sum += a * x[i];
                if i < j {
                    y[i] += a * x[j];
                }
            }
            y[j] += sum;
        }
    }

    /// True if both matrices have the same pattern.
    pub fn same_pattern(&self, other: &SymmetricMatrix) -> bool {
        self.pattern == other.pattern
    }

    /// A hash of the pattern: equal for equal patterns and practically different for different
    /// ones.
    pub(super) fn pattern(&self) -> u64 {
        self.pattern
    }

    /// Takes the values of a matrix with the same pattern.
    ///
    /// # Errors
    /// Internal, if the patterns differ.
    pub fn copy_values_from(&mut self, other: &SymmetricMatrix) -> Result<()> {
        self.require_pattern_of(other)?;
        self.values_mut().copy_from_slice(other.values());
        Ok(())
    }

    /// `A += factor * other`, for a matrix with the same pattern.
    ///
    /// # Errors
    /// Internal, if the patterns differ.
    pub fn add_scaled(&mut self, factor: f64, other: &SymmetricMatrix) -> Result<()> {
        self.require_pattern_of(other)?;
        for (a, b) in self.values_mut().iter_mut().zip(other.values()) {
            *a += factor * b;
        }
        Ok(())
    }

    fn require_pattern_of(&self, other: &SymmetricMatrix) -> Result<()> {
        if self.same_pattern(other) {
            return Ok(());
        }
        let sizes = format!("{} and {} entries", self.nonzeros(), other.nonzeros());
        Err(Error::internal("two matrices that must have the same pattern differ").value(sizes))
    }
}

fn not_in_pattern(i: u32, j: u32) -> Error {
    Error::internal("an entry that is added to a matrix is not in its pattern")
        .at(format!("row {i}, column {j}"))
}

fn fingerprint(matrix: &CsMat<f64>) -> u64 {
    let mut hasher = DefaultHasher::new();
    matrix.indptr().raw_storage().hash(&mut hasher);
    matrix.indices().hash(&mut hasher);
    hasher.finish()
}

/// The groups, and the groups of every unknown.
struct Incidence {
    members: Vec<u32>,
    /// Group `g` is `members[group_starts[g]..group_starts[g + 1]]`.
    group_starts: Vec<usize>,
    groups: Vec<u32>,
    /// Unknown `i` is in `groups[starts[i]..starts[i + 1]]`.
    starts: Vec<usize>,
}

impl Incidence {
    fn new<G: AsRef<[u32]>>(order: usize, groups: impl Iterator<Item = G>) -> Result<Incidence> {
        let mut members = Vec::new();
        let mut group_starts = vec![0];
        let mut starts = vec![0; order + 1];
        for group in groups {
            for &i in group.as_ref().iter().filter(|&&i| i != CONSTRAINED) {
                let Some(count) = starts.get_mut(i as usize + 1) else {
                    return Err(Error::internal(format!(
                        "a matrix of {order} unknowns is asked to hold unknown {i}"
                    )));
                };
                *count += 1;
                members.push(i);
            }
            group_starts.push(members.len());
        }
        if u32::try_from(group_starts.len()).is_err() {
            return Err(Error::internal("a matrix pattern has more groups than 32 bits can count"));
        }
        for i in 0..order {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut of_unknown = vec![0; members.len()];
        for g in 0..group_starts.len() - 1 {
            for &i in &members[group_starts[g]..group_starts[g + 1]] {
                of_unknown[next[i as usize]] = g as u32;
                next[i as usize] += 1;
            }
        }
        Ok(Incidence { members, group_starts, groups: of_unknown, starts })
    }

    /// All members of all groups of an unknown, with repetitions.
    fn neighbours(&self, unknown: usize) -> impl Iterator<Item = &u32> {
        self.groups[self.starts[unknown]..self.starts[unknown + 1]].iter().flat_map(|&g| {
            &self.members[self.group_starts[g as usize]..self.group_starts[g as usize + 1]]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dense(matrix: &SymmetricMatrix) -> Vec<Vec<f64>> {
        let n = matrix.order();
        let mut columns = vec![vec![0.0; n]; n];
        for (j, column) in columns.iter_mut().enumerate() {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            matrix.multiply(&unit, column);
        }
        columns
    }

    #[test]
    fn groups_add_up_to_the_full_matrix() {
        let groups = [[2, 0, CONSTRAINED], [1, 2, 3]];
        let mut a = SymmetricMatrix::from_groups(5, groups.iter()).unwrap();
        assert_eq!(a.nonzeros(), 5 + 1 + 3);
        a.add_group(&groups[0], &[1.0, 2.0, 9.0, 2.0, 3.0, 9.0, 9.0, 9.0, 9.0]).unwrap();
        a.add_group(&groups[1], &[10.0, 20.0, 30.0, 20.0, 40.0, 50.0, 30.0, 50.0, 60.0]).unwrap();
        let expected = [
            [3.0, 0.0, 2.0, 0.0, 0.0],
            [0.0, 10.0, 20.0, 30.0, 0.0],
            [2.0, 20.0, 41.0, 50.0, 0.0],
            [0.0, 30.0, 50.0, 60.0, 0.0],
            [0.0; 5],
        ];
        assert_eq!(dense(&a), expected);
        a.zero();
        assert_eq!(dense(&a), [[0.0; 5]; 5]);
    }

    #[test]
    fn an_unknown_that_occurs_twice_in_a_group_gets_all_its_entries() {
        // The local unknowns a, b, c with a = c: x^T A x must be the local quadratic form.
        let local = [1.0, 2.0, 3.0, 2.0, 4.0, 5.0, 3.0, 5.0, 6.0];
        let mut a = SymmetricMatrix::from_groups(2, [[1, 0, 1]].iter()).unwrap();
        a.add_group(&[1, 0, 1], &local).unwrap();
        assert_eq!(dense(&a), [[4.0, 7.0], [7.0, 1.0 + 6.0 + 2.0 * 3.0]]);
    }

    #[test]
    fn matrices_of_one_pattern_are_added_in_place() {
        let mut a = SymmetricMatrix::from_groups(3, [[0, 1], [1, 2]].iter()).unwrap();
        let mut b = a.clone();
        a.add_group(&[0, 1], &[1.0, 2.0, 2.0, 3.0]).unwrap();
        b.copy_values_from(&a).unwrap();
        b.add_scaled(-0.5, &a).unwrap();
        assert_eq!(dense(&b), [[0.5, 1.0, 0.0], [1.0, 1.5, 0.0], [0.0; 3]]);
        let other = SymmetricMatrix::from_groups(3, [[0, 1], [0, 2]].iter()).unwrap();
        assert_eq!(other.nonzeros(), a.nonzeros());
        assert!(!a.same_pattern(&other));
        assert!(a.add_scaled(1.0, &other).is_err() && a.copy_values_from(&other).is_err());
    }

    #[test]
    fn what_is_not_in_the_pattern_is_an_error() {
        let mut a = SymmetricMatrix::from_groups(3, [[0, 1]].iter()).unwrap();
        let error = a.add_group(&[0, 2], &[1.0; 4]).unwrap_err();
        assert!(error.place().contains("row 0, column 2"), "{error}");
        assert!(a.add_group(&[3], &[1.0]).is_err());
        assert!(a.add_group(&[0, 1], &[1.0; 3]).is_err());
        assert!(SymmetricMatrix::from_groups(3, [[0, 3]].iter()).is_err());
    }

    #[test]
    fn a_matrix_without_unknowns_or_groups_is_fine() {
        let none: [[u32; 0]; 0] = [];
        assert_eq!(SymmetricMatrix::from_groups(0, none.iter()).unwrap().nonzeros(), 0);
        assert_eq!(SymmetricMatrix::from_groups(4, none.iter()).unwrap().nonzeros(), 4);
    }
}
