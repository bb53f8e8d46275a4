//! Columns and fields of the geometry of interfaces: delta functions, curvatures, curves.

use super::keys::Named;
use super::row::Row;
use super::schema::{Curve, DeltaName};
use super::site::BAND;
use super::view::View;
use crate::base::Result;
use crate::fem::{Recovery, Space, SurfacePoint};
use crate::levelset::{
    Curvature, Delta, Frenet, Smeared, SpaceCurve, Width, band_edges, vertices_near,
};
use std::any::Any;

/// Degree of the quadrature of smeared delta functions.
const DEGREE: usize = 10;

/// Suffixes of the columns of a curvature.
const ENDS: [&str; 3] = ["min", "max", "mean"];

/// Measures interface number `k` with the delta functions and curvatures requested by the scene;
/// NaN if the interface has vanished.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn measure<const D: usize>(view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
    let output = &view.tables.output;
    if output.deltas.is_empty() && !output.curvature {
        return Ok(());
    }
    let name = format!("{}.", view.carried.structures()[k].name());
    let [enclosed, own] = if D == 2 { ["area", "perimeter"] } else { ["volume", "surface"] };
    let (space, phi) = (view.space(), view.level_set(k));
    for of in &output.deltas {
        let delta = match of {
            DeltaName::Smeared => Delta::Smeared(smeared(view, k, &phi)),
            DeltaName::Smereka1 => Delta::Smereka1,
            DeltaName::Smereka2 => Delta::Smereka2,
            DeltaName::Towers => Delta::Towers,
        };
        let (surface, inside) = (delta.measure(space, &phi)?, delta.inside(space, &phi)?);
        let found = |v: f64| if surface > 0.0 { v } else { f64::NAN };
        row.put(format!("{name}{own}_{}", of.word()), found(surface));
        if let Some(inside) = inside {
            row.put(format!("{name}{enclosed}_{}", of.word()), found(inside));
        }
    }
    if output.curvature {
        let (points, curvature, mesh) = (view.surface(k)?, near(space, &phi), space.mesh());
        let mean = spread(&points, |p| curvature.mean_at(mesh, p.at.cell, &p.at.barycentric));
        row.put_all(&format!("{name}curvature_"), ENDS.into_iter().zip(mean));
        if D == 3 {
            let gauss = spread(&points, |p| curvature.gauss_at(mesh, p.at.cell, &p.at.barycentric));
            row.put_all(&format!("{name}gauss_curvature_"), ENDS.into_iter().zip(gauss));
        }
    }
    Ok(())
}

/// Minimum, maximum and mean on an interface.
fn spread<const D: usize>(
    points: &[SurfacePoint<D>],
    f: impl Fn(&SurfacePoint<D>) -> f64,
) -> [f64; 3] {
    let (mut least, mut most, mut sum, mut size) = (f64::NAN, f64::NAN, 0.0, 0.0);
    for p in points {
        let value = f(p);
        // `min` and `max` ignore the initial NaN.
        (least, most) = (least.min(value), most.max(value));
        (sum, size) = (sum + p.at.weight * value, size + p.at.weight);
    }
    [least, most, sum / size]
}

/// The curvatures at the vertices of the cells that the interface crosses.
fn near<const D: usize>(space: &Space<D>, phi: &[f64]) -> Curvature {
    Curvature::new(&Recovery::new(space.mesh()), space, phi, &vertices_near(space, phi, 0.0))
}

/// The smeared delta function of interface number `k`: over the band of a membrane; for a passive
/// level set over a renormalised band of the same kind.
fn smeared<const D: usize>(view: &View<'_, D>, k: usize, phi: &[f64]) -> Smeared {
    let numerics = &view.tables.numerics;
    let edge = || band_edges(view.space(), phi, 0.0).map_or(0.0, |e| e.largest);
    let carried = view.carried_bands.get(k).copied().flatten();
    Smeared {
        kernel: numerics.kernel,
        width: carried.map_or(Width::Renormalised(numerics.width), Width::Carried),
        thickness: view.thickness.or(numerics.thickness).unwrap_or_else(|| BAND * edge()),
        degree: DEGREE,
    }
}

/// Mean and, in space, Gauss curvature of an interface with the suffixes of their names: P1
/// functions, nonzero only at the vertices of the cells that the interface crosses.
pub(super) fn fields<const D: usize>(
    view: &View<'_, D>,
    k: usize,
) -> Vec<(&'static str, Vec<f64>)> {
    let Curvature { mean, gauss } = near(view.space(), &view.level_set(k));
    let mut fields = vec![("curvature", mean)];
    if D == 3 {
        fields.push(("gauss_curvature", gauss));
    }
    fields
}

/// Suffixes of the columns of a curve, after its name and `_`.
const CURVE_COLUMNS: [&str; 6] =
    ["length", "curvature_mean", "curvature_max", "torsion_min", "torsion_max", "torsion_mean"];

/// Measures a curve between two interfaces in space; NaN if they do not intersect.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn measure_curve<const D: usize>(
    view: &View<'_, D>,
    curve: &Named<Curve>,
    row: &mut Row,
) -> Result<()> {
    let structures = view.carried.structures();
    let number = |name: &String| structures.iter().position(|s| s.name() == name).unwrap_or(0);
    let [a, b] = [0, 1].map(|i| view.level_set(number(&curve.of[i])));
    let space: &dyn Any = &**view.space();
    let values = match space.downcast_ref::<Space<3>>() {
        Some(space) => curve_values(space, [&a, &b])?,
        None => [f64::NAN; 6],
    };
    row.put_all(&format!("{}_", curve.name), CURVE_COLUMNS.into_iter().zip(values));
    Ok(())
}

fn curve_values(space: &Space<3>, level_sets: [&[f64]; 2]) -> Result<[f64; 6]> {
    let found = SpaceCurve::new(&Recovery::new(space.mesh()), space, level_sets)?;
    if found.is_empty() {
        return Ok([f64::NAN; 6]);
    }
    let length = found.length();
    let (mut bent, mut least, mut most) = (f64::NAN, f64::NAN, f64::NAN);
    for p in found.points() {
        bent = p.frenet.curvature.max(bent);
        (least, most) = (p.frenet.torsion.min(least), p.frenet.torsion.max(most));
    }
    let mean = |f: &dyn Fn(&Frenet) -> f64| found.integrate(|p| f(&p.frenet)) / length;
    Ok([length, mean(&|f| f.curvature), bent, least, most, mean(&|f| f.torsion)])
}
