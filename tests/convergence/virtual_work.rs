//! The force of a membrane is the derivative of its energy, and its stiffness that of the force:
//! along the flow of a smooth divergence-free velocity, the level set carried exactly.

use crate::exact::{M, V};
use crate::tools::Study;
use immersa::elastic::{AreaLaw, Membrane};
use immersa::fem::{At, Basis, Cells, Element, Rule, Space, integrate};
use immersa::flow::term::MomentumTerm;
use immersa::levelset::{surface_weight, zeta};
use immersa::mesh::{Diagonals, Mesh, Point, box_mesh, rectangle};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

const LAWS: [AreaLaw; 3] = [
    AreaLaw::Linear { modulus: 2.0 },
    AreaLaw::OneSided { modulus: 2.0 },
    AreaLaw::Tension { tension: 0.7 },
];

/// A smooth velocity without divergence, `curl(sin(a x + b) sin(c y + d))`.
struct Waves([f64; 4]);

impl Waves {
    /// Where a particle at `x` is after the time `s`, by one step of the classical Runge-Kutta
    /// method.
    fn moved(&self, x: &Point<2>, s: f64) -> Point<2> {
        let k1 = self.velocity(x);
        let k2 = self.velocity(&(x + k1 * (0.5 * s)));
        let k3 = self.velocity(&(x + k2 * (0.5 * s)));
        let k4 = self.velocity(&(x + k3 * s));
        x + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (s / 6.0)
    }
    fn velocity(&self, x: &Point<2>) -> V {
        let [a, b, c, d] = self.0;
        let ((s, co), (t, ct)) = ((a * x[0] + b).sin_cos(), (c * x[1] + d).sin_cos());
        V::new(c * s * ct, -a * co * t)
    }
    fn gradient(&self, x: &Point<2>) -> M {
        let [a, b, c, d] = self.0;
        let ((s, co), (t, ct)) = ((a * x[0] + b).sin_cos(), (c * x[1] + d).sin_cos());
        M::new(a * c * co * ct, -c * c * s * t, a * a * s * t, -a * c * co * ct)
    }
}

const FIRST: Waves = Waves([2.0, 0.3, 1.5, 0.8]);
const SECOND: Waves = Waves([1.2, 1.1, 2.3, -0.4]);

/// A level set whose zero is an ellipse; the stretch along it goes from 1.05 to 1.67 when
/// `tightness` is 0.8.
fn level(x: &Point<2>, tightness: f64) -> f64 {
    let (p, q) = (x[0] - 1.03, x[1] - 0.96);
    let r = (p * p / 0.49 + q * q / 0.36).sqrt();
    (r - 1.0) * (tightness + 0.1 * p)
}

/// A band of half-width `eps` about the level set, on `n x n` squares, and all quadrature points.
struct Band {
    basis: Basis<2>,
    eps: f64,
    tightness: f64,
}

impl Band {
    fn new(n: usize, eps: f64, tightness: f64) -> Band {
        let mesh = rectangle([0.0; 2], [2.0; 2], [n; 2], Diagonals::UnionJack).unwrap();
        let space = Arc::new(Space::new(&Arc::new(mesh), Element::P2));
        Band { basis: Basis::new(&space, &Arc::new(Rule::simplex(2, 8))), eps, tightness }
    }
    /// The level set after `flow` has carried it for the time `s`.
    fn carried(&self, flow: &Waves, s: f64) -> Vec<f64> {
        self.basis.space().interpolate(|x| level(&flow.moved(x, -s), self.tightness))
    }
    /// The membrane on the carried level set, with stiffness for a step of length 1.
    fn membrane(&self, law: AreaLaw, flow: &Waves, s: f64) -> Membrane<2> {
        let mut membrane = Membrane::new(law, self.eps);
        membrane.prepare(&self.basis, &self.carried(flow, s), Some(1.0));
        membrane
    }
    /// Integral of `f` over the cells of the band.
    fn over(&self, membrane: &Membrane<2>, f: impl Fn(&At<2>) -> f64 + Sync) -> f64 {
        let [sum] = integrate(&self.basis, membrane.support().cells(), |at| [f(at)]);
        sum
    }
    /// `F(v)` for a `v` of the given gradient.
    fn force(&self, membrane: &Membrane<2>, gradient: impl Fn(&Point<2>) -> M + Sync) -> f64 {
        self.over(membrane, |at| membrane.force(at).1.dot(&gradient(&at.x)))
    }

