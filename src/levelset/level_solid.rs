//! Shapes in space given by a level function.

use super::distance::Tree;
use super::grid::{Grid, Level, root, sampled};
use super::shape::Shape;
use crate::base::Result;
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};

/// Number of cubes of the grid along the longest side of the domain, and of the margin on every
/// side.
const GRID: usize = 48;
/// Tolerance for zeros on the lines of the grid and for closest points, as a fraction of a cube.
const TOLERANCE: f64 = 1e-10;
/// Largest number of steps of Newton's method for the closest point.
const MOST_STEPS: usize = 12;
/// The six tetrahedra of a cube along its diagonal, by corners whose bits are the steps in x, y and
/// z.
const KUHN: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 3, 2, 7], [0, 6, 4, 7], [0, 5, 1, 7]];

/// The set in space where a function is negative, with the true distance to its boundary (not the
/// value of the function).
///
/// The zero set is triangulated on a grid of 48 cubes along the domain (and a quarter of the domain
/// around it, for an interface that leaves the domain). Newton's method, with derivatives by
/// differences, finds the closest point of the zero set from the nearest point of the triangles;
/// the distance then has an error below `1e-9` of the domain. If it fails, as at edges and corners,
/// the distance is that to the triangles: edges and corners are truncated by a fraction of a cube.
/// Limits: a part smaller than a cube of the grid may be missed.
pub struct LevelSolid {
    function: Box<Level<3>>,
    zero_set: Tree<3>,
    /// Side of a cube.
    step: f64,
}

impl LevelSolid {
    /// The set where `function < 0`; `domain` is the bounding box of the mesh.
    ///
    /// # Errors
    /// A value that is not finite, no zero set in the domain.
    pub fn new(
        function: impl Fn(&Point<3>) -> f64 + Send + Sync + 'static,
        domain: (Point<3>, Point<3>),
    ) -> Result<LevelSolid> {
        let function: Box<Level<3>> = Box::new(function);
        let (grid, values) = sampled(&*function, domain, GRID, GRID / 4)?;
        let zero_set = Tree::new(grid.triangles(&*function, &values));
        Ok(LevelSolid { function, zero_set, step: grid.step })
    }

    /// The closest point of the zero set to `x` by Newton's method on `y - x + s grad f(y) = 0`,
    /// `f(y) = 0` from `start`.
    fn foot(&self, x: &Point<3>, start: Point<3>) -> Option<Point<3>> {
        let f = |y: &Point<3>| (self.function)(y);
        let g = gradient(&f, &start, 1e-3 * self.step);
        let mut y = start;
        let mut s = (x - start).dot(&g) / g.norm_squared();
        for _ in 0..MOST_STEPS {
            let g = gradient(&f, &y, 1e-3 * self.step);
            let mut matrix = SMatrix::<f64, 4, 4>::zeros();
            let block = SMatrix::<f64, 3, 3>::identity() + hessian(&f, &y, 1e-2 * self.step) * s;
            matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&block);
            matrix.fixed_view_mut::<3, 1>(0, 3).copy_from(&g);
            matrix.fixed_view_mut::<1, 3>(3, 0).copy_from(&g.transpose());
            let r = x - y - g * s;
            let change = matrix.lu().solve(&SVector::<f64, 4>::new(r[0], r[1], r[2], -f(&y)))?;
            let change_of_y = change.fixed_rows::<3>(0).into_owned();
            y += change_of_y;
            s += change[3];
            let near = (y - start).norm() <= 2.0 * self.step;
            if !near {
                return None;
            }
            if change_of_y.norm() <= TOLERANCE * self.step {
                return Some(y);
            }
        }
        None
    }
}

impl Shape<3> for LevelSolid {
    fn distance(&self, x: &Point<3>) -> f64 {
        let difference = self.zero_set.difference(x);
        let start = x - difference;
        // The triangles are within a cube of the zero set; a foot farther away is not the closest
        // point.
        let foot = self
            .foot(x, start)
            .map(|y| (x - y).norm())
            .filter(|d| *d <= difference.norm() + self.step);
        let d = foot.unwrap_or_else(|| difference.norm());
        if (self.function)(x) < 0.0 { -d } else { d }
    }
    /// The box around the triangles, which reaches a quarter of the domain beyond it where the
    /// interface does.
    fn bounds(&self) -> (Point<3>, Point<3>) {
        self.zero_set.bounds()
    }
}

fn unit(i: usize) -> Point<3> {
    Point::<3>::from_fn(|k, _| if k == i { 1.0 } else { 0.0 })
}

fn gradient(f: &impl Fn(&Point<3>) -> f64, x: &Point<3>, h: f64) -> SVector<f64, 3> {
    Point::<3>::from_fn(|i, _| (f(&(x + unit(i) * h)) - f(&(x - unit(i) * h))) / (2.0 * h))
}

fn hessian(f: &impl Fn(&Point<3>) -> f64, x: &Point<3>, h: f64) -> SMatrix<f64, 3, 3> {
    let mut m = SMatrix::<f64, 3, 3>::zeros();
    for i in 0..3 {
        let u = unit(i) * h;
        m[(i, i)] = (f(&(x + u)) - 2.0 * f(x) + f(&(x - u))) / (h * h);
        for j in 0..i {
            let v = unit(j) * h;
            let mixed = f(&(x + u + v)) - f(&(x + u - v)) - f(&(x - u + v)) + f(&(x - u - v));
            (m[(i, j)], m[(j, i)]) = (mixed / (4.0 * h * h), mixed / (4.0 * h * h));
        }
    }
    m
}

