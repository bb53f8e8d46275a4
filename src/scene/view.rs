//! A view of a problem at one time: the data for columns, fields and pictures.

use super::cuts::Cuts;
use super::points::point;
use super::row::Row;
use super::schema::Tables;
use crate::base::Result;
use crate::fem::{Space, SurfacePoint};
use crate::flow::FlowSolver;
use crate::levelset::{Interface, InterfaceMeasures, surface};
use crate::mesh::Point;
use crate::sim::{Carried, State};
use crate::structure::{Density, FieldId, polygon_area, polygon_length};
use std::borrow::Cow;
use std::sync::Arc;

/// Axes of the coordinates by name.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];

/// A problem at one time.
pub(super) struct View<'a, const D: usize> {
    /// Tables of the scene.
    pub tables: &'a Tables,
    /// Structures with their transport.
    pub carried: &'a Carried<D>,
    /// The state.
    pub state: &'a State<D>,
    /// The flow solver, if there is a flow.
    pub flow: Option<&'a FlowSolver<D>>,
    /// Half-width of the bands.
    pub thickness: Option<f64>,
    /// For each structure, the slope that its band is measured with, if the band is carried.
    pub carried_bands: &'a [Option<f64>],
}

impl<'a, const D: usize> View<'a, D> {
    /// P2 space of velocity and level sets.
    pub fn space(&self) -> &'a Arc<Space<D>> {
        self.carried.space()
    }
    /// Level set of structure number `k` at the nodes.
    pub fn level_set(&self, k: usize) -> Cow<'a, [f64]> {
        self.carried.level_set(&self.state.fields, k)
    }
    /// Quadrature points on the interface of structure number `k`.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn surface(&self, k: usize) -> Result<Vec<SurfacePoint<D>>> {
        surface(self.space(), &self.level_set(k))
    }
    /// Length and area of the polygon of the markers of structure number `k`; `None` without
    /// markers.
    pub fn marker_polygon(&self, k: usize) -> Option<[f64; 2]> {
        let list = self.carried.markers(&self.state.fields, k);
        (!list.is_empty()).then(|| [polygon_length(list), polygon_area(list)])
    }
    /// True if the backward characteristics are carried.
    pub fn has_backward_map(&self) -> bool {
        self.carried.has_backward_map(&self.state.fields)
    }

    /// Measures the interface of structure number `k`: size, centre, axes, extents, chords and
    /// rings, and in space its strain if it is known. Returns the enclosed
    /// measure and its own measure. Undefined values are NaN: all for an interface that has
    /// vanished; for one that crosses a periodic side, the axes, and centre and extent in the
    /// periodic direction.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn measure_interface(&self, k: usize, cuts: Cuts<'_>, row: &mut Row) -> Result<[f64; 2]> {
        let name = format!("{}.", self.carried.structures()[k].name());
        let interface = self.carried.interface(&self.state.fields, k)?;
        let sizes = self.put_measures(&name, &interface, row);
        for c in cuts.chords {
            let radius = interface.half_chord(&point(&c.through), &point(&c.direction));
            row.put(format!("{name}{}", c.name), radius.unwrap_or(f64::NAN));
        }
        for ring in cuts.rings {
            let modes = ring.modes.iter().map(|mode| format!("mode_{mode}"));
            let columns = std::iter::once("radius".to_string()).chain(modes);
            let values = interface.waves(&point(&ring.centre), &point(&ring.normal), &ring.modes);
            row.put_all(&format!("{name}{}_", ring.name), columns.zip(values));
        }
        let structure = &self.carried.structures()[k];
        if let Some((density, of)) =
            structure.surface_density().filter(|_| !structure.carries_strain())
        {
            let [least, mean, most] = self.density(density, &interface.points());
            match of {
                Density::Rest => {
                    row.put_all(
                        &name,
                        STRETCH.into_iter().zip([1.0 / most, 1.0 / mean, 1.0 / least]),
                    );
                }
                Density::Concentration => {
                    row.put_all(&name, CONCENTRATION.into_iter().zip([least, mean, most]));
                }
            }
        }
        if D == 3 && (self.has_backward_map() || structure.carries_strain()) {
            row.put_all(&name, STRAIN.into_iter().zip(self.strain(k, &interface.points())));
        }
        Ok(sizes)
    }

    /// Lengths of the interface of structure number `k` along its axes of inertia, in the plane;
    /// `None` without an interface, or where sides cut it.
    ///
    /// # Errors
    /// A level set that is not finite.
    pub fn lengths_along_axes(&self, k: usize) -> Result<Option<[f64; 2]>> {
        let interface = self.carried.interface(&self.state.fields, k)?;
        let measures = interface.measures().filter(|_| !interface.is_open());
        let (Some(contour), Some(angle)) = (interface.contour(), measures.and_then(|m| m.angle))
        else {
            return Ok(None);
        };
        let (sine, cosine) = angle.to_radians().sin_cos();
        let length = |axis: Point<2>| {
            let places = contour
                .segments()
                .iter()
                .flat_map(|s| (0..=8).map(|k| s.point(f64::from(k) / 8.0).dot(&axis)));
            let (least, most) =
                places.fold((f64::INFINITY, -f64::INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            most - least
        };
        Ok(Some([length(Point::<2>::new(cosine, sine)), length(Point::<2>::new(-sine, cosine))]))
    }

    /// Columns of size, centre, axes and extents.
    fn put_measures(&self, name: &str, interface: &Interface<'_, D>, row: &mut Row) -> [f64; 2] {
        // For an interface cut by two periodic sides, centre and extent across them are undefined.
        let cut = interface.is_open();
        let parted =
            |axis: usize| cut && self.carried.translations().iter().any(|t| t.shift[axis] != 0.0);
        let any_parted = (0..D).any(parted);
        let m = interface.measures().unwrap_or_else(InterfaceMeasures::none);
        let along = |axis: usize, v: f64| if parted(axis) { f64::NAN } else { v };
        let whole = |v: f64| if any_parted { f64::NAN } else { v };
        let sizes = if D == 2 { ["area", "perimeter"] } else { ["volume", "surface"] };
        row.put_all(name, sizes.into_iter().zip([m.enclosed, m.own]));
        for (i, axis) in AXES.iter().enumerate().take(D) {
            row.put(format!("{name}centre_{axis}"), along(i, m.centroid[i]));
        }
        for (i, axis) in m.axes.iter().enumerate() {
            row.put(format!("{name}axis_{}", i + 1), whole(*axis));
        }
        if D == 2 {
            row.put(format!("{name}angle"), whole(m.angle.unwrap_or(f64::NAN)));
        }
        for (i, axis) in AXES.iter().enumerate().take(D) {
            row.put(format!("{name}extent_{axis}"), along(i, m.extents[i]));
        }
        [m.enclosed, m.own]
    }

    /// Least, mean and largest value of a density on an interface; NaN without one.
    fn density(&self, density: FieldId, points: &[SurfacePoint<D>]) -> [f64; 3] {
        let density = self.state.fields.scalar(density);
        let (mut least, mut most, mut amount, mut own) = (f64::NAN, f64::NAN, 0.0, 0.0);
        for p in points {
            let m = self.space().value(density, p.at.cell, &p.at.barycentric);
            // `min` and `max` ignore the initial NaN.
            (least, most) = (m.min(least), m.max(most));
            (amount, own) = (amount + p.at.weight * m, own + p.at.weight);
        }
        [least, amount / own, most]
    }

    /// Values of [`STRAIN`] on an interface; NaN without strain.
    fn strain(&self, k: usize, points: &[SurfacePoint<D>]) -> [f64; 5] {
        let fields = &self.state.fields;
        let (mut least, mut most, mut shear) = (f64::NAN, f64::NAN, f64::NAN);
        let (mut sum, mut area) = (0.0, 0.0);
        for (s, p) in self.carried.surface_strain(fields, k, points).iter().zip(points) {
            // `min` and `max` ignore the initial NaN.
            (least, most, shear) = (s.z1.min(least), s.z1.max(most), s.z2.max(shear));
            (sum, area) = (sum + p.at.weight * s.z2, area + p.at.weight);
        }
        let error = match self.has_backward_map() {
            true => self.carried.determinant_error_on(fields, points),
            false => f64::NAN,
        };
        [error, least, most, sum / area, shear]
    }
}

/// Columns of the stretch that an interface carries; the mean is that over its length (area) at
/// rest.
const STRETCH: [&str; 3] = ["stretch_min", "stretch_mean", "stretch_max"];
/// Columns of the concentration that an interface carries.
const CONCENTRATION: [&str; 3] = ["concentration_min", "concentration_mean", "concentration_max"];

/// Columns of the strain of an interface in space, if it or backward characteristics carry it.
const STRAIN: [&str; 5] =
    ["determinant_error", "area_change_min", "area_change_max", "shear_mean", "shear_max"];
