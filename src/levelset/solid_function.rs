//! Shapes in space given by a level function.

use super::point_tree::PointTree;
use super::shape::Shape;
use crate::base::{Error, Result, parallel};
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};

/// A level function in space: negative inside.
type Level = dyn Fn(&Point<3>) -> f64 + Send + Sync;

/// Cubes of the grid along the longest side of the domain.
const GRID: usize = 64;
/// Steps of Newton's method to the nearest point.
const STEPS: usize = 20;
/// Differences for slopes and curvatures, over the diagonal of the domain.
const DIFFERENCES: [f64; 2] = [1e-6, 1e-4];
/// The nearest point is found to this, over the diagonal of the domain.
const TOLERANCE: f64 = 1e-11;

/// The set where a function is negative, with the distance to its boundary (not the value of the function).
///
/// The zero set is met along the edges of a grid of 64 cubes along the domain (and a quarter of the domain around it). From the nearest of
/// these points Newton's method finds the nearest point `y` of the zero set, by `y - x + s grad f(y) = 0`, `f(y) = 0`. Where it does
/// not converge to one that is nearer, as at an edge of the zero set, the point of the grid is taken.
///
/// Limits: a part smaller than a cube of the grid may be missed; beside a kink of the function, or where two parts of the zero set are
/// nearly as near, the distance may be too large by up to the square of a cube over twice the distance.
pub struct SolidFunction {
    function: Box<Level>,
    points: PointTree<3>,
    diagonal: f64,
}

impl SolidFunction {
    /// The set where `function < 0`; `domain` is the bounding box of the mesh.
    ///
    /// # Errors
    /// A value that is not finite, or no zero set in the domain.
    pub fn new(
        function: impl Fn(&Point<3>) -> f64 + Send + Sync + 'static,
        domain: (Point<3>, Point<3>),
    ) -> Result<SolidFunction> {
        let size = domain.1 - domain.0;
        if !(size.min() > 0.0 && size.norm().is_finite()) {
            return Err(Error::scene("the domain of a level function has no volume").value(format!(
                "{:?} to {:?}",
                domain.0.as_slice(),
                domain.1.as_slice()
            )));
        }
        let grid = Grid::over(domain);
        let values = grid.sample(&function);
        grid.check(&values, domain)?;
        let points = PointTree::new(grid.crossings(&function, &values));
        Ok(SolidFunction { function: Box::new(function), points, diagonal: size.norm() })
    }

    /// Gradient and second derivatives by central differences.
    fn derivatives(&self, x: &Point<3>) -> (SVector<f64, 3>, SMatrix<f64, 3, 3>) {
        let [slope, bend] = DIFFERENCES.map(|d| d * self.diagonal);
        let f = |step: SVector<f64, 3>| (self.function)(&(x + step));
        let along = |axis: usize, length: f64| {
            let mut step = SVector::<f64, 3>::zeros();
            step[axis] = length;
            step
        };
        let gradient = SVector::<f64, 3>::from_fn(|i, _| (f(along(i, slope)) - f(along(i, -slope))) / (2.0 * slope));
        let second = |i: usize, j: usize| {
            let (a, b) = (along(i, 0.5 * bend), along(j, 0.5 * bend));
            (f(a + b) - f(a - b) - f(b - a) + f(-a - b)) / (bend * bend)
        };
        (gradient, SMatrix::<f64, 3, 3>::from_fn(|i, j| second(i, j)))
    }

    /// The nearest point of the zero set to `x`, from `start` near it; `None` if it is not found.
    fn foot(&self, x: &Point<3>, start: &Point<3>) -> Option<Point<3>> {
        let mut y = *start;
        let (gradient, _) = self.derivatives(&y);
        let mut s = (x - y).dot(&gradient) / gradient.norm_squared();
        for _ in 0..STEPS {
            let (gradient, hessian) = self.derivatives(&y);
            let mut matrix = SMatrix::<f64, 4, 4>::zeros();
            matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&(SMatrix::<f64, 3, 3>::identity() + hessian * s));
            matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&gradient);
            matrix.fixed_view_mut::<1, 3>(3, 0).copy_from(&gradient.transpose());
            let residual = (y - x) + gradient * s;
            let right = SVector::<f64, 4>::new(residual[0], residual[1], residual[2], (self.function)(&y));
            let step = matrix.lu().solve(&right)?;
            let move_ = SVector::<f64, 3>::new(step[0], step[1], step[2]);
            y -= move_;
            s -= step[3];
            if !s.is_finite() || !y.iter().all(|c| c.is_finite()) {
                return None;
            }
            if move_.norm() <= TOLERANCE * self.diagonal {
                return Some(y);
            }
        }
        None
    }
}

impl Shape<3> for SolidFunction {
    fn distance(&self, x: &Point<3>) -> f64 {
        let Some(start) = self.points.nearest(x) else { return f64::NAN };
        let seen = (x - start).norm();
        // Newton's method finds other extremes of the distance too, and these are no nearer.
        let found = self.foot(x, start).map_or(seen, |y| (x - y).norm().min(seen));
        if (self.function)(x) < 0.0 { -found } else { found }
    }
    /// The box around the points where the zero set meets the grid.
    fn bounds(&self) -> (Point<3>, Point<3>) {
        self.points.bounds().unwrap_or((Point::<3>::zeros(), Point::<3>::zeros()))
    }
}

/// The grid on which a zero set is found.
struct Grid {
    origin: Point<3>,
    step: f64,
    /// Nodes along each axis.
    nodes: [usize; 3],
}

