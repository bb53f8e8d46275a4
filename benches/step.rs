//! What a time step is made of, kernel by kernel, and whole steps, in two and three dimensions, on one thread.

use divan::{Bencher, black_box};
use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{
    Basis, Cells, Condition, Element, Numbering, Rule, Space, assemble_flow_matrix, assemble_source, assemble_vector,
};
use immersa::flow::term::MomentumTerm;
use immersa::flow::{FlowSolver, FlowState, History, Step};
use immersa::levelset::Contour;
use immersa::linalg::{Factor, Ordering, SymmetricMatrix};
use immersa::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use immersa::sim::{Contrast, Coupling, Materials, Settings, Simulation, Structure};
use immersa::transport::{Feet, Method, Tracer, carry_nodal};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Edges along the side of the square.
const PLANE: [usize; 2] = [30, 60];
/// Edges along the side of the cube.
const SPACE: [usize; 1] = [6];
const DT: f64 = 5e-3;
const SAMPLES: u32 = 20;

fn main() {
    // All figures are of one thread; it fails only where threads were started already.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    divan::main();
}

/// A stretched ball in a closed box that turns: the pieces of a step.
struct Case<const D: usize> {
    velocity: Basis<D>,
    pressure: Basis<D>,
    conditions: Vec<(String, Condition<D>)>,
    u: Vec<SVector<f64, D>>,
    phi: Vec<f64>,
}

impl Case<2> {
    fn plane(n: usize) -> Self {
        Case::new(rectangle([0.0; 2], [2.0; 2], [n; 2], Diagonals::UnionJack).unwrap())
    }
}
impl Case<3> {
    fn space(n: usize) -> Self {
        Case::new(box_mesh([0.0; 3], [2.0; 3], [n; 3]).unwrap())
    }
}

impl<const D: usize> Case<D> {
    fn new(mesh: Mesh<D>) -> Self {
        let conditions = mesh.boundaries().keys().map(|name| (name.clone(), Condition::NoSlip)).collect();
        let mesh = Arc::new(mesh);
        let (p2, p1) = [Element::P2, Element::P1].map(|e| Arc::new(Space::new(&mesh, e))).into();
        let rule = Arc::new(Rule::simplex(D, 5));
        let bump = |x: &Point<D>| x.iter().map(|x| x * (2.0 - x)).product::<f64>();
        let u = p2.interpolate(|x| {
            let mut u = SVector::<f64, D>::zeros();
            (u[0], u[1]) = (bump(x) * (x[1] - 1.0), bump(x) * (1.0 - x[0]));
            u
        });
        let phi = p2.interpolate(|x| 1.2 * ((x - Point::<D>::repeat(1.0)).norm() - 0.6));
        Case { velocity: Basis::new(&p2, &rule), pressure: Basis::new(&p1, &rule), conditions, u, phi }
    }
    fn thickness(&self) -> f64 {
        2.0 * self.velocity.space().mesh().diameter(0)
    }
    fn membrane(&self) -> Membrane<D> {
        Membrane::new(AreaLaw::Linear { modulus: 1.0 }, self.thickness())
    }
    fn solver(&self) -> FlowSolver<D> {
        let (velocity, pressure) = (self.velocity.space(), self.pressure.space());
        FlowSolver::new(velocity, pressure, self.velocity.rule(), &self.conditions, 1.0).unwrap()
    }
    fn numbering(&self) -> Numbering<D> {
        Numbering::new(self.velocity.space(), self.pressure.space(), &self.conditions).unwrap()
    }
    fn empty_matrix(&self, numbering: &Numbering<D>) -> SymmetricMatrix {
        let (u, p) = (self.velocity.space(), self.pressure.space());
        let groups = (0..u.mesh().cell_count()).map(|c| {
            let mut list = Vec::new();
            numbering.cell_unknowns(u.cell_nodes(c), Some(p.cell_nodes(c)), &mut list);
            list
        });
        SymmetricMatrix::from_groups(numbering.order(), groups).unwrap()
    }
    fn assemble(&self, numbering: &Numbering<D>, matrix: &mut SymmetricMatrix) {
        matrix.zero();
        let form = |_: &_, u: &SVector<f64, D>, grad: &SMatrix<f64, D, D>| {
            (u / DT, (grad + grad.transpose()) * 0.01 + SMatrix::identity() * grad.trace())
        };
        assemble_flow_matrix(&self.velocity, Some(&self.pressure), numbering, Cells::All, matrix, form).unwrap();
    }
    fn factored(&self) -> (SymmetricMatrix, Factor) {
        let numbering = self.numbering();
        let mut matrix = self.empty_matrix(&numbering);
        self.assemble(&numbering, &mut matrix);
        let ordering = Ordering::saddle_point(&matrix, numbering.first_pressure()).unwrap();
        let mut factor = Factor::analyse(&matrix, ordering).unwrap();
        factor.refactor(&matrix).unwrap();
        (matrix, factor)
    }
    fn simulation(&self, order: usize, coupling: Coupling) -> Simulation<D> {
        let settings = Settings {
            dt: DT,
            order,
            transport: Method::Nodal,
            coupling,
            convection: true,
            grad_div: 1.0,
            quadrature: 5,
            materials: Materials { density: Contrast::uniform(1.0), viscosity: Contrast::uniform(0.01) },
            conditions: self.conditions.clone(),
            gravity: SVector::zeros(),
            body_force: None,
        };
        let (membrane, phi) = (self.membrane(), self.phi.clone());
        let structure = Structure { name: "membrane".into(), phi, membrane, surface_mass: 0.0 };
        let mesh = self.velocity.space().mesh();
        let mut simulation = Simulation::new(mesh, settings, vec![structure], |_| SVector::zeros()).unwrap();
        for _ in 0..2 {
            simulation.step().unwrap();
        }
        simulation
    }
}

