//! Plane slices through the domain: the field in its true finite element, and the line where an
//! interface crosses.

use super::super::colours::Colours;
use super::super::field::{FieldData, on_nodes};
use super::camera::{Camera, in_space};
use super::canvas::Facet;
use crate::base::{Error, Result};
use crate::fem::{EDGES, Space};
use crate::mesh::{Location, Point};
use nalgebra::{Matrix2, SVector, Vector2};

/// A plane across the domain, coloured by a field in the scale of the picture, without shading.
#[derive(Clone, Copy, Debug)]
pub struct Slice<'a> {
    /// The coordinate that is constant on it: 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// The value of that coordinate.
    pub position: f64,
    /// The field that is coloured; a vector field by its length.
    pub field: FieldData<'a, 3>,
}

/// A slice, cut into triangles that each lie in one cell.
pub(super) struct CutPlane<'a> {
    space: &'a Space<3>,
    axis: usize,
    field: Nodal,
    interfaces: Vec<Vec<f64>>,
    /// The cell of each triangle and the barycentric coordinates of its corners.
    triangles: Vec<(u32, [[f64; 4]; 3])>,
}

/// A field with its values at all nodes.
enum Nodal {
    Scalar(Vec<f64>),
    Vector(Vec<SVector<f64, 3>>),
}

/// Widths in pixels and opacity of the light rim of an interface and of the line itself, from
/// below.
const LINES: [(f64, f32, [f32; 3]); 2] = [(4.6, 0.7, [255.0; 3]), (2.2, 1.0, [12.0, 12.0, 16.0])];

impl<'a> CutPlane<'a> {
    /// Cuts the cells, as far as they lie in the box with the corners `shown`.
    ///
    /// # Errors
    /// A slice beside the box, or a field with a wrong number of values.
    pub fn new(
        space: &'a Space<3>,
        slice: &Slice,
        interfaces: &[&[f64]],
        shown: &[Point<3>; 2],
    ) -> Result<CutPlane<'a>> {
        let [low, high] = shown;
        if slice.axis > 2 {
            return Err(
                Error::internal("a slice has an axis that space does not have").value(slice.axis)
            );
        }
        let (low, high, name) = (low[slice.axis], high[slice.axis], ["x", "y", "z"][slice.axis]);
        if !(low..=high).contains(&slice.position) {
            return Err(Error::input("a slice lies outside of the box that is shown")
                .value(format!("{name} = {}", slice.position))
                .remedy(format!("give a value of {name} from {low} to {high}")));
        }
        let field = match slice.field {
            FieldData::Scalar(f) => Nodal::Scalar(on_nodes(space, "slice", f)?),
            FieldData::Vector(f) => Nodal::Vector(on_nodes(space, "slice", f)?),
        };
        let interfaces =
            interfaces.iter().map(|f| on_nodes(space, "level set", f)).collect::<Result<_>>()?;
        let triangles = triangles(space, slice.axis, slice.position, shown);
        Ok(CutPlane { space, axis: slice.axis, field, interfaces, triangles })
    }
    /// Its triangles in the picture.
    pub fn facets(&self, camera: &Camera, part: u32) -> Vec<Facet> {
        let facet = |(i, (cell, corners)): (usize, &(u32, [[f64; 4]; 3]))| Facet {
            spots: corners.map(|l| camera.project(&self.point(*cell, &l))),
            part,
            number: i as u32,
        };
        self.triangles.iter().enumerate().map(facet).collect()
    }
    fn point(&self, cell: u32, l: &[f64; 4]) -> Point<3> {
        self.space.mesh().point_at(&Location { cell, barycentric: *l })
    }
    /// Its colour at a point of a triangle, whose corners have the weights `l` in the picture.
    pub fn shade(&self, f: &Facet, l: [f64; 3], camera: &Camera, bar: &Colours) -> [f32; 3] {
        let (cell, corners) = &self.triangles[f.number as usize];
        let (c, w) = (*cell as usize, in_space(&f.spots, l));
        let l: [f64; 4] = std::array::from_fn(|k| {
            w[0] * corners[0][k] + w[1] * corners[1][k] + w[2] * corners[2][k]
        });
        let value = match &self.field {
            Nodal::Scalar(f) => self.space.value(f, c, &l),
            Nodal::Vector(f) => self.space.value(f, c, &l).norm(),
        };
        let mut rgb = bar.of(value).map(f32::from);
        for phi in &self.interfaces {
            let far = self.pixels_from(phi, c, &l, camera) as f32;
            for (width, opacity, ink) in LINES {
                let a = opacity * (0.5 * width as f32 + 0.5 - far).clamp(0.0, 1.0);
                // NaN, where the slope is zero, lays no ink.
                if a > 0.0 {
                    rgb = std::array::from_fn(|k| rgb[k] + (ink[k] - rgb[k]) * a);
                }
            }
        }
        rgb
    }
    /// Distance in pixels to the line `phi = 0` of the slice, `|phi| / |grad phi|` with the
    /// gradient in the picture.
    fn pixels_from(&self, phi: &[f64], c: usize, l: &[f64; 4], camera: &Camera) -> f64 {
        let value = self.space.value(phi, c, l).abs();
        let slope = self.space.gradient(phi, c, l);
        let (a, b) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let [column, row] = camera.derivative(&self.point(c as u32, l));
        // grad phi in the plane is the transposed derivative of the pixel times grad phi in the
        // picture.
        let derivative = Matrix2::new(column[a], row[a], column[b], row[b]);
        let inverse = derivative.try_inverse().unwrap_or_else(Matrix2::zeros);
        value / (inverse * Vector2::new(slope[a], slope[b])).norm()
    }
}