    /// `dE/dt` along the flow, `-F(v)`, and what the change of the band's own width adds:
    /// `- int E(r)/(r eps) (zeta + s zeta')(s) P : grad v`, `s = phi/(r eps)`, which vanishes with
    /// `eps^2`.
    fn virtual_work(&self, law: AreaLaw, flow: &Waves) -> [f64; 3] {
        let energy =
            |s: f64| Membrane::new(law, self.eps).energy(&self.basis, &self.carried(flow, s));
        let s = 1e-3;
        let slope = (energy(s) - energy(-s)) / (2.0 * s);
        let (phi, membrane) = (self.carried(flow, 0.0), self.membrane(law, flow, 0.0));
        let width = self.over(&membrane, |at| {
            let g = self.basis.gradient(at, &phi);
            let (r, n) = (g.norm(), g.normalize());
            let s = self.basis.value(at, &phi) / (r * self.eps);
            let derivative =
                if s.abs() < 1.0 { zeta(s) - 0.5 * PI * s * (PI * s).sin() } else { 0.0 };
            let gradient = flow.gradient(&at.x);
            -law.energy(r) / (r * self.eps)
                * derivative
                * (gradient.trace() - (n.transpose() * gradient * n)[0])
        });
        [slope, -self.force(&membrane, |x| flow.gradient(x)), width]
    }

    /// What should be zero when `d/dt F(v) = - C(u, v) + F((u . grad) v) + (what the stiffness
    /// leaves out or adds)`, the level set carried by `u`, over the size of `C(u, v)`.
    fn stiffness_error(&self, law: AreaLaw, u: &Waves, v: &Waves) -> f64 {
        let s = 1e-3;
        let force = |s: f64| self.force(&self.membrane(law, u, s), |x| v.gradient(x));
        let slope = (force(s) - force(-s)) / (2.0 * s);
        let (phi, membrane) = (self.carried(u, 0.0), self.membrane(law, u, 0.0));
        let stiffness = self.over(&membrane, |at| {
            membrane.stiffness(at, &V::zeros(), &u.gradient(&at.x)).1.dot(&v.gradient(&at.x))
        });
        let convected = self.force(&membrane, |x| {
            let (d, w) = (1e-5, u.velocity(x));
            v.gradient(x) * u.gradient(x)
                + (v.gradient(&(x + w * d)) - v.gradient(&(x - w * d))) / (2.0 * d)
        });
        // In compression the turning of the normal is left out; for constant tension the stretching
        // is added.
        let changed = self.over(&membrane, |at| {
            let g = self.basis.gradient(at, &phi);
            let (r, n) = (g.norm(), g.normalize());
            let w = surface_weight(self.basis.value(at, &phi), r, self.eps);
            let t = V::new(-n[1], n[0]);
            let (a, c) = (u.gradient(&at.x) * t, v.gradient(&at.x) * t);
            match law {
                AreaLaw::Tension { tension } => tension * r * w * t.dot(&a) * t.dot(&c),
                _ => -law.tension(r).min(0.0) * r * w * n.dot(&a) * n.dot(&c),
            }
        });
        (slope + stiffness - convected - changed) / stiffness
    }
}

/// Half-widths of the band, ten edges each: mesh and band are refined together.
const WIDTHS: [f64; 3] = [0.16, 0.113, 0.08];

fn band(eps: f64, tightness: f64) -> Band {
    Band::new((20.0 / eps).round() as usize, eps, tightness)
}

#[test]
fn the_force_is_minus_the_derivative_of_the_energy() {
    for (law, bound) in [(LAWS[0], 3.0e-3), (LAWS[2], 1.3e-2)] {
        let works = WIDTHS.map(|eps| band(eps, 0.8).virtual_work(law, &FIRST));
        assert!(works.iter().all(|w| w[0] * w[1] > 0.0), "{law:?}: the sign: {works:?}");
        let errors = works.map(|[slope, work, _]| (slope - work).abs() / work.abs()).into();
        let what = format!("Virtual work, {law:?}");
        Study { what: &what, sizes: &WIDTHS, errors }.assert(2.0, bound);
    }
}

