//! Transport: exactness of the projection, solid rotation, and the reversed vortex (T = 8) by both
//! methods.

use crate::tools::point;
use immersa::fem::{Basis, Element, Projector, Rule, Space};
use immersa::levelset::{Circle, Contour, Shape, signed_distance};
use immersa::mesh::{Diagonals, Mesh, Point, rectangle};
use immersa::transport::{Feet, Method, Tracer, carry_nodal, carry_projected};
use std::f64::consts::PI;
use std::sync::Arc;

/// A velocity at a position and a time.
type Flow = fn(&Point<2>, f64) -> Point<2>;

/// A level set that is carried by a given flow.
struct Carried {
    space: Arc<Space<2>>,
    tracer: Tracer<2>,
    projector: Projector<2>,
    phi: Vec<f64>,
}

impl Carried {
    fn new(mesh: Mesh<2>, shape: &dyn Shape<2>) -> Carried {
        let mesh = Arc::new(mesh);
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let projector =
            Projector::new(Basis::new(&space, &Arc::new(Rule::simplex(2, 5))), &[]).unwrap();
        let phi = signed_distance(&space, shape);
        Carried { tracer: Tracer::new(&space, &[]), space, projector, phi }
    }
    /// Steps of length `dt` to `end`, with the velocity of the middle of each.
    fn carry(&mut self, flow: Flow, end: f64, dt: f64, method: Method) {
        let mut feet = Feet::default();
        let mut moved = vec![0.0; self.phi.len()];
        for k in 0..(end / dt).round() as usize {
            let u = self.space.interpolate(|x| flow(x, (k as f64 + 0.5) * dt));
            match method {
                Method::Nodal => {
                    self.tracer.from_nodes(&u, dt, &mut feet);
                    carry_nodal(&self.space, &self.phi, &feet, &mut moved);
                }
                Method::Projected => {
                    self.tracer.from_quadrature(&u, dt, self.projector.basis(), &mut feet);
                    carry_projected(&mut self.projector, &self.phi, &feet, &mut moved).unwrap();
                }
                Method::Composed => panic!("composed transport is measured in vortex.rs"),
            }
            std::mem::swap(&mut self.phi, &mut moved);
        }
    }
    /// Area inside over that of a disc of radius `r`, less 1; -1 when there is nothing left.
    fn area_error(&self, r: f64) -> f64 {
        let contour = Contour::new(&self.space, &self.phi).unwrap();
        contour.measures().map_or(-1.0, |m| m.area / (PI * r * r) - 1.0)
    }
    /// Area of the symmetric difference with the disc (integral of the difference of the
    /// indicators, degree 8).
    fn symmetric_difference(&self, shape: &dyn Shape<2>) -> f64 {
        let basis = Basis::new(&self.space, &Arc::new(Rule::simplex(2, 8)));
        let [sum] = immersa::fem::integrate(&basis, immersa::fem::Cells::All, |at| {
            [f64::from((basis.value(at, &self.phi) < 0.0) != (shape.distance(&at.x) < 0.0))]
        });
        sum
    }
    /// Prints and asserts the error of the area (in per cent, to a tenth of its size) and the
    /// symmetric difference.
    fn assert(&self, what: &str, shape: &dyn Shape<2>, r: f64, area: f64, moved: f64) {
        let (error, difference) = (100.0 * self.area_error(r), self.symmetric_difference(shape));
        println!("{what}: area {error:+.4} %, symmetric difference {difference:.2e}");
        assert!(
            (error - area).abs() <= 0.1 * area.abs(),
            "{what}: area {error} %, measured before {area} %"
        );
        assert!(
            difference <= 1.2 * moved,
            "{what}: symmetric difference {difference}, measured before {moved}"
        );
    }
}

/// The unit square in `n x n` squares.
fn square(n: usize) -> Mesh<2> {
    rectangle([0.0; 2], [1.0; 2], [n; 2], Diagonals::UnionJack).unwrap()
}

/// The disc that is carried, and its radius.
fn disc_of_fluid() -> (Circle<2>, f64) {
    (Circle::new(point(0.5, 0.75), 0.15).unwrap(), 0.15)
}

