//! Construction of structures on the mesh of a scene.

use crate::base::{Error, Result, Warning, length, rounded};
use crate::elastic::{AreaLaw, Band, ContinuumForce, Membrane};
use crate::flow::Fluid;
use crate::levelset::{Interface, band_edges, check_band};
use crate::mesh::Point;
use crate::scene::schema::{MeshSource, Numerics};
use crate::scene::site::{Placed, Site};
use crate::structure::{Immersed, ImmersedInterface, Structure};

/// A structure under construction, with its keys in the scene and its data on the mesh.
pub(in crate::scene) struct Build<'a, 's, const D: usize> {
    /// The mesh with its spaces; warnings are added to it.
    pub site: &'a mut Site<'s, D>,
    /// Key of the list in the scene, and index in this list.
    pub keys: [String; 2],
    /// Signed distance of its shape, if it has one.
    pub placed: Option<Placed<D>>,
    /// Half-width of the bands.
    pub thickness: f64,
    /// Fluid inside, if it differs from that outside.
    pub inside: Option<Fluid>,
    /// Nodes on the boundary without periodic sides.
    pub walls: &'a [u32],
}

impl<const D: usize> Build<'_, '_, D> {
    /// Signed distance of its shape.
    ///
    /// # Errors
    /// Internal, for a structure without a shape.
    pub fn placed(&self) -> Result<&Placed<D>> {
        self.placed
            .as_ref()
            .ok_or_else(|| Error::internal("a structure without a shape was placed"))
    }
    /// Attaches the position of this key of the structure to an error.
    pub fn blame(&self, key: &str, error: Error) -> Error {
        self.site.script.blame(&[&self.keys[0], &self.keys[1], key], error)
    }
    /// Mean viscosity of the fluids inside and outside.
    pub fn mean_viscosity(&self) -> f64 {
        let outside = self.site.script.outside();
        0.5 * (self.inside.unwrap_or(outside).viscosity + outside.viscosity)
    }
    /// `count` equidistant points on the interface.
    ///
    /// # Errors
    /// An interface on which this is not possible.
    pub fn markers(&self, count: usize) -> Result<Vec<Point<D>>> {
        let Placed { nodal, function } = self.placed()?;
        Interface::cut(&self.site.space, &nodal[..])?.markers(&**function, count)
    }
    /// Rejects an interface that does not intersect the mesh.
    ///
    /// # Errors
    /// Such an interface.
    pub fn check_on_mesh(&self) -> Result<()> {
        if !Interface::cut(&self.site.space, &self.placed()?.nodal[..])?.points().is_empty() {
            return Ok(());
        }
        let e = Error::scene("no part of the interface lies on the mesh")
            .remedy("move the shape, or refine the mesh");
        Err(self.blame("shape", e))
    }
    /// Checks that the mesh resolves the band of the structure `name`, if it has one, and that the
    /// band does not reach the boundary. `widest` is the largest half-width of the band over the
    /// nominal one.
    ///
    /// # Errors
    /// A band that is too thin or reaches the boundary.
    pub fn check_band(&mut self, name: &str, banded: bool, widest: f64) -> Result<()> {
        let (eps, distance) = (self.thickness, self.placed()?.nodal.clone());
        let adapts = self.site.script.adapt.is_some();
        let remedy = "give a larger thickness, or shorter mesh.adapt.edge and along (adapted \
            edges reach 1.4 times what is asked for), or a mesh.adapt.width above the thickness";
        let check = if banded { check_band(&self.site.space, &distance, eps) } else { Ok(None) };
        let remedy = if adapts { Some(remedy.to_string()) } else { self.wider_shell(&distance) };
        let check = check.map_err(|e| match &remedy {
            Some(remedy) => e.remedy(remedy),
            None => e,
        });
        let check = check.and_then(|warning| {
            let advised = |w: Warning| Warning::new(w.what, remedy.unwrap_or(w.remedy));
            self.site.warnings.extend(warning.map(advised));
            let reach = if banded { eps * widest } else { 0.0 };
            let margins = self.walls.iter().map(|&n| distance[n as usize].abs());
            let margin = margins.fold(f64::INFINITY, f64::min);
            if margin > reach {
                self.warn_of_thick_band(name, reach, &distance);
                return Ok(());
            }
            if !banded {
                return Err(Error::scene(format!("`{name}` touches the boundary of the mesh"))
                    .value(format!("distance to the boundary {}", length(margin)))
                    .remedy("give a smaller shape, move it, or enlarge the mesh"));
            }
            Err(Error::scene(format!("the band of `{name}` reaches the boundary of the mesh"))
                .value(format!(
                    "half-width {}, distance to the boundary {}",
                    length(reach),
                    length(margin)
                ))
                .remedy("give a smaller thickness, move the shape, or enlarge the mesh"))
        });
        let script = self.site.script;
        let place = match script.numerics.thickness.is_some() {
            true => vec!["numerics", "thickness"],
            false => vec![&self.keys[0][..]],
        };
        check.map_err(|e| script.blame(&place, e))
    }
    /// The remedy for a band that reaches beyond the fine cells of a `ball_in_box`; `None` where
    /// cells in the band are as fine as on the interface.
    fn wider_shell(&self, distance: &[f64]) -> Option<String> {
        let MeshSource::BallInBox(ball) = &self.site.script.mesh else { return None };
        let largest = |eps| Some(band_edges(&self.site.space, distance, eps)?.largest);
        let [on_interface, in_band] = [largest(0.0)?, largest(self.thickness)?];
        let band = rounded(self.thickness + ball.edge, 3);
        (in_band > 1.1 * on_interface).then(|| {
            format!(
                "cells in the band are coarser than on the interface: give mesh.ball_in_box.band = \
                 {band}, or a smaller numerics.thickness"
            )
        })
    }
    /// A warning if the band is thicker than what it surrounds, or takes up much of it where the
    /// fluid changes across it.
    fn warn_of_thick_band(&mut self, name: &str, reach: f64, distance: &[f64]) {
        let depth = -distance.iter().copied().fold(0.0, f64::min);
        if reach <= depth {
            if self.inside.is_some() && reach > WIDE * depth {
                let what = format!(
                    "density and viscosity of `{name}` change over a band of half-width \
                     {}, {:.2} of the depth of its inside",
                    length(reach),
                    reach / depth
                );
                let advice = "its error is of first order in this ratio and may be some percent: \
                    give a smaller numerics.thickness on a finer mesh, and compare";
                self.site.warnings.push(Warning::new(what, advice));
            }
            return;
        }
        let what = format!(
            "the band of `{name}` is thicker than what it surrounds: half-width {}, largest \
             distance from the interface inside {}",
            length(reach),
            length(depth)
        );
        let advice = "give a larger shape, or a smaller numerics.thickness on a finer mesh";
        self.site.warnings.push(Warning::new(what, advice));
    }
}

