//! Run folders for tests: a short true simulation, written as a run writes it.

use immersa::elastic::{AreaLaw, Membrane};
use immersa::levelset::{Contour, Ellipse, signed_distance};
use immersa::mesh::{Diagonals, Locator, Point, rectangle};
use immersa::output::{FieldData, Series, SeriesWriter, write_pvd, write_vtu};
use immersa::scene::Scene;
use immersa::sim::{Fluid, Simulation, SimulationSettings};
use immersa::structure::{Immersed, ImmersedInterface, Medium};
use nalgebra::SVector;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// What `summary.json` warns of.
pub const ALARM: &str = "the energy rose by 3.1e-5 of its first value in the step to t = 0.07";

const AXES: [f64; 2] = [0.75, 0.5];
const STRETCH: f64 = 1.2625316;
const THICKNESS: f64 = 0.15;
const STEP: f64 = 0.01;

fn scene(cells: usize, steps: usize, pictures: usize) -> String {
    let end = steps as f64 * STEP;
    format!(
        r#"title = "Relaxing elliptical membrane"
[mesh]
rectangle = {{ min = [0, 0], max = [2, 2], cells = [{cells}, {cells}], diagonals = "union-jack" }}
[fluid]
density = 1.0
viscosity = 0.01
[boundary.walls]
no_slip = true
[[membrane]]
name = "membrane"
shape.ellipse = {{ centre = [1, 1], semi_axes = {AXES:?} }}
stretch = {STRETCH}
area.linear = {{ modulus = 1.0 }}
[membrane.chords]
horizontal = {{ through = [1, 1], direction = [1, 0] }}
vertical = {{ through = [1, 1], direction = [0, 1] }}
[time]
end = {end}
step = {STEP}
[numerics]
thickness = {THICKNESS}
grad_div = 5
transport = "nodal"
[output]
every = {STEP}
pictures = {}
picture = {{ field = "pressure" }}
probes.middle = {{ at = [1, 1], of = "velocity" }}
probes.inside = {{ at = [1, 1], of = "pressure" }}
profiles.pressure = {{ from = [0, 1], to = [2, 1], of = "pressure", times = [{}, {end}] }}
"#,
        pictures as f64 * STEP,
        0.5 * end
    )
}

fn simulation(cells: usize) -> Simulation<2> {
    let mesh =
        Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [cells, cells], Diagonals::UnionJack).unwrap());
    let space = immersa::fem::Space::new(&mesh, immersa::fem::Element::P2);
    let ellipse = Ellipse::new(Point::<2>::new(1.0, 1.0), AXES.into(), 0.0).unwrap();
    let settings = SimulationSettings {
        grad_div: 5.0,
        ..SimulationSettings::new(STEP, Fluid { density: 1.0, viscosity: 0.01 }, Vec::new())
    };
    let structure = Immersed::boxed(
        ImmersedInterface::new(
            "membrane",
            signed_distance(&space, &ellipse).iter().map(|d| STRETCH * d).collect(),
            THICKNESS,
        ),
        Membrane::new(AreaLaw::Linear { modulus: 1.0 }, THICKNESS),
    );
    Simulation::new(&mesh, settings, vec![structure], |_| SVector::zeros()).unwrap()
}

const COLUMNS: [&str; 23] = [
    "membrane.area",
    "membrane.perimeter",
    "membrane.centre_x",
    "membrane.centre_y",
    "membrane.axis_1",
    "membrane.axis_2",
    "membrane.angle",
    "membrane.extent_x",
    "membrane.extent_y",
    "membrane.horizontal",
    "membrane.vertical",
    "energy_kinetic",
    "energy_elastic",
    "dissipation",
    "energy_balance",
    "work",
    "velocity_max",
    "divergence",
    "cfl",
    "step_over_limit",
    "middle_x",
    "middle_y",
    "inside",
];

/// The row of the series for the state of now.
fn row(sim: &Simulation<2>) -> Vec<f64> {
    let (space, state, phi) = (sim.space(), sim.state(), &sim.level_set(0));
    let contour = Contour::new(space, phi).unwrap();
    let m = contour.measures().unwrap();
    let centre = Point::<2>::new(1.0, 1.0);
    let chord =
        |x, y| contour.half_chord(space, phi, &centre, &SVector::<f64, 2>::new(x, y)).unwrap();
    let e = state.energies;
    let limit = sim.structures()[0].step_limit(&Medium {
        density: 1.0,
        viscosity: 0.01,
        edge: 0.1,
        order: 2,
    });
    let at = Locator::new(space.mesh()).locate(space.mesh(), &centre).unwrap();
    let u = space.value(&state.flow.u, at.cell as usize, &at.barycentric);
    let p = sim.flow().pressure().space().value(&state.flow.p, at.cell as usize, &at.barycentric);
    let mut row =
        vec![m.area, m.perimeter, m.centroid[0], m.centroid[1], m.axis_1, m.axis_2, m.angle];
    row.extend([m.extent_x, m.extent_y, chord(1.0, 0.0), chord(0.0, 1.0)]);
    row.extend([
        e.kinetic,
        e.elastic,
        e.dissipation + e.grad_div,
        state.balance.residual(&e),
        state.balance.work,
    ]);
    row.extend([sim.largest_speed(), e.divergence, sim.courant(), STEP / limit, u[0], u[1], p]);
    row
}

