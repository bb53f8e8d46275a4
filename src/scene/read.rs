//! Reading and writing of a scene: its tables, its structures, and the consistency checks between
//! them.

use super::keys::{Context, Item, Keys, Table, Tabled, Typed, Writer, distinct};
use super::schema::{
    Adapt, Exact, Fluid, Given, Image, InUnits, Initial, KEYS_AFTER, KEYS_BEFORE, MeshSource,
    Motion, Numerics, Output, Tables, Time, check_image, constants, read_boundaries,
};
use super::structures::{KINDS, StructureKind, Traits};
use crate::base::{Error, Result};
use crate::fem::Element;
use crate::sim::{ConvectionScheme, SolverKind};
use crate::transport::Method;
use std::path::Path;
use std::sync::LazyLock;

/// Structures of a scene, in the order of their columns.
pub(super) type Structures = Vec<Box<dyn StructureKind>>;

/// The keys of a scene.
pub static KEYS: LazyLock<Keys> = LazyLock::new(|| {
    let lists = KINDS.iter().map(|kind| kind.key());
    let keys: Vec<_> = KEYS_BEFORE.into_iter().chain(lists).chain(KEYS_AFTER).collect();
    Keys {
        about: "A scene is a TOML file. Lengths, times and masses are in any consistent system of \
            units; units below are those of SI.",
        keys: keys.leak(),
    }
});

/// Reads a scene whose file is in `folder` and has the name `name`.
///
/// # Errors
/// The first invalid value, with its position.
pub(super) fn read(root: &Item, folder: &Path, name: &str) -> Result<(Tables, Structures)> {
    let read = |dimension| read_as(root, folder, name, dimension);
    // A conflict between the scene and its mesh file, or a missing file, is reported when the mesh
    // is built.
    read(None).or_else(|e| [2, 3].into_iter().find_map(|d| read(Some(d)).ok()).ok_or(e))
}

/// Reads a scene whose mesh file has this dimension; by default that of the file, or else 2.
fn read_as(
    root: &Item,
    folder: &Path,
    name: &str,
    dimension: Option<usize>,
) -> Result<(Tables, Structures)> {
    let scene = root.table(&KEYS)?;
    let constants = scene.optional("constants", constants)?.unwrap_or_default();
    let context = Context { dimension: 2, constants, folder: folder.to_path_buf() };
    let (image, mesh) = read_mesh(&scene, &context, dimension)?;
    let context = Context { dimension: mesh.dimension(), ..context };
    let adapt = read_adapt(&scene, &context)?;
    let numerics = Numerics::read_inner(&scene, "numerics", &context)?;
    let structures = read_structures(&scene, &numerics, &context)?;
    let traits: Vec<Traits> = structures.iter().map(|s| s.traits()).collect();
    let fluid = match &image {
        Some(_) => Fluid::none(context.dimension),
        None => {
            let read = |i: &Item| Fluid::read_among(i, &own_fluids(&structures), &context);
            scene.required("fluid", "write [fluid] with viscosity = 0.01", read)?
        }
    };
    let initial = Initial::read_for(&scene, &fluid, &context)?;
    let time = scene.required("time", "write [time] with end = 1.0 and step = 1e-3", |i| {
        Time::read(i, &context)
    })?;
    check(
        &scene,
        (&mesh, &fluid, image.is_some()),
        (&numerics, &time, adapt.as_ref()),
        &structures,
    )?;
    let names: Vec<&str> = structures.iter().map(|s| s.name()).collect();
    let motion = Motion::of(&fluid, image.is_some());
    let has_map = traits.iter().any(|t| t.resists_shear);
    let has_strain = has_map || traits.iter().any(|t| t.carries_strain);
    let interfaces = &names;
    let given = Given { time: &time, interfaces, motion, has_map, has_strain, context: &context };
    let output = Output::read_given(&scene, given)?;
    let text = |i: &Item| i.text().map(str::to_string);
    let tables = Tables {
        title: scene.optional("title", text)?.unwrap_or_else(|| name.to_string()),
        units: scene.optional("units", |i| InUnits::read(i, &context))?.unwrap_or_default(),
        boundaries: read_boundaries(scene.get("boundary"), fluid.is_prescribed(), &context)?,
        numerics,
        output,
        exact: Exact::read_inner(&scene, "exact", &context)?,
        constants: context.constants,
        mesh,
        adapt,
        fluid,
        initial,
        image,
        time,
    };
    Ok((tables, structures))
}

