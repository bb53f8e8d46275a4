//! The vortex of the book's section 1.5.3, against exact markers: where nodal transport fails, and what removes the failure.

use crate::tools::point;
use immersa::fem::{Basis, Element, Projector, Rule, Space, VelocityFunction};
use immersa::levelset::{Circle, Contour, Interface, Sample, Shape, signed_distance};
use immersa::mesh::{Diagonals, Location, Locator, Point, rectangle};
use immersa::transport::{CharacteristicMap, Feet, Tracer, Wind, carry_nodal, carry_projected};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::PI;
use std::sync::Arc;

const CENTRE: [f64; 2] = [0.5, 0.75];
const RADIUS: f64 = 0.15;

/// The velocity of the book, and its gradient (row `i`, column `j` is `d u_i / d x_j`).
fn vortex(x: &Point<2>) -> (Vector2<f64>, Matrix2<f64>) {
    let ((a, b), (c, d)) = ((PI * x[0]).sin_cos(), (PI * x[1]).sin_cos());
    let (s2x, s2y, c2x, c2y) = (2.0 * a * b, 2.0 * c * d, 2.0 * b * b - 1.0, 2.0 * d * d - 1.0);
    let u = Vector2::new(-a * a * s2y, s2x * c * c);
    let mixed = PI * s2x * s2y;
    (u, Matrix2::new(-mixed, -2.0 * PI * a * a * c2y, 2.0 * PI * c2x * c * c, mixed))
}

/// How the velocity changes in time.
#[derive(Clone, Copy)]
enum Course {
    /// Not at all, to t = 5.
    Steady,
    /// As `cos(pi t / 8)`, to t = 8, when everything is back.
    Reversed,
}

impl Course {
    fn end(self) -> f64 {
        match self {
            Course::Steady => 5.0,
            Course::Reversed => 8.0,
        }
    }
    fn factor(self, t: f64) -> f64 {
        match self {
            Course::Steady => 1.0,
            Course::Reversed => (PI * t / 8.0).cos(),
        }
    }
    fn velocity(self) -> VelocityFunction<2> {
        Arc::new(move |x, t| vortex(x).0 * self.factor(t))
    }
    /// Points of the interface at the end, and the stretch there, by the classical Runge-Kutta rule.
    fn markers(self, count: usize) -> Vec<(Point<2>, f64)> {
        let rate = |x: &Point<2>, v: &Vector2<f64>, t: f64| {
            let (u, gradient) = vortex(x);
            (u * self.factor(t), gradient * v * self.factor(t))
        };
        let steps = 2000;
        let dt = self.end() / f64::from(steps);
        let follow = |k: usize| {
            let (s, c) = (2.0 * PI * k as f64 / count as f64).sin_cos();
            let (mut x, mut v) = (point(CENTRE[0] + RADIUS * c, CENTRE[1] + RADIUS * s), Vector2::new(-s, c));
            for k in 0..steps {
                let t = f64::from(k) * dt;
                let a = rate(&x, &v, t);
                let b = rate(&(x + a.0 * (0.5 * dt)), &(v + a.1 * (0.5 * dt)), t + 0.5 * dt);
                let c = rate(&(x + b.0 * (0.5 * dt)), &(v + b.1 * (0.5 * dt)), t + 0.5 * dt);
                let d = rate(&(x + c.0 * dt), &(v + c.1 * dt), t + dt);
                x += (a.0 + b.0 * 2.0 + c.0 * 2.0 + d.0) * (dt / 6.0);
                v += (a.1 + b.1 * 2.0 + c.1 * 2.0 + d.1) * (dt / 6.0);
            }
            (x, v.norm())
        };
        (0..count).map(follow).collect()
    }
}

/// Errors at the end: of the area, relative; mean distance of exact markers from the interface; mean relative error of
/// the slope, which is the stretch, at the markers. Means by arc length.
#[derive(Clone, Copy, Debug)]
struct Errors {
    area: f64,
    distance: f64,
    slope: f64,
}

