//! Lines and planes along which an interface is measured.

use crate::base::Result;
use crate::scene::keys::{Absent::*, Context, Item, Keys, Kind::*, Table, Writer, key, list, named, row, vector};

/// A line through the interface along which half the distance of its two crossings is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Chord {
    /// The name in results.
    pub name: String,
    /// A point of the line.
    pub through: Vec<f64>,
    /// Direction of the line, not zero, of any length.
    pub direction: Vec<f64>,
}

/// A plane through the interface, in which it is cut along a closed line.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// The name in results.
    pub name: String,
    /// The point from which radii are measured.
    pub centre: Vec<f64>,
    /// Normal of the plane, not zero, of any length.
    pub normal: Vec<f64>,
    /// Numbers of waves around the ring whose amplitudes are wanted: even ones, as radii are measured
    /// along diameters.
    pub modes: Vec<usize>,
}

/// All lines and planes of an interface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cuts {
    /// Lines.
    pub chords: Vec<Chord>,
    /// Planes; in space alone.
    pub rings: Vec<Ring>,
}

pub(in crate::scene) static CHORD: Keys = Keys {
    about: "A line through the membrane, along which half the distance of its two crossings is measured.",
    keys: &[
        row("through", Value("point"), "m", Required, "A point of the line."),
        row(
            "direction",
            Value("vector of numbers"),
            "",
            Required,
            "The direction of the line, not zero, of any length.",
        ),
    ],
};

pub(in crate::scene) static RING: Keys = Keys {
    about: "A plane through the membrane: the radius of the line in which it cuts the membrane, half the diameters in the mean, and the amplitudes of its waves.",
    keys: &[
        row("centre", Value("point"), "m", Required, "The point through which diameters go."),
        row("normal", Value("vector of numbers"), "", Required, "The normal of the plane, not zero, of any length."),
        row(
            "modes",
            Value("list of even whole numbers from 2 to 32"),
            "",
            Default("[]"),
            "Numbers of waves around the ring whose amplitudes are wanted.",
        ),
    ],
};

impl Cuts {
    /// Reads the keys `chords` and `rings` of a table.
    pub(in crate::scene) fn read(table: &Table<'_>, context: &Context) -> Result<Cuts> {
        if let (2, Some(item)) = (context.dimension, table.get("rings")) {
            return Err(item
                .key_error("rings are planes through a surface, and the interface is a curve")
                .remedy("ask for chords"));
        }
        let chords = table.optional("chords", |i| named(i, |name, i| Chord::read(name, i, context)))?;
        let rings = table.optional("rings", |i| named(i, |name, i| Ring::read(name, i, context)))?;
        Ok(Cuts { chords: chords.unwrap_or_default(), rings: rings.unwrap_or_default() })
    }

    /// Names of the lines.
    pub(in crate::scene) fn names(&self) -> impl Iterator<Item = &str> {
        self.chords.iter().map(|c| c.name.as_str())
    }
    /// Writes the keys.
    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        for chord in &self.chords {
            let (through, direction) = (vector(&chord.through), vector(&chord.direction));
            let name = key(&chord.name);
            out.entry(&format!("chords.{name}"), format_args!("{{ through = {through}, direction = {direction} }}"));
        }
        for Ring { name, centre, normal, modes } in &self.rings {
            let (centre, normal, name) = (vector(centre), vector(normal), key(name));
            let modes = list(modes.iter().map(ToString::to_string));
            let ring = format_args!("{{ centre = {centre}, normal = {normal}, modes = {modes} }}");
            out.entry(&format!("rings.{name}"), ring);
        }
    }
}

impl Ring {
    fn read(name: String, item: &Item, context: &Context) -> Result<Ring> {
        let table = item.table(&RING)?;
        let normal = |i: &Item| match i.point(context)? {
            n if n.iter().any(|d| *d != 0.0) => Ok(n),
            _ => Err(i.error("the normal of a ring is zero").remedy("give a direction such as [0, 0, 1]")),
        };
        let mode = |i: &Item| match i.count(2, 32)? {
            m if m % 2 == 0 => Ok(m),
            m => Err(i
                .error(format!("{m} waves around a ring are not seen in its diameters"))
                .remedy("ask for even numbers")),
        };
        Ok(Ring {
            name,
            centre: table.required("centre", "give a point: centre = [0, 0, 0]", |i| i.point(context))?,
            normal: table.required("normal", "give a direction: normal = [0, 0, 1]", normal)?,
            modes: table.optional("modes", |i| i.list()?.iter().map(mode).collect::<Result<_>>())?.unwrap_or_default(),
        })
    }
}

impl Chord {
    fn read(name: String, item: &Item, context: &Context) -> Result<Chord> {
        let table = item.table(&CHORD)?;
        let direction = |i: &Item| {
            let direction = i.point(context)?;
            if direction.iter().any(|d| *d != 0.0) {
                return Ok(direction);
            }
            Err(i.error("the direction of a chord is zero").remedy("give a direction such as [1, 0]"))
        };
        Ok(Chord {
            name,
            through: table.required("through", "give a point: through = [1, 1]", |i| i.point(context))?,
            direction: table.required("direction", "give a direction: direction = [1, 0]", direction)?,
        })
    }
}