/// At a fixed width what is left over is the change of the band's own width, and nothing else.
#[test]
fn the_rest_of_the_virtual_work_is_the_width_of_the_band() {
    for (n, bound) in [(40, 7.7e-4), (80, 1.4e-4), (160, 6.5e-5)] {
        let [slope, work, width] = Band::new(n, 0.1, 0.8).virtual_work(LAWS[0], &FIRST);
        let error = (slope - work - width).abs() / work.abs();
        println!(
            "Virtual work with the width of the band, eps = 0.1, n = {n}: {error:.1e} (without \
             {:.1e})",
            (slope - work).abs() / work.abs()
        );
        assert!(error < bound);
    }
}

/// Stretched (0.8), and compressed (0.5) the linear law, whose stiffness then leaves out the
/// turning of the normal.
#[test]
fn the_stiffness_is_minus_the_derivative_of_the_force() {
    for (law, tightness, bound) in
        [(LAWS[0], 0.8, 4.9e-4), (LAWS[2], 0.8, 5.1e-4), (LAWS[0], 0.5, 4.5e-4)]
    {
        let errors = WIDTHS
            .map(|eps| band(eps, tightness).stiffness_error(law, &FIRST, &SECOND).abs())
            .into();
        let what = format!("Stiffness, {law:?}, tightness {tightness}");
        Study { what: &what, sizes: &WIDTHS, errors }.assert(2.0, bound);
    }
}

/// Symmetry and sign of the form at every quadrature point of the band around a ball.
fn check_form<const D: usize>(mesh: Mesh<D>, law: AreaLaw, stretch: f64, entries: [[f64; 9]; 2]) {
    let space = Arc::new(Space::new(&Arc::new(mesh), Element::P2));
    let basis = Basis::new(&space, &Arc::new(Rule::simplex(D, 3)));
    let phi = space.interpolate(|x| stretch * ((x - SVector::<f64, D>::repeat(0.52)).norm() - 0.3));
    let mut membrane = Membrane::new(law, 0.15);
    membrane.prepare(&basis, &phi, Some(0.1));
    let [a, b] = entries.map(|e| SMatrix::<f64, D, D>::from_fn(|i, j| e[D * i + j]));
    let Cells::Some(cells) = membrane.support().cells() else {
        panic!("a band is some of the cells")
    };
    let mut largest: f64 = 0.0;
    for at in cells.iter().flat_map(|&c| (0..basis.rule().len()).map(move |q| (c as usize, q))) {
        let at = basis.at(at.0, at.1);
        let form = |u: &SMatrix<f64, D, D>, v: &SMatrix<f64, D, D>| {
            membrane.stiffness(&at, &SVector::zeros(), u).1.dot(v)
        };
        let scale = (form(&a, &a) * form(&b, &b)).abs().sqrt().max(1e-12);
        assert!((form(&a, &b) - form(&b, &a)).abs() <= 1e-9 * scale.max(form(&a, &b).abs()));
        assert!(form(&a, &a) >= -1e-12 * scale && form(&a, &b).abs() <= scale * (1.0 + 1e-9));
        largest = largest.max(form(&a, &a));
    }
    let slack = matches!(law, AreaLaw::OneSided { .. }) && stretch < 1.0;
    assert!(slack || largest > 0.0, "the form vanishes");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn the_stiffness_is_symmetric_and_positive(
        entries in prop::array::uniform2(prop::array::uniform9(-1.0..1.0f64)), stretch in 0.7..1.5f64, k in 0..3usize
    ) {
        check_form(rectangle([0.0; 2], [1.0; 2], [8; 2], Diagonals::UnionJack).unwrap(), LAWS[k], stretch, entries);
        check_form(box_mesh([0.0; 3], [1.0; 3], [4; 3]).unwrap(), LAWS[k], stretch, entries);
    }
}
