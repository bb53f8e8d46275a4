//! Distance of two interfaces.

use crate::base::{Error, Result};
use crate::levelset::Contour;
use crate::mesh::{Locator, Point};
use crate::output::{Snapshot, read_pvd, read_vtu, same_time};
use std::path::Path;

/// The distance of one interface from another: over its length on average, and at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Mean over the length of the first.
    pub mean: f64,
    /// Largest at the points where it was taken, some eight a cell.
    pub largest: f64,
}

/// Steps along the gradient to the zero set.
const STEPS: usize = 8;

/// The distance of the P2 zero set of `name.level_set` in `first` from that in `second`, two fields
/// on any meshes.
///
/// The points are those of [`Contour::quadrature`]; from each, Newton's method along the gradient
/// of the second field leads to its zero set. Right to first order in the distance over the radius
/// of curvature; meant for interfaces that are close.
///
/// # Errors
/// A field that is missing; no interface in the first, or one that leaves the mesh of the second.
pub fn distance(first: &Snapshot<2>, second: &Snapshot<2>, name: &str) -> Result<Distance> {
    let field = format!("{name}.level_set");
    let (near, far) = (first.scalar(&field)?, second.scalar(&field)?);
    let points = Contour::new(&first.space, near)?.quadrature(&first.space, near);
    let mesh = second.space.mesh();
    let locator = Locator::new(mesh);
    let (mut length, mut sum, mut largest) = (0.0, 0.0, 0.0f64);
    for point in &points {
        let mut x: Point<2> = point.point;
        for _ in 0..STEPS {
            let Some(at) = locator.locate(mesh, &x) else { return Err(lost(name)) };
            let cell = at.cell as usize;
            let gradient = second.space.gradient(far, cell, &at.barycentric);
            let step = gradient
                * (second.space.value(far, cell, &at.barycentric) / gradient.norm_squared());
            if step.iter().any(|c| !c.is_finite()) {
                return Err(lost(name));
            }
            x -= step;
            if step.norm() < 1e-14 {
                break;
            }
        }
        let apart = (x - point.point).norm();
        length += point.weight;
        sum += point.weight * apart;
        largest = largest.max(apart);
    }
    if length > 0.0 { Ok(Distance { mean: sum / length, largest }) } else { Err(lost(name)) }
}

fn lost(name: &str) -> Error {
    Error::computation(format!(
        "the interfaces of `{name}` on two levels cannot be compared: one is gone, or they lie \
         far apart"
    ))
}

/// The fields that a run wrote at a time.
///
/// # Errors
/// There are none, or they cannot be read.
pub fn fields_at(folder: &Path, time: f64) -> Result<Snapshot<2>> {
    let entry =
        read_pvd(&folder.join("fields.pvd"))?.into_iter().find(|(t, _)| same_time(*t, time));
    let Some((_, file)) = entry else {
        return Err(Error::input("the run has no fields at this time")
            .at(folder.display().to_string())
            .value(time));
    };
    read_vtu(&folder.join(file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Element, Space};
    use crate::mesh::{Diagonals, rectangle};
    use crate::output::Values;
    use std::sync::Arc;

    fn circle(n: usize, radius: f64, shift: f64) -> Snapshot<2> {
        let mesh = Arc::new(rectangle([0.0; 2], [2.0; 2], [n; 2], Diagonals::UnionJack).unwrap());
        let space = Space::new(&mesh, Element::P2);
        // Not a distance: the slope must not matter.
        let phi = space.interpolate(|x| {
            3.0 * ((x[0] - 1.0 - shift).powi(2) + (x[1] - 1.0).powi(2) - radius * radius)
        });
        Snapshot { time: 0.0, space, fields: vec![("drop.level_set".into(), Values::Scalar(phi))] }
    }

    #[test]
    fn circles_lie_apart_by_the_difference_of_their_radii() {
        // Quadratic fields are exact on P2, whatever the meshes.
        let d = distance(&circle(12, 0.5, 0.0), &circle(31, 0.5023, 0.0), "drop").unwrap();
        assert!((d.mean - 0.0023).abs() < 1e-10 && (d.largest - 0.0023).abs() < 1e-10, "{d:?}");
        let d = distance(&circle(12, 0.5, 0.0), &circle(31, 0.5, 1e-3), "drop").unwrap();
        // A shift by s: the mean of s |cos| is 2 s/pi.
        assert!(
            (d.largest - 1e-3).abs() < 1e-5 && (d.mean - 2e-3 / std::f64::consts::PI).abs() < 1e-5,
            "{d:?}"
        );
    }

    #[test]
    fn what_cannot_be_compared_is_an_error() {
        let (a, b) = (circle(12, 0.5, 0.0), circle(12, 0.5, 0.0));
        assert!(distance(&a, &b, "film").is_err());
        let mut gone = circle(12, 0.5, 0.0);
        gone.fields = vec![("drop.level_set".into(), Values::Scalar(vec![1.0; gone.space.len()]))];
        assert!(distance(&gone, &a, "drop").unwrap_err().what().contains("drop"));
    }
}
