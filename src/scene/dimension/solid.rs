//! Scenes of space.

use super::super::refined::refined;
use super::{Dimension, In, coordinates, other_dimension, parted, point};
use crate::base::{Error, Result, Warning};
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{
    self, Circle, Cutter, Delta, Ellipsoid, Isosurface, LevelSolid, RoundedBlock, Shape as Distance, SolidUnion, Torus,
};
use crate::mesh::{Mesh, Point, gmsh};
use crate::scene::Scene;
use crate::scene::geometry::{CURVE_COLUMNS, curve_row};
use crate::scene::schema::{Chord, Curve, MeshSource, Ring, Shape};
use crate::sim::Simulation;
use std::f64::consts::PI;

/// Number of [`MEASURES`](Dimension::MEASURES).
const COUNT: usize = 11;

impl Dimension<3> for In<3> {
    const MEASURES: &'static [&'static str] = &[
        "volume", "surface", "centre_x", "centre_y", "centre_z", "axis_1", "axis_2", "axis_3", "extent_x", "extent_y",
        "extent_z",
    ];
    const CELLS: &'static str = "tetrahedra";
    const DROP: &'static [&'static str] = &["sphericity", "velocity_x", "velocity_y", "velocity_z"];
    const CUTTER: Cutter<3> = Cutter::SPACE;
    const STRAIN: &'static [&'static str] =
        &["determinant_error", "area_change_min", "area_change_max", "shear_mean", "shear_max"];

    fn mesh(scene: &Scene) -> Result<(Mesh<3>, Vec<Warning>)> {
        match &scene.mesh {
            MeshSource::File { path, refine, geometry, .. } => {
                let (mesh, warnings) = gmsh::read::<3>(path)?;
                Ok((refined(scene, mesh, *refine, geometry)?, warnings))
            }
            source => {
                let none = || Err(Error::internal("a mesh of the plane reached the mesh of space"));
                let mesh = source.generated().unwrap_or_else(none);
                Ok((mesh.map_err(|e| scene.blame(&["mesh"], e))?, Vec::new()))
            }
        }
    }

    fn shape(shape: &Shape, domain: (Point<3>, Point<3>)) -> Result<Box<dyn Distance<3>>> {
        Ok(match shape {
            Shape::Sphere { centre, radius } => Box::new(Circle::<3>::new(point(centre), *radius)?),
            Shape::Ellipsoid { centre, semi_axes, rotation } => {
                Box::new(Ellipsoid::new(point(centre), point(semi_axes), point(rotation))?)
            }
            Shape::Torus { centre, axis, major, minor } => {
                Box::new(Torus::new(point(centre), point(axis), *major, *minor)?)
            }
            Shape::RoundedBlock { centre, half_size, radius, rotation } => {
                Box::new(RoundedBlock::new(point(centre), point(half_size), *radius, point(rotation))?)
            }
            Shape::Union(parts) => {
                let parts = parts.iter().map(|p| Self::shape(p, domain)).collect::<Result<_>>()?;
                Box::new(SolidUnion::new(parts)?)
            }
            Shape::Expression(e) => {
                let e = e.clone();
                Box::new(LevelSolid::new(move |x: &Point<3>| e.eval(coordinates(x), 0.0), domain)?)
            }
            Shape::Circle { .. } | Shape::Ellipse { .. } | Shape::RoundedBox { .. } | Shape::Polygon(_) => {
                return Err(other_dimension(shape, 3));
            }
        })
    }

    fn surface(space: &Space<3>, phi: &[f64]) -> Result<Vec<SurfacePoint<3>>> {
        levelset::surface_in_space(space, phi)
    }

    fn delta(space: &Space<3>, phi: &[f64], delta: &Delta) -> Result<(f64, Option<f64>)> {
        Ok((delta.measure(space, phi)?, delta.inside(space, phi)?))
    }

    fn curve(scene: &Scene, sim: &Simulation<3>, curve: &Curve) -> Result<[f64; CURVE_COLUMNS.len()]> {
        curve_row(scene, sim, curve)
    }

    fn measure(sim: &Simulation<3>, k: usize, chords: &[Chord], rings: &[Ring]) -> Result<Vec<f64>> {
        let (space, phi) = (sim.space(), sim.level_set(k));
        let surface = Isosurface::new(space, &phi)?;
        let mut row = measures(sim, &surface).to_vec();
        let radius = |x: &Point<3>, d: &Point<3>| surface.half_chord(space, &phi, x, d).unwrap_or(f64::NAN);
        row.extend(chords.iter().map(|c| radius(&point(&c.through), &point(&c.direction))));
        rings.iter().for_each(|r| row.extend(waves(r, radius)));
        if sim.has_backward_map() {
            row.extend(strain(sim, k, &surface.points_of_forms(space, &phi)));
        }
        Ok(row)
    }
}

