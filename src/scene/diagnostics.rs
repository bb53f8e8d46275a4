//! What a run measures: the columns of the series, and profiles along lines.

use super::Scene;
use super::dimension::{Dimension, In, point};
use super::drops;
use super::errors;
use super::geometry::{self, CURVE_COLUMNS};
use super::image::Answer;
use super::model::Model;
use super::schema::{Profile, Quantity};
use crate::base::{Error, Result};
use crate::flow::{Load, flux, traction};
use crate::mesh::{Location, Locator, Point};
use crate::sim::Simulation;
use crate::transport::Method;
use std::cell::OnceCell;

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
/// The columns that a run has which segments an image: energies, mean levels inside and outside, connected parts of the inside.
const SEGMENTED: [&str; 6] = ["energy", "energy_fidelity", "energy_length", "c1", "c2", "components"];
/// The columns that a known answer adds.
const ANSWERED: [&str; 2] = ["area_error", "misclassified"];
/// The columns that composed transport adds.
const COMPOSED: [&str; 2] = ["submaps", "map_error"];
/// The columns that a mesh which follows adds.
const ADAPTED: [&str; 2] = ["unknowns", "energy_transferred"];
/// The columns that markers add to a level set.
const MARKERS: [&str; 2] = ["markers_length", "markers_area"];

/// Measures a simulation in the way that a scene asks for.
pub struct Diagnostics<'a, const D: usize = 2> {
    scene: &'a Scene,
    probes: Vec<Location>,
    profiles: Vec<Vec<(Point<D>, Location)>>,
    answer: Option<Answer>,
}

