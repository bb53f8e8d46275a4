//! Momentum terms and unknowns of a structure's own, against exact solutions of the Stokes
//! equations.

use immersa::fem::{At, Cells, Condition, Element, Rule, Space, VectorForm};
use immersa::flow::block::Block;
use immersa::flow::term::{MomentumTerm, Support};
use immersa::flow::{FlowSolver, FlowState, Step};
use immersa::levelset::surface;
use immersa::mesh::{Diagonals, Locator, Point, rectangle};
use nalgebra::{SMatrix, SVector};
use std::f64::consts::PI;
use std::sync::Arc;

type V = SVector<f64, 2>;
type M = SMatrix<f64, 2, 2>;

/// The square `[-1, 1]^2` with a velocity on all its sides, in a fluid of viscosity 1.
struct Square {
    velocity: Arc<Space<2>>,
    solver: FlowSolver<2>,
    state: FlowState<2>,
}

impl Square {
    fn new(n: usize, given: fn(&Point<2>) -> V) -> Square {
        let mesh = rectangle([-1.0; 2], [1.0; 2], [n; 2], Diagonals::UnionJack).unwrap();
        let mesh = Arc::new(mesh);
        let (velocity, pressure) = (Space::new(&mesh, Element::P2), Space::new(&mesh, Element::P1));
        let (velocity, pressure) = (Arc::new(velocity), Arc::new(pressure));
        let walls =
            vec![("walls".to_string(), Condition::Velocity(Arc::new(move |x, _| given(x))))];
        let rule = Arc::new(Rule::simplex(2, 5));
        let solver = FlowSolver::new(&velocity, &pressure, &rule, &walls, 1.0).unwrap();
        let state = solver.at_rest();
        Square { velocity, solver, state }
    }
    fn step<'a>(
        terms: &'a [&'a dyn MomentumTerm<2>],
        blocks: &'a [&'a dyn Block<2>],
    ) -> Step<'a, 2> {
        Step { weight: 0.0, terms, blocks, ..Step::backward_euler(1.0, 1.0, &[]) }
    }
    /// Solves the Stokes equations; the relative residual.
    fn solve(&mut self, terms: &[&dyn MomentumTerm<2>], blocks: &[&dyn Block<2>]) -> f64 {
        self.solver.step(&Square::step(terms, blocks), &mut self.state).unwrap().solve.residual
    }
    /// Force of the walls on the fluid, and its moment about the origin.
    fn walls(&self, terms: &[&dyn MomentumTerm<2>], blocks: &[&dyn Block<2>]) -> (V, f64) {
        let r = self.solver.reaction(&Square::step(terms, blocks), &self.state, Cells::All);
        let on_walls = |x: &Point<2>| x.amax() > 1.0 - 1e-12;
        let nodes = self.velocity.nodes().iter().zip(&r).filter(|(x, _)| on_walls(x));
        nodes.fold((V::zeros(), 0.0), |(f, m), (x, r)| (f + r, m + x[0] * r[1] - x[1] * r[0]))
    }
    fn at(&self, x: V) -> V {
        let place = Locator::new(self.velocity.mesh()).locate(self.velocity.mesh(), &x).unwrap();
        self.velocity.value(&self.state.u, place.cell as usize, &place.barycentric)
    }
    /// Quadrature points in the disc of radius `r` about the origin.
    fn disc(&self, r: f64) -> Vec<At<2>> {
        let basis = self.solver.velocity();
        let cells = 0..self.velocity.mesh().cell_count();
        let all = cells.flat_map(|c| (0..basis.rule().len()).map(move |q| basis.at(c, q)));
        all.filter(|at| at.x.norm() < r).collect()
    }
}

/// Holds a disc still by `C(u, v) = (k u, v)`.
struct Hold {
    radius: f64,
    strength: f64,
}

