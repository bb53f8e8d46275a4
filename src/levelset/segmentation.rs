//! Active contours: the level set that separates two grey levels of an image (book, section 1.4.1).

use super::band::{heaviside, zeta};
use crate::base::{Cause, Error, Partition, Result};
use crate::fem::{At, Basis, Cells, EDGES, Projector, Rule, Space, integrate};
use crate::mesh::Point;
use std::sync::Arc;

/// Weights of a [`Segmentation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentationWeights {
    /// Weight `alpha` of the fidelity to the image, > 0.
    pub fidelity: f64,
    /// Weight `beta` of the length, >= 0.
    pub length: f64,
    /// Half-width `eps` of the band, > 0.
    pub thickness: f64,
}

/// The two parts of the energy of a level set on an image, and the mean grey levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentationFit {
    /// Mean grey levels `c1` inside and `c2` outside.
    pub levels: [f64; 2],
    /// `alpha E1`.
    pub fidelity: f64,
    /// `beta E2`.
    pub length: f64,
}

/// The gradient flow of `alpha E1 + beta E2`, which fits the levels `c1` inside and `c2` outside to
/// the image `u0` with a short contour:
///
/// `E1 = int |u0 - c1|^2 (1 - H) + int |u0 - c2|^2 H`, `E2 = int delta |grad phi|`,
/// `H = H(phi/eps)`, `delta = zeta(phi/eps)/eps`,
///
/// with `H = 1` outside (`phi > 0`). Of both,
/// `int dE psi = int delta (alpha [(u0 - c2)^2 - (u0 - c1)^2] - beta div n) psi`, so that
///
/// `d phi/dt = delta (alpha [(u0 - c1)^2 - (u0 - c2)^2] + beta div (grad phi/|grad phi|))`,
///
/// which is (1.29) with the weights corrected. `c1 = int u0 (1 - H) / int (1 - H)` and
/// `c2 = int u0 H / int H` minimise `E1`. A step is implicit in the length term only, with the old
/// slope:
///
/// `(m phi', q) + beta dt (grad phi'/|grad phi|, grad q) = (m phi + dt alpha [(u0 - c1)^2 - (u0 -
/// c2)^2], q)`, `m = 1/delta`,
///
/// with the natural boundary condition: the contour meets the boundary at right angles. `delta` is
/// at least 1e-6 of its maximum, so that `phi` outside of the band does not change. The length term
/// is stable for any step; in one step the contour moves by at most `eps`, up to the edge of the
/// band.
///
/// A long step moves the contour less than its length implies, because the implicit term also
/// couples across the band.
///
/// Limits: objects away from the path of the contour are not found, since `delta` is zero there;
/// only two levels are distinguished.
///
/// Source: Chan and Vese 2001; (1.29).
pub struct Segmentation<const D: usize> {
    projector: Projector<D>,
    /// At the quadrature points, cell by cell.
    grey: Vec<f64>,
    weights: SegmentationWeights,
}

/// Least value of `zeta` in a denominator.
const REST: f64 = 1e-6;
/// Least value of `|grad phi|` in a denominator: a distance is below it only where fronts meet.
const FLAT: f64 = 0.1;
/// Degree of the rule on the parts of a cell.
const DEGREE: usize = 4;
/// Least fraction of the domain for which a side has a mean.
const LEAST: f64 = 1e-9;

impl<const D: usize> Segmentation<D> {
    /// A segmentation of the image `grey`, a level at each position, on a P2 space. In the plane
    /// the rule covers the four parts of a cell between its P2 nodes: an image whose pixels are
    /// pairs of such parts is integrated exactly.
    ///
    /// # Errors
    /// A matrix that does not fit into the memory.
    pub fn new(
        space: &Arc<Space<D>>,
        grey: impl Fn(&Point<D>) -> f64 + Sync,
        weights: SegmentationWeights,
    ) -> Result<Segmentation<D>> {
        let rule = if D == 2 {
            quartered(&Rule::simplex(2, DEGREE))
        } else {
            Rule::simplex(D, DEGREE + 2)
        };
        let basis = Basis::new(space, &Arc::new(rule));
        let points = basis.rule().len();
        let grey = (0..space.mesh().cell_count() * points)
            .map(|k| grey(&basis.at(k / points, k % points).x))
            .collect();
        Ok(Segmentation { projector: Projector::without_form(basis, &[])?, grey, weights })
    }