impl<'a, const D: usize> Diagnostics<'a, D>
where
    In<D>: Dimension<D>,
{
    /// Finds the points of all probes and profiles.
    ///
    /// # Errors
    /// A point outside the mesh, or a boundary that the mesh does not have.
    pub fn new(scene: &'a Scene, model: &Model<D>) -> Result<Diagnostics<'a, D>> {
        let mesh = model.simulation.space().mesh();
        let locator = Locator::new(mesh);
        let locate = |x: Point<D>, keys: [&str; 3]| {
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
        Ok(Diagnostics { scene, probes, profiles, answer: Answer::of(scene)? })
    }

    /// The names of the columns, without `time`.
    pub fn columns(&self) -> Vec<String> {
        let mut names = Vec::new();
        for m in &self.scene.membranes {
            names.extend(In::<D>::MEASURES.iter().map(|c| format!("{}.{c}", m.name)));
            names.extend(m.chords.iter().map(|c| format!("{}.{}", m.name, c.name)));
            for ring in &m.rings {
                let modes = ring.modes.iter().map(|mode| format!("mode_{mode}"));
                let columns = std::iter::once("radius".to_string()).chain(modes);
                names.extend(columns.map(|c| format!("{}.{}_{c}", m.name, ring.name)));
            }
            let own: &[&str] = if m.drop.is_some() { In::<D>::DROP } else { &[] };
            names.extend(self.strain().chain(own.iter().copied()).map(|c| format!("{}.{c}", m.name)));
            names.extend(geometry::columns::<D>(self.scene).iter().map(|c| format!("{}.{c}", m.name)));
        }
        for s in &self.scene.level_sets {
            let markers: &[&str] = if s.markers > 0 { &MARKERS } else { &[] };
            names.extend(In::<D>::MEASURES.iter().map(|c| format!("{}.{c}", s.name)));
            names.extend(self.strain().chain(markers.iter().copied()).map(|c| format!("{}.{c}", s.name)));
            names.extend(geometry::columns::<D>(self.scene).iter().map(|c| format!("{}.{c}", s.name)));
        }
        let common: &[&str] = match (&self.scene.image, self.scene.fluid.is_prescribed()) {
            (Some(_), _) => &SEGMENTED,
            (None, true) => &PASSIVE,
            (None, false) => &COMMON,
        };
        names.extend(common.iter().map(ToString::to_string));
        if self.answer.is_some() {
            names.extend(ANSWERED.iter().map(ToString::to_string));
        }
        if self.has_map() {
            names.extend(COMPOSED.iter().map(ToString::to_string));
        }
        if has_backward_map(self.scene) {
            names.push("determinant_error".into());
        }
        if self.scene.adapt.is_some() {
            names.extend(ADAPTED.iter().map(ToString::to_string));
        }
        for p in &self.scene.output.probes {
            names.extend(suffixes(p.of, D).iter().map(|c| format!("{}{c}", p.name)));
        }
        for f in &self.scene.output.forces {
            let columns = force_columns(D, f.about.is_some());
            names.extend(columns.iter().map(|c| format!("{}_{c}", f.name)));
        }
        names.extend(self.scene.output.fluxes.iter().map(|f| f.name.clone()));
        for curve in &self.scene.output.curves {
            names.extend(CURVE_COLUMNS.iter().map(|c| format!("{}_{c}", curve.name)));
        }
        names.extend(errors::columns(&self.scene.exact));
        if self.scene.time.tolerance.is_some() {
            names.push("step".into());
        }
        names
    }

    /// One row: a value a column. What cannot be measured is NaN: an interface that is gone; of one that is passing a periodic side the axes,
    /// and centre and extent along the way through it; a force before the first step.
    pub fn row(&self, model: &Model<D>) -> Result<Vec<f64>> {
        let sim = &model.simulation;
        let (state, space, fields) = (sim.state(), sim.space(), Fields::of(sim));
        let mut row = Vec::new();
        for (k, m) in self.scene.membranes.iter().enumerate() {
            let measured = In::<D>::measure(sim, k, &m.chords, &m.rings)?;
            let own = m.drop.is_some().then(|| drops::row(sim, k, [measured[0], measured[1]])).transpose()?;
            row.extend(measured.into_iter().chain(own.into_iter().flatten()));
            row.extend(geometry::row(self.scene, model, k)?);
        }
        for k in 0..self.scene.level_sets.len() {
            let k = self.scene.membranes.len() + k;
            row.extend(In::<D>::measure(sim, k, &[], &[])?);
            row.extend(geometry::row(self.scene, model, k)?);
        }
        if let Some((fit, parts)) = sim.segmented()? {
            let [c1, c2] = fit.levels;
            row.extend([fit.fidelity + fit.length, fit.fidelity, fit.length, c1, c2, parts as f64]);
            row.extend(self.answer.iter().flat_map(|answer| In::<D>::compare(answer, sim)));
        } else if sim.is_prescribed() {
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
        if sim.has_backward_map() {
            row.push(sim.determinant_error());
        }
        if self.scene.adapt.is_some() {
            let unknowns = sim.flow().map_or(0, |flow| flow.numbering().order());
            row.extend([unknowns as f64, state.budget.transferred]);
        }
        for (p, at) in self.scene.output.probes.iter().zip(&self.probes) {
            row.extend(fields.values(at, p.of));
        }
        for f in &self.scene.output.forces {
            let Some(pressure) = sim.flow().map(|flow| flow.pressure().space()) else { continue };
            let about = f.about.as_deref().map_or(Point::<D>::zeros(), point);
            let residual = sim.reaction(&f.boundary, &about)?.unwrap_or(Load::NAN);
            let viscosity = |cell: usize, l: &[f64; 4]| sim.viscosity_at(cell, l);
            let stress = traction(space, pressure, viscosity, &state.flow, &f.boundary, &about)?;
            row.extend(residual.force.iter().chain(&stress.force));
            if f.about.is_some() {
                // In the plane a moment has the last component alone.
                let turns = if D == 2 { 2..3 } else { 0..3 };
                row.extend(turns.clone().map(|i| residual.moment[i]).chain(turns.map(|i| stress.moment[i])));
            }
        }
        for f in &self.scene.output.fluxes {
            row.push(flux(space, &state.flow, &f.boundary)?);
        }
        for curve in &self.scene.output.curves {
            row.extend(In::<D>::curve(self.scene, sim, curve)?);
        }
        row.extend(errors::row(&self.scene.exact, sim));
        if self.scene.time.tolerance.is_some() {
            row.push(sim.settings().dt);
        }
        Ok(row)
    }

    /// The columns of strains, where there are any.
    fn strain(&self) -> impl Iterator<Item = &'static str> {
        let columns: &[&str] = if has_backward_map(self.scene) { In::<D>::STRAIN } else { &[] };
        columns.iter().copied()
    }

    /// Whether there is a chain of submaps to report on.
    fn has_map(&self) -> bool {
        self.scene.numerics.transport == Method::Composed && self.scene.interfaces().next().is_some()
    }

    /// Values along profile number `k`, point by point: one list for each component, with the end of its column's name.
    pub fn profile(&self, sim: &Simulation<D>, k: usize) -> Vec<(&'static str, Vec<f64>)> {
        let (of, fields) = (self.scene.output.profiles[k].of, Fields::of(sim));
        let rows: Vec<Vec<f64>> = self.profiles[k].iter().map(|(_, at)| fields.values(at, of)).collect();
        let column = |i: usize| rows.iter().map(|row| row[i]).collect();
        suffixes(of, D).iter().enumerate().map(|(i, suffix)| (*suffix, column(i))).collect()
    }

    /// The points of profile number `k`.
    pub fn profile_points(&self, k: usize) -> impl Iterator<Item = &Point<D>> {
        self.profiles[k].iter().map(|(x, _)| x)
    }
}

/// Whether the run of a scene carries the backward characteristics.
pub(super) fn has_backward_map(scene: &Scene) -> bool {
    scene.output.backward_map || scene.membranes.iter().any(|m| m.surface.is_some())
}

/// Boundary names that the output uses: table, entry, boundary.
fn named_boundaries(scene: &Scene) -> impl Iterator<Item = (&'static str, &str, &str)> {
    let forces = scene.output.forces.iter().map(|f| ("forces", f.name.as_str(), f.boundary.as_str()));
    let fluxes = scene.output.fluxes.iter().map(|f| ("fluxes", f.name.as_str(), f.boundary.as_str()));
    forces.chain(fluxes)
}

fn line<const D: usize>(p: &Profile) -> impl Iterator<Item = Point<D>> {
    let (from, to, n) = (point(&p.from), point(&p.to), p.points);
    (0..n).map(move |i| from + (to - from) * (i as f64 / (n - 1) as f64))
}

/// What the columns of a force end with, after its name and `_`.
fn force_columns(dimension: usize, with_moment: bool) -> Vec<String> {
    let components = &["x", "y", "z"][..dimension];
    let of = |way: &'static str| components.iter().map(move |c| format!("{way}{c}"));
    let mut columns: Vec<String> = of("").chain(of("stress_")).collect();
    match (with_moment, dimension) {
        (false, _) => {}
        (true, 2) => columns.extend(["moment", "stress_moment"].map(String::from)),
        (true, _) => columns.extend(of("moment_").chain(of("stress_moment_"))),
    }
    columns
}

/// What the columns of a quantity end with, one a component.
fn suffixes(of: Quantity, dimension: usize) -> &'static [&'static str] {
    match of {
        Quantity::Velocity => &["_x", "_y", "_z"][..dimension],
        _ => &[""],
    }
}

/// The fields of a simulation, and those that are derived from them once they are asked for.
struct Fields<'a, const D: usize> {
    sim: &'a Simulation<D>,
    vorticity: OnceCell<Vec<f64>>,
}

