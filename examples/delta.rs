//! Table 1.1 of the book, the length of an ellipse by delta functions, with more rows: every delta
//! function of `levelset::Delta`, signed distance and not, square and crooked meshes; and the
//! smeared one over its width, cut-off function and norm.
//!
//!     cargo run --release --example delta -- --out FOLDER
//!
//! writes `delta.csv`, `width.csv`, the same as Markdown, and a chart there: the means of the
//! absolute relative errors over random orientations and centres.

#![allow(clippy::print_stdout, reason = "an example says what it does")]

use immersa::base::{Error, Result, parallel};
use immersa::fem::{Element, Space};
use immersa::levelset::{Delta, Ellipse, Kernel, Norm, Smeared, Width, signed_distance};
use immersa::mesh::{Diagonals, Mesh, Point, rectangle};
use immersa::output::{Chart, Curve, Stroke, write_file};
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
/// Degree of the quadrature of smeared delta functions.
const DEGREE: usize = 12;
/// The columns of Table 1.1: Smereka's first, renormalisation, Smereka's second.
const PUBLISHED: [[f64; 6]; 3] = [
    [9.38e-3, 2.23e-3, 8.12e-4, 2.71e-4, 7.58e-5, 3.04e-5],
    [1.5e-1, 5e-3, 1.3e-3, 3e-4, 8e-5, 2e-5],
    [2.68e-3, 5.49e-4, 1.32e-4, 2.90e-5, 7.79e-6, 1.84e-6],
];
const NAMES: [&str; 5] = ["Smereka 1", "renormalised", "Smereka 2", "Towers", "cut"];

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

/// Squares cut into two over [-2, 2]^2, with P2 nodes `step` apart; crooked, with inner vertices
/// moved by up to 0.2 edges in each direction.
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
    Ok(Arc::new(Mesh::new(
        points,
        (0..regular.cell_count()).flat_map(|c| regular.cell(c).to_vec()).collect(),
    )?))
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
fn errors(
    space: &Space<2>,
    function: Function,
    places: usize,
    deltas: &[Delta],
) -> Result<Vec<f64>> {
    let mut sums = vec![0.0; deltas.len()];
    for phi in level_sets(space, function, places) {
        let phi = phi?;
        let mut found = vec![Ok(0.0); deltas.len()];
        parallel::fill(&mut found, 1, |first, part| {
            part.iter_mut()
                .enumerate()
                .for_each(|(i, length)| *length = deltas[first + i].measure(space, &phi));
        });
        for (sum, length) in sums.iter_mut().zip(found) {
            *sum += (length? / LENGTH - 1.0).abs() / places as f64;
        }
    }
    Ok(sums)
}

fn smeared(kernel: Kernel, norm: Norm, thickness: f64) -> Delta {
    Delta::Smeared(Smeared { kernel, width: Width::Renormalised(norm), thickness, degree: DEGREE })
}

/// Errors of the five delta functions at all steps, on one kind of mesh with one kind of function.
struct Case {
    mesh: &'static str,
    phi: &'static str,
    errors: Vec<Vec<f64>>,
}

impl Case {
    fn new(crooked: bool, function: Function) -> Result<Case> {
        let mut found = Vec::new();
        for step in STEPS {
            let space = Space::new(&mesh(step, crooked)?, Element::P2);
            let renormalised = smeared(Kernel::Cosine, Norm::L2, WIDTH * step);
            let deltas =
                [Delta::Smereka1, renormalised, Delta::Smereka2, Delta::Towers, Delta::Cut];
            found.push(errors(&space, function, PLACES, &deltas)?);
            println!("crooked: {crooked}, {step}: {:.2e}", found[found.len() - 1][0]);
        }
        let phi = if matches!(function, Function::Distance) { "distance" } else { "quadratic" };
        Ok(Case { mesh: if crooked { "crooked" } else { "squares" }, phi, errors: found })
    }
    /// The order of delta function `k` from the step before `i`.
    fn order(&self, k: usize, i: usize) -> f64 {
        i.checked_sub(1).map_or(f64::NAN, |j| (self.errors[j][k] / self.errors[i][k]).log2())
    }
    /// Error and order, as a table shows them.
    fn cell(&self, k: usize, i: usize) -> String {
        let order = self.order(k, i);
        let order = if order.is_nan() { String::new() } else { format!(" ({order:.1})") };
        format!("{:.1e}{order}", self.errors[i][k])
    }
    fn write_csv(&self, out: &mut String) {
        for (k, name) in NAMES.iter().enumerate() {
            for (i, step) in STEPS.iter().enumerate() {
                let (error, order) = (self.errors[i][k], self.order(k, i));
                let _ = writeln!(
                    out,
                    "{},{},{name},{step},{error:.3e},{order:.2}",
                    self.mesh, self.phi
                );
            }
        }
    }
    /// All delta functions, one a column.
    fn markdown(&self) -> String {
        let mut out =
            format!("| h | {} |\n|---|{}\n", NAMES.join(" | "), "---|".repeat(NAMES.len()));
        for (i, step) in STEPS.iter().enumerate() {
            let cells: Vec<String> = (0..NAMES.len()).map(|k| self.cell(k, i)).collect();
            let _ = writeln!(out, "| {step} | {} |", cells.join(" | "));
        }
        out
    }
}

