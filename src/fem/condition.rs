//! Boundary conditions of the flow.

use crate::base::{Cause, Error, Result};
use crate::mesh::{Mesh, Point};
use nalgebra::SVector;
use std::collections::BTreeSet;
use std::sync::Arc;

/// A velocity as a function of position and time.
pub type VelocityFunction<const D: usize> =
    Arc<dyn Fn(&Point<D>, f64) -> SVector<f64, D> + Send + Sync>;

/// A number as a function of position and time.
pub type ScalarFunction<const D: usize> = Arc<dyn Fn(&Point<D>, f64) -> f64 + Send + Sync>;

/// Condition on a part of the boundary.
#[derive(Clone)]
pub enum Condition<const D: usize> {
    /// Prescribed velocity.
    Velocity(VelocityFunction<D>),
    /// Zero velocity.
    NoSlip,
    /// No flow through the wall and no tangential stress.
    Slip,
    /// No stress: `(2 mu D(u) - p) n = 0`, "do nothing".
    Open,
    /// The same with the gradient: `(mu grad u - p) n = 0`.
    Gradient,
    /// Prescribed traction: `(2 mu D(u) - p) n = t`.
    Traction(VelocityFunction<D>),
    /// Prescribed pressure: `(mu grad u - p) n = -P n`.
    Pressure(ScalarFunction<D>),
    /// The same where fluid leaves; where it comes in along the normal, `p + rho |u|^2 / 2 = P`.
    TotalPressure(ScalarFunction<D>),
    /// Periodic with the named part, which is a translate of this one.
    Periodic(String),
}

impl<const D: usize> Condition<D> {
    /// True if fluid passes under a given stress, which determines the pressure.
    pub fn is_open(&self) -> bool {
        use Condition::{Gradient, Open, Pressure, TotalPressure, Traction};
        matches!(self, Open | Gradient | Traction(_) | Pressure(_) | TotalPressure(_))
    }
    /// True if the stress is that of the gradient, `(mu grad u - p) n`.
    pub fn has_gradient(&self) -> bool {
        matches!(self, Condition::Gradient | Condition::Pressure(_) | Condition::TotalPressure(_))
    }
    /// True if a stress takes the energy of fluid back that comes in (directional do-nothing). A
    /// prescribed pressure is meant as it is given.
    pub fn is_directional(&self) -> bool {
        self.is_open() && !matches!(self, Condition::Pressure(_))
    }
}

/// Conditions by boundary name, in the order of the scene. If a facet has several names, the one
/// with the fewest facets applies, then the later one. An empty list means no slip everywhere. At a
/// node between parts each keeps its normal velocity.
pub type Conditions<const D: usize> = Vec<(String, Condition<D>)>;

/// For every facet the number of its condition, sorted by ascending priority; `None` means no slip
/// by default.
///
/// # Errors
/// A name that the mesh does not have, a facet without a condition.
pub fn condition_of_facets<const D: usize>(
    mesh: &Mesh<D>,
    conditions: &Conditions<D>,
) -> Result<Vec<(u32, Option<usize>)>> {
    let count = mesh.facets().len() as u32;
    if conditions.is_empty() {
        return Ok((0..count).map(|f| (f, None)).collect());
    }
    let mut ranked: Vec<(usize, usize)> = Vec::new();
    // A periodic condition applies to its partner too.
    let names = |k: usize| -> Vec<&String> {
        match &conditions[k] {
            (name, Condition::Periodic(other)) => vec![name, other],
            (name, _) => vec![name],
        }
    };
    for k in 0..conditions.len() {
        ranked.push((mesh.boundary(names(k)[0])?.len(), k));
    }
    ranked.sort_by_key(|&(size, k)| (std::cmp::Reverse(size), k));
    let mut rank = vec![None; count as usize];
    for (r, &(_, k)) in ranked.iter().enumerate() {
        for name in names(k) {
            for &f in mesh.boundary(name)? {
                rank[f as usize] = Some(r);
            }
        }
    }
    if let Some(f) = rank.iter().position(Option::is_none) {
        let facet = &mesh.facets()[f];
        let at: Vec<_> = mesh
            .facet_points(facet)
            .map(|v| mesh.points()[v as usize].as_slice().to_vec())
            .collect();
        let bare = (0..count).filter(|f| rank[*f as usize].is_none()).collect();
        let names = parts(mesh, bare);
        let remedy = if names.is_empty() {
            "this part has no name in the mesh: give it one (gmsh: Physical Curve or Surface), or \
             give the rest of the boundary a condition"
                .into()
        } else {
            format!("give boundary \"{}\" a condition", names.join("\", \""))
        };
        return Err(Error::scene("a part of the boundary has no condition")
            .at(format!("boundary facet of cell {} with points {at:?}", facet.cell))
            .value(if names.is_empty() { "unnamed".into() } else { names.join(", ") })
            .remedy(remedy)
            .because(Cause::BareBoundary));
    }
    let mut list: Vec<(usize, u32)> =
        rank.iter().enumerate().map(|(f, r)| (r.unwrap_or(0), f as u32)).collect();
    list.sort_unstable();
    Ok(list.into_iter().map(|(r, f)| (f, Some(ranked[r].1))).collect())
}

/// Names of boundaries, the smallest first, that together cover these facets; none where a facet
/// has no name.
fn parts<const D: usize>(mesh: &Mesh<D>, mut facets: BTreeSet<u32>) -> Vec<String> {
    let mut all: Vec<_> = mesh.boundaries().iter().collect();
    all.sort_by_key(|(name, list)| (list.len(), (*name).clone()));
    let mut found = Vec::new();
    for (name, list) in all {
        let before = facets.len();
        list.iter().for_each(|f| {
            facets.remove(f);
        });
        if facets.len() < before {
            found.push(name.clone());
        }
    }
    if facets.is_empty() { found } else { Vec::new() }
}