/// The parts of a plane in the cells and in a box. A plane along facets takes them from the cells
/// below, or from those above at the lower end of the box.
fn triangles(
    space: &Space<3>,
    axis: usize,
    position: f64,
    [low, high]: &[Point<3>; 2],
) -> Vec<(u32, [[f64; 4]; 3])> {
    let mesh = space.mesh();
    let mut triangles = Vec::new();
    for c in 0..mesh.cell_count() {
        let cell = mesh.cell(c);
        let coordinate = |k: usize, axis: usize| mesh.points()[cell[k] as usize][axis];
        let height: [f64; 4] = std::array::from_fn(|k| coordinate(k, axis) - position);
        let above = height.map(|h| if position == low[axis] { h > 0.0 } else { h >= 0.0 });
        if above.iter().all(|a| *a) || !above.iter().any(|a| *a) {
            continue;
        }
        let mut corners = section(&height, &above);
        for other in [(axis + 1) % 3, (axis + 2) % 3] {
            let at = |l: &[f64; 4]| (0..4).map(|k| l[k] * coordinate(k, other)).sum::<f64>();
            corners = clipped(corners, |l| at(l) - low[other]);
            corners = clipped(corners, |l| high[other] - at(l));
        }
        for k in 2..corners.len() {
            triangles.push((c as u32, [corners[0], corners[k - 1], corners[k]]));
        }
    }
    triangles
}

/// The corners, in barycentric coordinates and in their order around it, of the section of a plane
/// with a cell whose vertices have such heights over the plane.
fn section(height: &[f64; 4], above: &[bool; 4]) -> Vec<[f64; 4]> {
    let mut corners = Vec::with_capacity(4);
    for &(i, j) in EDGES.iter().filter(|(i, j)| above[*i] != above[*j]) {
        let mut l = [0.0; 4];
        l[j] = height[i] / (height[i] - height[j]);
        l[i] = 1.0 - l[j];
        corners.push(((i, j), l));
    }
    // In a quadrilateral neighbours lie on edges that share a vertex: put the one that shares none
    // opposite.
    if corners.len() == 4 {
        let (i, j) = corners[0].0;
        let opposite =
            corners.iter().position(|((a, b), _)| ![i, j].contains(a) && ![i, j].contains(b));
        corners.swap(2, opposite.unwrap_or(2));
    }
    corners.into_iter().map(|(_, l)| l).collect()
}

/// The part of a convex polygon where a linear function is not negative.
fn clipped(corners: Vec<[f64; 4]>, f: impl Fn(&[f64; 4]) -> f64) -> Vec<[f64; 4]> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (k, a) in corners.iter().enumerate() {
        let b = &corners[(k + 1) % corners.len()];
        let (fa, fb) = (f(a), f(b));
        if fa >= 0.0 {
            kept.push(*a);
        }
        if (fa >= 0.0) != (fb >= 0.0) {
            let t = fa / (fa - fb);
            kept.push(std::array::from_fn(|i| a[i] + t * (b[i] - a[i])));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::box_mesh;
    use std::sync::Arc;

    #[test]
    fn a_slice_covers_the_section_of_the_box_once_wherever_it_lies() {
        let mesh = Arc::new(box_mesh([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [3, 4, 5]).unwrap());
        let space = Space::new(&mesh, Element::P1);
        let f = vec![0.0; space.len()];
        let area = |axis, position, shown: &[Point<3>; 2]| {
            let slice = Slice { axis, position, field: FieldData::Scalar(&f) };
            let cut = CutPlane::new(&space, &slice, &[], shown).unwrap();
            let triangle = |(cell, corners): &(u32, [[f64; 4]; 3])| {
                let [a, b, c] = corners.map(|l| cut.point(*cell, &l));
                assert!([a, b, c].iter().all(|x| (x[axis] - position).abs() < 1e-14));
                0.5 * (b - a).cross(&(c - a)).norm()
            };
            cut.triangles.iter().map(triangle).sum::<f64>()
        };
        for (axis, section, high) in [(0, 6.0, 1.0), (1, 3.0, 2.0), (2, 2.0, 3.0)] {
            // At the ends, along facets of cells, and through them.
            for position in [0.0, 0.5 * high, 0.37 * high, high] {
                let area = area(axis, position, &mesh.bounding_box().into());
                assert!((area - section).abs() < 1e-12, "axis {axis} at {position}: {area}");
            }
        }
        let part = [[0.25, 0.1, 1.0], [0.85, 1.3, 2.5]].map(Point::<3>::from);
        assert!(
            (area(0, 0.3, &part) - 1.2 * 1.5).abs() < 1e-12
                && (area(2, 1.0, &part) - 0.6 * 1.2).abs() < 1e-12
        );
    }

    #[test]
    fn slices_that_cannot_be_are_refused() {
        let space =
            Space::new(&Arc::new(box_mesh([0.0; 3], [1.0; 3], [1; 3]).unwrap()), Element::P2);
        let f = vec![0.0; space.len()];
        let shown = [Point::<3>::zeros(), Point::<3>::repeat(1.0)];
        let refused = |axis, position, f: &[f64]| {
            CutPlane::new(
                &space,
                &Slice { axis, position, field: FieldData::Scalar(f) },
                &[],
                &shown,
            )
            .err()
            .unwrap()
        };
        let e = refused(1, 1.5, &f);
        assert!(
            e.what().contains("outside")
                && e.wrong_value() == "y = 1.5"
                && e.advice().contains("0 to 1"),
            "{e}"
        );
        refused(0, f64::NAN, &f);
        refused(3, 0.5, &f);
        refused(0, 0.5, &f[1..]);
    }
}
