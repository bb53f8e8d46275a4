//! Transport in three dimensions: a ball that is turned about an axis, and LeVeque's deformation
//! flow, by all three methods.

use crate::tools::Study;
use immersa::fem::Element;
use immersa::fem::{Basis, Projector, Rule, Space, VelocityFunction};
use immersa::levelset::{Circle, Shape, signed_distance};
use immersa::mesh::{Location, Locator, Point, box_mesh};
use immersa::transport::{
    AdvectingVelocity, CharacteristicMap, Feet, Method, Tracer, carry_nodal, carry_projected,
};
use nalgebra::SVector;
use std::f64::consts::PI;
use std::sync::Arc;

/// A ball in a flow of the unit cube that brings it back at the end.
struct Case {
    space: Arc<Space<3>>,
    tracer: Tracer<3>,
    ball: Circle<3>,
    centre: Point<3>,
    radius: f64,
    velocity: VelocityFunction<3>,
    end: f64,
    steps: usize,
    courant: f64,
}

/// Volume over that of the ball at the start, less 1, and mean distance of points of the ball from
/// the interface.
#[derive(Clone, Copy, Debug)]
struct Errors {
    volume: f64,
    distance: f64,
}

impl Case {
    /// `n` blocks along a side; steps of about `courant` of their edges.
    fn new(
        n: usize,
        ball: ([f64; 3], f64),
        velocity: VelocityFunction<3>,
        end: f64,
        steps: usize,
    ) -> Case {
        let mesh = Arc::new(box_mesh([0.0; 3], [1.0; 3], [n; 3]).unwrap());
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let fastest = space.nodes().iter().map(|x| velocity(x, 0.0).norm()).fold(0.0, f64::max);
        let courant = fastest * end / steps as f64 * n as f64;
        let (centre, radius) = (Point::<3>::from(ball.0), ball.1);
        let ball = Circle::new(centre, radius).unwrap();
        Case {
            tracer: Tracer::new(&space, &[]),
            space,
            ball,
            centre,
            radius,
            velocity,
            end,
            steps,
            courant,
        }
    }
    /// The level set at the end.
    fn carried(&self, method: Method) -> Vec<f64> {
        let (mut phi, mut feet) = (signed_distance(&self.space, &self.ball), Feet::default());
        let mut moved = phi.clone();
        let mut projector = (method == Method::Projected).then(|| {
            Projector::new(Basis::new(&self.space, &Arc::new(Rule::simplex(3, 5))), &[]).unwrap()
        });
        let mut map = CharacteristicMap::identity(self.space.len());
        let dt = self.end / self.steps as f64;
        for k in 1..=self.steps {
            let wind = AdvectingVelocity::Given {
                velocity: &self.velocity,
                arrival: k as f64 * dt,
                courant: self.courant,
            };
            if let Some(projector) = &mut projector {
                self.tracer.feet_of_quadrature(&wind, dt, projector.basis(), &mut feet);
                carry_projected(projector, &phi, &feet, &mut moved).unwrap();
                std::mem::swap(&mut phi, &mut moved);
                continue;
            }
            self.tracer.feet_of_nodes(&wind, dt, &mut feet);
            if method == Method::Composed {
                map.advance(&self.tracer, &feet);
                map.restart_beyond(&self.space, 1.0);
                continue;
            }
            carry_nodal(&self.space, &phi, &feet, &mut moved);
            std::mem::swap(&mut phi, &mut moved);
        }
        if method == Method::Composed {
            let mesh = self.space.mesh();
            map.carry(
                &self.tracer,
                |at: &Location| self.ball.distance(&mesh.point_at(at)),
                &mut phi,
            );
        }
        phi
    }
    fn errors(&self, method: Method) -> Errors {
        let phi = self.carried(method);
        let before = volume(&self.space, &signed_distance(&self.space, &self.ball));
        let locator = Locator::new(self.space.mesh());
        let distance = |x: &Point<3>| {
            let at = locator.locate(self.space.mesh(), x).unwrap();
            self.space.value(&phi, at.cell as usize, &at.barycentric).abs()
        };
        // Fibonacci's points, evenly spread over the sphere.
        let count = 2000;
        let on_sphere = |k: usize| {
            let z = 1.0 - (2 * k + 1) as f64 / count as f64;
            let (s, c) = (PI * (1.0 + 5f64.sqrt()) * k as f64).sin_cos();
            self.centre
                + SVector::<f64, 3>::new(c, s, 0.0) * ((1.0 - z * z).sqrt() * self.radius)
                + SVector::<f64, 3>::new(0.0, 0.0, z * self.radius)
        };
        let distance = (0..count).map(|k| distance(&on_sphere(k))).sum::<f64>() / count as f64;
        Errors { volume: volume(&self.space, &phi) / before - 1.0, distance }
    }
}

