//! Typed reading of values, with errors that give position, value and remedy.

use super::document::{Document, Entry, Node, Place, Value};
use super::{Absent, Keys};
use crate::base::{Error, Result};
use crate::scene::expression::Expression;
use crate::scene::nearest::{advice, nearest};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Properties of the scene that the reading of values depends on.
#[derive(Clone)]
pub(in crate::scene) struct Context {
    /// Components of a vector: 2 or 3.
    pub dimension: usize,
    pub constants: BTreeMap<String, f64>,
    /// The folder that paths are relative to.
    pub folder: PathBuf,
}

/// A value with its key.
#[derive(Clone)]
pub(in crate::scene) struct Item<'a> {
    document: &'a Document,
    node: &'a Node,
    /// The position of the key, or of the value if it has no key (in a list).
    key_place: &'a Place,
    /// The path of keys, joined by dots.
    pub key: String,
}

/// A table with validated keys.
pub(in crate::scene) struct Table<'a> {
    document: &'a Document,
    entries: &'a [Entry],
    place: &'a Place,
    key: String,
}

/// The largest magnitude of a number in a scene; its square and cube remain finite.
const LARGEST: f64 = 1e100;

impl<'a> Item<'a> {
    /// The whole scene.
    pub fn root(document: &'a Document) -> Item<'a> {
        Item { document, node: &document.root, key_place: &document.root.place, key: String::new() }
    }

    /// An error about this value.
    pub fn error(&self, what: impl Into<String>) -> Error {
        let table = matches!(self.node.value, Value::Table(_));
        let place = if table { self.key_place } else { &self.node.place };
        let value = self.document.written(place);
        let error = self.document.error(place, &self.key, what);
        if value.is_empty() { error } else { error.value(value) }
    }

    /// An error about the key of this value.
    pub fn key_error(&self, what: impl Into<String>) -> Error {
        let value = self.document.written(self.key_place);
        self.document.error(self.key_place, &self.key, what).value(value)
    }

    /// Attaches the position of this value to an error.
    pub fn blame(&self, error: Error) -> Error {
        let placed = self.error("");
        let error = error.at(placed.place());
        match placed.source_snippet() {
            Some(snippet) => error.snippet(snippet.clone()),
            None => error,
        }
    }

    fn wrong_kind(&self, expected: &str) -> Error {
        self.error(format!("`{}` is {}, but must be {expected}", self.key, self.node.value.kind()))
    }

    fn child(&self, node: &'a Node, key_place: &'a Place, key: &str) -> Item<'a> {
        Item { document: self.document, node, key_place, key: joined(&self.key, key) }
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64> {
        let v = match self.node.value {
            Value::Integer(i) => i as f64,
            Value::Float(f) => f,
            _ => {
                return Err(self
                    .wrong_kind("a number")
                    .remedy("write a number without quotes or units, such as 0.5"));
            }
        };
        if !v.is_finite() || v.abs() > LARGEST {
            let what = if v.is_finite() { "is too large" } else { "must be a finite number" };
            return Err(self
                .error(format!("`{}` {what}", self.key))
                .remedy(format!("give a number between -{LARGEST:e} and {LARGEST:e}")));
        }
        Ok(v)
    }

    /// A number > 0.
    pub fn positive(&self) -> Result<f64> {
        let v = self.number()?;
        if v > 0.0 { Ok(v) } else { Err(self.out_of_range("positive", "> 0")) }
    }

    /// A number >= 0.
    pub fn non_negative(&self) -> Result<f64> {
        let v = self.number()?;
        if v >= 0.0 { Ok(v) } else { Err(self.out_of_range("positive or zero", ">= 0")) }
    }

    fn out_of_range(&self, words: &str, range: &str) -> Error {
        self.error(format!("`{}` must be {words}", self.key))
            .remedy(format!("give a number {range}"))
    }

    /// An integer from `least` to `most`.
    pub fn count(&self, least: usize, most: usize) -> Result<usize> {
        let Value::Integer(i) = self.node.value else {
            return Err(self
                .wrong_kind("a whole number")
                .remedy(format!("give one from {least} to {most}")));
        };
        match usize::try_from(i) {
            Ok(n) if (least..=most).contains(&n) => Ok(n),
            _ => Err(self
                .error(format!("`{}` is out of range", self.key))
                .remedy(format!("give a whole number from {least} to {most}"))),
        }
    }

    /// True or false.
    pub fn boolean(&self) -> Result<bool> {
        match self.node.value {
            Value::Boolean(b) => Ok(b),
            _ => {
                Err(self.wrong_kind("true or false").remedy("write true or false, without quotes"))
            }
        }
    }

    /// A text.
    pub fn text(&self) -> Result<&'a str> {
        match &self.node.value {
            Value::Text(s) => Ok(s),
            _ => Err(self.wrong_kind("text").remedy("write it in \"quotes\"")),
        }
    }

    /// True if the value is the text `word`.
    pub fn is_word(&self, word: &str) -> bool {
        matches!(&self.node.value, Value::Text(s) if s == word)
    }

