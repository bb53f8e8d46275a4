//! Keys of a scene: their descriptions, from which tables are read and the reference is printed,
//! and the typed reading and writing of values. Independent of any particular table.

mod document;
mod form;
mod item;
mod names;
mod nested;
mod table;
mod typed;
mod write;

pub(crate) use super::nearest::advice;
pub(in crate::scene) use document::{Document, Entry, Node, Place, Source, Value, parse_value};
pub use form::Form;
pub(in crate::scene) use item::{Context, Item, Table};
pub(in crate::scene) use names::{distinct, identifier, named};
pub(in crate::scene) use nested::Nested;
pub use table::Named;
pub(in crate::scene) use table::{
    Tabled, joined, last, one_of, optional, or_default, required, table,
};
pub(in crate::scene) use typed::{
    Auto, Components, Count, Counts, Direction, Entries, Flag, Identifier, Many, NonNegative,
    Number, Numbers, Opt, OrFalse, Point, Positive, Set, Text, Typed, Vector, Words, kinds, words,
};
pub(in crate::scene) use write::{Toml, Writer, key, list, name, number, text};

/// The keys of a table.
#[derive(Debug)]
pub struct Keys {
    /// Meaning of the table, in a sentence.
    pub about: &'static str,
    /// All its keys.
    pub keys: &'static [Key],
}

/// A key of a table.
#[derive(Debug)]
pub struct Key {
    /// The name in TOML.
    pub name: &'static str,
    /// Its possible values.
    pub kind: Kind,
    /// The unit in SI, for any consistent system; empty for a pure number and for words.
    pub unit: &'static str,
    /// Meaning if the key is absent.
    pub absent: Absent,
    /// Meaning, in sentences.
    pub doc: &'static str,
}

/// Possible values of a key.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A value, in words and in its form.
    Value(&'static str, Form),
    /// A value, in words and in its form, or false.
    OrFalse(&'static str, Form),
    /// This many numbers.
    Numbers(usize),
    /// This many numbers > 0.
    Lengths(usize),
    /// An integer from the first to the second number.
    Count([usize; 2]),
    /// This many integers from the first to the second number.
    Counts(usize, [usize; 2]),
    /// One of these words.
    Choice(&'static [&'static str]),
    /// One of these words, or false.
    ChoiceOrFalse(&'static [&'static str]),
    /// A list of these words.
    Set(&'static [&'static str]),
    /// A table.
    Table(&'static Keys),
    /// A list of tables, `[[name]]`.
    List(&'static Keys),
    /// A table of tables that are named by the scene, `[name.NAME]`.
    Named(&'static Keys),
    /// A value, in words and in its form, or a table.
    Either(&'static str, Form, &'static Keys),
}

/// Meaning of an absent key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// An error.
    Required,
    /// Exactly one of several keys of the table must be present.
    OneOf,
    /// This value, in TOML.
    Default(&'static str),
    /// The word "auto", which may also be given: the value is derived by the plan.
    Auto,
    /// A derived value, described in words.
    Derived(&'static str),
    /// Nothing.
    Optional,
}

/// The description of the key `name`.
pub(in crate::scene) const fn row(
    name: &'static str,
    kind: Kind,
    unit: &'static str,
    absent: Absent,
    doc: &'static str,
) -> Key {
    Key { name, kind, unit, absent, doc }
}

impl Keys {
    /// The names of the keys.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone + use<> {
        self.keys.iter().map(|k| k.name)
    }

    /// The key of this name.
    pub fn get(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|k| k.name == name)
    }
}

impl Kind {
    /// The keys of the table, or of each table of the list, if the value can be one.
    pub fn keys(&self) -> Option<&'static Keys> {
        match *self {
            Kind::Table(keys) | Kind::List(keys) | Kind::Named(keys) | Kind::Either(_, _, keys) => {
                Some(keys)
            }
            _ => None,
        }
    }
}
