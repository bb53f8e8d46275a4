//! Shapes that continue through periodic sides.

use crate::base::{Error, Result, length, parallel};
use crate::fem::{Space, Translation, image_shifts};
use crate::levelset::Shape;
use crate::mesh::Point;

/// Difference, over the size of the domain, up to which two distances are the same: formulas with
/// rounded constants are periodic up to this.
const SAME: f64 = 1e-4;

/// A shape with its images through periodic sides.
///
/// A shape such as a circle is repeated, and the set is the union of all images. One that a
/// translation maps onto itself, such as the half plane below a wave, is the same in all of them;
/// as its interface may be known near the domain alone, the nearest of the images tells the
/// distance.
pub(super) struct Images<const D: usize> {
    shape: Box<dyn Shape<D>>,
    /// Translations that map the shape onto itself.
    same: Vec<Point<D>>,
    /// Translations that make other images of it.
    apart: Vec<Point<D>>,
}

impl<const D: usize> Images<D> {
    /// The images of `shape` through the periodic sides `pairs`.
    pub fn new(shape: Box<dyn Shape<D>>, space: &Space<D>, pairs: &[Translation<D>]) -> Images<D> {
        let mut axes: Vec<Translation<D>> = Vec::new();
        for p in pairs {
            let near = |s: Point<D>| s.norm() < 1e-6 * p.shift.norm();
            if !axes.iter().any(|a| near(a.shift - p.shift) || near(a.shift + p.shift)) {
                axes.push(p.clone());
            }
        }
        let tolerance = SAME * size(space);
        let is_same = |shift: &Point<D>| {
            let [differing] = parallel::sum(space.len(), |n| {
                let x = &space.nodes()[n];
                let d = shape.distance(x);
                let differs = |y: Point<D>| (shape.distance(&y) < 0.0) != (d < 0.0);
                // At the interface the sign is a rounding error.
                let differs = d.abs() > tolerance && (differs(x + shift) || differs(x - shift));
                [f64::from(u8::from(differs))]
            });
            differing == 0.0
        };
        let (same, apart): (Vec<_>, Vec<_>) = axes.into_iter().partition(|a| is_same(&a.shift));
        Images { same: image_shifts(&same), apart: image_shifts(&apart), shape }
    }

    /// Signed distance from `x` to the boundary of the union of all images.
    pub fn distance(&self, x: &Point<D>) -> f64 {
        let image = |shift: &Point<D>| {
            let own = self.shape.distance(&(x + shift));
            let others = self.same.iter().skip(1).map(|s| self.shape.distance(&(x + shift + s)));
            others.fold(own.abs(), |least, d| least.min(d.abs())).copysign(own)
        };
        union(self.apart.iter().map(image))
    }

    /// The distances at the nodes of `space`.
    ///
    /// # Errors
    /// Distances that differ on two periodic sides.
    pub fn nodal(&self, space: &Space<D>, pairs: &[Translation<D>]) -> Result<Vec<f64>> {
        let mut nodal = vec![0.0; space.len()];
        parallel::fill(&mut nodal, 1, |first, part| {
            for (d, x) in part.iter_mut().zip(&space.nodes()[first..]) {
                *d = self.distance(x);
            }
        });
        let tolerance = SAME * size(space);
        for p in pairs {
            for n in space.facet_nodes(&space.mesh().facets()[p.facet as usize]) {
                let x = &space.nodes()[n as usize];
                let (here, y) = (nodal[n as usize], x + p.shift);
                let there = self.distance(&y);
                if (here - there).abs() > tolerance {
                    return Err(Error::scene("the shape is not the same on both periodic sides")
                        .value(format!(
                            "its distance is {} at {:?}, {} at {:?}",
                            length(here),
                            x.as_slice(),
                            length(there),
                            y.as_slice()
                        ))
                        .remedy(
                            "give a function with the period of the domain or a shape within one \
                             period, or other conditions than periodic",
                        ));
                }
            }
        }
        Ok(nodal)
    }
}

fn size<const D: usize>(space: &Space<D>) -> f64 {
    let (low, high) = space.mesh().bounding_box();
    (high - low).norm()
}

/// The signed distance to the union of images, from the distances to each. Where all are negative,
/// the point is in all of them, and the smallest magnitude is taken.
fn union(distances: impl Iterator<Item = f64>) -> f64 {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    let (least, greatest) = distances.fold(start, |(l, g), d| (l.min(d), g.max(d)));
    if greatest < 0.0 { greatest } else { least }
}
