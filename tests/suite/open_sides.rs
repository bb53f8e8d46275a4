//! Sides through which fluid passes under a given stress: exact flows in the plane and in space, the
//! energy balance of open channels.

use super::program::*;
use immersa::fem::{Condition, Conditions, vector_errors};
use immersa::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use immersa::scene::{ImmersedFlow, Problem, Scene};
use immersa::sim::{Fluid, Simulation, SimulationSettings};
use nalgebra::{Complex, SMatrix, SVector};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

type V = SVector<f64, 2>;

fn pressure<const D: usize>(
    p: impl Fn(&Point<D>, f64) -> f64 + Send + Sync + 'static,
) -> Condition<D> {
    Condition::Pressure(Arc::new(p))
}

fn settings<const D: usize>(
    dt: f64,
    [density, viscosity]: [f64; 2],
    conditions: Conditions<D>,
) -> SimulationSettings<D> {
    SimulationSettings::new(dt, Fluid { density, viscosity }, conditions)
}

fn steps<const D: usize>(sim: &mut Simulation<D>, count: usize) {
    for _ in 0..count {
        sim.step().unwrap();
    }
}

/// The largest error of the velocity at a node.
fn largest_error<const D: usize>(
    sim: &Simulation<D>,
    exact: impl Fn(&Point<D>) -> SVector<f64, D>,
) -> f64 {
    let nodes = sim.space().nodes().iter().zip(&sim.state().flow.u);
    nodes.map(|(x, u)| (u - exact(x)).norm()).fold(0.0, f64::max)
}

/// The mesh turned about the origin.
fn turned(mesh: &Mesh<2>, angle: f64) -> Mesh<2> {
    let (s, c) = angle.sin_cos();
    let turn = |p: &Point<2>| V::new(c * p[0] - s * p[1], s * p[0] + c * p[1]);
    let cells = (0..mesh.cell_count()).flat_map(|k| mesh.cell(k).to_vec()).collect();
    let mut turned = Mesh::new(mesh.points().iter().map(turn).collect(), cells).unwrap();
    for (name, facets) in mesh.boundaries() {
        turned.set_boundary(name.clone(), facets.clone());
    }
    turned
}

/// Poiseuille flow between a given velocity or pressure and an open side of the form of the
/// gradient, along the axes and across them, with and without inertia.
#[test]
fn the_form_of_the_gradient_lets_poiseuille_flow_pass() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [6, 4], Diagonals::UnionJack).unwrap();
    for angle in [0.0, 0.4] {
        let (s, c) = f64::sin_cos(angle);
        let exact = move |x: &Point<2>| {
            let y = c * x[1] - s * x[0];
            V::new(c, s) * (4.0 * y * (1.0 - y))
        };
        let mesh = Arc::new(turned(&mesh, angle));
        let walls = || ["bottom", "top"].map(|w| (w.to_string(), Condition::NoSlip)).to_vec();
        // The pressure falls by 8 mu over a unit.
        let mu = 0.3;
        let inlets: [Condition<2>; 2] =
            [Condition::Velocity(Arc::new(move |x, _| exact(x))), pressure(move |_, _| 16.0 * mu)];
        for inlet in inlets {
            for outlet in [Condition::Gradient, pressure(|_, _| 0.0)] {
                for density in [0.0, 1.0] {
                    let mut conditions = walls();
                    conditions.push(("left".into(), inlet.clone()));
                    conditions.push(("right".into(), outlet.clone()));
                    let settings = settings(0.1, [density, mu], conditions);
                    let mut sim = Simulation::new(&mesh, settings, vec![], exact).unwrap();
                    steps(&mut sim, 3);
                    let error = largest_error(&sim, exact);
                    assert!(error < 1e-10, "{angle} {density}: {error:e}");
                    let balance = &sim.state().balance;
                    let spurious = balance.spurious(&sim.state().energies);
                    assert!(spurious.abs() < 1e-10, "{angle} {density}: {spurious:e}");
                    assert!(balance.work > 0.1);
                }
            }
        }
    }
}

/// The form of the stress changes the flow at the side, as much on a finer mesh.
#[test]
fn the_form_of_the_stress_spreads_poiseuille_flow() {
    for n in [8, 16] {
        let mesh = rectangle([0.0; 2], [3.0, 1.0], [3 * n, n], Diagonals::UnionJack).unwrap();
        let exact = |x: &Point<2>| V::new(4.0 * x[1] * (1.0 - x[1]), 0.0);
        let mut conditions: Conditions<2> =
            ["bottom", "top"].map(|w| (w.to_string(), Condition::NoSlip)).to_vec();
        conditions.push(("left".into(), Condition::Velocity(Arc::new(move |x, _| exact(x)))));
        conditions.push(("right".into(), Condition::Open));
        let settings = settings(0.1, [0.0, 0.3], conditions);
        let mut sim = Simulation::new(&Arc::new(mesh), settings, vec![], exact).unwrap();
        sim.step().unwrap();
        let largest = sim.largest_speed();
        assert!((largest - 1.03).abs() < 0.01, "{n}: {largest}");
    }
}

