//! Forward and backward substitution with a supernodal factor `L D U`; for a symmetric matrix
//! `U = L^T`.
//!
//! The time is that of reading the factor from the memory, twice. Eight columns are processed
//! together: the entries of the solution that they share are read and written once, and in the
//! backward pass, against the order in the memory, so many streams use the full bandwidth (two
//! thirds of the time of four columns, if the factor is larger than the caches). The divisions by
//! `D` are done in the backward pass.

/// A stored number of a factor. The arithmetic is in double precision: single precision halves the
/// bytes read.
pub(super) trait Entry: Copy {
    /// The number in double precision.
    fn wide(self) -> f64;
}

impl Entry for f64 {
    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
}

impl Entry for f32 {
    #[inline(always)]
    fn wide(self) -> f64 {
        f64::from(self)
    }
}

/// Positions of the blocks of a factor.
///
/// A supernode is a block of consecutive columns with the same rows below their triangle: `width`
/// columns of `width + rows` entries each, one after another. The diagonal holds `D`; entries above
/// it are unused.
pub(super) struct Supernodes {
    blocks: Vec<Block>,
    /// Rows below the triangles, block by block.
    rows: Vec<u32>,
    /// Entries of the solution that belong to a block.
    panel: Vec<f64>,
}

#[derive(Clone, Copy)]
pub(super) struct Block {
    /// Its first column.
    pub column: usize,
    /// Number of columns.
    pub width: usize,
    /// Index of its first entry among all entries of the factor.
    pub entries: usize,
    /// Start and end of its rows.
    rows: [usize; 2],
}

impl Supernodes {
    /// From blocks in the order of elimination, each with its first column, its width, the start of
    /// its entries and its rows.
    pub fn new<R: Iterator<Item = u32>>(
        list: impl Iterator<Item = (usize, usize, usize, R)>,
    ) -> Supernodes {
        let (mut blocks, mut rows, mut tallest) = (Vec::new(), Vec::new(), 0);
        for (column, width, entries, below) in list {
            let start = rows.len();
            rows.extend(below);
            tallest = tallest.max(width + rows.len() - start);
            blocks.push(Block { column, width, entries, rows: [start, rows.len()] });
        }
        Supernodes { blocks, rows, panel: vec![0.0; tallest] }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(self.blocks.as_slice())
            + size_of_val(self.rows.as_slice())
            + size_of_val(self.panel.as_slice())
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.blocks.len()
    }

    /// Block `s`.
    pub fn block(&self, s: usize) -> Block {
        self.blocks[s]
    }

    /// Block `s` and its rows below the triangle.
    pub fn with_rows(&self, s: usize) -> (Block, &[u32]) {
        let block = self.blocks[s];
        (block, &self.rows[block.rows[0]..block.rows[1]])
    }

    /// Replaces the right-hand side `x`, in the order of elimination, by the solution. `lower`
    /// holds the columns of `L` and `D`, `upper` those of `U^T`.
    pub fn solve<E: Entry>(&mut self, [lower, upper]: [&[E]; 2], x: &mut [f64]) {
        for block in &self.blocks {
            let rows = &self.rows[block.rows[0]..block.rows[1]];
            let (entries, panel) = block.parts(rows, lower, &mut self.panel);
            panel[..block.width].copy_from_slice(&x[block.column..][..block.width]);
            panel[block.width..].fill(0.0);
            eliminate(entries, block.width, panel);
            x[block.column..][..block.width].copy_from_slice(&panel[..block.width]);
            rows.iter().zip(&panel[block.width..]).for_each(|(&i, v)| x[i as usize] += v);
        }
        for block in self.blocks.iter().rev() {
            let rows = &self.rows[block.rows[0]..block.rows[1]];
            let (entries, panel) = block.parts(rows, upper, &mut self.panel);
            let height = panel.len();
            let pivots = &lower[block.entries..];
            for k in 0..block.width {
                panel[k] = x[block.column + k] / pivots[k * height + k].wide();
            }
            rows.iter().zip(&mut panel[block.width..]).for_each(|(&i, v)| *v = x[i as usize]);
            substitute_back(entries, block.width, panel);
            x[block.column..][..block.width].copy_from_slice(&panel[..block.width]);
        }
    }
}

