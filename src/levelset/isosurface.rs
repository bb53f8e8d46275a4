//! The surface `phi = 0` of a P2 field in space, cut cell by cell into curved triangles.

use super::patch::Triangle;
use super::quadratic::{Quadratic, barycentric_direction};
use super::sign::cut_cells;
use super::tetrahedron::Tetrahedron;
use crate::base::{Result, parallel};
use crate::fem::{At, Rule, Space, SurfacePoint};
use crate::mesh::Facet;
use nalgebra::SVector;
use rayon::prelude::*;

/// Degree of the rule on a triangle for [`Isosurface::quadrature`].
const DEGREE: usize = 4;
/// Degree for weak forms, three points per triangle: the sum of the normals is exact, and the error
/// is of order 4 in triangles of half the size of a cell.
const DEGREE_OF_FORMS: usize = 2;

/// The surface `phi = 0` of a P2 field on a mesh of tetrahedra.
///
/// The lattice of the P2 nodes divides a cell into eight tetrahedra. If the signs at two lattice
/// nodes differ, `phi` is quadratic on the line between them and its zero there is exact; these
/// zeros are the corners of one or two triangles in a tetrahedron of the lattice. The middle of a
/// side is the zero of `phi` on the line through the middle of its chord along the gradient (its
/// mean from both cells of a face; in the plane of the facet on the boundary of the mesh). This
/// avoids the folding of narrow triangles that occurs within the planes of the faces. Shared points
/// are bit-identical from both cells, so that the surface is closed, or ends on the boundary of the
/// mesh.
///
/// Area and volume have an error of order 4 in the mesh size for a smooth `phi` of the space,
/// single points of order 3.
///
/// Limits: a piece between the nodes of the lattice (half an edge apart) changes no sign and is
/// missed. A value that is exactly 0 counts as positive (outside).
#[derive(Clone, Debug, Default)]
pub struct Isosurface {
    triangles: Vec<Triangle>,
    walls: Vec<Triangle>,
}

impl Isosurface {
    /// The surface of `phi`. Only cells with a change of sign are processed further.
    ///
    /// # Errors
    /// A space that is not P2, a value of `phi` that is not finite.
    pub fn new(space: &Space<3>, phi: &[f64]) -> Result<Isosurface> {
        let cells = cut_cells(space, phi)?;
        let triangles = gather(&cells, |&c, out| Tetrahedron::new(space, phi, c).cut(out));
        let negative = |f: &&Facet| space.facet_nodes(f).any(|n| phi[n as usize] < 0.0);
        let facets: Vec<&Facet> = space.mesh().facets().iter().filter(negative).collect();
        let walls = gather(&facets, |f, out| {
            Tetrahedron::new(space, phi, f.cell as usize).wall(f.opposite as usize, out)
        });
        Ok(Isosurface { triangles, walls })
    }
    /// The triangles, sorted by their cells, with their normals out of `phi < 0`.
    pub fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }
    /// The parts of the boundary of the mesh where `phi < 0`, with their normals out of the mesh:
    /// together with the triangles they enclose the set `phi < 0`.
    pub fn walls(&self) -> &[Triangle] {
        &self.walls
    }
    /// True if there is no surface.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Quadrature points, exact on a triangle to degree 4: moved along the normal onto the P2 zero
    /// set of `phi`, which must be the function that the surface was made from; sorted by their
    /// cells and numbered by `at.q`. Normals and weights, areas, are those of the curved triangles.
    pub fn quadrature(&self, space: &Space<3>, phi: &[f64]) -> Vec<SurfacePoint<3>> {
        self.points(space, phi, &Rule::simplex(2, DEGREE))
    }
    /// Three points on every triangle, on the zero set of the P2 function, sorted by their cells
    /// and numbered by `at.q`. Their normals, out of `phi < 0`, are those of the triangles: their
    /// sum over a closed surface is 0.
    pub fn points_of_forms(&self, space: &Space<3>, phi: &[f64]) -> Vec<SurfacePoint<3>> {
        self.points(space, phi, &Rule::simplex(2, DEGREE_OF_FORMS))
    }

    fn points(&self, space: &Space<3>, phi: &[f64], rule: &Rule) -> Vec<SurfacePoint<3>> {
        let at = |triangle: &Triangle, out: &mut Vec<SurfacePoint<3>>| {
            let points = rule.points.iter().zip(&rule.weights);
            out.extend(points.filter_map(|(t, w)| surface_point(space, phi, triangle, t, *w)));
        };
        let mut points = gather(&self.triangles, at);
        points.iter_mut().enumerate().for_each(|(q, p)| p.at.q = q);
        points
    }

    /// Integral of `f` over the surface of `phi`, by [`Isosurface::quadrature`].
    pub fn integrate(
        &self,
        space: &Space<3>,
        phi: &[f64],
        f: impl Fn(&SurfacePoint<3>) -> f64,
    ) -> f64 {
        self.quadrature(space, phi).iter().map(|p| p.at.weight * f(p)).sum()
    }
}