/// The pressure along `y = 1`.
fn profile(sim: &Simulation<2>) -> Vec<f64> {
    let space = sim.flow().pressure().space();
    let locator = Locator::new(space.mesh());
    let value = |x: f64| {
        let at = locator.locate(space.mesh(), &Point::<2>::new(x, 1.0)).unwrap();
        space.value(&sim.state().flow.p, at.cell as usize, &at.barycentric)
    };
    abscissas().iter().map(|&x| value(x)).collect()
}

fn abscissas() -> Vec<f64> {
    (0..200).map(|k| 2.0 * f64::from(k) / 199.0).collect()
}

/// Computes `steps` steps on `cells x cells x 2` triangles with fields every `pictures` steps, and
/// writes the run folder.
pub fn write(folder: &Path, cells: usize, steps: usize, pictures: usize) {
    fs::create_dir_all(folder.join("fields")).unwrap();
    fs::create_dir_all(folder.join("profiles")).unwrap();
    let scene = Scene::parse(&scene(cells, steps, pictures), &folder.join("scene.toml")).unwrap();
    fs::write(folder.join("scene.toml"), scene.to_toml()).unwrap();
    fs::write(folder.join("immersa.run"), "run folder of immersa").unwrap();
    let mut sim = simulation(cells);
    let mut series = SeriesWriter::create(&folder.join("series.csv"), &COLUMNS).unwrap();
    let (mut list, mut profiles, mut largest_rise) = (Vec::new(), Vec::new(), 0f64);
    let first_area = row(&sim)[0];
    for step in 0..=steps {
        if step > 0 {
            let before = sim.state().energies.total();
            sim.step().unwrap();
            largest_rise = largest_rise.max(sim.state().energies.total() - before);
        }
        let now = row(&sim);
        series.append(sim.time(), &now).unwrap();
        if step % pictures == 0 || step == steps {
            let name = format!("fields/{:06}.vtu", list.len());
            let state = sim.state();
            let fields = [
                ("velocity", FieldData::Vector(&state.flow.u)),
                ("pressure", FieldData::Scalar(&state.flow.p)),
                ("membrane.level_set", FieldData::Scalar(&sim.level_set(0))),
            ];
            write_vtu(&folder.join(&name), sim.space(), sim.time(), &fields).unwrap();
            list.push((sim.time(), name));
        }
        if 2 * step == steps || step == steps {
            profiles.push((format!("t={}", (sim.time() * 1e9).round() / 1e9), profile(&sim)));
        }
    }
    write_pvd(&folder.join("fields.pvd"), &list).unwrap();
    let (x, y) = (abscissas(), vec![1.0; 200]);
    let mut columns: Vec<(&str, &[f64])> = vec![("distance", &x), ("x", &x), ("y", &y)];
    columns.extend(profiles.iter().map(|(name, p)| (name.as_str(), p.as_slice())));
    Series::new(&columns).write(&folder.join("profiles/pressure.csv")).unwrap();
    fs::write(folder.join("summary.json"), summary(&sim, first_area, largest_rise)).unwrap();
}

fn summary(sim: &Simulation<2>, first_area: f64, largest_rise: f64) -> String {
    let now = row(sim);
    let last: serde_json::Map<_, _> =
        COLUMNS.iter().zip(&now).map(|(k, v)| (k.to_string(), (*v).into())).collect();
    let u = sim.state().flow.u.len();
    let summary = serde_json::json!({
        "title": "Relaxing elliptical membrane",
        "status": "finished",
        "error": null,
        "steps": sim.state().steps,
        "end_time": sim.time(),
        "cells": sim.space().mesh().cell_count(),
        "unknowns": { "velocity": 2 * u, "pressure": sim.state().flow.p.len(), "level_set": u },
        "seconds": { "assembly": 0.5, "factorisation": 1.25, "transport": 0.375 },
        "alarms": [ALARM],
        "warnings": ["the mesh has no region names"],
        "plan": "Navier-Stokes, P2-P1, BDF2, convection by characteristics.\nOne membrane, linear \
         law.\n\nLeft out: backward characteristics (no shear), curvature, redistancing.",
        "balance": {
            "energy": sim.state().balance.residual(&sim.state().energies),
            "largest_rise": largest_rise / sim.state().balance.initial,
            "area": { "membrane": now[0] / first_area - 1.0 },
        },
        "final": last,
    });
    serde_json::to_string_pretty(&summary).unwrap()
}
