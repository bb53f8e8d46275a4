//! Kinds of values: each is named in the reference, read and written in one place.

use super::item::{Context, Item};
use super::write::{Toml, text};
use super::{Absent, Form, Kind, list};
use crate::base::Result;
use crate::scene::expression::Expression;
use std::marker::PhantomData;

/// Keys with their values in TOML.
pub(in crate::scene) type Entries = Vec<(String, String)>;

/// A kind of value that a key can have.
pub(in crate::scene) trait Typed {
    /// The type of the value after reading.
    type Out;
    /// Its name in the reference.
    const KIND: Kind;
    /// Default meaning of an absent key.
    const ABSENT: Absent = Absent::Optional;
    /// True if the value has one component for each dimension. A default for the plane is extended
    /// to space with its last component.
    const SPATIAL: bool = false;
    /// Reads the value.
    ///
    /// # Errors
    /// An invalid value, with its position and a remedy.
    fn read(item: &Item<'_>, context: &Context) -> Result<Self::Out>;
    /// The value as TOML.
    fn toml(out: &Self::Out) -> String;
    /// Adds the entries of `key`.
    fn write(out: &Self::Out, key: &str, to: &mut Entries) {
        to.push((key.to_string(), Self::toml(out)));
    }
}

/// Declares kinds of values: `Name: Type = kind, read;`, with `spatial` for one component a
/// dimension.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident $(<$(const $n:ident),+>)?: $out:ty = $kind:expr, $read:expr
        $(, $spatial:ident)?;)*) => {$(
        $(#[$doc])*
        pub(in crate::scene) struct $name $(<$(const $n: usize),+>)?;
        impl $(<$(const $n: usize),+>)? $crate::scene::keys::Typed for $name $(<$($n),+>)? {
            type Out = $out;
            const KIND: $crate::scene::keys::Kind = $kind;
            $($crate::scene::keys::kinds!(@$spatial);)?
            fn read(
                item: &$crate::scene::keys::Item<'_>,
                context: &$crate::scene::keys::Context,
            ) -> $crate::base::Result<$out> {
                let read: fn(
                    &$crate::scene::keys::Item<'_>,
                    &$crate::scene::keys::Context,
                ) -> $crate::base::Result<$out> = $read;
                read(item, context)
            }
            fn toml(out: &$out) -> String {
                $crate::scene::keys::Toml::toml(out)
            }
        }
    )*};
    (@spatial) => { const SPATIAL: bool = true; };
}
pub(in crate::scene) use kinds;

kinds! {
    /// A finite number.
    Number: f64 = Kind::Value("number", Form::NUMBER), |i, _| i.number();
    /// A number > 0.
    Positive: f64 = Kind::Value("number > 0", Form::POSITIVE), |i, _| i.positive();
    /// A number >= 0.
    NonNegative: f64 = Kind::Value("number >= 0", Form::least(0.0)), |i, _| i.non_negative();
    /// True or false.
    Flag: bool = Kind::Value("true or false", Form::Flag), |i, _| i.boolean();
    /// A text.
    Text: String = Kind::Value("text", Form::Text), |i, _| i.text().map(str::to_string);
    /// A text that becomes part of column and file names.
    Identifier: String = Kind::Value("text", Form::Text), |i, _| super::identifier(i);
    /// A whole number from `LEAST` to `MOST`.
    Count<const LEAST, const MOST>: usize = Kind::Count([LEAST, MOST]), |i, _| i.count(LEAST, MOST);
    /// A point of `N` coordinates.
    Vector<const N>: [f64; N] =
        Kind::Value("point", Form::List(&Form::NUMBER, [N, N])), |i, _| i.vector();
    /// A list of `N` numbers.
    Numbers<const N>: [f64; N] = Kind::Numbers(N), |i, _| i.vector();
    /// A list of `N` whole numbers from 1 to `MOST`.
    Counts<const N, const MOST>: [usize; N] = Kind::Counts(N, [1, MOST]), |i, _| i.counts(MOST);
    /// A point of the scene.
    Point: Vec<f64> = Kind::Value("point", Form::POINT), |i, c| i.point(c), spatial;
    /// A vector of the scene.
    Direction: Vec<f64> = Kind::Value("vector of numbers", Form::POINT), |i, c| i.point(c), spatial;
    /// A vector of numbers or expressions.
    Components: Vec<Expression> =
        Kind::Value("vector of numbers or expressions", Form::EXPRESSIONS), |i, c| i.components(c), spatial;
}

