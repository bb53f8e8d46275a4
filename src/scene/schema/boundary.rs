//! `[boundary.NAME]`: what happens on the named parts of the boundary.

use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::keys::{Absent::OneOf, Keys, Kind::Value, row};
use crate::scene::keys::{Context, Item};
use crate::scene::keys::{Writer, expressions, key, text};

/// The name that stands for the whole boundary.
pub const WALLS: &str = "walls";

/// The condition on a named part of the boundary.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// A boundary of the mesh, or [`WALLS`] for all facets that no other entry names.
    pub name: String,
    /// What holds there.
    pub condition: Condition,
}

/// A boundary condition of the flow.
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// A given velocity.
    Velocity(Vec<Expression>),
    /// No velocity.
    NoSlip,
    /// No normal velocity, no tangential stress.
    Slip,
    /// No stress (do-nothing).
    Open,
    /// The same flow as on the boundary of this name, which is its translate.
    Periodic(String),
}

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "What holds on a boundary of the mesh: exactly one of these. `walls` stands for all sides that have no entry; without any entry, \
        no slip holds on the whole boundary.",
    keys: &[
        row("velocity", Value("vector of numbers or expressions"), "m/s", OneOf, "A given velocity."),
        row("no_slip", Value("true"), "", OneOf, "No velocity."),
        row("slip", Value("true"), "", OneOf, "No normal velocity and no tangential stress."),
        row("open", Value("true"), "", OneOf, "No stress (do-nothing)."),
        row(
            "periodic",
            Value("text"),
            "",
            OneOf,
            "The name of the boundary that is the translate of this one, with the same flow.",
        ),
    ],
};

/// All entries, in the order of the scene; without any, no slip on the whole boundary, or nothing where the velocity is `prescribed`.
pub(in crate::scene) fn read(item: Option<Item>, prescribed: bool, context: &Context) -> Result<Vec<Boundary>> {
    let Some(item) = item else {
        if prescribed {
            return Ok(Vec::new());
        }
        return Ok(vec![Boundary { name: WALLS.to_string(), condition: Condition::NoSlip }]);
    };
    let entries: Vec<(&str, Item)> = item.open_table()?.items().collect();
    let mut boundaries = Vec::new();
    for (name, item) in &entries {
        let condition = Condition::read(item, context)?;
        if prescribed && !matches!(condition, Condition::Periodic(_)) {
            return Err(item
                .key_error("a condition on a boundary means nothing where the velocity is prescribed")
                .remedy("leave it out; only periodic sides matter then"));
        }
        boundaries.push(Boundary { name: name.to_string(), condition });
    }
    if boundaries.is_empty() {
        return Err(item
            .key_error("`boundary` is empty")
            .remedy("write [boundary.walls] with no_slip = true, or leave the table out"));
    }
    for (_, item) in &entries {
        check_pair(item, &boundaries)?;
    }
    Ok(boundaries)
}

impl Condition {
    fn read(item: &Item, context: &Context) -> Result<Condition> {
        let (kind, item) = item.table(&KEYS)?.exactly_one(&KEYS)?;
        let flag = |condition| match item.boolean()? {
            true => Ok(condition),
            false => Err(item.error(format!("`{}` can only be true", item.key)).remedy(format!(
                "write {kind} = true, or one of {} instead",
                KEYS.names().collect::<Vec<_>>().join(", ")
            ))),
        };
        match kind {
            "velocity" => item.components(context).map(Condition::Velocity),
            "no_slip" => flag(Condition::NoSlip),
            "slip" => flag(Condition::Slip),
            "open" => flag(Condition::Open),
            _ => Ok(Condition::Periodic(item.text()?.to_string())),
        }
    }

    fn write(&self, out: &mut Writer) {
        match self {
            Condition::Velocity(v) => out.entry("velocity", expressions(v)),
            Condition::NoSlip => out.entry("no_slip", true),
            Condition::Slip => out.entry("slip", true),
            Condition::Open => out.entry("open", true),
            Condition::Periodic(other) => out.entry("periodic", text(other)),
        }
    }
}

/// A periodic boundary has one partner, which is another boundary with no condition of its own.
fn check_pair(item: &Item, boundaries: &[Boundary]) -> Result<()> {
    let Some(item) = item.open_table()?.get("periodic") else { return Ok(()) };
    let name = item.key.strip_prefix("boundary.").and_then(|k| k.strip_suffix(".periodic")).unwrap_or("");
    let other = item.text()?;
    let partner = |b: &Boundary| matches!(&b.condition, Condition::Periodic(p) if p == other) && b.name != name;
    let conflict = if other == name {
        Some(format!("`{name}` is periodic with itself"))
    } else if [name, other].contains(&WALLS) {
        Some("the whole boundary cannot be periodic".to_string())
    } else if boundaries.iter().any(partner) {
        Some(format!("`{other}` has two periodic partners"))
    } else {
        let own = boundaries.iter().find(|b| b.name == other).map(|b| &b.condition);
        own.filter(|c| !matches!(c, Condition::Periodic(back) if back == name))
            .map(|_| format!("`{other}` is periodic with `{name}` and has another condition"))
    };
    match conflict {
        None => Ok(()),
        Some(what) => Err(item.error(what).remedy("pair each periodic boundary with one other that has no entry")),
    }
}

pub(in crate::scene) fn write(boundaries: &[Boundary], out: &mut Writer) {
    for b in boundaries {
        out.header(&format!("[boundary.{}]", key(&b.name)));
        b.condition.write(out);
    }
}
