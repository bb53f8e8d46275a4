//! The tables of a scene: their types, defaults and checks, and how they are written.

mod adapt;
mod boundary;
mod drop;
mod exact;
mod fluid;
mod geometry;
mod image;
mod keys;
mod level_set;
mod membrane;
mod mesh;
mod names;
mod numerics;
mod output;
mod picture;
mod polygon;
mod redistance;
mod shape;
mod time;
mod write;

pub use adapt::{Adapt, AdaptField};
pub use boundary::{Boundary, Condition, WALLS};
pub use drop::Drop;
pub use exact::Exact;
pub use fluid::{Contrast, Fluid};
pub use geometry::{Curve, DeltaName};
pub use image::Image;
pub use keys::{Absent, Key, Keys, Kind};
pub use level_set::LevelSet;
pub use membrane::{Chord, Membrane, Ring};
pub use mesh::MeshSource;
pub use numerics::{Numerics, TensionScheme};
use output::Motion;
pub use output::{Flux, Force, Output, Probe, Profile, Quantity};
pub use picture::{Cut, Picture};
pub use redistance::Redistance;
pub use shape::Shape;
pub use time::Time;

use super::expression::is_reserved;
use super::item::{self, Context, Item};
use crate::base::Result;
use crate::elastic::AreaLaw;
use crate::fem::Element;
use crate::sim::{self, Coupling, Way};
use crate::transport::Method;
use keys::{Absent::*, Kind::*, row};
use std::collections::BTreeMap;
use std::path::Path;
use write::Writer;

/// All that a scene says, with defaults filled in and every value checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What the scene is called.
    pub title: String,
    /// The units of the scene, in words; may be empty.
    pub units: String,
    /// Names that expressions may use, beside x, y, z, t and pi.
    pub constants: BTreeMap<String, f64>,
    /// Where the mesh comes from.
    pub mesh: MeshSource,
    /// How the mesh follows what happens on it, if it does.
    pub adapt: Option<Adapt>,
    /// What flows; nothing where there is an image.
    pub fluid: Fluid,
    /// The image that the one level set segments, in place of a flow.
    pub image: Option<Image>,
    /// Conditions on the boundary, in the order of the scene; empty only when the velocity is prescribed.
    pub boundaries: Vec<Boundary>,
    /// Elastic interfaces, in the order of the scene, then the drops.
    pub membranes: Vec<Membrane>,
    /// Interfaces that are carried and act on nothing, in the order of the scene.
    pub level_sets: Vec<LevelSet>,
    /// The time grid.
    pub time: Time,
    /// How the equations are solved.
    pub numerics: Numerics,
    /// What is written.
    pub output: Output,
    /// The exact solution, where one is known.
    pub exact: Exact,
}

