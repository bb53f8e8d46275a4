//! Curves in space, the intersections of two level sets: length, tangent, curvature, torsion
//! (section 1.3 of the book).

use super::isosurface::Isosurface;
use super::patch::Triangle;
use super::sign::cut_cells;
use crate::base::Result;
use crate::fem::{At, Derivatives, Recovered, Recovery, Space};
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};

type V = SVector<f64, 3>;

/// Largest number of Newton steps onto the curve, and the tolerance of the step relative to the
/// size of a triangle.
const STEPS: usize = 8;
const REACHED: f64 = 1e-13;
/// Largest distance of a zero from its start, as a fraction of the size of a triangle; farther
/// zeros belong to another piece.
const FARTHEST: f64 = 0.5;

/// The Frenet frame at a point of a curve in space, with curvature and torsion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frenet {
    /// Unit tangent `t = grad phi1 x grad phi2/|grad phi1 x grad phi2|` (1.17).
    pub tangent: V,
    /// Unit normal `n`, towards the centre of curvature (1.19).
    pub normal: V,
    /// Binormal `b = t x n` (1.20).
    pub binormal: V,
    /// Curvature `|[grad t] t|` (1.21), not negative, 1/length.
    pub curvature: f64,
    /// Torsion `([grad n] t) . b` (1.21), positive for a right-handed helix in either direction,
    /// 1/length.
    pub torsion: f64,
}

impl Frenet {
    /// From the derivatives of two functions at a common zero; `None` if their gradients are
    /// parallel. Where the curve is straight, normal, binormal and torsion are not defined, and set
    /// to zero.
    ///
    /// The curve `c' = T(c)` follows the field `T = g x h` of the gradients, so that
    /// `c'' = [grad T] T` and `c''' = D^2 T(T, T) + [grad T] c''`; curvature and torsion are those
    /// of a curve with any parameter: `|c' x c''|/|c'|^3` and `det(c', c'', c''')/|c' x c''|^2`.
    /// These equal (1.21) without derivatives of a unit vector.
    pub fn new(phi1: &Derivatives<3>, phi2: &Derivatives<3>) -> Option<Frenet> {
        let (g, h) = (phi1.gradient, phi2.gradient);
        let first = g.cross(&h);
        let tangent = first.try_normalize(0.0)?;
        let (dg, dh) = (phi1.hessian * first, phi2.hessian * first);
        // grad T applied to a vector is the derivative of g x h along it.
        let along = |v: &V| (phi1.hessian * v).cross(&h) + g.cross(&(phi2.hessian * v));
        let second = along(&first);
        let bend =
            phi1.third_along(&first, &first).cross(&h) + g.cross(&phi2.third_along(&first, &first));
        let third = bend + dg.cross(&dh) * 2.0 + along(&second);
        let across = first.cross(&second);
        let curvature = across.norm() / first.norm().powi(3);
        let Some(binormal) = across.try_normalize(0.0) else {
            let zero = V::zeros();
            return Some(Frenet { tangent, normal: zero, binormal: zero, curvature, torsion: 0.0 });
        };
        let torsion = across.dot(&third) / across.norm_squared();
        Some(Frenet { tangent, normal: binormal.cross(&tangent), binormal, curvature, torsion })
    }
}

/// A point of a curve in space, with its part of the length and its geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Its location, and its weight, a length; `at.q` numbers the points.
    pub at: At<3>,
    /// The frame, by recovered derivatives.
    pub frenet: Frenet,
}

/// The intersection of the interfaces of two level sets, `phi1 = phi2 = 0`, as points with weights.
///
/// The triangles of the surface `phi1 = 0` ([`Isosurface`]) are cut by the zero line of `phi2`,
/// linear between the corners of their four quarters; the ends of these segments are moved onto the
/// zeros of both P2 functions by Newton steps in the plane of the two gradients. Each segment gives
/// the midpoint of its arc with the length of a parabola through three points, so that the length
/// has an error of order 4 in the mesh size for a smooth curve. Curvature and torsion come from
/// derivatives recovered at the vertices ([`Recovered`]): order 2, and 1 (2 on regular meshes).
///
/// Curves need not be closed: they may end on the walls. Points where the two surfaces are tangent
/// are omitted.
#[derive(Clone, Debug, Default)]
pub struct SpaceCurve {
    points: Vec<CurvePoint>,
}

