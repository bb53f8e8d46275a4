//! Transfer of fields between two meshes of the same domain: by values at the new nodes, or by
//! projection over the supermesh.

use super::mass::Mass;
use super::periodic::Translation;
use super::quadrature::Rule;
use super::space::{Space, Value};
use super::supermesh::Supermesh;
use crate::base::{Error, Result};
use crate::mesh::{Location, Locator, Mesh, Point};
use nalgebra::SVector;
use std::sync::Arc;

/// Largest distance of a new node from the old domain, relative to the extent of the domain.
const OFF: f64 = 1e-6;

/// Distance of a new node from the old domain, over the longest edge of the nearest cell, up to
/// which a side is the same and only divided in another way: a chord of length `h` of a circle of
/// radius `R` is `h^2/8R` from it.
const CHORD: f64 = 0.1;

/// Locations of the nodes of a space in another mesh, for any number of fields.
#[derive(Clone, Debug)]
pub struct Interpolation(Vec<Location>);

impl Interpolation {
    /// Locates the nodes of `to` in `from`. Nodes outside by rounding are moved to the boundary.
    ///
    /// # Errors
    /// Input, if a node lies outside the old domain by more than a millionth of its extent.
    pub fn new<const D: usize>(from: &Mesh<D>, to: &Space<D>) -> Result<Interpolation> {
        let locator = Locator::new(from);
        let (low, high) = from.bounding_box();
        let mut last = Location { cell: 0, barycentric: [1.0 / (D + 1) as f64; 4] };
        let mut places = Vec::with_capacity(to.len());
        for x in to.nodes() {
            let place = match locator.locate(from, x) {
                Some(place) => place,
                None => {
                    let start = from.point_at(&last);
                    let (place, _) = from.walk(last.cell, &start, x);
                    let off = (from.point_at(&place) - x).norm();
                    if off.is_nan() || off > OFF * (high - low).norm() {
                        return Err(Error::input("a field is carried to a mesh of another domain")
                            .at(format!("node {:?}", x.as_slice()))
                            .value(format!("{off:e} outside")));
                    }
                    place
                }
            };
            last = place;
            places.push(place);
        }
        Ok(Interpolation(places))
    }

    /// Locates the nodes of `to` in `from`, a mesh of the same domain or of a larger one. Curved
    /// sides may be divided in another way: a node outside by less than a tenth of an edge takes
    /// the value at a point of the boundary near it.
    ///
    /// # Errors
    /// Input, if nodes lie farther outside: their number, and the farthest.
    pub fn within<const D: usize>(from: &Mesh<D>, to: &Space<D>) -> Result<Interpolation> {
        let (locator, used) = (Locator::new(from), to.used_nodes());
        let mut border = None;
        let (mut outside, mut farthest) = (0, (0.0, Point::<D>::zeros()));
        let mut places = Vec::with_capacity(to.len());
        for (x, used) in to.nodes().iter().zip(used) {
            places.push(match locator.locate(from, x) {
                Some(place) => place,
                None => {
                    let border = border.get_or_insert_with(|| Border::new(from));
                    let (place, off) = border.nearest(from, x);
                    let is_far = off.is_nan() || off > CHORD * from.diameter(place.cell as usize);
                    if used && is_far {
                        outside += 1;
                        farthest = if off > farthest.0 { (off, *x) } else { farthest };
                    }
                    place
                }
            });
        }
        let (off, x) = farthest;
        match outside {
            0 => Ok(Interpolation(places)),
            n => Err(Error::input("a field is carried to a mesh that covers more than its own")
                .value(format!(
                    "{n} of {} nodes are outside, the farthest at {:.4?} by {off:.3e}",
                    to.len(),
                    x.as_slice()
                ))),
        }
    }

    /// Values of a function of `from` (a space on the old mesh) at the new nodes. Exact for
    /// functions in both spaces, of order 3 for P2 and smooth functions; integrals are not
    /// conserved.
    pub fn apply<const D: usize, T: Value>(&self, from: &Space<D>, f: &[T]) -> Vec<T> {
        self.0.iter().map(|at| from.value(f, at.cell as usize, &at.barycentric)).collect()
    }
}

/// The cells at the boundary of a mesh, each with its first point and its longest edge.
struct Border<const D: usize>(Vec<(u32, Point<D>, f64)>);

impl<const D: usize> Border<D> {
    fn new(mesh: &Mesh<D>) -> Border<D> {
        let of = |cell: u32| {
            let c = cell as usize;
            (cell, mesh.points()[mesh.cell(c)[0] as usize], mesh.diameter(c))
        };
        let mut cells: Vec<u32> = mesh.facets().iter().map(|f| f.cell).collect();
        cells.dedup();
        Border(cells.into_iter().map(of).collect())
    }