impl Grid<3> {
    /// The zero set, with its corners on the lines of the grid; cubes with a value that is not
    /// finite are left out.
    fn triangles(&self, f: &Level<3>, values: &[f64]) -> Vec<[Point<3>; 3]> {
        let [nx, ny, nz] = self.nodes;
        let mut out = Vec::new();
        for (k, j, i) in (0..nz - 1)
            .flat_map(|k| (0..ny - 1).flat_map(move |j| (0..nx - 1).map(move |i| (k, j, i))))
        {
            let corner = |b: usize| i + (b & 1) + nx * (j + (b >> 1 & 1) + ny * (k + (b >> 2)));
            let cube: [usize; 8] = std::array::from_fn(corner);
            let negative = values[cube[0]] < 0.0;
            if cube.iter().any(|&a| (values[a] < 0.0) != negative)
                && cube.iter().all(|&a| values[a].is_finite())
            {
                KUHN.iter().for_each(|t| self.march(f, values, t.map(|b| cube[b]), &mut out));
            }
        }
        out
    }
    /// Appends the triangles in a tetrahedron.
    fn march(&self, f: &Level<3>, values: &[f64], nodes: [usize; 4], out: &mut Vec<[Point<3>; 3]>) {
        let (inner, outer): (Vec<usize>, Vec<usize>) =
            nodes.iter().partition(|&&a| values[a] < 0.0);
        let zero = |a: usize, b: usize| {
            root(f, (self.point(a), values[a]), (self.point(b), values[b]), TOLERANCE * self.step)
        };
        match (&inner[..], &outer[..]) {
            ([a], [b, c, d]) => out.push([zero(*a, *b), zero(*a, *c), zero(*a, *d)]),
            ([b, c, d], [a]) => out.push([zero(*b, *a), zero(*c, *a), zero(*d, *a)]),
            ([a, b], [c, d]) => {
                let [ac, ad, bd, bc] = [zero(*a, *c), zero(*a, *d), zero(*b, *d), zero(*b, *c)];
                out.extend([[ac, ad, bd], [ac, bd, bc]]);
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levelset::{Circle, Ellipsoid, RoundedBox};

    fn p(x: f64, y: f64, z: f64) -> Point<3> {
        Point::<3>::new(x, y, z)
    }
    fn domain() -> (Point<3>, Point<3>) {
        (p(-1.0, -1.0, -1.0), p(1.0, 1.0, 1.0))
    }
    /// Largest difference of the distances of two shapes on a grid in the domain, at points where
    /// `of` holds.
    fn difference(a: &dyn Shape<3>, b: &dyn Shape<3>, of: impl Fn(&Point<3>) -> bool) -> f64 {
        let n = 13;
        (0..n * n * n)
            .map(|k| {
                p((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64) * (2.0 / (n - 1) as f64)
            })
            .map(|x| x.add_scalar(-1.0))
            .filter(of)
            .map(|x| (a.distance(&x) - b.distance(&x)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn level_functions_of_an_ellipsoid_and_a_ball_give_their_distances() {
        let (axes, centre) = (p(0.75, 0.6, 0.45), p(0.01, -0.02, 0.03));
        let exact = Ellipsoid::new(centre, axes, p(0.0, 0.0, 0.0)).unwrap();
        let square = move |x: &Point<3>| (x - centre).component_div(&axes).norm_squared() - 1.0;
        let shape = LevelSolid::new(square, domain()).unwrap();
        // Outside, and inside up to the focal surfaces.
        let error = difference(&shape, &exact, |x| exact.distance(x) > -0.2);
        assert!(error < 1e-9, "{error}");
        assert!((shape.bounds().1 - exact.bounds().1).norm() < 2e-3);
        let ball = LevelSolid::new(move |x| (x - centre).norm().powi(3) - 0.125, domain()).unwrap();
        let error = difference(&ball, &Circle::new(centre, 0.5).unwrap(), |_| true);
        assert!(error < 1e-9, "{error}");
    }

    #[test]
    fn edges_are_cut_at_a_fraction_of_a_cube() {
        let half = p(0.47, 0.33, 0.61);
        let exact = RoundedBox::turned(p(0.0, 0.0, 0.0), half, 0.0, p(0.0, 0.0, 0.0)).unwrap();
        let shape = LevelSolid::new(move |x| (x.abs() - half).max(), domain()).unwrap();
        let error = difference(&shape, &exact, |_| true);
        assert!(error < shape.step, "{error}");
    }

    #[test]
    fn a_plane_across_the_domain_keeps_its_distance_at_the_walls() {
        let slope =
            LevelSolid::new(|x| (x[1] - 0.1 - 0.25 * x[0]) * (2.0 + x[2]), domain()).unwrap();
        for x in [p(-1.0, -1.0, -1.0), p(1.0, -1.0, 1.0), p(0.0, 1.0, 0.3)] {
            let exact = (x[1] - 0.1 - 0.25 * x[0]) / 1.0625f64.sqrt();
            assert!((slope.distance(&x) - exact).abs() < 1e-9, "{} {exact}", slope.distance(&x));
        }
    }

    #[test]
    fn bad_level_functions_are_refused() {
        let error = |f: fn(&Point<3>) -> f64| {
            LevelSolid::new(f, domain()).err().map(|e| e.to_string()).unwrap_or_default()
        };
        assert!(error(|x| x[0] + 2.0).contains("from 1 to 3"));
        assert!(error(|_| -1.0).contains("no zero"));
        assert!(error(|x| (x[0] - 1.0).ln()).contains("no finite value"));
        let flat = LevelSolid::new(|x| x[0], (p(0.0, 0.0, 0.0), p(1.0, 1.0, 0.0)));
        assert!(flat.err().unwrap().to_string().contains("no volume"));
    }
}
