use proptest::prelude::*;

use super::super::testing::{laplacian, scattered, stokes};
use super::*;
use crate::base::Kind;
use crate::linalg::Operator;
use crate::linalg::gmres::Gmres;

fn factored(matrix: &SymmetricMatrix, ordering: Ordering) -> Factor {
    let mut factor = Factor::analyse(matrix, ordering).unwrap();
    factor.refactor(matrix).unwrap();
    factor
}

/// The relative residual of the bare substitution, and the report of the refined solution.
fn residuals(matrix: &SymmetricMatrix, factor: &mut Factor) -> (f64, SolveReport) {
    let exact = scattered(matrix.order());
    let mut b = vec![0.0; matrix.order()];
    matrix.multiply(&exact, &mut b);
    let mut x = b.clone();
    factor.substitute(&mut x);
    let bare = factor.update_residual(matrix, &b, &x);
    (bare, factor.solve(matrix, &b, &mut x).unwrap())
}

#[test]
fn the_laplacian_is_solved_to_rounding() {
    for n in [1, 2, 3, 30] {
        let a = laplacian(n, 0.0);
        let mut factor = factored(&a, Ordering::plain(&a).unwrap());
        let (bare, report) = residuals(&a, &mut factor);
        assert!(bare < 1e-13, "{n}: {bare:e}");
        assert!(report.residual < 1e-14 && report.refinements == 0, "{n}: {report:?}");
    }
}

#[test]
fn the_solution_is_the_discrete_eigenfunction() {
    // The five-point Laplacian of sin(pi i h) sin(pi j h), h = 1 / (n + 1), is 8 sin^2(pi h / 2)
    // times itself.
    let n = 25;
    let h = std::f64::consts::PI / (n as f64 + 1.0);
    let mode: Vec<f64> = (0..n * n)
        .map(|k| ((k % n + 1) as f64 * h).sin() * ((k / n + 1) as f64 * h).sin())
        .collect();
    let a = laplacian(n, 0.0);
    let mut x = vec![0.0; n * n];
    factored(&a, Ordering::plain(&a).unwrap()).solve(&a, &mode, &mut x).unwrap();
    let eigenvalue = 8.0 * (0.5 * h).sin().powi(2);
    assert!(x.iter().zip(&mode).all(|(x, m)| (x * eigenvalue - m).abs() < 1e-13));
}

#[test]
fn saddle_points_need_no_refinement_in_their_own_ordering() {
    for (mass, viscosity) in [(200.0, 0.01), (0.0, 1.0), (1e4, 1e-5)] {
        for penalty in [1e-6, 1e-10, 1e-14, 0.0] {
            let (a, first) = stokes(24, mass, viscosity, penalty);
            let mut factor = factored(&a, Ordering::saddle_point(&a, first).unwrap());
            let (bare, report) = residuals(&a, &mut factor);
            assert!(
                bare < 1e-13,
                "mass {mass}, viscosity {viscosity}, penalty {penalty:e}: {bare:e}"
            );
            assert!(report.residual < 1e-13 && report.refinements == 0, "{report:?}");
        }
    }
}

#[test]
fn a_saddle_point_in_a_plain_ordering_loses_digits_and_refinement_brings_them_back() {
    let (a, _) = stokes(24, 200.0, 0.01, 1e-10);
    let mut factor = factored(&a, Ordering::plain(&a).unwrap());
    let (bare, report) = residuals(&a, &mut factor);
    assert!(bare > 1e-12, "the test shows nothing: {bare:e}");
    assert!(report.residual < 1e-10, "{report:?}");
}

