//! Geometry of interfaces in `[output]`: delta functions, curvatures, intersection curves.

use crate::base::Result;
use crate::scene::keys::{Context, Form, Item, Kind, Table, Words, kinds, table, words};

/// A delta function for measurements on interfaces, beside the cut one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeltaName {
    /// Spread over the band, with `numerics.kernel` and `numerics.width`.
    Smeared,
    /// The first one of Smereka.
    Smereka1,
    /// The second one of Smereka.
    Smereka2,
    /// The one of Towers.
    Towers,
}

impl DeltaName {
    /// The suffix of the names of its columns.
    pub fn word(self) -> &'static str {
        Deltas::WORDS.iter().find(|d| d.1 == self).map_or("", |d| d.0)
    }
}

words! {
    Deltas: DeltaName {
        "smeared" = DeltaName::Smeared,
        "smereka1" = DeltaName::Smereka1,
        "smereka2" = DeltaName::Smereka2,
        "towers" = DeltaName::Towers,
    } twice "the delta function stands twice in the list", "name each once"
}

table! {
    /// The curve in which two interfaces meet: its length, curvature and torsion, in `series.csv`.
    Curve {
        /// The membranes, drops or level sets.
        of: Vec<String> [TwoNames, Required("name two interfaces: of = [\"a\", \"b\"]")],
    } before Curve::before;
}

kinds! {
    /// Names of interfaces.
    TwoNames: Vec<String> = Kind::Value("list of two names", Form::List(&Form::Text, [2, 2])),
        |i, _| i.list()?.iter().map(|i| i.text().map(str::to_string)).collect();
}

impl Curve {
    /// Rejects curves in the plane.
    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        if context.dimension == 3 {
            return Ok(());
        }
        let what = "interfaces of the plane meet in points, not in curves";
        Err(table.key_error(what).remedy("leave output.curves out"))
    }

    /// Checks that a curve belongs to two of the `interfaces` of a scene.
    pub(in crate::scene) fn check(&self, item: &Item, interfaces: &[&str]) -> Result<()> {
        let Some(named) = item.open_table()?.get("of") else { return Ok(()) };
        let known = format!("the scene has {}", interfaces.join(", "));
        if let Some(other) = self.of.iter().find(|n| !interfaces.contains(&n.as_str())) {
            return Err(named.error(format!("there is no interface `{other}`")).remedy(known));
        }
        match &self.of[..] {
            [a, b] if a != b => Ok(()),
            _ => Err(named.error("a curve needs two interfaces that differ").remedy(known)),
        }
    }
}
