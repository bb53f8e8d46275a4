//! The zero set of a level set in the plane and in space.

use super::contour::{Contour, LATTICE};
use super::isosurface::Isosurface;
use crate::base::{Error, Result, same};
use crate::fem::{At, Space, SurfacePoint};
use crate::mesh::Point;
use nalgebra::SVector;
use std::any::Any;
use std::borrow::Cow;
use std::sync::Arc;

/// The interface `phi = 0` of a P2 function in `D` dimensions: a curve of the plane or a surface in
/// space, with its measures.
///
/// # Examples
/// ```
/// use immersa::fem::{Element, Space};
/// use immersa::levelset::Interface;
/// use immersa::mesh::{Diagonals, rectangle};
/// use std::sync::Arc;
///
/// let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 1.0], [4, 4], Diagonals::Right)?);
/// let space = Arc::new(Space::new(&mesh, Element::P2));
/// let phi = space.interpolate(|x| x[0] - 0.7);
/// let measures = Interface::cut(&space, phi)?.measures().unwrap();
/// assert!((measures.enclosed - 0.7).abs() < 1e-12);
/// assert!((measures.own - 1.0).abs() < 1e-12);
/// # Ok::<(), immersa::base::Error>(())
/// ```
pub struct Interface<'a, const D: usize> {
    space: Cow<'a, Arc<Space<D>>>,
    phi: Cow<'a, [f64]>,
    zero: Zero,
}

/// The zero set.
enum Zero {
    Plane(Contour),
    Solid(Isosurface),
}

/// Chords of the interface as segments or triangles, with their cells: straight pieces whose
/// corners lie on the zero set.
#[derive(Clone, Debug)]
pub(super) struct Pieces<const D: usize> {
    pub cells: Vec<u32>,
    pub corners: Vec<[Point<D>; D]>,
}

/// Size, position and form of an interface.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceMeasures<const D: usize> {
    /// Area (in space: volume) of the set `phi < 0`, cut off at the boundary of the mesh.
    pub enclosed: f64,
    /// Length (in space: area) of the interface; the boundary of the mesh does not count.
    pub own: f64,
    /// Centroid of the set.
    pub centroid: Point<D>,
    /// Semi-axes of the ellipse (ellipsoid) with the same second moments as the set, largest first.
    pub axes: [f64; D],
    /// In the plane the direction of the larger axis in degrees, counter-clockwise from x, in
    /// (-90, 90]; without meaning for a circle.
    pub angle: Option<f64>,
    /// Half the extents of the interface along the axes of the coordinates.
    pub extents: [f64; D],
}

impl<const D: usize> InterfaceMeasures<D> {
    /// NaN everywhere: the measures of an empty interface.
    pub fn none() -> InterfaceMeasures<D> {
        let nan = f64::NAN;
        InterfaceMeasures {
            enclosed: nan,
            own: nan,
            centroid: Point::<D>::from_element(nan),
            axes: [nan; D],
            angle: None,
            extents: [nan; D],
        }
    }
}

pub(super) fn other_dimension() -> Error {
    Error::internal("an interface was cut in another number of dimensions than its mesh")
}

impl Zero {
    /// Cuts `phi`, a function of `space`.
    fn new<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Zero> {
        let space: &dyn Any = space;
        match (space.downcast_ref::<Space<2>>(), space.downcast_ref::<Space<3>>()) {
            (Some(space), _) => Ok(Zero::Plane(Contour::new(space, phi)?)),
            (_, Some(space)) => Ok(Zero::Solid(Isosurface::new(space, phi)?)),
            _ => Err(other_dimension()),
        }
    }
    fn points<const D: usize>(&self, space: &Space<D>, phi: &[f64]) -> Vec<SurfacePoint<D>> {
        let space: &dyn Any = space;
        let points = match (self, space.downcast_ref(), space.downcast_ref()) {
            (Zero::Plane(contour), Some(space), _) => same(plane_points(contour, space, phi)),
            (Zero::Solid(surface), _, Some(space)) => same(surface.points_of_forms(space, phi)),
            _ => None,
        };
        points.unwrap_or_default()
    }
    fn measures<const D: usize>(&self) -> Option<InterfaceMeasures<D>> {
        match self {
            Zero::Plane(contour) => contour.measures().ok().and_then(|m| {
                same(InterfaceMeasures {
                    enclosed: m.area,
                    own: m.perimeter,
                    centroid: m.centroid,
                    axes: [m.axis_1, m.axis_2],
                    angle: Some(m.angle),
                    extents: [m.extent_x, m.extent_y],
                })
            }),
            Zero::Solid(surface) => surface.measures().ok().and_then(|m| {
                same(InterfaceMeasures {
                    enclosed: m.volume,
                    own: m.surface,
                    centroid: m.centroid,
                    axes: [m.axis_1, m.axis_2, m.axis_3],
                    angle: None,
                    extents: [m.extent_x, m.extent_y, m.extent_z],
                })
            }),
        }
    }
    fn is_empty(&self) -> bool {
        match self {
            Zero::Plane(contour) => contour.is_empty(),
            Zero::Solid(surface) => surface.is_empty(),
        }
    }
}