/// Half-width of a band over the depth of what it surrounds, above which fluids that differ across
/// it are far from a jump.
const WIDE: f64 = 0.3;

/// A structure with its force spread over a band: by its stress, or by the continuum force if the
/// scene requests it.
pub(super) fn smeared<const D: usize>(
    interface: ImmersedInterface<D>,
    law: AreaLaw,
    (numerics, band, carries_stretch): (&Numerics, Band, bool),
) -> Box<dyn Structure<D>> {
    let (eps, slope) = (interface.thickness, interface.stretch);
    let (kernel, norm) = (numerics.kernel, numerics.width);
    if numerics.has_continuum_force() {
        let force = ContinuumForce::new(law.modulus(), eps).with_band(band, slope);
        return Immersed::boxed(interface, force.with_kernel(kernel, norm));
    }
    let force = Membrane::new(law, eps).with_band(band, slope).with_kernel(kernel, norm);
    let force = if carries_stretch { force.with_carried_stretch() } else { force };
    Immersed::boxed(interface, force)
}

/// The type of band of a structure. Default: renormalised, but carried for constant tension, where
/// a renormalised band would increase the spurious currents around a drop at rest.
pub(in crate::scene) fn band_of(numerics: &Numerics, constant_tension: bool) -> Band {
    let derived = if constant_tension { Band::Carried } else { Band::Renormalised };
    numerics.band.unwrap_or(derived)
}

/// The band of the structure `name` in words.
pub(super) fn band_words(name: &str, numerics: &Numerics, band: Band) -> String {
    let given = if numerics.band.is_some() { "" } else { " (derived)" };
    match band {
        Band::Renormalised => {
            format!("band of `{name}` renormalised{given}: of this half-width whatever the stretch")
        }
        Band::Carried => {
            let keeps = if numerics.has_continuum_force() { "" } else { " keeps the energy," };
            format!(
                "band of `{name}` carried with the fluid{given}:{keeps} of this half-width at the \
                 start"
            )
        }
    }
}
