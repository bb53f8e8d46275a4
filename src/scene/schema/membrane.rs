//! `[[membrane]]`: elastic interfaces.

use super::drop::Drop;
use super::keys::{Absent::*, Keys, Kind::*, row, words};
use super::names::{distinct, identifier, named};
use super::shape::{self, Shape};
use super::write::{Writer, expressions, key, list, name as word, number, text, vector};
use crate::base::Result;
use crate::elastic::{AreaFrom, AreaLaw, Force, ShearLaw, SurfaceLaw};
use crate::scene::Expression;
use crate::scene::item::{Context, Item, Table};

/// A closed elastic membrane.
#[derive(Clone, Debug, PartialEq)]
pub struct Membrane {
    /// Its name in results; unique in the scene.
    pub name: String,
    /// Its form at time 0.
    pub shape: Shape,
    /// Stretch r at time 0: length over length at rest.
    pub stretch: f64,
    /// The law of its elastic energy; of one that resists shear, what it is for small changes of its area.
    pub area: AreaLaw,
    /// The law of one that resists shear too.
    pub surface: Option<SurfaceLaw>,
    /// Where its material at a point at time 0 is at rest, beside the stretch: three expressions, or none for the same place.
    pub map: Vec<Expression>,
    /// What the change of its area is taken from, if it resists shear.
    pub area_from: AreaFrom,
    /// Whether its level set is `phi0(Y)` in place of being carried.
    pub mapped: bool,
    /// Where its force acts.
    pub force: Force,
    /// Mass per length (2-D) or area (3-D), >= 0.
    pub mass: f64,
    /// What it is, if it is a drop rather than a membrane.
    pub drop: Option<Drop>,
    /// Lines along which the contour is measured.
    pub chords: Vec<Chord>,
    /// Rings on which the form of the interface is measured; in space alone.
    pub rings: Vec<Ring>,
}

/// A plane through the membrane, in which it is cut along a closed line.
#[derive(Clone, Debug, PartialEq)]
pub struct Ring {
    /// The name in results.
    pub name: String,
    /// The point from which radii are measured.
    pub centre: Vec<f64>,
    /// The normal of the plane, not zero, of any length.
    pub normal: Vec<f64>,
    /// Numbers of waves around the ring whose amplitudes are wanted: even ones, as radii are measured along diameters.
    pub modes: Vec<usize>,
}

/// A line through the membrane along which half the distance of its two crossings is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Chord {
    /// The name in results.
    pub name: String,
    /// A point of the line.
    pub through: Vec<f64>,
    /// The direction of the line, not zero, of any length.
    pub direction: Vec<f64>,
}

pub(super) const FORCES: [(&str, Force); 2] = [("smeared", Force::Smeared), ("sharp", Force::Sharp)];
pub(super) const FORCE_WORDS: [&str; FORCES.len()] = words(&FORCES);
const AREAS: [(&str, AreaFrom); 2] = [("slope", AreaFrom::Slope), ("map", AreaFrom::Map)];
const AREA_WORDS: [&str; AREAS.len()] = words(&AREAS);
const LEVEL_SETS: [(&str, bool); 2] = [("carried", false), ("mapped", true)];
const LEVEL_SET_WORDS: [&str; LEVEL_SETS.len()] = words(&LEVEL_SETS);

