//! Keys of a scene: their descriptions, from which tables are read and the reference is printed, and
//! the typed reading and writing of values. Knows no particular table.

mod document;
mod item;
mod names;
mod write;

pub(crate) use super::nearest::advice;
pub(in crate::scene) use document::{Document, Entry, Node, Place, Source, Value, parse_value};
pub(in crate::scene) use item::{Context, Item, Table};
pub(in crate::scene) use names::{distinct, identifier, named};
pub(in crate::scene) use write::{Writer, expression, expressions, key, list, name, number, or_auto, text, vector};

/// The keys of a table.
#[derive(Debug)]
pub struct Keys {
    /// What the table is about, in a sentence.
    pub about: &'static str,
    /// All keys it may have.
    pub keys: &'static [Key],
}

/// A key of a table.
#[derive(Debug)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// What its value can be.
    pub kind: Kind,
    /// The unit in SI, for any consistent system; empty for a pure number and for words.
    pub unit: &'static str,
    /// What holds where the key is not written.
    pub absent: Absent,
    /// What it means, in sentences.
    pub doc: &'static str,
}

/// What the value of a key can be.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A value, in words.
    Value(&'static str),
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A table.
    Table(&'static Keys),
    /// A list of tables, `[[name]]`.
    List(&'static Keys),
    /// A table of tables that are named by the scene, `[name.NAME]`.
    Named(&'static Keys),
    /// A value, in words, or a table.
    Either(&'static str, &'static Keys),
}

/// What holds where a key is not written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// The scene is wrong.
    Required,
    /// Another key of the table is written: exactly one of them must be.
    OneOf,
    /// This value, in TOML.
    Default(&'static str),
    /// The word "auto", which may be written too: the plan decides.
    Auto,
    /// What these words say.
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

/// The words of a choice.
pub(in crate::scene) const fn words<T: Copy, const N: usize>(choices: &[(&'static str, T); N]) -> [&'static str; N] {
    let mut words = [""; N];
    let mut i = 0;
    while i < N {
        words[i] = choices[i].0;
        i += 1;
    }
    words
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
    /// The keys of the table, or of each of the tables, that the value is or can be.
    pub fn keys(&self) -> Option<&'static Keys> {
        match *self {
            Kind::Table(keys) | Kind::List(keys) | Kind::Named(keys) | Kind::Either(_, keys) => Some(keys),
            Kind::Value(_) | Kind::Choice(_) => None,
        }
    }
}
