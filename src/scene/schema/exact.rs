//! `[exact]`: a solution that is known, against which the run measures itself.

use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::keys::{Absent::Optional, Keys, Kind::Value, row};
use crate::scene::keys::{Context, Item};
use crate::scene::keys::{Writer, expression, expressions};

/// The exact solution; what is not known is not compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exact {
    /// The velocity, one expression of x, y and t a component.
    pub velocity: Option<Vec<Expression>>,
    /// The pressure.
    pub pressure: Option<Expression>,
}

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "A solution that is known: its errors become columns of the series.",
    keys: &[
        row("velocity", Value("two expressions of x, y, t"), "m/s", Optional, "The velocity."),
        row(
            "pressure",
            Value("expression of x, y, t"),
            "Pa",
            Optional,
            "The pressure; up to a constant where nothing fixes it.",
        ),
    ],
};

impl Exact {
    pub(in crate::scene) fn read(item: &Item, context: &Context) -> Result<Exact> {
        let table = item.table(&KEYS)?;
        Ok(Exact {
            velocity: table.optional("velocity", |i| i.components(context))?,
            pressure: table.optional("pressure", |i| i.expression(&context.constants))?,
        })
    }

    /// Writes the table, if anything is known.
    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        if self.velocity.is_none() && self.pressure.is_none() {
            return;
        }
        out.header("[exact]");
        if let Some(v) = &self.velocity {
            out.entry("velocity", expressions(v));
        }
        if let Some(p) = &self.pressure {
            out.entry("pressure", expression(p));
        }
    }
}
