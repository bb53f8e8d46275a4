//! Scenes of space.

use super::super::refined::refined;
use super::{Dimension, In, coordinates, other_dimension, point};
use crate::base::{Error, Result, Warning};
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{
    self, Circle, Ellipsoid, Isosurface, LevelSolid, RoundedBlock, Shape as Distance, SolidUnion, Torus,
};
use crate::mesh::{Mesh, Point, gmsh};
use crate::scene::Scene;
use crate::scene::schema::{Chord, MeshSource, Shape};
use crate::sim::Simulation;

/// Number of [`MEASURES`](Dimension::MEASURES).
const COUNT: usize = 11;

impl Dimension<3> for In<3> {
    const MEASURES: &'static [&'static str] = &[
        "volume", "surface", "centre_x", "centre_y", "centre_z", "axis_1", "axis_2", "axis_3", "extent_x", "extent_y",
        "extent_z",
    ];
    const CELLS: &'static str = "tetrahedra";

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

    fn measure(sim: &Simulation<3>, k: usize, chords: &[Chord]) -> Result<Vec<f64>> {
        let (space, phi) = (sim.space(), sim.level_set(k));
        let surface = Isosurface::new(space, &phi)?;
        let mut row = measures(sim, &surface).to_vec();
        row.extend(
            chords
                .iter()
                .map(|c| surface.half_chord(space, &phi, &point(&c.through), &point(&c.direction)).unwrap_or(f64::NAN)),
        );
        Ok(row)
    }
}

/// The first columns of an interface.
fn measures(sim: &Simulation<3>, surface: &Isosurface) -> [f64; COUNT] {
    // In parts on the two sides of the mesh a membrane has a volume and a surface, but no place and no form.
    let parted = !sim.translations().is_empty() && !surface.walls().is_empty();
    surface.measures().map_or([f64::NAN; COUNT], |k| {
        let whole = |v: f64| if parted { f64::NAN } else { v };
        let [x, y, z] = [0, 1, 2].map(|i| whole(k.centroid[i]));
        let [a, b, c] = [k.axis_1, k.axis_2, k.axis_3].map(whole);
        let [width, height, depth] = [k.extent_x, k.extent_y, k.extent_z].map(whole);
        [k.volume, k.surface, x, y, z, a, b, c, width, height, depth]
    })
}
