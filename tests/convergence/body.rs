//! A stiff elastic body by the backward map and the stress in divergence form: where that fails, and what helps.
//!
//! The library has no elasticity of bodies yet: the law is written here, against the public parts that a law uses.

use crate::tools::point;
use immersa::fem::{At, Cells, Condition, Conditions, Element, Rule, Space, VectorForm};
use immersa::flow::term::MomentumTerm;
use immersa::flow::{Coefficient, FlowSolver, History, Step};
use immersa::levelset::heaviside;
use immersa::mesh::{Diagonals, Location, Point, rectangle};
use immersa::transport::{CharacteristicMap, Feet, Tracer};
use nalgebra::{Matrix2, SMatrix, SVector};
use std::sync::Arc;

/// Incompressible neo-Hookean law: the stress `2 chi H (B - I)`, `B = grad Y^-1 grad Y^-T` scaled to determinant 1, in the body `H`;
/// implicit, `C(u, v) = dt int 2 chi H (grad u B) : grad v` is added to the matrix.
struct NeoHookean {
    chi: f64,
    dt: f64,
    points: usize,
    /// `2 chi H` and `B` at the quadrature points.
    state: Vec<(f64, Matrix2<f64>)>,
}

impl MomentumTerm<2> for NeoHookean {
    fn cells(&self) -> Cells<'_> {
        Cells::All
    }
    fn force(&self, at: &At<2>) -> VectorForm<2> {
        let (weight, b) = self.state[at.cell * self.points + at.q];
        (SVector::zeros(), (b - Matrix2::identity()) * -weight)
    }
    fn is_implicit(&self) -> bool {
        true
    }
    fn stiffness(&self, at: &At<2>, grad_u: &SMatrix<f64, 2, 2>) -> SMatrix<f64, 2, 2> {
        let (weight, b) = self.state[at.cell * self.points + at.q];
        grad_u * b * (weight * self.dt)
    }
}

/// A disc of radius .2 in a cavity of edge 1 whose lid moves with speed 1, viscosity .01, on `n x n` squares.
struct Cavity {
    n: usize,
    dt: f64,
    grad_div: f64,
    chi: f64,
    /// Steps of a submap.
    every: usize,
    order: usize,
}

/// How far it came, the largest speed on the way, and the elastic energy and rms(det grad Y - 1) in the body at the end.
#[derive(Debug)]
struct Outcome {
    time: f64,
    speed: f64,
    energy: f64,
    determinant: f64,
}

impl Cavity {
    fn run(&self, end: f64) -> Outcome {
        let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [self.n; 2], Diagonals::Left).unwrap());
        let velocity = Arc::new(Space::new(&mesh, Element::P2));
        let pressure = Arc::new(Space::new(&mesh, Element::P1));
        let rule = Arc::new(Rule::simplex(2, 6));
        let conditions: Conditions<2> = vec![
            ("walls".into(), Condition::NoSlip),
            ("top".into(), Condition::Velocity(Arc::new(|_, _| SVector::<f64, 2>::new(1.0, 0.0)))),
        ];
        let mut solver = FlowSolver::new(&velocity, &pressure, &rule, &conditions, self.grad_div).unwrap();
        solver.set_materials(Coefficient::Constant(1.0), Coefficient::Constant(0.01));
        let tracer = Tracer::new(&velocity, &[]);
        let mut map = CharacteristicMap::identity(velocity.len());
        let mut flow = solver.at_rest();
        solver.impose(0.0, &mut flow.u);
        let mut law = NeoHookean { chi: self.chi, dt: self.dt, points: rule.len(), state: Vec::new() };
        let mut feet = Feet::default();
        let mut speed: f64 = 0.0;
        let steps = (end / self.dt).round() as usize;
        for k in 0..steps {
            self.deform(&mut law, &map, &tracer, &solver);
            let old = flow.u.clone();
            tracer.from_quadrature(&old, self.dt, solver.velocity(), &mut feet);
            let history = [History { weight: 1.0, u: &old, feet: Some(&feet) }];
            let time = (k + 1) as f64 * self.dt;
            let step = Step { terms: &[&law], ..Step::backward_euler(time, self.dt, &history) };
            solver.step(&step, &mut flow).unwrap();
            speed = flow.u.iter().map(|u| u.norm()).fold(speed, f64::max);
            // Ten times the lid: what follows is of no interest.
            if !(speed < 10.0) || k + 1 == steps {
                let (energy, determinant) = self.deform(&mut law, &map, &tracer, &solver);
                return Outcome { time, speed, energy, determinant };
            }
            tracer.from_nodes(&flow.u, self.dt, &mut feet);
            map.advance(&tracer, &feet);
            if (k + 1) % self.every == 0 {
                map.restart_beyond(&velocity, 0.0);
            }
        }
        unreachable!("the last step returns")
    }

    /// Puts stress and stiffness of the map into the law; returns the elastic energy and rms(det grad Y - 1) in the body.
    fn deform(&self, law: &mut NeoHookean, map: &CharacteristicMap<2>, tracer: &Tracer<2>, solver: &FlowSolver<2>) -> (f64, f64) {
        let basis = solver.velocity();
        let mesh = basis.space().mesh();
        let (eps, centre) = (2.0 / self.n as f64, point(0.6, 0.5));
        let points = basis.rule().len();
        law.state.clear();
        let (mut energy, mut squares, mut area) = (0.0, 0.0, 0.0);
        for c in 0..mesh.cell_count() {
            for q in 0..points {
                let at = Location { cell: c as u32, barycentric: basis.rule().points[q] };
                let (foot, gradient) = map.foot_and_gradient(tracer, at);
                let y: Point<2> = mesh.point_at(&foot) - centre;
                // Distance to first order: the level set over its slope.
                let slope = (gradient.transpose() * y.normalize()).norm();
                // Smooth indicator of the inside.
                let h = 1.0 - heaviside((y.norm() - 0.2) / (slope * eps));
                let det = gradient.determinant();
                let inverse = gradient.try_inverse().unwrap_or(Matrix2::identity()) * det.abs().sqrt();
                let b = inverse * inverse.transpose();
                law.state.push((2.0 * self.chi * h, b));
                let weight = basis.at(c, q).weight;
                energy += weight * self.chi * h * (b.trace() - 2.0);
                if h > 0.5 {
                    squares += weight * (det - 1.0).powi(2);
                    area += weight;
                }
            }
        }
        (energy, (squares / area).sqrt())
    }
}

#[test]
fn zz_body() {
    for gd in [0.0, 1.0, 10.0] {
        for (dt, every) in [(0.05, 20), (0.01, 20), (0.002, 20)] {
            let end = if dt < 0.005 { 0.2 } else { 0.5 };
            let o = Cavity { n: 16, dt, grad_div: gd, chi: 50.0, every, order: 1 }.run(end);
            println!("BODY gd {gd} dt {dt} every {every}: {o:?}");
        }
    }
}
