//! Columns and fields of the geometry of interfaces: delta functions, curvatures, curves.

use super::Scene;
use super::dimension::{Dimension, In};
use super::model::{BAND, Model, band_of};
use super::schema::{Curve, DeltaName};
use crate::base::Result;
use crate::elastic::Band;
use crate::fem::{Recovery, Space, SurfacePoint};
use crate::levelset::{Curvature, Delta, Smeared, SpaceCurve, Width, band_edges, vertices_near};
use crate::sim::Simulation;

/// Degree of the quadrature of smeared delta functions.
const DEGREE: usize = 10;

/// What the columns of a curvature end with.
const ENDS: [&str; 3] = ["min", "max", "mean"];

/// The columns of each interface, after its name and a dot.
pub(super) fn columns<const D: usize>(scene: &Scene) -> Vec<String>
where
    In<D>: Dimension<D>,
{
    let mut names = Vec::new();
    for delta in &scene.output.deltas {
        names.push(format!("{}_{}", In::<D>::MEASURES[1], delta.word()));
        if has_inside(*delta) {
            names.push(format!("{}_{}", In::<D>::MEASURES[0], delta.word()));
        }
    }
    if scene.output.curvature {
        names.extend(ENDS.iter().map(|end| format!("curvature_{end}")));
        if D == 3 {
            names.extend(ENDS.iter().map(|end| format!("gauss_curvature_{end}")));
        }
    }
    names
}

fn has_inside(delta: DeltaName) -> bool {
    matches!(delta, DeltaName::Smeared | DeltaName::Towers)
}

/// The values of [`columns`] for interface number `k`; NaN where it is gone.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn row<const D: usize>(scene: &Scene, model: &Model<D>, k: usize) -> Result<Vec<f64>>
where
    In<D>: Dimension<D>,
{
    let mut row = Vec::new();
    if scene.output.deltas.is_empty() && !scene.output.curvature {
        return Ok(row);
    }
    let (space, phi) = (model.simulation.space(), model.simulation.level_set(k));
    for name in &scene.output.deltas {
        let delta = match name {
            DeltaName::Smeared => Delta::Smeared(smeared(scene, model, k, &phi)),
            DeltaName::Smereka1 => Delta::Smereka1,
            DeltaName::Smereka2 => Delta::Smereka2,
            DeltaName::Towers => Delta::Towers,
        };
        let (surface, inside) = In::<D>::delta(space, &phi, &delta)?;
        let found = |v: f64| if surface > 0.0 { v } else { f64::NAN };
        row.push(found(surface));
        row.extend(inside.map(found));
    }
    if scene.output.curvature {
        let points = In::<D>::surface(space, &phi)?;
        let curvature = near(space, &phi);
        let mesh = space.mesh();
        row.extend(spread(&points, |p| curvature.mean_at(mesh, p.at.cell, &p.at.barycentric)));
        if D == 3 {
            row.extend(spread(&points, |p| curvature.gauss_at(mesh, p.at.cell, &p.at.barycentric)));
        }
    }
    Ok(row)
}

/// Least, largest and mean value on an interface.
fn spread<const D: usize>(points: &[SurfacePoint<D>], f: impl Fn(&SurfacePoint<D>) -> f64) -> [f64; 3] {
    let (mut least, mut most, mut sum, mut size) = (f64::NAN, f64::NAN, 0.0, 0.0);
    for p in points {
        let value = f(p);
        // `min` and `max` pass over the NaN at the start.
        (least, most) = (least.min(value), most.max(value));
        (sum, size) = (sum + p.at.weight * value, size + p.at.weight);
    }
    [least, most, sum / size]
}

/// The curvatures at the vertices of the cells that the interface crosses.
fn near<const D: usize>(space: &Space<D>, phi: &[f64]) -> Curvature {
    Curvature::new(&Recovery::new(space.mesh()), space, phi, &vertices_near(space, phi, 0.0))
}

/// The smeared delta function of interface number `k`: over the band of a membrane; for a level set over one of the same kind, renormalised.
fn smeared<const D: usize>(scene: &Scene, model: &Model<D>, k: usize, phi: &[f64]) -> Smeared {
    let numerics = &scene.numerics;
    let carried = scene.membranes.get(k).filter(|m| band_of(scene, m) == Band::Carried);
    let edge = || band_edges(model.simulation.space(), phi, 0.0).map_or(0.0, |e| e.largest);
    Smeared {
        kernel: numerics.kernel,
        width: carried.map_or(Width::Renormalised(numerics.width), |m| Width::Carried(m.stretch)),
        thickness: model.thickness.or(numerics.thickness).unwrap_or_else(|| BAND * edge()),
        degree: DEGREE,
    }
}

/// Mean and, in space, Gauss curvature of every interface, by the ends of their names: P1 functions, zero but at the vertices of the cells that it crosses.
pub(super) fn fields<const D: usize>(sim: &Simulation<D>, k: usize) -> Vec<(&'static str, Vec<f64>)> {
    let Curvature { mean, gauss } = near(sim.space(), &sim.level_set(k));
    let mut fields = vec![("curvature", mean)];
    if D == 3 {
        fields.push(("gauss_curvature", gauss));
    }
    fields
}

/// What the columns of a curve end with, after its name and `_`.
pub(super) const CURVE_COLUMNS: [&str; 6] =
    ["length", "curvature_mean", "curvature_max", "torsion_min", "torsion_max", "torsion_mean"];

/// The values of [`CURVE_COLUMNS`]; NaN where the interfaces do not meet.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn curve_row(scene: &Scene, sim: &Simulation<3>, curve: &Curve) -> Result<[f64; 6]> {
    let number = |name: &String| scene.interfaces().position(|(n, _)| n == name).unwrap_or(0);
    let [a, b] = [0, 1].map(|i| sim.level_set(number(&curve.of[i])));
    let space = sim.space();
    let found = SpaceCurve::new(&Recovery::new(space.mesh()), space, [&a, &b])?;
    if found.is_empty() {
        return Ok([f64::NAN; 6]);
    }
    let length = found.length();
    let (mut bent, mut least, mut most) = (f64::NAN, f64::NAN, f64::NAN);
    for p in found.points() {
        bent = p.frenet.curvature.max(bent);
        (least, most) = (p.frenet.torsion.min(least), p.frenet.torsion.max(most));
    }
    let mean = |f: &dyn Fn(&crate::levelset::Frenet) -> f64| found.integrate(|p| f(&p.frenet)) / length;
    Ok([length, mean(&|f| f.curvature), bent, least, most, mean(&|f| f.torsion)])
}
