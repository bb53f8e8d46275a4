//! What a second thread brings: the kernels of a step with one thread and with two, in turn, the
//! best of many each.

#![allow(clippy::print_stdout, reason = "the figures are the point of a bench")]
#[allow(dead_code, reason = "some of it is for the other benches alone")]
mod case;

use case::{Case, DT};
use immersa::fem::{Basis, Rule, assemble_source, assemble_vector};
use immersa::flow::FlowState;
use immersa::flow::term::MomentumTerm;
use immersa::transport::{Feet, Tracer, carry_nodal};
use nalgebra::SVector;
use rayon::ThreadPoolBuilder;
use std::sync::Arc;
use std::time::Instant;

const REPETITIONS: usize = 400;

fn main() {
    let case = Case::plane(60);
    let space = case.velocity.space();
    let tracer = Tracer::new(space, &[]);
    let mut membrane = case.membrane();
    let solver = case.solver();
    let state = FlowState { u: case.u.clone(), p: vec![0.0; case.pressure.space().len()] };
    let fine = Basis::new(space, &Arc::new(Rule::simplex(2, 8)));
    let points = &case.velocity.rule().points;
    let (mut feet, mut moved) = (Feet::default(), case.phi.clone());
    let (mut load, mut scratch) = (vec![SVector::<f64, 2>::zeros(); case.u.len()], Vec::new());
    let mut total = [0.0; 2];
    let mut row = |name: &str, work: &mut (dyn FnMut() + Send)| {
        let best = compare(work);
        (total[0], total[1]) = (total[0] + best[0], total[1] + best[1]);
        println!(
            "{name:<20} {:8.3} ms {:8.3} ms {:6.2} times",
            1e3 * best[0],
            1e3 * best[1],
            best[0] / best[1]
        );
    };
    println!("60 x 60 squares       one thread  two threads");
    row("feet of quadrature", &mut || {
        tracer.from_quadrature(&case.u, DT, &case.velocity, &mut feet)
    });
    row("right-hand side", &mut || {
        assemble_source(&case.velocity, &mut load, &mut scratch, |c, cell| {
            let own = space.on_cell(&case.u, c);
            (0..points.len()).for_each(|q| cell.add(q, own.value(&points[q])));
        });
    });
    row("force", &mut || {
        membrane.prepare(&case.velocity, &case.phi, None);
        assemble_vector(
            &case.velocity,
            membrane.support().cells(),
            &mut load,
            &mut scratch,
            |at| membrane.force(at),
        );
    });
    row("transport", &mut || {
        tracer.from_nodes(&case.u, DT, &mut feet);
        carry_nodal(space, &case.phi, &feet, &mut moved);
    });
    row("energies", &mut || {
        std::hint::black_box(solver.energies(&state));
    });
    let membrane = case.membrane();
    row("elastic energy", &mut || {
        std::hint::black_box(membrane.energy(&fine, &case.phi));
    });
    println!(
        "all                  {:8.3} ms {:8.3} ms {:6.2} times",
        1e3 * total[0],
        1e3 * total[1],
        total[0] / total[1]
    );
}

/// The least seconds with one thread and with two.
fn compare(work: &mut (dyn FnMut() + Send)) -> [f64; 2] {
    let pools = [1, 2].map(|n| ThreadPoolBuilder::new().num_threads(n).build().unwrap());
    let mut best = [f64::INFINITY; 2];
    for _ in 0..REPETITIONS {
        for (pool, best) in pools.iter().zip(&mut best) {
            let seconds = pool.install(|| {
                let start = Instant::now();
                work();
                start.elapsed().as_secs_f64()
            });
            *best = best.min(seconds);
        }
    }
    best
}