/// The keys of a scene.
pub static KEYS: Keys = Keys {
    about: "A scene is a TOML file. Lengths, times and masses are in any consistent system of units; \
        units below are those of SI.",
    keys: &[
        row("title", Value("text"), "", Derived("the name of the file"), "What the scene is called."),
        row("units", Value("text"), "", Default("\"\""), "The units of the scene, in words; nothing is converted."),
        row(
            "constants",
            Value("table of numbers or expressions"),
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
        row("fluid", Table(&fluid::KEYS), "", OneOf, "What flows, and what drives it."),
        row("image", Table(&image::KEYS), "", OneOf, "An image that a level set segments, in place of a flow."),
        row(
            "boundary",
            Named(&boundary::KEYS),
            "",
            Derived("no slip everywhere"),
            "What happens on the named parts of the boundary.",
        ),
        row("membrane", List(&membrane::KEYS), "", Optional, "Elastic interfaces."),
        row("drop", List(&drop::KEYS), "", Optional, "Fluids in the fluid, with surface tension."),
        row("level_set", List(&level_set::KEYS), "", Optional, "Interfaces that are carried and act on nothing."),
        row("time", Table(&time::KEYS), "", Required, "How long, in which steps."),
        row("numerics", Table(&numerics::KEYS), "", Optional, "How the equations are solved."),
        row("output", Table(&output::KEYS), "", Optional, "What is written, and when."),
        row(
            "exact",
            Table(&exact::KEYS),
            "",
            Optional,
            "A solution that is known, against which the run measures itself.",
        ),
    ],
};

impl Settings {
    /// Reads a scene whose file lies in `folder` and is called `name`.
    pub(super) fn read(root: &Item, folder: &Path, name: &str) -> Result<Settings> {
        let read = |dimension| Settings::read_as(root, folder, name, dimension);
        // Where the scene says otherwise than its mesh file, or the file is missing, that is told when the mesh is made.
        read(None).or_else(|e| [2, 3].into_iter().find_map(|d| read(Some(d)).ok()).ok_or(e))
    }

    /// Reads a scene, its mesh file being of this dimension; without one, of that which the file says, or else of the plane.
    fn read_as(root: &Item, folder: &Path, name: &str, dimension: Option<usize>) -> Result<Settings> {
        let scene = root.table(&KEYS)?;
        let constants = scene.optional("constants", constants)?.unwrap_or_default();
        let mesh = "write [mesh] with rectangle = { min = [0, 0], max = [1, 1], cells = [30, 30] }";
        let image_item = scene.get("image");
        let image = image_item.as_ref().map(|i| Image::read(i, folder)).transpose()?;
        let mesh = match (&image_item, &image) {
            (Some(item), Some(image)) if scene.get("mesh").is_none() => image.mesh(item)?,
            _ => scene.required("mesh", mesh, |i| MeshSource::read(i, folder, &constants, dimension))?,
        };
        if let Some(item) = &image_item {
            image::check(&scene, item, mesh.dimension())?;
        }
        let adapt_item = scene.get("mesh").map(|i| i.open_table()).transpose()?.and_then(|t| t.get("adapt"));
        if let (Some(item), 3) = (&adapt_item, mesh.dimension()) {
            return Err(item
                .key_error("meshes of tetrahedra are not adapted")
                .remedy("leave mesh.adapt out, and make the mesh fine where the interface passes"));
        }
        let adapt = adapt_item.as_ref().map(Adapt::read).transpose()?;
        let context = Context { dimension: mesh.dimension(), constants };
        let mut membranes = membrane::read(scene.get("membrane"), &context)?;
        let numerics = Numerics::read(scene.get("numerics"))?;
        let banded = numerics.surface_tension.is_some() || numerics.coupling == Coupling::SemiImplicit;
        membranes.extend(drop::read(scene.get("drop"), &membranes, banded, &context)?);
        let taken: Vec<&str> = membranes.iter().map(|m| m.name.as_str()).collect();
        let level_sets = level_set::read(scene.get("level_set"), &taken, &context)?;
        let fluid = |i: &Item| Fluid::read(i, &membranes, &context);
        let fluid = match &image {
            Some(_) => Fluid::none(context.dimension),
            None => scene.required("fluid", "write [fluid] with viscosity = 0.01", fluid)?,
        };
        if image.is_none() && fluid.is_prescribed() {
            check_passive(&scene, level_sets.is_empty())?;
        }
        let interfaces: Vec<&str> = taken.into_iter().chain(level_sets.iter().map(|s| s.name.as_str())).collect();
        let time = scene.required("time", "write [time] with end = 1.0 and step = 1e-3", Time::read)?;
        let text = |i: &Item| i.text().map(str::to_string);
        if time.tolerance.is_some() {
            check_tolerance(&scene, &fluid, adapt.as_ref())?;
        }
        if let (Some(item), Some(adapt)) = (&adapt_item, &adapt) {
            adapt.check_use(item, !interfaces.is_empty(), fluid.is_prescribed())?;
        }
        let sheared = membranes.iter().any(|m| m.surface.is_some());
        check_elements(&scene, &numerics, &membranes, mesh.dimension(), adapt.is_some())?;
        if let (Some(item), Method::Composed) = (&adapt_item, numerics.transport) {
            return Err(item
                .key_error("a mesh that changes cannot carry the chain of maps of composed transport")
                .remedy("take numerics.transport = \"nodal\" or \"projected\", or leave mesh.adapt out"));
        }
        let table = scene.get("numerics").map(|i| i.open_table()).transpose()?;
        if let Some(item) = table.and_then(|t| t.get("redistance")) {
            redistance::check(&item, &membranes, !level_sets.is_empty(), numerics.transport, time.tolerance.is_some())?;
        }
        Ok(Settings {
            title: scene.optional("title", text)?.unwrap_or_else(|| name.to_string()),
            units: scene.optional("units", text)?.unwrap_or_default(),
            boundaries: boundary::read(scene.get("boundary"), fluid.is_prescribed(), &context)?,
            numerics,
            output: Output::read(
                scene.get("output"),
                &time,
                &interfaces,
                Motion::of(&fluid, image.is_some()),
                sheared,
                &context,
            )?,
            exact: scene.optional("exact", |i| Exact::read(i, &context))?.unwrap_or_default(),
            constants: context.constants,
            mesh,
            adapt,
            fluid,
            image,
            membranes,
            level_sets,
            time,
        })
    }

    /// The names of all interfaces, those of membranes first, each with the slope of its level set at the start.
    pub fn interfaces(&self) -> impl Iterator<Item = (&str, f64)> {
        let passive = self.level_sets.iter().map(|s| (s.name.as_str(), 1.0));
        self.membranes.iter().map(|m| (m.name.as_str(), m.stretch)).chain(passive)
    }

    /// The fluid inside structure number `k`, if it has one of its own: a drop that says so (it may equal that outside, and lie in another drop),
    /// or what `[fluid]` says of the one structure of the scene.
    pub fn inside(&self, k: usize) -> Option<sim::Fluid> {
        let outside = self.outside();
        if let Some(Drop { density, viscosity }) = self.membranes[k].drop
            && (density.is_some() || viscosity.is_some())
        {
            return Some(sim::Fluid {
                density: density.unwrap_or(outside.density),
                viscosity: viscosity.unwrap_or(outside.viscosity),
            });
        }
        let inside = sim::Fluid { density: self.fluid.density.inside, viscosity: self.fluid.viscosity.inside };
        (inside != outside).then_some(inside)
    }

    /// The fluid outside of all structures.
    pub fn outside(&self) -> sim::Fluid {
        sim::Fluid { density: self.fluid.density.outside, viscosity: self.fluid.viscosity.outside }
    }

    /// All fluids, that outside first.
    pub fn fluids(&self) -> impl Iterator<Item = sim::Fluid> {
        std::iter::once(self.outside()).chain((0..self.membranes.len()).filter_map(|k| self.inside(k)))
    }

    /// Whether some fluid has mass; without it the Stokes equations are solved.
    pub fn has_inertia(&self) -> bool {
        self.fluids().any(|f| f.density > 0.0)
    }

    /// Where structure number `k` is written in the scene.
    pub fn structure_keys(&self, k: usize) -> [String; 2] {
        let membranes = self.membranes.iter().filter(|m| m.drop.is_none()).count();
        let (list, number) = if k < membranes { ("membrane", k) } else { ("drop", k - membranes) };
        [list.to_string(), number.to_string()]
    }

    /// What an interface encloses and what it has of its own, as their columns are called.
    pub fn extents(&self) -> [&'static str; 2] {
        if self.mesh.dimension() == 2 { ["area", "perimeter"] } else { ["volume", "surface"] }
    }

    /// The scene as TOML with every default written out; reads as the same settings.
    pub(super) fn write(&self) -> String {
        let mut out = Writer::default();
        out.entry("title", write::text(&self.title));
        out.entry("units", write::text(&self.units));
        if !self.constants.is_empty() {
            out.header("[constants]");
            for (name, value) in &self.constants {
                out.entry(name, write::number(*value));
            }
        }
        self.mesh.write(&mut out);
        self.adapt.iter().for_each(|a| a.write(&mut out));
        match &self.image {
            Some(image) => image.write(&mut out),
            None => self.fluid.write(&mut out),
        }
        boundary::write(&self.boundaries, &mut out);
        membrane::write(&self.membranes, &mut out);
        level_set::write(&self.level_sets, &mut out);
        self.time.write(&mut out);
        self.numerics.write(&mut out);
        self.output.write(&mut out, self.mesh.dimension());
        self.exact.write(&mut out);
        out.text
    }
}

/// Refuses schemes and elements that are not made for the scene.
fn check_elements(
    scene: &item::Table<'_>,
    numerics: &Numerics,
    membranes: &[Membrane],
    dimension: usize,
    adapts: bool,
) -> Result<()> {
    let Some(table) = scene.get("numerics").map(|i| i.open_table()).transpose()? else { return Ok(()) };
    if let (Some(item), Some(scheme)) = (table.get("surface_tension"), numerics.surface_tension) {
        let stiff = |m: &&Membrane| m.surface.is_some() || !matches!(m.area, AreaLaw::Tension { .. });
        if let Some(m) = membranes.iter().find(stiff) {
            return Err(item
                .key_error(format!(
                    "the schemes of `surface_tension` are for constant tension, and membrane `{}` has another law",
                    m.name
                ))
                .remedy("give `coupling` in its place"));
        }
        if let (true, Some(m)) = (scheme.continuum, membranes.iter().find(|m| m.is_sharp())) {
            return Err(item
                .key_error(format!(
                    "the continuum surface force is spread over a band, and `{}` has a sharp force",
                    m.name
                ))
                .remedy("take force = \"smeared\" there, or another scheme"));
        }
    }
    match table.get("pressure").filter(|_| numerics.pressure == Element::P1P0) {
        Some(item) if numerics.solving.way == Some(Way::Schur) => Err(item
            .key_error("the Schur route has no operator for a pressure that holds the constants twice")
            .remedy("take solver = \"auto\", or pressure = \"P1\"")),
        Some(item) if dimension == 3 => Err(item
            .key_error(
                "in space P2 velocities cannot balance a pressure with a constant of each cell: the pair is not stable",
            )
            .remedy("take pressure = \"P1\"")),
        Some(item) if adapts => Err(item
            .key_error("a pressure with jumps is not brought to a new mesh")
            .remedy("take pressure = \"P1\", or leave mesh.adapt out")),
        _ => Ok(()),
    }
}

/// Steps that follow the error need a flow, whose error they follow, and a mesh that stays: on another mesh the differences between
/// velocities of earlier times are those of the transfer.
fn check_tolerance(scene: &item::Table<'_>, fluid: &Fluid, adapt: Option<&Adapt>) -> Result<()> {
    let time = scene.get("time").map(|i| i.open_table()).transpose()?;
    let Some(item) = time.and_then(|t| t.get("tolerance")) else { return Ok(()) };
    if fluid.is_prescribed() {
        return Err(item
            .key_error("the velocity is prescribed, and there is no flow whose error steps could follow")
            .remedy("leave time.tolerance out, and choose time.step"));
    }
    if adapt.is_some_and(|a| a.every.is_some()) {
        return Err(item
            .key_error("steps cannot follow the error on a mesh that is made anew")
            .remedy("leave out time.tolerance, or mesh.adapt.every: the mesh is then adapted at the start alone"));
    }
    Ok(())
}

/// A prescribed velocity carries level sets and nothing else.
fn check_passive(scene: &item::Table<'_>, without_level_set: bool) -> Result<()> {
    if let Some(item) = scene.get("membrane").or(scene.get("drop")) {
        return Err(item
            .key_error(format!("a {} acts on the flow, but the velocity is prescribed", item.key))
            .remedy("carry its shape as a [[level_set]], or give a viscosity in place of prescribed_velocity"));
    }
    if let Some(item) = scene.get("exact").map(|e| e.open_table()).transpose()?.and_then(|e| e.get("pressure")) {
        return Err(item
            .key_error("there is no pressure to compare: the velocity is prescribed and no flow is solved")
            .remedy("leave exact.pressure out"));
    }
    match scene.get("fluid") {
        Some(item) if without_level_set => Err(item
            .key_error("the velocity is prescribed and carries nothing")
            .remedy("add [[level_set]] with shape.circle = { centre = [0.5, 0.75], radius = 0.15 }")),
        _ => Ok(()),
    }
}

/// Names with numbers, or with expressions of the names before them.
fn constants(item: &Item) -> Result<BTreeMap<String, f64>> {
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
