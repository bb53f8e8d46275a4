//! The regularised interface: delta and Heaviside functions, regularised density and viscosity.

use crate::base::{Error, Result, Warning, length, rounded};
use crate::fem::Space;
use nalgebra::SVector;
use std::f64::consts::PI;

/// The cut-off function `zeta(s) = (1 + cos(pi s)) / 2` for `|s| < 1`, 0 elsewhere (book, section
/// 3.6). Its integral is 1.
pub fn zeta(s: f64) -> f64 {
    if s.abs() < 1.0 { 0.5 * (1.0 + (PI * s).cos()) } else { 0.0 }
}

/// The integral of [`zeta`] from -1 to `s`: 0 for `s <= -1`, 1 for `s >= 1`.
pub fn heaviside(s: f64) -> f64 {
    let s = s.clamp(-1.0, 1.0);
    (0.5 * (1.0 + s + (PI * s).sin() / PI)).clamp(0.0, 1.0)
}

/// The cut-off function of the band: even, of integral 1, zero beyond 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kernel {
    /// [`zeta`], `(1 + cos(pi s))/2`.
    #[default]
    Cosine,
    /// `1 - |s|`. With the l1 width, and a half-width that is a whole number of steps, its sums
    /// over a square lattice meet the moment conditions of Engquist, Tornberg and Tsai (2005) to
    /// second order.
    Hat,
}

impl Kernel {
    /// The value at `s`.
    pub fn value(self, s: f64) -> f64 {
        match self {
            Kernel::Cosine => zeta(s),
            Kernel::Hat => (1.0 - s.abs()).max(0.0),
        }
    }
    /// The integral from -1 to `s`.
    pub fn heaviside(self, s: f64) -> f64 {
        match self {
            Kernel::Cosine => heaviside(s),
            Kernel::Hat => {
                let tail = 0.5 * (1.0 - s.abs()).max(0.0).powi(2);
                if s < 0.0 { tail } else { 1.0 - tail }
            }
        }
    }
    /// The weight `zeta(phi/(r eps))/(r eps)`, zero outside the band `|phi| < r eps`; see
    /// [`surface_weight`].
    pub fn weight(self, phi: f64, r: f64, eps: f64) -> f64 {
        let width = r * eps;
        // False for width = 0 and for NaN.
        if phi.abs() < width { self.value(phi / width) / width } else { 0.0 }
    }
}

/// The renormalised weight `w = zeta(phi / (r eps)) / (r eps)` of the membrane stress (3.16), with
/// `r = |grad phi|`.
///
/// `phi / r` is a distance to first order for any stretch (the renormalisation of (1.32)-(1.35)),
/// so `w r = zeta(phi / (r eps)) / eps` is the surface delta of half-width `eps` in space.
///
/// As `r` tends to 0 (kinks of the distance on the medial axis, where a `P2` gradient passes
/// through 0) the band `|phi| < r eps` closes and the weight is 0; it is never NaN. It is unbounded
/// only where `phi` and its gradient vanish together, that is where two interfaces merge.
pub fn surface_weight(phi: f64, r: f64, eps: f64) -> f64 {
    Kernel::Cosine.weight(phi, r, eps)
}

/// Norm of the slope of a renormalised band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// `|grad phi|`: the band has the half-width `eps` in space.
    #[default]
    L2,
    /// The sum of the moduli of the components (Engquist, Tornberg and Tsai 2005; book, section
    /// 1.5.2): the band has the half-width `eps` along the axes, and `eps sqrt(D)` across an
    /// interface along a diagonal.
    L1,
}

impl Norm {
    /// The norm of a gradient.
    pub fn of<const D: usize>(self, gradient: &SVector<f64, D>) -> f64 {
        match self {
            Norm::L2 => gradient.norm(),
            Norm::L1 => gradient.iter().map(|g| g.abs()).sum(),
        }
    }
    /// Largest norm of a unit vector in `d` dimensions.
    pub fn largest(self, d: usize) -> f64 {
        match self {
            Norm::L2 => 1.0,
            Norm::L1 => (d as f64).sqrt(),
        }
    }
}

