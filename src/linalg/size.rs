//! Size of a factor, and time of a factorisation.

/// Relative costs of a factorisation: per operation, and per entry of the factor. The unit is that
/// of [`ITERATING`].
const FACTORING: [f64; 2] = [0.028, 8.0];
/// Relative costs of an iteration (substitution, product with the matrix, orthogonalisation): per
/// entry read, and per unknown.
const ITERATING: [f64; 2] = [1.3, 100.0];
/// Cost in single precision over that in double precision: of an operation, and of reading an
/// entry.
const SINGLE: [f64; 2] = [0.5, 0.75];
/// Nanoseconds of a factorisation on one core of a server: per operation, and per entry. For
/// display only, as [`SOLVING_TIME`].
///
/// Measured (November 2026, seconds of the processor) for P2-P1 on `n^3` cubes, n = 8, 12, 16:
/// 0.065, 0.57, 3.5 to 4.5 (by this model 0.06, 0.74, 4.3), in single precision 0.04, 0.34, 2.0.
const FACTORING_TIME: [f64; 2] = [0.018, 2.5];
/// Nanoseconds of a solve, as [`ITERATING`]. Measured as above: 0.005, 0.028, 0.085 (by this model
/// 0.006, 0.030, 0.10).
const SOLVING_TIME: [f64; 2] = [0.8, 100.0];

/// The precision that a factor is computed and stored in; matrices, right-hand sides and solutions
/// are in double precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits: one substitution is accurate to rounding.
    Double,
    /// 32 bits, half the memory: a substitution is accurate to about 1e-6, and iterations have to
    /// follow.
    Single,
}

impl Precision {
    /// Bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Precision::Double => size_of::<f64>(),
            Precision::Single => size_of::<f32>(),
        }
    }
}

/// Counts of a factor, or of several, known before it is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorSize {
    /// Unknowns.
    pub unknowns: usize,
    /// Stored entries of the factor.
    pub entries: usize,
    /// Entries that a solve or an iteration reads, each twice.
    pub read: usize,
    /// Operations of a numeric factorisation: the sum over the columns of the square of their
    /// lengths.
    pub operations: f64,
    /// Bytes of the factor with its working space.
    pub bytes: usize,
    /// The precision of its numbers.
    pub precision: Precision,
}

impl FactorSize {
    /// Cost of a numeric factorisation, in iterations preconditioned by the factor: numbers of
    /// operations and entries, weighted with measured constants that are the same on every machine,
    /// so that no decision depends on a clock.
    ///
    /// Measured on one core of a server (November 2026): factorisation over substitution and
    /// product for P2-P1 on `n x n` squares, n = 30, 60, 120: 6.8, 4.2, 5.3 (by this model 4.2,
    /// 5.4, 7.3); on `n^3` cubes, n = 4, 6, 8, 10: 8.3, 9.3, 10.4, 15.0 (6.4, 10.4, 14.5, 20.6);
    /// another time, n = 8, 12, 16: 14, 20, 41 (14.5, 28, 46), in single precision 10, 17, 30 (9.9,
    /// 19, 31).
    pub fn cost(&self) -> f64 {
        self.weighed(FACTORING, self.entries) / self.iteration(ITERATING).max(1.0)
    }

    /// Estimated seconds of a factorisation on one core of a server, for display only.
    pub fn factoring_seconds(&self) -> f64 {
        1e-9 * self.weighed(FACTORING_TIME, self.entries)
    }

    /// Estimated seconds of a substitution or an iteration, as
    /// [`factoring_seconds`](Self::factoring_seconds).
    pub fn solving_seconds(&self) -> f64 {
        1e-9 * self.iteration(SOLVING_TIME)
    }

    /// Bytes of the numbers of the factor.
    pub fn value_bytes(&self) -> usize {
        self.entries * self.precision.bytes()
    }

    fn weighed(&self, [operation, entry]: [f64; 2], entries: usize) -> f64 {
        self.relative()[0] * (operation * self.operations + entry * entries as f64)
    }

    fn iteration(&self, [entry, unknown]: [f64; 2]) -> f64 {
        self.relative()[1] * entry * self.read as f64 + unknown * self.unknowns as f64
    }

    fn relative(&self) -> [f64; 2] {
        match self.precision {
            Precision::Double => [1.0; 2],
            Precision::Single => SINGLE,
        }
    }
}
