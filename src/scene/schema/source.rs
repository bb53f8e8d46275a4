//! What the values of `[output]` must agree with: the times, the interfaces, and what the scene has to show.

use super::fluid::Fluid;
use super::time::Time;
use crate::base::Result;
use crate::scene::keys::{Context, Item, Table, named};

/// A field that can be asked for.
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
    /// The level set of the one interface.
    LevelSet,
    /// The stretch of the one interface.
    Stretch,
    /// `Z1` on the one interface; in pictures of space alone.
    AreaChange,
    /// `Z2` on the one interface; in pictures of space alone.
    Shear,
    /// The grey levels of the image that is segmented; in pictures alone.
    Image,
    /// A checkerboard on the one interface when it is at rest, which its material carries; in pictures of space alone.
    Checkerboard,
}

/// What moves interfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Motion {
    /// A flow that is solved.
    Flow,
    /// A velocity that is given.
    Prescribed,
    /// The fit to an image; nothing flows.
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

/// The table `[output]`, if there is one, and what its values must agree with.
pub(in crate::scene) struct Source<'a> {
    pub table: Option<Table<'a>>,
    pub time: &'a Time,
    pub interfaces: &'a [&'a str],
    /// Whether there is a flow.
    pub motion: Motion,
    /// Whether backward characteristics are carried.
    pub has_map: bool,
    pub context: &'a Context,
}

impl<'a> Source<'a> {
    pub fn optional<T>(&self, key: &str, read: impl FnOnce(&Item<'a>) -> Result<T>) -> Result<Option<T>> {
        self.table.as_ref().map_or(Ok(None), |t| t.optional(key, read))
    }

    pub fn named<T>(&self, key: &str, read: impl Fn(String, &Item) -> Result<T>) -> Result<Vec<T>> {
        Ok(self.optional(key, |i| named(i, read))?.unwrap_or_default())
    }

    /// An interval or `false`; by default the run is cut into `parts`.
    pub fn interval_or_none(&self, key: &str, parts: f64) -> Result<Option<f64>> {
        let given = self.optional(key, |i| unless_false(i, Item::positive))?;
        Ok(given.unwrap_or_else(|| {
            Some((self.time.end / parts).max(if self.time.tolerance.is_some() { 0.0 } else { self.time.step }))
        }))
    }

    /// A quantity that the scene has.
    pub fn possible(&self, item: &Item, quantity: Quantity) -> Result<Quantity> {
        let n = self.interfaces.len();
        if self.motion == Motion::Image && quantity != Quantity::LevelSet {
            return Err(item
                .error(format!("there is no `{}`: an image is segmented, and nothing flows", item.text()?))
                .remedy("ask for level_set"));
        }
        if quantity == Quantity::Pressure && self.motion == Motion::Prescribed {
            return Err(item
                .error("there is no pressure: the velocity is prescribed and no flow is solved")
                .remedy("ask for velocity, speed, level_set or stretch"));
        }
        if matches!(quantity, Quantity::LevelSet | Quantity::Stretch) && n != 1 {
            return Err(item
                .error(format!("`{}` belongs to one interface, but the scene has {n}", item.text()?))
                .remedy("ask for pressure, velocity or speed"));
        }
        Ok(quantity)
    }
}

/// `None` for `false`, else what `read` gives.
pub(super) fn unless_false<'a, T>(item: &Item<'a>, read: impl FnOnce(&Item<'a>) -> Result<T>) -> Result<Option<T>> {
    if item.is_false() { Ok(None) } else { read(item).map(Some) }
}
