//! Structures that the mesh no longer resolves.

use crate::base::{Result, Warning};
use crate::fem::{Space, SurfacePoint};
use crate::levelset::{band_edges, check_band, surface};
use crate::sim::Simulation;
use crate::structure::Structure;

/// Slope of a distance, over what it should be, below which the two sides of an interface share a
/// cell.
const FLATTEST: f64 = 0.5;

/// The acting structures of a flow that the mesh does not resolve, with what is wrong and a remedy:
/// an interface that is not cut, a band that is too thin for its cells, a radius below their edges.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn unresolved<const D: usize>(
    sim: &Simulation<D>,
    thickness: Option<f64>,
) -> Result<Vec<(String, Warning)>> {
    let (space, fields) = (sim.space(), &sim.state().fields);
    let leaving: Vec<&str> = sim.leaving().collect();
    let mut found = Vec::new();
    for (k, s) in sim.structures().iter().enumerate() {
        let Some(id) = s.level_set().filter(|_| s.acts() && !leaving.contains(&s.name())) else {
            continue;
        };
        let (name, phi) = (s.name(), fields.scalar(id));
        let mut tell = |what: String, remedy: &str| {
            found.push((name.to_string(), Warning::new(what, remedy)));
        };
        let Some(edges) = band_edges(space, phi, 0.0) else {
            tell(
                format!("The interface of `{name}` crosses no cell of the mesh"),
                "Take a finer mesh or smaller steps: it exerts no force",
            );
            continue;
        };
        let eps = thickness.filter(|_| has_band(&**s)).unwrap_or(0.0);
        if let Some(Err(e)) = (eps > 0.0).then(|| check_band(space, phi, eps)) {
            tell(
                format!("The band of `{name}` is too thin for the mesh ({})", e.wrong_value()),
                "Take a larger numerics.thickness, or a finer mesh where the structure goes",
            );
        } else if s.reach() == 0.0
            && let Some(m) = sim.carried().interface(fields, k)?.measures()
        {
            // The radius of a circle or sphere with the same ratio of inside and interface.
            let radius = D as f64 * m.enclosed / m.own;
            if radius < edges.largest {
                let h = edges.largest;
                tell(
                    format!("`{name}`, of radius {radius:.3}, is not resolved by edges of {h:.3}"),
                    "Take a finer mesh where the structure goes",
                );
            } else if s.keeps_distance() {
                let flattest = flattest(space, phi)? / s.slope();
                if flattest < FLATTEST {
                    tell(
                        format!("`{name}` has tips or folds that are thinner than the mesh"),
                        "Take a finer mesh where they are: its stretch and force are wrong there",
                    );
                }
            }
        }
    }
    Ok(found)
}

/// Least slope of a level set on its interface.
fn flattest<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<f64> {
    let slope = |p: &SurfacePoint<D>| space.gradient(phi, p.at.cell, &p.at.barycentric).norm();
    Ok(surface(space, phi)?.iter().map(slope).fold(f64::INFINITY, f64::min))
}

/// True if a force, or properties of fluids, are spread over a band.
fn has_band<const D: usize>(s: &dyn Structure<D>) -> bool {
    s.reach() > 0.0 || s.held().is_some_and(|h| h.fluid.is_some() || h.surface_mass > 0.0)
}