/// Table 1.1 beside ours: the renormalised delta of the quadratic function, Smereka's of the
/// distance.
fn published(distance: &Case, quadratic: &Case) -> String {
    let mut out = String::from("| h |");
    NAMES[..3].iter().for_each(|name| out.push_str(&format!(" {name}: book | ours |")));
    out.push_str("\n|---|---|---|---|---|---|---|\n");
    for (i, step) in STEPS.iter().enumerate() {
        let _ = write!(out, "| {step} |");
        for (k, case) in [distance, quadratic, distance].into_iter().enumerate() {
            let _ = write!(out, " {:.1e} | {} |", PUBLISHED[k][i], case.cell(k, i));
        }
        out.push('\n');
    }
    out
}

/// The errors over the step; with the quadratic function, where the delta functions differ most.
fn chart(case: &Case) -> String {
    let curves = |k: usize| case.errors.iter().map(|e| e[k]).collect::<Vec<f64>>();
    let ours: Vec<Vec<f64>> = (0..NAMES.len()).map(curves).collect();
    let mut all: Vec<Curve> = Vec::new();
    for (k, y) in ours.iter().enumerate() {
        all.push(Curve { name: NAMES[k], x: &STEPS, y, stroke: Stroke::Marked, colour: Some(k) });
    }
    for (k, y) in PUBLISHED.iter().enumerate() {
        all.push(Curve { name: "", x: &STEPS, y, stroke: Stroke::Dashed, colour: Some(k) });
    }
    let chart = Chart {
        x_label: "distance of the nodes h",
        y_label: "relative error of the length",
        log_x: true,
        log_y: true,
        curves: all,
        ..Chart::default()
    };
    chart.svg()
}

/// The smeared delta over its width, cut-off function and norm: as CSV and, of the finest step, as
/// Markdown.
fn widths() -> Result<[String; 2]> {
    let mut csv = String::from("eps over h,kernel,norm,h,distance,quadratic\n");
    let mut markdown = String::new();
    for step in [0.05, 0.025, 0.0125] {
        let space = Space::new(&mesh(step, false)?, Element::P2);
        markdown = String::from(
            "| eps/h | cosine, l2 | cosine, l1 | hat, l2 | hat, l1 |\n|---|---|---|---|---|\n",
        );
        for width in [1.0, 1.5, 2.0, 3.0, 4.0, 6.0] {
            let (mut deltas, mut names) = (Vec::new(), Vec::new());
            for (kernel, a) in [(Kernel::Cosine, "cosine"), (Kernel::Hat, "hat")] {
                for (norm, b) in [(Norm::L2, "l2"), (Norm::L1, "l1")] {
                    deltas.push(smeared(kernel, norm, width * step));
                    names.push(format!("{width},{a},{b}"));
                }
            }
            let distance = errors(&space, Function::Distance, PLACES, &deltas)?;
            let quadratic = errors(&space, Function::Quadratic, PLACES, &deltas)?;
            let _ = write!(markdown, "| {width} |");
            for ((name, d), q) in names.iter().zip(distance).zip(quadratic) {
                let _ = writeln!(csv, "{name},{step},{d:.3e},{q:.3e}");
                let _ = write!(markdown, " {d:.1e}, {q:.1e} |");
            }
            markdown.push('\n');
        }
    }
    Ok([csv, markdown])
}

fn main() -> Result<()> {
    let folder = std::env::args().skip_while(|a| a != "--out").nth(1).unwrap_or_else(|| ".".into());
    std::fs::create_dir_all(&folder)
        .map_err(|e| Error::input("cannot make the folder").at(folder.clone()).value(e))?;
    let write =
        |name: &str, text: &str| write_file(&Path::new(&folder).join(name), text.as_bytes());
    let squares = [Case::new(false, Function::Distance)?, Case::new(false, Function::Quadratic)?];
    let crooked = [Case::new(true, Function::Distance)?, Case::new(true, Function::Quadratic)?];
    let mut csv = String::from("mesh,phi,delta,h,error,order\n");
    squares.iter().chain(&crooked).for_each(|case| case.write_csv(&mut csv));
    write("delta.csv", &csv)?;
    write("published.md", &published(&squares[0], &squares[1]))?;
    write("squares-distance.md", &squares[0].markdown())?;
    write("squares-quadratic.md", &squares[1].markdown())?;
    write("crooked-distance.md", &crooked[0].markdown())?;
    write("delta.svg", &chart(&squares[1]))?;
    let [csv, markdown] = widths()?;
    write("width.csv", &csv)?;
    write("width.md", &markdown)
}
