//! Figs. 1.5 and 1.6 of the book: a disc is drawn out into a filament by a vortex, with and without
//! redistancing; where its interface lies at the end, and how long it is over time.
//!
//!     cargo run --release --example filament -- --out runs/filament

#![allow(clippy::print_stdout, reason = "an example prints its results")]

use immersa::base::{Error, Result};
use immersa::fem::Space;
use immersa::levelset::{Contour, Delta, Kernel, Norm, Smeared, Width};
use immersa::mesh::Point;
use immersa::output::{Chart, Curve, Stroke, write_file};
use immersa::scene::{Advected, Scene};
use immersa::structure::polygon_length;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const SCENE: &str = include_str!("vortex/scene.toml");
/// Times between two measurements, and of the end.
const EVERY: f64 = 0.25;
const END: f64 = 5.0;

/// A way to keep the level set.
#[derive(Clone, Copy, PartialEq)]
struct Way {
    /// In the table.
    key: &'static str,
    /// In charts.
    name: &'static str,
    /// How level sets are carried.
    transport: &'static str,
    /// How they are redistanced.
    keys: &'static [&'static str],
    /// After every step, or four times in all.
    rarely: bool,
}

const fn way(key: &'static str, name: &'static str, keys: &'static [&'static str]) -> Way {
    Way { key, name, transport: "nodal", keys, rarely: false }
}

const NOT: Way = way("none", "not redistanced", &[]);
const JACOBI: Way = way("hamilton-jacobi", "Hamilton-Jacobi", &["method=hamilton-jacobi"]);
const MARCHING: Way = way("fast-marching", "fast marching", &["method=fast-marching"]);
const EXACT: Way = way("exact", "exact distance", &["method=exact"]);
const AREA: Way = way("exact-area", "exact distance and area", &["method=exact", "volume=true"]);
const RARELY: Way =
    Way { rarely: true, ..way("exact-rarely", "exact distance, four times", &["method=exact"]) };
const COMPOSED: Way = Way { transport: "composed", ..way("composed", "composed map", &[]) };

/// What was measured in one computation.
struct Course {
    time: Vec<f64>,
    /// Lengths: of the cut interface, by the renormalised delta, and of the polygon of the markers.
    length: [Vec<f64>; 3],
    area: Vec<f64>,
    /// Lines of the interface at the end, and the markers.
    lines: Vec<Vec<Point<2>>>,
    markers: Vec<Point<2>>,
}

/// The vortex on `cells x cells` squares, 2 cells a step.
fn course(cells: usize, way: Way) -> Result<Course> {
    let step = 2.0 / cells as f64;
    let steps = (END / step).round() as usize;
    let mut set = vec![
        format!("mesh.rectangle.cells=[{cells},{cells}]"),
        format!("time.step={step}"),
        format!("numerics.transport={}", way.transport),
    ];
    set.extend(way.keys.iter().map(|k| format!("numerics.redistance.{k}")));
    if way.rarely {
        set.push(format!("numerics.redistance.every={}", steps / 4));
    }
    let scene = Scene::parse_with(SCENE, Path::new("examples/vortex/scene.toml"), &set)?;
    let mut flow = Advected::<2>::new(&scene)?.advection;
    let mut course = Course {
        time: vec![],
        length: Default::default(),
        area: vec![],
        lines: vec![],
        markers: vec![],
    };
    let every = (EVERY / step).round() as usize;
    for k in 0..=steps {
        if k > 0 {
            flow.step()?;
        }
        // A chain of maps takes long to evaluate.
        if k % every != 0 || (way == COMPOSED && k % (4 * every) != 0) {
            continue;
        }
        let (carried, fields) = (flow.carried(), &flow.state().fields);
        let interface = carried.interface(fields, 0)?;
        let Some(cut) = interface.contour() else { continue };
        let markers = carried.markers(fields, 0);
        course.time.push(flow.time());
        course.length[0].push(cut.perimeter());
        course.length[1].push(by_delta(flow.space(), &flow.level_set(0), 0.75 / cells as f64)?);
        course.length[2].push(if markers.is_empty() { f64::NAN } else { polygon_length(markers) });
        course.area.push(cut.measures().map_or(0.0, |m| m.area));
        if k == steps {
            course.lines = lines(cut);
            course.markers = markers.to_vec();
        }
    }
    Ok(course)
}

/// The length of the interface by the renormalised delta of half-width `eps`, `zeta(phi/(eps |grad
/// phi|))/eps`.
fn by_delta(space: &Space<2>, phi: &[f64], eps: f64) -> Result<f64> {
    let width = Width::Renormalised(Norm::L2);
    Delta::Smeared(Smeared { kernel: Kernel::Cosine, width, thickness: eps, degree: 8 })
        .measure(space, phi)
}