/// Regularised density (3.19):
/// `inside + H(phi/eps) (outside - inside) + zeta(phi/eps) surface_mass / eps`.
///
/// `surface_mass` is the mass of the membrane per unit length (2-D) or area (3-D) at rest;
/// `|grad phi| zeta(phi/eps) / eps` is the surface delta, so stretching the membrane by
/// `|grad phi|` thins it by the same factor and keeps its mass.
pub fn density(phi: f64, eps: f64, inside: f64, outside: f64, surface_mass: f64) -> f64 {
    inside + heaviside(phi / eps) * (outside - inside) + zeta(phi / eps) / eps * surface_mass
}

/// Regularised viscosity: `inside + H(phi/eps) (outside - inside)`.
pub fn viscosity(phi: f64, eps: f64, inside: f64, outside: f64) -> f64 {
    inside + heaviside(phi / eps) * (outside - inside)
}

/// Half-width of the band, in edge lengths, below which a run is rejected (and a larger one below
/// which there is a warning).
const REFUSED: f64 = 1.5;
const DOUBTFUL: f64 = 2.5;

/// Checks that the mesh resolves the band of half-width `eps`.
///
/// `h` is the largest edge length of the cells that meet the band `|phi| < eps |grad phi|` at one
/// of their nodes, or the interface. The edge length of a cell is its `D`-th shortest edge: that of
/// an equilateral triangle, the leg of a right-angled one; in cells elongated along the interface
/// their extent across it. There is a warning for `eps < 2.5 h` and an error for `eps < 1.5 h`: the
/// thinner the band, the more its weight depends on its position in the mesh (error of the
/// perimeter of a circle with the rule of degree 4: 8e-6 at `2.5 h`, 7e-5 at `1.5 h`, 3e-4 at `h`,
/// 4e-3 at `h/2`, 4e-2 at `h/4`), which produces spurious work.
///
/// # Errors
/// Names the cell, its position, `eps`, `h`, and the sufficient thickness or refinement.
pub fn check_band<const D: usize>(
    space: &Space<D>,
    phi: &[f64],
    eps: f64,
) -> Result<Option<Warning>> {
    if !(eps > 0.0 && eps.is_finite()) {
        return Err(Error::scene("the thickness of the band must be positive").value(eps));
    }
    let Some(BandEdges { largest: h, cell, .. }) = band_edges(space, phi, eps) else {
        return Ok(None);
    };
    // A ratio equal to the limit, such as 0.1 on a mesh of 2/30, may be below it by rounding.
    let ratio = eps / h * (1.0 + 1e-12);
    if ratio >= DOUBTFUL {
        return Ok(None);
    }
    let vertices = space.mesh().cell(cell);
    let centre =
        vertices.iter().map(|&v| space.mesh().points()[v as usize]).sum::<crate::mesh::Point<D>>()
            / (D as f64 + 1.0);
    let at: Vec<String> = centre.iter().map(|x| length(*x)).collect();
    let place = format!("cell {cell} (counted from 0) at [{}]", at.join(", "));
    let value = format!(
        "half-width eps = {}, edge length h = {}, eps / h = {:.3}",
        rounded(eps, 6),
        length(h),
        eps / h
    );
    let remedy = |limit: f64| {
        format!(
            "set thickness >= {}, or refine the mesh around the interface to edges <= {} (for a \
             generated mesh: {:.2} times as many cells in each direction)",
            length(limit * h),
            length(eps / limit),
            limit * h / eps
        )
    };
    if ratio < REFUSED {
        return Err(Error::scene(format!(
            "the band is thinner than the mesh allows: eps must be at least {REFUSED} h"
        ))
        .at(place)
        .value(value)
        .remedy(remedy(DOUBTFUL)));
    }
    Ok(Some(Warning::new(
        format!(
            "the band is barely resolved: eps should be at least {DOUBTFUL} h; {value}, {place}"
        ),
        remedy(DOUBTFUL),
    )))
}

/// The edges of the mesh in a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandEdges {
    /// Length in the finest cell.
    pub smallest: f64,
    /// Length in the coarsest cell.
    pub largest: f64,
    /// The coarsest cell.
    pub cell: usize,
}

/// The edges of the cells that meet the band `|phi| < r eps`; `None` if there are none. The length
/// of a cell is its `D`-th shortest edge: the leg of a right triangle.
pub fn band_edges<const D: usize>(space: &Space<D>, phi: &[f64], eps: f64) -> Option<BandEdges> {
    let mut found: Option<BandEdges> = None;
    for cell in (0..space.mesh().cell_count()).filter(|&c| meets_band(space, phi, eps, c)) {
        let h = edge_length(space, phi, cell);
        let edges = found.get_or_insert(BandEdges { smallest: h, largest: h, cell });
        edges.smallest = edges.smallest.min(h);
        if h > edges.largest {
            (edges.largest, edges.cell) = (h, cell);
        }
    }
    found
}