impl Errors {
    fn of(area: f64, course: Course, at: impl Fn(&Point<2>) -> (f64, Vector2<f64>)) -> Errors {
        let (mut length, mut distance, mut slope) = (0.0, 0.0, 0.0);
        for (x, stretch) in course.markers(2000) {
            let (value, gradient) = at(&x);
            length += stretch;
            distance += value.abs();
            slope += (gradient.norm() - stretch).abs();
        }
        Errors { area: area / (PI * RADIUS * RADIUS) - 1.0, distance: distance / length, slope: slope / length }
    }
    fn print(&self, what: &str) {
        println!("{what}: area {:+.3} %, distance {:.2e}, slope {:.3}", 100.0 * self.area, self.distance, self.slope);
    }
}

struct Case {
    space: Arc<Space<2>>,
    tracer: Tracer<2>,
    course: Course,
    n: usize,
    steps: usize,
}

impl Case {
    /// The unit square in `n x n` squares, steps of about `courant` edges of a square.
    fn new(course: Course, n: usize, courant: f64, diagonals: Diagonals) -> Case {
        let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [n; 2], diagonals).unwrap());
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let steps = (course.end() * n as f64 / courant).ceil() as usize;
        Case { tracer: Tracer::new(&space, &[]), space, course, n, steps }
    }
    fn dt(&self) -> f64 {
        self.course.end() / self.steps as f64
    }
    fn disc(&self) -> Circle<2> {
        Circle::new(CENTRE.into(), RADIUS).unwrap()
    }
    fn winds<'a>(&self, velocity: &'a VelocityFunction<2>) -> impl Iterator<Item = Wind<'a, 2>> {
        let dt = self.dt();
        let courant = self.n as f64 * dt;
        (1..=self.steps).map(move |k| Wind::Given { velocity, arrival: k as f64 * dt, courant })
    }
    fn errors(&self, phi: &[f64]) -> Errors {
        let contour = Contour::new(&self.space, phi).unwrap();
        let area = contour.measures().map_or(0.0, |m| m.area);
        let locator = Locator::new(self.space.mesh());
        Errors::of(area, self.course, |x| {
            let at = locator.locate(self.space.mesh(), x).unwrap();
            let (cell, l) = (at.cell as usize, &at.barycentric);
            (self.space.value(phi, cell, l), self.space.gradient(phi, cell, l))
        })
    }
    fn nodal(&self) -> Errors {
        let (mut phi, mut feet) = (signed_distance(&self.space, &self.disc()), Feet::default());
        let mut moved = phi.clone();
        let velocity = self.course.velocity();
        for wind in self.winds(&velocity) {
            self.tracer.feet_of_nodes(&wind, self.dt(), &mut feet);
            carry_nodal(&self.space, &phi, &feet, &mut moved);
            std::mem::swap(&mut phi, &mut moved);
        }
        self.errors(&phi)
    }
    fn projected(&self) -> Errors {
        let (mut phi, mut feet) = (signed_distance(&self.space, &self.disc()), Feet::default());
        let mut projector = Projector::new(Basis::new(&self.space, &Arc::new(Rule::simplex(2, 6))), &[]).unwrap();
        let mut moved = phi.clone();
        let velocity = self.course.velocity();
        for wind in self.winds(&velocity) {
            self.tracer.feet_of_quadrature(&wind, self.dt(), projector.basis(), &mut feet);
            carry_projected(&mut projector, &phi, &feet, &mut moved).unwrap();
            std::mem::swap(&mut phi, &mut moved);
        }
        self.errors(&phi)
    }
    /// With the exact velocity; a new submap at every multiple of `tau`.
    fn composed(&self, tau: f64) -> Composed<'_> {
        let velocity = self.course.velocity();
        let winds: Vec<_> = self.winds(&velocity).collect();
        self.chain(tau, |k, feet| self.tracer.feet_of_nodes(&winds[k], self.dt(), feet))
    }
    /// With given feet.
    fn chain(&self, tau: f64, feet_of: impl Fn(usize, &mut Feet)) -> Composed<'_> {
        let (mut map, mut feet) = (CharacteristicMap::identity(self.space.len()), Feet::default());
        let every = ((tau / self.dt()).round() as usize).max(1);
        for k in 0..self.steps {
            feet_of(k, &mut feet);
            map.advance(&self.tracer, &feet);
            if (k + 1) % every == 0 {
                map.restart_beyond(&self.space, 0.0);
            }
        }
        Composed { case: self, map }
    }
    /// A new submap where the last one has become steeper than `remap`.
    fn composed_by_steepness(&self, remap: f64) -> Composed<'_> {
        let (mut map, mut feet) = (CharacteristicMap::identity(self.space.len()), Feet::default());
        let velocity = self.course.velocity();
        for wind in self.winds(&velocity) {
            self.tracer.feet_of_nodes(&wind, self.dt(), &mut feet);
            map.advance(&self.tracer, &feet);
            map.restart_beyond(&self.space, remap);
        }
        Composed { case: self, map }
    }
}

