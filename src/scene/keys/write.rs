//! Writing a scene as TOML.

use crate::scene::expression::Expression;
use std::fmt::Write as _;

/// A TOML text under construction.
#[derive(Default)]
pub struct Writer {
    pub text: String,
}

impl Writer {
    /// Begins the table `[header]` or `[[header]]`.
    pub fn header(&mut self, header: &str) {
        let gap = if self.text.is_empty() { "" } else { "\n" };
        self.push(format_args!("{gap}{header}\n"));
    }

    /// Writes `key = value`, with the value already in TOML.
    pub fn entry(&mut self, key: &str, value: impl std::fmt::Display) {
        self.push(format_args!("{key} = {value}\n"));
    }

    /// Writes keys with their values, which are already in TOML.
    pub fn entries(&mut self, entries: impl IntoIterator<Item = (String, String)>) {
        entries.into_iter().for_each(|(key, value)| self.entry(&key, value));
    }

    fn push(&mut self, what: std::fmt::Arguments<'_>) {
        // Writing into a String cannot fail.
        let _ = self.text.write_fmt(what);
    }
}

/// A type with a TOML representation.
pub(in crate::scene) trait Toml {
    /// The value as TOML.
    fn toml(&self) -> String;
}

impl Toml for f64 {
    fn toml(&self) -> String {
        number(*self)
    }
}

impl Toml for usize {
    fn toml(&self) -> String {
        self.to_string()
    }
}

impl Toml for bool {
    fn toml(&self) -> String {
        self.to_string()
    }
}

impl Toml for String {
    fn toml(&self) -> String {
        text(self)
    }
}

impl Toml for std::path::PathBuf {
    fn toml(&self) -> String {
        text(&self.to_string_lossy())
    }
}

/// A constant expression is written as a number.
impl Toml for Expression {
    fn toml(&self) -> String {
        self.text().parse::<f64>().map_or_else(|_| text(self.text()), number)
    }
}

impl<T: Toml> Toml for Vec<T> {
    fn toml(&self) -> String {
        list(self.iter().map(Toml::toml))
    }
}

impl<T: Toml, const N: usize> Toml for [T; N] {
    fn toml(&self) -> String {
        list(self.iter().map(Toml::toml))
    }
}

/// A number as TOML, with all digits.
pub(in crate::scene) fn number(v: f64) -> String {
    format!("{v:?}")
}

/// TOML values as a list.
pub(in crate::scene) fn list(items: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", items.into_iter().collect::<Vec<_>>().join(", "))
}

/// A text as TOML, quoted, on one line.
pub(in crate::scene) fn text(s: &str) -> String {
    let mut quoted = String::from('"');
    for c in s.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04x}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

/// A key as TOML, quoted if necessary.
pub(in crate::scene) fn key(s: &str) -> String {
    let bare =
        !s.is_empty() && s.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if bare { s.to_string() } else { text(s) }
}

/// The word for a value of a choice.
pub(in crate::scene) fn name<T: PartialEq>(value: T, choices: &[(&'static str, T)]) -> String {
    text(choices.iter().find(|c| c.1 == value).map_or("", |c| c.0))
}
