//! Writing a scene as TOML.

use crate::scene::expression::Expression;
use std::fmt::Write as _;

/// A TOML text in the making.
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

    /// Writes `key = value`; the value is TOML already.
    pub fn entry(&mut self, key: &str, value: impl std::fmt::Display) {
        self.push(format_args!("{key} = {value}\n"));
    }

    fn push(&mut self, what: std::fmt::Arguments<'_>) {
        // Writing into a String cannot fail.
        let _ = self.text.write_fmt(what);
    }
}

/// A number as TOML, with all its digits.
pub(in crate::scene) fn number(v: f64) -> String {
    format!("{v:?}")
}

/// Numbers as a TOML list.
pub(in crate::scene) fn vector(v: &[f64]) -> String {
    list(v.iter().map(|v| number(*v)))
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

/// A key as TOML, quoted where it must be.
pub(in crate::scene) fn key(s: &str) -> String {
    let bare = !s.is_empty() && s.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if bare { s.to_string() } else { text(s) }
}

/// An expression as TOML: a number where it was written as one.
pub(in crate::scene) fn expression(e: &Expression) -> String {
    match e.text().parse::<f64>() {
        Ok(v) => number(v),
        Err(_) => text(e.text()),
    }
}

/// Expressions as a TOML list.
pub(in crate::scene) fn expressions(v: &[Expression]) -> String {
    list(v.iter().map(expression))
}

/// The name of a choice.
pub(in crate::scene) fn name<T: PartialEq>(value: T, choices: &[(&'static str, T)]) -> String {
    text(choices.iter().find(|c| c.1 == value).map_or("", |c| c.0))
}

/// A value, or "auto".
pub(in crate::scene) fn or_auto<T>(value: Option<T>, write: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| text("auto"), write)
}