#[test]
fn a_new_factorisation_of_the_same_values_has_the_same_bits() {
    let (a, first) = stokes(10, 1.0, 0.1, 1e-10);
    let mut factor = factored(&a, Ordering::saddle_point(&a, first).unwrap());
    let bits = |factor: &Factor| match &factor.values {
        Values::Double(values) => values.iter().map(|v| v.to_bits()).collect::<Vec<_>>(),
        _ => Vec::new(),
    };
    let before = bits(&factor);
    let mut other = a.clone();
    other.values_mut().iter_mut().for_each(|v| *v *= 1.5);
    factor.refactor(&other).unwrap();
    assert_ne!(bits(&factor), before);
    factor.refactor(&a).unwrap();
    assert_eq!(bits(&factor), before);
    assert_eq!(bits(&factored(&a, Ordering::saddle_point(&a, first).unwrap())), before);
}

#[test]
fn several_right_hand_sides_are_solved_at_once() {
    let a = laplacian(12, 0.5);
    let n = a.order();
    let mut factor = factored(&a, Ordering::plain(&a).unwrap());
    let rhs = scattered(3 * n);
    let mut together = vec![0.0; 3 * n];
    let report = factor.solve(&a, &rhs, &mut together).unwrap();
    assert!(report.residual < 1e-14);
    for k in 0..3 {
        let mut alone = vec![0.0; n];
        factor.solve(&a, &rhs[k * n..(k + 1) * n], &mut alone).unwrap();
        assert!(alone.iter().zip(&together[k * n..]).all(|(x, y)| (x - y).abs() < 1e-13));
    }
    let mut x = vec![1.0; n];
    let report = factor.solve(&a, &vec![0.0; n], &mut x).unwrap();
    assert_eq!((report.residual, x), (0.0, vec![0.0; n]));
}