impl SpaceCurve {
    /// The curve of two functions of the P2 `space`; `recovery` is that of its mesh.
    ///
    /// # Errors
    /// A space that is not P2, a value that is not finite.
    pub fn new(recovery: &Recovery<3>, space: &Space<3>, phi: [&[f64]; 2]) -> Result<SpaceCurve> {
        cut_cells(space, phi[1])?;
        let surface = Isosurface::new(space, phi[0])?;
        let changes = |t: &&Triangle| {
            space.cell_nodes(t.cell as usize).iter().any(|&n| phi[1][n as usize] < 0.0)
        };
        let mut arcs = Vec::new();
        for triangle in surface.triangles().iter().filter(changes) {
            arcs_in(space, phi, triangle, &mut arcs);
        }
        if arcs.is_empty() {
            return Ok(SpaceCurve::default());
        }
        let mut near = vec![false; space.mesh().points().len()];
        let cells = arcs.iter().map(|a: &At<3>| a.cell);
        cells.for_each(|c| space.mesh().cell(c).iter().for_each(|&v| near[v as usize] = true));
        let vertices: Vec<u32> = (0..near.len() as u32).filter(|&v| near[v as usize]).collect();
        let known = phi.map(|f| Recovered::new(recovery, space, f, &vertices));
        let geometry = |at: &At<3>| {
            let [a, b] = [0, 1].map(|k| known[k].in_cell(space.mesh(), at.cell, &at.barycentric));
            Frenet::new(&a, &b)
        };
        let found =
            arcs.into_iter().filter_map(|at| geometry(&at).map(|frenet| CurvePoint { at, frenet }));
        let mut points: Vec<CurvePoint> = found.collect();
        points.iter_mut().enumerate().for_each(|(q, p)| p.at.q = q);
        Ok(SpaceCurve { points })
    }
    /// Its points, in the order of the cells.
    pub fn points(&self) -> &[CurvePoint] {
        &self.points
    }
    /// True if the interfaces do not intersect.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
    /// Its length.
    pub fn length(&self) -> f64 {
        self.integrate(|_| 1.0)
    }
    /// The integral of `f` along it.
    pub fn integrate(&self, f: impl Fn(&CurvePoint) -> f64) -> f64 {
        self.points.iter().map(|p| p.at.weight * f(p)).sum()
    }
}

/// The four quarters of a curved triangle by its six points.
const QUARTERS: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];

/// A point of a cell and its barycentric coordinates.
type Placed = (Point<3>, [f64; 4]);

/// Appends the midpoints of the arcs on a triangle of the surface of `phi[0]`, with their lengths.
fn arcs_in(space: &Space<3>, phi: [&[f64]; 2], triangle: &Triangle, out: &mut Vec<At<3>>) {
    let cell = triangle.cell as usize;
    let value = triangle.barycentric.map(|l| space.value(phi[1], cell, &l));
    let reach = FARTHEST * triangle.size();
    for quarter in QUARTERS {
        let negative = quarter.map(|a| value[a] < 0.0);
        let count = negative.iter().filter(|&&n| n).count();
        let Some(alone) = (0..3).find(|&i| negative[i] == (count == 1)).filter(|_| count % 3 != 0)
        else {
            continue;
        };
        let corner = quarter[alone];
        let ends = [1, 2].map(|i| {
            let other = quarter[(alone + i) % 3];
            let t = value[corner] / (value[corner] - value[other]);
            let start = between(&placed(triangle, corner), &placed(triangle, other), t);
            onto_curve(space, phi, cell, start, reach)
        });
        let middle = onto_curve(space, phi, cell, between(&ends[0], &ends[1], 0.5), reach);
        let weight = arc(&ends[0].0, &middle.0, &ends[1].0);
        if weight > 0.0 {
            out.push(At { cell, q: 0, barycentric: middle.1, x: middle.0, weight });
        }
    }
}

fn placed(triangle: &Triangle, a: usize) -> Placed {
    (triangle.points[a], triangle.barycentric[a])
}

fn between(a: &Placed, b: &Placed, t: f64) -> Placed {
    (a.0 + (b.0 - a.0) * t, std::array::from_fn(|k| a.1[k] + (b.1[k] - a.1[k]) * t))
}

/// The common zero of both functions of the cell near a point, in the plane of their gradients; the
/// point itself if there is none within `reach`.
fn onto_curve(
    space: &Space<3>,
    phi: [&[f64]; 2],
    cell: usize,
    start: Placed,
    reach: f64,
) -> Placed {
    let own = phi.map(|f| space.on_cell(f, cell));
    let map = space.mesh().map(cell);
    let (mut x, mut l) = start;
    for _ in 0..STEPS {
        let gradients = space.element().reference_gradients::<3>(&l);
        let [g, h] = [0, 1].map(|k| map.inverse.tr_mul(&own[k].reference_gradient(&gradients)));
        let normal = SMatrix::<f64, 2, 2>::new(g.dot(&g), g.dot(&h), g.dot(&h), h.dot(&h));
        let values = SVector::<f64, 2>::new(own[0].value(&l), own[1].value(&l));
        let Some(c) = normal.try_inverse().map(|inverse| inverse * values) else { return start };
        let step = -(g * c[0] + h * c[1]);
        let moved = map.inverse * step;
        x += step;
        l[0] -= moved.sum();
        (0..3).for_each(|k| l[k + 1] += moved[k]);
        let moved = (x - start.0).norm();
        if moved > reach || moved.is_nan() {
            return start;
        }
        if step.norm() <= REACHED * reach {
            break;
        }
    }
    (x, l)
}

