//! The first place in which two runs differ.

use crate::outcome::Outcome;
use immersa::output::{Values, read_vtu};
use std::path::Path;

/// A line for each file in which two runs differ, and for how they ended.
pub fn between(a: &Outcome, b: &Outcome) -> Vec<String> {
    let mut lines = Vec::new();
    if a.code != b.code {
        lines.push(format!("exit code {} for {}", a.code, b.code));
    }
    if let Some(line) = in_lines(&a.said, &b.said) {
        lines.push(format!("message, {line}"));
    }
    let mut names: Vec<&String> = a.files.keys().chain(b.files.keys()).collect();
    names.sort();
    names.dedup();
    for name in names {
        match (a.files.get(name), b.files.get(name)) {
            (Some(a), Some(b)) => lines.extend(in_file(name, a, b)),
            (Some(_), None) => lines.push(format!("{name} is new")),
            _ => lines.push(format!("{name} is missing")),
        }
    }
    lines
}

/// The first place in which two files of this name differ.
pub fn in_file(name: &str, a: &[u8], b: &[u8]) -> Option<String> {
    if a == b {
        return None;
    }
    let texts = std::str::from_utf8(a).ok().zip(std::str::from_utf8(b).ok());
    let place = match (name.rsplit_once('.').map_or("", |(_, e)| e), texts) {
        ("csv", Some((a, b))) => in_table(a, b),
        ("vtu", _) => in_fields::<2>(a, b).or_else(|| in_fields::<3>(a, b)),
        (_, Some((a, b))) => in_lines(a, b),
        _ => None,
    };
    let byte = || format!("byte {}", a.iter().zip(b).take_while(|(a, b)| a == b).count());
    Some(format!("{name}, {}", place.unwrap_or_else(byte)))
}

fn in_lines(a: &str, b: &str) -> Option<String> {
    let (mut first, mut second) = (a.lines(), b.lines());
    for k in 1.. {
        match (first.next(), second.next()) {
            (None, None) => break,
            (x, y) if x != y => {
                let [x, y] = [x, y].map(|l| l.unwrap_or("nothing").trim());
                return Some(format!("line {k}: `{x}` for `{y}`"));
            }
            _ => {}
        }
    }
    None
}

/// The first row and column in which tables differ.
fn in_table(a: &str, b: &str) -> Option<String> {
    let header = |text: &str| text.lines().next().unwrap_or("").to_owned();
    if header(a) != header(b) {
        return in_lines(a, b);
    }
    for (row, (x, y)) in a.lines().zip(b.lines()).enumerate() {
        let cells = || x.split(',').zip(y.split(','));
        if let Some(k) = cells().position(|(x, y)| x != y) {
            let (x, y) = cells().nth(k)?;
            return Some(format!("row {row}, {}: {x} for {y}", header(a).split(',').nth(k)?));
        }
    }
    Some(format!("{} rows for {}", a.lines().count() - 1, b.lines().count() - 1))
}

/// The first field and node in which field files differ.
fn in_fields<const D: usize>(a: &[u8], b: &[u8]) -> Option<String> {
    let read = |bytes: &[u8]| {
        let file = tempfile::NamedTempFile::new().ok()?;
        std::fs::write(file.path(), bytes).ok()?;
        read_vtu::<D>(Path::new(file.path())).ok()
    };
    let (a, b) = (read(a)?, read(b)?);
    for ((name, x), (other, y)) in a.fields.iter().zip(&b.fields) {
        if name != other {
            return Some(format!("field {name} for {other}"));
        }
        let found = match (x, y) {
            (Values::Scalar(x), Values::Scalar(y)) => first(x, y, |v| vec![*v]),
            (Values::Vector(x), Values::Vector(y)) => first(x, y, |v| v.as_slice().to_vec()),
            _ => Some("a vector and a number".to_owned()),
        };
        if let Some(found) = found {
            return Some(format!("{name}, {found}"));
        }
    }
    None
}

fn first<T>(a: &[T], b: &[T], values: impl Fn(&T) -> Vec<f64>) -> Option<String> {
    if a.len() != b.len() {
        return Some(format!("{} nodes for {}", a.len(), b.len()));
    }
    let bits = |v: &T| values(v).iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let node = a.iter().zip(b).position(|(x, y)| bits(x) != bits(y))?;
    Some(format!("node {node}: {:?} for {:?}", values(&a[node]), values(&b[node])))
}
