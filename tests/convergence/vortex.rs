//! The vortex of the book's section 1.5.3, against exact markers: where nodal transport fails, and
//! what removes the failure.

use crate::tools::point;
use immersa::fem::{Basis, Element, Projector, Rule, Space, VelocityFunction};
use immersa::levelset::{Circle, Contour, Interface, Sample, Shape, signed_distance};
use immersa::mesh::{Diagonals, Location, Locator, Point, rectangle};
use immersa::transport::{
    AdvectingVelocity, CharacteristicMap, Feet, Tracer, carry_nodal, carry_projected,
};
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
    /// Points of the interface at the end, and the stretch there, by the classical Runge-Kutta
    /// rule.
    fn markers(self, count: usize) -> Vec<(Point<2>, f64)> {
        let rate = |x: &Point<2>, v: &Vector2<f64>, t: f64| {
            let (u, gradient) = vortex(x);
            (u * self.factor(t), gradient * v * self.factor(t))
        };
        let steps = 2000;
        let dt = self.end() / f64::from(steps);
        let follow = |k: usize| {
            let (s, c) = (2.0 * PI * k as f64 / count as f64).sin_cos();
            let (mut x, mut v) =
                (point(CENTRE[0] + RADIUS * c, CENTRE[1] + RADIUS * s), Vector2::new(-s, c));
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

/// Errors at the end: of the area, relative, by samples of the sign and by the cut interface, which
/// does not see a part thinner than half an edge; mean distance of exact markers from the
/// interface; mean relative error of the slope, which is the stretch, at the markers. Means by arc
/// length.
#[derive(Clone, Copy, Debug)]
struct Errors {
    area: f64,
    cut: f64,
    distance: f64,
    slope: f64,
}

impl Errors {
    fn of(
        [area, cut]: [f64; 2],
        course: Course,
        at: impl Fn(&Point<2>) -> (f64, Vector2<f64>),
    ) -> Errors {
        let (mut length, mut distance, mut slope) = (0.0, 0.0, 0.0);
        for (x, stretch) in course.markers(2000) {
            let (value, gradient) = at(&x);
            length += stretch;
            distance += value.abs();
            slope += (gradient.norm() - stretch).abs();
        }
        let [area, cut] = [area, cut].map(|a| a / (PI * RADIUS * RADIUS) - 1.0);
        Errors { area, cut, distance: distance / length, slope: slope / length }
    }
    fn print(&self, what: &str) {
        let [area, cut] = [self.area, self.cut].map(|a| 100.0 * a);
        println!(
            "{what}: area {area:+.3} % (cut {cut:+.3} %), distance {:.2e}, slope {:.3}",
            self.distance, self.slope
        );
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
    fn winds<'a>(
        &self,
        velocity: &'a VelocityFunction<2>,
    ) -> impl Iterator<Item = AdvectingVelocity<'a, 2>> {
        let dt = self.dt();
        let courant = self.n as f64 * dt;
        (1..=self.steps).map(move |k| AdvectingVelocity::Given {
            velocity,
            arrival: k as f64 * dt,
            courant,
        })
    }
    fn errors(&self, phi: &[f64]) -> Errors {
        let contour = Contour::new(&self.space, phi).unwrap();
        let cut = contour.measures().map_or(0.0, |m| m.area);
        let locator = Locator::new(self.space.mesh());
        Errors::of([self.sampled(phi), cut], self.course, |x| {
            let at = locator.locate(self.space.mesh(), x).unwrap();
            let (cell, l) = (at.cell as usize, &at.barycentric);
            (self.space.value(phi, cell, l), self.space.gradient(phi, cell, l))
        })
    }
    /// Area where `phi < 0`, by 144 samples a cell.
    fn sampled(&self, phi: &[f64]) -> f64 {
        const K: usize = 12;
        let third = 1.0 / (3 * K) as f64;
        let corners = (0..K).flat_map(|i| (0..K - i).map(move |j| (i, j, 1)));
        let turned = (0..K - 1).flat_map(|i| (0..K - 1 - i).map(move |j| (i, j, 2)));
        let samples: Vec<[f64; 4]> = corners
            .chain(turned)
            .map(|(i, j, k)| {
                let [a, b] = [i, j].map(|v| (3 * v + k) as f64 * third);
                [1.0 - a - b, a, b, 0.0]
            })
            .collect();
        let inside =
            |c: usize| samples.iter().filter(|l| self.space.value(phi, c, l) < 0.0).count() as f64;
        let mesh = self.space.mesh();
        (0..mesh.cell_count()).map(|c| mesh.map(c).volume * inside(c) / samples.len() as f64).sum()
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
        let mut projector =
            Projector::new(Basis::new(&self.space, &Arc::new(Rule::simplex(2, 6))), &[]).unwrap();
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
        (
            self.case.disc().distance(&y),
            gradient.transpose() * (y - point(CENTRE[0], CENTRE[1])).normalize(),
        )
    }
    fn interface(&self) -> Interface<'_, 2> {
        let sample = |at: &Location| {
            let (foot, gradient) = self.map.foot_and_gradient(&self.case.tracer, *at);
            let y = self.case.space.mesh().point_at(&foot);
            Sample { value: self.case.disc().distance(&y), slope: gradient.norm() }
        };
        Interface::of_function(&self.case.space, RADIUS, sample).unwrap().unwrap()
    }
    fn errors(&self) -> Errors {
        let area = self.interface().contour().unwrap().measures().unwrap().area;
        let mesh = self.case.space.mesh();
        let locator = Locator::new(mesh);
        Errors::of([area; 2], self.case.course, |x| self.at(&locator.locate(mesh, x).unwrap()))
    }
    fn determinant_error(&self) -> f64 {
        self.map.determinant_error(&self.case.tracer)
    }
}

