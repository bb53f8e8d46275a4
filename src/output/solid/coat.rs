//! Surfaces of level sets, coated with the fields of a run.

use super::super::field::{FieldData, on_nodes};
use super::pattern::Pattern;
use super::surface::{Paint, Surface};
use crate::base::Result;
use crate::fem::{Space, Value};
use crate::levelset::{Isosurface, Triangle};
use nalgebra::SVector;

/// Fields on the space of a level set by which its surface is coloured.
#[derive(Clone, Copy, Debug)]
pub enum Coat<'a> {
    /// One colour, see [`Paint::PLAIN`].
    Plain,
    /// A field in the scale of the picture; a vector field by its length.
    Field(FieldData<'a, 3>),
    /// A pattern of the reference state, which the backward characteristic Y carries.
    Checkerboard {
        /// Y at the nodes.
        characteristic: &'a [SVector<f64, 3>],
        /// The pattern.
        pattern: Pattern,
    },
}

/// The flat triangles that a curved one is cut into: its corners are 0, 1, 2, the middles of its
/// sides 3, 4, 5.
const FLAT: [[u32; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

impl Surface {
    /// The surface `phi = 0` of a P2 function, fields taken in their finite element at six points
    /// of each curved triangle.
    ///
    /// Its normals are those of `grad phi`, averaged at the nodes over the cells around: the jumps
    /// of the gradient from cell to cell would look like facets.
    ///
    /// # Errors
    /// Those of [`Isosurface::new`]; a field with a wrong number of values.
    pub fn of_level_set(space: &Space<3>, phi: &[f64], coat: Coat) -> Result<Surface> {
        let surface = Isosurface::new(space, phi)?;
        let triangles = surface.triangles();
        let paint = match coat {
            Coat::Plain => Paint::PLAIN,
            Coat::Field(FieldData::Scalar(f)) => {
                Paint::Scalar(at_points(space, "surface", f, triangles)?)
            }
            Coat::Field(FieldData::Vector(f)) => {
                let values = at_points(space, "surface", f, triangles)?;
                Paint::Scalar(values.iter().map(|v| v.norm()).collect())
            }
            Coat::Checkerboard { characteristic, pattern } => Paint::Checkerboard {
                material: at_points(space, "characteristic", characteristic, triangles)?,
                pattern,
            },
        };
        let normals =
            at_points(space, "normal", &gradient_at_nodes(space, phi, triangles), triangles)?;
        let flat = |k: usize| FLAT.map(|t| t.map(|a| 6 * k as u32 + a));
        Ok(Surface {
            points: triangles.iter().flat_map(|t| t.points).collect(),
            normals,
            triangles: (0..triangles.len()).flat_map(flat).collect(),
            paint,
        })
    }
}

/// A function at the six points of each triangle.
fn at_points<T: Value>(
    space: &Space<3>,
    name: &str,
    f: &[T],
    triangles: &[Triangle],
) -> Result<Vec<T>> {
    let f = on_nodes(space, name, f)?;
    let at = |t: &Triangle| {
        let on_cell = space.on_cell(&f, t.cell as usize);
        t.barycentric.map(|l| on_cell.value(&l))
    };
    Ok(triangles.iter().flat_map(at).collect())
}

/// The mean of the gradients in the cells around a node, at the nodes of the cells with triangles;
/// elsewhere it means nothing.
fn gradient_at_nodes(
    space: &Space<3>,
    phi: &[f64],
    triangles: &[Triangle],
) -> Vec<SVector<f64, 3>> {
    let mut wanted = vec![false; space.len()];
    for t in triangles {
        space.cell_nodes(t.cell as usize).iter().for_each(|&n| wanted[n as usize] = true);
    }
    let near = |c: usize| space.cell_nodes(c).iter().any(|&n| wanted[n as usize]);
    space.means(|c, l| if near(c) { space.gradient(phi, c, l) } else { SVector::<f64, 3>::zeros() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Point, box_mesh};
    use std::sync::Arc;

    #[test]
    fn the_surface_of_a_sphere_has_its_points_normals_and_values() {
        let space =
            Space::new(&Arc::new(box_mesh([-1.0; 3], [1.0; 3], [6; 3]).unwrap()), Element::P2);
        // Quadratic, so that field and gradient are exact.
        let phi = space.interpolate(|x| x.norm_squared() - 0.49);
        let f = space.interpolate(|x| x[0] * x[1] + 2.0 * x[2]);
        let surface =
            Surface::of_level_set(&space, &phi, Coat::Field(FieldData::Scalar(&f))).unwrap();
        surface.check().unwrap();
        let Paint::Scalar(values) = &surface.paint else { panic!("not a scalar") };
        for ((x, n), v) in surface.points.iter().zip(&surface.normals).zip(values) {
            assert!((x.norm() - 0.7).abs() < 2e-3 && (n - x * 2.0).norm() < 1e-12, "{x} {n}");
            assert!((v - (x[0] * x[1] + 2.0 * x[2])).abs() < 1e-12);
        }
        // Of triangles that are turned outward.
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|k| surface.points[k as usize]);
            let across = 0.5 * (b - a).cross(&(c - a));
            across.dot(&(a + b + c)).signum() * across.norm()
        };
        let (sum, exact) =
            (surface.triangles.iter().map(area).sum::<f64>(), 4.0 * std::f64::consts::PI * 0.49);
        assert!((sum / exact - 1.0).abs() < 5e-3, "{sum} {exact}");
    }

    #[test]
    fn the_pattern_is_carried_by_y_and_fields_of_a_wrong_length_are_refused() {
        let space =
            Space::new(&Arc::new(box_mesh([-1.0; 3], [1.0; 3], [3; 3]).unwrap()), Element::P2);
        let phi = space.interpolate(|x| x.norm_squared() - 0.49);
        let y = space.interpolate(|x| Point::<3>::new(x[0] - 0.5 * x[2], x[1], x[2]));
        let pattern = Pattern::Cubes { origin: Point::<3>::zeros(), edge: 0.2 };
        let coat = Coat::Checkerboard { characteristic: &y, pattern };
        let surface = Surface::of_level_set(&space, &phi, coat).unwrap();
        let Paint::Checkerboard { material, .. } = &surface.paint else {
            panic!("not a checkerboard")
        };
        for (x, y) in surface.points.iter().zip(material) {
            assert!((y - Point::<3>::new(x[0] - 0.5 * x[2], x[1], x[2])).norm() < 1e-14);
        }
        let coat = Coat::Checkerboard { characteristic: &y[1..], pattern };
        assert!(Surface::of_level_set(&space, &phi, coat).is_err());
        assert!(Surface::of_level_set(&space, &phi, Coat::Plain).is_ok());
    }
}
