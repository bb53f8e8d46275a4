//! The same membrane on the same meshes with the same steps as FreeFEM: outputs recorded with the
//! twins of `examples/`, and a live run.

use crate::membrane::{Case, advance, half_chords};
use immersa::scene::Scene;
use immersa::studies::{self, Twin};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Rows of time and the two half-chords of a twin's table, which are its first columns.
fn table(text: &str) -> Vec<[f64; 3]> {
    let number = |v: Option<&str>| v.unwrap().parse::<f64>().unwrap();
    text.lines()
        .skip(1)
        .map(|line| {
            let mut columns = line.split(',');
            [(); 3].map(|()| number(columns.next()))
        })
        .collect()
}

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

/// Largest difference of the half-chords from FreeFEM's at `times`, and our half-chord along x at
/// the last.
fn difference(case: Case, rows: &[[f64; 3]], times: &[f64]) -> (f64, f64) {
    let mut sim = case.simulation();
    let mut worst: f64 = 0.0;
    for &t in times {
        advance(&mut sim, t);
        let row = rows.iter().find(|r| (r[0] - t).abs() < 1e-9).unwrap();
        let [a, b] = half_chords(&sim);
        println!("  t = {t}: {a:.6} {b:.6}, FreeFEM {:.6} {:.6}", row[1], row[2]);
        worst = worst.max((a - row[1]).abs()).max((b - row[2]).abs());
    }
    (worst, half_chords(&sim)[0])
}

/// Compares with `data/freefem_n<n>_dt<dt>.csv` and gives our half-chord along x at t = 0.4.
///
/// The tolerances are measured; they are far below what the two programs are required to agree to,
/// 2e-4 and 1e-3.
fn compare(folder: &str, n: usize, step: &str, tolerance: f64) -> f64 {
    let modulus = if folder == "listing" { 1.0 } else { 10.0 };
    let case = Case { n, modulus, dt: step.parse().unwrap(), ..Case::LISTING };
    let file = example(folder).join(format!("data/freefem_n{n}_dt{step}.csv"));
    let rows = table(&std::fs::read_to_string(file).unwrap());
    let (worst, chord) = difference(case, &rows, &[0.1, 0.2, 0.4]);
    println!(
        "FreeFEM, lambda = {modulus}, n = {n}, dt = {step}: largest difference of half-chords \
         {worst:.1e}"
    );
    assert!(worst < tolerance, "n = {n}, dt = {step}: {worst:e}");
    chord
}

/// Two steps make the value at step zero: FreeFEM's is 0.7219.
#[test]
fn the_listing_at_thirty_squares_and_its_limit_of_small_steps() {
    let (coarse, fine) =
        (compare("listing", 30, "5e-3", 9e-6), compare("listing", 30, "2.5e-3", 9e-6));
    let limit = 2.0 * fine - coarse;
    println!("Half-chord along x at t = 0.4, extrapolated to step zero: {limit:.5}");
    assert!((limit - 0.7219).abs() < 1e-4);
}

#[test]
fn the_listing_at_sixty_squares() {
    compare("listing", 60, "5e-3", 9e-6);
}

#[test]
fn the_stiff_membrane_at_thirty_squares() {
    compare("relaxing-ellipse", 30, "1.25e-3", 3.5e-5);
}

/// The longest of these tests: 320 steps of 33 000 unknowns.
#[test]
fn the_stiff_membrane_at_sixty_squares() {
    compare("relaxing-ellipse", 60, "1.25e-3", 3.5e-5);
}

/// Runs the twin where FreeFEM is installed, and takes its recorded output otherwise.
#[test]
fn freefem_live() {
    let folder = tempfile::tempdir().unwrap();
    let path = example("listing").join("scene.toml");
    let twin = Twin::read(&Twin::beside(&path)).unwrap();
    let scene = Scene::load(&path, twin.settings()).unwrap();
    let case = studies::Case::new(&twin, &scene).unwrap();
    let live = case.run(&twin.loops()[0], 0.1, 0, folder.path(), &AtomicBool::new(false)).unwrap();
    println!(
        "FreeFEM {}",
        if live.is_some() { "ran here" } else { "is not installed: its recorded output is taken" }
    );
    let table = live.unwrap_or_else(|| case.recorded().unwrap()).table;
    let column = |name: &str| table.column(name).unwrap();
    let (t, a, b) = (column("time"), column("membrane.horizontal"), column("membrane.vertical"));
    let rows: Vec<[f64; 3]> = (0..t.len()).map(|i| [t[i], a[i], b[i]]).collect();
    let (worst, _) = difference(Case::LISTING, &rows, &[0.1]);
    println!("FreeFEM, live, lambda = 1, n = 30, dt = 5e-3, t = 0.1: {worst:.1e}");
    assert!(worst < 2e-4);
}