impl Grid {
    fn over((low, high): (Point<3>, Point<3>)) -> Grid {
        let (size, margin) = (high - low, GRID / 4);
        let step = size.max() / GRID as f64;
        let nodes = [0, 1, 2].map(|i| (size[i] / step).ceil() as usize + 2 * margin + 1);
        Grid { origin: low.add_scalar(-(margin as f64) * step), step, nodes }
    }
    fn point(&self, k: usize) -> Point<3> {
        let [nx, ny, _] = self.nodes;
        let place = [k % nx, k / nx % ny, k / (nx * ny)];
        self.origin + Point::<3>::from_fn(|i, _| place[i] as f64 * self.step)
    }
    /// Values at all nodes.
    fn sample(&self, f: &Level) -> Vec<f64> {
        let mut values = vec![0.0; self.nodes.iter().product()];
        parallel::fill(&mut values, 1, |first, part| {
            part.iter_mut().enumerate().for_each(|(k, v)| *v = f(&self.point(first + k)));
        });
        values
    }
    /// Refuses values in the domain that are not finite, or of one sign.
    fn check(&self, values: &[f64], domain: (Point<3>, Point<3>)) -> Result<()> {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for (k, &v) in values.iter().enumerate() {
            let x = self.point(k);
            if !(0..3).all(|i| x[i] >= domain.0[i] && x[i] <= domain.1[i]) {
                continue;
            }
            if !v.is_finite() {
                return Err(Error::scene("the function of a shape has no finite value")
                    .at(format!("x = {}, y = {}, z = {}", x[0], x[1], x[2]))
                    .value(v)
                    .remedy("the function must be defined in the whole domain"));
            }
            range = (range.0.min(v), range.1.max(v));
        }
        if range.0 < 0.0 && range.1 >= 0.0 {
            return Ok(());
        }
        Err(Error::scene("the function of a shape has no zero in the domain")
            .value(format!("its values there run from {} to {}", range.0, range.1))
            .remedy(format!(
                "it must be negative inside the shape and positive outside; a shape smaller than {:.3e} is not seen",
                self.step
            )))
    }
    /// Where the zero set meets the edges of the grid.
    fn crossings(&self, f: &Level, values: &[f64]) -> Vec<Point<3>> {
        let [nx, ny, nz] = self.nodes;
        let mut found = Vec::new();
        for k in 0..values.len() {
            let ends = [k % nx + 1 < nx, k / nx % ny + 1 < ny, k / (nx * ny) + 1 < nz];
            for (next, inside) in [k + 1, k + nx, k + nx * ny].into_iter().zip(ends) {
                if inside
                    && values[k].is_finite()
                    && values[next].is_finite()
                    && (values[k] < 0.0) != (values[next] < 0.0)
                {
                    found.push(root(f, self.point(k), self.point(next)));
                }
            }
        }
        found
    }
}

/// A zero of `f`, which changes its sign between `a` and `b`, by bisection.
fn root(f: &Level, mut a: Point<3>, mut b: Point<3>) -> Point<3> {
    let negative = f(&a) < 0.0;
    for _ in 0..40 {
        let middle = (a + b) * 0.5;
        if (f(&middle) < 0.0) == negative { a = middle } else { b = middle }
    }
    (a + b) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(x: f64, y: f64, z: f64) -> Point<3> {
        Point::<3>::new(x, y, z)
    }
    const DOMAIN: [f64; 3] = [1.0, 1.0, 1.0];

    fn domain() -> (Point<3>, Point<3>) {
        (-Point::<3>::from(DOMAIN), Point::<3>::from(DOMAIN))
    }

    #[test]
    fn the_distance_to_a_ball_is_exact_whatever_the_slope_of_its_function() {
        let ball =
            SolidFunction::new(|x| (x - p(0.1, 0.0, 0.0)).norm_squared().powi(2) - 0.5f64.powi(4), domain()).unwrap();
        for k in 0..300 {
            let x = p((k as f64).sin(), (2.3 * k as f64).sin(), (3.7 * k as f64).sin());
            let exact = (x - p(0.1, 0.0, 0.0)).norm() - 0.5;
            // Near the centre all points of the ball are as near.
            if exact > -0.45 {
                let found = ball.distance(&x);
                assert!((found - exact).abs() < 1e-9, "{:?}: {found} for {exact}", x.as_slice());
            }
        }
        let (low, high) = ball.bounds();
        assert!((high - p(0.6, 0.5, 0.5)).amax() < 2e-3 && (low - p(-0.4, -0.5, -0.5)).amax() < 2e-3);
    }

    #[test]
    fn the_distance_to_a_box_errs_at_its_edges_by_less_than_a_cube_of_the_grid() {
        let cube = SolidFunction::new(|x| x.abs().max() - 0.503, domain()).unwrap();
        assert!((cube.distance(&p(0.1, 0.2, 0.9)) - 0.397).abs() < 1e-9);
        assert!((cube.distance(&p(0.1, 0.2, 0.4)) + 0.103).abs() < 1e-9);
        let (edge, exact) = (cube.distance(&p(0.803, 0.903, 0.0)), 0.5);
        assert!((edge - exact).abs() < 2.0 / 64.0, "{edge}");
    }

    #[test]
    fn functions_without_a_zero_or_a_value_are_refused() {
        let refused = |f: fn(&Point<3>) -> f64| SolidFunction::new(f, domain()).err().unwrap().to_string();
        assert!(refused(|_| 1.0).contains("no zero"));
        assert!(refused(|x| if x[0] > 0.0 { f64::NAN } else { -1.0 }).contains("finite"));
    }
}
