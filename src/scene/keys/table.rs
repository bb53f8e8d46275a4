//! Declaration of a table in one place: its struct, reference, reading and writing.

use super::document::{Place, Value, parse_value};
use super::item::{Context, Item, Table};
use super::typed::{Entries, Typed};
use super::{Keys, Writer};
use crate::base::{Error, Result};

/// A table of a scene.
pub(in crate::scene) trait Tabled: Sized {
    /// Its keys.
    const KEYS: &'static Keys;
    /// Reads the values from a table with validated keys.
    ///
    /// # Errors
    /// Invalid values, with their position and a remedy.
    fn read_table(table: &Table<'_>, context: &Context) -> Result<Self>;
    /// Its keys with their values in TOML.
    fn entries(&self) -> Entries;
    /// Reads the table from a value.
    ///
    /// # Errors
    /// Those of [`read_table`](Tabled::read_table), and unknown keys.
    fn read(item: &Item<'_>, context: &Context) -> Result<Self> {
        Self::read_table(&item.table(Self::KEYS)?, context)
    }
    /// Reads the table `key`; an absent table is read as an empty one.
    ///
    /// # Errors
    /// Those of [`read`](Tabled::read).
    fn read_inner(table: &Table<'_>, key: &str, context: &Context) -> Result<Self> {
        Self::read_table(&table.inner(key, Self::KEYS)?, context)
    }
    /// The table on one line.
    fn inline(&self) -> String {
        let entries = self.entries().into_iter().map(|(key, value)| format!("{key} = {value}"));
        format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
    }
    /// Writes the table under its header.
    fn section(&self, header: &str, out: &mut Writer) {
        out.header(header);
        out.entries(self.entries());
    }
}

/// A table with a name from the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Named<T> {
    /// The name in results.
    pub name: String,
    /// The table.
    pub table: T,
}

impl<T> std::ops::Deref for Named<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.table
    }
}

/// The entries, those with the keys in `order` moved to the end.
pub(in crate::scene) fn last(mut entries: Entries, order: &[&str]) -> Entries {
    entries.sort_by_key(|(key, _)| {
        let first = key.split('.').next();
        order.iter().position(|k| Some(*k) == first).map_or(0, |place| place + 1)
    });
    entries
}

/// The value of `key`, if present.
pub(in crate::scene) fn optional<K: Typed>(
    table: &Table<'_>,
    key: &str,
    context: &Context,
) -> Result<Option<K::Out>> {
    table.get(key).map(|i| K::read(&i, context)).transpose()
}

/// The value of `key`. The remedy for a missing key is the first one, in space the last, with
/// `{here}` replaced by the name of the table.
pub(in crate::scene) fn required<K: Typed>(
    table: &Table<'_>,
    key: &str,
    remedies: &[&str],
    context: &Context,
) -> Result<K::Out> {
    let remedy = if context.dimension == 3 { remedies.last() } else { remedies.first() };
    let remedy = remedy.map_or_else(String::new, |r| r.replace("{here}", table.name()));
    table.required(key, &remedy, |i| K::read(i, context))
}

/// The value of `key`, or the value of the TOML text `default`.
pub(in crate::scene) fn or_default<K: Typed>(
    table: &Table<'_>,
    key: &str,
    default: &str,
    context: &Context,
) -> Result<K::Out> {
    if let Some(item) = table.get(key) {
        return K::read(&item, context);
    }
    let wrong = |e| Error::internal(format!("the default {default} of `{key}`: {e}"));
    let mut node = parse_value(default, Place::NOWHERE, 0).map_err(wrong)?;
    if let (true, Value::Array(items)) = (K::SPATIAL, &mut node.value)
        && let Some(last) = items.last().cloned()
    {
        items.resize(context.dimension, last);
    }
    K::read(&table.unwritten(key, &node), context)
}

