//! Scenes of the plane.

use super::super::adapt;
use super::super::image::{Answer, write_segmentation};
use super::super::refined::refined;
use super::{Dimension, In, coordinates, other_dimension, parted, point};
use crate::base::{Error, Result, Warning};
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{
    self, Circle, Contour, Cutter, Delta, Ellipse, Interface, LevelFunction, Polygon, RoundedBox, Shape as Distance,
    Union,
};
use crate::mesh::{self, Mesh, Point, gmsh};
use crate::scene::schema::{Chord, MeshSource, Ring, Shape};
use crate::scene::{Model, Scene};
use crate::sim::{InitialFunction, Simulation, Transfer};
use std::path::Path;

/// Number of [`MEASURES`](Dimension::MEASURES).
const COUNT: usize = 9;

impl Dimension<2> for In<2> {
    const MEASURES: &'static [&'static str] =
        &["area", "perimeter", "centre_x", "centre_y", "axis_1", "axis_2", "angle", "extent_x", "extent_y"];
    const CELLS: &'static str = "triangles";
    const DROP: &'static [&'static str] = &["circularity", "velocity_x", "velocity_y"];
    const CUTTER: Cutter<2> = Cutter::PLANE;
    const STRAIN: &'static [&'static str] = &[];

    fn mesh(scene: &Scene) -> Result<(Mesh<2>, Vec<Warning>)> {
        let mesh = match &scene.mesh {
            MeshSource::File { path, refine, geometry, .. } => {
                let (mesh, warnings) = gmsh::read::<2>(path)?;
                return Ok((refined(scene, mesh, *refine, geometry)?, warnings));
            }
            MeshSource::Rectangle { min, max, cells, diagonals } => mesh::rectangle(*min, *max, *cells, *diagonals),
            MeshSource::Disc { centre, radius, cells } => mesh::disc(*centre, *radius, *cells),
            MeshSource::Box { .. } | MeshSource::BallInBox { .. } => {
                Err(Error::internal("a box reached the mesh of the plane"))
            }
        };
        Ok((mesh.map_err(|e| scene.blame(&["mesh"], e))?, Vec::new()))
    }

    fn shape(shape: &Shape, domain: (Point<2>, Point<2>)) -> Result<Box<dyn Distance<2>>> {
        Ok(match shape {
            Shape::Circle { centre, radius } => Box::new(Circle::new(point(centre), *radius)?),
            Shape::Ellipse { centre, semi_axes, angle } => {
                Box::new(Ellipse::new(point(centre), point(semi_axes), *angle)?)
            }
            Shape::RoundedBox { centre, half_size, radius, angle } => {
                Box::new(RoundedBox::new(point(centre), point(half_size), *radius, *angle)?)
            }
            Shape::Polygon(points) => Box::new(Polygon::new(points.iter().map(|p| point(p)).collect())?),
            Shape::Union(parts) => {
                let parts = parts.iter().map(|p| Self::shape(p, domain)).collect::<Result<_>>()?;
                Box::new(Union::new(parts)?)
            }
            Shape::Expression(e) => {
                let e = e.clone();
                Box::new(LevelFunction::new(move |x: &Point<2>| e.eval(coordinates(x), 0.0), domain)?)
            }
            Shape::Sphere { .. } | Shape::Ellipsoid { .. } | Shape::Torus { .. } | Shape::RoundedBlock { .. } => {
                return Err(other_dimension(shape, 2));
            }
        })
    }

    fn surface(space: &Space<2>, phi: &[f64]) -> Result<Vec<SurfacePoint<2>>> {
        levelset::surface(space, phi)
    }

    fn delta(space: &Space<2>, phi: &[f64], delta: &Delta) -> Result<(f64, Option<f64>)> {
        Ok((delta.measure(space, phi)?, delta.inside(space, phi)?))
    }

    fn measure(sim: &Simulation<2>, k: usize, chords: &[Chord], _: &[Ring]) -> Result<Vec<f64>> {
        let interface = sim.interface(k)?;
        let mut row = measures(sim, &interface).to_vec();
        let Interface { space, phi, contour } = &interface;
        row.extend(
            chords
                .iter()
                .map(|c| contour.half_chord(space, phi, &point(&c.through), &point(&c.direction)).unwrap_or(f64::NAN)),
        );
        let passive = k.checked_sub(sim.structures().len());
        row.extend(passive.and_then(|k| sim.marker_polygon(k)).into_iter().flatten());
        Ok(row)
    }

    fn markers(space: &Space<2>, phi: &[f64], distance: &InitialFunction<2>, count: usize) -> Result<Vec<Point<2>>> {
        markers(&Contour::new(space, phi)?, distance, count)
    }

    fn compare(answer: &Answer, sim: &Simulation<2>) -> [f64; 2] {
        answer.compare(sim)
    }

    fn write_segmentation(scene: &Scene, sim: &Simulation<2>, folder: &Path) -> Result<()> {
        write_segmentation(scene, sim, folder)
    }

    fn adapted_start(scene: &Scene, given: Mesh<2>, lengths: &adapt::Lengths) -> Result<Mesh<2>> {
        adapt::adapted_start(scene, given, lengths)
    }

    fn follow(model: &mut Model<2>, scene: &Scene) -> Result<bool> {
        model.follow_fields(scene)
    }

    fn go_on(model: &mut Model<2>, mesh: Mesh<2>, transfer: Transfer) -> Result<()> {
        model.go_on_upon(mesh, transfer)
    }
}