/// Quadrature points on `phi = 0`, on the zero set of the P2 function, sorted by their cells and
/// numbered by `at.q`, with the normals of the cut interface, out of `phi < 0`.
///
/// # Errors
/// A space that is not P2, a value that is not finite.
pub fn surface<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Vec<SurfacePoint<D>>> {
    Ok(Zero::new(space, phi)?.points(space, phi))
}

/// Straight pieces of the interface: half of each segment, a quarter of each triangle.
pub(super) fn pieces<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Pieces<D>> {
    cut_into(space, phi, &LATTICE)
}

/// The same with whole triangles, a quarter as many.
pub(super) fn coarse_pieces<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Pieces<D>> {
    cut_into(space, phi, &[[0, 1, 2]])
}

fn cut_into<const D: usize>(
    space: &Space<D>,
    phi: &[f64],
    parts: &[[usize; 3]],
) -> Result<Pieces<D>> {
    let found = match Zero::new(space, phi)? {
        Zero::Plane(contour) => {
            let (mut cells, mut corners) = (Vec::new(), Vec::new());
            for s in contour.segments() {
                let [start, middle, end] = s.points;
                cells.extend([s.cell; 2]);
                corners.extend([[start, middle], [middle, end]]);
            }
            same(Pieces { cells, corners })
        }
        Zero::Solid(surface) => {
            let (mut cells, mut corners) = (Vec::new(), Vec::new());
            for t in surface.triangles() {
                cells.extend(parts.iter().map(|_| t.cell));
                corners.extend(parts.iter().map(|part| part.map(|k| t.points[k])));
            }
            same(Pieces { cells, corners })
        }
    };
    found.ok_or_else(other_dimension)
}

/// Enclosed area (volume) and length (area) of an interface; zeros if it is empty.
///
/// # Errors
/// A space that is not P2, a value that is not finite.
pub fn extents<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<[f64; 2]> {
    let measures = Zero::new(space, phi)?.measures::<D>();
    Ok(measures.map_or([0.0; 2], |m| [m.enclosed, m.own]))
}

/// Points of a quadrature rule on the interface, numbered by `q`: in the plane those of
/// [`surface`], in the order of the curve, and six per triangle in space.
pub(super) fn quadrature<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Vec<At<D>>> {
    let (zero, space): (Zero, &dyn Any) = (Zero::new(space, phi)?, space);
    let points = match (&zero, space.downcast_ref(), space.downcast_ref()) {
        (Zero::Plane(contour), Some(space), _) => {
            let numbered = contour.quadrature(space, phi).into_iter().enumerate();
            same(numbered.map(|(q, p)| p.at(q)).collect::<Vec<_>>())
        }
        (Zero::Solid(surface), _, Some(space)) => {
            let points = surface.quadrature(space, phi).into_iter();
            same(points.map(|p| p.at).collect::<Vec<_>>())
        }
        _ => None,
    };
    points.ok_or_else(other_dimension)
}

/// Area (volume) of the set `phi < 0`, which may be empty or the whole domain.
pub(super) fn enclosed<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<f64> {
    let zero = Zero::new(space, phi)?;
    if zero.is_empty() {
        let inside = phi.first().is_some_and(|v| *v < 0.0);
        return Ok(if inside { space.mesh().volume() } else { 0.0 });
    }
    match &zero {
        Zero::Plane(contour) => Ok(contour.measures()?.area),
        Zero::Solid(surface) => Ok(surface.measures()?.volume),
    }
}

/// Points of a contour, sorted by their cells.
fn plane_points(contour: &Contour, space: &Space<2>, phi: &[f64]) -> Vec<SurfacePoint<2>> {
    let mut points = contour.quadrature(space, phi);
    // A zero close to a node gives pieces of length zero, without a normal.
    points.retain(|p| p.weight > 0.0 && p.normal.norm().is_finite());
    points.sort_by_key(|p| p.cell);
    let numbered = points.into_iter().enumerate();
    numbered.map(|(q, p)| SurfacePoint { at: p.at(q), normal: p.normal }).collect()
}

