//! What a run measures: the columns of the series, and profiles along lines.

use super::Scene;
use super::errors;
use super::model::Model;
use super::schema::{Profile, Quantity};
use crate::base::{Error, Result};
use crate::flow::{Load, flux, traction};
use crate::levelset::Interface;
use crate::mesh::{Location, Locator, Point};
use crate::sim::Simulation;
use crate::transport::Method;

/// The columns that each membrane has, after its name and a dot.
const MEASURES: [&str; 9] =
    ["area", "perimeter", "centre_x", "centre_y", "axis_1", "axis_2", "angle", "extent_x", "extent_y"];
/// The columns that every run has.
const COMMON: [&str; 9] = [
    "energy_kinetic",
    "energy_elastic",
    "dissipation",
    "energy_balance",
    "work",
    "velocity_max",
    "divergence",
    "cfl",
    "step_over_limit",
];

/// The columns that a run with a prescribed velocity has.
const PASSIVE: [&str; 3] = ["velocity_max", "divergence", "cfl"];
/// The columns that composed transport adds.
const COMPOSED: [&str; 2] = ["submaps", "map_error"];
/// The columns that a mesh which follows adds.
const ADAPTED: [&str; 2] = ["unknowns", "energy_transferred"];
/// The columns that markers add to a level set.
const MARKERS: [&str; 2] = ["markers_length", "markers_area"];

/// Measures a simulation in the way that a scene asks for.
pub struct Diagnostics<'a> {
    scene: &'a Scene,
    probes: Vec<Location>,
    profiles: Vec<Vec<(Point<2>, Location)>>,
}

