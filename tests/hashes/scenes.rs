//! The scenes of the repository: files, and texts in its Rust sources with the changes made to
//! them.

use crate::Result;
use crate::shorten::{in_space, shortened};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A scene to run.
pub struct Case {
    pub name: String,
    /// The shortened scene.
    pub text: String,
    /// `KEY=VALUE` for `--set`.
    pub set: Option<String>,
    /// Also stopped and resumed.
    pub resumes: bool,
}

/// Changes that every scene of a file is run with, in space the first two; those that do not apply
/// are refused.
const CHANGES: [&str; 8] = [
    "time.order=1",
    "time.tolerance=1e-2",
    "numerics.coupling=explicit",
    "numerics.coupling=semi-implicit",
    "numerics.transport=projected",
    "numerics.transport=composed",
    "membrane.0.force=sharp",
    "drop.0.force=sharp",
];

/// First parts of the keys of a scene.
const TABLES: [&str; 12] = [
    "boundary",
    "constants",
    "drop",
    "exact",
    "fluid",
    "image",
    "level_set",
    "membrane",
    "mesh",
    "numerics",
    "output",
    "time",
];

/// Keys that make a run long.
const LONG: [&str; 10] =
    ["cells", "end", "step", "refine", "edge", "every", "fields", "pictures", "size", "vertices"];

/// All scenes below `root`, by name.
pub fn all(root: &Path) -> Result<Vec<Case>> {
    let mut files = Vec::new();
    for folder in ["book/src", "examples", "src", "tests"] {
        walk(&root.join(folder), &mut files)?;
    }
    files.sort();
    let mut cases = Vec::new();
    for file in files {
        let text = fs::read_to_string(&file)?;
        let name = file.strip_prefix(root)?.display().to_string();
        let folder = file.parent().ok_or("a file in no folder")?;
        if file.extension().is_some_and(|e| e == "toml") {
            if is_scene(&text) {
                let plane = text.parse().is_ok_and(|scene| !in_space(&scene));
                let changes = if plane { &CHANGES } else { &CHANGES[..2] };
                add(&name, &text, folder, changes, &mut cases);
            }
        } else {
            from_source(&name, &text, folder, &mut cases);
        }
    }
    Ok(cases)
}

fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        // The book shows the examples through a link.
        if path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            walk(&path, files)?;
        } else if path.extension().is_some_and(|e| e == "toml" || e == "rs") {
            files.push(path);
        }
    }
    Ok(())
}

/// A whole scene, which can be read.
fn is_scene(text: &str) -> bool {
    text.parse::<toml::Table>().is_ok_and(|t| {
        t.contains_key("time") && (t.contains_key("mesh") || t.contains_key("image"))
    })
}

/// A scene as it is, and with each of some changes that is short.
fn add(name: &str, text: &str, folder: &Path, changes: &[&str], cases: &mut Vec<Case>) {
    let text = shortened(text, folder);
    let case = |name, set: Option<&&str>| {
        let set = set.map(ToString::to_string);
        Case { name, text: text.clone(), resumes: set.is_none(), set }
    };
    cases.push(case(name.to_owned(), None));
    cases.extend(changes.iter().map(|change| case(format!("{name} {change}"), Some(change))));
}

/// The scenes in the literals of a source file. Those beside them that look like `KEY=VALUE` are
/// changes of them; two in a row behind a bracket, the first of them in the scene, are a
/// replacement.
fn from_source(name: &str, source: &str, folder: &Path, cases: &mut Vec<Case>) {
    let literals = literals(source);
    let found = literals.iter().map(|l| l.text.as_str()).filter(|text| is_change(text));
    let changes: Vec<&str> = found.collect::<BTreeSet<_>>().into_iter().collect();
    for scene in literals.iter().filter(|l| is_scene(&l.text)) {
        let name = format!("{name}:{}", scene.line);
        add(&name, &scene.text, folder, &changes, cases);
        for pair in literals.windows(2).filter(|pair| pair[0].opens && pair[1].follows) {
            let [from, to] = [&pair[0].text, &pair[1].text];
            if !from.is_empty() && scene.text.contains(from.as_str()) {
                let text = shortened(&scene.text.replace(from.as_str(), to), folder);
                let name = format!("{name} {from:?} is {to:?}");
                cases.push(Case { name, text, set: None, resumes: false });
            }
        }
    }
}

/// `KEY=VALUE` with a key of a scene that does not make it long, and no part to be filled in.
fn is_change(text: &str) -> bool {
    let Some((key, value)) = text.split_once('=') else { return false };
    let parts: Vec<&str> = key.split('.').collect();
    let open = |c: char| c == '{';
    let filled_in = value.match_indices(open).any(|(k, _)| !value[k + 1..].starts_with(' '));
    parts.len() > 1
        && TABLES.contains(&parts[0])
        && parts.iter().all(|p| p.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'))
        && parts.last().is_some_and(|last| !LONG.contains(last))
        && !filled_in
}

/// The text of a string in a source file.
struct Literal {
    text: String,
    line: usize,
    /// A bracket opens before it.
    opens: bool,
    /// Only a comma lies between it and the one before.
    follows: bool,
}

/// The strings of a Rust source, those of comments left out.
fn literals(source: &str) -> Vec<Literal> {
    let (mut all, mut rest, mut between) = (Vec::new(), source, String::new());
    while let Some(c) = rest.chars().next() {
        let raw = rest.starts_with("r\"") || rest.starts_with("r#\"");
        let taken = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("'\"'") {
            3
        } else if c == '"' || (raw && !between.ends_with(|c: char| c.is_alphanumeric() || c == '_'))
        {
            let (text, length) = if raw { raw_string(rest) } else { string(rest) };
            let line = 1 + source[..source.len() - rest.len()].matches('\n').count();
            let code = between.trim();
            all.push(Literal { text, line, opens: code.ends_with('('), follows: code == "," });
            between.clear();
            length
        } else {
            between.push(c);
            c.len_utf8()
        };
        rest = &rest[taken..];
    }
    all
}

/// The text of `r"..."` or `r#"..."#` at the front, and its length.
fn raw_string(rest: &str) -> (String, usize) {
    let (open, close) = if rest.starts_with("r\"") { ("r\"", "\"") } else { ("r#\"", "\"#") };
    let end = rest[open.len()..].find(close).map_or(rest.len(), |k| k + open.len());
    (rest[open.len()..end].to_owned(), (end + close.len()).min(rest.len()))
}

/// The text of `"..."` at the front, and its length.
fn string(rest: &str) -> (String, usize) {
    let (mut text, mut characters) = (String::new(), rest.char_indices().skip(1).peekable());
    while let Some((k, c)) = characters.next() {
        match c {
            '"' => return (text, k + 1),
            '\\' => match characters.next() {
                Some((_, 'n')) => text.push('\n'),
                // A line that goes on.
                Some((_, '\n')) => {
                    while characters.next_if(|(_, c)| c.is_whitespace()).is_some() {}
                }
                Some((_, c)) => text.push(c),
                None => break,
            },
            c => text.push(c),
        }
    }
    (text, rest.len())
}
