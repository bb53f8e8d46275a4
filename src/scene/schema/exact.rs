//! `[exact]`: a known solution, to which the run is compared.

use crate::scene::expression::Expression;
use crate::scene::keys::{Form, Kind, Opt, kinds, table};

table! {
    /// A solution that is known: its errors become columns of the series.
    Exact: Default {
        /// The velocity.
        velocity: Option<Vec<Expression>> [Opt<Velocity>, "m/s"],
        /// The pressure; up to a constant where nothing fixes it.
        pressure: Option<Expression> [Opt<Pressure>, "Pa"],
    }
}

kinds! {
    /// One expression a component.
    Velocity: Vec<Expression> = Kind::Value("two expressions of x, y, t", Form::EXPRESSIONS), |i, c| i.components(c);
    /// One expression.
    Pressure: Expression = Kind::Value("expression of x, y, t", Form::Expression), |i, c| i.expression(&c.constants);
}
