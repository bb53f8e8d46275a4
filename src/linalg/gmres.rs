//! GMRES for any operator, with any preconditioner.

use super::Operator;

/// Number of Krylov vectors before a restart.
pub(super) const RESTART: usize = 40;
/// Number of iterations before the rate of convergence is assessed.
const TRIAL: usize = 4;

/// Result of an iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Iterated {
    /// Applications of the preconditioner.
    pub iterations: usize,
    /// `|b - A x| / |b|` in the 2-norm, computed from the returned vector.
    pub residual: f64,
    /// True if the residual is within the tolerance.
    pub converged: bool,
}

/// Working space; grows with the largest number of iterations so far.
#[derive(Default)]
pub(super) struct Gmres {
    /// Orthonormal residual directions `v_0 .. v_m`.
    basis: Vec<Vec<f64>>,
    /// `z_j = M^{-1} v_j`.
    directions: Vec<Vec<f64>>,
    residual: Vec<f64>,
    /// Columns of the triangular factor of the Hessenberg matrix.
    columns: Vec<Vec<f64>>,
    rotations: Vec<[f64; 2]>,
    /// The rotated right-hand side of the least-squares problem.
    g: Vec<f64>,
}

impl Gmres {
    /// Improves `x` until `|b - A x| <= tolerance |b|` in the 2-norm, in at most `most` iterations.
    /// Stops early if the mean reduction so far needs half as many again. `precondition` replaces a
    /// vector by `M^{-1}` times it.
    ///
    /// Preconditioned from the right, so that the residual of the system itself is minimised (Saad,
    /// Iterative Methods for Sparse Linear Systems, 2nd ed., algorithm 9.6). Sequential:
    /// bit-identical for any number of threads.
    pub fn solve(
        &mut self,
        operator: &mut Operator<'_>,
        mut precondition: impl FnMut(&mut [f64]),
        rhs: &[f64],
        x: &mut [f64],
        (tolerance, most): (f64, usize),
    ) -> Iterated {
        let n = rhs.len();
        self.residual.resize(n, 0.0);
        let scale = dot(rhs, rhs).sqrt();
        let mut done = Iterated { iterations: 0, residual: 0.0, converged: true };
        if scale == 0.0 {
            x.fill(0.0);
            return done;
        }
        let first = self.start(operator, rhs, x) / scale;
        let mut relative = first;
        loop {
            done.residual = relative;
            done.converged = relative <= tolerance;
            if done.converged || !relative.is_finite() || done.iterations >= most {
                return done;
            }
            let (mut j, mut hopeless) = (0, false);
            while j < RESTART && done.iterations < most && relative > tolerance && !hopeless {
                relative = self.expand(j, operator, &mut precondition) / scale;
                j += 1;
                done.iterations += 1;
                hopeless = !relative.is_finite()
                    || (done.iterations >= TRIAL
                        && relative > tolerance
                        && expected(first, relative, done.iterations, tolerance)
                            > 1.5 * most as f64);
            }
            self.add_solution(j, x);
            let true_residual = self.start(operator, rhs, x) / scale;
            // Rounding: what was gained is kept, more is not to be had.
            let stalled = true_residual > 0.5 * done.residual;
            relative = true_residual;
            if hopeless || stalled {
                return Iterated { residual: relative, converged: relative <= tolerance, ..done };
            }
        }
    }

    /// Sets the first direction to the residual of `x`; returns its norm.
    fn start(&mut self, operator: &mut Operator<'_>, rhs: &[f64], x: &[f64]) -> f64 {
        operator.multiply(x, &mut self.residual);
        self.residual.iter_mut().zip(rhs).for_each(|(r, b)| *r = b - *r);
        let norm = dot(&self.residual, &self.residual).sqrt();
        let v = slot(&mut self.basis, 0, rhs.len());
        v.iter_mut().zip(&self.residual).for_each(|(v, r)| *v = r / norm);
        self.g.clear();
        self.g.push(norm);
        self.columns.clear();
        self.rotations.clear();
        norm
    }

