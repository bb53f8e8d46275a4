//! What `[output]` asks of the geometry of interfaces: delta functions, curvatures, curves between them.

use crate::base::Result;
use crate::scene::keys::{Absent::*, Keys, Kind::*, row};
use crate::scene::keys::{Context, Item};

/// A delta function that interfaces are measured with, beside the cut one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeltaName {
    /// Spread over the band, with `numerics.kernel` and `numerics.width`.
    Smeared,
    /// Smereka's first.
    Smereka1,
    /// Smereka's second.
    Smereka2,
    /// Towers'.
    Towers,
}

impl DeltaName {
    /// What its columns end with.
    pub fn word(self) -> &'static str {
        DELTAS.iter().find(|d| d.1 == self).map_or("", |d| d.0)
    }
}

const DELTAS: [(&str, DeltaName); 4] = [
    ("smeared", DeltaName::Smeared),
    ("smereka1", DeltaName::Smereka1),
    ("smereka2", DeltaName::Smereka2),
    ("towers", DeltaName::Towers),
];
/// The values of the list, in words.
pub(in crate::scene) const DELTA_LIST: &str = "list of \"smeared\", \"smereka1\", \"smereka2\", \"towers\"";

/// The curve in which two interfaces meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The name of its columns.
    pub name: String,
    /// The names of the interfaces.
    pub of: [String; 2],
}

pub(in crate::scene) static CURVE: Keys = Keys {
    about: "The curve in which two interfaces meet: its length, curvature and torsion, in `series.csv`.",
    keys: &[row("of", Value("list of two names"), "", Required, "The membranes, drops or level sets.")],
};

/// The list of delta functions, each once.
pub(in crate::scene) fn deltas(item: &Item) -> Result<Vec<DeltaName>> {
    let mut found = Vec::new();
    for item in item.list()? {
        let delta = item.choice(&DELTAS)?;
        if found.contains(&delta) {
            return Err(item.error("the delta function stands twice in the list").remedy("name each once"));
        }
        found.push(delta);
    }
    Ok(found)
}

/// A curve of two of the interfaces of a scene.
pub(in crate::scene) fn curve(name: String, item: &Item, interfaces: &[&str], context: &Context) -> Result<Curve> {
    if context.dimension != 3 {
        return Err(item
            .key_error("interfaces of the plane meet in points, not in curves")
            .remedy("leave output.curves out"));
    }
    let table = item.table(&CURVE)?;
    let read = |i: &Item| {
        let of = i.list()?.iter().map(|i| i.text().map(str::to_string)).collect::<Result<Vec<_>>>()?;
        let known = format!("the scene has {}", interfaces.join(", "));
        if let Some(k) = of.iter().position(|n| !interfaces.contains(&n.as_str())) {
            return Err(i.error(format!("there is no interface `{}`", of[k])).remedy(known));
        }
        match <[String; 2]>::try_from(of) {
            Ok(of) if of[0] != of[1] => Ok(of),
            _ => Err(i.error("a curve needs two interfaces that differ").remedy(known)),
        }
    };
    Ok(Curve { name, of: table.required("of", "name two interfaces: of = [\"a\", \"b\"]", read)? })
}
