//! `[fluid]`: what flows, and what drives it.

use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::keys::{Absent::Default, Absent::OneOf, Absent::Required, Keys, Kind::Either, Kind::Value, row};
use crate::scene::keys::{Context, Item};
use crate::scene::keys::{Writer, expressions, number, vector};

/// A property that differs between the two sides of a structure, by (3.19).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contrast {
    /// Value where `phi < 0`.
    pub inside: f64,
    /// Value where `phi > 0`.
    pub outside: f64,
}

impl Contrast {
    /// The same on both sides.
    pub fn uniform(value: f64) -> Contrast {
        Contrast { inside: value, outside: value }
    }
    /// Whether both sides are the same.
    pub fn is_uniform(&self) -> bool {
        self.inside == self.outside
    }
}

/// The fluid on both sides of a closed structure.
#[derive(Clone, Debug, PartialEq)]
pub struct Fluid {
    /// Mass per volume, >= 0; 0 means no inertia: the Stokes equations.
    pub density: Contrast,
    /// Dynamic viscosity, > 0.
    pub viscosity: Contrast,
    /// Whether densities differ in gravity alone.
    pub boussinesq: bool,
    /// Acceleration; acts on the density.
    pub gravity: Vec<f64>,
    /// Force per volume.
    pub force: Vec<Expression>,
    /// Velocity at time 0; does not depend on time.
    pub initial_velocity: Vec<Expression>,
    /// The velocity at all times, in place of a flow that is solved; then nothing else of the fluid has a meaning.
    pub prescribed_velocity: Option<Vec<Expression>>,
}

/// All keys but `prescribed_velocity`.
const SOLVED: [&str; 6] = ["density", "viscosity", "boussinesq", "gravity", "force", "initial_velocity"];

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "What flows, and what drives it.",
    keys: &[
        row(
            "density",
            Either("number >= 0", &CONTRAST),
            "kg/m3",
            Default("1.0"),
            "Mass per volume; 0 means no inertia: the Stokes equations.",
        ),
        row("viscosity", Either("number > 0", &CONTRAST), "Pa s", OneOf, "Dynamic viscosity."),
        row(
            "boussinesq",
            Value("true or false"),
            "",
            Default("false"),
            "Whether the densities of drops (or inside a membrane) differ from that of the fluid in gravity alone, inertia being the same everywhere: \
             the Boussinesq form of section 1.4.2, for small differences.",
        ),
        row("gravity", Value("vector of numbers"), "m/s2", Default("[0.0, 0.0]"), "Acceleration; acts on the density."),
        row("force", Value("vector of numbers or expressions"), "N/m3", Default("[0.0, 0.0]"), "Force per volume."),
        row(
            "initial_velocity",
            Value("vector of numbers or expressions"),
            "m/s",
            Default("[0.0, 0.0]"),
            "Velocity at time 0; must not depend on `t`.",
        ),
        row(
            "prescribed_velocity",
            Value("vector of numbers or expressions"),
            "m/s",
            OneOf,
            "The velocity at all times, in place of a flow that is solved: then nothing else of the fluid, no membrane and no \
             condition on a boundary but periodic sides has a meaning, and level sets are carried by it.",
        ),
    ],
};

static CONTRAST: Keys = Keys {
    about: "A value on each side of the one closed structure of the scene. A drop can have a density and a viscosity of its own instead.",
    keys: &[
        row("inside", Value("number"), "", Required, "Where the level set is negative."),
        row("outside", Value("number"), "", Required, "Where it is positive."),
    ],
};