    /// Adds direction `j`; returns the norm of the residual of the least-squares problem.
    fn expand(
        &mut self,
        j: usize,
        operator: &mut Operator<'_>,
        precondition: &mut impl FnMut(&mut [f64]),
    ) -> f64 {
        let n = self.residual.len();
        let z = slot(&mut self.directions, j, n);
        z.copy_from_slice(&self.basis[j]);
        precondition(z);
        let z = &self.directions[j];
        let w = &mut self.residual;
        operator.multiply(z, w);
        let mut column = Vec::with_capacity(j + 2);
        for v in &self.basis[..=j] {
            let h = dot(v, w);
            w.iter_mut().zip(v).for_each(|(w, v)| *w -= h * v);
            column.push(h);
        }
        let norm = dot(w, w).sqrt();
        let next = slot(&mut self.basis, j + 1, n);
        let inverse = if norm > 0.0 { 1.0 / norm } else { 0.0 };
        next.iter_mut().zip(&self.residual).for_each(|(v, w)| *v = w * inverse);
        for (i, [c, s]) in self.rotations.iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            (column[i], column[i + 1]) = (c * a + s * b, c * b - s * a);
        }
        let length = column[j].hypot(norm);
        let [c, s] = if length > 0.0 { [column[j] / length, norm / length] } else { [1.0, 0.0] };
        column[j] = length;
        self.columns.push(column);
        self.rotations.push([c, s]);
        let last = self.g[j];
        self.g[j] = c * last;
        self.g.push(-s * last);
        (s * last).abs()
    }

    /// Adds the best combination of the first `m` directions to `x`.
    fn add_solution(&mut self, m: usize, x: &mut [f64]) {
        let mut y = self.g[..m].to_vec();
        for i in (0..m).rev() {
            let known: f64 = (i + 1..m).map(|k| self.columns[k][i] * y[k]).sum();
            let pivot = self.columns[i][i];
            y[i] = if pivot == 0.0 { 0.0 } else { (y[i] - known) / pivot };
        }
        for (z, y) in self.directions.iter().zip(&y) {
            x.iter_mut().zip(z).for_each(|(x, z)| *x += y * z);
        }
    }
}

/// Total number of iterations expected at the present rate of convergence.
fn expected(first: f64, now: f64, iterations: usize, tolerance: f64) -> f64 {
    let rate = (now / first).ln();
    if rate < 0.0 { iterations as f64 * (tolerance / first).ln() / rate } else { f64::INFINITY }
}

fn slot(list: &mut Vec<Vec<f64>>, k: usize, n: usize) -> &mut Vec<f64> {
    if list.len() <= k {
        list.resize_with(k + 1, Vec::new);
    }
    list[k].resize(n, 0.0);
    &mut list[k]
}

/// Four sums side by side: the order is fixed, and the processor can overlap them.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a4.remainder().iter().zip(b4.remainder()).map(|(a, b)| a * b).sum();
    let mut s = [0.0; 4];
    for (a, b) in a4.zip(b4) {
        for k in 0..4 {
            s[k] += a[k] * b[k];
        }
    }
    (s[0] + s[1]) + (s[2] + s[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::super::testing::{laplacian, scattered};
    use super::*;
    use crate::linalg::SymmetricMatrix;

    /// The residual is what it says, and without preconditioner as many iterations as distinct
    /// eigenvalues suffice.
    #[test]
    fn as_many_iterations_as_there_are_different_eigenvalues_solve_a_system() {
        let mut a = SymmetricMatrix::from_groups(60, (0..60u32).map(|i| [i])).unwrap();
        for i in 0..60 {
            a.add_group(&[i], &[[2.0, -3.0, 5.0][i as usize % 3]]).unwrap();
        }
        let rhs = scattered(60);
        let mut x = vec![0.0; 60];
        let done = Gmres::default().solve(&mut (&a).into(), |_| (), &rhs, &mut x, (1e-13, 10));
        assert!(done.converged && done.iterations == 3, "{done:?}");
        for i in 0..60 {
            assert!((x[i] - rhs[i] / [2.0, -3.0, 5.0][i % 3]).abs() < 1e-13);
        }
    }

    #[test]
    fn more_iterations_than_are_kept_converge_through_restarts() {
        let a = laplacian(24, 0.05);
        let rhs = scattered(a.order());
        let mut x = vec![0.0; a.order()];
        let mut method = Gmres::default();
        let done = method.solve(&mut (&a).into(), |_| (), &rhs, &mut x, (1e-8, 500));
        assert!(done.converged && done.iterations > RESTART, "{done:?}");
        let mut r = vec![0.0; a.order()];
        a.multiply(&x, &mut r);
        r.iter_mut().zip(&rhs).for_each(|(r, b)| *r -= b);
        let relative = (dot(&r, &r) / dot(&rhs, &rhs)).sqrt();
        assert!(
            (relative - done.residual).abs() < 1e-3 * relative && relative <= 1e-8,
            "{relative:e}, {done:?}"
        );
        // A start that is the solution needs none.
        assert_eq!(method.solve(&mut (&a).into(), |_| (), &rhs, &mut x, (1e-8, 500)).iterations, 0);
    }

    #[test]
    fn a_hopeless_iteration_is_given_up_early_and_says_so() {
        let a = laplacian(40, 0.0);
        let rhs = scattered(a.order());
        let mut x = vec![0.0; a.order()];
        let done = Gmres::default().solve(&mut (&a).into(), |_| (), &rhs, &mut x, (1e-10, 8));
        assert!(!done.converged && done.iterations <= 8 && done.residual > 1e-10, "{done:?}");
        let zero = Gmres::default().solve(
            &mut (&a).into(),
            |_| (),
            &vec![0.0; a.order()],
            &mut x,
            (1e-10, 8),
        );
        assert!(zero.converged && x.iter().all(|v| *v == 0.0));
    }
}