/// Volume where `phi < 0`: cells that the interface may cross are cut into eight three times, and
/// `phi` is linear in the parts.
fn volume(space: &Space<3>, phi: &[f64]) -> f64 {
    let corners = [0, 1, 2, 3].map(|k| space.element().node(k, 3));
    let inside = |c: usize| fraction(&|l| space.value(phi, c, l), &corners, 3);
    (0..space.mesh().cell_count()).map(|c| space.mesh().map(c).volume * inside(c)).sum()
}

/// The part of a tetrahedron, given by the barycentric coordinates of its corners, where `f < 0`.
fn fraction(f: &dyn Fn(&[f64; 4]) -> f64, v: &[[f64; 4]; 4], depth: usize) -> f64 {
    let middle = |a: usize, b: usize| [0, 1, 2, 3].map(|i| 0.5 * (v[a][i] + v[b][i]));
    let [m01, m02, m03, m12, m13, m23] =
        [middle(0, 1), middle(0, 2), middle(0, 3), middle(1, 2), middle(1, 3), middle(2, 3)];
    let values = [v[0], v[1], v[2], v[3], m01, m02, m03, m12, m13, m23].map(|l| f(&l));
    let (low, high) =
        values.iter().fold((f64::INFINITY, -f64::INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
    // A P2 function stays within this of its values at the nodes.
    let margin = 0.5 * (high - low);
    if high + margin < 0.0 || low - margin > 0.0 {
        return f64::from(high < 0.0);
    }
    if depth == 0 {
        return linear_fraction([values[0], values[1], values[2], values[3]]);
    }
    let parts = [
        [v[0], m01, m02, m03],
        [m01, v[1], m12, m13],
        [m02, m12, v[2], m23],
        [m03, m13, m23, v[3]],
        [m02, m13, m01, m03],
        [m02, m13, m03, m23],
        [m02, m13, m23, m12],
        [m02, m13, m12, m01],
    ];
    parts.iter().map(|p| fraction(f, p, depth - 1)).sum::<f64>() / 8.0
}

/// The part of a tetrahedron where the linear function with these values at the corners is
/// negative.
fn linear_fraction(mut f: [f64; 4]) -> f64 {
    f.sort_by(f64::total_cmp);
    let [a, b, c, d] = f;
    // The corner cut off at `from`, whose value has another sign than the rest.
    let corner =
        |from: f64, rest: [f64; 3]| rest.iter().map(|r| from / (from - r)).product::<f64>();
    match f.iter().filter(|x| **x < 0.0).count() {
        0 => 0.0,
        1 => corner(a, [b, c, d]),
        2 => {
            // A wedge, cut into three tetrahedra by the edges that cross.
            let cross = |p: f64, q: f64| p / (p - q);
            let (ac, ad, bc, bd) = (cross(a, c), cross(a, d), cross(b, c), cross(b, d));
            ac * ad + bc * (ad * (1.0 - ac)) + bc * bd * (1.0 - ad)
        }
        3 => 1.0 - corner(d, [a, b, c]),
        _ => 1.0,
    }
}

#[test]
fn parts_of_a_tetrahedron_add_up() {
    for f in [[-1.0, 2.0, 3.0, 0.5], [-1.0, -2.0, 3.0, 0.5], [-1.0, -2.0, -0.1, 0.5]] {
        let n = 60;
        let mut inside = (0.0, 0.0);
        for (i, j, k) in (0..n)
            .flat_map(|i| (0..n - i).flat_map(move |j| (0..n - i - j).map(move |k| (i, j, k))))
        {
            let l = [i, j, k].map(|m| (f64::from(m) + 0.25) / f64::from(n));
            let value = (1.0 - l[0] - l[1] - l[2]) * f[0] + l[0] * f[1] + l[1] * f[2] + l[2] * f[3];
            inside = (inside.0 + f64::from(u8::from(value < 0.0)), inside.1 + 1.0);
        }
        let negated = linear_fraction(f.map(|x: f64| -x));
        assert!((linear_fraction(f) + negated - 1.0).abs() < 1e-14, "{f:?}");
        assert!(
            (linear_fraction(f) - inside.0 / inside.1).abs() < 0.02,
            "{f:?}: {} {:?}",
            linear_fraction(f),
            inside
        );
    }
}

/// A turn about the axis through the middle, fast in the middle and at rest at the walls: rigid
/// within .42 of the axis.
fn turn() -> VelocityFunction<3> {
    Arc::new(|x, _| {
        let (a, b) = (x[0] - 0.5, x[1] - 0.5);
        let s = ((a.hypot(b) - 0.42) / 0.08).clamp(0.0, 1.0);
        SVector::<f64, 3>::new(-b, a, 0.0) * (1.0 - s * s * (3.0 - 2.0 * s))
    })
}

/// LeVeque's flow (SIAM J. Numer. Anal. 33, 1996), which draws a ball out to a sheet and brings it
/// back at t = 3.
fn deformation() -> VelocityFunction<3> {
    Arc::new(|x, t| {
        let s = |k: usize| (PI * x[k]).sin().powi(2);
        let d = |k: usize| (2.0 * PI * x[k]).sin();
        SVector::<f64, 3>::new(2.0 * s(0) * d(1) * d(2), -d(0) * s(1) * d(2), -d(0) * d(1) * s(2))
            * (PI * t / 3.0).cos()
    })
}

/// Measures, prints and asserts: the volume (in per cent, to a tenth of its error) and the mean
/// distance, which is returned.
fn assert_errors(what: &str, case: &Case, method: Method, volume: f64, distance: f64) -> f64 {
    let errors = case.errors(method);
    let (v, d) = (100.0 * errors.volume, errors.distance);
    println!("{what}, {method:?}, {} steps: volume {v:+.3} %, distance {d:.2e}", case.steps);
    assert!(
        (v - volume).abs() <= 0.1 * volume.abs(),
        "{what}, {method:?}: volume {v} %, measured before {volume} %"
    );
    assert!(d <= 1.2 * distance, "{what}, {method:?}: distance {d}, measured before {distance}");
    d
}

/// One turn in 20 steps, the radius of the ball 1.6 to 3.2 blocks. The composed map alone is in its
/// asymptotic range.
#[test]
fn a_ball_that_is_turned_once() {
    let measure = |method, n: usize, volume, distance| {
        let case = Case::new(n, ([0.5, 0.7, 0.5], 0.2), turn(), 2.0 * PI, 20);
        assert_errors(&format!("Ball turned once, {n} blocks"), &case, method, volume, distance)
    };
    measure(Method::Nodal, 16, 4.913, 3.74e-3);
    measure(Method::Projected, 12, 6.535, 8.61e-3);
    let errors = [(8, -1.011, 6.09e-3), (12, 0.384, 1.16e-3), (16, 0.993, 7.55e-4)];
    let errors =
        errors.map(|(n, volume, distance)| measure(Method::Composed, n, volume, distance)).to_vec();
    let sizes = [1.0 / 8.0, 1.0 / 12.0, 1.0 / 16.0];
    Study { what: "Ball turned once, composed, distance", sizes: &sizes, errors }
        .assert(3.0, 1.2 * 7.55e-4);
}

/// The ball has a radius of 1.2 to 2.4 blocks, the sheet that it becomes a thickness of half a
/// block: nothing but the map can keep it.
#[test]
fn a_ball_that_is_drawn_out_to_a_sheet_and_back() {
    for (method, n, volume, distance) in [
        (Method::Nodal, 16, -35.565, 4.73e-2),
        (Method::Projected, 12, -40.950, 4.84e-2),
        (Method::Composed, 8, 1.756, 6.86e-3),
        (Method::Composed, 12, 1.242, 1.69e-3),
        (Method::Composed, 16, 0.373, 7.48e-4),
    ] {
        let case = Case::new(n, ([0.35; 3], 0.15), deformation(), 3.0, 2 * n);
        assert_errors(&format!("Ball drawn out, {n} blocks"), &case, method, volume, distance);
    }
}
