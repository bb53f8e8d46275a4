//! Overrides of single values of a scene: `time.step=1e-3`, `membrane.0.stretch=1.1`.

use super::keys::{Document, Entry, Node, Place, Source, Value, parse_value};
use crate::base::{Error, Result, Snippet};

/// Sets one value. Missing tables on its path are created; elements of an array are addressed by
/// their index from 0.
///
/// The value is parsed as TOML. If this fails and it does not begin like a list, a table or a
/// quoted text, it is taken as text.
pub(super) fn apply(document: &mut Document, text: &str) -> Result<()> {
    let source = document.sources.len();
    document.sources.push(Source { path: "--set".to_string(), text: text.to_string() });
    let Some(equals) = text.find('=') else {
        return Err(fault(text, 0..text.len(), "an override needs a key and a value"));
    };
    let node = value(text, equals + 1, source)?;
    let mut segments = Vec::new();
    let mut start = 0;
    for part in text[..equals].split('.') {
        let name = part.trim();
        let at = start + part.len() - part.trim_start().len();
        if name.is_empty() {
            return Err(fault(text, start..start + part.len(), "a key of the override is empty"));
        }
        segments.push((name, Place { source, span: at..at + name.len() }));
        start += part.len() + 1;
    }
    let mut target = &mut document.root;
    for (name, place) in segments {
        target = enter(target, name, place, text)?;
    }
    *target = node;
    Ok(())
}

fn value(text: &str, start: usize, source: usize) -> Result<Node> {
    let written = &text[start..];
    let begin = start + written.len() - written.trim_start().len();
    let written = written.trim();
    let place = Place { source, span: begin..begin + written.len() };
    match parse_value(written, source, begin) {
        Ok(node) => Ok(node),
        Err(_) if written.is_empty() => Err(fault(text, begin..begin, "the override has no value")),
        Err(e) if written.starts_with(['[', '{', '"', '\'']) => {
            let span = e.span().unwrap_or(0..written.len());
            let what = format!("the value of the override is not valid TOML: {}", e.message());
            Err(fault(text, span.start + begin..span.end + begin, what))
        }
        Err(_) => Ok(Node { value: Value::Text(written.to_string()), place }),
    }
}

/// The child `name` of `node`; created if missing in a table.
fn enter<'a>(node: &'a mut Node, name: &str, place: Place, text: &str) -> Result<&'a mut Node> {
    let span = place.span.clone();
    match &mut node.value {
        Value::Table(entries) => {
            let position = entries.iter().position(|e| e.key == name).unwrap_or(entries.len());
            if position == entries.len() {
                let empty = Node { value: Value::Table(Vec::new()), place: place.clone() };
                entries.push(Entry { key: name.to_string(), key_place: place, node: empty });
            }
            Ok(&mut entries[position].node)
        }
        Value::Array(items) => {
            let count = items.len();
            let what =
                format!("the list has {count} entries, numbered from 0; `{name}` is none of them");
            name.parse()
                .ok()
                .and_then(|k: usize| items.get_mut(k))
                .ok_or_else(|| fault(text, span, what))
        }
        other => {
            let what = format!("`{name}` cannot be set inside {}", other.kind());
            Err(fault(text, span, what))
        }
    }
}

fn fault(text: &str, span: std::ops::Range<usize>, what: impl Into<String>) -> Error {
    Error::scene(what)
        .at(format!("--set {text}"))
        .value(text)
        .remedy(
            "write --set key.sub=value, for example --set time.step=1e-3 or --set \
             membrane.0.stretch=1.1",
        )
        .snippet(Snippet { path: "--set".to_string(), source: text.to_string(), span })
}
