//! The factorisation `L D U` without pivoting of a matrix whose pattern is symmetric and whose
//! values are not, in single precision: the preconditioner of flows with implicit convection.
//!
//! Supernodal and right-looking on the pattern of the symmetric factor. With positive definite
//! symmetric parts of the velocity block (mass, viscosity) no pivot vanishes in the order of a
//! saddle point, whatever the skew part: G. H. Golub and C. Van Loan, Unsymmetric positive definite
//! linear systems, Linear Algebra Appl. 28 (1979) 85. The entries may grow with the skew part, and
//! iterations have to follow.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use super::resize;
use crate::linalg::SymmetricMatrix;
use crate::linalg::single::scales;
use crate::linalg::substitution::Supernodes;

/// Columns that are eliminated one by one before a product updates the others.
const PANEL: usize = 32;
/// Columns of an update that are computed at a time.
const UPDATE: usize = 64;

/// The values of a factor `L D U`, each block of columns of `L` and of `U^T` as in [`Supernodes`]:
/// below unit diagonals; the diagonal of `lower` holds `D`.
#[derive(Default)]
pub(super) struct Lu {
    pub lower: Vec<f32>,
    pub upper: Vec<f32>,
    /// The diagonal of `S`: the factored matrix is `S A S`.
    pub scale: Vec<f64>,
    /// Position in the factor of each stored entry of the matrix.
    slots: Vec<usize>,
    /// Halves of the matrix, symmetric and skew.
    halves: Option<[SymmetricMatrix; 2]>,
    work: Work,
}

/// Buffers of an elimination.
#[derive(Default)]
struct Work {
    /// Block of every column.
    owner: Vec<u32>,
    /// Positions of rows in the block that they update.
    places: Vec<usize>,
    update: Vec<f32>,
}

impl Lu {
    /// Bytes of the values for this many entries of `L`, and of the working space for a matrix.
    pub fn bytes(nonzeros: usize, [order, entries]: [usize; 2]) -> usize {
        // Positions, and two halves with values and row numbers.
        2 * size_of::<f32>() * nonzeros + 40 * entries + 60 * order
    }

    /// Allocates the values, once; false if the memory does not suffice.
    pub fn reserve(&mut self, nonzeros: usize, entries: usize) -> bool {
        resize(&mut self.lower, nonzeros)
            && resize(&mut self.upper, nonzeros)
            && resize(&mut self.slots, entries)
    }

    /// The halves of the matrix to be factored, for assembly; those of `matrix` at first.
    pub fn halves(&mut self, matrix: &SymmetricMatrix) -> &mut [SymmetricMatrix; 2] {
        let halves = self.halves.get_or_insert_with(|| [matrix.clone(), matrix.clone()]);
        halves[0].values_mut().copy_from_slice(matrix.values());
        halves[1].zero();
        halves
    }

    /// Factors the matrix of the halves; `positions` are those of the unknowns in the order of
    /// elimination.
    ///
    /// # Errors
    /// The position of a pivot that is zero or not finite.
    pub fn factor(
        &mut self,
        blocks: &Supernodes,
        positions: &[usize],
    ) -> std::result::Result<(), usize> {
        let Some([symmetric, skew]) = self.halves.take() else { return Err(0) };
        if self.work.owner.is_empty() {
            self.plan(blocks, positions, &symmetric);
        }
        self.fill(positions, [&symmetric, &skew]);
        self.halves = Some([symmetric, skew]);
        let (lower, upper) = (&mut self.lower[..], &mut self.upper[..]);
        (0..blocks.len()).try_for_each(|s| eliminate(blocks, s, [lower, upper], &mut self.work))
    }

    /// Finds the position of every entry of the matrix.
    fn plan(&mut self, blocks: &Supernodes, positions: &[usize], matrix: &SymmetricMatrix) {
        self.work.owner = vec![0; matrix.order()];
        for s in 0..blocks.len() {
            let block = blocks.block(s);
            self.work.owner[block.column..][..block.width].fill(s as u32);
        }
        let mut entry = 0;
        for j in 0..matrix.order() {
            for &i in matrix.column(j).0 {
                let (a, b) = (positions[i], positions[j]);
                let (column, row) = (a.min(b), a.max(b));
                let (block, rows) = blocks.with_rows(self.work.owner[column] as usize);
                let height = block.width + rows.len();
                let place = match row.checked_sub(block.column + block.width) {
                    None => row - block.column,
                    Some(_) => block.width + rows.partition_point(|&r| (r as usize) < row),
                };
                self.slots[entry] = block.entries + (column - block.column) * height + place;
                entry += 1;
            }
        }
    }

    /// Writes the scaled entries of the matrix into the factor.
    fn fill(&mut self, positions: &[usize], [symmetric, skew]: [&SymmetricMatrix; 2]) {
        self.scale = scales(symmetric);
        self.lower.fill(0.0);
        self.upper.fill(0.0);
        let mut slots = self.slots.iter();
        for j in 0..symmetric.order() {
            let ((rows, h), (_, s)) = (symmetric.column(j), skew.column(j));
            for (((&i, h), s), &slot) in rows.iter().zip(h).zip(s).zip(&mut slots) {
                let scale = self.scale[i] * self.scale[j];
                let (above, below) = (((h + s) * scale) as f32, ((h - s) * scale) as f32);
                let straight = positions[i] < positions[j];
                (self.upper[slot], self.lower[slot]) =
                    if straight { (above, below) } else { (below, above) };
            }
        }
    }
}

