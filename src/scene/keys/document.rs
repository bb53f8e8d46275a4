//! A scene as a tree of values, each with its source position.

use crate::base::{Error, Result, Snippet};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Source position: in the file (source 0) or in the k-th override (source k).
#[derive(Clone, Debug, Default)]
pub(in crate::scene) struct Place {
    pub source: usize,
    pub span: Range<usize>,
}

/// A value of TOML.
#[derive(Clone, Debug)]
pub(in crate::scene) enum Value {
    Text(String),
    Integer(i64),
    Float(f64),
    Boolean(bool),
    Datetime,
    Array(Vec<Node>),
    Table(Vec<Entry>),
}

/// A value and its position.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Node {
    pub value: Value,
    pub place: Place,
}

/// A key of a table with its value; entries keep the order of the text, with overrides last.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Entry {
    pub key: String,
    pub key_place: Place,
    pub node: Node,
}

/// A source text.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Source {
    /// The name of the file, or `--set`.
    pub path: String,
    pub text: String,
}

/// The source texts of a scene and the tree of its values.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Document {
    pub sources: Vec<Source>,
    pub root: Node,
}

impl Place {
    /// The source of a value that is in no text.
    pub const NOWHERE: usize = usize::MAX;
}

impl Value {
    /// Type of the value, as a noun for error messages.
    pub fn kind(&self) -> &'static str {
        match self {
            Value::Text(_) => "text",
            Value::Integer(_) => "a whole number",
            Value::Float(_) => "a number",
            Value::Boolean(_) => "true or false",
            Value::Datetime => "a date",
            Value::Array(_) => "a list",
            Value::Table(_) => "a table",
        }
    }
}

impl Document {
    /// Reads the TOML `text` of the file `path`.
    pub fn parse(text: &str, path: &str) -> Result<Document> {
        let table = DeTable::parse(text).map_err(|e| syntax_error(text, path, &e))?;
        let end = text.len();
        let root = Node {
            value: table_value(table.get_ref(), 0, 0),
            place: Place { source: 0, span: end..end },
        };
        Ok(Document {
            sources: vec![Source { path: path.to_string(), text: text.to_string() }],
            root,
        })
    }

    /// The error `what` at `place`, with the key in words.
    pub fn error(&self, place: &Place, key: &str, what: impl Into<String>) -> Error {
        let error = Error::scene(what);
        let Some(source) = self.sources.get(place.source) else { return error };
        let snippet = Snippet {
            path: source.path.clone(),
            source: source.text.clone(),
            span: place.span.clone(),
        };
        let (line, column) = snippet.line_column();
        let file = if place.source == 0 {
            format!("{}:{line}:{column}", source.path)
        } else {
            format!("{} {}", source.path, source.text)
        };
        let key = if key.is_empty() { String::new() } else { format!(", key {key}") };
        error.at(format!("{file}{key}")).snippet(snippet)
    }

    /// The text at `place`, shortened.
    pub fn written(&self, place: &Place) -> String {
        let text = self
            .sources
            .get(place.source)
            .and_then(|s| s.text.get(place.span.clone()))
            .unwrap_or("");
        let line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if line.chars().count() <= 60 {
            line
        } else {
            format!("{} ...", line.chars().take(56).collect::<String>())
        }
    }

    /// The position of the value at `keys`, or of the innermost table on its path that is present.
    pub fn locate(&self, keys: &[&str]) -> Place {
        let mut node = &self.root;
        let mut place = &node.place;
        for key in keys {
            let next = match &node.value {
                Value::Table(entries) => {
                    entries.iter().find(|e| e.key == *key).map(|e| (&e.key_place, &e.node))
                }
                Value::Array(items) => {
                    key.parse().ok().and_then(|k: usize| items.get(k)).map(|n| (&n.place, n))
                }
                _ => None,
            };
            let Some((p, n)) = next else { break };
            (place, node) = (p, n);
        }
        if matches!(node.value, Value::Table(_)) { place.clone() } else { node.place.clone() }
    }
}

fn syntax_error(text: &str, path: &str, error: &toml::de::Error) -> Error {
    let span = error.span().unwrap_or(text.len()..text.len());
    let snippet = Snippet { path: path.to_string(), source: text.to_string(), span };
    let (line, column) = snippet.line_column();
    let value = text.get(snippet.span.clone()).unwrap_or("").to_string();
    Error::scene(format!("the scene is not valid TOML: {}", error.message()))
        .at(format!("{path}:{line}:{column}"))
        .value(if value.is_empty() { "nothing is written here" } else { &value })
        .remedy(
            "keys are written `key = value`, tables `[name]`, and text stands in \"quotes\" \
             (https://toml.io)",
        )
        .snippet(snippet)
}

/// The value of an override; `shift` is added to its spans.
pub(in crate::scene) fn parse_value(
    text: &str,
    source: usize,
    shift: usize,
) -> std::result::Result<Node, toml::de::Error> {
    DeValue::parse(text).map(|v| node(&v, source, shift))
}

fn node(value: &Spanned<DeValue<'_>>, source: usize, shift: usize) -> Node {
    let value_of = |v: &DeValue<'_>| match v {
        DeValue::String(s) => Value::Text(s.to_string()),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(i) => Value::Integer(i),
            // Beyond 64 bits: a floating-point number, no integer.
            Err(_) => Value::Float(i.as_str().parse().unwrap_or(f64::INFINITY)),
        },
        DeValue::Float(f) => Value::Float(f.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(b) => Value::Boolean(*b),
        DeValue::Datetime(_) => Value::Datetime,
        DeValue::Array(items) => {
            Value::Array(items.iter().map(|i| node(i, source, shift)).collect())
        }
        DeValue::Table(table) => table_value(table, source, shift),
    };
    Node { value: value_of(value.get_ref()), place: place(value.span(), source, shift) }
}

fn table_value(table: &DeTable<'_>, source: usize, shift: usize) -> Value {
    let mut entries: Vec<Entry> = table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            key_place: place(key.span(), source, shift),
            node: node(value, source, shift),
        })
        .collect();
    entries.sort_by_key(|e| e.key_place.span.start);
    Value::Table(entries)
}

fn place(span: Range<usize>, source: usize, shift: usize) -> Place {
    Place { source, span: span.start + shift..span.end + shift }
}