/// Reads the image, if there is one, and the mesh.
fn read_mesh(
    scene: &Table<'_>,
    context: &Context,
    dimension: Option<usize>,
) -> Result<(Option<Image>, MeshSource)> {
    let item = scene.get("image");
    let image = item.as_ref().map(|i| Image::read(i, context)).transpose()?;
    let remedy = "write [mesh] with rectangle = { min = [0, 0], max = [1, 1], cells = [30, 30] }";
    let mesh = match (&item, &image) {
        (Some(item), Some(image)) if scene.get("mesh").is_none() => image.mesh(item)?,
        _ => scene.required("mesh", remedy, |i| MeshSource::read(i, context, dimension))?,
    };
    if let Some(item) = &item {
        let lists: Vec<&str> = KINDS.iter().map(|kind| kind.list).collect();
        check_image(scene, item, mesh.dimension(), &lists)?;
    }
    Ok((image, mesh))
}

fn adapt_item<'a>(scene: &Table<'a>) -> Result<Option<Item<'a>>> {
    Ok(scene.get("mesh").map(|i| i.open_table()).transpose()?.and_then(|t| t.get("adapt")))
}

fn read_adapt(scene: &Table<'_>, context: &Context) -> Result<Option<Adapt>> {
    let item = adapt_item(scene)?;
    if let (Some(item), 3) = (&item, context.dimension) {
        return Err(item
            .key_error("meshes of tetrahedra are not adapted")
            .remedy("leave mesh.adapt out, and make the mesh fine where the interface passes"));
    }
    item.as_ref().map(|i| Adapt::read(i, context)).transpose()
}

/// Reads all structures, each with a distinct name.
fn read_structures(
    scene: &Table<'_>,
    numerics: &Numerics,
    context: &Context,
) -> Result<Structures> {
    let mut all: Structures = Vec::new();
    for kind in KINDS {
        let taken: Vec<&str> = all.iter().map(|s| s.name()).collect();
        let read = |i: &Item| (kind.read)(i, numerics, context);
        let found = distinct(scene.get(kind.list), &taken, read, |s| s.name())?;
        all.extend(found);
    }
    Ok(all)
}

/// Names of the structures that enclose a fluid, each with true if it specifies that fluid itself.
fn own_fluids(structures: &[Box<dyn StructureKind>]) -> Vec<(String, bool)> {
    let acting = structures.iter().filter(|s| s.traits().acts);
    acting
        .map(|s| (s.name().to_string(), s.traits().own_fluid.iter().any(Option::is_some)))
        .collect()
}

/// Writes a scene as TOML with all defaults; the result reads as an equal scene.
pub(super) fn write(tables: &Tables, structures: &[Box<dyn StructureKind>]) -> String {
    let mut out = Writer::default();
    tables.write_before(&mut out);
    structures.iter().for_each(|s| s.write(&mut out));
    tables.write_after(&mut out);
    out.text
}

/// Checks the consistency of tables and structures.
fn check(
    scene: &Table<'_>,
    (mesh, fluid, has_image): (&MeshSource, &Fluid, bool),
    (numerics, time, adapt): (&Numerics, &Time, Option<&Adapt>),
    structures: &[Box<dyn StructureKind>],
) -> Result<()> {
    let passive = structures.iter().any(|s| !s.traits().acts);
    let prescribed = fluid.is_prescribed();
    if !has_image && prescribed {
        check_passive(scene, structures, !passive)?;
    }
    if time.tolerance.is_some() {
        check_tolerance(scene, fluid, adapt)?;
    }
    check_convection(scene, numerics, time)?;
    if time.order == 3 {
        check_third_order(
            scene,
            (numerics, time),
            !structures.is_empty() || prescribed || has_image,
        )?;
    }
    let adapt_item = adapt_item(scene)?;
    if let (Some(item), Some(adapt)) = (&adapt_item, adapt) {
        adapt.check_use(item, !structures.is_empty(), prescribed)?;
    }
    check_elements(scene, numerics, structures, mesh.dimension(), adapt.is_some())?;
    if let (Some(item), Method::Composed) = (&adapt_item, numerics.transport) {
        return Err(item
            .key_error("a mesh that changes cannot carry the chain of maps of composed transport")
            .remedy(
                "take numerics.transport = \"nodal\" or \"projected\", or leave mesh.adapt out",
            ));
    }
    let table = scene.get("numerics").map(|i| i.open_table()).transpose()?;
    match table.and_then(|t| t.get("redistance")) {
        Some(item) => check_redistance(&item, structures, numerics, time.tolerance.is_some()),
        None => Ok(()),
    }
}