/// Two walls in space, with walls that the fluid slips along between them.
#[test]
fn a_pressure_drop_drives_poiseuille_flow_in_space() {
    let mesh = Arc::new(box_mesh([0.0; 3], [1.0, 1.0, 1.0], [2, 3, 2]).unwrap());
    let mu = 0.7;
    let exact = |x: &Point<3>| SVector::<f64, 3>::new(4.0 * x[1] * (1.0 - x[1]), 0.0, 0.0);
    let conditions: Conditions<3> = vec![
        ("left".into(), pressure(move |_, _| 8.0 * mu)),
        ("right".into(), pressure(|_, _| 0.0)),
        ("front".into(), Condition::Slip),
        ("back".into(), Condition::Slip),
        ("bottom".into(), Condition::NoSlip),
        ("top".into(), Condition::NoSlip),
    ];
    for density in [0.0, 2.0] {
        let settings = settings(0.1, [density, mu], conditions.clone());
        let mut sim = Simulation::new(&mesh, settings, vec![], exact).unwrap();
        steps(&mut sim, 2);
        let error = largest_error(&sim, exact);
        assert!(error < 1e-10, "{density}: {error:e}");
    }
}

/// A column with an open top: the fluid stays at rest under a pressure that is linear.
#[test]
fn a_column_with_an_open_top_stays_at_rest() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0, 2.0], [3, 6], Diagonals::Right).unwrap());
    for top in [
        pressure(|_, _| 3.0),
        Condition::TotalPressure(Arc::new(|_, _| 3.0)),
        Condition::Traction(Arc::new(|_, _| V::new(0.0, -3.0))),
    ] {
        let conditions: Conditions<2> =
            vec![("walls".into(), Condition::NoSlip), ("top".into(), top)];
        let mut settings = settings(0.1, [2.0, 0.01], conditions);
        settings.gravity = V::new(0.0, -9.81);
        let mut sim = Simulation::new(&mesh, settings, vec![], |_| V::zeros()).unwrap();
        steps(&mut sim, 3);
        assert!(sim.largest_speed() < 1e-10, "{:e}", sim.largest_speed());
        for (p, x) in sim.state().flow.p.iter().zip(mesh.points()) {
            assert!((p - (3.0 + 2.0 * 9.81 * (2.0 - x[1]))).abs() < 1e-9, "{p} at {x}");
        }
    }
}

/// An extension `(x, -y)` under the tractions that hold it, exact in P2.
#[test]
fn tractions_hold_an_extension() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0, 1.0], [4, 4], Diagonals::Left).unwrap());
    let exact = |x: &Point<2>| V::new(x[0], -x[1]);
    let mu = 0.4;
    let traction = |t: V| Condition::Traction(Arc::new(move |_: &Point<2>, _| t));
    let conditions: Conditions<2> = vec![
        ("left".into(), Condition::Slip),
        ("bottom".into(), Condition::Slip),
        ("right".into(), traction(V::new(2.0 * mu, 0.0))),
        ("top".into(), traction(V::new(0.0, -2.0 * mu))),
    ];
    let settings = settings(0.1, [0.0, mu], conditions);
    let mut sim = Simulation::new(&mesh, settings, vec![], |_| V::zeros()).unwrap();
    sim.step().unwrap();
    assert!(largest_error(&sim, exact) < 1e-10);
    assert!(sim.state().flow.p.iter().all(|p| p.abs() < 1e-10));
    // What the tractions put in, viscosity takes.
    let e = sim.state().energies;
    assert!((e.power - e.dissipation).abs() < 1e-10 && (e.power - 4.0 * mu).abs() < 1e-10, "{e:?}");
}

/// Flow between planes at y = 0 and 1 under the pressure drop `cos(w t)` over a unit of length: the
/// velocity of Womersley.
fn womersley(y: f64, t: f64, [density, mu, w]: [f64; 3]) -> f64 {
    let i = Complex::new(0.0, 1.0);
    let lambda = (i * (w * density / mu)).sqrt();
    let shape = Complex::new(1.0, 0.0) - (lambda * (y - 0.5)).cosh() / (lambda * 0.5).cosh();
    (shape / (i * w * density) * (i * (w * t)).exp()).re
}

