use super::super::testing::{scattered, stokes};
use super::super::{Change, LaggedFactor};
use super::*;

const CELLS: usize = 12;

/// Stokes flow of viscosity 1 in the plane: the inverse of the Schur complement is near that of the
/// mass matrix of the pressure.
fn case() -> (SymmetricMatrix, usize, Saddle) {
    let (matrix, first) = stokes(CELLS, 0.0, 1.0, 0.0);
    let multipliers = matrix.order() - first;
    let mut mass =
        SymmetricMatrix::from_groups(multipliers, (0..multipliers as u32).map(|i| [i])).unwrap();
    mass.values_mut().fill(1.0 / (CELLS * CELLS) as f64);
    let components = (0..first).map(|i| u8::from(2 * i >= first)).collect();
    (matrix, first, Saddle { components, operators: vec![mass] })
}

fn solver(kind: SolverKind) -> (SymmetricMatrix, LaggedFactor) {
    let (matrix, first, saddle) = case();
    let options = SolverOptions { kind: Some(kind), memory: None, ..SolverOptions::default() };
    let solver = LaggedFactor::choose(&matrix, first, options, 0.0, || Ok(saddle)).unwrap();
    (matrix, solver)
}

#[test]
fn iterations_with_every_factor_reach_the_residual_that_they_report() {
    let mut exact: Option<Vec<f64>> = None;
    for (kind, most) in [(SolverKind::Direct, 0), (SolverKind::Single, 3), (SolverKind::Schur, 160)]
    {
        let (matrix, mut solver) = solver(kind);
        let rhs = scattered(matrix.order());
        let mut x = vec![0.0; rhs.len()];
        let report = solver.solve(&matrix, Change::Lasting, &rhs, &mut x).unwrap();
        assert!(report.refactored && report.solve.residual <= 1e-10, "{kind}: {report:?}");
        assert!(report.solve.iterations <= most, "{kind}: {report:?}");
        let mut r = vec![0.0; rhs.len()];
        matrix.multiply(&x, &mut r);
        let square = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>();
        r.iter_mut().zip(&rhs).for_each(|(r, b)| *r -= b);
        let relative = (square(&r) / square(&rhs)).sqrt();
        assert!(
            (relative - report.solve.residual).abs() <= 1e-14 + 1e-3 * relative,
            "{kind}: {relative:e}"
        );
        let exact = exact.get_or_insert_with(|| x.clone());
        let largest = exact.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(x.iter().zip(&*exact).all(|(x, e)| (x - e).abs() < 1e-6 * largest), "{kind}");
        // The same system again, from its solution: nothing is left to do.
        let again = solver.solve(&matrix, Change::None, &rhs, &mut x).unwrap();
        assert!(!again.refactored && again.solve.iterations == 0, "{kind}: {again:?}");
    }
}

#[test]
fn an_iteration_that_does_not_converge_is_an_error() {
    let (matrix, first, mut saddle) = case();
    // An operator that has nothing to do with the Schur complement.
    for (k, v) in saddle.operators[0].values_mut().iter_mut().enumerate() {
        *v = if k % 2 == 0 { 1e-8 } else { 1e8 };
    }
    let options =
        SolverOptions { kind: Some(SolverKind::Schur), memory: None, ..SolverOptions::default() };
    let mut solver = LaggedFactor::choose(&matrix, first, options, 1e-10, || Ok(saddle)).unwrap();
    let rhs = scattered(matrix.order());
    let error = solver
        .solve(&matrix, Change::Lasting, &rhs, &mut vec![0.0; rhs.len()])
        .unwrap_err()
        .to_string();
    for part in ["did not converge", "iterations", "relative residual", "remedy"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn a_factor_in_single_precision_does_not_depend_on_the_units() {
    for unit in [1e-30, 1e30] {
        let (mut matrix, first, _) = case();
        matrix.values_mut().iter_mut().for_each(|v| *v *= unit);
        let mut factor =
            Factor::plan(&matrix, Ordering::saddle_point(&matrix, first).unwrap()).unwrap();
        factor = factor.with_precision(Precision::Single);
        factor.refactor(&matrix).unwrap();
        let rhs = scattered(matrix.order());
        let mut x = vec![0.0; rhs.len()];
        let report = factor.solve(&matrix, &rhs, &mut x).unwrap();
        assert!(report.residual < 1e-9 && report.refinements <= 3, "{unit:e}: {report:?}");
    }
}

#[test]
fn less_memory_takes_the_next_way_and_none_is_refused() {
    let (matrix, first, saddle) = case();
    let choose = |memory: usize| {
        let options =
            SolverOptions { kind: None, memory: Some(memory), ..SolverOptions::default() };
        LaggedFactor::choose(&matrix, first, options, 0.0, || Ok(saddle.clone()))
    };
    let large = choose(usize::MAX).unwrap();
    assert_eq!(large.kind(), SolverKind::Direct);
    assert_eq!(choose(large.size().bytes - 1).unwrap().kind(), SolverKind::Single);
    let error = choose(1000).err().unwrap().to_string();
    assert!(error.contains("1.0 kB may be taken") && error.contains("by schur"), "{error}");
}