    /// True if the value is `false`.
    pub fn is_false(&self) -> bool {
        matches!(self.node.value, Value::Boolean(false))
    }

    /// True if the value is the number 0.
    pub fn is_zero(&self) -> bool {
        matches!(self.node.value, Value::Integer(0))
    }

    /// True if the value is a table.
    pub fn is_table(&self) -> bool {
        matches!(self.node.value, Value::Table(_))
    }

    /// One of the named values.
    pub fn choice<T: Copy>(&self, choices: &[(&'static str, T)]) -> Result<T> {
        let word = self.text()?;
        choices.iter().find(|c| c.0 == word).map(|c| c.1).ok_or_else(|| {
            self.error(format!("`{word}` is not a value of `{}`", self.key))
                .remedy(advice(word, choices.iter().map(|c| c.0)))
        })
    }

    /// The items of a list.
    pub fn list(&self) -> Result<Vec<Item<'a>>> {
        let Value::Array(nodes) = &self.node.value else {
            let remedy = match self.is_table() {
                true => format!("write [[{}]] with two brackets", self.key),
                false => "write it in brackets, as in [0, 1]".to_string(),
            };
            return Err(self.wrong_kind("a list").remedy(remedy));
        };
        Ok(nodes.iter().enumerate().map(|(i, n)| self.child(n, &n.place, &i.to_string())).collect())
    }

    /// The items of a list of length `n`, one for each dimension of the scene.
    fn components_of(&self, n: usize) -> Result<Vec<Item<'a>>> {
        let advice = format!("give {n} values in brackets; the scene has {n} dimensions");
        self.list_of(n).map_err(|e| if self.list().is_ok() { e.remedy(advice) } else { e })
    }

    /// The items of a list of length `n`.
    fn list_of(&self, n: usize) -> Result<Vec<Item<'a>>> {
        let items = self.list()?;
        if items.len() != n {
            let (key, found) = (&self.key, items.len());
            return Err(self
                .error(format!(
                    "`{key}` has {found} component{}, but needs {n}",
                    if found == 1 { "" } else { "s" }
                ))
                .remedy(format!("give {n} values in brackets")));
        }
        Ok(items)
    }

    /// A vector of `N` numbers.
    pub fn vector<const N: usize>(&self) -> Result<[f64; N]> {
        let mut v = [0.0; N];
        for (v, item) in v.iter_mut().zip(self.list_of(N)?) {
            *v = item.number()?;
        }
        Ok(v)
    }

    /// A vector of `N` integers from 1 to `most`.
    pub fn counts<const N: usize>(&self, most: usize) -> Result<[usize; N]> {
        let mut v = [0; N];
        for (v, item) in v.iter_mut().zip(self.list_of(N)?) {
            *v = item.count(1, most)?;
        }
        Ok(v)
    }

    /// A list of `n` numbers.
    pub fn numbers(&self, n: usize) -> Result<Vec<f64>> {
        self.list_of(n)?.iter().map(Item::number).collect()
    }

    /// A vector with one number for each dimension of the scene.
    pub fn point(&self, context: &Context) -> Result<Vec<f64>> {
        self.components_of(context.dimension)?.iter().map(Item::number).collect()
    }

    /// A vector with one number or expression for each dimension of the scene.
    pub fn components(&self, context: &Context) -> Result<Vec<Expression>> {
        self.components_of(context.dimension)?
            .iter()
            .map(|i| i.expression(&context.constants))
            .collect()
    }

    /// A number or an expression.
    pub fn expression(&self, constants: &BTreeMap<String, f64>) -> Result<Expression> {
        let Value::Text(text) = &self.node.value else {
            let number = self.number().map(Expression::constant);
            return match self.node.value {
                Value::Integer(_) | Value::Float(_) => number,
                _ => Err(self
                    .wrong_kind("a number or an expression")
                    .remedy("write 0.5 or \"sin(pi * x)\"")),
            };
        };
        let expression = Expression::parse(text, constants).map_err(|e| {
            let place = self.inside(text, &e.at);
            let remedy =
                if e.hint.is_empty() { "write an expression such as \"1 - x^2\"" } else { &e.hint };
            let wrong = text.get(e.at.clone()).filter(|w| !w.is_empty()).unwrap_or(text);
            self.document.error(&place, &self.key, e.message.clone()).value(wrong).remedy(remedy)
        })?;
        if expression.is_constant().is_some_and(|v| !v.is_finite()) {
            return Err(self
                .error(format!("the expression of `{}` has no finite value", self.key))
                .remedy(
                    "look for a division by zero or a root or logarithm of a negative number",
                ));
        }
        Ok(expression)
    }

    /// The position of the bytes `at` of the text in this value; the whole value if it contains
    /// escapes.
    fn inside(&self, text: &str, at: &std::ops::Range<usize>) -> Place {
        let place = &self.node.place;
        let source = self.document.sources.get(place.source).map_or("", |s| s.text.as_str());
        match source.get(place.span.clone()).and_then(|written| written.find(text)) {
            Some(offset) if !text.is_empty() => {
                let start = place.span.start + offset;
                Place { source: place.source, span: start + at.start..start + at.end }
            }
            _ => place.clone(),
        }
    }

    /// The value as a table, whose keys must all be among `known`.
    pub fn table(&self, known: &Keys) -> Result<Table<'a>> {
        let table = self.open_table()?;
        match table.entries.iter().find(|e| known.get(&e.key).is_none()) {
            None => Ok(table),
            Some(entry) => {
                let place = if self.key.is_empty() {
                    "the scene".to_string()
                } else {
                    format!("`{}`", self.key)
                };
                let all = known.names().collect::<Vec<_>>().join(", ");
                let remedy = match nearest(&entry.key, known.names()) {
                    Some(n) => format!("did you mean `{n}`? Valid keys here: {all}"),
                    None => format!("valid keys here: {all}"),
                };
                Err(self
                    .child(&entry.node, &entry.key_place, &entry.key)
                    .key_error(format!("`{}` is not a key of {place}", entry.key))
                    .remedy(remedy))
            }
        }
    }

    /// The value as a table with arbitrary keys.
    pub fn open_table(&self) -> Result<Table<'a>> {
        match &self.node.value {
            Value::Table(entries) => Ok(Table {
                document: self.document,
                entries,
                place: self.key_place,
                key: self.key.clone(),
            }),
            _ => Err(self.wrong_kind("a table").remedy("write it as [name] or { key = value }")),
        }
    }
}

