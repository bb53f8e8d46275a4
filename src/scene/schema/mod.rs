//! The tables of a scene: their types, defaults and checks, and how they are written.

mod adapt;
mod boundary;
mod exact;
mod fluid;
mod keys;
mod level_set;
mod membrane;
mod mesh;
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
pub use exact::Exact;
pub use fluid::Fluid;
pub use keys::{Absent, Key, Keys, Kind};
pub use level_set::LevelSet;
pub use membrane::{Chord, Membrane, Ring};
pub use mesh::MeshSource;
pub use numerics::Numerics;
pub use output::{Flux, Force, Output, Probe, Profile, Quantity};
pub use picture::{Cut, Picture};
pub use redistance::Redistance;
pub use shape::Shape;
pub use time::Time;

use super::expression::is_reserved;
use super::item::{self, Context, Item};
use crate::base::Result;
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
    /// What flows.
    pub fluid: Fluid,
    /// Conditions on the boundary, in the order of the scene; empty only when the velocity is prescribed.
    pub boundaries: Vec<Boundary>,
    /// Elastic interfaces, in the order of the scene.
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
        row("mesh", Table(&mesh::KEYS), "", Required, "Where the mesh comes from."),
        row("fluid", Table(&fluid::KEYS), "", Required, "What flows, and what drives it."),
        row(
            "boundary",
            Named(&boundary::KEYS),
            "",
            Derived("no slip everywhere"),
            "What happens on the named parts of the boundary.",
        ),
        row("membrane", List(&membrane::KEYS), "", Optional, "Elastic interfaces."),
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
        let mesh = scene.required("mesh", mesh, |i| MeshSource::read(i, folder, &constants, dimension))?;
        let adapt_item = scene.get("mesh").map(|i| i.open_table()).transpose()?.and_then(|t| t.get("adapt"));
        if let (Some(item), 3) = (&adapt_item, mesh.dimension()) {
            return Err(item
                .key_error("meshes of tetrahedra are not adapted")
                .remedy("leave mesh.adapt out, and make the mesh fine where the interface passes"));
        }
        let adapt = adapt_item.as_ref().map(Adapt::read).transpose()?;
        let context = Context { dimension: mesh.dimension(), constants };
        let membranes = membrane::read(scene.get("membrane"), &context)?;
        let taken: Vec<&str> = membranes.iter().map(|m| m.name.as_str()).collect();
        let level_sets = level_set::read(scene.get("level_set"), &taken, &context)?;
        let fluid = |i: &Item| Fluid::read(i, membranes.len(), &context);
        let fluid = scene.required("fluid", "write [fluid] with viscosity = 0.01", fluid)?;
        if fluid.is_prescribed() {
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
        let numerics = Numerics::read(scene.get("numerics"))?;
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
            output: Output::read(scene.get("output"), &time, &interfaces, fluid.is_prescribed(), sheared, &context)?,
            exact: scene.optional("exact", |i| Exact::read(i, &context))?.unwrap_or_default(),
            constants: context.constants,
            mesh,
            adapt,
            fluid,
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
        self.fluid.write(&mut out);
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
    if let Some(item) = scene.get("membrane") {
        return Err(item
            .key_error("a membrane acts on the flow, but the velocity is prescribed")
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