/// Eliminates the columns of block `s`, whose updates by earlier ones are done, and updates later
/// blocks.
fn eliminate(
    blocks: &Supernodes,
    s: usize,
    [lower, upper]: [&mut [f32]; 2],
    work: &mut Work,
) -> std::result::Result<(), usize> {
    let (block, rows) = blocks.with_rows(s);
    let (width, height) = (block.width, block.width + rows.len());
    let [(l, later_l), (u, later_u)] =
        [lower, upper].map(|v| v[block.entries..].split_at_mut(width * height));
    for start in (0..width).step_by(PANEL) {
        let end = width.min(start + PANEL);
        for k in start..end {
            eliminate_column([l, u], height, [k, end]).ok_or(block.column + k)?;
        }
        let [(l, rest_l), (u, rest_u)] = [&mut *l, &mut *u].map(|v| v.split_at_mut(end * height));
        let columns = width - end;
        if columns > 0 {
            let [from_l, from_u] = [&*l, &*u].map(|v| view(v, [height, start, end]));
            for (to, below, across) in [(rest_l, from_l, from_u), (rest_u, from_u, from_l)] {
                let to =
                    MatMut::from_column_major_slice_with_stride_mut(to, height, columns, height);
                let (below, across) =
                    (below.subrows(end, height - end), across.subrows(end, columns).transpose());
                matmul(
                    to.subrows_mut(end, height - end),
                    Accum::Add,
                    below,
                    across,
                    -1.0,
                    Par::Seq,
                );
            }
        }
    }
    for first in (0..rows.len()).step_by(UPDATE) {
        let columns = UPDATE.min(rows.len() - first);
        let count = rows.len() - first;
        work.update.resize((count * columns).max(work.update.len()), 0.0);
        let [from_l, from_u] = [&*l, &*u].map(|v| view(v, [height, 0, width]));
        let later = block.entries + width * height;
        let both = [(&mut *later_l, from_l, from_u, true), (&mut *later_u, from_u, from_l, false)];
        for (to, below, across, diagonal) in both {
            let update = &mut work.update[..count * columns];
            let product = MatMut::from_column_major_slice_mut(update, count, columns);
            let (below, across) = (
                below.subrows(width + first, count),
                across.subrows(width + first, columns).transpose(),
            );
            matmul(product, Accum::Replace, below, across, 1.0, Par::Seq);
            let parts = (&work.owner[..], &mut work.places);
            subtract(blocks, &rows[first..], (to, later), &work.update, diagonal, parts);
        }
    }
    // The columns of L with a unit diagonal, beside the pivots.
    for k in 0..width {
        let column = &mut l[k * height..][..height];
        let inverse = 1.0 / column[k];
        column[k + 1..].iter_mut().for_each(|v| *v *= inverse);
    }
    Ok(())
}

/// Divides column `k` of `U^T` by the pivot, and updates the columns up to `end`; `None` if the
/// pivot is zero or not finite. The columns of `L` stay multiplied by their pivots.
fn eliminate_column([l, u]: [&mut [f32]; 2], height: usize, [k, end]: [usize; 2]) -> Option<()> {
    let ((l, rest_l), (u, rest_u)) =
        (l.split_at_mut((k + 1) * height), u.split_at_mut((k + 1) * height));
    let (l, u) = (&l[k * height..], &mut u[k * height..]);
    let inverse = 1.0 / l[k];
    if !(inverse.is_finite() && l[k].is_finite()) {
        return None;
    }
    u[k + 1..].iter_mut().for_each(|v| *v *= inverse);
    for j in k + 1..end {
        let at = (j - k - 1) * height + j;
        let count = height - j;
        let [a, b] = [u[j], l[j]];
        let (to, from) = (&mut rest_l[at..][..count], &l[j..][..count]);
        to.iter_mut().zip(from).for_each(|(to, v)| *to -= a * v);
        let (to, from) = (&mut rest_u[at..][..count], &u[j..][..count]);
        to.iter_mut().zip(from).for_each(|(to, v)| *to -= b * v);
    }
    Some(())
}

/// Columns `start..end` of a block.
fn view(values: &[f32], [height, start, end]: [usize; 3]) -> MatRef<'_, f32> {
    let part = &values[start * height..end * height];
    MatRef::from_column_major_slice(part, height, end - start)
}

/// Subtracts the lower triangle of an update (columns of `rows.len()` entries, by `rows`) from
/// later blocks, whose entries begin at `start` in the factor; without its diagonal if that is held
/// elsewhere.
fn subtract(
    blocks: &Supernodes,
    rows: &[u32],
    (to, start): (&mut [f32], usize),
    update: &[f32],
    diagonal: bool,
    (owner, places): (&[u32], &mut Vec<usize>),
) {
    let count = rows.len();
    let columns = count.min(UPDATE);
    let mut first = 0;
    while first < columns {
        let s = owner[rows[first] as usize];
        let (block, own) = blocks.with_rows(s as usize);
        let (end, height) = (block.column + block.width, block.width + own.len());
        places.clear();
        let mut next = 0;
        for &row in &rows[first..] {
            let row = row as usize;
            places.push(match row < end {
                true => row - block.column,
                false => {
                    next += own[next..].iter().take_while(|&&r| (r as usize) < row).count();
                    block.width + next
                }
            });
        }
        let mut j = first;
        while j < columns && owner[rows[j] as usize] == s {
            let column = block.entries - start + places[j - first] * height;
            let to = &mut to[column..][..height];
            let skip = j + usize::from(!diagonal);
            let from = &update[j * count..(j + 1) * count];
            for (&place, v) in places[skip - first..].iter().zip(&from[skip..]) {
                to[place] -= v;
            }
            j += 1;
        }
        first = j;
    }
}