struct Composed<'a> {
    case: &'a Case,
    map: CharacteristicMap<2>,
}

impl Composed<'_> {
    fn at(&self, at: &Location) -> (f64, Vector2<f64>) {
        let (foot, gradient) = self.map.foot_and_gradient(&self.case.tracer, *at);
        let y = self.case.space.mesh().point_at(&foot);
        (self.case.disc().distance(&y), gradient.transpose() * (y - point(CENTRE[0], CENTRE[1])).normalize())
    }
    fn interface(&self) -> Interface {
        let sample = |at: &Location| {
            let (foot, gradient) = self.map.foot_and_gradient(&self.case.tracer, *at);
            let y = self.case.space.mesh().point_at(&foot);
            Sample { value: self.case.disc().distance(&y), slope: gradient.norm() }
        };
        Interface::of_function(&self.case.space, RADIUS, sample).unwrap()
    }
    fn errors(&self) -> Errors {
        let area = self.interface().contour.measures().unwrap().area;
        let mesh = self.case.space.mesh();
        let locator = Locator::new(mesh);
        Errors::of(area, self.case.course, |x| self.at(&locator.locate(mesh, x).unwrap()))
    }
    fn determinant_error(&self) -> f64 {
        self.map.determinant_error(&self.case.tracer)
    }
}

#[test]
fn zz_measure() {
    use Course::*;
    for d in [Diagonals::Left, Diagonals::UnionJack] {
        for c in [Steady, Reversed] {
            for (n, cfl) in [(64, 0.5), (64, 4.0)] {
                let case = Case::new(c, n, cfl, d);
                case.nodal().print(&format!("{d:?} nodal {n} {cfl} steps {}", case.steps));
            }
            let case = Case::new(c, 64, 2.0, d);
            case.projected().print(&format!("{d:?} projected 64 2"));
            for tau in [0.125, 0.25, 0.5, 1.0] {
                let case = Case::new(c, 32, 2.0, d);
                let r = case.composed(tau);
                r.errors().print(&format!("{d:?} composed 32 2 tau {tau} maps {} det {:.2e}", r.map.submaps().len(), r.determinant_error()));
            }
            for remap in [0.25, 0.5, 1.0, 2.0] {
                for (n, cfl) in [(32, 2.0), (32, 0.5), (64, 2.0)] {
                    let case = Case::new(c, n, cfl, d);
                    let r = case.composed_by_steepness(remap);
                    r.errors().print(&format!("{d:?} composed {n} {cfl} remap {remap} maps {} det {:.2e}", r.map.submaps().len(), r.determinant_error()));
                }
            }
        }
    }
}
