//! What differs between a scene of the plane and one of space; all else is written once, for `D` dimensions.

mod plane;
mod solid;

use super::Scene;
use super::adapt::Lengths;
use super::geometry::CURVE_COLUMNS;
use super::image::Answer;
use super::model::Model;
use super::schema::{self, Chord, Curve, Ring};
use crate::base::{Error, Result, Warning};
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{Cutter, Delta, Shape};
use crate::mesh::{Mesh, Point};
use crate::sim::{InitialFunction, Simulation, Transfer};
use std::path::Path;

/// Stands for `D` dimensions, of which [`Dimension`] says what is particular.
pub struct In<const D: usize>;

/// What a scene has or does in its own way in each number of dimensions. What is given here is for those that lack it.
pub trait Dimension<const D: usize> {
    /// The columns that each interface has, after its name and a dot; what it encloses comes first.
    const MEASURES: &'static [&'static str];
    /// The columns that a drop has beside them.
    const DROP: &'static [&'static str];
    /// What cells are called, more than one of them.
    const CELLS: &'static str;
    /// How interfaces are cut where they are redistanced.
    const CUTTER: Cutter<D>;

    /// The mesh of the scene before it is adapted, and what is to be said of it.
    ///
    /// # Errors
    /// A file that cannot be read or has another dimension; sizes that make no mesh.
    fn mesh(scene: &Scene) -> Result<(Mesh<D>, Vec<Warning>)>;

    /// The shape that a scene describes; `domain` is the bounding box of the mesh.
    ///
    /// # Errors
    /// One that cannot be, or that belongs to another number of dimensions.
    fn shape(shape: &schema::Shape, domain: (Point<D>, Point<D>)) -> Result<Box<dyn Shape<D>>>;

    /// Quadrature points on the zero set of a function of the space.
    ///
    /// # Errors
    /// A value that is not finite.
    fn surface(space: &Space<D>, phi: &[f64]) -> Result<Vec<SurfacePoint<D>>>;

    /// Length or area of an interface by a delta function, and what it encloses, where a Heaviside function belongs to it.
    ///
    /// # Errors
    /// A value that is not finite.
    fn delta(space: &Space<D>, phi: &[f64], delta: &Delta) -> Result<(f64, Option<f64>)>;

    /// The row of a curve between interfaces.
    ///
    /// # Errors
    /// A value that is not finite.
    fn curve(_scene: &Scene, _sim: &Simulation<D>, _curve: &Curve) -> Result<[f64; CURVE_COLUMNS.len()]> {
        Err(Error::internal("a curve between interfaces of the plane"))
    }

    /// The columns of the strain of an interface, where backward characteristics are carried.
    const STRAIN: &'static [&'static str];

    /// The row of interface number `k`: [`MEASURES`](Self::MEASURES), the half-chords, the rings, [`STRAIN`](Self::STRAIN), and what is
    /// measured of its markers. What cannot be measured is NaN.
    ///
    /// # Errors
    /// A level set that is not finite.
    fn measure(sim: &Simulation<D>, k: usize, chords: &[Chord], rings: &[Ring]) -> Result<Vec<f64>>;

    /// As many points on the zero set of `phi`, at equal distances, moved onto that of `distance`.
    ///
    /// # Errors
    /// An interface that cannot have them.
    fn markers(_space: &Space<D>, _phi: &[f64], _distance: &InitialFunction<D>, count: usize) -> Result<Vec<Point<D>>> {
        Err(Error::scene("markers follow a curve, and the interface is a surface")
            .value(count)
            .remedy("leave them out"))
    }

    /// How the level set differs from the known answer of a segmentation: relative error of the area, and pixels on the wrong side.
    fn compare(_answer: &Answer, _sim: &Simulation<D>) -> [f64; 2] {
        [f64::NAN; 2]
    }

    /// Writes what the segmentation of an image has come to.
    ///
    /// # Errors
    /// A file cannot be written.
    fn write_segmentation(_scene: &Scene, _sim: &Simulation<D>, _folder: &Path) -> Result<()> {
        Ok(())
    }

    /// The mesh of a scene that follows its interfaces, at the start: from the mesh as given.
    ///
    /// # Errors
    /// Shapes that do not lie on the mesh.
    fn adapted_start(_scene: &Scene, given: Mesh<D>, _lengths: &Lengths) -> Result<Mesh<D>> {
        Ok(given)
    }

    /// Makes the mesh anew where it no longer fits interfaces or fields, and goes on upon it. Returns whether it did.
    ///
    /// # Errors
    /// Those of [`Simulation::on_mesh`].
    fn follow(_model: &mut Model<D>, _scene: &Scene) -> Result<bool> {
        Ok(false)
    }

    /// Goes on upon another mesh of the domain.
    ///
    /// # Errors
    /// Those of [`Simulation::on_mesh`].
    fn go_on(_model: &mut Model<D>, _mesh: Mesh<D>, _transfer: Transfer) -> Result<()> {
        Err(Error::internal("a mesh that cannot be adapted was adapted"))
    }
}

/// Along which axes an interface that is `cut` by walls is in parts on the two sides of the mesh: it has no place and no extent along them.
fn parted<const D: usize>(sim: &Simulation<D>, cut: bool) -> [bool; D] {
    std::array::from_fn(|axis| cut && sim.translations().iter().any(|t| t.shift[axis] != 0.0))
}

/// A point of the scene, as expressions take it.
pub(super) fn coordinates<const D: usize>(x: &Point<D>) -> [f64; 3] {
    std::array::from_fn(|i| if i < D { x[i] } else { 0.0 })
}

/// Numbers of the scene as a point.
pub(super) fn point<const D: usize>(x: &[f64]) -> Point<D> {
    Point::<D>::from_fn(|i, _| x.get(i).copied().unwrap_or(0.0))
}

/// The error for a shape that belongs to another number of dimensions.
fn other_dimension(shape: &schema::Shape, dimension: usize) -> Error {
    Error::scene(format!("the shape does not belong into {dimension} dimensions")).value(shape.write())
}
