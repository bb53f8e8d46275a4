//! Scenes of space.

use super::{Dimension, In, coordinates, other_dimension, point};
use crate::base::{Error, Result, Warning};
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{Circle, RoundedBlock, Shape as Distance, SolidFunction, SolidUnion};
use crate::mesh::{self, Mesh, Point, gmsh};
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
        let mesh = match &scene.mesh {
            MeshSource::File { path, .. } => return gmsh::read::<3>(path),
            MeshSource::Box { min, max, cells } => mesh::box_mesh(*min, *max, *cells),
            MeshSource::Rectangle { .. } | MeshSource::Disc { .. } => {
                Err(Error::internal("a mesh of the plane reached the mesh of space"))
            }
        };
        Ok((mesh.map_err(|e| scene.blame(&["mesh"], e))?, Vec::new()))
    }

    fn shape(shape: &Shape, domain: (Point<3>, Point<3>)) -> Result<Box<dyn Distance<3>>> {
        Ok(match shape {
            Shape::Sphere { centre, radius } => Box::new(Circle::<3>::new(point(centre), *radius)?),
            Shape::RoundedBlock { centre, half_size, radius, turn } => {
                Box::new(RoundedBlock::new(point(centre), point(half_size), *radius, point(&turn.axis), turn.angle)?)
            }
            Shape::Union(parts) => {
                let parts = parts.iter().map(|p| Self::shape(p, domain)).collect::<Result<_>>()?;
                Box::new(SolidUnion::new(parts)?)
            }
            Shape::Expression(e) => {
                let e = e.clone();
                Box::new(SolidFunction::new(move |x: &Point<3>| e.eval(coordinates(x), 0.0), domain)?)
            }
            Shape::Ellipsoid { .. }
            | Shape::Circle { .. }
            | Shape::Ellipse { .. }
            | Shape::RoundedBox { .. }
            | Shape::Polygon(_) => return Err(other_dimension(shape, 3)),
        })
    }

    fn surface(_space: &Space<3>, _phi: &[f64]) -> Result<Vec<SurfacePoint<3>>> {
        Err(Error::internal("surfaces are not cut yet"))
    }

    fn measure(_sim: &Simulation<3>, _k: usize, chords: &[Chord]) -> Result<Vec<f64>> {
        Ok(vec![f64::NAN; COUNT + chords.len()])
    }
}
