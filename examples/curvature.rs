//! Curvatures of surfaces (annex 7.1 of the book) and of curves between two level sets (section
//! 1.3), with their errors and orders.
//!
//!     cargo run --release --example curvature -- --out FOLDER
//!
//! writes `curvature.csv` and `curves.csv` there, and the same as Markdown.

#![allow(clippy::print_stdout, reason = "an example says what it does")]

use immersa::base::{Error, Result};
use immersa::fem::{Element, Recovery, Space};
use immersa::levelset::{
    Curvature, Ellipsoid, Isosurface, Shape, SpaceCurve, Torus, vertices_near,
};
use immersa::mesh::{Mesh, Point, box_mesh};
use immersa::output::write_file;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

type P3 = Point<3>;
type Function<'a> = &'a dyn Fn(&P3) -> f64;

/// Largest and mean errors of two quantities.
#[derive(Default)]
struct Errors {
    largest: [f64; 2],
    sums: [f64; 2],
    weight: f64,
    scale: [f64; 2],
}

impl Errors {
    fn add(&mut self, found: [f64; 2], exact: [f64; 2], weight: f64) {
        for k in 0..2 {
            let e = (found[k] - exact[k]).abs();
            self.largest[k] = self.largest[k].max(e);
            self.sums[k] += e * weight;
            self.scale[k] = self.scale[k].max(exact[k].abs());
        }
        self.weight += weight;
    }
    /// Largest and mean of the first, largest and mean of the second, over the largest exact value.
    fn relative(&self) -> [f64; 4] {
        let of = |k: usize| {
            [self.largest[k] / self.scale[k], self.sums[k] / self.weight / self.scale[k]]
        };
        [of(0)[0], of(0)[1], of(1)[0], of(1)[1]]
    }
}

/// A row of a table, with the orders from the last mesh.
fn write_row(
    out: &mut String,
    what: &str,
    (h, last_h): (f64, f64),
    errors: [f64; 4],
    last: Option<[f64; 4]>,
) {
    let _ = write!(out, "{what},{h:.4}");
    for k in 0..4 {
        let order = last.map_or(f64::NAN, |l| (l[k] / errors[k]).ln() / (last_h / h).ln());
        let _ = write!(out, ",{:.2e},{order:.2}", errors[k]);
    }
    out.push('\n');
    println!("{what} {h:.4} {errors:.2?}");
}

fn surface(
    out: &mut String,
    what: &str,
    mesh: &dyn Fn(usize) -> Result<Mesh<3>>,
    phi: Function,
    exact: &dyn Fn(&P3) -> [f64; 2],
) -> Result<()> {
    let mut last = (f64::NAN, None);
    for n in [12, 16, 24, 32, 48] {
        let mesh = Arc::new(mesh(n)?);
        let space = Space::new(&mesh, Element::P2);
        let phi = space.interpolate(phi);
        let curvature =
            Curvature::new(&Recovery::new(&mesh), &space, &phi, &vertices_near(&space, &phi, 0.0));
        let mut errors = Errors::default();
        for p in Isosurface::new(&space, &phi)?.points_of_forms(&space, &phi) {
            let (cell, l) = (p.at.cell, &p.at.barycentric);
            let found = [curvature.mean_at(&mesh, cell, l), curvature.gauss_at(&mesh, cell, l)];
            errors.add(found, exact(&p.at.x), p.at.weight);
        }
        let h = 2.4 / n as f64;
        write_row(out, what, (h, last.0), errors.relative(), last.1);
        last = (h, Some(errors.relative()));
    }
    Ok(())
}

fn surfaces(out: &mut String) -> Result<()> {
    let axes = [0.9, 0.7, 0.55];
    let ellipsoid = Ellipsoid::new(P3::zeros(), P3::from(axes), P3::zeros())?;
    let square = |x: &P3| (0..3).map(|i| (x[i] / axes[i]).powi(2)).sum::<f64>();
    let exact = |x: &P3| {
        let s = axes.map(|a| a * a);
        let q: [f64; 3] = std::array::from_fn(|i| x[i] * x[i] / s[i]);
        let w: f64 = (0..3).map(|i| q[i] / s[i]).sum();
        let (product, h) = (
            s[0] * s[1] * s[2],
            q[0] * (s[1] + s[2]) + q[1] * (s[0] + s[2]) + q[2] * (s[0] + s[1]),
        );
        [h / (product * w.powf(1.5)), 1.0 / (product * w * w)]
    };
    let cube = |n: usize| box_mesh([-1.2; 3], [1.2; 3], [n, n, n]);
    surface(out, "ellipsoid,distance", &cube, &|x| ellipsoid.distance(x), &exact)?;
    surface(out, "ellipsoid,quadratic", &cube, &|x| square(x) - 1.0, &exact)?;
    let tilted = |x: &P3| (square(x).sqrt() - 1.0) * (1.0 + 0.4 * x[0] - 0.2 * x[1] * x[2]);
    surface(out, "ellipsoid,tilted", &cube, &tilted, &exact)?;
    let (big, small) = (0.7, 0.3);
    let torus = Torus::new(P3::zeros(), P3::z(), big, small)?;
    let exact = |x: &P3| {
        let rho = x[0].hypot(x[1]);
        [(2.0 - big / rho) / small, (1.0 - big / rho) / (small * small)]
    };
    let slab = |n: usize| box_mesh([-1.2, -1.2, -0.6], [1.2, 1.2, 0.6], [n, n, n / 2]);
    surface(out, "torus,distance", &slab, &|x| torus.distance(x), &exact)?;
    let quartic = |x: &P3| {
        let sum = x.norm_squared() + big * big - small * small;
        sum * sum - 4.0 * big * big * (x[0] * x[0] + x[1] * x[1])
    };
    surface(out, "torus,quartic", &slab, &quartic, &exact)
}

