//! `[[level_set]]`: interfaces that are carried and act on nothing.

use super::keys::{Absent::*, Keys, Kind::*, row};
use super::names::{distinct, identifier};
use super::shape::{self, Shape};
use super::write::{Writer, text};
use crate::base::Result;
use crate::scene::item::{Context, Item};

/// A passive level set.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelSet {
    /// Its name in results; unique in the scene.
    pub name: String,
    /// Its form at time 0; the level set is its signed distance.
    pub shape: Shape,
    /// Particles on the interface, followed for comparison; 0 for none.
    pub markers: usize,
}

pub(super) static KEYS: Keys = Keys {
    about: "A closed interface that is carried and acts on nothing.",
    keys: &[
        row("name", Value("text"), "", Default("\"interface\""), "Its name in results; unique in the scene."),
        row("shape", Table(&shape::KEYS), "", Required, "Its form at time 0."),
        row(
            "markers",
            Value("whole number from 3, or 0 for none"),
            "",
            Default("0"),
            "Particles on the interface, in columns of their own: the length and the area of their polygon. In the plane alone.",
        ),
    ],
};

const MOST_MARKERS: usize = 10_000_000;

/// All passive level sets, in the order of the scene. `taken` are names of other structures.
pub(super) fn read(item: Option<Item>, taken: &[&str], context: &Context) -> Result<Vec<LevelSet>> {
    distinct(item, taken, |i| LevelSet::read(i, context), |s| &s.name)
}

impl LevelSet {
    fn read(item: &Item, context: &Context) -> Result<LevelSet> {
        let table = item.table(&KEYS)?;
        let shape = "give one: shape.circle = { centre = [0.5, 0.75], radius = 0.15 }";
        if let (Some(item), 3) = (table.get("markers").filter(|i| !i.is_zero()), context.dimension) {
            return Err(item
                .key_error("markers follow a curve, and the interface is a surface: the scene has 3 dimensions")
                .remedy("leave them out"));
        }
        // A polygon has three corners.
        let markers = |i: &Item| if i.is_zero() { Ok(0) } else { i.count(3, MOST_MARKERS) };
        Ok(LevelSet {
            name: table.optional("name", identifier)?.unwrap_or_else(|| "interface".to_string()),
            shape: table.required("shape", shape, |i| Shape::read(i, context))?,
            markers: table.optional("markers", markers)?.unwrap_or(0),
        })
    }
}

pub(super) fn write(level_sets: &[LevelSet], out: &mut Writer) {
    for s in level_sets {
        out.header("[[level_set]]");
        out.entry("name", text(&s.name));
        out.entry("shape", s.shape.write());
        out.entry("markers", s.markers);
    }
}