/// Errors of the velocity after a period, in L2.
fn womersley_error(dt: f64) -> f64 {
    let (density, mu, w) = (1.0, 0.1, 2.0 * PI);
    let exact = move |x: &Point<2>, t: f64| V::new(womersley(x[1], t, [density, mu, w]), 0.0);
    let mesh = Arc::new(rectangle([0.0; 2], [0.25, 1.0], [2, 32], Diagonals::UnionJack).unwrap());
    let conditions: Conditions<2> = vec![
        ("left".into(), pressure(move |_, t| 0.25 * (w * t).cos())),
        ("right".into(), pressure(|_, _| 0.0)),
        ("bottom".into(), Condition::NoSlip),
        ("top".into(), Condition::NoSlip),
    ];
    let settings = settings(dt, [density, mu], conditions);
    let mut sim = Simulation::new(&mesh, settings, vec![], |x| exact(x, 0.0)).unwrap();
    steps(&mut sim, (1.0 / dt).round() as usize);
    let t = sim.time();
    vector_errors(sim.space(), &sim.state().flow.u, |x| (exact(x, t), SMatrix::zeros())).l2
}

#[test]
fn pulsating_flow_between_planes_is_of_second_order_in_time() {
    let errors = [0.025, 0.0125, 0.00625].map(womersley_error);
    // The velocity is of the size 0.1.
    assert!(errors[2] < 2e-5, "{errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 1.75 && order < 2.2, "{order}: {errors:?}");
    }
}

/// A reservoir with the total pressure P feeds a channel of length L without friction, which was at
/// rest: `rho L du/dt = P - rho u^2 / 2`, so `u = U tanh(U t / 2 L)` with `U^2 = 2 P / rho`.
fn from_reservoir(dt: f64) -> f64 {
    let (density, head, length, end) = (2.0, 4.0, 1.5, 2.0);
    let mesh = Arc::new(rectangle([0.0; 2], [length, 1.0], [6, 4], Diagonals::UnionJack).unwrap());
    let conditions: Conditions<2> = vec![
        ("left".into(), Condition::TotalPressure(Arc::new(move |_, _| head))),
        ("right".into(), Condition::TotalPressure(Arc::new(|_, _| 0.0))),
        ("bottom".into(), Condition::Slip),
        ("top".into(), Condition::Slip),
    ];
    let settings = settings(dt, [density, 0.01], conditions);
    let mut sim = Simulation::new(&mesh, settings, vec![], |_| V::zeros()).unwrap();
    steps(&mut sim, (end / dt).round() as usize);
    let fastest = f64::sqrt(2.0 * head / density);
    let exact = fastest * (fastest * end / (2.0 * length)).tanh();
    largest_error(&sim, |_| V::new(exact, 0.0))
}

#[test]
fn a_reservoir_feeds_a_channel_with_its_total_pressure() {
    let errors = [0.1, 0.05, 0.025].map(from_reservoir);
    assert!(errors[2] < 2e-3, "{errors:?}");
    assert!(errors.windows(2).all(|e| e[0] / e[1] > 3.3), "{errors:?}");
}