pub(super) static KEYS: Keys = Keys {
    about: "A closed elastic membrane.",
    keys: &[
        row("name", Value("text"), "", Default("\"membrane\""), "Its name in results; unique in the scene."),
        row("shape", Table(&shape::KEYS), "", Required, "Its form at time 0."),
        row("stretch", Value("number > 0"), "", Default("1.0"), "Stretch r at time 0: length over length at rest."),
        row("area", Table(&LAWS), "", Derived("none, where `law` is given"), "The law of the energy E(r) of its area."),
        row(
            "shear",
            Table(&SHEARS),
            "",
            Optional,
            "The law of the energy of its shear, beside that of its area; in space alone. Backward characteristics are then carried.",
        ),
        row(
            "law",
            Table(&WHOLE),
            "",
            Optional,
            "A law of area and shear together, in place of `area` and `shear`; in space alone.",
        ),
        row(
            "map",
            Value("three expressions"),
            "m",
            Derived("[\"x\", \"y\", \"z\"]"),
            "Where the material that is at x, y, z at time 0 is at rest, beside the stretch: Y at time 0.",
        ),
        row(
            "area_change",
            Choice(&AREA_WORDS),
            "",
            Default("\"slope\""),
            "What Z1 is taken from where there is shear: the slope of the level set, or the map Y.",
        ),
        row(
            "level_set",
            Choice(&LEVEL_SET_WORDS),
            "",
            Default("\"carried\""),
            "Whether the level set is carried, or taken as that of time 0 at the place where the map Y comes from.",
        ),
        row(
            "force",
            Choice(&FORCE_WORDS),
            "",
            Default("\"smeared\""),
            "Where its force acts: over a band, whose half-width `numerics.thickness` makes an error of first order, or on the interface \
             itself, cut out of the cells, with the stretch carried along it.",
        ),
        row(
            "mass",
            Value("number >= 0"),
            "kg/m2",
            Default("0.0"),
            "Mass per area (in the plane: per length and unit depth).",
        ),
        row("chords", Named(&CHORD), "", Optional, "Lines along which the contour is measured."),
        row(
            "rings",
            Named(&RING),
            "",
            Optional,
            "Planes through the membrane in which its form is measured; in space alone.",
        ),
    ],
};

static SHEARS: Keys = Keys {
    about: "The law of the energy E2(Z2) of shear: exactly one of these. Z2 is (l1/l2 + l2/l1)/2, l1 and l2 the principal stretches (3.41).",
    keys: &[
        row(
            "linear",
            Table(&MODULUS),
            "",
            OneOf,
            "E2' = modulus (Z2 - 1) (3.65): a small shear, for which Z2 - 1 is of second order, meets no resistance.",
        ),
        row("neo_hookean", Table(&MODULUS), "", OneOf, "E2' = modulus: resists small shears with this modulus."),
    ],
};

static WHOLE: Keys = Keys {
    about: "A law of area and shear together: exactly one of these. The modulus is G, that of surface shear.",
    keys: &[
        row(
            "neo_hookean",
            Table(&MODULUS),
            "",
            OneOf,
            "A thin sheet of rubber: W = G/2 (l1^2 + l2^2 + 1/(l1 l2)^2 - 3); E_s = 3 G.",
        ),
        row(
            "skalak",
            Table(&SKALAK),
            "",
            OneOf,
            "Skalak's law for red blood cells: W = G/4 (I1^2 + 2 I1 - 2 I2 + C I2^2), I1 = l1^2 + l2^2 - 2, I2 = (l1 l2)^2 - 1.",
        ),
    ],
};

static SKALAK: Keys = Keys {
    about: "Skalak's law.",
    keys: &[
        row("modulus", Value("number >= 0"), "N/m", Required, "G, the surface shear modulus."),
        row("area_ratio", Value("number >= 0"), "", Required, "C: resistance to a change of area over that to shear."),
    ],
};