impl<'a, const D: usize> Interface<'a, D> {
    /// The interface of `phi`, a function of `space`.
    ///
    /// # Errors
    /// A space that is not P2, a value that is not finite.
    pub fn cut(
        space: &'a Arc<Space<D>>,
        phi: impl Into<Cow<'a, [f64]>>,
    ) -> Result<Interface<'a, D>> {
        let phi = phi.into();
        let zero = Zero::new(space, &phi)?;
        Ok(Interface { space: Cow::Borrowed(space), phi, zero })
    }
    /// The space: of the whole mesh, or of halved cells around the interface only.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }
    /// The level set.
    pub fn phi(&self) -> &[f64] {
        &self.phi
    }
    /// The curve, in the plane.
    pub fn contour(&self) -> Option<&Contour> {
        match &self.zero {
            Zero::Plane(contour) => Some(contour),
            Zero::Solid(_) => None,
        }
    }
    /// True if there is no interface.
    pub fn is_empty(&self) -> bool {
        self.zero.is_empty()
    }
    /// True if the interface ends on the boundary of the mesh.
    pub fn is_open(&self) -> bool {
        match &self.zero {
            Zero::Plane(contour) => contour.lines().iter().any(|l| !l.closed),
            Zero::Solid(surface) => !surface.walls().is_empty(),
        }
    }
    /// Quadrature points, as [`surface`].
    pub fn points(&self) -> Vec<SurfacePoint<D>> {
        self.zero.points(&self.space, &self.phi)
    }
    /// Size, position and form; `None` where there is no interface.
    pub fn measures(&self) -> Option<InterfaceMeasures<D>> {
        self.zero.measures()
    }
    /// Half the distance between the first zeros of `phi` on both sides of `point` on the line
    /// along `direction` (of any length): the semi-axis of a centred shape along that line. `None`
    /// if there is no interface on one of the sides.
    pub fn half_chord(&self, point: &Point<D>, direction: &SVector<f64, D>) -> Option<f64> {
        let space: &dyn Any = &**self.space;
        let (point, direction): (&dyn Any, &dyn Any) = (point, direction);
        match &self.zero {
            Zero::Plane(contour) => contour.half_chord(
                space.downcast_ref()?,
                &self.phi,
                point.downcast_ref()?,
                direction.downcast_ref()?,
            ),
            Zero::Solid(surface) => surface.half_chord(
                space.downcast_ref()?,
                &self.phi,
                point.downcast_ref()?,
                direction.downcast_ref()?,
            ),
        }
    }
}

impl Interface<'static, 2> {
    /// The interface of a function on halved cells.
    pub(super) fn of_contour(
        space: Arc<Space<2>>,
        phi: Vec<f64>,
        contour: Contour,
    ) -> Interface<'static, 2> {
        Interface { space: Cow::Owned(space), phi: Cow::Owned(phi), zero: Zero::Plane(contour) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, Mesh, box_mesh, rectangle};
    use std::f64::consts::PI;

    /// A circle or a sphere of radius .4, cut once: measures, chords and points, all of order 4 or
    /// exact.
    fn check<const D: usize>(mesh: Mesh<D>, enclosed: f64, own: f64) {
        let space = Arc::new(Space::new(&Arc::new(mesh), Element::P2));
        let centre = Point::<D>::from_element(0.5);
        let phi = space.interpolate(|x| (x - centre).norm_squared() - 0.16);
        let interface = Interface::cut(&space, &phi[..]).unwrap();
        let m = interface.measures().unwrap();
        assert!(
            (m.enclosed / enclosed - 1.0).abs() < 2e-4 && (m.own / own - 1.0).abs() < 2e-4,
            "{m:?}"
        );
        assert!((m.centroid - centre).norm() < 1e-4, "{m:?}");
        assert!(m.axes.iter().chain(&m.extents).all(|a| (a - 0.4).abs() < 1e-3), "{m:?}");
        let mut along = SVector::<f64, D>::from_element(1.0);
        along[0] = 2.0;
        assert!((interface.half_chord(&centre, &along).unwrap() - 0.4).abs() < 1e-10);
        assert!(!interface.is_open() && !interface.is_empty());
        let points = interface.points();
        let size: f64 = points.iter().map(|p| p.at.weight).sum();
        assert!((size / m.own - 1.0).abs() < 1e-3, "{size} {}", m.own);
        let on = |p: &SurfacePoint<D>| ((p.at.x - centre).norm() - 0.4).abs() < 1e-6;
        assert!(points.iter().all(on) && points.windows(2).all(|w| w[0].at.cell <= w[1].at.cell));
        let outward = |p: &SurfacePoint<D>| p.normal.dot(&(p.at.x - centre)) > 0.39;
        assert!(points.iter().all(outward));
        let nothing = vec![1.0; phi.len()];
        let gone = Interface::cut(&space, &nothing[..]).unwrap();
        assert!(gone.is_empty() && gone.measures().is_none() && gone.points().is_empty());
        assert!(gone.half_chord(&centre, &along).is_none());
    }

    #[test]
    fn a_circle_is_cut_once_and_measured() {
        let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [16, 16], Diagonals::UnionJack).unwrap();
        check(mesh, PI * 0.16, 2.0 * PI * 0.4);
    }

    #[test]
    fn a_sphere_is_cut_once_and_measured() {
        let mesh = box_mesh([0.0; 3], [1.0; 3], [8; 3]).unwrap();
        check(mesh, 4.0 / 3.0 * PI * 0.064, 4.0 * PI * 0.16);
    }

    #[test]
    fn a_line_through_the_mesh_is_open() {
        let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], Diagonals::UnionJack).unwrap();
        let space = Arc::new(Space::new(&Arc::new(mesh), Element::P2));
        let phi = space.interpolate(|x| x[0] - 0.4);
        let line = Interface::cut(&space, &phi[..]).unwrap();
        assert!(line.is_open());
        assert!((enclosed(&space, &phi).unwrap() - 0.4).abs() < 1e-14);
        assert_eq!(enclosed(&space, &vec![-1.0; phi.len()]).unwrap(), space.mesh().volume());
    }
}