impl MomentumTerm<2> for Hold {
    fn support(&self) -> Support<'_, 2> {
        Support::Cells(Cells::All)
    }
    fn force(&self, _: &At<2>) -> VectorForm<2> {
        (V::zeros(), M::zeros())
    }
    fn is_implicit(&self) -> bool {
        true
    }
    fn stiffness(&self, at: &At<2>, u: &V, _: &M) -> VectorForm<2> {
        let k = if at.x.norm() < self.radius { self.strength } else { 0.0 };
        (u * k, M::zeros())
    }
}

/// Radius of the disc.
const A: f64 = 0.4;

/// Flow about a disc at rest that turns with the angular velocity 1 far away:
/// `u_theta = r - A^2/r`, and the moment on the disc is `4 pi A^2` in viscosity 1.
fn turning(x: &Point<2>) -> V {
    V::new(-x[1], x[0]) * (1.0 - A * A / x.norm_squared()).max(0.0)
}

#[test]
fn a_penalty_holds_a_disc_still_and_the_walls_bear_its_moment() {
    let exact = 4.0 * PI * A * A;
    let errors = [16, 32, 64].map(|n| {
        let (mut square, hold) = (Square::new(n, turning), Hold { radius: A, strength: 1e7 });
        assert!(square.solve(&[&hold], &[]) < 1e-12);
        let inside = square.disc(0.7 * A).iter().map(|p| square.at(p.x).norm()).fold(0.0, f64::max);
        assert!(inside < 1e-3, "the disc moves: {inside}");
        let held: f64 = square
            .disc(A)
            .iter()
            .map(|p| {
                let u =
                    square.velocity.value(&square.state.u, p.cell, &p.barycentric) * hold.strength;
                p.weight * (p.x[0] * u[1] - p.x[1] * u[0])
            })
            .sum();
        let (force, moment) = square.walls(&[&hold], &[]);
        assert!(
            force.norm() < 1e-8 && (moment / held - 1.0).abs() < 1e-8,
            "{force} {moment} {held}"
        );
        (moment / exact - 1.0).abs()
    });
    // A cell that the edge of the disc cuts is held as a whole: of first order.
    assert!(errors[2] < 0.05 && errors[2] < 0.3 * errors[0], "{errors:?}");
}

/// A force at one point.
struct PointForce([At<2>; 1], V);

impl MomentumTerm<2> for PointForce {
    fn support(&self) -> Support<'_, 2> {
        Support::Points(&self.0)
    }
    fn force(&self, _: &At<2>) -> VectorForm<2> {
        (self.1, M::zeros())
    }
}

const PLACE: [f64; 2] = [0.11, -0.07];
const FORCE: [f64; 2] = [1.0, 0.5];

/// The Stokeslet of the plane, `(-ln r I + x x / r^2) f / (4 pi)` in viscosity 1.
fn stokeslet(x: &Point<2>) -> V {
    let (d, f) = (x - V::from(PLACE), V::from(FORCE));
    let r = d.norm();
    (f * -r.ln() + d * (d.dot(&f) / (r * r))) / (4.0 * PI)
}

#[test]
fn a_force_at_a_point_makes_a_stokeslet_and_the_walls_bear_it() {
    let errors = [8, 16, 32].map(|n| {
        let mut square = Square::new(n, stokeslet);
        let (mesh, place) = (square.velocity.mesh(), V::from(PLACE));
        let found = Locator::new(mesh).locate(mesh, &place).unwrap();
        let (cell, barycentric) = (found.cell as usize, found.barycentric);
        let at = At { cell, q: 0, barycentric, x: place, weight: 1.0 };
        let term = PointForce([at], V::from(FORCE));
        square.solve(&[&term], &[]);
        let (force, _) = square.walls(&[&term], &[]);
        assert!((force + term.1).norm() < 1e-10, "the walls bear {force}");
        let angles = (0..12).map(|k| PI * f64::from(k) / 6.0);
        let ring = angles.map(|t| place + V::new(t.cos(), t.sin()) * 0.4);
        ring.map(|x| (square.at(x) - stokeslet(&x)).norm() / stokeslet(&x).norm())
            .fold(0.0, f64::max)
    });
    assert!(errors[2] < 2e-3 && errors[2] < 0.3 * errors[0], "{errors:?}");
}