fn lines(contour: &Contour) -> Vec<Vec<Point<2>>> {
    contour.lines().iter().map(|line| contour.polyline(line)).collect()
}

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let out = arguments.iter().position(|a| a == "--out").and_then(|i| arguments.get(i + 1));
    let out = PathBuf::from(out.map_or("runs/filament", String::as_str));
    std::fs::create_dir_all(&out).map_err(|e| {
        Error::input("cannot make the folder").at(out.display().to_string()).value(e)
    })?;
    let write = |name: &str, text: &str| write_file(&out.join(name), text.as_bytes());

    let mut table = String::from("time,nodes,way,cut,delta,markers,area\n");
    let mut all: Vec<(usize, Way, Course)> = Vec::new();
    for cells in [32, 64, 128] {
        for way in [NOT, JACOBI, MARCHING, EXACT, AREA, RARELY, COMPOSED] {
            // The finest chain of maps takes minutes, and says what that before says.
            if way != COMPOSED || cells < 128 {
                all.push((2 * cells, way, course(cells, way)?));
            }
        }
    }
    for (nodes, way, c) in &all {
        for i in 0..c.time.len() {
            let [cut, delta, markers] = [0, 1, 2].map(|k| c.length[k][i]);
            let _ = writeln!(
                table,
                "{},{nodes},{},{cut},{delta},{markers},{}",
                c.time[i], way.key, c.area[i]
            );
        }
        let last = c.time.len() - 1;
        println!(
            "N = {nodes}, {}: length {:.3} (delta {:.3}), area {:.5}",
            way.name, c.length[0][last], c.length[1][last], c.area[last]
        );
    }
    write("lengths.csv", &table)?;

    let find = |nodes, way: Way| all.iter().find(|a| a.0 == nodes && a.1 == way).map(|a| &a.2);
    let reference = &all[0].2;
    let markers = Curve {
        name: "markers",
        x: &reference.time,
        y: &reference.length[2],
        stroke: Stroke::Line,
        colour: Some(6),
    };
    // Fig. 1.6: by the delta, both ways at three resolutions.
    let mut curves = vec![markers];
    let named: Vec<(usize, String, Stroke, Way)> = [64, 128, 256]
        .iter()
        .flat_map(|&n| {
            [
                (n, format!("redistanced, N = {n}"), Stroke::Line, EXACT),
                (n, format!("renormalised, N = {n}"), Stroke::Dashed, NOT),
            ]
        })
        .collect();
    for (k, (n, label, stroke, way)) in named.iter().enumerate() {
        let Some(c) = find(*n, *way) else { continue };
        curves.push(Curve {
            name: label,
            x: &c.time,
            y: &c.length[1],
            stroke: *stroke,
            colour: Some(k / 2),
        });
    }
    // The composed map evaluates the level set wherever it is cut, so that its length is that of
    // the interface.
    if let Some(c) = find(128, COMPOSED) {
        let label = "composed map, N = 128";
        curves.push(Curve {
            name: label,
            x: &c.time,
            y: &c.length[0],
            stroke: Stroke::Points,
            colour: Some(6),
        });
    }
    let chart = Chart { x_label: "time", y_label: "length", curves, ..Chart::default() };
    write("lengths.svg", &chart.svg())?;
    // All ways at one resolution, cut.
    let mut curves = vec![markers];
    for (_, way, c) in all.iter().filter(|a| a.0 == 128) {
        let stroke = if *way == COMPOSED { Stroke::Points } else { Stroke::Line };
        curves.push(Curve {
            name: way.name,
            x: &c.time,
            y: &c.length[0],
            stroke,
            colour: Some(curves.len() - 1),
        });
    }
    let chart = Chart { x_label: "time", y_label: "length", curves, ..Chart::default() };
    write("ways.svg", &chart.svg())?;
    // Fig. 1.5.
    for nodes in [64, 128, 256] {
        if let (Some(not), Some(exact)) = (find(nodes, NOT), find(nodes, EXACT)) {
            write(&format!("interface-{nodes}.svg"), &interfaces(not, exact))?;
        }
    }
    Ok(())
}

/// The interfaces at the end, beside each other, each with the polygon of the markers.
fn interfaces(not: &Course, exact: &Course) -> String {
    const SIZE: f64 = 380.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" \
         font-family=\"sans-serif\" font-size=\"14\">\n",
        2.0 * SIZE + 20.0,
        SIZE + 24.0
    );
    for (k, (name, course)) in
        [("not redistanced", not), ("redistanced after every step", exact)].into_iter().enumerate()
    {
        let left = k as f64 * (SIZE + 20.0);
        let path = |line: &[Point<2>], close: &str| {
            let mut d = String::new();
            for (i, x) in line.iter().enumerate() {
                let (a, b) = (left + SIZE * x[0], 22.0 + SIZE * (1.0 - x[1]));
                let _ = write!(d, "{}{a:.1} {b:.1}", if i == 0 { "M" } else { "L" });
            }
            d + close
        };
        let _ = writeln!(svg, "<text x=\"{left}\" y=\"14\" fill=\"#888888\">{name}</text>");
        let _ = writeln!(
            svg,
            "<rect x=\"{left}\" y=\"22\" width=\"{SIZE}\" height=\"{SIZE}\" fill=\"none\" \
             stroke=\"#888888\"/>"
        );
        let inside: String = course.lines.iter().map(|line| path(line, "Z")).collect();
        let _ = writeln!(
            svg,
            "<path d=\"{inside}\" fill=\"#1F82C0\" fill-opacity=\"0.35\" fill-rule=\"evenodd\" \
             stroke=\"#1F82C0\"/>"
        );
        let _ = writeln!(
            svg,
            "<path d=\"{}\" fill=\"none\" stroke=\"#D55E00\" stroke-width=\"0.8\"/>",
            path(&course.markers, "Z")
        );
    }
    svg + "</svg>\n"
}