/// Joins several lines of documentation, each of which begins with a space.
pub(in crate::scene) const fn joined(lines: &'static str) -> &'static str {
    lines.split_at(1).1
}

/// Declares a table:
///
/// ```text
/// table! {
///     /// Meaning of the table.
///     Name {
///         /// Meaning of the key.
///         key: Type [Kind, "unit", Absent],
///     }
///     before function; check function; hide function;
/// }
/// ```
///
/// defines the struct `Name` with reference, reading and writing of its keys. Further
/// derived traits follow the name after a colon. The unit is optional. `Absent` is
/// - `Required("remedy")`, with a second remedy for scenes of space;
/// - `Default(value in TOML)`;
/// - `Derived("words")`, with the initial value if it is not the default of the type;
/// - `OneOf`;
/// - `Inner`, which reads an absent table as an empty one;
/// - or absent, for the default meaning of the kind.
///
/// `before` is called with the table before reading and rejects invalid combinations of keys;
/// `check` is called after reading and may change the values; `hide` selects the keys that are not
/// written.
macro_rules! table {
    ($(#[doc = $about:literal])* $name:ident $(: $($more:ident),+)? {
        $($(#[doc = $doc:literal])* $key:ident: $out:ty
            [$kind:ty $(, $unit:literal)? $(, $absent:ident $(($($arg:tt)*))?)?],)*
    } $(before $before:path;)? $(check $check:path;)? $(hide $hide:path;)?) => {
        $(#[doc = $about])*
        #[derive(Clone, Debug, PartialEq $($(, $more)+)?)]
        pub struct $name {
            $($(#[doc = $doc])* pub $key: $out,)*
        }
        impl $crate::scene::keys::Tabled for $name {
            const KEYS: &'static $crate::scene::keys::Keys = {
                static KEYS: $crate::scene::keys::Keys = $crate::scene::keys::Keys {
                    about: $crate::scene::keys::joined(concat!($($about),*)),
                    keys: &[$($crate::scene::keys::Key {
                        name: stringify!($key),
                        kind: <$kind as $crate::scene::keys::Typed>::KIND,
                        unit: concat!($($unit)?),
                        absent: $crate::scene::keys::table!(@absent $kind $(, $absent $(($($arg)*))?)?),
                        doc: $crate::scene::keys::joined(concat!($($doc),*)),
                    }),*],
                };
                &KEYS
            };
            fn read_table(
                table: &$crate::scene::keys::Table<'_>,
                context: &$crate::scene::keys::Context,
            ) -> $crate::base::Result<Self> {
                $($before(table, context)?;)?
                #[allow(unused_mut, reason = "a table without checks is not changed")]
                let mut read = $name {
                    $($key: $crate::scene::keys::table!(
                        @read table, $key, context, $kind $(, $absent $(($($arg)*))?)?
                    )),*
                };
                $($check(&mut read, table, context)?;)?
                Ok(read)
            }
            fn entries(&self) -> $crate::scene::keys::Entries {
                let mut entries = $crate::scene::keys::Entries::new();
                $(<$kind as $crate::scene::keys::Typed>::write(
                    &self.$key, stringify!($key), &mut entries,
                );)*
                $(entries.retain(|(key, _)| !$hide(self, key));)?
                entries
            }
        }
    };
    (@absent $kind:ty) => { <$kind as $crate::scene::keys::Typed>::ABSENT };
    (@absent $kind:ty, Required($($remedy:tt)*)) => { $crate::scene::keys::Absent::Required };
    (@absent $kind:ty, Default($($text:tt)*)) => {
        $crate::scene::keys::Absent::Default(stringify!($($text)*))
    };
    (@absent $kind:ty, Derived($words:literal $($more:tt)*)) => {
        $crate::scene::keys::Absent::Derived($words)
    };
    (@absent $kind:ty, OneOf) => { $crate::scene::keys::Absent::OneOf };
    (@absent $kind:ty, Inner) => { $crate::scene::keys::Absent::Optional };
    (@read $table:ident, $key:ident, $context:ident, $kind:ty, Required($($remedy:expr),+)) => {
        $crate::scene::keys::required::<$kind>($table, stringify!($key), &[$($remedy),+], $context)?
    };
    (@read $table:ident, $key:ident, $context:ident, $kind:ty, Default($($text:tt)*)) => {
        $crate::scene::keys::or_default::<$kind>(
            $table, stringify!($key), stringify!($($text)*), $context,
        )?
    };
    (@read $table:ident, $key:ident, $context:ident, $kind:ty, Derived($words:literal, $first:expr)) => {
        $crate::scene::keys::optional::<$kind>($table, stringify!($key), $context)?.unwrap_or($first)
    };
    (@read $table:ident, $key:ident, $context:ident, $kind:ty, Inner) => {
        $crate::scene::keys::Tabled::read_inner($table, stringify!($key), $context)?
    };
    (@read $table:ident, $key:ident, $context:ident, $kind:ty $(, $absent:ident $(($($arg:tt)*))?)?) => {
        $crate::scene::keys::optional::<$kind>($table, stringify!($key), $context)?.unwrap_or_default()
    };
}
pub(in crate::scene) use table;

/// Declares a table with exactly one of its keys, for an enum that is defined elsewhere:
///
/// ```text
/// one_of! {
///     /// Meaning of the table.
///     Name {
///         /// Meaning of the key.
///         "key" [Kind, "unit"] (pattern) => (Name::Variant);
///     }
///     check function
/// }
/// ```
///
/// The pattern binds the value read by `Kind`, from which the variant is built; writing uses them
/// in reverse. `check` is called with the key before its value is read.
macro_rules! one_of {
    ($(#[doc = $about:literal])* $name:ident {
        $($(#[doc = $doc:literal])* $key:literal
            [$kind:ty $(, $unit:literal)?] ($($inner:tt)*) => ($($outer:tt)*);)*
    } $(check $check:path)?) => {
        impl $crate::scene::keys::Tabled for $name {
            const KEYS: &'static $crate::scene::keys::Keys = {
                static KEYS: $crate::scene::keys::Keys = $crate::scene::keys::Keys {
                    about: $crate::scene::keys::joined(concat!($($about),*)),
                    keys: &[$($crate::scene::keys::Key {
                        name: $key,
                        kind: <$kind as $crate::scene::keys::Typed>::KIND,
                        unit: concat!($($unit)?),
                        absent: $crate::scene::keys::Absent::OneOf,
                        doc: $crate::scene::keys::joined(concat!($($doc),*)),
                    }),*],
                };
                &KEYS
            };
            fn read_table(
                table: &$crate::scene::keys::Table<'_>,
                context: &$crate::scene::keys::Context,
            ) -> $crate::base::Result<Self> {
                let (key, item) = table.exactly_one(Self::KEYS)?;
                $($check(key, &item, context)?;)?
                $(if key == $key {
                    let $($inner)* = <$kind as $crate::scene::keys::Typed>::read(&item, context)?;
                    return Ok($($outer)*);
                })*
                Err($crate::base::Error::internal("a key that nothing reads"))
            }
            fn entries(&self) -> $crate::scene::keys::Entries {
                let mut entries = $crate::scene::keys::Entries::new();
                #[allow(unreachable_patterns, reason = "an enum may have variants that no key stands for")]
                match Clone::clone(self) {
                    $($($outer)* => <$kind as $crate::scene::keys::Typed>::write(
                        &$($inner)*, $key, &mut entries,
                    ),)*
                    _ => (),
                }
                entries
            }
        }
    };
}
pub(in crate::scene) use one_of;