/// Two multipliers that hold the mean velocity over points at zero.
struct MeanHeld(Vec<At<2>>);

impl Block<2> for MeanHeld {
    fn len(&self) -> usize {
        2
    }
    fn points(&self) -> &[At<2>] {
        &self.0
    }
    fn unknowns(&self, _: usize, out: &mut Vec<u32>) {
        out.extend([0, 1]);
    }
    fn coupling(&self, _: &At<2>, k: usize) -> VectorForm<2> {
        (V::ith(k, 1.0), M::zeros())
    }
}

#[test]
fn two_multipliers_hold_the_mean_velocity_of_a_disc_at_zero() {
    let mut square = Square::new(16, |_| V::new(1.0, 0.5));
    let held = MeanHeld(square.disc(A));
    assert!(square.solve(&[], &[&held]) < 1e-12);
    let space = &square.velocity;
    let flow: V = held
        .0
        .iter()
        .map(|p| space.value(&square.state.u, p.cell, &p.barycentric) * p.weight)
        .sum();
    assert!(flow.norm() < 1e-13, "{flow}");
    // The multipliers are the force per area that holds the disc, and the walls bear it.
    let area: f64 = held.0.iter().map(|p| p.weight).sum();
    let values = &square.solver.block_values()[0];
    let (force, _) = square.walls(&[], &[&held]);
    let held_by = V::new(values[0], values[1]) * area;
    assert!(
        force.norm() > 1.0 && (force - held_by).norm() < 1e-9 * force.norm(),
        "{force} {held_by}"
    );
}

/// Tension of an inextensible interface: P1 functions of the cut cells, `b(s, v) = int s P : grad
/// v`.
struct Tension {
    space: Arc<Space<2>>,
    /// Points on the interface with normals, and after those of each cell one for the whole cell.
    points: Vec<At<2>>,
    normals: Vec<Option<V>>,
    /// Normal of each cut cell.
    of_cell: Vec<V>,
    /// Number of each vertex.
    number: Vec<Option<u32>>,
    count: usize,
}

/// Stabilisation along the normal.
const STABLE: f64 = 0.1;

impl Tension {
    fn new(space: &Arc<Space<2>>, phi: &[f64]) -> Tension {
        let points = surface(space, phi).unwrap();
        let mesh = space.mesh();
        let mut tension = Tension {
            space: Arc::clone(space),
            points: vec![],
            normals: vec![],
            of_cell: vec![V::zeros(); mesh.cell_count()],
            number: vec![None; mesh.points().len()],
            count: 0,
        };
        for of_cell in points.chunk_by(|a, b| a.at.cell == b.at.cell) {
            let cell = of_cell[0].at.cell;
            for p in of_cell {
                tension.points.push(p.at);
                tension.normals.push(Some(p.normal));
            }
            let middle = [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0];
            let corners = mesh.cell(cell).iter().map(|&v| mesh.points()[v as usize]);
            let (x, weight) = (corners.sum::<V>() / 3.0, mesh.map(cell).volume);
            tension.points.push(At { cell, q: 0, barycentric: middle, x, weight });
            tension.normals.push(None);
            tension.of_cell[cell] = space.gradient(phi, cell, &middle).normalize();
            for &v in mesh.cell(cell) {
                if tension.number[v as usize].is_none() {
                    tension.number[v as usize] = Some(tension.count as u32);
                    tension.count += 1;
                }
            }
        }
        tension.points.iter_mut().enumerate().for_each(|(q, p)| p.q = q);
        tension
    }
    /// Mean of the tension over the interface times `weight(x)`.
    fn mean(&self, values: &[f64], weight: impl Fn(&Point<2>) -> f64) -> f64 {
        let on = self.points.iter().zip(&self.normals).filter(|(_, n)| n.is_some());
        let (sum, length) = on.fold((0.0, 0.0), |(s, l), (p, _)| {
            let cell = self.space.mesh().cell(p.cell);
            let value: f64 = (0..3)
                .map(|k| p.barycentric[k] * values[self.number[cell[k] as usize].unwrap() as usize])
                .sum();
            (s + p.weight * weight(&p.x) * value, l + p.weight)
        });
        sum / length
    }
}