impl<'a, const D: usize> Fields<'a, D> {
    fn of(sim: &'a Simulation<D>) -> Fields<'a, D> {
        Fields { sim, vorticity: OnceCell::new() }
    }

    /// The components of a quantity at a point.
    fn values(&self, at: &Location, of: Quantity) -> Vec<f64> {
        let sim = self.sim;
        let (state, space, cell) = (sim.state(), sim.space(), at.cell as usize);
        let velocity = || space.value(&state.flow.u, cell, &at.barycentric);
        let vorticity = || self.vorticity.get_or_init(|| space.vorticity(&state.flow.u));
        // A scene asks for a level set only when there is exactly one.
        let phi = |f: &dyn Fn(&[f64]) -> f64| vec![f(&sim.level_set(0))];
        match of {
            Quantity::Pressure => vec![
                sim.flow().map_or(f64::NAN, |flow| flow.pressure().space().value(&state.flow.p, cell, &at.barycentric)),
            ],
            Quantity::Velocity => velocity().iter().copied().collect(),
            Quantity::Speed => vec![velocity().norm()],
            Quantity::Vorticity => vec![space.value(vorticity(), cell, &at.barycentric)],
            Quantity::LevelSet => phi(&|f| space.value(f, cell, &at.barycentric)),
            Quantity::Stretch => phi(&|f| space.gradient(f, cell, &at.barycentric).norm()),
            // Asked for in pictures alone.
            Quantity::AreaChange | Quantity::Shear | Quantity::Image | Quantity::Checkerboard => vec![f64::NAN],
        }
    }
}