impl<'a> Table<'a> {
    /// The value of `key`, if present.
    pub fn get(&self, key: &str) -> Option<Item<'a>> {
        self.entries.iter().find(|e| e.key == key).map(|e| self.item(e))
    }

    fn item(&self, entry: &'a Entry) -> Item<'a> {
        let key = joined(&self.key, &entry.key);
        Item { document: self.document, node: &entry.node, key_place: &entry.key_place, key }
    }

    /// The table `key`, whose keys must all be among `known`; an empty table if absent.
    pub fn inner(&self, key: &str, known: &Keys) -> Result<Table<'a>> {
        match self.get(key) {
            Some(item) => item.table(known),
            None => Ok(Table { entries: &[], key: joined(&self.key, key), ..*self }),
        }
    }

    /// The default value `node` for the absent key `key`.
    pub fn unwritten<'b>(&'b self, key: &str, node: &'b Node) -> Item<'b> {
        Item { document: self.document, node, key_place: &node.place, key: joined(&self.key, key) }
    }

    /// An error about the key of this table.
    pub fn key_error(&self, what: impl Into<String>) -> Error {
        self.document.error(self.place, &self.key, what).value(self.document.written(self.place))
    }

    /// The last key of the path.
    pub fn name(&self) -> &str {
        self.key.rsplit('.').next().unwrap_or_default()
    }

    /// All entries with their names.
    pub fn items(&self) -> impl Iterator<Item = (&'a str, Item<'a>)> {
        self.entries.iter().map(|e| (e.key.as_str(), self.item(e)))
    }

    /// The value of `key` read by `read`, if present.
    pub fn optional<T>(
        &self,
        key: &str,
        read: impl FnOnce(&Item<'a>) -> Result<T>,
    ) -> Result<Option<T>> {
        self.get(key).map(|i| read(&i)).transpose()
    }

    /// The value of `key` read by `read`; `remedy` is the advice if it is missing.
    pub fn required<T>(
        &self,
        key: &str,
        remedy: &str,
        read: impl FnOnce(&Item<'a>) -> Result<T>,
    ) -> Result<T> {
        match self.get(key) {
            Some(item) => read(&item),
            None => Err(self.missing(&format!("`{key}`"), key).remedy(remedy)),
        }
    }

    /// The single key among `keys` that is present, with its value; an error if there is none or
    /// more than one.
    pub fn exactly_one(&self, keys: &Keys) -> Result<(&'static str, Item<'a>)> {
        let names = || keys.keys.iter().filter(|k| k.absent == Absent::OneOf).map(|k| k.name);
        let mut found = names().filter_map(|k| self.get(k).map(|i| (k, i)));
        let all = names().collect::<Vec<_>>().join(", ");
        let Some(first) = found.next() else {
            return Err(self
                .missing(&format!("one of {all}"), "")
                .remedy(format!("give exactly one of {all}")));
        };
        match found.next() {
            None => Ok(first),
            Some((second, item)) => Err(item
                .key_error(format!(
                    "`{second}` cannot stand beside `{}` in `{}`",
                    first.0, self.key
                ))
                .remedy(format!("keep exactly one of {all}"))),
        }
    }

    /// The error for a missing value.
    fn missing(&self, what: &str, key: &str) -> Error {
        let place =
            if self.key.is_empty() { "the scene".to_string() } else { format!("`{}`", self.key) };
        let error = self.document.error(
            self.place,
            &joined(&self.key, key),
            format!("{what} is missing in {place}"),
        );
        error.value("nothing is given")
    }
}

fn joined(parent: &str, key: &str) -> String {
    match (parent, key) {
        ("", key) => key.to_string(),
        (parent, "") => parent.to_string(),
        (parent, key) => format!("{parent}.{key}"),
    }
}
