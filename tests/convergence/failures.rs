//! The failures of published and of obvious methods, each where it is predicted, with the remedy
//! that removes it.
//!
//! The book's listing has its viscous term as `mu (grad u, grad v)`. For a velocity that vanishes
//! on the boundary this is `2 mu (D u, D v) - mu (div u, div v)`: ours with a grad-div term of
//! weight `-mu`. The small weight matters: it is what keeps `div u` from feeding the membrane in
//! our scheme without grad-div (see `energy`).

use crate::explicit_limit::{flat, is_stable, medium, tension};
use crate::membrane::{Case, area_error, balance, half_chords};
use crate::semi_implicit::divergence_form;
use immersa::elastic::{Band, explicit_step_limit};
use immersa::mesh::Diagonals;
use immersa::sim::{Coupling, Simulation};

/// The listing as it is printed, without the adaptation of its mesh.
const AS_PRINTED: Case = Case { grad_div: -Case::LISTING.viscosity, ..Case::LISTING };

/// What became of a run.
struct Fate {
    /// Energy at the end, and the largest on the way, over that at the start.
    energy: f64,
    peak: f64,
    /// Spurious energy, over that at the start.
    balance: f64,
    /// Per cent.
    area: f64,
    sim: Simulation<2>,
}

fn fate(what: &str, case: Case, end: f64) -> Fate {
    let mut sim = case.simulation();
    let start = sim.state().energies.total();
    let mut peak: f64 = 0.0;
    for _ in 0..(end / case.dt).round() as usize {
        sim.step().unwrap();
        peak = peak.max(sim.state().energies.total() / start);
    }
    let energy = sim.state().energies.total() / start;
    let (balance, area) = (balance(&sim), area_error(&sim));
    println!(
        "{what}, lambda = {}, n = {}, eps = {:.2} h, dt = {}, grad-div {}, {:?}, t = {end}: E/E0 \
         {energy:.3}, at most {peak:.3}, balance {balance:+.3}, area {area:+.3} %, max |u| {:.3}",
        case.modulus,
        case.n,
        case.thickness * case.n as f64 / 2.0,
        case.dt,
        case.grad_div,
        case.coupling,
        sim.largest_speed()
    );
    Fate { energy, peak, balance, area, sim }
}

/// Whether the run behaves: energy never above the start, little spurious energy, area kept.
fn is_sound(f: &Fate, balance: f64, area: f64) -> bool {
    f.peak <= 1.0 && f.balance.abs() < balance && f.area.abs() < area
}

/// F1: the listing as printed (n = 30, eps = 1.5 h) gains energy, whatever the step. FreeFEM at t =
/// .25: max |u| 1.25, half-chord .7342, area -1.46 %; E/E0 3.1 at t = .4. Remedy: grad-div.
#[test]
fn f1_the_listing_as_printed_gains_energy() {
    let early = fate("F1", AS_PRINTED, 0.25);
    let chord = half_chords(&early.sim)[0];
    println!("F1: half-chord along x at t = .25: {chord:.4}");
    assert!((early.sim.largest_speed() - 1.25).abs() < 0.01 && (chord - 0.7342).abs() < 1e-4);
    assert!((early.area + 1.46).abs() < 0.03);
    for dt in [5e-3, 2.5e-3] {
        let late = fate("F1", Case { dt, ..AS_PRINTED }, 0.4);
        assert!(
            (late.energy - 3.1).abs() < 0.25 && late.balance > 8.0,
            "{} {}",
            late.energy,
            late.balance
        );
    }
    let remedied = fate("F1", Case::LISTING, 0.5);
    assert!(is_sound(&remedied, 0.005, 0.03));
}

/// F2: a band of 3 h hides most of it. On parallel diagonals (n = 24, dt = .01, t = .6) an
/// independent program in Python has E/E0 = .985 and the area at -.11 %, and with 1.5 h 2.35 and
/// -1.5 %; FreeFEM on the union jack (n = 30, t = .25) max |u| .105 and the area at -.13 %. Even so
/// several per cent of the energy are spurious. Remedy: grad-div.
#[test]
fn f2_a_wide_band_hides_the_gain() {
    let parallel = Case { n: 24, diagonals: Diagonals::Right, dt: 1e-2, ..AS_PRINTED };
    let narrow = fate("F2, parallel diagonals", Case { thickness: 0.125, ..parallel }, 0.6);
    assert!((narrow.energy - 2.35).abs() < 0.05 && (narrow.area + 1.5).abs() < 0.05);
    let wide = Case { thickness: 0.25, ..parallel };
    let hidden = fate("F2, parallel diagonals", wide, 0.6);
    assert!((hidden.energy - 0.985).abs() < 2e-3 && (hidden.area + 0.11).abs() < 0.01);
    assert!((0.04..0.06).contains(&hidden.balance), "{}", hidden.balance);
    let jack = fate("F2, union jack", Case { thickness: 0.2, ..AS_PRINTED }, 0.25);
    assert!((jack.sim.largest_speed() - 0.105).abs() < 1e-3 && (jack.area + 0.13).abs() < 5e-3);
    let remedied = fate("F2, parallel diagonals", Case { grad_div: 1.0, ..wide }, 0.6);
    assert!(is_sound(&remedied, 0.005, 0.03));
}

