//! Measurements common to all problems: structures, transport, probes, profiles, fluxes, curves,
//! errors.

use super::points::point;
use super::problem::ProfileColumn;
use super::row::Row;
use super::schema::{Profile, Quantity};
use super::script::Script;
use super::structures::{StructureKind, kind_in};
use super::view::{AXES, View};
use super::{errors, geometry};
use crate::base::{Error, Result};
use crate::flow::flux;
use crate::mesh::{Location, Locator, Mesh, Point};
use crate::structure::Density;
use std::cell::OnceCell;

/// Points of all probes and profiles of a scene in a mesh.
pub(super) struct Probes<const D: usize> {
    probes: Vec<Location>,
    profiles: Vec<Vec<(Point<D>, Location)>>,
}

impl<const D: usize> Probes<D> {
    /// Locates the points, and checks the boundary names in the output.
    ///
    /// # Errors
    /// A point outside the mesh, or a boundary that the mesh does not have.
    pub fn new(script: &Script, mesh: &Mesh<D>) -> Result<Probes<D>> {
        let (output, locator) = (&script.output, Locator::new(mesh));
        let locate = |x: Point<D>, keys: [&str; 3]| {
            locator.locate(mesh, &x).ok_or_else(|| {
                let (lo, hi) = mesh.bounding_box();
                let remedy = format!(
                    "give a point of the mesh, which spans {:?} to {:?}",
                    lo.as_slice(),
                    hi.as_slice()
                );
                let e = Error::scene("the point lies outside the mesh");
                script.blame(&keys, e.value(format!("{:?}", x.as_slice())).remedy(remedy))
            })
        };
        let probes = output.probes.iter();
        let probes = probes.map(|p| locate(point(&p.at), ["output", "probes", &p.name]));
        let probes = probes.collect::<Result<_>>()?;
        let mut profiles = Vec::new();
        for p in &output.profiles {
            let points = line(p).map(|x| Ok((x, locate(x, ["output", "profiles", &p.name])?)));
            profiles.push(points.collect::<Result<_>>()?);
        }
        let forces = output.forces.iter().map(|f| ("forces", &f.name, &f.boundary));
        let fluxes = output.fluxes.iter().map(|f| ("fluxes", &f.name, &f.boundary));
        for (table, name, boundary) in forces.chain(fluxes) {
            let place = |e| script.blame(&["output", table, name, "boundary"], e);
            mesh.boundary(boundary).map_err(place)?;
        }
        Ok(Probes { probes, profiles })
    }

    /// Measures at the probes.
    pub fn measure(&self, view: &View<'_, D>, row: &mut Row) {
        let fields = Derived::of(view);
        for (p, at) in view.tables.output.probes.iter().zip(&self.probes) {
            row.put_all(&p.name, suffixes(p.of, D).iter().zip(fields.values(at, p.of)));
        }
    }

    /// Values along profile number `k`, point by point; one list for each component.
    pub fn profile(&self, view: &View<'_, D>, k: usize) -> Vec<ProfileColumn> {
        let (of, fields) = (view.tables.output.profiles[k].of, Derived::of(view));
        let points = self.profiles[k].iter();
        let rows: Vec<Vec<f64>> = points.map(|(_, at)| fields.values(at, of)).collect();
        let column = |i: usize| rows.iter().map(|row| row[i]).collect();
        suffixes(of, D).iter().enumerate().map(|(i, suffix)| (*suffix, column(i))).collect()
    }

    /// Coordinates of the points of profile number `k`.
    pub fn points(&self, k: usize) -> Vec<Vec<f64>> {
        self.profiles[k].iter().map(|(x, _)| x.iter().copied().collect()).collect()
    }
}

/// Measures all structures.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn structures<const D: usize>(
    view: &View<'_, D>,
    kinds: &[Box<dyn StructureKind>],
    row: &mut Row,
) -> Result<()> {
    for (k, kind) in kinds.iter().enumerate() {
        kind_in::<D>(&**kind)?.measure(view, k, row)?;
        if kind.shape().is_some() {
            geometry::measure(view, k, row)?;
        }
    }
    Ok(())
}