/// True if a node of cell `c` lies in the band, or the interface passes between its nodes.
fn meets_band<const D: usize>(space: &Space<D>, phi: &[f64], eps: f64, c: usize) -> bool {
    let nodes = space.cell_nodes(c);
    let negative = phi[nodes[0] as usize] < 0.0;
    nodes.iter().enumerate().any(|(a, &node)| {
        let value = phi[node as usize];
        (value < 0.0) != negative
            || value.abs() < eps * space.gradient(phi, c, &space.element().node(a, D)).norm()
    })
}

/// Ratio of the longest to the shortest edge above which a cell counts as elongated.
const DRAWN_OUT: f64 = 1.5;

/// The length that resolves a band in cell `c`: its `D`-th shortest edge or, in an elongated cell,
/// its extent along the gradient of `phi`, if that is less.
fn edge_length<const D: usize>(space: &Space<D>, phi: &[f64], c: usize) -> f64 {
    let (mesh, v) = (space.mesh(), space.mesh().cell(c));
    let point = |a: usize| mesh.points()[v[a] as usize];
    let mut edges: Vec<f64> = (0..=D)
        .flat_map(|a| (0..a).map(move |b| (a, b)))
        .map(|(a, b)| (point(a) - point(b)).norm())
        .collect();
    edges.sort_by(f64::total_cmp);
    let (shortest, usual, longest) = (edges[0], edges[D - 1], edges[edges.len() - 1]);
    if longest <= DRAWN_OUT * shortest {
        return usual;
    }
    let mut centre = [0.0; 4];
    centre[..=D].fill(1.0 / (D + 1) as f64);
    let gradient = space.gradient(phi, c, &centre);
    let along = |a: usize| gradient.dot(&point(a)) / gradient.norm();
    let (low, high) = (0..=D)
        .map(along)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    // Without a gradient the extent is NaN, and `max` gives the shortest edge.
    usual.min((high - low).max(shortest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Element, Rule};
    use crate::levelset::{Circle, signed_distance};
    use crate::mesh::{Diagonals, Point, rectangle};
    use proptest::prelude::*;
    use std::sync::Arc;

    fn circle(n: usize, stretch: f64) -> (Space<2>, Vec<f64>) {
        let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [n, n], Diagonals::Right).unwrap());
        let space = Space::new(&mesh, Element::P2);
        let shape = Circle::new(Point::<2>::new(1.02, 0.97), 0.6).unwrap();
        let phi = signed_distance(&space, &shape).iter().map(|d| stretch * d).collect();
        (space, phi)
    }

    #[test]
    fn the_band_of_a_stretched_circle_weighs_its_perimeter() {
        // Renormalisation: the result must not depend on the stretch.
        for stretch in [0.5, 1.0, 1.7] {
            let (space, phi) = circle(60, stretch);
            let rule = Rule::simplex(2, 6);
            let mut sum = 0.0;
            for c in 0..space.mesh().cell_count() {
                for (l, w) in rule.points.iter().zip(&rule.weights) {
                    let r = space.gradient(&phi, c, l).norm();
                    sum += w
                        * space.mesh().map(c).volume
                        * surface_weight(space.value(&phi, c, l), r, 0.1)
                        * r;
                }
            }
            let exact = std::f64::consts::TAU * 0.6;
            assert!((sum / exact - 1.0).abs() < 2e-5, "{stretch}: {}", sum / exact - 1.0);
        }
    }

    /// Largest error of the weight of the band around circles in ten places of the mesh, by the
    /// rule of degree 4.
    fn error_of_the_weight(eps_over_h: f64) -> f64 {
        let rule = Rule::simplex(2, 4);
        let mesh = Arc::new(rectangle([0.0, 0.0], [2.0, 2.0], [30, 30], Diagonals::Right).unwrap());
        let space = Space::new(&mesh, Element::P2);
        let error = |i: i32| {
            let centre = Point::<2>::new(1.0 + 0.0067 * f64::from(i), 1.0 - 0.011 * f64::from(i));
            let phi = signed_distance(&space, &Circle::new(centre, 0.6).unwrap());
            let weight = |c: usize, l: &[f64; 4]| {
                let r = space.gradient(&phi, c, l).norm();
                surface_weight(space.value(&phi, c, l), r, eps_over_h / 15.0)
                    * r
                    * mesh.map(c).volume
            };
            let cell = |c| {
                rule.points.iter().zip(&rule.weights).map(|(l, w)| w * weight(c, l)).sum::<f64>()
            };
            ((0..mesh.cell_count()).map(cell).sum::<f64>() / (1.2 * PI) - 1.0).abs()
        };
        (0..10).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn a_thin_band_weighs_what_its_place_in_the_mesh_makes_it() {
        let errors = [0.25, 0.5, 1.0, 1.5, 2.5].map(error_of_the_weight);
        for (error, (low, high)) in errors.into_iter().zip([
            (0.02, 0.1),
            (2e-3, 1e-2),
            (1e-4, 1e-3),
            (2e-5, 2e-4),
            (0.0, 2e-5),
        ]) {
            assert!(error >= low && error < high, "{errors:?}");
        }
    }

    #[test]
    fn density_and_viscosity_take_their_values_far_away() {
        assert_eq!(density(-0.2, 0.1, 1.0, 3.0, 5.0), 1.0);
        assert_eq!(density(0.2, 0.1, 1.0, 3.0, 5.0), 3.0);
        assert_eq!(density(0.0, 0.1, 1.0, 3.0, 5.0), 2.0 + 50.0);
        assert_eq!(viscosity(-1.0, 0.1, 0.01, 0.1), 0.01);
        assert_eq!(viscosity(1.0, 0.1, 0.01, 0.1), 0.1);
    }

    #[test]
    fn a_vanishing_gradient_gives_no_weight() {
        for (phi, r) in [(0.0, 0.0), (1e-3, 0.0), (0.3, 1e-300), (f64::NAN, 1.0), (0.0, f64::NAN)] {
            assert_eq!(surface_weight(phi, r, 0.1), 0.0);
        }
        assert_eq!(surface_weight(0.0, 2.0, 0.25), 2.0);
    }

    #[test]
    fn a_band_thinner_than_the_mesh_allows_is_refused_where_it_is() {
        let (space, phi) = circle(20, 1.0);
        // h = 0.1: refused below 0.15, doubtful below 0.25.
        let error = check_band(&space, &phi, 0.149).unwrap_err().to_string();
        for part in ["cell ", "eps = 0.149", "h = 0.1000", "thickness >= 0.2500", "edges <= 0.0596"]
        {
            assert!(error.contains(part), "{part} is missing in {error}");
        }
        assert!(check_band(&space, &phi, 0.15).unwrap().unwrap().to_string().contains("2.5 h"));
        assert!(check_band(&space, &phi, 0.249).unwrap().is_some());
        assert!(check_band(&space, &phi, 0.25).unwrap().is_none());
        assert!(check_band(&space, &phi, 0.0).is_err());
        assert!(check_band(&space, &phi, f64::NAN).is_err());
        // A band that passes between the nodes is seen by the change of sign.
        assert!(check_band(&space, &phi, 1e-6).is_err());
    }

    proptest! {
        #[test]
        fn the_heaviside_function_integrates_the_delta(s in -1.5..1.5f64) {
            let n = 400;
            let h = (s + 1.0) / n as f64;
            let sum: f64 = (0..n).map(|k| zeta(-1.0 + (k as f64 + 0.5) * h) * h).sum();
            let integral = if s < -1.0 { 0.0 } else { sum };
            prop_assert!((heaviside(s) - integral).abs() < 1e-4);
            prop_assert!((heaviside(s) + heaviside(-s) - 1.0).abs() < 1e-15);
        }

        /// The mass of the membrane does not change when it is stretched.
        #[test]
        fn the_surface_mass_follows_the_stretch(r in 0.3..3.0f64, m in 0.0..10.0f64) {
            let (n, eps) = (2000, 0.1);
            let width = 2.0 * eps / r;
            let mass: f64 = (0..n)
                .map(|k| (k as f64 + 0.5) / n as f64 * width - 0.5 * width)
                .map(|d| (density(r * d, eps, 0.0, 0.0, m)) * width / n as f64)
                .sum();
            prop_assert!((mass - m / r).abs() < 1e-9 * (1.0 + m));
        }
    }
}
