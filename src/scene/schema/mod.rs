//! Tables of a scene: types, defaults, checks and writing. The lists of structures are in
//! `scene::structures`.

mod adapt;
mod boundary;
mod exact;
mod fluid;
mod geometry;
mod given;
mod image;
mod initial;
mod mesh;
mod numerics;
mod output;
mod picture;
mod polygon;
mod redistance;
pub(in crate::scene) mod shape;
mod time;
mod units;

pub use adapt::{Adapt, AdaptField};
pub use boundary::{Boundary, Condition, Opening, WALLS};
pub use exact::Exact;
pub use fluid::{Contrast, Fluid};
pub use geometry::{Curve, DeltaName};
pub use given::Quantity;
pub(in crate::scene) use given::{Given, Motion};
pub use image::Image;
pub use initial::Initial;
pub(in crate::scene) use mesh::relative;
pub use mesh::{BallInBox, Block, Disc, MeshSource, Rectangle};
pub use numerics::{Numerics, TensionScheme};
pub use output::{Flux, Force, Output, Probe, Profile, Reference, Stored};
pub use picture::{Cut, Picture, Window};
pub use polygon::Polygon;
pub use redistance::Redistance;
pub use shape::{
    Circle, Ellipse, Ellipsoid, Oval, OvalCurve, RoundedBox, Shape, Sphere, Spheroid, Torus,
};
pub use time::Time;
pub use units::{BaseUnits, Units};

pub(in crate::scene) use boundary::read as read_boundaries;
pub(in crate::scene) use image::check as check_image;
pub(in crate::scene) use units::InUnits;

use super::expression::is_reserved;
use super::keys::{Absent::*, Form, Item, Key, Kind::*, Tabled, Typed, Writer, number, row, text};
use crate::base::Result;
use crate::flow;
use std::collections::BTreeMap;

/// All tables of a scene except its structures, with defaults filled in and all values checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    /// Title of the scene.
    pub title: String,
    /// Units of the scene; may be none.
    pub units: Units,
    /// Names for expressions, beside x, y, z, t and pi.
    pub constants: BTreeMap<String, f64>,
    /// Source of the mesh.
    pub mesh: MeshSource,
    /// Adaptation of the mesh, if there is one.
    pub adapt: Option<Adapt>,
    /// The fluid; at rest for a segmentation.
    pub fluid: Fluid,
    /// The run that the flow starts from, if there is one.
    pub initial: Option<Initial>,
    /// The image to segment, in place of a flow.
    pub image: Option<Image>,
    /// Boundary conditions, in the order of the scene; empty only for a prescribed velocity.
    pub boundaries: Vec<Boundary>,
    /// The time grid.
    pub time: Time,
    /// Numerical methods.
    pub numerics: Numerics,
    /// Output of a run.
    pub output: Output,
    /// The exact solution, if known.
    pub exact: Exact,
}

/// Keys before the lists of structures; declared by hand, as these lists are between them and the
/// rest.
pub(in crate::scene) const KEYS_BEFORE: [Key; 8] = [
    row(
        "title",
        Value("text", Form::Text),
        "",
        Derived("the name of the file"),
        "What the scene is called.",
    ),
    row(
        "units",
        InUnits::KIND,
        "",
        InUnits::ABSENT,
        "The units of the scene; nothing is converted. A text such as \"SI\", \"cgs\" or \"mm, ms, \
            g\", or { length = \"mm\", time = \"ms\", mass = \"g\" }, gives units to the axes and \
            tables of the report; any other text is written on it.",
    ),
    row(
        "constants",
        Value("table of numbers or expressions", Form::Names(&Form::Expression)),
        "",
        Optional,
        "Names that expressions may use; each may use those before it.",
    ),
    row(
        "mesh",
        Table(&mesh::KEYS),
        "",
        Derived("with an image squares of two pixels; else required"),
        "Where the mesh comes from.",
    ),
    row("fluid", Table(Fluid::KEYS), "", OneOf, "What flows, and what drives it."),
    row(
        "initial",
        Table(Initial::KEYS),
        "",
        Optional,
        "An earlier run whose flow is the start, in place of `fluid.initial_velocity`.",
    ),
    row(
        "image",
        Table(Image::KEYS),
        "",
        OneOf,
        "An image that a level set segments, in place of a flow.",
    ),
    row(
        "boundary",
        Named(Condition::KEYS),
        "",
        Derived("no slip everywhere"),
        "What happens on the named parts of the boundary.",
    ),
];
/// Keys after the lists of structures.
pub(in crate::scene) const KEYS_AFTER: [Key; 4] = [
    row("time", Table(Time::KEYS), "", Required, "How long, in which steps."),
    row("numerics", Table(Numerics::KEYS), "", Optional, "How the equations are solved."),
    row("output", Table(Output::KEYS), "", Optional, "What is written, and when."),
    row(
        "exact",
        Table(Exact::KEYS),
        "",
        Optional,
        "A solution that is known, against which the run measures itself.",
    ),
];

impl Tables {
    /// The fluid outside of all structures.
    pub fn outside(&self) -> flow::Fluid {
        let (density, viscosity) = (self.fluid.density.outside, self.fluid.viscosity.outside);
        flow::Fluid { density, viscosity }
    }
    /// Names of the columns of the measure enclosed by an interface and of its own measure.
    pub fn extents(&self) -> [&'static str; 2] {
        if self.mesh.dimension() == 2 { ["area", "perimeter"] } else { ["volume", "surface"] }
    }
    /// Writes the tables before the lists of structures.
    pub(in crate::scene) fn write_before(&self, out: &mut Writer) {
        out.entry("title", text(&self.title));
        out.entry("units", InUnits::toml(&self.units));
        if !self.constants.is_empty() {
            out.header("[constants]");
            self.constants.iter().for_each(|(name, value)| out.entry(name, number(*value)));
        }
        self.mesh.write(out);
        self.adapt.iter().for_each(|a| a.write(out));
        match &self.image {
            Some(image) => image.section("[image]", out),
            None => {
                let taken = |key: &str| self.initial.is_some() && key == "initial_velocity";
                out.header("[fluid]");
                out.entries(self.fluid.entries().into_iter().filter(|(key, _)| !taken(key)));
            }
        }
        self.initial.iter().for_each(|i| i.section("[initial]", out));
        boundary::write(&self.boundaries, out);
    }
    /// Writes the tables after the lists of structures.
    pub(in crate::scene) fn write_after(&self, out: &mut Writer) {
        self.time.section("[time]", out);
        self.numerics.write(out);
        self.output.write(out);
        if self.exact != Exact::default() {
            self.exact.section("[exact]", out);
        }
    }
}

/// Reads names with numbers, or with expressions of the preceding names.
pub(in crate::scene) fn constants(item: &Item) -> Result<BTreeMap<String, f64>> {
    let mut constants = BTreeMap::new();
    for (name, item) in item.open_table()?.items() {
        let letters = name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
        if !letters || !name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
            return Err(item
                .key_error(format!("`{name}` cannot name a constant"))
                .remedy("use letters, digits and `_`, and begin with a letter"));
        }
        if is_reserved(name) {
            return Err(item
                .key_error(format!("`{name}` has a meaning of its own in expressions"))
                .remedy("choose another name"));
        }
        let value = item.expression(&constants)?.is_constant().ok_or_else(|| {
            item.error(format!("the constant `{name}` depends on x, y, z or t"))
                .remedy("use numbers and the constants before it")
        })?;
        constants.insert(name.to_string(), value);
    }
    Ok(constants)
}