/// The length of the parabola through three points.
fn arc(a: &Point<3>, middle: &Point<3>, b: &Point<3>) -> f64 {
    let speed =
        |t: f64| (a * (4.0 * t - 3.0) + middle * (4.0 - 8.0 * t) + b * (4.0 * t - 1.0)).norm();
    crate::fem::gauss_legendre(4).iter().map(|&(t, w)| w * speed(t)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::box_mesh;
    use std::f64::consts::PI;
    use std::sync::Arc;

    /// The derivatives at `x` of `x - a cos(k z)` and `y - a sin(k z)`, whose common zero is a
    /// right-handed helix.
    fn helix(a: f64, k: f64, x: &V) -> [Derivatives<3>; 2] {
        let (s, c) = (k * x[2]).sin_cos();
        let of = |axis: usize, first: f64, second: f64, third: f64| {
            let mut d = Derivatives::<3>::zero();
            d.gradient[axis] = 1.0;
            (d.gradient[2], d.hessian[(2, 2)], d.third[2][(2, 2)]) = (first, second, third);
            d
        };
        [
            of(0, a * k * s, a * k * k * c, -a * k.powi(3) * s),
            of(1, -a * k * c, a * k * k * s, a * k.powi(3) * c),
        ]
    }

    #[test]
    fn a_helix_has_its_frame_and_the_order_of_the_functions_turns_the_tangent_alone() {
        let (a, k): (f64, f64) = (0.6, 1.7);
        let square = 1.0 + (a * k).powi(2);
        for z in [0.0f64, 0.4, 2.1] {
            let x = V::new(a * (k * z).cos(), a * (k * z).sin(), z);
            let [p, q] = helix(a, k, &x);
            let f = Frenet::new(&p, &q).unwrap();
            assert!(
                (f.curvature - a * k * k / square).abs() < 1e-13
                    && (f.torsion - k / square).abs() < 1e-13,
                "{f:?}"
            );
            // The normal points to the axis.
            assert!((f.normal + V::new(x[0], x[1], 0.0) / a).norm() < 1e-13);
            let tangent =
                V::new(-a * k * (k * z).sin(), a * k * (k * z).cos(), 1.0) / square.sqrt();
            assert!(
                (f.tangent - tangent).norm() < 1e-13
                    && (f.binormal - f.tangent.cross(&f.normal)).norm() < 1e-13
            );
            let back = Frenet::new(&q, &p).unwrap();
            assert!(
                (back.tangent + f.tangent).norm() < 1e-13
                    && (back.normal - f.normal).norm() < 1e-13
            );
            assert!((back.torsion - f.torsion).abs() < 1e-13);
        }
        assert!(Frenet::new(&Derivatives::zero(), &Derivatives::zero()).is_none());
    }

    #[test]
    fn circles_between_a_sphere_and_a_plane_are_found_and_straight_lines_too() {
        let mesh = Arc::new(box_mesh([-1.0; 3], [1.0; 3], [7, 6, 7]).unwrap());
        let (space, recovery) = (Space::new(&mesh, Element::P2), Recovery::new(&mesh));
        let (sphere, plane) = (
            space.interpolate(|x| x.norm_squared() - 0.64),
            space.interpolate(|x| x[2] - 0.3 * x[0] - 0.2),
        );
        let curve = SpaceCurve::new(&recovery, &space, [&sphere, &plane]).unwrap();
        let r = (0.64f64 - 0.04 / 1.09).sqrt();
        assert!(
            (curve.length() / (2.0 * PI * r) - 1.0).abs() < 1e-4,
            "{}",
            curve.length() / (2.0 * PI * r)
        );
        for (q, p) in curve.points().iter().enumerate() {
            assert!(p.at.q == q && (p.at.x.norm() - 0.8).abs() < 1e-12);
            assert!(
                (p.frenet.curvature * r - 1.0).abs() < 1e-8 && p.frenet.torsion.abs() < 1e-6,
                "{:?}",
                p.frenet
            );
        }
        let other = space.interpolate(|x| x[1] + 0.1);
        let line = SpaceCurve::new(&recovery, &space, [&other, &plane]).unwrap();
        assert!(
            (line.length() / (2.0 * 1.09f64.sqrt()) - 1.0).abs() < 1e-12
                && line.points()[0].frenet.curvature < 1e-9
        );
        let none = SpaceCurve::new(&recovery, &space, [&sphere, &vec![1.0; space.len()]]).unwrap();
        assert!(none.is_empty() && none.length() == 0.0);
        assert!(
            SpaceCurve::new(&recovery, &space, [&sphere, &vec![f64::NAN; space.len()]]).is_err()
        );
    }
}