#[test]
fn a_function_of_the_space_is_its_own_projection() {
    let mut carried = Carried::new(square(9), &Circle::new(point(0.5, 0.5), 0.2).unwrap());
    let basis = carried.projector.basis().clone();
    let wild =
        carried.space.interpolate(|x| (17.0 * x[0]).sin() * (23.0 * x[1] * x[0]).cos() + 3.0);
    let mut back = vec![0.0; wild.len()];
    carried.projector.project(|at| basis.value(at, &wild), &mut back).unwrap();
    let worst = wild.iter().zip(&back).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("Projection of a P2 function: largest nodal error {worst:.1e}");
    assert!(worst < 1e-10);
}

/// Without motion nothing changes, whatever the method.
#[test]
fn a_field_at_rest_stays() {
    for method in [Method::Nodal, Method::Projected] {
        let mut carried = Carried::new(square(8), &Circle::new(point(0.5, 0.5), 0.2).unwrap());
        let before = carried.phi.clone();
        carried.carry(|_, _| point(0.0, 0.0), 0.3, 0.1, method);
        let worst = before.iter().zip(&carried.phi).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-10, "{method:?}: {worst:e}");
    }
}

fn turn(x: &Point<2>, _: f64) -> Point<2> {
    point(0.5 - x[1], x[0] - 0.5)
}

/// Solid rotation within 0.42 of the middle; the fluid at the walls rests.
fn turn_of_the_middle(x: &Point<2>, t: f64) -> Point<2> {
    let s = (((x - point(0.5, 0.5)).norm() - 0.42) / 0.08).clamp(0.0, 1.0);
    turn(x, t) * (1.0 - s * s * (3.0 - 2.0 * s))
}

/// One turn of a disc about the middle, in 40 steps.
#[test]
fn solid_rotation() {
    let (shape, r) = disc_of_fluid();
    for (method, n, area, moved) in [
        (Method::Nodal, 32, 6.2365, 5.12e-3),
        (Method::Nodal, 64, -0.1968, 5.81e-4),
        (Method::Projected, 32, -0.3607, 2.09e-3),
        (Method::Projected, 64, -0.0515, 4.71e-4),
    ] {
        let mut carried = Carried::new(square(n), &shape);
        carried.carry(turn_of_the_middle, 2.0 * PI, 2.0 * PI / 40.0, method);
        carried.assert(&format!("Rotation, {method:?}, {n} squares"), &shape, r, area, moved);
    }
}

/// Where fluid enters, the feet of a whole strip lie on the wall. Nodal transport bears that; the
/// projection of such a field is larger than the field, and repeated it grows without bound. An
/// immersed structure needs walls or periodic sides with `projected`.
#[test]
fn projection_is_unstable_at_an_inflow() {
    let largest = |method| {
        let mut carried = Carried::new(square(16), &disc_of_fluid().0);
        carried.carry(turn, 2.0 * PI, 2.0 * PI / 40.0, method);
        carried.phi.iter().map(|v| v.abs()).fold(0.0, f64::max)
    };
    let (nodal, projected) = (largest(Method::Nodal), largest(Method::Projected));
    println!(
        "Rotation in a square, largest |phi| (0.76 at the start): nodal {nodal:.2}, projected \
         {projected:.1e}"
    );
    assert!(nodal < 0.8 && projected > 10.0);
}

/// LeVeque's vortex with the period 8: at t = 8 everything is back where it was.
fn vortex(x: &Point<2>, t: f64) -> Point<2> {
    let ((a, b), (c, d)) = ((PI * x[0]).sin_cos(), (PI * x[1]).sin_cos());
    point(-a * a * 2.0 * c * d, 2.0 * a * b * c * c) * (PI * t / 8.0).cos()
}

/// Rider and Kothe's volume-of-fluid method has symmetric differences of .0478 and .00696 on 32 and
/// 64 squares. Nodal transport suffers from every step that it takes: small steps are its worst
/// case.
#[test]
fn the_reversed_vortex() {
    let (shape, r) = disc_of_fluid();
    for (method, n, steps, area, moved) in [
        (Method::Nodal, 32, 500, -70.0346, 5.62e-2),
        (Method::Nodal, 32, 64, -25.4520, 2.75e-2),
        (Method::Nodal, 64, 128, -3.2339, 1.20e-2),
        (Method::Projected, 32, 64, 4.6965, 1.04e-2),
        (Method::Projected, 64, 128, 2.5037, 1.63e-3),
    ] {
        let mut carried = Carried::new(square(n), &shape);
        carried.carry(vortex, 8.0, 8.0 / steps as f64, method);
        carried.assert(
            &format!("Vortex, {method:?}, {n} squares, {steps} steps"),
            &shape,
            r,
            area,
            moved,
        );
    }
}
