//! The reference of the scene format in Markdown, generated from the descriptions used for reading.

use super::expression::functions;
use super::keys::{Absent, Key, Keys, Kind, advice};
use super::read::KEYS;
use crate::base::{Error, Result};

/// A table and all its possible places in the scene.
pub(super) struct Section {
    /// Keys on the way to it, joined by dots; empty for the scene.
    pub paths: Vec<String>,
    headings: Vec<String>,
    /// Its keys.
    pub keys: &'static Keys,
}

const EXPRESSIONS: &str = "expressions";

/// The reference of the whole scene, or of the table `of` and the tables in it, such as
/// `membrane.shape`.
///
/// Errors: of kind [`Scene`](crate::base::Kind::Scene) if there is no such table.
pub fn reference(of: Option<&str>) -> Result<String> {
    let sections = sections();
    let wanted = |path: &str| match of {
        None => true,
        Some(of) => {
            path.strip_prefix(of).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        }
    };
    let mut parts: Vec<String> = sections
        .iter()
        .filter(|s| s.paths.iter().any(|p| wanted(p)))
        .map(Section::markdown)
        .collect();
    if wanted(EXPRESSIONS) {
        parts.push(expressions());
    }
    if parts.is_empty() {
        let known =
            sections.iter().flat_map(|s| &s.paths).map(String::as_str).filter(|p| !p.is_empty());
        let of = of.unwrap_or("");
        return Err(Error::scene(format!("`{of}` is not a table of the scene"))
            .at("command line, TABLE")
            .value(of)
            .remedy(advice(of, known.chain([EXPRESSIONS]))));
    }
    Ok(parts.join("\n"))
}

/// The scene and all its tables.
pub(super) fn sections() -> Vec<Section> {
    let mut sections = vec![Section {
        paths: vec![String::new()],
        headings: vec!["The scene".to_string()],
        keys: &KEYS,
    }];
    collect(&KEYS, "", &mut sections);
    sections
}

/// Adds the tables inside `keys` at `path`; a table at several places gets one section.
fn collect(keys: &'static Keys, path: &str, sections: &mut Vec<Section>) {
    for key in keys.keys {
        let Some(inner) = key.kind.keys() else { continue };
        let path =
            if path.is_empty() { key.name.to_string() } else { format!("{path}.{}", key.name) };
        let heading = match key.kind {
            Kind::Named(_) => format!("[{path}.NAME]"),
            Kind::List(_) => format!("[[{path}]]"),
            _ => format!("[{path}]"),
        };
        match sections.iter_mut().find(|s| std::ptr::eq(s.keys, inner)) {
            Some(section) => {
                section.paths.push(path);
                section.headings.push(heading);
            }
            None => {
                sections.push(Section {
                    paths: vec![path.clone()],
                    headings: vec![heading],
                    keys: inner,
                });
                collect(inner, &path, sections);
            }
        }
    }
}

impl Section {
    fn markdown(&self) -> String {
        let level = self.paths[0].split('.').filter(|p| !p.is_empty()).count().min(2) + 1;
        let headings = match level {
            1 => self.headings.join(", "),
            _ => self.headings.iter().map(|h| format!("`{h}`")).collect::<Vec<_>>().join(", "),
        };
        let entries: String = self.keys.keys.iter().map(entry).collect();
        format!("{} {headings}\n\n{}\n{entries}", "#".repeat(level), self.keys.about)
    }
}

/// A key as an entry of a definition list.
fn entry(key: &Key) -> String {
    let kind = match key.kind {
        Kind::Value(what, _) => what.to_string(),
        Kind::OrFalse(what, _) => format!("{what} or false"),
        Kind::Numbers(n) => format!("{} numbers", in_words(n)),
        Kind::Lengths(n) => format!("{} numbers > 0", in_words(n)),
        Kind::Count([least, most]) if most == least + 1 => format!("{least} or {most}"),
        Kind::Count([least, most]) => format!("whole number from {least} to {most}"),
        Kind::Counts(n, [least, most]) => {
            format!("{} whole numbers from {least} to {most}", in_words(n))
        }
        Kind::Choice(words) => quoted(words, "`"),
        Kind::ChoiceOrFalse(words) => format!("{} or false", quoted(words, "`")),
        Kind::Set(words) => format!("list of {}", quoted(words, "")),
        Kind::Table(_) => "table".to_string(),
        Kind::List(_) => "list of tables".to_string(),
        Kind::Named(_) => "tables with names".to_string(),
        Kind::Either(what, ..) => format!("{what}, or table"),
    };
    let auto = if key.absent == Absent::Auto { " or `\"auto\"`" } else { "" };
    let unit = if key.unit.is_empty() { String::new() } else { format!(" ({})", key.unit) };
    let absent = match key.absent {
        Absent::Required => ", required".to_string(),
        Absent::OneOf => String::new(),
        Absent::Default(value) => format!(", default `{value}`"),
        Absent::Auto => ", default `\"auto\"`".to_string(),
        Absent::Derived(what) => format!(", default: {what}"),
        Absent::Optional => ", optional".to_string(),
    };
    format!("\n`{}`: {kind}{auto}{unit}{absent}\n: {}\n", key.name, key.doc)
}

/// Words in quotes, each between two marks.
fn quoted(words: &[&str], mark: &str) -> String {
    words.iter().map(|w| format!("{mark}\"{w}\"{mark}")).collect::<Vec<_>>().join(", ")
}

fn in_words(n: usize) -> String {
    match n {
        2 => "two".to_string(),
        3 => "three".to_string(),
        n => n.to_string(),
    }
}

fn expressions() -> String {
    let functions = functions().map(|f| format!("`{f}`")).collect::<Vec<_>>().join(", ");
    format!(
        "## Expressions\n\n\
         Where an expression may stand, write a number or a text such as \
         `\"sin(pi * x) * min(t, 1)\"`. It may use `x`, `y`, `z`, `t`, `pi` and the names in \
         `[constants]`.\n\n\
         Operators, from loose to tight: `||`; `&&`; the comparisons `<`, `>`, `<=`, `>=`, `==`, \
         `!=`, which do not chain; `+`, `-`; `*`, `/`; the prefixes `-`, `+`, `!`; and `^`, which \
         groups to the right, so that `-x^2` is `-(x^2)`. True is 1 and false is 0.\n\n\
         Functions: {functions}. `log` is the natural logarithm, angles are in radians, and \
         `if(c, a, b)` is `a` where `c` is not 0 and else `b`.\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_the_reference_is_the_table_and_those_in_it() {
        let whole = reference(None).unwrap();
        let shape = reference(Some("membrane.shape")).unwrap();
        assert!(whole.contains(&shape), "{shape}");
        assert!(
            shape.starts_with("### `[membrane.shape]`")
                && shape.contains("`[membrane.shape.ellipse]`"),
            "{shape}"
        );
        assert!(!shape.contains("stretch"));
        assert!(reference(Some("expressions")).unwrap().contains("`hypot`"));
        assert!(
            reference(Some("fluid.viscosity")).unwrap().contains("inside"),
            "a table at two places"
        );
    }

    #[test]
    fn a_wrong_table_is_told_the_nearest() {
        let e = reference(Some("numeric")).unwrap_err();
        assert!(e.advice().contains("did you mean `numerics`?"), "{e}");
    }
}
