//! Level functions, and the grid on which their zero sets are traced.

use crate::base::{Error, Result, parallel};
use crate::mesh::Point;

/// A level function: negative inside.
pub(super) type Level<const D: usize = 2> = dyn Fn(&Point<D>) -> f64 + Send + Sync;

/// A grid of squares or cubes.
pub(super) struct Grid<const D: usize> {
    origin: Point<D>,
    /// Side of a square or cube.
    pub(super) step: f64,
    /// Nodes along each axis; those along x follow one another.
    pub(super) nodes: [usize; D],
    /// Diagonal of the box, without the margin.
    pub(super) diagonal: f64,
}

impl<const D: usize> Grid<D> {
    /// `count` along the longest side of the box, and `margin` more on every side.
    pub(super) fn over((low, high): (Point<D>, Point<D>), count: usize, margin: usize) -> Grid<D> {
        let size = high - low;
        let step = size.max() / count as f64;
        let nodes = std::array::from_fn(|i| (size[i] / step).ceil() as usize + 2 * margin + 1);
        Grid { origin: low.add_scalar(-(margin as f64) * step), step, nodes, diagonal: size.norm() }
    }
    /// Node number `k`.
    pub(super) fn point(&self, mut k: usize) -> Point<D> {
        let index = Point::<D>::from_fn(|i, _| {
            let along = k % self.nodes[i];
            k /= self.nodes[i];
            along as f64
        });
        self.origin + index * self.step
    }
    /// Values at all nodes.
    pub(super) fn sample(&self, f: &Level<D>) -> Vec<f64> {
        let mut values = vec![0.0; self.nodes.iter().product()];
        parallel::fill(&mut values, 1, |first, part| {
            part.iter_mut().enumerate().for_each(|(k, v)| *v = f(&self.point(first + k)));
        });
        values
    }
}

/// A grid over the domain with the values of `f`, which has a zero set there.
///
/// # Errors
/// A domain without extent, a value in it that is not finite, no zero set in it.
pub(super) fn sampled<const D: usize>(
    f: &Level<D>,
    domain: (Point<D>, Point<D>),
    count: usize,
    margin: usize,
) -> Result<(Grid<D>, Vec<f64>)> {
    let size = domain.1 - domain.0;
    if !(size.min() > 0.0 && size.norm().is_finite()) {
        let extent = if D == 2 { "area" } else { "volume" };
        return Err(Error::scene(format!("the domain of a level function has no {extent}"))
            .value(format!("{:?} to {:?}", domain.0.as_slice(), domain.1.as_slice())));
    }
    let grid = Grid::over(domain, count, margin);
    let values = grid.sample(f);
    let mut range = (f64::INFINITY, f64::NEG_INFINITY);
    for (k, &v) in values.iter().enumerate() {
        let x = grid.point(k);
        if (0..D).all(|i| x[i] >= domain.0[i] && x[i] <= domain.1[i]) {
            if !v.is_finite() {
                let place: Vec<String> = ["x", "y", "z"]
                    .iter()
                    .zip(x.iter())
                    .map(|(n, x)| format!("{n} = {x}"))
                    .collect();
                return Err(Error::scene("the function of a shape has no finite value")
                    .at(place.join(", "))
                    .value(v)
                    .remedy("the function must be defined in the whole domain"));
            }
            range = (range.0.min(v), range.1.max(v));
        }
    }
    if range.0 < 0.0 && range.1 >= 0.0 {
        return Ok((grid, values));
    }
    Err(Error::scene("the function of a shape has no zero in the domain")
        .value(format!("its values there run from {} to {}", range.0, range.1))
        .remedy(format!(
            "it must be negative inside the shape and positive outside; a shape smaller than \
             {:.3e} is not seen",
            grid.step
        )))
}

/// The zero of `f` between a point where it is negative and one where it is not, to within
/// `tolerance`, by Chandrupatla's method (1997): inverse quadratic interpolation where it is safe,
/// bisection elsewhere.
pub(super) fn root<const D: usize>(
    f: &Level<D>,
    inner: (Point<D>, f64),
    outer: (Point<D>, f64),
    tolerance: f64,
) -> Point<D> {
    let (origin, direction) = (inner.0, outer.0 - inner.0);
    let width = tolerance / direction.norm();
    // The zero lies between a and b; a is the latest point, c the one before.
    let (mut a, mut b) = ((0.0, inner.1), (1.0, outer.1));
    let mut t = a.1 / (a.1 - b.1);
    for _ in 0..100 {
        let s = a.0 + t * (b.0 - a.0);
        let new = (s, f(&(origin + direction * s)));
        if !new.1.is_finite() {
            break;
        }
        let c = if (new.1 < 0.0) == (a.1 < 0.0) {
            a
        } else {
            let old = b;
            b = a;
            old
        };
        a = new;
        let limit = (width + f64::EPSILON) / (b.0 - a.0).abs();
        if limit >= 0.5 || a.1 == 0.0 {
            break;
        }
        let (xi, phi) = ((a.0 - b.0) / (c.0 - b.0), (a.1 - b.1) / (c.1 - b.1));
        t = 0.5;
        if phi * phi < xi && (1.0 - phi).powi(2) < 1.0 - xi {
            t = a.1 / (b.1 - a.1) * c.1 / (b.1 - c.1)
                + (c.0 - a.0) / (b.0 - a.0) * a.1 / (c.1 - a.1) * b.1 / (c.1 - b.1);
        }
        t = t.clamp(limit, 1.0 - limit);
    }
    let best = if a.1.abs() <= b.1.abs() { a.0 } else { b.0 };
    origin + direction * best
}