/// Measures the maps of the transport.
pub(super) fn maps<const D: usize>(view: &View<'_, D>, row: &mut Row) {
    if let Some((submaps, error)) = view.carried.map_error(&view.state.fields) {
        row.put("submaps", submaps as f64);
        row.put("map_error", error);
    }
    if view.has_backward_map() {
        row.put("determinant_error", view.carried.determinant_error(&view.state.fields));
    }
}

/// Measures fluxes, curves between interfaces and errors against the exact solution.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn rest<const D: usize>(view: &View<'_, D>, row: &mut Row) -> Result<()> {
    for f in &view.tables.output.fluxes {
        row.put(f.name.clone(), flux(view.space(), &view.state.flow, &f.boundary)?);
    }
    for curve in &view.tables.output.curves {
        geometry::measure_curve(view, curve, row)?;
    }
    errors::measure(view, row);
    Ok(())
}

/// Longest edges of a cell to the interface, beyond which it has no stretch to be measured.
const NEAR: f64 = 2.0;

fn line<const D: usize>(p: &Profile) -> impl Iterator<Item = Point<D>> {
    let (from, to, n) = (point(&p.from), point(&p.to), p.points);
    (0..n).map(move |i| from + (to - from) * (i as f64 / (n - 1) as f64))
}

/// Suffixes of the columns of a quantity, one for each component.
fn suffixes(of: Quantity, dimension: usize) -> &'static [&'static str] {
    match of {
        Quantity::Velocity => &["_x", "_y", "_z"][..dimension],
        _ => &[""],
    }
}

/// The fields of a problem, and derived fields computed on demand.
struct Derived<'a, const D: usize> {
    view: &'a View<'a, D>,
    vorticity: OnceCell<Vec<f64>>,
}

impl<'a, const D: usize> Derived<'a, D> {
    fn of(view: &'a View<'a, D>) -> Derived<'a, D> {
        Derived { view, vorticity: OnceCell::new() }
    }

    /// The components of a quantity at a point.
    fn values(&self, at: &Location, of: Quantity) -> Vec<f64> {
        let (state, space, cell) = (self.view.state, self.view.space(), at.cell as usize);
        let l = &at.barycentric;
        let velocity = || space.value(&state.flow.u, cell, l);
        let vorticity = || self.vorticity.get_or_init(|| space.vorticity(&state.flow.u));
        // There is exactly one level set when a scene requests it.
        let phi = |f: &dyn Fn(&[f64]) -> f64| vec![f(&self.view.level_set(0))];
        let pressure = || {
            let value = |flow: &crate::flow::FlowSolver<D>| {
                flow.pressure().space().value(&state.flow.p, cell, l)
            };
            self.view.flow.filter(|_| state.has_pressure()).map_or(f64::NAN, value)
        };
        match of {
            Quantity::Pressure => vec![pressure()],
            Quantity::Velocity => velocity().iter().copied().collect(),
            Quantity::Speed => vec![velocity().norm()],
            Quantity::Vorticity => vec![space.value(vorticity(), cell, l)],
            Quantity::LevelSet => phi(&|f| space.value(f, cell, l)),
            // Where the interface carries its stretch the slope is none.
            Quantity::Stretch => match self.view.carried.structures()[0].surface_density() {
                Some((id, Density::Rest)) => {
                    let stretch = 1.0 / space.value(state.fields.scalar(id), cell, l);
                    // Beyond the cells about the interface its field is a fill value.
                    let reach = NEAR * self.view.carried.mesh().diameter(cell);
                    let slope = self.view.carried.structures()[0].slope();
                    let near = phi(&|f| space.value(f, cell, l))[0].abs() < reach * slope;
                    vec![if near && stretch.is_finite() { stretch } else { f64::NAN }]
                }
                _ => phi(&|f| space.gradient(f, cell, l).norm()),
            },
            // Available in pictures only.
            Quantity::AreaChange | Quantity::Shear | Quantity::Image | Quantity::Checkerboard => {
                vec![f64::NAN]
            }
        }
    }
}

/// Names of the components of a force, or of its moment, which has one component in the plane.
pub(super) fn force_columns(dimension: usize, moment: bool) -> Vec<String> {
    match (moment, dimension) {
        (false, _) => AXES[..dimension].iter().map(ToString::to_string).collect(),
        (true, 2) => vec!["moment".into()],
        (true, _) => AXES.iter().map(|axis| format!("moment_{axis}")).collect(),
    }
}
