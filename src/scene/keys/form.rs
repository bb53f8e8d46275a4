//! The form of values in TOML, for programs that check a scene without reading it.

/// The form of a value in TOML: what its words in the reference say, as far as no other value
/// matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A text.
    Text,
    /// True or false.
    Flag,
    /// True.
    True,
    /// True, or this word.
    TrueOr(&'static str),
    /// A number from `least` to `most`; if `open`, `least` itself is excluded.
    Number {
        /// Lower bound.
        least: f64,
        /// Upper bound.
        most: f64,
        /// True if the lower bound is excluded.
        open: bool,
    },
    /// A whole number from the first to the second.
    Whole([usize; 2]),
    /// A number, or a text with an expression.
    Expression,
    /// A list of such values, of so many at least and at most.
    List(&'static Form, [usize; 2]),
    /// A table whose keys are names, with such values.
    Names(&'static Form),
    /// A table as at this path of the scene.
    Like(&'static str),
}

impl Form {
    /// Any number.
    pub const NUMBER: Form = Form::least(f64::NEG_INFINITY);
    /// A number > 0.
    pub const POSITIVE: Form = Form::above(0.0);
    /// Components of a vector, in the plane or in space.
    pub const POINT: Form = Form::List(&Form::NUMBER, [2, 3]);
    /// Components of a vector, numbers or expressions.
    pub const EXPRESSIONS: Form = Form::List(&Form::Expression, [2, 3]);

    /// A number that is not below a bound.
    pub const fn least(least: f64) -> Form {
        Form::Number { least, most: f64::INFINITY, open: false }
    }
    /// A number above a bound.
    pub const fn above(least: f64) -> Form {
        Form::Number { least, most: f64::INFINITY, open: true }
    }
}