impl<'a> Diagnostics<'a> {
    /// Finds the points of all probes and profiles.
    ///
    /// # Errors
    /// A point outside the mesh, or a boundary that the mesh does not have.
    pub fn new(scene: &'a Scene, model: &Model) -> Result<Diagnostics<'a>> {
        let mesh = model.simulation.space().mesh();
        let locator = Locator::new(mesh);
        let locate = |x: Point<2>, keys: [&str; 3]| {
            locator.locate(mesh, &x).ok_or_else(|| {
                let (lo, hi) = mesh.bounding_box();
                let e = Error::scene("the point lies outside the mesh").value(format!("{:?}", x.as_slice())).remedy(
                    format!("give a point of the mesh, which spans {:?} to {:?}", lo.as_slice(), hi.as_slice()),
                );
                scene.blame(&keys, e)
            })
        };
        let probes = scene.output.probes.iter();
        let probes = probes.map(|p| locate(point(&p.at), ["output", "probes", &p.name])).collect::<Result<_>>()?;
        let mut profiles = Vec::new();
        for p in &scene.output.profiles {
            let points = line(p).map(|x| Ok((x, locate(x, ["output", "profiles", &p.name])?)));
            profiles.push(points.collect::<Result<_>>()?);
        }
        for (table, name, boundary) in named_boundaries(scene) {
            mesh.boundary(boundary).map_err(|e| scene.blame(&["output", table, name, "boundary"], e))?;
        }
        Ok(Diagnostics { scene, probes, profiles })
    }

    /// The names of the columns, without `time`.
    pub fn columns(&self) -> Vec<String> {
        let mut names = Vec::new();
        for m in &self.scene.membranes {
            names.extend(MEASURES.iter().map(|c| format!("{}.{c}", m.name)));
            names.extend(m.chords.iter().map(|c| format!("{}.{}", m.name, c.name)));
        }
        for s in &self.scene.level_sets {
            let markers: &[&str] = if s.markers > 0 { &MARKERS } else { &[] };
            names.extend(MEASURES.iter().chain(markers).map(|c| format!("{}.{c}", s.name)));
        }
        let common: &[&str] = if self.scene.fluid.is_prescribed() { &PASSIVE } else { &COMMON };
        names.extend(common.iter().map(ToString::to_string));
        if self.has_map() {
            names.extend(COMPOSED.iter().map(ToString::to_string));
        }
        if self.scene.adapt.is_some() {
            names.extend(ADAPTED.iter().map(ToString::to_string));
        }
        for p in &self.scene.output.probes {
            names.extend(suffixes(p.of).iter().map(|c| format!("{}{c}", p.name)));
        }
        for f in &self.scene.output.forces {
            let moment = f.about.is_some().then_some(["moment", "stress_moment"]);
            let columns = ["x", "y", "stress_x", "stress_y"].into_iter().chain(moment.into_iter().flatten());
            names.extend(columns.map(|c| format!("{}_{c}", f.name)));
        }
        names.extend(self.scene.output.fluxes.iter().map(|f| f.name.clone()));
        names.extend(errors::columns(&self.scene.exact));
        if self.scene.time.tolerance.is_some() {
            names.push("step".into());
        }
        names
    }

    /// One row: a value a column. What cannot be measured (an interface that is gone, the centre and the axes of one that is
    /// passing a periodic side, a force before the first step) is NaN.
    pub fn row(&self, model: &Model) -> Result<Vec<f64>> {
        let sim = &model.simulation;
        let (state, space) = (sim.state(), sim.space());
        let mut row = Vec::new();
        for (k, m) in self.scene.membranes.iter().enumerate() {
            let interface = sim.interface(k)?;
            row.extend(measures(sim, &interface));
            let Interface { space, phi, contour } = &interface;
            for c in &m.chords {
                let half = contour.half_chord(space, phi, &point(&c.through), &point(&c.direction));
                row.push(half.unwrap_or(f64::NAN));
            }
        }
        for k in 0..self.scene.level_sets.len() {
            row.extend(measures(sim, &sim.interface(self.scene.membranes.len() + k)?));
            row.extend(sim.marker_polygon(k).into_iter().flatten());
        }
        if sim.is_prescribed() {
            row.extend([sim.largest_speed(), sim.divergence(), sim.courant()]);
        } else {
            let e = state.energies;
            let over_limit = model.step_limit().map_or(0.0, |limit| sim.settings().dt / limit);
            row.extend([
                e.kinetic,
                e.elastic,
                e.dissipation,
                state.budget.residual(&e),
                state.budget.work,
                sim.largest_speed(),
                e.divergence,
                sim.courant(),
                over_limit,
            ]);
        }
        if let Some((submaps, error)) = sim.map_error() {
            row.extend([submaps as f64, error]);
        }
        if self.scene.adapt.is_some() {
            let unknowns = sim.flow().map_or(0, |flow| flow.numbering().order());
            row.extend([unknowns as f64, state.budget.transferred]);
        }
        for (p, at) in self.scene.output.probes.iter().zip(&self.probes) {
            row.extend(values(sim, at, p.of));
        }
        for f in &self.scene.output.forces {
            let Some(pressure) = sim.flow().map(|flow| flow.pressure().space()) else { continue };
            let about = f.about.as_deref().map_or(Point::<2>::zeros(), point);
            let residual = sim.reaction(&f.boundary, &about)?.unwrap_or(Load::NAN);
            let viscosity = |cell: usize, l: &[f64; 4]| sim.viscosity_at(cell, l);
            let stress = traction(space, pressure, viscosity, &state.flow, &f.boundary, &about)?;
            row.extend([residual.force[0], residual.force[1], stress.force[0], stress.force[1]]);
            if f.about.is_some() {
                row.extend([residual.moment[2], stress.moment[2]]);
            }
        }
        for f in &self.scene.output.fluxes {
            row.push(flux(space, &state.flow, &f.boundary)?);
        }
        row.extend(errors::row(&self.scene.exact, sim));
        if self.scene.time.tolerance.is_some() {
            row.push(sim.settings().dt);
        }
        Ok(row)
    }

    /// Whether there is a backward map to report on.
    fn has_map(&self) -> bool {
        self.scene.numerics.transport == Method::Composed && self.scene.interfaces().next().is_some()
    }

    /// Values along profile number `k`, point by point: one list for each component, with the end of its column's name.
    pub fn profile(&self, sim: &Simulation<2>, k: usize) -> Vec<(&'static str, Vec<f64>)> {
        let of = self.scene.output.profiles[k].of;
        let rows: Vec<Vec<f64>> = self.profiles[k].iter().map(|(_, at)| values(sim, at, of)).collect();
        let column = |i: usize| rows.iter().map(|row| row[i]).collect();
        suffixes(of).iter().enumerate().map(|(i, suffix)| (*suffix, column(i))).collect()
    }

    /// The points of profile number `k`.
    pub fn profile_points(&self, k: usize) -> impl Iterator<Item = &Point<2>> {
        self.profiles[k].iter().map(|(x, _)| x)
    }
}

/// [`MEASURES`] of an interface.
fn measures(sim: &Simulation<2>, interface: &Interface) -> [f64; MEASURES.len()] {
    let contour = &interface.contour;
    // In parts on the two sides of the mesh a membrane has an area and a length, but no place and no form.
    let parted = !sim.translations().is_empty() && contour.lines().iter().any(|l| !l.closed);
    contour.measures().map_or([f64::NAN; MEASURES.len()], |k| {
        let whole = |v: f64| if parted { f64::NAN } else { v };
        let form = [k.centroid[0], k.centroid[1], k.axis_1, k.axis_2, k.angle, k.extent_x, k.extent_y];
        let [x, y, a, b, angle, width, height] = form.map(whole);
        [k.area, k.perimeter, x, y, a, b, angle, width, height]
    })
}

/// Boundary names that the output uses: table, entry, boundary.
fn named_boundaries(scene: &Scene) -> impl Iterator<Item = (&'static str, &str, &str)> {
    let forces = scene.output.forces.iter().map(|f| ("forces", f.name.as_str(), f.boundary.as_str()));
    let fluxes = scene.output.fluxes.iter().map(|f| ("fluxes", f.name.as_str(), f.boundary.as_str()));
    forces.chain(fluxes)
}

fn point(x: &[f64]) -> Point<2> {
    Point::<2>::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0))
}

fn line(p: &Profile) -> impl Iterator<Item = Point<2>> {
    let (from, to, n) = (point(&p.from), point(&p.to), p.points);
    (0..n).map(move |i| from + (to - from) * (i as f64 / (n - 1) as f64))
}

/// What the columns of a quantity end with, one a component.
fn suffixes(of: Quantity) -> &'static [&'static str] {
    match of {
        Quantity::Velocity => &["_x", "_y"],
        _ => &[""],
    }
}

/// The components of a quantity at a point.
fn values(sim: &Simulation<2>, at: &Location, of: Quantity) -> Vec<f64> {
    let (state, space, cell) = (sim.state(), sim.space(), at.cell as usize);
    let velocity = || space.value(&state.flow.u, cell, &at.barycentric);
    // A scene asks for a level set only when there is exactly one.
    let phi = |f: &dyn Fn(&[f64]) -> f64| vec![f(&sim.level_set(0))];
    match of {
        Quantity::Pressure => vec![
            sim.flow().map_or(f64::NAN, |flow| flow.pressure().space().value(&state.flow.p, cell, &at.barycentric)),
        ],
        Quantity::Velocity => velocity().iter().copied().collect(),
        Quantity::Speed => vec![velocity().norm()],
        Quantity::LevelSet => phi(&|f| space.value(f, cell, &at.barycentric)),
        Quantity::Stretch => phi(&|f| space.gradient(f, cell, &at.barycentric).norm()),
    }
}
