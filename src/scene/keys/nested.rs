//! Tables as values of keys: one table, and tables that are named by the scene.

use super::item::{Context, Item};
use super::table::{Named, Tabled};
use super::typed::{Entries, Typed};
use super::{Kind, key, named};
use crate::base::Result;
use std::marker::PhantomData;

/// A table.
pub(in crate::scene) struct Nested<T>(PhantomData<T>);

impl<T: Tabled> Typed for Nested<T> {
    type Out = T;
    const KIND: Kind = Kind::Table(T::KEYS);
    fn read(item: &Item<'_>, context: &Context) -> Result<T> {
        T::read(item, context)
    }
    fn toml(out: &T) -> String {
        out.inline()
    }
}

impl<T: Tabled> Typed for Named<T> {
    type Out = Vec<Named<T>>;
    const KIND: Kind = Kind::Named(T::KEYS);
    fn read(item: &Item<'_>, context: &Context) -> Result<Self::Out> {
        named(item, |name, item| Ok(Named { name, table: T::read(item, context)? }))
    }
    fn toml(out: &Self::Out) -> String {
        let entries = out.iter().map(|t| format!("{} = {}", key(&t.name), t.table.inline()));
        format!("{{ {} }}", entries.collect::<Vec<_>>().join(", "))
    }
    fn write(out: &Self::Out, name: &str, to: &mut Entries) {
        to.extend(out.iter().map(|t| (format!("{name}.{}", key(&t.name)), t.table.inline())));
    }
}
