//! Meshes adapted to the metrics of `tests/data/adaptmesh/adaptmesh.edp`, beside those of FreeFEM's
//! adaptmesh: live where FreeFEM is installed, recorded otherwise. `cargo test --release --test
//! suite adaptmesh -- --nocapture` prints the table of the book; with `RECORD=1` it writes what
//! FreeFEM gave to the record.

use cpu_time::ProcessTime;
use immersa::fem::{
    Basis, Cells, Element, Interpolation, Projection, Rule, Space, integrate, scalar_errors,
};
use immersa::mesh::adapt::{AdaptOptions, AdaptReport, Metric, adapt, assess};
use immersa::mesh::{Diagonals, Mesh, Point, rectangle};
use nalgebra::{SMatrix, SVector};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

const TIMES: usize = 6;
const HEAD: &str = "metric, program, vertices, unit edges, worst quality, mean quality, P1 error, \
    P2 error, CPU s, CPU s of the last";

/// A function of the distance `d` to a circle, or to the line y = 0, and the sizes that go with it.
struct Case {
    name: &'static str,
    centre: [f64; 2],
    radius: f64,
    kind: Kind,
}

enum Kind {
    /// Sizes across and along.
    Sizes(fn(f64) -> (f64, f64)),
    /// The metric of the Hessian of a function of `d`, with the error that linear interpolation may
    /// make; value and two derivatives.
    Function(f64, fn(f64) -> [f64; 3]),
}

const K: f64 = 20.0;
const DELTA: f64 = 0.02;

fn interface(d: f64) -> [f64; 3] {
    let t = (K * d).tanh();
    let s = 1.0 - t * t;
    [t, K * s, -2.0 * K * K * t * s]
}

fn band(d: f64) -> [f64; 3] {
    let root = d.hypot(DELTA);
    [root, d / root, DELTA * DELTA / root.powi(3)]
}

const CASES: [Case; 5] = [
    Case {
        name: "sizes",
        centre: [0.5, 0.5],
        radius: 0.35,
        kind: Kind::Sizes(|d| (0.01 + 0.2 * d.abs(), 0.01 + 0.2 * d.abs())),
    },
    Case {
        name: "layer",
        centre: [0.0, 0.0],
        radius: 0.0,
        kind: Kind::Sizes(|d| (0.002 + 0.1 * d, 0.1)),
    },
    Case {
        name: "front",
        centre: [-0.1, 0.5],
        radius: 0.7,
        kind: Kind::Sizes(|d| (0.003 + 0.3 * d.abs(), 0.1)),
    },
    Case { name: "tanh", centre: [0.5, 0.5], radius: 0.35, kind: Kind::Function(0.005, interface) },
    Case { name: "band", centre: [0.5, 0.5], radius: 0.35, kind: Kind::Function(0.002, band) },
];

impl Case {
    /// Unit normal, distance and distance from the centre.
    fn polar(&self, x: &Point<2>) -> (Point<2>, f64, f64) {
        if self.radius == 0.0 {
            return (Point::<2>::new(0.0, 1.0), x[1], 1.0);
        }
        let v = x - Point::<2>::from(self.centre);
        let r = v.norm().max(1e-12);
        (v / r, r - self.radius, r)
    }

    fn tensor(&self, x: &Point<2>) -> SMatrix<f64, 2, 2> {
        let (n, d, r) = self.polar(x);
        let (across, along) = match self.kind {
            Kind::Sizes(sizes) => sizes(d),
            Kind::Function(error, f) => {
                let [_, slope, bend] = f(d);
                let size = |hessian: f64| {
                    (2.0 / (9.0 * error) * f64::abs(hessian)).powf(-0.5).clamp(0.002, 0.2)
                };
                (size(bend), size(slope / r))
            }
        };
        let normal = n * n.transpose();
        normal / across.powi(2) + (SMatrix::<f64, 2, 2>::identity() - normal) / along.powi(2)
    }

    fn metric(&self, mesh: &Mesh<2>) -> Metric {
        Metric { tensors: mesh.points().iter().map(|x| self.tensor(x)).collect() }
    }

    /// L2 errors of linear and quadratic interpolation of the function.
    fn errors(&self, mesh: &Arc<Mesh<2>>) -> [f64; 2] {
        let Kind::Function(_, f) = self.kind else { return [f64::NAN; 2] };
        [Element::P1, Element::P2].map(|element| {
            let space = Arc::new(Space::new(mesh, element));
            let exact = |x: &Point<2>| (f(self.polar(x).1)[0], SVector::<f64, 2>::zeros());
            scalar_errors(&space, &space.interpolate(|x| exact(x).0), exact).l2
        })
    }
}

