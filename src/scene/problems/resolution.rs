//! Structures that the mesh no longer resolves.

use crate::base::{Result, Warning, length};
use crate::fem::SurfacePoint;
use crate::levelset::{band_edges, check_band, surface};
use crate::sim::Simulation;
use crate::structure::{Density, Structure};

/// Slope of a distance, over what it should be, below which the two sides of an interface share a
/// cell.
const SHARED_CELL: f64 = 0.5;

/// Stretch below which a membrane that resists compression is told to be compressed.
const LEAST_STRETCH: f64 = 0.95;
/// Negative concentration over the largest that is told.
const NEGATIVE: f64 = 0.01;

/// The acting structures of a flow that the mesh does not resolve, with what is wrong and a remedy:
/// an interface that is not cut, a band that is too thin for its cells, a radius below their edges,
/// a gap to a wall below an edge. `walls` are nodes on walls, with the edges there.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn unresolved<const D: usize>(
    sim: &Simulation<D>,
    (thickness, walls): (Option<f64>, &[(u32, f64)]),
    wrinkles: impl Fn(usize) -> bool,
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
        if let Some(warning) = s.distrust(space, fields)? {
            found.push((name.to_string(), warning));
            continue;
        }
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
            } else if let Some((gap, h)) = narrowest(phi, s.slope(), walls) {
                tell(
                    format!(
                        "The fluid between `{name}` and the boundary, {} wide, is not resolved by \
                         edges of {}",
                        length(gap),
                        length(h)
                    ),
                    "Take a finer mesh there, or a wider domain",
                );
            } else if s.keeps_distance() {
                let points = surface(space, phi)?;
                let slope =
                    |p: &SurfacePoint<D>| space.gradient(phi, p.at.cell, &p.at.barycentric).norm();
                // Only a level set that is kept a distance can tell by its slope.
                let kept = sim.carried().keeps_distances();
                let flattest = points.iter().map(slope).fold(f64::INFINITY, f64::min);
                if kept && flattest < SHARED_CELL * s.slope() {
                    tell(
                        format!("`{name}` has tips or folds that are thinner than the mesh"),
                        "Take a finer mesh where they are: its stretch and force are wrong there",
                    );
                } else if let Some((id, of)) = s.surface_density() {
                    let values = fields.scalar(id);
                    let value =
                        |p: &SurfacePoint<D>| space.value(values, p.at.cell, &p.at.barycentric);
                    let densities = points.iter().map(value);
                    if let Some((what, remedy)) = of_density(of, densities, wrinkles(k)) {
                        tell(format!("`{name}` {what}"), remedy);
                    }
                }
            }
        }
    }
    Ok(found)
}

/// Gap over the longest edge of its cells, below which no node lies in it.
const GAP: f64 = 0.5;

/// The narrowest gap between an interface and a wall that the edges there do not resolve, with the
/// edge.
fn narrowest(phi: &[f64], slope: f64, walls: &[(u32, f64)]) -> Option<(f64, f64)> {
    let gaps = walls.iter().filter_map(|(n, h)| Some((phi.get(*n as usize)? / slope, *h)));
    gaps.filter(|(gap, h)| *gap < GAP * h).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// What is wrong with the density that an interface carries, and a remedy.
fn of_density(
    of: Density,
    densities: impl Iterator<Item = f64>,
    wrinkles: bool,
) -> Option<(String, &'static str)> {
    let (least, most) = densities
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), m| (low.min(m), high.max(m)));
    match of {
        Density::Rest if wrinkles && most * LEAST_STRETCH > 1.0 => Some((
            format!("is compressed, to a stretch of {:.3}", 1.0 / most),
            "Without bending stiffness it wrinkles, as finely as the mesh lets it: take a membrane \
             under tension from the start (stretch), or, where its wrinkles do not count, a law \
             that does not resist compression (area.one_sided) with a finer mesh",
        )),
        Density::Concentration if least < -NEGATIVE * most => Some((
            format!("has a negative concentration, {least:.3} where the largest is {most:.3}"),
            "Take a finer mesh, a smoother concentration at the start, or more diffusivity",
        )),
        _ => None,
    }
}

/// True if a force, or properties of fluids, are spread over a band.
fn has_band<const D: usize>(s: &dyn Structure<D>) -> bool {
    s.reach() > 0.0 || s.held().is_some_and(|h| h.fluid.is_some() || h.surface_mass > 0.0)
}
