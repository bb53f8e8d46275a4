//! `[fluid]`: properties of the fluid, and forces on it.

use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::keys::{
    Components, Context, Direction, Flag, Form, Item, Kind, NonNegative, Number, Opt, Positive,
    Table, Tabled, Toml, Typed, kinds, optional, table,
};
use std::marker::PhantomData;

table! {
    /// What flows, and what drives it.
    Fluid {
        /// Mass per volume; 0 means no inertia: the Stokes equations.
        density: Contrast [Contrasted<NonNegative>, "kg/m3", Default(1.0)],
        /// Dynamic viscosity.
        viscosity: Contrast [Contrasted<Positive>, "Pa s", OneOf],
        /// Whether the densities of drops (or inside a membrane) differ from that of the fluid in
        /// gravity alone, inertia being the same everywhere: the Boussinesq form of section 1.4.2,
        /// for small differences.
        boussinesq: bool [Flag, Default(false)],
        /// Acceleration; acts on the density.
        gravity: Vec<f64> [Direction, "m/s2", Default([0.0, 0.0])],
        /// Force per volume.
        force: Vec<Expression> [Components, "N/m3", Default([0.0, 0.0])],
        /// Velocity at time 0; must not depend on `t`.
        initial_velocity: Vec<Expression> [InitialVelocity, "m/s", Default([0.0, 0.0])],
        /// The velocity at all times, in place of a flow that is solved: then nothing else of the
        /// fluid, no membrane and no condition on a boundary but periodic sides has a meaning, and
        /// level sets are carried by it.
        prescribed_velocity: Option<Vec<Expression>> [Opt<Components>, "m/s", OneOf],
    } before Fluid::before; check Fluid::check; hide Fluid::hides;
}

table! {
    /// A value on each side of the one closed structure of the scene. A drop can have a density and
    /// a viscosity of its own instead.
    Contrast: Copy, Default {
        /// Where the level set is negative.
        inside: f64 [Number, Required("give both: { inside = 1, outside = 1 }")],
        /// Where it is positive.
        outside: f64 [Number, Required("give both: { inside = 1, outside = 1 }")],
    }
}

kinds! {
    /// A velocity at time 0.
    InitialVelocity: Vec<Expression> = Kind::Value("vector of numbers or \
        expressions", Form::EXPRESSIONS), initial, spatial;
}

/// A number of the kind `K`, or one for each side.
pub(in crate::scene) struct Contrasted<K>(PhantomData<K>);

impl<K: Typed<Out = f64>> Typed for Contrasted<K> {
    type Out = Contrast;
    const KIND: Kind = match K::KIND {
        Kind::Value(words, form) => Kind::Either(words, form, Contrast::KEYS),
        other => other,
    };
    fn read(item: &Item<'_>, context: &Context) -> Result<Contrast> {
        if !item.is_table() {
            return K::read(item, context).map(Contrast::uniform);
        }
        let (contrast, table) = (Contrast::read(item, context)?, item.open_table()?);
        ["inside", "outside"]
            .iter()
            .try_for_each(|key| optional::<K>(&table, key, context).map(drop))?;
        Ok(contrast)
    }
    fn toml(out: &Contrast) -> String {
        if out.is_uniform() { out.inside.toml() } else { out.inline() }
    }
}

impl Contrast {
    /// The same value on both sides.
    pub fn uniform(value: f64) -> Contrast {
        Contrast { inside: value, outside: value }
    }
    /// True if both sides are the same.
    pub fn is_uniform(&self) -> bool {
        self.inside == self.outside
    }
}

/// All keys except `prescribed_velocity`.
const SOLVED: [&str; 6] =
    ["density", "viscosity", "boussinesq", "gravity", "force", "initial_velocity"];

impl Fluid {
    /// Reads a fluid; `structures` are the names of those that enclose one, each with true if it
    /// specifies the fluid itself.
    pub(in crate::scene) fn read_among(
        item: &Item,
        structures: &[(String, bool)],
        context: &Context,
    ) -> Result<Fluid> {
        let (fluid, table) = (Fluid::read(item, context)?, item.open_table()?);
        let sides = ["density", "viscosity"].into_iter().filter_map(|key| table.get(key));
        sides.filter(Item::is_table).try_for_each(|item| check_sides(&item, structures))?;
        Ok(fluid)
    }

    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        let prescribed = optional::<Components>(table, "prescribed_velocity", context)?;
        match SOLVED
            .iter()
            .find_map(|key| Some((key, table.get(key)?)))
            .filter(|_| prescribed.is_some())
        {
            None => Ok(()),
            Some((key, item)) => Err(item
                .key_error(format!(
                    "`{key}` means nothing beside `prescribed_velocity`: no flow is solved"
                ))
                .remedy("keep one of the two")),
        }
    }

    /// Replaces all other values by a prescribed velocity; without one a viscosity is required.
    fn check(&mut self, table: &Table<'_>, context: &Context) -> Result<()> {
        if let Some(velocity) = self.prescribed_velocity.take() {
            *self = Fluid::prescribed(velocity);
            return Ok(());
        }
        if let (true, 0.0, Some(item)) =
            (self.boussinesq, self.density.outside, table.get("boussinesq"))
        {
            return Err(item
                .key_error(
                    "in the Boussinesq form the inertia is that of the fluid outside, and it has \
                     none: its density is 0",
                )
                .remedy("give the fluid a density, or leave boussinesq out"));
        }
        let remedy = "give the dynamic viscosity: viscosity = 0.01";
        table.required("viscosity", remedy, |i| Contrasted::<Positive>::read(i, context)).map(drop)
    }

    fn hides(&self, key: &str) -> bool {
        self.is_prescribed() && SOLVED.contains(&key)
    }

    /// A fluid at rest: the velocity is zero at all times.
    pub(in crate::scene) fn none(dimension: usize) -> Fluid {
        let zero = vec![Expression::constant(0.0); dimension];
        Fluid::prescribed(zero)
    }

    /// A prescribed velocity, so that no flow is solved.
    fn prescribed(velocity: Vec<Expression>) -> Fluid {
        let (none, zero) =
            (Contrast::uniform(0.0), vec![Expression::constant(0.0); velocity.len()]);
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

    /// True if the velocity is prescribed, so that no flow is solved.
    pub fn is_prescribed(&self) -> bool {
        self.prescribed_velocity.is_some()
    }

    /// True if there is a force per volume.
    pub fn has_force(&self) -> bool {
        self.force.iter().any(|f| f.is_constant() != Some(0.0))
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

/// A property with different values inside and outside needs exactly one structure that does not
/// specify its own fluid.
fn check_sides(item: &Item, structures: &[(String, bool)]) -> Result<()> {
    if let Some((drop, _)) = structures.iter().find(|(_, own)| *own) {
        return Err(item
            .key_error(format!(
                "`{}` differs inside and outside, and so does what the drop `{drop}` says",
                item.key
            ))
            .remedy("give one number, that outside, and the drop its own density or viscosity"));
    }
    if structures.len() != 1 {
        return Err(item
            .key_error(format!(
                "`{}` differs inside and outside, but the scene has {} closed structures",
                item.key,
                structures.len()
            ))
            .remedy(
                "give one number, and each [[drop]] its own density and viscosity, or a scene \
                 with exactly one [[membrane]] or [[drop]]",
            ));
    }
    Ok(())
}