/// What one program gave for one metric.
#[derive(Clone, Debug)]
struct Row {
    program: String,
    /// Vertices, unit edges, worst and mean quality, errors of P1 and P2, seconds of all calls and
    /// of the last.
    numbers: [f64; 8],
}

impl Row {
    fn new(program: &str, report: &AdaptReport, errors: [f64; 2], seconds: [f64; 2]) -> Row {
        let r = report;
        let numbers = [
            r.vertices as f64,
            r.unit_edges,
            r.worst_quality,
            r.mean_quality,
            errors[0],
            errors[1],
            seconds[0],
            seconds[1],
        ];
        Row { program: program.into(), numbers }
    }

    fn text(&self, case: &str) -> String {
        let [n, unit, worst, mean, p1, p2, all, last] = self.numbers;
        format!(
            "{case}, {}, {n}, {unit:.3}, {worst:.3}, {mean:.3}, {p1:.2e}, {p2:.2e}, {all:.3}, \
             {last:.4}",
            self.program
        )
    }
}

fn ours(case: &Case) -> (Row, Mesh<2>) {
    let mut mesh = rectangle([0.0; 2], [1.0; 2], [20, 20], Diagonals::Right).unwrap();
    let mut seconds = [0.0; 2];
    for _ in 0..TIMES {
        let metric = case.metric(&mesh);
        let start = ProcessTime::now();
        mesh = adapt(&mesh, &metric, &AdaptOptions::default()).unwrap().mesh;
        seconds = [seconds[0] + start.elapsed().as_secs_f64(), start.elapsed().as_secs_f64()];
    }
    let report = assess(&mesh, &case.metric(&mesh)).unwrap();
    (Row::new("immersa", &report, case.errors(&Arc::new(mesh.clone())), seconds), mesh)
}

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/adaptmesh").join(file)
}

/// Runs adaptmesh; `None` if FreeFEM is not installed.
fn theirs(case: &Case, folder: &Path) -> Option<Row> {
    let out = folder.join(format!("{}.msh", case.name));
    let output = Command::new("FreeFem++")
        .arg("-nw")
        .arg(data("adaptmesh.edp"))
        .arg(case.name)
        .arg(&out)
        .output()
        .ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text
        .lines()
        .find_map(|l| l.strip_prefix("seconds "))
        .unwrap_or_else(|| panic!("FreeFEM failed:\n{text}"));
    let seconds: Vec<f64> = line.split_whitespace().map(|w| w.parse().unwrap()).collect();
    let mesh = read(&std::fs::read_to_string(out).unwrap());
    let report = assess(&mesh, &case.metric(&mesh)).unwrap();
    Some(Row::new("FreeFEM", &report, case.errors(&Arc::new(mesh)), [seconds[0], seconds[1]]))
}

/// A mesh in FreeFEM's own format, without its labels.
fn read(text: &str) -> Mesh<2> {
    let mut words = text.split_whitespace().map(|w| w.parse::<f64>().unwrap());
    let mut next = || words.next().unwrap();
    let (points, cells) = (next() as usize, next() as usize);
    next();
    let points = (0..points)
        .map(|_| [next(), next(), next()])
        .map(|[x, y, _]| Point::<2>::new(x, y))
        .collect();
    let cells = (0..4 * cells).map(|_| next()).collect::<Vec<_>>();
    Mesh::new(points, cells.chunks(4).flat_map(|c| [0, 1, 2].map(|k| c[k] as u32 - 1)).collect())
        .unwrap()
}

fn recorded(case: &Case) -> Row {
    let text = std::fs::read_to_string(data("recorded.csv")).unwrap();
    let line = text.lines().find(|l| l.starts_with(&format!("{},", case.name))).unwrap();
    let words: Vec<&str> = line.split(", ").collect();
    Row {
        program: "FreeFEM (recorded)".into(),
        numbers: std::array::from_fn(|i| words[i + 2].parse().unwrap()),
    }
}