impl Fluid {
    /// `structures` are the names of those that hold a fluid, each with true if it names that fluid.
    pub(in crate::scene) fn read(item: &Item, structures: &[(String, bool)], context: &Context) -> Result<Fluid> {
        let table = item.table(&KEYS)?;
        let zero = vec![Expression::constant(0.0); context.dimension];
        if let Some(velocity) = table.optional("prescribed_velocity", |i| i.components(context))? {
            if let Some((key, item)) = SOLVED.iter().find_map(|key| Some((key, table.get(key)?))) {
                return Err(item
                    .key_error(format!("`{key}` means nothing beside `prescribed_velocity`: no flow is solved"))
                    .remedy("keep one of the two"));
            }
            return Ok(Fluid::prescribed(velocity));
        }
        let density = |i: &Item| read_contrast(i, structures, Item::non_negative);
        let viscosity = |i: &Item| read_contrast(i, structures, Item::positive);
        let boussinesq = table.optional("boussinesq", Item::boolean)?.unwrap_or(false);
        let found = table.optional("density", density)?.unwrap_or(Contrast::uniform(1.0));
        if let (true, 0.0, Some(item)) = (boussinesq, found.outside, table.get("boussinesq")) {
            return Err(item
                .key_error("in the Boussinesq form the inertia is that of the fluid outside, and it has none: its density is 0")
                .remedy("give the fluid a density, or leave boussinesq out"));
        }
        Ok(Fluid {
            density: found,
            viscosity: table.required("viscosity", "give the dynamic viscosity: viscosity = 0.01", viscosity)?,
            boussinesq,
            gravity: table.optional("gravity", |i| i.point(context))?.unwrap_or(vec![0.0; context.dimension]),
            force: table.optional("force", |i| i.components(context))?.unwrap_or(zero.clone()),
            initial_velocity: table.optional("initial_velocity", |i| initial(i, context))?.unwrap_or(zero),
            prescribed_velocity: None,
        })
    }

    /// Nothing flows: the velocity is zero at all times.
    pub(in crate::scene) fn none(dimension: usize) -> Fluid {
        let zero = vec![Expression::constant(0.0); dimension];
        Fluid::prescribed(zero)
    }

    /// No flow is solved: the velocity is given.
    fn prescribed(velocity: Vec<Expression>) -> Fluid {
        let (none, zero) = (Contrast::uniform(0.0), vec![Expression::constant(0.0); velocity.len()]);
        Fluid {
            density: none,
            viscosity: none,
            boussinesq: false,
            gravity: vec![0.0; velocity.len()],
            force: zero.clone(),
            initial_velocity: zero,
            prescribed_velocity: Some(velocity),
        }
    }

    /// Whether the velocity is prescribed, so that no flow is solved.
    pub fn is_prescribed(&self) -> bool {
        self.prescribed_velocity.is_some()
    }

    /// Whether there is a force per volume.
    pub fn has_force(&self) -> bool {
        self.force.iter().any(|f| f.is_constant() != Some(0.0))
    }

    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        out.header("[fluid]");
        if let Some(velocity) = &self.prescribed_velocity {
            return out.entry("prescribed_velocity", expressions(velocity));
        }
        out.entry("density", write_contrast(self.density));
        out.entry("viscosity", write_contrast(self.viscosity));
        out.entry("boussinesq", self.boussinesq);
        out.entry("gravity", vector(&self.gravity));
        out.entry("force", expressions(&self.force));
        out.entry("initial_velocity", expressions(&self.initial_velocity));
    }
}

fn initial(item: &Item, context: &Context) -> Result<Vec<Expression>> {
    let velocity = item.components(context)?;
    if velocity.iter().any(Expression::depends_on_time) {
        return Err(item
            .error("the initial velocity depends on time")
            .remedy("write it in x, y and z alone; it holds at time 0"));
    }
    Ok(velocity)
}

/// A number or `{ inside, outside }`, each read by `value`; the latter needs exactly one structure.
fn read_contrast<'a>(
    item: &Item<'a>,
    structures: &[(String, bool)],
    value: impl Fn(&Item<'a>) -> Result<f64>,
) -> Result<Contrast> {
    if !item.is_table() {
        return value(item).map(Contrast::uniform);
    }
    let table = item.table(&CONTRAST)?;
    let remedy = "give both: { inside = 1, outside = 1 }";
    let contrast = Contrast {
        inside: table.required("inside", remedy, &value)?,
        outside: table.required("outside", remedy, &value)?,
    };
    if let Some((drop, _)) = structures.iter().find(|(_, own)| *own) {
        return Err(item
            .key_error(format!("`{}` differs inside and outside, and so does what the drop `{drop}` says", item.key))
            .remedy("give one number, that outside, and the drop its own density or viscosity"));
    }
    if structures.len() != 1 {
        return Err(item
            .key_error(format!(
                "`{}` differs inside and outside, but the scene has {} closed structures",
                item.key,
                structures.len()
            ))
            .remedy("give one number, and each [[drop]] its own density and viscosity, or a scene with exactly one [[membrane]] or [[drop]]"));
    }
    Ok(contrast)
}

fn write_contrast(c: Contrast) -> String {
    if c.is_uniform() {
        return number(c.inside);
    }
    format!("{{ inside = {}, outside = {} }}", number(c.inside), number(c.outside))
}