    /// A location near `x`, a point outside, and its distance.
    fn nearest(&self, mesh: &Mesh<D>, x: &Point<D>) -> (Location, f64) {
        let mut best = (Location { cell: self.0[0].0, barycentric: [f64::NAN; 4] }, f64::INFINITY);
        for (cell, corner, size) in &self.0 {
            if (corner - x).norm() - size < best.1 {
                let place = mesh.nearby(*cell, x);
                let off = (mesh.point_at(&place) - x).norm();
                if off < best.1 {
                    best = (place, off);
                }
            }
        }
        best
    }
}

/// The L2 projection of functions on one mesh to a space on another, `(u_new, q) = (u_old, q)` for
/// all `q` of the new space, integrated exactly over the intersections of old and new triangles
/// (Farrell and others 2009): conserves the integral, and all moments with functions of the new
/// space, to rounding. Does not keep extrema or boundary values.
///
/// Each field costs about ten clippings of pairs of triangles per new cell and about 30 products
/// with the mass matrix.
pub struct Projection {
    supermesh: Supermesh,
    mass: Mass,
}

impl Projection {
    /// Intersects the meshes. Nodes that `translations` identifies in the new space share their
    /// values.
    ///
    /// # Errors
    /// Input, if the meshes do not cover the same domain.
    pub fn new(
        from: &Arc<Mesh<2>>,
        to: &Arc<Space<2>>,
        translations: &[Translation<2>],
    ) -> Result<Projection> {
        Ok(Projection {
            supermesh: Supermesh::new(from, to.mesh())?,
            mass: Mass::new(to, translations),
        })
    }

    /// The projection of a scalar function of `from`.
    ///
    /// # Errors
    /// Computation, if the solve does not converge: the field is not finite.
    pub fn scalar(&self, from: &Space<2>, f: &[f64]) -> Result<Vec<f64>> {
        self.mass.solve(&self.moments(from, f))
    }

    /// The projection of a vector function of `from`, by components. It is not discretely
    /// divergence-free even if `f` is: this would take a solve of the flow.
    ///
    /// # Errors
    /// As [`scalar`](Self::scalar).
    pub fn vector(&self, from: &Space<2>, f: &[SVector<f64, 2>]) -> Result<Vec<SVector<f64, 2>>> {
        let moments = self.moments(from, f);
        let component =
            |i: usize| self.mass.solve(&moments.iter().map(|m| m[i]).collect::<Vec<f64>>());
        let (x, y) = (component(0)?, component(1)?);
        Ok(x.into_iter().zip(y).map(|(x, y)| SVector::<f64, 2>::new(x, y)).collect())
    }

    /// `(f, q)` for the basis functions `q` of the new space.
    fn moments<T: Value>(&self, from: &Space<2>, f: &[T]) -> Vec<T> {
        let to = self.mass.space();
        let rule = Rule::simplex(2, from.element().degree() + to.element().degree());
        self.supermesh.moments(from, f, to, &rule)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Basis, Cells, Element, Errors, integrate, scalar_errors};
    use crate::mesh::adapt::{AdaptOptions, Metric, adapt};
    use crate::mesh::{Diagonals, Point, rectangle};

    /// A mesh of about `n` triangles a side whose triangles have nothing to do with those of the
    /// other `turn`.
    fn adapted(n: usize, turn: bool) -> Arc<Mesh<2>> {
        let mesh = rectangle([0.0; 2], [1.0; 2], [n, n], Diagonals::Right).unwrap();
        let size = |x: &Point<2>| (1.0 + if turn { x[1] } else { 1.0 - x[0] }) / (1.5 * n as f64);
        let metric = Metric::isotropic(&mesh.points().iter().map(size).collect::<Vec<_>>());
        Arc::new(adapt(&mesh, &metric, &AdaptOptions::default()).unwrap().mesh)
    }

    fn integral(space: &Arc<Space<2>>, f: &[f64]) -> f64 {
        let basis = Basis::new(space, &Arc::new(Rule::simplex(2, 2)));
        integrate(&basis, Cells::All, |at| [basis.value(at, f)])[0]
    }

    fn wave(x: &Point<2>) -> f64 {
        (5.0 * x[0]).sin() * (4.0 * x[1] + 1.0).cos()
    }

    fn wave_and_slope(x: &Point<2>) -> (f64, SVector<f64, 2>) {
        let ((s, c), (p, q)) = ((5.0 * x[0]).sin_cos(), (4.0 * x[1] + 1.0).sin_cos());
        (s * q, SVector::<f64, 2>::new(5.0 * c * q, -4.0 * s * p))
    }