    /// The weights and the half-width of the band.
    pub fn weights(&self) -> SegmentationWeights {
        self.weights
    }
    /// Bytes held by the factor.
    pub fn bytes(&self) -> usize {
        self.projector.bytes()
    }
    fn grey_at(&self, at: &At<D>) -> f64 {
        self.grey[at.cell * self.projector.basis().rule().len() + at.q]
    }

    /// The mean grey levels inside and outside.
    ///
    /// # Errors
    /// One of the two sides is empty.
    pub fn levels(&self, phi: &[f64]) -> Result<[f64; 2]> {
        let (basis, eps) = (self.projector.basis(), self.weights.thickness);
        let [inside, grey_inside, all, grey_all] = integrate(basis, Cells::All, |at| {
            let (part, grey) = (heaviside(-basis.value(at, phi) / eps), self.grey_at(at));
            [part, grey * part, 1.0, grey]
        });
        let outside = all - inside;
        if inside.min(outside) > LEAST * all {
            return Ok([grey_inside / inside, (grey_all - grey_inside) / outside]);
        }
        let side = if inside < outside { "inside" } else { "outside" };
        Err(gone(side).value(format!("{:.3e} of the image inside", inside / all)))
    }

    /// The energy, and the levels that minimise it.
    ///
    /// # Errors
    /// Those of [`levels`](Self::levels).
    pub fn fit(&self, phi: &[f64]) -> Result<SegmentationFit> {
        let levels @ [c1, c2] = self.levels(phi)?;
        let (basis, SegmentationWeights { fidelity, length, thickness: eps }) =
            (self.projector.basis(), self.weights);
        let [misfit, size] = integrate(basis, Cells::All, |at| {
            let (value, grey) = (basis.value(at, phi), self.grey_at(at));
            let outside = heaviside(value / eps);
            let delta = zeta(value / eps) / eps;
            let slope = if delta > 0.0 { basis.gradient(at, phi).norm() } else { 0.0 };
            [(grey - c1).powi(2) * (1.0 - outside) + (grey - c2).powi(2) * outside, delta * slope]
        });
        Ok(SegmentationFit { levels, fidelity: fidelity * misfit, length: length * size })
    }

    /// A step of length `dt`; the level set must be redistanced after it.
    ///
    /// # Errors
    /// Those of [`levels`](Self::levels); a matrix that cannot be factored; an empty contour after
    /// the step.
    pub fn step(&mut self, dt: f64, phi: &mut [f64]) -> Result<()> {
        let [c1, c2] = self.levels(phi)?;
        let (basis, old) = (self.projector.basis().clone(), phi.to_vec());
        let SegmentationWeights { fidelity, length, thickness: eps } = self.weights;
        let mass = |at: &At<D>| eps / zeta(basis.value(at, &old) / eps).max(REST);
        self.projector
            .set_form(|at| (mass(at), length * dt / basis.gradient(at, &old).norm().max(FLAT)))?;
        let (grey, points) = (&self.grey, basis.rule().len());
        self.projector.project(
            |at| {
                let u = grey[at.cell * points + at.q];
                mass(at) * basis.value(at, &old)
                    + dt * fidelity * ((u - c1).powi(2) - (u - c2).powi(2))
            },
            phi,
        )?;
        let side = match phi.first() {
            Some(v) if *v < 0.0 && phi.iter().all(|v| *v < 0.0) => "outside",
            Some(v) if *v >= 0.0 && phi.iter().all(|v| *v >= 0.0) => "inside",
            _ => return Ok(()),
        };
        let least = phi.iter().fold(f64::INFINITY, |least, v| least.min(v.abs()));
        Err(gone(side).value(format!("|phi| >= {least:.3e}")))
    }
}

/// The error for an empty side.
fn gone(side: &str) -> Error {
    Error::computation(format!("the contour is gone: nothing is left {side}"))
        .remedy("give the length a smaller weight, or take a start that crosses the objects")
        .because(Cause::ContourLost)
}

/// The rule on each of the four parts of a triangle between its edge midpoints.
fn quartered(rule: &Rule) -> Rule {
    let corner = |k: usize| -> [f64; 3] { std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }) };
    let middle = |i: usize, j: usize| -> [f64; 3] {
        std::array::from_fn(|k| 0.5 * (corner(i)[k] + corner(j)[k]))
    };
    let middles = [middle(0, 1), middle(1, 2), middle(2, 0)];
    let parts = [
        [corner(0), middles[0], middles[2]],
        [middles[0], corner(1), middles[1]],
        [middles[2], middles[1], corner(2)],
        middles,
    ];
    let points = parts.iter().flat_map(|part| {
        rule.points.iter().map(|l| {
            let coordinate = |k: usize| (0..3).map(|i| l[i] * part[i][k]).sum();
            [coordinate(0), coordinate(1), coordinate(2), 0.0]
        })
    });
    let weights = parts.iter().flat_map(|_| rule.weights.iter().map(|w| 0.25 * w));
    Rule { points: points.collect(), weights: weights.collect() }
}