const CHANNEL: &str = "[mesh]
rectangle = { min = [0, 0], max = [2, 1], cells = [16, 8] }
[fluid]
density = 1
viscosity = 0.02
[boundary.left]
velocity = [\"6*y*(1-y)\", 0]
[boundary.walls]
no_slip = true
[time]
end = 0.4
step = 0.02
[output]
fields = false
pictures = false
checkpoint = false
";

fn scene(text: &str) -> Scene {
    Scene::parse(text, Path::new(".")).unwrap()
}

/// Spurious energy over that in play at the end of a scene, and what the start has taken.
fn balance(text: &str) -> [f64; 2] {
    let scene = scene(text);
    let mut flow = ImmersedFlow::<2>::new(&scene).unwrap();
    for _ in 0..scene.time.steps() {
        flow.step().unwrap();
    }
    let (e, b) = flow.energies().unwrap();
    [b.residual(&e), b.share(b.start)]
}

/// A channel that is set in motion at once: half the work of the impulse is in no energy, and what
/// follows closes.
#[test]
fn the_energy_balance_of_an_open_channel_closes() {
    for outlet in ["open = true", "open = \"gradient\"", "pressure = 2", "traction = [0, 0]"] {
        let [rest, start] = balance(&format!("{CHANNEL}[boundary.right]\n{outlet}\n"));
        assert!(rest.abs() < 0.01, "{outlet}: {rest}");
        assert!(start < -0.5, "{outlet}: {start}");
    }
}

/// What is left is the dissipation of the scheme in time, which falls with the step.
#[test]
fn the_rest_of_the_balance_falls_with_the_step() {
    // Set in motion smoothly.
    let smooth = CHANNEL.replace("6*y*(1-y)", "6*y*(1-y)*(1-cos(pi*min(t/0.4,1)))/2");
    let rest = [0.04, 0.02, 0.01].map(|dt| {
        let text = smooth.replace("step = 0.02", &format!("step = {dt}"));
        balance(&format!("{text}[boundary.right]\nopen = true\n"))
    });
    let orders = rest.windows(2).map(|e| (e[0][0] / e[1][0]).log2());
    assert!(orders.clone().all(|order| order > 1.7), "{rest:?}");
    assert!(rest[2][0].abs() < 2e-3, "{rest:?}");
}

/// What is wrong with the sides of a scene is told.
#[test]
fn sides_that_cannot_be_are_refused() {
    for (sides, said) in [
        (
            "[boundary.right]\nopen = \"gradient\"\n[boundary.top]\nopen = true\n",
            &["boundary.right", "boundary.top", "different forms", "same form"][..],
        ),
        ("[boundary.right]\nopen = \"free\"\n", &["free", "\"gradient\""][..]),
        ("[boundary.right]\nopen = false\n", &["can only be true"][..]),
        ("[boundary.right]\npressure = \"1/t\"\n", &["boundary.right.pressure", "finite"][..]),
        ("[boundary.right]\npressure = [1, 2]\n", &["number or an expression"][..]),
        ("[boundary.right]\ntraction = 1\n", &["boundary.right.traction"][..]),
        (
            "[boundary.right]\ntraction = [0, \"1/(y-0.5)\"]\n",
            &["boundary.right.traction", "finite"][..],
        ),
    ] {
        let folder = folder_with(&format!("{CHANNEL}{sides}"));
        immersa(folder.path(), &["explain", "scene.toml"]).expect(2, said);
    }
}

/// A scene keeps its sides when it is written and read again.
#[test]
fn sides_are_written_as_they_are_read() {
    for side in [
        "open = true",
        "open = \"gradient\"",
        "pressure = \"2*y + t\"",
        "total_pressure = 3.5",
        "traction = [\"t\", 1]",
    ] {
        let read = scene(&format!("{CHANNEL}[boundary.right]\n{side}\n"));
        let again = Scene::parse(&read.to_toml(), Path::new(".")).unwrap();
        assert_eq!(read.boundaries, again.boundaries, "{side}");
    }
}

/// A force whose two values are apart is told with its name and what helps; one that is exact is
/// not, nor one of a fluid at rest.
#[test]
fn forces_that_disagree_are_told() {
    let output = "[output]\nfields = false\npictures = false\ncheckpoint = false\n";
    let cavity = format!(
        "[mesh]\nrectangle = {{ min = [0, 0], max = [1, 1], cells = [8, 8] }}\n[fluid]\n\
         density = 1\nviscosity = 0.1\n[boundary.walls]\nno_slip = true\n[boundary.top]\n\
         velocity = [1, 0]\n[time]\nend = 0.2\nstep = 0.05\n{output}\
         forces.lid = {{ boundary = \"top\" }}\n"
    );
    let folder = folder_with(&cavity);
    let ended = immersa(folder.path(), &["run", "scene.toml", "--out", "run"]);
    let words = ["the force `lid`", "% apart", "boundary `top` is too coarse", "finer"];
    ended.expect(0, &words);
    let summary = std::fs::read_to_string(folder.path().join("run/summary.json")).unwrap();
    assert!(summary.contains("the force `lid` by the residual"), "{summary}");
    let rest = cavity.replace("velocity = [1, 0]", "no_slip = true");
    let channel = format!(
        "{CHANNEL}forces.lid = {{ boundary = \"bottom\" }}\n[boundary.right]\npressure = 0\n\
         [fluid.initial]\n"
    );
    let channel = channel
        .replace("[fluid.initial]\n", "")
        .replace("viscosity = 0.02", "viscosity = 0.02\ninitial_velocity = [\"6*y*(1-y)\", 0]");
    for scene in [rest, channel] {
        let folder = folder_with(&scene);
        let ended = immersa(folder.path(), &["run", "scene.toml", "--out", "run"]);
        ended.expect(0, &[]);
        assert!(!ended.stderr.contains("the force"), "{}", ended.stderr);
    }
}
