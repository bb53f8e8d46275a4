//! Lines and planes along which an interface is measured.

use crate::base::Result;
use crate::scene::keys::{Context, Form, Item, Kind, Named, Point, Table, kinds, table};

table! {
    /// A line through the membrane, along which half the distance of its two crossings is measured.
    Chord {
        /// A point of the line.
        through: Vec<f64> [Point, "m", Required("give a point: through = [1, 1]")],
        /// The direction of the line, not zero, of any length.
        direction: Vec<f64> [Along, Required("give a direction: direction = [1, 0]")],
    }
}

table! {
    /// A plane through the membrane: the radius of the line in which it cuts the membrane, half the
    /// diameters in the mean, and the amplitudes of its waves.
    Ring {
        /// The point through which diameters go.
        centre: Vec<f64> [Point, "m", Required("give a point: centre = [0, 0, 0]")],
        /// The normal of the plane, not zero, of any length.
        normal: Vec<f64> [Normal, Required("give a direction: normal = [0, 0, 1]")],
        /// Numbers of waves around the ring whose amplitudes are wanted.
        modes: Vec<usize> [Modes, Default([])],
    }
}

kinds! {
    /// The direction of a line.
    Along: Vec<f64> = Kind::Value("vector of numbers", Form::POINT), |i, c|
        not_zero(i, c, "the direction of a chord is zero", "give a direction such as [1, 0]"),
        spatial;
    /// The normal of a plane.
    Normal: Vec<f64> = Kind::Value("vector of numbers", Form::POINT), |i, c|
        not_zero(i, c, "the normal of a ring is zero", "give a direction such as [0, 0, 1]"),
        spatial;
    /// Numbers of waves, even as radii are measured along diameters.
    Modes: Vec<usize> = Kind::Value(
        "list of even whole numbers from 2 to 32",
        Form::List(&Form::Whole([2, 32]), [0, usize::MAX]),
    ),
        |i, _| i.list()?.iter().map(mode).collect();
}

/// All lines and planes of an interface.
#[derive(Clone, Copy, Default)]
pub struct Cuts<'a> {
    /// Lines.
    pub chords: &'a [Named<Chord>],
    /// Planes; in space only.
    pub rings: &'a [Named<Ring>],
}

impl<'a> Cuts<'a> {
    /// Names of the lines.
    pub(in crate::scene) fn names(self) -> impl Iterator<Item = &'a str> {
        self.chords.iter().map(|c| c.name.as_str())
    }
}

/// Rejects planes for a curve.
pub(in crate::scene) fn check(table: &Table<'_>, context: &Context) -> Result<()> {
    match table.get("rings").filter(|_| context.dimension == 2) {
        None => Ok(()),
        Some(item) => Err(item
            .key_error("rings are planes through a surface, and the interface is a curve")
            .remedy("ask for chords")),
    }
}

fn not_zero(item: &Item, context: &Context, what: &str, remedy: &str) -> Result<Vec<f64>> {
    let direction = item.point(context)?;
    if direction.iter().any(|d| *d != 0.0) {
        Ok(direction)
    } else {
        Err(item.error(what).remedy(remedy))
    }
}

fn mode(item: &Item) -> Result<usize> {
    match item.count(2, 32)? {
        m if m % 2 == 0 => Ok(m),
        m => Err(item
            .error(format!("{m} waves around a ring are not seen in its diameters"))
            .remedy("ask for even numbers")),
    }
}
