//! What a time step is made of, kernel by kernel, and whole steps, in two and three dimensions, on
//! one thread.

mod case;

use case::{Case, DT};
use divan::{Bencher, black_box};
use immersa::fem::{Basis, Rule, assemble_source, assemble_vector};
use immersa::flow::term::{MomentumTerm, Support};
use immersa::flow::{FlowState, History, Step};
use immersa::levelset::Contour;
use immersa::linalg::{Factor, Ordering};
use immersa::sim::Coupling;
use immersa::transport::{Feet, Tracer, carry_nodal};
use nalgebra::SVector;
use std::sync::Arc;

/// Edges along the side of the square.
const PLANE: [usize; 2] = [30, 60];
/// Edges along the side of the cube.
const SPACE: [usize; 1] = [6];
const SAMPLES: u32 = 20;

fn main() {
    // All figures are of one thread; it fails only where threads were started already.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    divan::main();
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
                bencher.bench_local(|| {
                    Factor::analyse(&matrix, Ordering::saddle_point(&matrix, first).unwrap())
                        .unwrap()
                });
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
                bencher
                    .bench_local(|| tracer.from_quadrature(&case.u, DT, &case.velocity, &mut feet));
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
                    let Support::Cells(cells) = membrane.support() else { return };
                    assemble_vector(&case.velocity, cells, &mut load, &mut scratch, |at| {
                        membrane.force(at)
                    });
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
                let fine =
                    Basis::new(case.velocity.space(), &Arc::new(Rule::simplex(dimension, 8)));
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
    bencher.bench_local(|| {
        Contour::new(case.velocity.space(), black_box(&case.phi)).unwrap().measures().unwrap()
    });
}
