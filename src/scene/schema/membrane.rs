//! `[[membrane]]`: elastic interfaces.

use super::keys::{Absent::*, Keys, Kind::*, row, words};
use super::shape::{self, Shape};
use super::write::{Writer, key, name as word, number, text, vector};
use crate::base::Result;
use crate::elastic::{AreaLaw, Force};
use crate::scene::item::{Context, Item};

/// A closed elastic membrane.
#[derive(Clone, Debug, PartialEq)]
pub struct Membrane {
    /// Its name in results; unique in the scene.
    pub name: String,
    /// Its form at time 0.
    pub shape: Shape,
    /// Stretch r at time 0: length over length at rest.
    pub stretch: f64,
    /// The law of its elastic energy.
    pub area: AreaLaw,
    /// Where its force acts.
    pub force: Force,
    /// Mass per length (2-D) or area (3-D), >= 0.
    pub mass: f64,
    /// Lines along which the contour is measured.
    pub chords: Vec<Chord>,
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

const FORCES: [(&str, Force); 2] = [("smeared", Force::Smeared), ("sharp", Force::Sharp)];
const FORCE_WORDS: [&str; FORCES.len()] = words(&FORCES);

pub(super) static KEYS: Keys = Keys {
    about: "A closed elastic membrane.",
    keys: &[
        row("name", Value("text"), "", Default("\"membrane\""), "Its name in results; unique in the scene."),
        row("shape", Table(&shape::KEYS), "", Required, "Its form at time 0."),
        row("stretch", Value("number > 0"), "", Default("1.0"), "Stretch r at time 0: length over length at rest."),
        row("area", Table(&LAWS), "", Required, "The law of its elastic energy."),
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

static CHORD: Keys = Keys {
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
    let Some(item) = item else { return Ok(Vec::new()) };
    let mut membranes: Vec<Membrane> = Vec::new();
    for item in item.list()? {
        let membrane = Membrane::read(&item, context)?;
        if membranes.iter().any(|m| m.name == membrane.name) {
            let named = item.open_table()?.get("name").unwrap_or(item);
            return Err(named
                .error(format!("two membranes are named `{}`", membrane.name))
                .remedy("give each [[membrane]] a name of its own"));
        }
        membranes.push(membrane);
    }
    Ok(membranes)
}

impl Membrane {
    /// Whether its force acts on the interface itself.
    pub fn is_sharp(&self) -> bool {
        self.force == Force::Sharp
    }

    fn read(item: &Item, context: &Context) -> Result<Membrane> {
        let table = item.table(&KEYS)?;
        let shape = "give one: shape.circle = { centre = [1, 1], radius = 0.5 }";
        let law = "give the elastic law: area.linear = { modulus = 1 }";
        Ok(Membrane {
            name: table.optional("name", identifier)?.unwrap_or_else(|| "membrane".to_string()),
            shape: table.required("shape", shape, |i| Shape::read(i, context))?,
            stretch: table.optional("stretch", Item::positive)?.unwrap_or(1.0),
            area: table.required("area", law, AreaLaw::read)?,
            force: table.optional("force", |i| i.choice(&FORCES))?.unwrap_or(Force::Smeared),
            mass: table.optional("mass", Item::non_negative)?.unwrap_or(0.0),
            chords: table
                .optional("chords", |i| named(i, |name, i| Chord::read(name, i, context)))?
                .unwrap_or_default(),
        })
    }

    fn write(&self, out: &mut Writer) {
        out.header("[[membrane]]");
        out.entry("name", text(&self.name));
        out.entry("shape", self.shape.write());
        out.entry("stretch", number(self.stretch));
        out.entry("area", self.area.write());
        out.entry("force", word(self.force, &FORCES));
        out.entry("mass", number(self.mass));
        for chord in &self.chords {
            let (through, direction) = (vector(&chord.through), vector(&chord.direction));
            let name = key(&chord.name);
            out.entry(&format!("chords.{name}"), format_args!("{{ through = {through}, direction = {direction} }}"));
        }
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

/// The entries of a table whose keys name them; a name becomes part of column and file names.
pub(super) fn named<T>(item: &Item, read: impl Fn(String, &Item) -> Result<T>) -> Result<Vec<T>> {
    let entries = item.open_table()?;
    let one = |(name, item): (&str, Item)| match is_identifier(name) {
        true => read(name.to_string(), &item),
        false => Err(item.key_error(format!("`{name}` cannot be a name here")).remedy(IDENTIFIER)),
    };
    entries.items().map(one).collect()
}

const IDENTIFIER: &str = "use letters, digits, `_` and `-`, and begin with a letter";

pub(super) fn identifier(item: &Item) -> Result<String> {
    let name = item.text()?;
    if is_identifier(name) {
        return Ok(name.to_string());
    }
    Err(item.error(format!("\"{name}\" cannot be a name here")).remedy(IDENTIFIER))
}

fn is_identifier(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(allowed)
}

pub(super) fn write(membranes: &[Membrane], out: &mut Writer) {
    for m in membranes {
        m.write(out);
    }
}