impl Block<2> for Tension {
    fn len(&self) -> usize {
        self.count
    }
    fn points(&self) -> &[At<2>] {
        &self.points
    }
    fn unknowns(&self, cell: usize, out: &mut Vec<u32>) {
        out.extend(self.space.mesh().cell(cell).iter().map(|&v| self.number[v as usize].unwrap()));
    }
    fn coupling(&self, at: &At<2>, k: usize) -> VectorForm<2> {
        let projection = |n: V| (M::identity() - n * n.transpose()) * at.barycentric[k];
        (V::zeros(), self.normals[at.q].map_or(M::zeros(), projection))
    }
    fn own(&self, at: &At<2>, j: usize, k: usize) -> f64 {
        if self.normals[at.q].is_some() {
            return 0.0;
        }
        let (map, n) = (self.space.mesh().map(at.cell), &self.of_cell[at.cell]);
        -STABLE * map.gradient(j).dot(n) * map.gradient(k).dot(n)
    }
}

/// An inextensible circle of radius `A` in the straining flow `(x, -y)`: with
/// `psi = f(r) sin 2 theta`, `f = 3/4 r^2 - r^4/(4 A^2)` inside and `r^2/2 - A^2/4 + A^4/(4 r^2)`
/// outside, it moves with `A cos 2 theta` along its normal and has the tension `-2 A cos 2 theta`
/// and a constant (viscosity 1).
fn about_a_circle(x: &Point<2>) -> V {
    let (r, t) = (x.norm(), x[1].atan2(x[0]));
    let (a, b) = (A * A, A * A * A * A);
    let (f, slope) = if r < A {
        (0.75 * r * r - r.powi(4) / (4.0 * a), 1.5 * r - r.powi(3) / a)
    } else {
        (0.5 * r * r - 0.25 * a + 0.25 * b / (r * r), r - 0.5 * b / r.powi(3))
    };
    let (radial, around) = (2.0 * f / r * (2.0 * t).cos(), -slope * (2.0 * t).sin());
    V::new(radial * t.cos() - around * t.sin(), radial * t.sin() + around * t.cos())
}

#[test]
fn a_p1_trace_on_cut_cells_makes_a_circle_inextensible() {
    let errors = [12, 24, 48].map(|n| {
        let mut square = Square::new(n, about_a_circle);
        let phi = square.velocity.interpolate(|x| (x - V::new(0.003, 0.002)).norm() - A);
        let tension = Tension::new(&square.velocity, &phi);
        let residual = square.solve(&[], &[&tension]);
        assert!(residual < 1e-12, "{residual:e}");
        let values = &square.solver.block_values()[0];
        let wave = 2.0 * tension.mean(values, |x| (2.0 * x[1].atan2(x[0])).cos());
        let (sum, count) = (0..24).fold((0.0, 0.0), |(s, c), k| {
            let t = PI * f64::from(k) / 12.0 + 0.1;
            let x = V::new(t.cos(), t.sin()) * (0.7 * A);
            (s + (square.at(x) - about_a_circle(&x)).norm_squared(), c + 1.0)
        });
        [(sum / f64::sqrt(count * count)).sqrt() / A, (wave / (-2.0 * A) - 1.0).abs()]
    });
    // P2 has no kink and P1 no jump inside a cell: of first order.
    for k in 0..2 {
        assert!(errors[2][k] < [0.02, 0.08][k] && errors[2][k] < 0.3 * errors[0][k], "{errors:?}");
    }
}