/// The predicted failure of nodal transport, and the two remedies. The prediction comes from a
/// program that shares nothing with this one (a lattice of squares in place of a mesh, area by
/// sampling): distances and slopes agree to its digits.
#[test]
fn nodal_transport_loses_the_filament_and_projection_or_composition_keeps_it() {
    let at = |n, courant| Case::new(Course::Steady, n, courant, Diagonals::Left);
    let small = at(64, 0.5).nodal();
    small.print("Vortex, t = 5, nodal, 64 squares, Courant number .5");
    assert!(small.area < -0.95 && near(small.distance, 5.79e-3) && near(small.slope, 0.755));
    let large = at(64, 4.0).nodal();
    large.print("Vortex, t = 5, nodal, 64 squares, Courant number 4");
    assert!(near(large.area, -0.212) && near(large.distance, 1.42e-3) && near(large.slope, 0.469));
    let projected = at(64, 2.0).projected();
    projected.print("Vortex, t = 5, projected, 64 squares, Courant number 2");
    assert!(projected.area > 2.0 * -0.0046 && projected.area < 0.5 * -0.0046);
    assert!(near(projected.distance, 9.10e-4) && near(projected.slope, 0.304));
    let case = at(32, 2.0);
    let composed = case.composed(0.125);
    let errors = composed.errors();
    errors.print("Vortex, t = 5, composed, 32 squares, Courant number 2, tau .125");
    println!(
        "    {} submaps, determinant {:.1e}",
        composed.map.submaps().len(),
        composed.determinant_error()
    );
    assert!(
        errors.area.abs() < 1e-3 && near(errors.distance, 2.18e-5) && near(errors.slope, 0.016)
    );
    // The estimate that costs no second run is near the error of the slope.
    let estimate = composed.determinant_error();
    assert!(estimate > 0.5 * errors.slope && estimate < 2.0 * errors.slope, "{estimate}");
    // On the mesh that all others fail on, the length is that of the markers to a few parts in a
    // thousand.
    let exact: f64 =
        Course::Steady.markers(2000).iter().map(|m| m.1).sum::<f64>() / 2000.0 * 2.0 * PI * RADIUS;
    let length = composed.interface().contour().unwrap().perimeter();
    println!("    length {length:.4}, exact {exact:.4}");
    assert!((length / exact - 1.0).abs() < 0.01);
}

