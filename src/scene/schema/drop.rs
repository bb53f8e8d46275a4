//! `[[drop]]`: a fluid in another one, with surface tension between them.

use super::keys::{Absent::*, Keys, Kind::*, row};
use super::membrane::{CHORD, FORCE_WORDS, FORCES, Membrane, RING, cuts};
use super::names::{distinct, identifier};
use super::shape::{self, Shape};
use super::write::{Writer, name as word, number, text};
use crate::base::Result;
use crate::elastic::{AreaFrom, AreaLaw, Force};
use crate::scene::item::{Context, Item};

/// The fluid of a drop or bubble, where it is not that of `[fluid]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// Mass per volume.
    pub density: Option<f64>,
    /// Dynamic viscosity.
    pub viscosity: Option<f64>,
}

pub(super) static KEYS: Keys = Keys {
    about: "A drop or a bubble: a fluid in another one. What lies in several is of the last of them. Drops of one shape, a union, merge; \
            interfaces of two drops do not see each other.",
    keys: &[
        row("name", Value("text"), "", Default("\"drop\""), "Its name in results; unique in the scene."),
        row("shape", Table(&shape::KEYS), "", Required, "Its form at time 0."),
        row("tension", Value("number >= 0"), "N/m", Default("0.0"), "Surface tension."),
        row(
            "density",
            Value("number >= 0"),
            "kg/m3",
            Derived("that of the fluid"),
            "Mass per volume of what is inside.",
        ),
        row(
            "viscosity",
            Value("number > 0"),
            "Pa s",
            Derived("that of the fluid"),
            "Dynamic viscosity of what is inside.",
        ),
        row(
            "force",
            Choice(&FORCE_WORDS),
            "",
            Derived("\"sharp\"; \"smeared\" where `numerics.surface_tension` or the semi-implicit coupling is given"),
            "Where surface tension acts: on the interface itself, cut out of the cells, or over a band of half-width `numerics.thickness`.",
        ),
        row("chords", Named(&CHORD), "", Optional, "Lines along which the contour is measured."),
        row(
            "rings",
            Named(&RING),
            "",
            Optional,
            "Planes through the surface in which its form is measured; in space alone.",
        ),
    ],
};

/// All drops, in the order of the scene. `membranes` are those read before, whose names are taken; `banded` says whether surface tension is that of a
/// scheme which spreads it over a band.
pub(super) fn read(
    item: Option<Item>,
    membranes: &[Membrane],
    banded: bool,
    context: &Context,
) -> Result<Vec<Membrane>> {
    let taken: Vec<&str> = membranes.iter().map(|m| m.name.as_str()).collect();
    distinct(item, &taken, |i| read_one(i, banded, context), |m| &m.name)
}

fn read_one(item: &Item, banded: bool, context: &Context) -> Result<Membrane> {
    let table = item.table(&KEYS)?;
    let shape = "give one: shape.circle = { centre = [0.5, 0.5], radius = 0.25 }";
    let tension = table.optional("tension", Item::non_negative)?.unwrap_or(0.0);
    let (chords, rings) = cuts(&table, context)?;
    Ok(Membrane {
        name: table.optional("name", identifier)?.unwrap_or_else(|| "drop".to_string()),
        shape: table.required("shape", shape, |i| Shape::read(i, context))?,
        stretch: 1.0,
        area: AreaLaw::Tension { tension },
        surface: None,
        map: Vec::new(),
        area_from: AreaFrom::Slope,
        mapped: false,
        force: table.optional("force", |i| i.choice(&FORCES))?.unwrap_or(if banded {
            Force::Smeared
        } else {
            Force::Sharp
        }),
        mass: 0.0,
        drop: Some(Drop {
            density: table.optional("density", Item::non_negative)?,
            viscosity: table.optional("viscosity", Item::positive)?,
        }),
        chords,
        rings,
    })
}

impl Membrane {
    /// Writes a membrane that is a drop.
    pub(super) fn write_drop(&self, drop: &Drop, out: &mut Writer) {
        out.header("[[drop]]");
        out.entry("name", text(&self.name));
        out.entry("shape", self.shape.write());
        out.entry("tension", number(self.area.tension(1.0)));
        for (key, value) in [("density", drop.density), ("viscosity", drop.viscosity)] {
            value.iter().for_each(|v| out.entry(key, number(*v)));
        }
        out.entry("force", word(self.force, &FORCES));
        self.write_cuts(out);
    }
}
