//! Table 1.1 of the book, the length of an ellipse by delta functions, with more rows: every delta function of `levelset::Delta`, signed
//! distance and not, square and crooked meshes; and the smeared one over its width, cut-off function and norm.
//!
//!     cargo run --release --example delta -- FOLDER
//!
//! writes `delta.csv` and `width.csv` there: the mean of the absolute relative errors over random orientations and centres.

#![allow(clippy::print_stdout, reason = "an example says what it does")]

use immersa::base::{Error, Result, parallel};
use immersa::fem::{Element, Space};
use immersa::levelset::{Delta, Ellipse, Kernel, Norm, Smeared, Width, signed_distance};
use immersa::mesh::{Diagonals, Mesh, Point, rectangle};
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

/// Smereka's ellipse and its length.
const AXES: [f64; 2] = [1.5, 0.75];
const LENGTH: f64 = 7.26633616541076;
/// Orientations and centres.
const PLACES: usize = 50;
/// Distances of the P2 nodes: half the edges.
const STEPS: [f64; 6] = [0.2, 0.1, 0.05, 0.025, 0.0125, 0.00625];
/// The half-width of the smeared delta functions of the first table, over that distance.
const WIDTH: f64 = 1.5;

/// Numbers in [0, 1) that are the same in every run (Knuth's MMIX generator).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Squares cut into two over [-2, 2]^2, with P2 nodes `step` apart; crooked, with inner vertices moved by up to 0.2 edges in each direction.
fn mesh(step: f64, crooked: bool) -> Result<Arc<Mesh<2>>> {
    let n = (2.0 / step).round() as usize;
    let regular = rectangle([-2.0; 2], [2.0; 2], [n, n], Diagonals::Right)?;
    if !crooked {
        return Ok(Arc::new(regular));
    }
    let (mut random, most) = (Random(7), 0.2 * 2.0 * step);
    let mut moved = |x: &Point<2>| {
        let by = Point::<2>::new(random.between(-most, most), random.between(-most, most));
        if x.iter().all(|c| c.abs() < 2.0 - 1e-9) { x + by } else { *x }
    };
    let points = regular.points().iter().map(&mut moved).collect();
    Ok(Arc::new(Mesh::new(points, (0..regular.cell_count()).flat_map(|c| regular.cell(c).to_vec()).collect())?))
}

/// What the ellipse is the zero set of.
#[derive(Clone, Copy)]
enum Function {
    Distance,
    /// `x^2/a^2 + y^2/b^2 - 1` in its own axes: slopes from 1.3 to 2.7 on it.
    Quadratic,
}

/// The level sets of the ellipse in its places.
fn level_sets<'a>(
    space: &'a Space<2>,
    function: Function,
    places: usize,
) -> impl Iterator<Item = Result<Vec<f64>>> + 'a {
    let mut random = Random(2006);
    (0..places).map(move |_| {
        let angle = random.between(0.0, 180.0);
        let centre = Point::<2>::new(random.between(-0.2, 0.2), random.between(-0.2, 0.2));
        let ellipse = Ellipse::new(centre, Point::<2>::from(AXES), angle)?;
        Ok(match function {
            Function::Distance => signed_distance(space, &ellipse),
            Function::Quadratic => {
                let (s, c) = angle.to_radians().sin_cos();
                space.interpolate(|x| {
                    let d = x - centre;
                    let (u, v) = (c * d[0] + s * d[1], c * d[1] - s * d[0]);
                    (u / AXES[0]).powi(2) + (v / AXES[1]).powi(2) - 1.0
                })
            }
        })
    })
}

/// The mean of the absolute relative errors of the delta functions.
fn errors(space: &Space<2>, function: Function, places: usize, deltas: &[Delta]) -> Result<Vec<f64>> {
    let mut sums = vec![0.0; deltas.len()];
    for phi in level_sets(space, function, places) {
        let phi = phi?;
        let mut found = vec![Ok(0.0); deltas.len()];
        parallel::fill(&mut found, 1, |first, part| {
            part.iter_mut().enumerate().for_each(|(i, length)| *length = deltas[first + i].measure(space, &phi));
        });
        for (sum, length) in sums.iter_mut().zip(found) {
            *sum += (length? / LENGTH - 1.0).abs() / places as f64;
        }
    }
    Ok(sums)
}

fn smeared(kernel: Kernel, norm: Norm, thickness: f64) -> Delta {
    Delta::Smeared(Smeared { kernel, width: Width::Renormalised(norm), thickness, degree: 6 })
}

/// The rows of the first table for one kind of mesh.
fn compare(crooked: bool, out: &mut String) -> Result<()> {
    let names = ["smereka1", "renormalised", "smereka2", "towers", "cut"];
    for (function, name) in [(Function::Distance, "distance"), (Function::Quadratic, "quadratic")] {
        let mut last = [f64::NAN; 5];
        for step in STEPS {
            let space = Space::new(&mesh(step, crooked)?, Element::P2);
            let renormalised = smeared(Kernel::Cosine, Norm::L2, WIDTH * step);
            let deltas = [Delta::Smereka1, renormalised, Delta::Smereka2, Delta::Towers, Delta::Cut];
            let errors = errors(&space, function, PLACES, &deltas)?;
            for (k, error) in errors.into_iter().enumerate() {
                let (mesh, order) = (if crooked { "crooked" } else { "squares" }, (last[k] / error).log2());
                let _ = writeln!(out, "{mesh},{name},{},{step},{error:.3e},{order:.2}", names[k]);
                println!("{mesh} {name} {} {step}: {error:.3e} {order:.2}", names[k]);
                last[k] = error;
            }
        }
    }
    Ok(())
}

/// The smeared delta over its width, cut-off function and norm.
fn widths(out: &mut String) -> Result<()> {
    for step in [0.05, 0.025, 0.0125] {
        let space = Space::new(&mesh(step, false)?, Element::P2);
        let mut deltas = Vec::new();
        let mut names = Vec::new();
        for width in [1.0, 1.5, 2.0, 3.0, 4.0, 6.0] {
            for (kernel, a) in [(Kernel::Cosine, "cosine"), (Kernel::Hat, "hat")] {
                for (norm, b) in [(Norm::L2, "l2"), (Norm::L1, "l1")] {
                    deltas.push(smeared(kernel, norm, width * step));
                    names.push(format!("{a},{b},{width}"));
                }
            }
        }
        let both = [Function::Distance, Function::Quadratic].map(|f| errors(&space, f, PLACES, &deltas));
        let [distance, quadratic] = both;
        for ((name, d), q) in names.iter().zip(distance?).zip(quadratic?) {
            let _ = writeln!(out, "{name},{step},{d:.3e},{q:.3e}");
            println!("{name} {step}: {d:.3e} {q:.3e}");
        }
    }
    Ok(())
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| ".".into());
    let write = |name: &str, text: &str| {
        let path = Path::new(&folder).join(name);
        let failed =
            |e: std::io::Error| Error::input("a table cannot be written").at(path.display().to_string()).value(e);
        std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&path, text)).map_err(failed)
    };
    let mut table = String::from("mesh,phi,delta,h,error,order\n");
    compare(false, &mut table)?;
    compare(true, &mut table)?;
    write("delta.csv", &table)?;
    let mut table = String::from("kernel,norm,eps over h,h,distance,quadratic\n");
    widths(&mut table)?;
    write("width.csv", &table)
}