/// The first columns of an interface.
fn measures(sim: &Simulation<3>, surface: &Isosurface) -> [f64; COUNT] {
    let parted = parted(sim, !surface.walls().is_empty());
    surface.measures().map_or([f64::NAN; COUNT], |k| {
        let whole = |v: f64| if parted.contains(&true) { f64::NAN } else { v };
        let along = |list: [f64; 3]| [0, 1, 2].map(|i| if parted[i] { f64::NAN } else { list[i] });
        let [x, y, z] = along([0, 1, 2].map(|i| k.centroid[i]));
        let [a, b, c] = [k.axis_1, k.axis_2, k.axis_3].map(whole);
        let [width, height, depth] = along([k.extent_x, k.extent_y, k.extent_z]);
        [k.volume, k.surface, x, y, z, a, b, c, width, height, depth]
    })
}

/// Diameters that a ring is measured along.
const DIAMETERS: usize = 96;

/// Part of the diameters that may find no interface: its zero may lie by a little in a cell whose nodes it does not part.
const MISSED: f64 = 0.05;

/// The mean radius of a ring and the amplitudes of its modes, by half the diameters in [`DIAMETERS`] directions.
fn waves(ring: &Ring, radius: impl Fn(&Point<3>, &Point<3>) -> f64) -> Vec<f64> {
    let (centre, n) = (point::<3>(&ring.centre), point::<3>(&ring.normal).normalize());
    let first = if n[0].abs() < 0.9 { Point::<3>::x() } else { Point::<3>::y() };
    let first = (first - n * n.dot(&first)).normalize();
    let second = n.cross(&first);
    let angle = |i: usize| PI * i as f64 / DIAMETERS as f64;
    let along = |i: usize| radius(&centre, &(first * angle(i).cos() + second * angle(i).sin()));
    let radii: Vec<f64> = (0..DIAMETERS).map(along).collect();
    let found: Vec<f64> = radii.iter().copied().filter(|r| r.is_finite()).collect();
    let mean = match found.len() as f64 {
        count if count >= (1.0 - MISSED) * DIAMETERS as f64 => found.iter().sum::<f64>() / count,
        _ => f64::NAN,
    };
    // What was not found counts as the mean.
    let part = |f: &dyn Fn(f64) -> f64| {
        let terms = radii.iter().enumerate().map(|(i, r)| if r.is_finite() { (r - mean) * f(angle(i)) } else { 0.0 });
        terms.sum::<f64>() / DIAMETERS as f64
    };
    let mode = |m: usize| 2.0 * part(&|a| (m as f64 * a).cos()).hypot(part(&|a| (m as f64 * a).sin()));
    // No number where too little was found, `hypot` of nothing being 0.
    let modes = ring.modes.iter().map(|&m| if mean.is_nan() { mean } else { mode(m) });
    std::iter::once(mean).chain(modes).collect()
}

/// [`STRAIN`](Dimension::STRAIN) of an interface; NaN where there is none.
fn strain(sim: &Simulation<3>, k: usize, points: &[SurfacePoint<3>]) -> [f64; 5] {
    let (mut least, mut most, mut shear, mut sum, mut area) = (f64::NAN, f64::NAN, f64::NAN, 0.0, 0.0);
    for (s, p) in sim.surface_strain(k, points).iter().zip(points) {
        // `min` and `max` pass over the NaN at the start.
        (least, most, shear) = (s.z1.min(least), s.z1.max(most), s.z2.max(shear));
        (sum, area) = (sum + p.at.weight * s.z2, area + p.at.weight);
    }
    [sim.determinant_error_on(points), least, most, sum / area, shear]
}