/// The first columns of an interface.
fn measures(sim: &Simulation<2>, interface: &Interface) -> [f64; COUNT] {
    let contour = &interface.contour;
    let parted = parted(sim, contour.lines().iter().any(|l| !l.closed));
    contour.measures().map_or([f64::NAN; COUNT], |k| {
        let along = |axis: usize, v: f64| if parted[axis] { f64::NAN } else { v };
        let whole = |v: f64| if parted.contains(&true) { f64::NAN } else { v };
        let [a, b, angle] = [k.axis_1, k.axis_2, k.angle].map(whole);
        let [x, y] = [0, 1].map(|i| along(i, k.centroid[i]));
        [k.area, k.perimeter, x, y, a, b, angle, along(0, k.extent_x), along(1, k.extent_y)]
    })
}

/// Points on an interface at equal distances along it: on the contour of the mesh first, then moved onto the shape.
fn markers(contour: &Contour, distance: &InitialFunction<2>, count: usize) -> Result<Vec<Point<2>>> {
    let [line] = contour.lines() else {
        return Err(Error::scene("markers need an interface of one closed curve")
            .value(format!("{} curves", contour.lines().len()))
            .remedy("give each curve a [[level_set]] of its own"));
    };
    let polyline = contour.polyline(line);
    let mut lengths = vec![0.0];
    for pair in polyline.windows(2) {
        lengths.push(lengths[lengths.len() - 1] + (pair[1] - pair[0]).norm());
    }
    let whole = lengths[lengths.len() - 1];
    let delta = 1e-6 * whole;
    let onto = |x: Point<2>| {
        let along = |axis: usize| {
            let mut step = Point::<2>::zeros();
            step[axis] = delta;
            (distance(&(x + step)) - distance(&(x - step))) / (2.0 * delta)
        };
        x - Point::<2>::new(along(0), along(1)) * distance(&x)
    };
    let point = |k: usize| {
        let s = whole * k as f64 / count as f64;
        let i = lengths.partition_point(|l| *l <= s).clamp(1, polyline.len() - 1);
        let t = (s - lengths[i - 1]) / (lengths[i] - lengths[i - 1]).max(f64::MIN_POSITIVE);
        onto(onto(polyline[i - 1] + (polyline[i] - polyline[i - 1]) * t))
    };
    Ok((0..count).map(point).collect())
}