/// Concatenates the output of `work` for the items, in their order.
fn gather<T: Sync, R: Send + Clone>(items: &[T], work: impl Fn(&T, &mut Vec<R>) + Sync) -> Vec<R> {
    let parts: Vec<Vec<R>> = items
        .par_chunks(parallel::CHUNK)
        .map(|chunk| {
            let mut out = Vec::new();
            chunk.iter().for_each(|item| work(item, &mut out));
            out
        })
        .collect();
    parts.concat()
}

/// The point of the zero set at `t[..3]` in the triangle; `None` for a degenerate triangle without
/// a normal.
fn surface_point(
    space: &Space<3>,
    phi: &[f64],
    triangle: &Triangle,
    t: &[f64; 4],
    w: f64,
) -> Option<SurfacePoint<3>> {
    let cell = triangle.cell as usize;
    let vector = triangle.area_vector(t);
    let normal = vector.try_normalize(0.0)?;
    let (mut x, mut l) = (triangle.point(t), triangle.barycentric_at(t));
    let across: SVector<f64, 3> = normal * triangle.size();
    let s = Quadratic::on_line(space, phi, cell, &l, &across).roots()[0];
    // The triangle deviates by a small fraction of its size; a root farther away is another branch.
    if s.abs() < 0.1 {
        let dl = barycentric_direction(space, cell, &across);
        x += across * s;
        l = std::array::from_fn(|k| l[k] + s * dl[k]);
    }
    let at = At { cell, q: 0, barycentric: l, x, weight: w * vector.norm() };
    Some(SurfacePoint { at, normal })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::levelset::surface as surface_points;
    use crate::mesh::{Mesh, Point, box_mesh};
    use proptest::prelude::*;
    use std::collections::HashMap;
    use std::sync::Arc;

    type Checked = std::result::Result<(), TestCaseError>;

    fn p(x: f64, y: f64, z: f64) -> Point<3> {
        Point::<3>::new(x, y, z)
    }
    fn space(n: usize) -> Space<3> {
        Space::new(&Arc::new(box_mesh([0.0; 3], [2.0; 3], [n, n, n]).unwrap()), Element::P2)
    }
    fn surface(n: usize, f: impl Fn(&Point<3>) -> f64) -> (Space<3>, Vec<f64>, Isosurface) {
        let space = space(n);
        let phi = space.interpolate(f);
        let surface = Isosurface::new(&space, &phi).unwrap();
        (space, phi, surface)
    }
    /// Area vector, and the volume from each component of the divergence theorem, of triangles and
    /// walls together.
    fn sums(s: &Isosurface) -> (Point<3>, Point<3>) {
        let rule = Rule::simplex(2, 4);
        let (mut area, mut volume) = (Point::<3>::zeros(), Point::<3>::zeros());
        for t in s.triangles().iter().chain(s.walls()) {
            for (l, w) in rule.points.iter().zip(&rule.weights) {
                let n = t.area_vector(l) * *w;
                area += n;
                volume += n.component_mul(&t.point(l));
            }
        }
        (area, volume)
    }
    fn check_closed(s: &Isosurface) -> Checked {
        let (area, volume) = sums(s);
        prop_assert!(area.norm() < 1e-12, "{area}");
        prop_assert!(volume.max() - volume.min() < 1e-12, "{volume}");
        Ok(())
    }
    /// Every curved side has its opposite, the same to the last bit.
    fn check_sides(s: &Isosurface) -> Checked {
        let bits = |x: &Point<3>| [x[0].to_bits(), x[1].to_bits(), x[2].to_bits()];
        let mut sides: HashMap<[[u64; 3]; 3], i32> = HashMap::new();
        for t in s.triangles().iter().chain(s.walls()) {
            for (a, b, m) in [(0, 1, 3), (1, 2, 4), (2, 0, 5)] {
                let [a, b, m] = [a, b, m].map(|k| bits(&t.points[k]));
                if a < b {
                    *sides.entry([a, m, b]).or_default() += 1;
                } else if b < a {
                    *sides.entry([b, m, a]).or_default() -= 1;
                }
            }
        }
        let open = sides.values().filter(|&&n| n != 0).count();
        prop_assert!(open == 0, "{} of {} sides are open", open, sides.len());
        Ok(())
    }
    /// The points lie on the zero set, where their barycentric coordinates say, and `phi` grows
    /// along the normals.
    fn check_points(space: &Space<3>, phi: &[f64], s: &Isosurface) {
        for t in s.triangles() {
            let cell = t.cell as usize;
            for k in 0..6 {
                let l = &t.barycentric[k];
                let mut x = Point::<3>::zeros();
                for (a, &v) in space.mesh().cell(cell).iter().enumerate() {
                    x += space.mesh().points()[v as usize] * l[a];
                }
                assert!((x - t.points[k]).norm() < 1e-14);
                // The middles on faces are zeros of the function of one of the two cells.
                let tolerance = if k < 3 { 1e-13 } else { 1e-6 };
                assert!(
                    space.value(phi, cell, l).abs() < tolerance,
                    "node {k}: {}",
                    space.value(phi, cell, l)
                );
            }
            let third = [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0];
            assert!(
                space.gradient(phi, cell, &t.barycentric_at(&third)).dot(&t.area_vector(&third))
                    > -1e-14
            );
        }
        for (q, point) in s.quadrature(space, phi).iter().enumerate() {
            assert!(point.at.q == q && point.at.weight > 0.0);
            assert!(space.value(phi, point.at.cell, &point.at.barycentric).abs() < 1e-13);
        }
        assert!(s.quadrature(space, phi).is_sorted_by_key(|point| point.at.cell));
    }

    #[test]
    fn two_balls_are_closed_and_lie_on_the_zero_set() {
        let ball = |x: &Point<3>, c: Point<3>, r: f64| (x - c).norm_squared() - r * r;
        let two =
            |x: &Point<3>| ball(x, p(0.52, 0.5, 0.6), 0.3).min(ball(x, p(1.4, 1.3, 1.2), 0.47));
        // Fine enough that no cell with the surface, and none beside it, meets the kink between the
        // balls.
        let (space, phi, s) = surface(16, two);
        assert!(s.walls().is_empty());
        check_points(&space, &phi, &s);
        check_sides(&s).unwrap();
        check_closed(&s).unwrap();
        let exact = 4.0 / 3.0 * std::f64::consts::PI * (0.3f64.powi(3) + 0.47f64.powi(3));
        assert!((s.measures().unwrap().volume / exact - 1.0).abs() < 1e-4);
    }

    #[test]
    fn planes_through_nodes_are_exact() {
        for (f, area, volume) in [
            ((|x| x[1] - 0.71) as fn(&Point<3>) -> f64, 4.0, 2.84),
            (|x| x[1] - 1.0, 4.0, 4.0),
            (|x| 0.5 - x[2], 4.0, 6.0),
            (|x| x[1] - x[0], 4.0 * 2f64.sqrt(), 4.0),
            (|x| x[0] + x[1] + x[2] - 3.0, 3.0 * 3f64.sqrt(), 4.0),
        ] {
            for n in [4, 5] {
                let (space, phi, s) = surface(n, f);
                check_points(&space, &phi, &s);
                check_closed(&s).unwrap();
                let m = s.measures().unwrap();
                assert!(
                    (m.surface - area).abs() < 1e-12 && (m.volume - volume).abs() < 1e-12,
                    "{m:?}"
                );
                assert!((s.integrate(&space, &phi, |_| 1.0) - area).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_cube_through_nodes_and_functions_that_touch_zero_do_no_harm() {
        let (_, _, s) = surface(8, |x| (x - p(1.0, 1.0, 1.0)).abs().max() - 0.5);
        check_closed(&s).unwrap();
        assert!((s.measures().unwrap().volume - 1.0).abs() < 0.02);
        assert!(surface(4, |x| (x[0] - 1.0).abs()).2.is_empty());
        assert!(surface(4, |_| 0.0).2.is_empty());
        let touching = surface(4, |x| -(x[0] - 1.0).abs()).2;
        assert!(
            touching
                .triangles()
                .iter()
                .all(|t| t.points.iter().all(|p| (p[0] - 1.0).abs() < 1e-14))
        );
        check_closed(&touching).unwrap();
    }

    #[test]
    fn points_for_weak_forms_are_sorted_and_their_normals_add_up_to_nothing() {
        let (space, phi, s) = surface(8, |x| (x - p(1.03, 0.98, 1.01)).norm() - 0.6);
        let points = surface_points(&space, &phi).unwrap();
        assert!(points.iter().enumerate().all(|(q, p)| p.at.q == q));
        assert!(points.is_sorted_by_key(|p| p.at.cell));
        let sum: Point<3> = points.iter().map(|p| p.normal * p.at.weight).sum();
        assert!(sum.norm() < 1e-13);
        let area: f64 = points.iter().map(|p| p.at.weight).sum();
        assert!((area / s.area() - 1.0).abs() < 1e-4);
    }

    #[test]
    fn what_cannot_be_cut_is_an_error() {
        let s = space(2);
        let mut phi = vec![1.0; s.len()];
        phi[7] = f64::NAN;
        assert!(Isosurface::new(&s, &phi).unwrap_err().to_string().contains("node 7"));
        assert!(Isosurface::new(&s, &phi[1..]).is_err());
        let none = Isosurface::new(&s, &vec![-1.0; s.len()]).unwrap();
        assert!(none.is_empty() && none.bounds().is_none());
        assert!(none.measures().unwrap_err().to_string().contains("no interface"));
    }

    #[test]
    fn the_surface_does_not_depend_on_the_number_of_threads() {
        let s = space(8);
        let phi = s.interpolate(|x| (7.0 * x[0]).sin() * (5.0 * x[1]).cos() + x[2] - 0.8);
        let run = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| (Isosurface::new(&s, &phi).unwrap(), surface_points(&s, &phi).unwrap()))
        };
        let (one, two) = (run(1), run(2));
        assert!(one.0.triangles() == two.0.triangles() && one.1 == two.1);
        assert_eq!(one.0.measures().unwrap(), two.0.measures().unwrap());
    }

    /// A box whose inner points are moved and whose cells are stored in a mixed order of their
    /// vertices.
    fn crooked(n: usize) -> Mesh<3> {
        let regular = box_mesh([0.0; 3], [2.0; 3], [n, n, n]).unwrap();
        let inside = |x: &Point<3>| x.iter().all(|&c| c > 0.0 && c < 2.0);
        let moved = |x: &Point<3>| {
            x + p((9.0 * x[1]).sin(), (8.0 * x[2]).cos(), (7.0 * x[0]).sin()) * (0.25 / n as f64)
        };
        let points: Vec<_> =
            regular.points().iter().map(|x| if inside(x) { moved(x) } else { *x }).collect();
        let mixed = |c: usize| {
            let v = regular.cell(c);
            [v[c % 4], v[(c + 1) % 4], v[(c + 2) % 4], v[(c + 3) % 4]]
        };
        Mesh::new(points, (0..regular.cell_count()).flat_map(mixed).collect()).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn any_smooth_field_gives_a_closed_surface(a in 1.0..5.0f64, b in 1.0..5.0f64, c in -0.5..0.5f64, shift in 0.0..6.0f64) {
            let f = |x: &Point<3>| (a * x[0] + shift).sin() * (b * x[1]).cos() + 0.4 * (x[2] * a - shift).cos() - c;
            let space = Space::new(&Arc::new(crooked(6)), Element::P2);
            let phi = space.interpolate(f);
            let s = Isosurface::new(&space, &phi).unwrap();
            check_sides(&s)?;
            check_closed(&s)?;
        }

        #[test]
        fn any_node_values_give_a_closed_surface(values in prop::collection::vec(-2..3i32, 97)) {
            // Small integers: many exact zeros, crossings at nodes, saddles.
            let s = space(2);
            let phi: Vec<f64> = (0..s.len()).map(|i| f64::from(values[i % values.len()])).collect();
            check_closed(&Isosurface::new(&s, &phi).unwrap())?;
        }
    }
}