/// Rejects schemes and elements that are not available for the scene.
fn check_elements(
    scene: &Table<'_>,
    numerics: &Numerics,
    structures: &[Box<dyn StructureKind>],
    dimension: usize,
    adapts: bool,
) -> Result<()> {
    let Some(table) = scene.get("numerics").map(|i| i.open_table()).transpose()? else {
        return Ok(());
    };
    if let (Some(item), Some(scheme)) = (table.get("surface_tension"), numerics.surface_tension) {
        let acting = || structures.iter().filter(|s| s.traits().acts);
        if let Some(s) = acting().find(|s| !s.traits().constant_tension) {
            return Err(item
                .key_error(format!(
                    "the schemes of `surface_tension` are for constant tension, and {} `{}` has \
                     another law",
                    s.list(),
                    s.name()
                ))
                .remedy("give `coupling` in its place"));
        }
        if let (true, Some(s)) = (scheme.by_curvature, acting().find(|s| s.traits().on_interface)) {
            return Err(item
                .key_error(format!(
                    "the continuum surface force is spread over a band, and `{}` has a sharp force",
                    s.name()
                ))
                .remedy("take force = \"smeared\" there, or another scheme"));
        }
    }
    match table.get("pressure").filter(|_| numerics.pressure == Element::P1P0) {
        Some(item) if numerics.solver == Some(SolverKind::Schur) => Err(item
            .key_error(
                "the Schur route has no operator for a pressure that holds the constants twice",
            )
            .remedy("take solver = \"auto\", or pressure = \"P1\"")),
        Some(item) if dimension == 3 => Err(item
            .key_error(
                "in space P2 velocities cannot balance a pressure with a constant of each cell: \
                 the pair is not stable",
            )
            .remedy("take pressure = \"P1\"")),
        Some(item) if adapts => Err(item
            .key_error("a pressure with jumps is not brought to a new mesh")
            .remedy("take pressure = \"P1\", or leave mesh.adapt out")),
        _ => Ok(()),
    }
}

/// Order 3 is for a flow alone in steps of one length.
fn check_third_order(
    scene: &Table<'_>,
    (numerics, time): (&Numerics, &Time),
    carries: bool,
) -> Result<()> {
    let table = scene.get("time").map(|i| i.open_table()).transpose()?;
    let Some(item) = table.and_then(|t| t.get("order")) else { return Ok(()) };
    let traced = numerics.convection.flatten().is_some_and(|c| c != ConvectionScheme::Implicit);
    let (what, remedy) = match (carries, traced, time.tolerance.is_some()) {
        (true, ..) => ("the structures and what is carried are of order 2", "take order = 2"),
        (_, true, _) => (
            "order 3 is not for this numerics.convection",
            "take numerics.convection = \"baker1982\", or order = 2",
        ),
        (.., true) => (
            "steps that follow the error are of order 2",
            "take order = 2, or leave time.tolerance out",
        ),
        _ => return Ok(()),
    };
    Err(item.key_error(what).remedy(remedy))
}

/// Explicit convection needs steps that keep below its limit.
fn check_convection(scene: &Table<'_>, numerics: &Numerics, time: &Time) -> Result<()> {
    let explicit = numerics.convection == Some(Some(ConvectionScheme::Explicit));
    let table = scene.get("numerics").map(|i| i.open_table()).transpose()?;
    match table.and_then(|t| t.get("convection")).filter(|_| explicit) {
        Some(item) if time.tolerance.is_none() => Err(item
            .key_error(
                "explicit convection is unstable above a Courant number of about .3, and steps of \
                 one length do not keep below it",
            )
            .remedy(
                "add time.tolerance = 1e-2: the steps then follow the speed; or take \
                 convection = \"baker1982\", stable for any step",
            )),
        _ => Ok(()),
    }
}