    #[test]
    fn functions_of_both_spaces_are_carried_exactly() {
        let (old, new) = (adapted(7, false), adapted(9, true));
        let quadratic = |x: &Point<2>| 1.0 - x[0] * x[1] + 3.0 * x[1] * x[1];
        let linear = |x: &Point<2>| 1.0 - x[0] + 2.0 * x[1];
        for (element, f) in
            [(Element::P1, &linear as &dyn Fn(&Point<2>) -> f64), (Element::P2, &quadratic)]
        {
            let (from, to) = (Space::new(&old, element), Arc::new(Space::new(&new, element)));
            let (given, expected) = (from.interpolate(f), to.interpolate(f));
            let interpolated = Interpolation::new(&old, &to).unwrap().apply(&from, &given);
            let projected = Projection::new(&old, &to, &[]).unwrap().scalar(&from, &given).unwrap();
            for found in [interpolated, projected] {
                let worst =
                    found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(worst < 1e-12, "{element:?}: {worst:e}");
            }
        }
    }

    #[test]
    fn projection_conserves_the_integral_and_never_gains_energy() {
        let (old, new) = (adapted(12, false), adapted(6, true));
        let (from, to) =
            (Arc::new(Space::new(&old, Element::P2)), Arc::new(Space::new(&new, Element::P2)));
        // Rough on purpose: the nodes of the old mesh decide the signs.
        let rough: Vec<f64> = (0..from.len()).map(|i| 1.0 + ((i * i) as f64).sin()).collect();
        let projection = Projection::new(&old, &to, &[]).unwrap();
        let projected = projection.scalar(&from, &rough).unwrap();
        let before = integral(&from, &rough);
        assert!((integral(&to, &projected) - before).abs() < 1e-13 * before.abs());
        let interpolated = Interpolation::new(&old, &to).unwrap().apply(&from, &rough);
        assert!(
            (integral(&to, &interpolated) - before).abs() > 1e-4,
            "interpolation does not conserve"
        );
        let vector: Vec<SVector<f64, 2>> =
            rough.iter().map(|r| SVector::<f64, 2>::new(*r, 1.0 - r)).collect();
        let carried = projection.vector(&from, &vector).unwrap();
        assert!(
            carried
                .iter()
                .zip(&projected)
                .all(|(v, p)| (v[0] - p).abs() + (v[1] - 1.0 + p).abs() < 1e-11)
        );
        let energy = |space: &Arc<Space<2>>, f: &[f64]| {
            scalar_errors(space, f, |_| (0.0, SVector::zeros())).l2
        };
        assert!(energy(&to, &projected) < energy(&from, &rough));
    }

    #[test]
    fn both_ways_are_of_order_three_for_smooth_functions() {
        let mut rows: Vec<[Errors; 2]> = Vec::new();
        for n in [8, 16, 32] {
            let (old, new) = (adapted(n, false), adapted(n, true));
            let (from, to) =
                (Space::new(&old, Element::P2), Arc::new(Space::new(&new, Element::P2)));
            let given = from.interpolate(wave);
            let interpolated = Interpolation::new(&old, &to).unwrap().apply(&from, &given);
            let projected = Projection::new(&old, &to, &[]).unwrap().scalar(&from, &given).unwrap();
            rows.push([interpolated, projected].map(|f| scalar_errors(&to, &f, wave_and_slope)));
        }
        for k in 0..2 {
            let order = |e: &dyn Fn(&Errors) -> f64| (e(&rows[1][k]) / e(&rows[2][k])).log2();
            let (l2, h1) = (order(&|e| e.l2), order(&|e| e.h1));
            assert!(l2 > 2.8 && h1 > 1.8 && rows[2][k].l2 < 2.5e-5, "{k}: {l2} {h1} {rows:?}");
        }
    }

    #[test]
    fn a_field_that_is_not_finite_is_refused() {
        let mesh = adapted(3, true);
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let projection = Projection::new(&mesh, &space, &[]).unwrap();
        let zero = projection.scalar(&space, &vec![0.0; space.len()]).unwrap();
        assert!(zero.iter().all(|v| *v == 0.0));
        let message =
            projection.scalar(&space, &vec![f64::NAN; space.len()]).unwrap_err().to_string();
        assert!(message.contains("did not converge"), "{message}");
    }

    #[test]
    fn a_mesh_of_another_domain_is_refused() {
        let old = adapted(4, false);
        let wide = Arc::new(rectangle([0.0; 2], [1.1, 1.0], [4, 4], Diagonals::Right).unwrap());
        let to = Arc::new(Space::new(&wide, Element::P2));
        let message = Interpolation::new(&old, &to).unwrap_err().to_string();
        assert!(message.contains("another domain") && message.contains("outside"), "{message}");
        assert!(Projection::new(&old, &to, &[]).err().unwrap().to_string().contains("is covered"));
    }
}
