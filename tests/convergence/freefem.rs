//! The same membrane on the same meshes with the same steps as FreeFEM: outputs recorded with the twins of `examples/`, and a live run.

use crate::membrane::{Case, advance, half_chords};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Rows `t, a_h, a_v` of a twin's table.
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

/// Largest difference of the half-chords from FreeFEM's at `times`, and our half-chord along x at the last.
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
/// The tolerances are measured; they are far below what the two programs are required to agree to, 2e-4 and 1e-3.
fn compare(folder: &str, n: usize, step: &str, tolerance: f64) -> f64 {
    let modulus = if folder == "listing" { 1.0 } else { 10.0 };
    let case = Case { n, modulus, dt: step.parse().unwrap(), ..Case::LISTING };
    let file = example(folder).join(format!("data/freefem_n{n}_dt{step}.csv"));
    let rows = table(&std::fs::read_to_string(file).unwrap());
    let (worst, chord) = difference(case, &rows, &[0.1, 0.2, 0.4]);
    println!("FreeFEM, lambda = {modulus}, n = {n}, dt = {step}: largest difference of half-chords {worst:.1e}");
    assert!(worst < tolerance, "n = {n}, dt = {step}: {worst:e}");
    chord
}

/// Two steps make the value at step zero: FreeFEM's is 0.7219.
#[test]
fn the_listing_at_thirty_squares_and_its_limit_of_small_steps() {
    let (coarse, fine) = (compare("listing", 30, "5e-3", 9e-6), compare("listing", 30, "2.5e-3", 9e-6));
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
    let out = folder.path().join("twin.csv");
    let run = Command::new("FreeFem++")
        .args(["-nw", "-v", "0", "twin.edp", "-n", "30", "-dt", "5e-3", "-tmax", "0.1", "-out"])
        .arg(&out)
        .current_dir(example("listing"))
        .output();
    let text = match run {
        Ok(done) => {
            assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stdout));
            println!("FreeFEM ran here");
            std::fs::read_to_string(&out).unwrap()
        }
        Err(reason) => {
            println!("FreeFem++ did not start ({reason}): its recorded output is taken");
            std::fs::read_to_string(example("listing").join("data/freefem_n30_dt5e-3.csv")).unwrap()
        }
    };
    let (worst, _) = difference(Case::LISTING, &table(&text), &[0.1]);
    println!("FreeFEM, live, lambda = 1, n = 30, dt = 5e-3, t = 0.1: {worst:.1e}");
    assert!(worst < 2e-4);
}