fn curve(
    out: &mut String,
    (what, mesh): (&str, &dyn Fn(usize) -> Result<Mesh<3>>),
    phi: [Function; 2],
    exact: &dyn Fn(&P3) -> [f64; 2],
    wanted: &dyn Fn(&P3) -> bool,
) -> Result<()> {
    let mut last = (f64::NAN, None);
    for n in [8, 12, 16, 24, 32] {
        let mesh = Arc::new(mesh(n)?);
        let space = Space::new(&mesh, Element::P2);
        let [a, b] = phi.map(|f| space.interpolate(f));
        let mut errors = Errors::default();
        for p in SpaceCurve::new(&Recovery::new(&mesh), &space, [&a, &b])?.points() {
            if wanted(&p.at.x) {
                errors.add([p.frenet.curvature, p.frenet.torsion], exact(&p.at.x), p.at.weight);
            }
        }
        let h = 2.0 / n as f64;
        write_row(out, what, (h, last.0), errors.relative(), last.1);
        last = (h, Some(errors.relative()));
    }
    Ok(())
}

fn curves(out: &mut String) -> Result<()> {
    let (a, k): (f64, f64) = (0.6, 2.0);
    let square = 1.0 + (a * k).powi(2);
    let cube = |n: usize| box_mesh([-1.0; 3], [1.0; 3], [n, n, n]);
    let helix: [Function; 2] = [&|x| x[0] - a * (k * x[2]).cos(), &|x| x[1] - a * (k * x[2]).sin()];
    let exact = |_: &P3| [a * k * k / square, k / square];
    curve(out, ("helix", &cube), helix, &exact, &|x| x[2].abs() < 0.7)?;
    let exact = |x: &P3| {
        let c = 2.0 * x[0] - 1.0;
        let curvature = (13.0 + 3.0 * c).sqrt() / (0.5 * (3.0 + c).powf(1.5));
        [curvature, 6.0 * (x[1] / x[2]) / (0.5 * (13.0 + 3.0 * c))]
    };
    // The axis of the cylinder does not lie on the lattice.
    let shifted = |n: usize| box_mesh([-0.77, -1.03, -1.19], [1.24, 1.01, 1.21], [n, n, n]);
    let viviani: [Function; 2] = [&|x| x.norm() - 1.0, &|x| (x[0] - 0.5).hypot(x[1]) - 0.5];
    curve(out, ("viviani", &shifted), viviani, &exact, &|x| x[0] < 0.8)
}

/// A table as Markdown, each error with its order in brackets.
fn markdown(csv: &str) -> String {
    let mut out = String::new();
    for (i, line) in csv.lines().enumerate() {
        let mut cells: Vec<String> = Vec::new();
        for (name, cell) in csv.lines().next().unwrap_or_default().split(',').zip(line.split(',')) {
            match (name == "order", i, cells.last_mut()) {
                (false, ..) => cells.push(cell.to_string()),
                (true, 1.., Some(last)) if cell != "NaN" => last.push_str(&format!(" ({cell})")),
                _ => {}
            }
        }
        let _ = writeln!(out, "| {} |", cells.join(" | "));
        if i == 0 {
            let _ = writeln!(out, "|{}", "---|".repeat(cells.len()));
        }
    }
    out
}

fn main() -> Result<()> {
    let folder = std::env::args().skip_while(|a| a != "--out").nth(1).unwrap_or_else(|| ".".into());
    std::fs::create_dir_all(&folder)
        .map_err(|e| Error::input("cannot make the folder").at(folder.clone()).value(e))?;
    let write =
        |name: &str, text: &str| write_file(&Path::new(&folder).join(name), text.as_bytes());
    let columns = |a: &str, b: &str| {
        let of = |q: &str| format!("{q} largest,order,{q} mean,order");
        format!("h,{},{}\n", of(a), of(b))
    };
    let mut table = format!("surface,phi,{}", columns("H", "G"));
    surfaces(&mut table)?;
    write("curvature.csv", &table)?;
    write("curvature.md", &markdown(&table))?;
    let mut table = format!("curve,{}", columns("curvature", "torsion"));
    curves(&mut table)?;
    write("curves.csv", &table)?;
    write("curves.md", &markdown(&table))
}