/// Declares the words of a choice: `Name: Type { "word" = value, ... }`.
///
/// The name is a kind of value. [`Set`] is a list of such words; `twice` is followed by the error
/// for a repeated word and its remedy.
macro_rules! words {
    ($(#[$doc:meta])* $name:ident: $out:ty { $($word:literal = $value:expr),* $(,)? }
        $(twice $what:literal, $remedy:literal)?) => {
        $(#[$doc])*
        pub(in crate::scene) struct $name;
        impl $crate::scene::keys::Words for $name {
            const WORDS: &'static [(&'static str, $out)] = &[$(($word, $value)),*];
            $(const TWICE: [&'static str; 2] = [$what, $remedy];)?
        }
        impl $crate::scene::keys::Typed for $name {
            type Out = $out;
            const KIND: $crate::scene::keys::Kind = $crate::scene::keys::Kind::Choice(&[$($word),*]);
            fn read(
                item: &$crate::scene::keys::Item<'_>,
                _: &$crate::scene::keys::Context,
            ) -> $crate::base::Result<$out> {
                item.choice(<$name as $crate::scene::keys::Words>::WORDS)
            }
            fn toml(out: &$out) -> String {
                $crate::scene::keys::name(*out, <$name as $crate::scene::keys::Words>::WORDS)
            }
        }
    };
}
pub(in crate::scene) use words;

/// The words of a choice.
pub(in crate::scene) trait Words: Typed<Out: Copy + PartialEq + 'static> {
    /// Words with their values.
    const WORDS: &'static [(&'static str, Self::Out)];
    /// The error and the remedy for a word that is repeated in a list.
    const TWICE: [&'static str; 2] = ["the word stands twice in the list", "name each once"];
}

/// An optional value.
pub(in crate::scene) struct Opt<K>(PhantomData<K>);
/// A value, or "auto" for one derived by the plan.
pub(in crate::scene) struct Auto<K>(PhantomData<K>);
/// A value, or false for none.
pub(in crate::scene) struct OrFalse<K>(PhantomData<K>);
/// A list that is omitted if empty.
pub(in crate::scene) struct Many<K>(PhantomData<K>);
/// A list of distinct words.
pub(in crate::scene) struct Set<W>(PhantomData<W>);

impl<K: Typed> Typed for Opt<K> {
    type Out = Option<K::Out>;
    const KIND: Kind = K::KIND;
    fn read(item: &Item<'_>, context: &Context) -> Result<Self::Out> {
        K::read(item, context).map(Some)
    }
    fn toml(out: &Self::Out) -> String {
        out.as_ref().map_or_else(String::new, K::toml)
    }
    fn write(out: &Self::Out, key: &str, to: &mut Entries) {
        out.iter().for_each(|v| K::write(v, key, to));
    }
}

impl<K: Typed> Typed for Auto<K> {
    type Out = Option<K::Out>;
    const KIND: Kind = K::KIND;
    const ABSENT: Absent = Absent::Auto;
    fn read(item: &Item<'_>, context: &Context) -> Result<Self::Out> {
        if item.is_word("auto") { Ok(None) } else { K::read(item, context).map(Some) }
    }
    fn toml(out: &Self::Out) -> String {
        out.as_ref().map_or_else(|| text("auto"), K::toml)
    }
}

impl<K: Typed> Typed for OrFalse<K> {
    type Out = Option<K::Out>;
    const KIND: Kind = match K::KIND {
        Kind::Value(words, form) => Kind::OrFalse(words, form),
        Kind::Choice(words) => Kind::ChoiceOrFalse(words),
        other => other,
    };
    fn read(item: &Item<'_>, context: &Context) -> Result<Self::Out> {
        if item.is_false() { Ok(None) } else { K::read(item, context).map(Some) }
    }
    fn toml(out: &Self::Out) -> String {
        out.as_ref().map_or_else(|| false.toml(), K::toml)
    }
}

impl<T, K: Typed<Out = Vec<T>>> Typed for Many<K> {
    type Out = Vec<T>;
    const KIND: Kind = K::KIND;
    fn read(item: &Item<'_>, context: &Context) -> Result<Self::Out> {
        K::read(item, context)
    }
    fn toml(out: &Self::Out) -> String {
        K::toml(out)
    }
    fn write(out: &Self::Out, key: &str, to: &mut Entries) {
        if !out.is_empty() {
            K::write(out, key, to);
        }
    }
}

impl<W: Words> Typed for Set<W> {
    type Out = Vec<W::Out>;
    const KIND: Kind = match W::KIND {
        Kind::Choice(words) => Kind::Set(words),
        other => other,
    };
    fn read(item: &Item<'_>, context: &Context) -> Result<Self::Out> {
        let mut found = Vec::new();
        for item in item.list()? {
            let value = W::read(&item, context)?;
            if found.contains(&value) {
                return Err(item.error(W::TWICE[0]).remedy(W::TWICE[1]));
            }
            found.push(value);
        }
        Ok(found)
    }
    fn toml(out: &Self::Out) -> String {
        list(out.iter().map(W::toml))
    }
}