#[test]
fn a_slightly_stale_factor_still_solves_and_a_wrong_one_is_refused() {
    let a = laplacian(10, 1.0);
    let mut factor = factored(&a, Ordering::plain(&a).unwrap());
    let rhs = scattered(100);
    let mut x = vec![0.0; 100];
    let report = factor.solve(&laplacian(10, 1.0 + 1e-3), &rhs, &mut x).unwrap();
    assert!(report.refinements > 1 && report.residual <= TOLERANCE, "{report:?}");
    let error = factor.solve(&laplacian(10, 3.0), &rhs, &mut x).unwrap_err();
    assert_eq!(error.kind(), Kind::Computation);
    for part in ["100 unknowns", "relative residual", "remedy"] {
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn wrong_patterns_and_lengths_are_errors() {
    let (a, b) = (laplacian(5, 1.0), laplacian(6, 1.0));
    let ordering = Ordering::plain(&a).unwrap();
    assert!(Factor::analyse(&b, ordering.clone()).is_err());
    let mut factor = Factor::analyse(&a, ordering).unwrap();
    let mut x = vec![0.0; 25];
    assert_eq!(
        factor.solve(&a, &[1.0; 25], &mut x).unwrap_err().kind(),
        Kind::Internal,
        "not factorised"
    );
    assert_eq!(factor.refactor(&b).unwrap_err().kind(), Kind::Internal);
    factor.refactor(&a).unwrap();
    assert!(factor.solve(&b, &[1.0; 25], &mut x).is_err());
    assert!(factor.solve(&a, &[1.0; 24], &mut x[..24]).is_err());
    assert!(factor.solve(&a, &[1.0; 50], &mut x).is_err());
}

#[test]
fn what_is_not_finite_or_singular_is_an_error() {
    let a = laplacian(5, 1.0);
    let mut factor = factored(&a, Ordering::plain(&a).unwrap());
    let mut x = vec![0.0; 25];
    let mut rhs = vec![1.0; 25];
    rhs[7] = f64::NAN;
    assert_eq!(factor.solve(&a, &rhs, &mut x).unwrap_err().place(), "unknown 7");
    let mut broken = a.clone();
    broken.add_group(&[9], &[f64::INFINITY]).unwrap();
    let error = factor.refactor(&broken).unwrap_err();
    assert_eq!((error.kind(), error.place()), (Kind::Computation, "unknown 9"));
    assert!(factor.solve(&a, &[1.0; 25], &mut x).is_err(), "the factor is no longer valid");
    let mut singular = a.clone();
    singular.zero();
    let error = factor.refactor(&singular).unwrap_err();
    assert!(error.what().contains("singular"), "{error}");
    factor.refactor(&a).unwrap();
    assert!(factor.solve(&a, &[1.0; 25], &mut x).is_ok());
}

#[test]
fn a_factor_that_does_not_fit_is_refused_with_its_size() {
    let a = laplacian(30, 0.0);
    let ordering = Ordering::plain(&a).unwrap();
    let bytes = Factor::analyse_within(&a, ordering.clone(), None).unwrap().bytes();
    assert!(bytes > 8 * 900 && bytes < 1_000_000, "{bytes}");
    assert!(Factor::analyse_within(&a, ordering.clone(), Some(bytes)).is_ok());
    let error = Factor::analyse_within(&a, ordering, Some(bytes - 1)).err().unwrap();
    assert_eq!(error.kind(), Kind::Computation);
    for part in ["900 unknowns", "kB are needed", "remedy"] {
        assert!(error.to_string().contains(part), "{error}");
    }
}

#[test]
fn norms_of_large_vectors_do_not_overflow() {
    assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
    assert_eq!(norm(&[]), 0.0);
    assert!(norm(&[1.0, f64::NAN]).is_nan());
}

/// A random `[A, B^T; B, -C]` with `A` and `C` diagonally dominant, and the number of rows of `A`.
fn quasi_definite() -> impl Strategy<Value = (SymmetricMatrix, usize)> {
    (1_usize..60, 0_usize..40).prop_flat_map(|(m, k)| {
        let n = m + k;
        let links = proptest::collection::vec((0..n as u32, 0..n as u32, -1.0..1.0), 0..4 * n);
        links.prop_map(move |links| {
            let groups = || links.iter().map(|&(i, j, _)| [i, j]);
            let mut a = SymmetricMatrix::from_groups(n, groups()).unwrap();
            for &(i, j, v) in links.iter().filter(|&&(i, j, _)| i != j) {
                // Inside a diagonal block, keep the dominance; across blocks anything goes.
                let sign = |i: u32| if (i as usize) < m { 1.0 } else { -1.0 };
                let d: f64 = if sign(i) == sign(j) { v } else { 0.0 };
                a.add_group(&[i, j], &[sign(i) * d.abs(), v, v, sign(j) * d.abs()]).unwrap();
            }
            for i in 0..n {
                a.add_group(&[i as u32], &[if i < m { 1.0 } else { -0.1 }]).unwrap();
            }
            (a, m)
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn quasi_definite_matrices_are_solved_in_any_ordering((a, first) in quasi_definite()) {
        for ordering in [Ordering::plain(&a).unwrap(), Ordering::saddle_point(&a, first).unwrap()] {
            let (bare, report) = residuals(&a, &mut factored(&a, ordering));
            prop_assert!(bare < 1e-11, "{bare:e}");
            prop_assert!(report.residual < 1e-13, "{report:?}");
        }
    }
}

/// A dense matrix has columns of length n, n - 1, ... 1.
#[test]
fn the_operations_of_a_dense_factor_are_counted_exactly() {
    let n = 40;
    let all: Vec<u32> = (0..n).collect();
    let mut a = SymmetricMatrix::from_groups(n as usize, [&all].into_iter()).unwrap();
    for i in 0..n {
        a.add_group(&[i], &[1.0]).unwrap();
    }
    let factor = Factor::analyse(&a, Ordering::plain(&a).unwrap()).unwrap();
    assert_eq!(factor.operations(), f64::from(n * (n + 1) * (2 * n + 1) / 6));
}

/// A skew part on the pattern of a matrix: `N_ij = -N_ji` from scattered numbers of this size, on
/// the first unknowns.
struct Skew {
    upper: SymmetricMatrix,
}

impl Skew {
    fn new(matrix: &SymmetricMatrix, size: f64, first: usize) -> Skew {
        let mut upper = matrix.clone();
        let numbers = scattered(upper.nonzeros());
        let pointers = matrix.upper().indptr().raw_storage().to_vec();
        let values = upper.values_mut();
        values.iter_mut().zip(&numbers).for_each(|(v, n)| *v = size * n);
        for j in 0..matrix.order() {
            // No diagonal, and no multipliers.
            values[pointers[j + 1] - 1] = 0.0;
            if j >= first {
                values[pointers[j]..pointers[j + 1]].fill(0.0);
            }
        }
        Skew { upper }
    }
}

impl Addition for Skew {
    fn add_product(&mut self, x: &[f64], y: &mut [f64]) {
        for j in 0..x.len() {
            let (rows, values) = self.upper.column(j);
            for (&i, v) in rows.iter().zip(values) {
                y[i] += v * x[j];
                y[j] -= v * x[i];
            }
        }
    }
    fn add_halves(&self, _: &mut SymmetricMatrix, skew: &mut SymmetricMatrix) -> Result<()> {
        skew.add_scaled(1.0, &self.upper)
    }
}

/// A factor `L D U` preconditions a saddle point with a skew part, as large as the symmetric one and
/// a tenth of it, to rounding in some iterations; the symmetric factor, to which the skew part is
/// unknown, takes many times as many.
#[test]
fn a_matrix_with_a_skew_part_is_solved_in_few_iterations() {
    let (matrix, first) = stokes(12, 100.0, 1.0, 0.0);
    let scale = matrix.values().iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for (size, most) in [(0.1, 3), (1.0, 4)] {
        let mut skew = Skew::new(&matrix, size * scale, first);
        let exact = scattered(matrix.order());
        let mut b = vec![0.0; exact.len()];
        matrix.multiply(&exact, &mut b);
        skew.add_product(&exact, &mut b);
        let mut iterations = |unsymmetric: bool| {
            let factor = Factor::plan(&matrix, Ordering::saddle_point(&matrix, first).unwrap());
            let mut factor = factor.unwrap();
            if unsymmetric {
                factor = factor.unsymmetric();
            }
            factor.refactor_with(&matrix, Some(&skew)).unwrap();
            let mut x = vec![0.0; exact.len()];
            let mut operator = Operator { matrix: &matrix, addition: Some(&mut skew) };
            let precondition = |v: &mut [f64]| factor.substitute(v);
            let done =
                Gmres::default().solve(&mut operator, precondition, &b, &mut x, (1e-12, 200));
            let difference: Vec<f64> = x.iter().zip(&exact).map(|(x, e)| x - e).collect();
            let error = norm(&difference) / norm(&exact);
            assert!(!done.converged || error < 1e-7, "{size}: {error:e}");
            (done.iterations, done.converged)
        };
        let ([few, many], converged) = {
            let (few, converged) = iterations(true);
            ([few, iterations(false).0], converged)
        };
        assert!(converged && few <= most && many > 5 * few, "{size}: {few} and {many}");
    }
}

/// Without a skew part `L D U` is the factor in single precision of the symmetric matrix, and the
/// same values have the same bits again.
#[test]
fn a_symmetric_matrix_has_the_same_factor_either_way() {
    let (matrix, first) = stokes(12, 100.0, 1.0, 0.0);
    let plan = || Factor::plan(&matrix, Ordering::saddle_point(&matrix, first).unwrap()).unwrap();
    let [mut whole, mut symmetric] =
        [plan().unsymmetric(), plan().with_precision(Precision::Single)];
    assert!(whole.size().entries == 2 * whole.nonzeros());
    let b = scattered(matrix.order());
    let solve = |factor: &mut Factor| {
        factor.refactor(&matrix).unwrap();
        let mut x = b.clone();
        factor.substitute(&mut x);
        x
    };
    let [x, again, y] = [solve(&mut whole), solve(&mut whole), solve(&mut symmetric)];
    assert_eq!(x, again);
    let difference: Vec<f64> = x.iter().zip(&y).map(|(x, y)| x - y).collect();
    assert!(norm(&difference) < 1e-3 * norm(&y), "{:e}", norm(&difference) / norm(&y));
}
