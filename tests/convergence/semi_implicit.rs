//! The book's semi-implicit scheme (3.62)-(3.64).
use crate::membrane::{Case, area_error, balance, half_chords};
use immersa::sim::Coupling;

#[test]
fn explore() {
    for line in std::fs::read_to_string("/tmp/semi_runs").unwrap().lines() {
        let mut case = Case::LISTING;
        let mut end = 0.4;
        let mut every = 0.1;
        for w in line.split_whitespace() {
            let (k, v) = w.split_once('=').unwrap();
            let f = || v.parse::<f64>().unwrap();
            match k {
                "n" => case.n = v.parse().unwrap(),
                "l" => case.modulus = f(),
                "ten" => { case.tension = true; case.stretch = 1.0 }
                "eps" => case.thickness = f(),
                "w" => case.thickness = f() * 2.0 / case.n as f64,
                "mu" => case.viscosity = f(),
                "gd" => case.grad_div = f(),
                "dt" => case.dt = f(),
                "end" => end = f(),
                "every" => every = f(),
                "c" => case.coupling = match v { "e" => Coupling::Explicit, "i" => Coupling::Implicit, _ => Coupling::SemiImplicit },
                "p" => case.transport = immersa::transport::Method::Projected,
                _ => panic!(),
            }
        }
        println!("{line}");
        let mut sim = case.simulation();
        let e0 = sim.state().energies.total();
        let mut worst: f64 = 0.0;
        let steps = (end / case.dt).round() as u64;
        let mut next = every;
        for k in 1..=steps {
            if let Err(e) = sim.step() { println!("  step {k} failed: {e:?}"); break }
            let r = sim.state().energies.total() / e0;
            worst = worst.max(r);
            if sim.time() > next - 1e-9 || k == steps {
                next += every;
                println!("  t {:.4} E/E0 {:.4} max {:.4} kin {:.4} bal {:+.4} area {:+.4} chords {:.5?} umax {:.3}", sim.time(), r, worst, sim.state().energies.kinetic / e0, balance(&sim), area_error(&sim), half_chords(&sim), sim.largest_speed());
                if !(r < 100.0) { break }
            }
        }
    }
}