/// The same benches for the plane and for space.
macro_rules! benches {
    ($name:ident, $case:path, $sizes:expr) => {
        mod $name {
            use super::*;

            #[divan::bench(args = $sizes, sample_count = 5, sample_size = 1)]
            fn matrix(bencher: Bencher, n: usize) {
                let case = $case(n);
                let numbering = case.numbering();
                let mut matrix = case.empty_matrix(&numbering);
                bencher.bench_local(|| case.assemble(&numbering, &mut matrix));
            }
            #[divan::bench(args = $sizes, sample_count = 3, sample_size = 1)]
            fn ordering_and_analysis(bencher: Bencher, n: usize) {
                let case = $case(n);
                let (matrix, _) = case.factored();
                let first = case.numbering().first_pressure();
                bencher
                    .bench_local(|| Factor::analyse(&matrix, Ordering::saddle_point(&matrix, first).unwrap()).unwrap());
            }
            #[divan::bench(args = $sizes, sample_count = 5, sample_size = 1)]
            fn refactor(bencher: Bencher, n: usize) {
                let (matrix, mut factor) = $case(n).factored();
                bencher.bench_local(|| factor.refactor(&matrix).unwrap());
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn solve(bencher: Bencher, n: usize) {
                let (matrix, mut factor) = $case(n).factored();
                let rhs: Vec<f64> = (0..matrix.order()).map(|i| (i as f64).sin()).collect();
                let mut x = rhs.clone();
                bencher.bench_local(|| factor.solve(&matrix, &rhs, &mut x).unwrap());
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn feet_of_quadrature(bencher: Bencher, n: usize) {
                let case = $case(n);
                let (tracer, mut feet) = (Tracer::new(case.velocity.space(), &[]), Feet::default());
                bencher.bench_local(|| tracer.from_quadrature(&case.u, DT, &case.velocity, &mut feet));
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn right_hand_side(bencher: Bencher, n: usize) {
                let case = $case(n);
                let (mut load, mut scratch) = (vec![SVector::zeros(); case.u.len()], Vec::new());
                let (space, points) = (case.velocity.space(), &case.velocity.rule().points);
                bencher.bench_local(|| {
                    assemble_source(&case.velocity, &mut load, &mut scratch, |c, cell| {
                        let own = space.on_cell(&case.u, c);
                        (0..points.len()).for_each(|q| cell.add(q, own.value(&points[q])));
                    });
                });
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn force(bencher: Bencher, n: usize) {
                let case = $case(n);
                let mut membrane = case.membrane();
                let (mut load, mut scratch) = (vec![SVector::zeros(); case.u.len()], Vec::new());
                bencher.bench_local(|| {
                    membrane.prepare(&case.velocity, &case.phi, None);
                    let cells = MomentumTerm::cells(&membrane);
                    assemble_vector(&case.velocity, cells, &mut load, &mut scratch, |at| membrane.force(at));
                });
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn transport(bencher: Bencher, n: usize) {
                let case = $case(n);
                let (tracer, mut feet) = (Tracer::new(case.velocity.space(), &[]), Feet::default());
                let mut moved = case.phi.clone();
                bencher.bench_local(|| {
                    tracer.from_nodes(&case.u, DT, &mut feet);
                    carry_nodal(case.velocity.space(), &case.phi, &feet, &mut moved);
                });
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn energies(bencher: Bencher, n: usize) {
                let case = $case(n);
                let (solver, u) = (case.solver(), case.u.clone());
                let state = FlowState { u, p: vec![0.0; case.pressure.space().len()] };
                bencher.bench_local(|| solver.energies(&state));
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn elastic_energy(bencher: Bencher, n: usize) {
                let case = $case(n);
                let membrane = case.membrane();
                let dimension = case.u[0].len();
                let fine = Basis::new(case.velocity.space(), &Arc::new(Rule::simplex(dimension, 8)));
                bencher.bench_local(|| membrane.energy(&fine, &case.phi));
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn step_of_the_flow(bencher: Bencher, n: usize) {
                let case = $case(n);
                let mut solver = case.solver();
                let mut state = solver.at_rest();
                let history = [History { weight: 1.0, u: &case.u, feet: None }];
                let step = Step::backward_euler(DT, DT, &history);
                solver.step(&step, &mut state).unwrap();
                bencher.bench_local(|| solver.step(&step, &mut state).unwrap());
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn step_explicit_order_1(bencher: Bencher, n: usize) {
                let mut simulation = $case(n).simulation(1, Coupling::Explicit);
                bencher.bench_local(|| simulation.step().unwrap());
            }
            #[divan::bench(args = $sizes, sample_count = SAMPLES, sample_size = 1)]
            fn step_explicit_order_2(bencher: Bencher, n: usize) {
                let mut simulation = $case(n).simulation(2, Coupling::Explicit);
                bencher.bench_local(|| simulation.step().unwrap());
            }
            #[divan::bench(args = $sizes, sample_count = 4, sample_size = 1)]
            fn step_implicit(bencher: Bencher, n: usize) {
                let mut simulation = $case(n).simulation(2, Coupling::Implicit);
                bencher.bench_local(|| simulation.step().unwrap());
            }
        }
    };
}

benches!(plane, Case::plane, PLANE);
benches!(space, Case::space, SPACE);

#[divan::bench(args = PLANE, sample_count = SAMPLES, sample_size = 1)]
fn contour(bencher: Bencher, n: usize) {
    let case = Case::plane(n);
    bencher.bench_local(|| Contour::new(case.velocity.space(), black_box(&case.phi)).unwrap().measures().unwrap());
}