/// Number of connected parts of `phi < 0` on the lattice of the P2 nodes. Parts that meet the
/// boundary are included.
pub fn parts_inside<const D: usize>(space: &Space<D>, phi: &[f64]) -> usize {
    let mut parts = Partition::new(space.len());
    let edges = &EDGES[..D * (D + 1) / 2];
    for c in 0..space.mesh().cell_count() {
        let nodes = space.cell_nodes(c);
        let mut join = |a: usize, b: usize| {
            let pair = [nodes[a], nodes[b]];
            if pair.iter().all(|&n| phi[n as usize] < 0.0) {
                parts.join(pair[0], pair[1]);
            }
        };
        for (e, &(i, j)) in edges.iter().enumerate() {
            let middle = D + 1 + e;
            join(i, middle);
            join(j, middle);
            for (f, &(k, l)) in edges.iter().enumerate().skip(e + 1) {
                if [k, l].contains(&i) || [k, l].contains(&j) {
                    join(middle, D + 1 + f);
                }
            }
        }
    }
    (0..space.len() as u32).filter(|&n| phi[n as usize] < 0.0 && parts.first(n) == n).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::levelset::{Circle, Contour, Redistance, Redistancing, signed_distance};
    use crate::mesh::{Diagonals, rectangle};
    use crate::transport::Tracer;

    fn space(n: usize) -> Arc<Space<2>> {
        let mesh = rectangle([0.0, 0.0], [40.0, 40.0], [n, n], Diagonals::UnionJack).unwrap();
        Arc::new(Space::new(&Arc::new(mesh), Element::P2))
    }
    fn circle(space: &Space<2>, radius: f64) -> Vec<f64> {
        signed_distance(space, &Circle::new(Point::<2>::new(20.3, 19.8), radius).unwrap())
    }
    const WEIGHTS: SegmentationWeights =
        SegmentationWeights { fidelity: 1.0, length: 0.5, thickness: 4.0 };

    fn on(
        space: &Arc<Space<2>>,
        weights: SegmentationWeights,
        grey: impl Fn(&Point<2>) -> f64 + Sync,
    ) -> Segmentation<2> {
        Segmentation::new(space, grey, weights).unwrap()
    }

    #[test]
    fn pixels_are_integrated_exactly_and_the_levels_are_means() {
        // A checkerboard of pixels, two to the side of a cell.
        let space = space(20);
        let s = on(&space, WEIGHTS, |x| {
            f64::from(u8::from((x[0].floor() + x[1].floor()) % 2.0 == 0.0))
        });
        let [grey, square] =
            integrate(s.projector.basis(), Cells::All, |at| [s.grey_at(at), s.grey_at(at).powi(2)]);
        assert!((grey - 800.0).abs() < 1e-9 && (square - 800.0).abs() < 1e-9, "{grey}");
        // Half of the plane far from the line has its own level; in the band both mix evenly.
        let s = on(&space, WEIGHTS, |x| if x[0] < 20.0 { 0.75 } else { 0.25 });
        let fit = s.fit(&space.interpolate(|x| x[0] - 20.0)).unwrap();
        // From the line on 1 - H integrates to eps (1/4 - 1/pi^2).
        let mixed = 4.0 * (0.25 - 1.0 / std::f64::consts::PI.powi(2)) / 20.0 * 0.5;
        assert!((fit.levels[0] - 0.75 + mixed).abs() < 1e-4, "{:?} {mixed}", fit.levels);
        assert!(
            (fit.levels[0] + fit.levels[1] - 1.0).abs() < 1e-9 && (fit.length - 20.0).abs() < 1e-3,
            "{fit:?}"
        );
    }

    /// Along the flow `d phi/dt = -dE` the energy falls by the square of the motion,
    /// `-int (phi' - phi)^2/dt`, for both parts of the energy.
    #[test]
    fn a_small_step_goes_down_the_gradient_of_the_energy() {
        let space = space(20);
        let grey = |x: &Point<2>| {
            0.2 + 0.7 * (-(x - Point::<2>::new(26.0, 17.0)).norm_squared() / 90.0).exp()
        };
        for (fidelity, length) in [(1.0, 0.0), (1.0, 0.4), (0.1, 0.4)] {
            let mut s = on(&space, SegmentationWeights { fidelity, length, thickness: 5.0 }, grey);
            let (dt, old) = (0.02, circle(&space, 11.0));
            let mut new = old.clone();
            s.step(dt, &mut new).unwrap();
            let total = |f: SegmentationFit| f.fidelity + f.length;
            let change = total(s.fit(&new).unwrap()) - total(s.fit(&old).unwrap());
            let basis = s.projector.basis();
            let [motion] = integrate(basis, Cells::All, |at| {
                [(basis.value(at, &new) - basis.value(at, &old)).powi(2) / dt]
            });
            assert!(
                change < 0.0 && (change / -motion - 1.0).abs() < 0.02,
                "{fidelity}, {length}: {change} {motion}"
            );
        }
    }

    /// Without misfit the speed is `beta H/eps`, so that `R^2 = R0^2 - 2 beta t/eps`.
    #[test]
    fn a_circle_on_an_even_image_shrinks_by_its_curvature() {
        let space = space(20);
        let how = Redistancing { method: Redistance::Exact, volume: false };
        let shrunk = |steps: usize| {
            let mut s = on(&space, WEIGHTS, |_| 0.5);
            let mut phi = circle(&space, 12.0);
            for _ in 0..steps {
                s.step(160.0 / steps as f64, &mut phi).unwrap();
                how.apply(&Tracer::new(&space, &[]), &[], 1.0, &mut phi).unwrap();
            }
            let area = Contour::new(&space, &phi).unwrap().measures().unwrap().area;
            (144.0 - area / std::f64::consts::PI) / (2.0 * 160.0 * 0.5 / 4.0)
        };
        let [coarse, fine] = [shrunk(20), shrunk(320)];
        // Of first order in the step, until some 3 % of the band and of the mesh are left.
        assert!(
            (fine - 1.0).abs() < 0.04 && (fine - 1.0).abs() < 0.25 * (coarse - 1.0).abs(),
            "{coarse} {fine}"
        );
    }

    #[test]
    fn a_contour_that_is_gone_is_told() {
        let space = space(4);
        let s = on(&space, WEIGHTS, |x| x[0] / 40.0);
        for (sign, side) in [(1.0, "inside"), (-1.0, "outside")] {
            let e = s.levels(&vec![sign * 50.0; space.len()]).unwrap_err().to_string();
            assert!(e.contains(&format!("left {side}")), "{e}");
        }
        // A circle that shrinks to nothing, by R^2 = R0^2 - 2 beta t/eps at t = 16.
        let space = self::space(20);
        let mut s = on(&space, WEIGHTS, |_| 0.5);
        let mut phi = circle(&space, 2.0);
        let how = Redistancing { method: Redistance::Exact, volume: false };
        let gone = (0..20).find_map(|_| {
            let ended = s.step(2.0, &mut phi).err();
            how.apply(&Tracer::new(&space, &[]), &[], 1.0, &mut phi).unwrap();
            ended
        });
        let e = gone.unwrap().to_string();
        assert!(e.contains("left inside") && phi.iter().all(|v| *v >= 0.0), "{e}");
    }

    #[test]
    fn parts_of_the_inside_are_counted() {
        let space = space(20);
        let at = |x: &Point<2>, a: f64, b: f64| (x - Point::<2>::new(a, b)).norm();
        // A disc, a ring and a part that the boundary cuts.
        let phi = space.interpolate(|x| {
            (at(x, 9.0, 9.0) - 5.0)
                .min((at(x, 27.0, 25.0) - 7.0).abs() - 3.0)
                .min(at(x, 0.0, 40.0) - 6.0)
        });
        assert_eq!(parts_inside(&space, &phi), 3);
        assert_eq!(parts_inside(&space, &phi.iter().map(|v| -v).collect::<Vec<_>>()), 2);
        let cube = Space::new(
            &Arc::new(crate::mesh::box_mesh([0.0; 3], [1.0; 3], [3, 3, 3]).unwrap()),
            Element::P2,
        );
        assert_eq!(parts_inside(&cube, &cube.interpolate(|x| 0.3 - (x[2] - 0.5).abs())), 2);
    }
}