pub(super) static RING: Keys = Keys {
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

static LAWS: Keys = Keys {
    about: "The law of the elastic energy E(r): exactly one of these. The tension is E'(r), r the stretch (3.13).",
    keys: &[
        row("linear", Table(&MODULUS), "", OneOf, "E'(r) = modulus (r - 1)."),
        row("one_sided", Table(&MODULUS), "", OneOf, "E'(r) = modulus max(r - 1, 0): no resistance to compression."),
        row("tension", Table(&TENSION), "", OneOf, "E'(r) = tension, whatever the stretch: a drop."),
    ],
};

static MODULUS: Keys = Keys {
    about: "A law with an elastic modulus.",
    keys: &[row("modulus", Value("number >= 0"), "N/m", Required, "Elastic modulus.")],
};

static TENSION: Keys = Keys {
    about: "Surface tension.",
    keys: &[row("tension", Value("number >= 0"), "N/m", Required, "Surface tension.")],
};

pub(super) static CHORD: Keys = Keys {
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

/// All membranes, in the order of the scene.
pub(super) fn read(item: Option<Item>, context: &Context) -> Result<Vec<Membrane>> {
    distinct(item, &[], |i| Membrane::read(i, context), |m| &m.name)
}

impl Membrane {
    /// Whether its force acts on the interface itself.
    pub fn is_sharp(&self) -> bool {
        self.force == Force::Sharp
    }

    fn read(item: &Item, context: &Context) -> Result<Membrane> {
        let table = item.table(&KEYS)?;
        let shape = "give one: shape.circle = { centre = [1, 1], radius = 0.5 }";
        let name = table.optional("name", identifier)?.unwrap_or_else(|| "membrane".to_string());
        let force = table.optional("force", |i| i.choice(&FORCES))?.unwrap_or(Force::Smeared);
        let (area, surface) = laws(&table, force, context)?;
        let needs_shear = |i: &Item| {
            i.key_error(format!("`{}` is for membranes that resist shear", i.key))
                .remedy("give shear.linear = { modulus = 1 } beside the law of area, or leave it out")
        };
        for key in ["map", "area_change", "level_set"] {
            if let (None, Some(item)) = (surface, table.get(key)) {
                return Err(needs_shear(&item));
            }
        }
        let (chords, rings) = cuts(&table, context)?;
        Ok(Membrane {
            name,
            shape: table.required("shape", shape, |i| Shape::read(i, context))?,
            stretch: table.optional("stretch", Item::positive)?.unwrap_or(1.0),
            area,
            surface,
            map: table.optional("map", |i| rest_map(i, context))?.unwrap_or_default(),
            area_from: table.optional("area_change", |i| i.choice(&AREAS))?.unwrap_or(AreaFrom::Slope),
            mapped: table.optional("level_set", |i| i.choice(&LEVEL_SETS))?.unwrap_or(false),
            force,
            mass: table.optional("mass", Item::non_negative)?.unwrap_or(0.0),
            drop: None,
            chords,
            rings,
        })
    }

    fn write(&self, out: &mut Writer) {
        if let Some(drop) = &self.drop {
            return self.write_drop(drop, out);
        }
        out.header("[[membrane]]");
        out.entry("name", text(&self.name));
        out.entry("shape", self.shape.write());
        out.entry("stretch", number(self.stretch));
        match self.surface {
            None => out.entry("area", self.area.write()),
            Some(SurfaceLaw::Split { area, shear }) => {
                out.entry("area", area.write());
                let (law, modulus) = match shear {
                    ShearLaw::Linear { modulus } => ("linear", modulus),
                    ShearLaw::NeoHookean { modulus } => ("neo_hookean", modulus),
                };
                out.entry("shear", format_args!("{{ {law} = {{ modulus = {} }} }}", number(modulus)));
            }
            Some(SurfaceLaw::NeoHookean { modulus }) => {
                out.entry("law", format_args!("{{ neo_hookean = {{ modulus = {} }} }}", number(modulus)));
            }
            Some(SurfaceLaw::Skalak { modulus, area_ratio }) => {
                let (g, c) = (number(modulus), number(area_ratio));
                out.entry("law", format_args!("{{ skalak = {{ modulus = {g}, area_ratio = {c} }} }}"));
            }
        }
        if self.surface.is_some() {
            if !self.map.is_empty() {
                out.entry("map", expressions(&self.map));
            }
            out.entry("area_change", word(self.area_from, &AREAS));
            out.entry("level_set", word(self.mapped, &LEVEL_SETS));
        }
        out.entry("force", word(self.force, &FORCES));
        out.entry("mass", number(self.mass));
        self.write_cuts(out);
    }

    /// The lines and planes along which it is measured.
    pub(super) fn write_cuts(&self, out: &mut Writer) {
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

/// The lines and planes along which an interface is measured.
pub(super) fn cuts(table: &Table<'_>, context: &Context) -> Result<(Vec<Chord>, Vec<Ring>)> {
    if let (2, Some(item)) = (context.dimension, table.get("rings")) {
        return Err(item
            .key_error("rings are planes through a surface, and the interface is a curve")
            .remedy("ask for chords"));
    }
    let chords = table.optional("chords", |i| named(i, |name, i| Chord::read(name, i, context)))?;
    let rings = table.optional("rings", |i| named(i, |name, i| Ring::read(name, i, context)))?;
    Ok((chords.unwrap_or_default(), rings.unwrap_or_default()))
}

/// The law of the area, and that of a membrane which resists shear.
fn laws(table: &Table<'_>, force: Force, context: &Context) -> Result<(AreaLaw, Option<SurfaceLaw>)> {
    let (shear, whole) = (table.get("shear"), table.get("law"));
    if let Some(item) = shear.as_ref().or(whole.as_ref()) {
        if context.dimension == 2 {
            return Err(item
                .key_error("shear is for surfaces in space, and a membrane of the plane is a curve")
                .remedy("give the law of its length alone: area.linear = { modulus = 1 }"));
        }
        if force == Force::Sharp {
            return Err(item
                .key_error("a sharp force carries the stretch along the interface, but no shear")
                .remedy("take force = \"smeared\", or leave the shear out"));
        }
    }
    if let Some(item) = &whole {
        if let Some(other) = shear.as_ref().or(table.get("area").as_ref()) {
            return Err(other
                .key_error(format!("`law` is a law of area and shear together, and `{}` comes on top of it", other.key))
                .remedy("give `law` alone, or `area` and `shear`"));
        }
        let law = SurfaceLaw::read_whole(item)?;
        let [modulus, _, _] = law.response(1.0, 1.0).second;
        return Ok((AreaLaw::Linear { modulus }, Some(law)));
    }
    let remedy = "give the elastic law: area.linear = { modulus = 1 }";
    let area = table.required("area", remedy, AreaLaw::read)?;
    let shear = shear.as_ref().map(ShearLaw::read).transpose()?;
    Ok((area, shear.map(|shear| SurfaceLaw::Split { area, shear })))
}

fn rest_map(item: &Item, context: &Context) -> Result<Vec<Expression>> {
    let map = item.components(context)?;
    if map.iter().any(Expression::depends_on_time) {
        return Err(item.error("the map to the place at rest depends on time").remedy("write it in x, y and z alone"));
    }
    Ok(map)
}

fn modulus(item: &Item, law: &str) -> Result<f64> {
    item.table(&MODULUS)?.required("modulus", &format!("write {law} = {{ modulus = 1 }}"), Item::non_negative)
}

impl ShearLaw {
    fn read(item: &Item) -> Result<ShearLaw> {
        let (law, item) = item.table(&SHEARS)?.exactly_one(&SHEARS)?;
        let modulus = modulus(&item, law)?;
        Ok(if law == "linear" { ShearLaw::Linear { modulus } } else { ShearLaw::NeoHookean { modulus } })
    }
}

impl SurfaceLaw {
    fn read_whole(item: &Item) -> Result<SurfaceLaw> {
        let (law, item) = item.table(&WHOLE)?.exactly_one(&WHOLE)?;
        if law == "neo_hookean" {
            return Ok(SurfaceLaw::NeoHookean { modulus: modulus(&item, law)? });
        }
        let (table, remedy) = (item.table(&SKALAK)?, "write skalak = { modulus = 1, area_ratio = 1 }");
        Ok(SurfaceLaw::Skalak {
            modulus: table.required("modulus", remedy, Item::non_negative)?,
            area_ratio: table.required("area_ratio", remedy, Item::non_negative)?,
        })
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

impl AreaLaw {
    fn read(item: &Item) -> Result<AreaLaw> {
        let (law, item) = item.table(&LAWS)?.exactly_one(&LAWS)?;
        let (parameter, keys) = if law == "tension" { ("tension", &TENSION) } else { ("modulus", &MODULUS) };
        let remedy = format!("write {law} = {{ {parameter} = 1 }}");
        let value = item.table(keys)?.required(parameter, &remedy, Item::non_negative)?;
        Ok(match law {
            "linear" => AreaLaw::Linear { modulus: value },
            "one_sided" => AreaLaw::OneSided { modulus: value },
            _ => AreaLaw::Tension { tension: value },
        })
    }

    fn write(&self) -> String {
        match self {
            AreaLaw::Linear { modulus } => format!("{{ linear = {{ modulus = {} }} }}", number(*modulus)),
            AreaLaw::OneSided { modulus } => format!("{{ one_sided = {{ modulus = {} }} }}", number(*modulus)),
            AreaLaw::Tension { tension } => format!("{{ tension = {{ tension = {} }} }}", number(*tension)),
        }
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

pub(super) fn write(membranes: &[Membrane], out: &mut Writer) {
    for m in membranes {
        m.write(out);
    }
}
