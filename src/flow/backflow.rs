//! Fluid that comes back in through an open side.

use super::boundary::over_boundary;
use super::term::{MomentumTerm, Support};
use crate::fem::{At, Space, VectorForm};
use crate::mesh::{Location, Point};
use nalgebra::{SMatrix, SVector};

/// A point, the outward normal, and the number of the condition.
type Site<const D: usize> = (At<D>, SVector<f64, D>, usize);

/// The directional do-nothing condition on open sides,
/// `(2 mu D(u) - p) n = rho min(u . n, 0) u / 2`.
///
/// Where fluid leaves it is the condition without stress. Where fluid comes in, that condition
/// bounds no energy: what comes in brings `rho |u|^2 / 2`, and the flow may grow without end. The
/// stress above takes this energy back. In a step it is the form
/// `C(u, v) = int rho max(-u* . n, 0) u . v / 2 ds`, symmetric and not negative, with the velocity
/// `u*` extrapolated from earlier steps.
///
/// Source: M. Braack and P. B. Mucha, Directional do-nothing condition for the Navier-Stokes
/// equations, J. Comput. Math. 32 (2014) 507.
#[derive(Clone, Debug, Default)]
pub struct Backflow<const D: usize> {
    /// Quadrature points on the open sides, with the outward normals and the conditions; `q`
    /// counts them.
    sites: Vec<Site<D>>,
    /// `rho max(-u* . n, 0) / 2` at each.
    rates: Vec<f64>,
    /// Velocity of the explicit part of the step at each.
    start: Vec<SVector<f64, D>>,
    /// The points where the rate is not zero.
    points: Vec<At<D>>,
}

impl<const D: usize> Backflow<D> {
    /// The term on these facets, each with the number of its condition.
    pub fn new(space: &Space<D>, mut facets: Vec<(u32, usize)>) -> Backflow<D> {
        let mesh = space.mesh();
        facets.sort_by_key(|(f, _)| mesh.facets()[*f as usize].cell);
        let mut sites = Vec::new();
        for (number, condition) in facets {
            over_boundary(mesh, &[number], |facet, l, weight| {
                let (cell, barycentric) = (facet.cell as usize, *l);
                let x = mesh.point_at(&Location { cell: facet.cell, barycentric });
                let at = At { cell, q: sites.len(), barycentric, x, weight };
                sites.push((at, mesh.facet_normal(facet).0, condition));
            });
        }
        Backflow { sites, ..Backflow::default() }
    }
    /// Takes the rates for the density (by cell and barycentric coordinates) and the velocity `u*`
    /// of a step whose explicit part is taken at `start` (zero for `None`).
    pub fn prepare(
        &mut self,
        space: &Space<D>,
        density: impl Fn(usize, &[f64; 4]) -> f64,
        u: &[SVector<f64, D>],
        start: Option<&[SVector<f64, D>]>,
    ) {
        let rate = |(at, n, _): &Site<D>| {
            let inward = -space.value(u, at.cell, &at.barycentric).dot(n);
            // The density at points of inflow only: it may be costly.
            if inward > 0.0 { 0.5 * inward * density(at.cell, &at.barycentric) } else { 0.0 }
        };
        let rates = self.sites.iter().map(rate).collect();
        self.set_rates(rates);
        let at_site = |(at, ..): &Site<D>| {
            start.map_or(SVector::zeros(), |u| space.value(u, at.cell, &at.barycentric))
        };
        self.start = self.sites.iter().map(at_site).collect();
    }
    /// Sets the rates, for a matrix that is assembled again; as many as there are points, or none.
    pub fn set_rates(&mut self, mut rates: Vec<f64>) {
        rates.resize(self.sites.len(), 0.0);
        let inflow = self.sites.iter().zip(&rates).filter(|(_, rate)| **rate > 0.0);
        self.points = inflow.map(|((at, ..), _)| *at).collect();
        self.rates = rates;
        self.start = vec![SVector::zeros(); self.sites.len()];
    }
    /// The rates.
    pub fn rates(&self) -> &[f64] {
        &self.rates
    }
    /// True if there is no open side.
    pub fn is_empty(&self) -> bool {
        self.sites.is_empty()
    }
    /// True if fluid comes in anywhere.
    pub fn is_active(&self) -> bool {
        !self.points.is_empty()
    }
    /// Power of the term in a step with the new velocity `u`: not positive.
    pub fn power(&self, space: &Space<D>, u: &[SVector<f64, D>]) -> f64 {
        let of = |at: &At<D>| {
            -at.weight * self.rates[at.q] * space.value(u, at.cell, &at.barycentric).norm_squared()
        };
        self.points.iter().map(of).sum()
    }
    /// The greatest speed into the domain through the sides whose conditions are `told`, and the
    /// condition and the point where it is.
    pub fn greatest(
        &self,
        space: &Space<D>,
        u: &[SVector<f64, D>],
        told: impl Fn(usize) -> bool,
    ) -> Option<(f64, usize, Point<D>)> {
        let speed = |(at, n, condition): &Site<D>| {
            (-space.value(u, at.cell, &at.barycentric).dot(n), *condition, at.x)
        };
        self.greatest_by(|site| if told(site.2) { speed(site) } else { (0.0, site.2, site.0.x) })
    }
    /// The same of the speed with which fluid comes in and goes along the side, whichever is less.
    pub fn greatest_oblique(
        &self,
        space: &Space<D>,
        u: &[SVector<f64, D>],
    ) -> Option<(f64, usize, Point<D>)> {
        self.greatest_by(|(at, n, condition)| {
            let v = space.value(u, at.cell, &at.barycentric);
            let inward = -v.dot(n);
            (inward.min((v + n * inward).norm()), *condition, at.x)
        })
    }
    fn greatest_by(
        &self,
        speed: impl Fn(&Site<D>) -> (f64, usize, Point<D>),
    ) -> Option<(f64, usize, Point<D>)> {
        self.sites.iter().map(speed).filter(|s| s.0 > 0.0).max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

impl<const D: usize> MomentumTerm<D> for Backflow<D> {
    fn support(&self) -> Support<'_, D> {
        Support::Points(&self.points)
    }
    fn force(&self, at: &At<D>) -> VectorForm<D> {
        (self.start[at.q] * -self.rates[at.q], SMatrix::zeros())
    }
    fn is_implicit(&self) -> bool {
        true
    }
    fn stiffness(
        &self,
        at: &At<D>,
        u: &SVector<f64, D>,
        _grad_u: &SMatrix<f64, D, D>,
    ) -> VectorForm<D> {
        (u * self.rates[at.q], SMatrix::zeros())
    }
}