/// Bounds: most edges have unit length and no triangle is bad, as good as FreeFEM or better; the
/// same error with no more vertices, where linear interpolation has the error `c/n` with `n`
/// vertices and quadratic `c/n^1.5`.
#[test]
#[allow(clippy::print_stdout, reason = "the table of the book")]
fn meshes_fit_their_metrics_as_well_as_those_of_freefem() {
    let folder = tempfile::tempdir().unwrap();
    let mut record = format!("{HEAD}\n");
    println!("{HEAD}");
    for case in &CASES {
        let (our, mesh) = ours(case);
        let their = theirs(case, folder.path());
        if let Some(row) = &their {
            record += &(row.text(case.name) + "\n");
        }
        let their = their.unwrap_or_else(|| recorded(case));
        println!("{}\n{}", our.text(case.name), their.text(case.name));
        assert!((mesh.volume() - 1.0).abs() < 1e-13);
        let ([n, unit, worst, mean, p1, p2, ..], theirs) = (our.numbers, their.numbers);
        assert!(unit > 0.94 && worst > 0.4 && mean > 0.92, "{our:?}");
        assert!(
            unit > theirs[1] - 0.01 && worst > theirs[2] - 0.1 && mean > theirs[3] - 0.02,
            "{our:?} {their:?}"
        );
        assert!(n < 1.25 * theirs[0], "{our:?} {their:?}");
        if p1.is_finite() {
            let worth = |n: f64, p1: f64, p2: f64| [n * p1, n.powf(1.5) * p2];
            let (ours, theirs) = (worth(n, p1, p2), worth(theirs[0], theirs[4], theirs[5]));
            assert!(
                ours[0] < theirs[0] && ours[1] < theirs[1],
                "{}: {ours:?} {theirs:?}",
                case.name
            );
        }
    }
    if std::env::var_os("RECORD").is_some() {
        std::fs::write(data("recorded.csv"), record).unwrap();
    }
}

/// A square of about `n` triangles a side, finer to the top or to the left.
fn graded(n: usize, top: bool) -> Arc<Mesh<2>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [n, n], Diagonals::Right).unwrap();
    let size = |x: &Point<2>| (2.0 - if top { x[1] } else { 1.0 - x[0] }) / (1.5 * n as f64);
    let metric = Metric::isotropic(&mesh.points().iter().map(size).collect::<Vec<_>>());
    Arc::new(adapt(&mesh, &metric, &AdaptOptions::default()).unwrap().mesh)
}

/// A field carried to and fro between two meshes: what is lost each time adds up only if values are
/// taken at nodes.
#[test]
#[allow(clippy::print_stdout, reason = "the table of the book")]
fn projection_loses_less_than_values_at_nodes_when_a_field_is_carried_often() {
    let meshes = [graded(32, true), graded(32, false)];
    let spaces = meshes.each_ref().map(|mesh| Arc::new(Space::new(mesh, Element::P2)));
    let exact = |x: &Point<2>| {
        let d = (x - Point::<2>::new(0.5, 0.5)).norm() - 0.35;
        ((K * d).tanh(), SVector::<f64, 2>::zeros())
    };
    let mass = |f: &[f64]| {
        let basis = Basis::new(&spaces[0], &Arc::new(Rule::simplex(2, 2)));
        integrate(&basis, Cells::All, |at| [basis.value(at, f)])[0]
    };
    let start = spaces[0].interpolate(|x| exact(x).0);
    let mut fields = [start.clone(), start.clone()];
    println!("transfers, L2 error at nodes, by projection, integral lost at nodes, by projection");
    let mut rows = Vec::new();
    for pair in 1..=10 {
        for (from, to) in [(0, 1), (1, 0)] {
            fields[0] = Interpolation::new(&meshes[from], &spaces[to])
                .unwrap()
                .apply(&spaces[from], &fields[0]);
            let projection = Projection::new(&meshes[from], &spaces[to], &[]).unwrap();
            fields[1] = projection.scalar(&spaces[from], &fields[1]).unwrap();
        }
        let errors = fields.each_ref().map(|f| scalar_errors(&spaces[0], f, exact).l2);
        let lost = fields.each_ref().map(|f| (mass(f) / mass(&start) - 1.0).abs());
        rows.push((errors, lost));
        if [1, 5, 10].contains(&pair) {
            println!(
                "{}, {:.2e}, {:.2e}, {:.1e}, {:.1e}",
                2 * pair,
                errors[0],
                errors[1],
                lost[0],
                lost[1]
            );
        }
    }
    println!("0, {:.2e}", scalar_errors(&spaces[0], &start, exact).l2);
    assert!(rows[9].1[1] < 1e-12 && rows[9].1[0] > 1e-7);
    assert!(rows[9].0[1] < rows[9].0[0]);
}