/// F3: a finer mesh with the band narrowed along with it makes it worse: four times the energy of
/// F1 at t = .3. Remedy: grad-div.
#[test]
fn f3_refinement_makes_it_worse() {
    let coarse = fate("F3", AS_PRINTED, 0.3);
    let fine = Case { n: 60, thickness: 0.05, ..AS_PRINTED };
    let worse = fate("F3", fine, 0.3);
    assert!((1.8..2.4).contains(&coarse.energy) && worse.energy > 4.0 * coarse.energy);
    let remedied = fate("F3", Case { grad_div: 1.0, ..fine }, 0.3);
    assert!(is_sound(&remedied, 0.005, 0.03));
}

/// F4: with lambda = 10 the wide band does not help, and neither does a smaller step, nor the
/// implicit coupling. Remedy: grad-div, here in proportion to the stress.
#[test]
fn f4_a_stiff_membrane_gains_energy_at_every_step() {
    let stiff = Case { modulus: 10.0, thickness: 0.2, ..AS_PRINTED };
    for (coupling, dt, least) in [
        (Coupling::Explicit, 2.5e-3, 5.0),
        (Coupling::Explicit, 1.25e-3, 5.0),
        (Coupling::Implicit, 5e-3, 1.3),
    ] {
        let grown = fate("F4", Case { coupling, dt, ..stiff }, 0.3);
        assert!(grown.energy > least, "{}", grown.energy);
    }
    for (coupling, dt) in [(Coupling::Explicit, 2.5e-3), (Coupling::Implicit, 5e-3)] {
        let remedied = fate("F4", Case { coupling, dt, grad_div: 16.0, ..stiff }, 0.3);
        assert!(is_sound(&remedied, 0.025, 0.01));
    }
}

/// F5: the explicit coupling beyond (1.54) with `dx = .258 h` (flat membrane of constant tension, n
/// = 16, eps = 3 h, mu = .01, 90 steps). The measured limit is 1.34 times the formula
/// (`explicit_limit`). Remedies: the implicit coupling and, over a carried band, the semi-implicit
/// one.
#[test]
fn f5_the_explicit_coupling_beyond_its_limit() {
    let (viscosity, thickness) = (1e-2, 3.0 / 16.0);
    let limit = explicit_step_limit(&medium(viscosity, 1.0 / 16.0), thickness, 1.0);
    let renormalised = tension(thickness);
    let carried = tension(thickness).with_band(Band::Carried, 1.0);
    let bears = |coupling, membrane, factor: f64| {
        let bears = is_stable(flat(16, viscosity, membrane, factor * limit, coupling), 90, 1.0);
        println!(
            "F5, flat membrane, {coupling:?}, {factor} of (1.54), 90 steps: {}",
            if bears { "stable" } else { "unstable" }
        );
        bears
    };
    for membrane in [&renormalised, &carried] {
        assert!(
            bears(Coupling::Explicit, membrane, 0.7) && !bears(Coupling::Explicit, membrane, 2.0)
        );
    }
    for factor in [2.0, 20.0] {
        assert!(
            bears(Coupling::Implicit, &renormalised, factor)
                && bears(Coupling::SemiImplicit, &carried, factor)
        );
    }
}

/// F6: the diffusion of the semi-implicit scheme (3.62) written as `div(E' grad phi*)` in place of
/// the `E' lap phi*` of the book, for an area law: the run goes on, but with many times the energy.
/// Two independent programs that wrote it so have 4 times and 3.3 % more area (Python, n = 24, eps
/// = 3 h, dt = .01, t = .6) and 20 times (FreeFEM, n = 30, eps = .1, dt = 5e-3, where the explicit
/// coupling is stable); small differences grow in these runs. What the divergence adds is `grad E'
/// . grad phi*`, the push of a force along the normal that no membrane has. Remedies: the
/// diffusivity outside the divergence, as published, and the implicit coupling.
#[test]
fn f6_the_diffusivity_inside_the_divergence() {
    let wide = Case { n: 24, thickness: 0.25, dt: 1e-2, ..Case::LISTING };
    for (case, end) in [(wide, 0.6), (Case::LISTING, 0.4)] {
        let (energy, area) = divergence_form(case, end);
        println!(
            "F6, n = {}, diffusivity inside the divergence: E/E0 {energy:.2}, area {area:+.2} %",
            case.n
        );
        assert!((4.0..40.0).contains(&energy), "{energy}");
        for coupling in [Coupling::SemiImplicit, Coupling::Implicit] {
            assert!(is_sound(&fate("F6", Case { coupling, ..case }, end), 0.005, 0.03));
        }
    }
}
