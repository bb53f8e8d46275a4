//! Properties of a scene that the values of `[output]` depend on.

use super::fluid::Fluid;
use super::time::Time;
use crate::base::Result;
use crate::scene::keys::{Context, Item, Table};

/// A field that a scene can request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The pressure.
    Pressure,
    /// The velocity, one value for each component.
    Velocity,
    /// The magnitude of the velocity.
    Speed,
    /// The vorticity, [`Space::vorticity`](crate::fem::Space::vorticity).
    Vorticity,
    /// The level set of the only interface.
    LevelSet,
    /// The stretch of the only interface.
    Stretch,
    /// `Z1` on the only interface; in pictures of space only.
    AreaChange,
    /// `Z2` on the only interface; in pictures of space only.
    Shear,
    /// The grey levels of the segmented image; in pictures only.
    Image,
    /// A checkerboard on the only interface at rest, carried by its material; in pictures of space
    /// only.
    Checkerboard,
}

/// The cause of the motion of interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Motion {
    /// A computed flow.
    Flow,
    /// A prescribed velocity.
    Prescribed,
    /// The fit to an image, without a flow.
    Image,
}

impl Motion {
    pub fn of(fluid: &Fluid, image: bool) -> Motion {
        match (image, fluid.is_prescribed()) {
            (true, _) => Motion::Image,
            (false, true) => Motion::Prescribed,
            (false, false) => Motion::Flow,
        }
    }
}

/// Properties of the scene that the values of `[output]` depend on.
pub(in crate::scene) struct Given<'a> {
    pub time: &'a Time,
    /// Names of all interfaces.
    pub interfaces: &'a [&'a str],
    pub motion: Motion,
    /// True if backward characteristics are carried.
    pub has_map: bool,
    /// True if the strain of a surface is known, by them or carried along the interface.
    pub has_strain: bool,
    pub context: &'a Context,
}

impl Given<'_> {
    /// Rejects a quantity that the scene does not have.
    pub(in crate::scene) fn check_quantity(&self, item: &Item, quantity: Quantity) -> Result<()> {
        let n = self.interfaces.len();
        if self.motion == Motion::Image && quantity != Quantity::LevelSet {
            return Err(item
                .error(format!(
                    "there is no `{}`: an image is segmented, and nothing flows",
                    item.text()?
                ))
                .remedy("ask for level_set"));
        }
        if quantity == Quantity::Pressure && self.motion == Motion::Prescribed {
            return Err(item
                .error("there is no pressure: the velocity is prescribed and no flow is solved")
                .remedy("ask for velocity, speed, level_set or stretch"));
        }
        if matches!(quantity, Quantity::LevelSet | Quantity::Stretch) && n != 1 {
            return Err(item
                .error(format!(
                    "`{}` belongs to one interface, but the scene has {n}",
                    item.text()?
                ))
                .remedy("ask for pressure, velocity or speed"));
        }
        Ok(())
    }

    /// Rejects times that do not increase.
    pub(super) fn check_times(&self, item: &Item) -> Result<()> {
        let mut last = None;
        for item in item.list()? {
            let t = item.non_negative()?;
            if last.is_some_and(|last| last >= t) {
                return Err(item
                    .error(format!("the time {t} is not after the one before it"))
                    .remedy(format!("give rising times from 0 to {}", self.time.end)));
            }
            last = Some(t);
        }
        Ok(())
    }

    /// Rejects repeated names: columns of the series begin with the name of the measured object.
    pub(super) fn check_names(&self, table: &Table<'_>) -> Result<()> {
        let mut taken: Vec<&str> = self.interfaces.to_vec();
        for key in ["probes", "forces", "fluxes", "curves"] {
            let Some(item) = table.get(key) else { continue };
            for (name, item) in item.open_table()?.items() {
                if taken.contains(&name) {
                    return Err(item
                        .key_error(format!(
                            "the name `{name}` is taken by another output or an interface"
                        ))
                        .remedy(
                            "give every membrane, level set, probe, force, flux and curve a name \
                             of its own",
                        ));
                }
                taken.push(name);
            }
        }
        Ok(())
    }
}