/// Adaptive steps need a flow, whose error they control, and a fixed mesh: on another mesh the
/// differences between velocities at earlier times contain the error of the transfer.
fn check_tolerance(scene: &Table<'_>, fluid: &Fluid, adapt: Option<&Adapt>) -> Result<()> {
    let time = scene.get("time").map(|i| i.open_table()).transpose()?;
    let Some(item) = time.and_then(|t| t.get("tolerance")) else { return Ok(()) };
    if fluid.is_prescribed() {
        return Err(item
            .key_error(
                "the velocity is prescribed, and there is no flow whose error steps could follow",
            )
            .remedy("leave time.tolerance out, and choose time.step"));
    }
    if adapt.is_some_and(|a| a.every.is_some()) {
        return Err(item
            .key_error("steps cannot follow the error on a mesh that is made anew")
            .remedy(
                "leave out time.tolerance, or mesh.adapt.every: the mesh is then adapted at the \
                 start alone",
            ));
    }
    Ok(())
}

/// A prescribed velocity transports level sets and nothing else.
fn check_passive(
    scene: &Table<'_>,
    structures: &[Box<dyn StructureKind>],
    without_level_set: bool,
) -> Result<()> {
    let acting = structures.iter().find(|s| s.traits().acts);
    if let Some(item) = acting.and_then(|s| scene.get(s.list())) {
        return Err(item
            .key_error(format!("a {} acts on the flow, but the velocity is prescribed", item.key))
            .remedy(
                "carry its shape as a [[level_set]], or give a viscosity in place of \
                 prescribed_velocity",
            ));
    }
    if let Some(item) =
        scene.get("exact").map(|e| e.open_table()).transpose()?.and_then(|e| e.get("pressure"))
    {
        return Err(item
            .key_error(
                "there is no pressure to compare: the velocity is prescribed and no flow is solved",
            )
            .remedy("leave exact.pressure out"));
    }
    match scene.get("fluid") {
        Some(item) if without_level_set => {
            Err(item.key_error("the velocity is prescribed and carries nothing").remedy(
                "add [[level_set]] with shape.circle = { centre = [0.5, 0.75], radius = 0.15 }",
            ))
        }
        _ => Ok(()),
    }
}

/// Rejects redistancing of structures that use the slope of their level set, or have none.
fn check_redistance(
    item: &Item,
    structures: &[Box<dyn StructureKind>],
    numerics: &Numerics,
    paced: bool,
) -> Result<()> {
    let (transport, of) = (numerics.transport, numerics.redistance);
    if of.is_none_or(|r| r.scheme().is_none()) {
        return Ok(());
    }
    let acting = || structures.iter().filter(|s| s.traits().acts);
    let refuse = |what: String, remedy: &str| -> Result<()> {
        Err::<(), Error>(item.key_error(what).remedy(remedy))
    };
    if structures.is_empty() {
        return refuse(
            "there is no interface to redistance".into(),
            "leave it out, or add a [[level_set]]",
        );
    }
    let by_slope = of.is_some_and(|r| r.slope.is_some());
    if by_slope && !acting().any(|s| s.traits().keeps_distance()) {
        return refuse(
            "`slope` is for sharp forces, and there is none".into(),
            "give `every`, a number of steps, in its place",
        );
    }
    if transport == Method::Composed {
        return refuse(
            "composed transport never changes its level sets, which are functions of the way back \
             to time 0"
                .into(),
            "take numerics.transport = \"nodal\" or \"projected\", or leave numerics.redistance \
             out",
        );
    }
    if paced && acting().next().is_some() {
        return refuse(
            "steps that follow the error would follow the jumps that redistancing makes in the \
             force of a membrane"
                .into(),
            "leave out numerics.redistance, or time.tolerance",
        );
    }
    for s in acting() {
        let (name, traits) = (s.name(), s.traits());
        if traits.slope_is_stretch() {
            let what = format!(
                "the slope of the level set of `{name}` is the stretch of an elastic membrane, \
                 and redistancing destroys it"
            );
            return refuse(
                what,
                "take force = \"sharp\", whose stretch is a field of its own, or leave \
                numerics.redistance out",
            );
        }
        if traits.mass > 0.0 {
            let what = format!(
                "the slope of the level set of `{name}` thins the mass of the membrane (3.19), \
                 and redistancing destroys it"
            );
            return refuse(what, "leave numerics.redistance out, or take mass = 0");
        }
    }
    Ok(())
}