impl Block {
    /// The entries of the block, and as much of the panel as it needs.
    fn parts<'a, E>(
        &self,
        rows: &[u32],
        factor: &'a [E],
        panel: &'a mut [f64],
    ) -> (&'a [E], &'a mut [f64]) {
        let height = self.width + rows.len();
        (&factor[self.entries..][..self.width * height], &mut panel[..height])
    }
}

/// `x <- L^-1 x` for the first `width` entries of the panel; their contributions to the other
/// entries are added to these.
fn eliminate<E: Entry>(entries: &[E], width: usize, panel: &mut [f64]) {
    let mut k = 0;
    while k < width {
        k += match width - k {
            8.. => eliminate_columns::<8, E>(entries, k, panel),
            4.. => eliminate_columns::<4, E>(entries, k, panel),
            _ => eliminate_columns::<1, E>(entries, k, panel),
        };
    }
}

/// [`eliminate`] for `N` columns from `k` on. Returns `N`.
fn eliminate_columns<const N: usize, E: Entry>(
    entries: &[E],
    k: usize,
    panel: &mut [f64],
) -> usize {
    let height = panel.len();
    let (head, tail) = panel.split_at_mut(k + N);
    let below: [&[E]; N] =
        std::array::from_fn(|j| &entries[(k + j) * height + k + N..][..tail.len()]);
    let x = &mut head[k..];
    for j in 0..N {
        for i in j + 1..N {
            x[i] -= entries[(k + j) * height + k + i].wide() * x[j];
        }
    }
    let x: [f64; N] = std::array::from_fn(|j| x[j]);
    for i in 0..tail.len() {
        let mut sum = 0.0;
        for j in 0..N {
            sum += below[j][i].wide() * x[j];
        }
        tail[i] -= sum;
    }
    N
}

/// `x <- L^-T x` for the first `width` entries of the panel; the others are known.
fn substitute_back<E: Entry>(entries: &[E], width: usize, panel: &mut [f64]) {
    let mut k = width;
    // The columns in the same groups as in the forward pass.
    while k > 0 {
        k -= match (k % 8, k % 4) {
            (0, _) => substitute_columns::<8, E>(entries, k - 8, panel),
            (_, 0) => substitute_columns::<4, E>(entries, k - 4, panel),
            _ => substitute_columns::<1, E>(entries, k - 1, panel),
        };
    }
}

/// [`substitute_back`] for `N` columns from `k` on. Returns `N`.
fn substitute_columns<const N: usize, E: Entry>(
    entries: &[E],
    k: usize,
    panel: &mut [f64],
) -> usize {
    let height = panel.len();
    let (head, tail) = panel.split_at_mut(k + N);
    let below: [&[E]; N] =
        std::array::from_fn(|j| &entries[(k + j) * height + k + N..][..tail.len()]);
    let x = &mut head[k..];
    let sums = products(below, tail);
    for j in (0..N).rev() {
        let mut sum = sums[j];
        for i in j + 1..N {
            sum += entries[(k + j) * height + k + i].wide() * x[i];
        }
        x[j] -= sum;
    }
    N
}

/// The products of `v` with several columns, each in four partial sums.
fn products<const N: usize, E: Entry>(columns: [&[E]; N], v: &[f64]) -> [f64; N] {
    const LANES: usize = 4;
    let n = v.len();
    let whole = n - n % LANES;
    let mut sums = [[0.0; LANES]; N];
    for i in (0..whole).step_by(LANES) {
        let part = &v[i..i + LANES];
        for (sum, c) in sums.iter_mut().zip(&columns) {
            let c = &c[i..i + LANES];
            for l in 0..LANES {
                sum[l] += c[l].wide() * part[l];
            }
        }
    }
    std::array::from_fn(|j| {
        let rest = (whole..n).map(|i| columns[j][i].wide() * v[i]).sum::<f64>();
        let [a, b, c, d] = sums[j];
        (a + b) + (c + d) + rest
    })
}