#[test]
fn the_reversed_vortex_comes_back_when_maps_are_composed() {
    let at = |n, courant| Case::new(Course::Reversed, n, courant, Diagonals::Left);
    let nodal = at(64, 4.0).nodal();
    nodal.print("Vortex, T = 8 reversed, nodal, 64 squares, Courant number 4");
    assert!(near(nodal.area, -0.0295) && near(nodal.distance, 1.18e-2) && near(nodal.slope, 0.140));
    let projected = at(64, 2.0).projected();
    projected.print("Vortex, T = 8 reversed, projected, 64 squares, Courant number 2");
    assert!(
        near(projected.area, 0.02948)
            && near(projected.distance, 2.99e-3)
            && near(projected.slope, 0.085)
    );
    let case = at(32, 2.0);
    let composed = case.composed(0.125).errors();
    composed.print("Vortex, T = 8 reversed, composed, 32 squares, Courant number 2, tau .125");
    assert!(
        composed.area.abs() < 3e-4
            && near(composed.distance, 7.5e-5)
            && near(composed.slope, 0.024)
    );
}

/// Long submaps are as steep as a field that is carried without them; short ones stay near the
/// identity.
#[test]
fn composition_needs_its_restarts() {
    let case = Case::new(Course::Steady, 32, 2.0, Diagonals::Left);
    let slope = |tau: f64| {
        let errors = case.composed(tau).errors();
        errors.print(&format!("Vortex, t = 5, composed, 32 squares, tau {tau}"));
        errors.slope
    };
    let (rare, often) = (slope(1.0), slope(0.125));
    assert!(near(rare, 0.127) && near(often, 0.016));
    // The criterion by steepness finds the short ones by itself.
    let found = case.composed_by_steepness(immersa::sim::REMAP);
    let errors = found.errors();
    errors.print(&format!(
        "Vortex, t = 5, composed, 32 squares, by steepness, {} submaps",
        found.map.submaps().len()
    ));
    assert!(errors.slope <= often && errors.area.abs() < 1e-3);
}

/// Feet by one step of the midpoint rule through the P2 velocity at Courant number 2 cost 3 % of
/// the area; the library's steps of half the size, or the Runge-Kutta rule, do not.
#[test]
fn coarse_feet_spoil_the_area_and_finer_ones_do_not() {
    let case = Case::new(Course::Steady, 32, 2.0, Diagonals::Left);
    let (space, mesh) = (&case.space, case.space.mesh());
    let u = space.interpolate(|x| vortex(x).0);
    let locator = Locator::new(mesh);
    let within = |x: Point<2>| locator.locate(mesh, &x.map(|c| c.clamp(0.0, 1.0))).unwrap();
    let value = |at: &Location| space.value(&u, at.cell as usize, &at.barycentric);
    let midpoint = space.nodes().iter().map(|x| {
        let middle = within(x - value(&within(*x)) * (0.5 * case.dt()));
        within(x - value(&middle) * case.dt())
    });
    let coarse = Feet::new(midpoint.collect());
    let area = |what: &str, chain: Composed<'_>| {
        let errors = chain.errors();
        errors.print(&format!(
            "Vortex, t = 5, composed, 32 squares, Courant number 2, feet by {what}"
        ));
        errors.area
    };
    let tau = 4.0 * case.dt();
    let coarse =
        area("one midpoint step in P2", case.chain(tau, |_, feet| feet.clone_from(&coarse)));
    let halved = area(
        "midpoint steps below 1 in P2",
        case.chain(tau, |_, feet| case.tracer.from_nodes(&u, case.dt(), feet)),
    );
    let exact = area("Runge-Kutta in the exact velocity", case.composed(tau));
    assert!(near(coarse, 0.0298), "{coarse}");
    assert!(halved.abs() < 0.25 * coarse && exact.abs() < 1e-3);
}

/// Within a tenth.
fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() <= 0.1 * expected.abs()
}
