//! Arrows between modules: those that the table of ARCHITECTURE.md allows, and none in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::{fs, path::Path};

/// The parts of a path; of a module from the root of the crate on.
type Name = Vec<String>;
/// What each module names: the paths, and the names that `use` gives them.
type Sources = BTreeMap<Name, Vec<(Name, String)>>;

fn joined(path: &[String], name: &str) -> Name {
    [path, &[name.to_owned()]].concat()
}

/// Reads a folder, without comments and tests.
fn read(folder: &Path, module: &Name, sources: &mut Sources) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let inner =
            if ["mod", "lib"].contains(&name) { module.clone() } else { joined(module, name) };
        if path.is_dir() && name != "tests" {
            read(&path, &inner, sources);
        } else if path.extension().is_some_and(|e| e == "rs")
            && !(name.ends_with("tests") || ["testing", "main"].contains(&name))
        {
            let text = fs::read_to_string(&path).unwrap();
            let lines = text.lines().map(|line| line.split("//").next().unwrap());
            let code: Vec<_> = lines.take_while(|line| !line.ends_with("mod tests {")).collect();
            sources.insert(inner, named(&code.join("\n")));
        }
    }
}

/// What a text names in `use` and by `crate::`, `super::` and `self::`.
fn named(text: &str) -> Vec<(Name, String)> {
    let mut found = Vec::new();
    for start in ["use ", "crate::", "super::", "self::"] {
        let inside =
            |k: usize| text[..k].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':');
        for (k, _) in text.match_indices(start).filter(|(k, _)| !inside(*k)) {
            let before = found.len();
            tree(text[k..].trim_start_matches("use "), &[], &mut found);
            if start != "use " {
                found[before..].iter_mut().for_each(|(_, given)| given.clear());
            }
        }
    }
    found
}

/// Reads the path at the front of a text with all its branches; what follows.
fn tree<'a>(text: &'a str, path: &[String], found: &mut Vec<(Name, String)>) -> &'a str {
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '*';
    let word = |text: &'a str| text.split_at(text.find(|c| !is_word(c)).unwrap_or(text.len()));
    if let Some(mut rest) = text.strip_prefix('{') {
        while !rest.starts_with('}') {
            let next = tree(rest.trim_start(), path, found)
                .trim_start()
                .trim_start_matches(',')
                .trim_start();
            assert!(next.len() < rest.len(), "`use` that cannot be read: {text}");
            rest = next;
        }
        return &rest[1..];
    }
    let (first, rest) = word(text);
    let path =
        if first == "self" && !path.is_empty() { path.to_vec() } else { joined(path, first) };
    match rest.strip_prefix("::") {
        Some(next) if next.starts_with(|c| is_word(c) || c == '{') => tree(next, &path, found),
        _ => {
            let (given, rest) =
                rest.strip_prefix(" as ").map_or((path[path.len() - 1].as_str(), rest), word);
            found.push((path.clone(), given.to_owned()));
            rest
        }
    }
}

/// The module in which a path that stands in `from` ends; none in another crate. What is imported
/// is followed to where it comes from, but what a layer exports again is its own.
fn resolve(sources: &Sources, from: &Name, path: &[String]) -> Option<Name> {
    let mut at = from.clone();
    for (k, name) in path.iter().enumerate() {
        let inner = joined(&at, name);
        let import = sources.get(&at)?.iter().find(|(path, given)| given == name && path.len() > 1);
        match (name.as_str(), import) {
            ("crate", _) => at.clear(),
            ("super", _) => drop(at.pop()),
            ("self", _) => {}
            _ if sources.contains_key(&inner) => at = inner,
            (_, Some((path, _))) if k > 0 => match resolve(sources, &at, path) {
                Some(to) if to.first() == at.first() || from.first() == at.first() => at = to,
                _ => return Some(at),
            },
            _ => return (k > 0).then_some(at),
        }
    }
    Some(at)
}

/// From which module to which.
fn arrows() -> BTreeSet<(Name, Name)> {
    let mut sources = Sources::new();
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &Name::new(), &mut sources);
    let names =
        sources.iter().flat_map(|(from, names)| names.iter().map(move |(path, _)| (from, path)));
    let arrows =
        names.filter_map(|(from, path)| Some((from.clone(), resolve(&sources, from, path)?)));
    arrows.collect()
}

#[test]
fn every_module_uses_only_what_the_table_of_the_architecture_allows() {
    let text = include_str!("../../ARCHITECTURE.md");
    let table = text.split("ANCHOR: layers").nth(1).unwrap().split("ANCHOR_END").next().unwrap();
    let row = |line: &str| line.split('|').map(|cell| cell.trim().to_owned()).collect::<Name>();
    let rows: Vec<Name> = table.lines().map(row).filter(|row| row.len() == 5).collect();
    let allows = |from: &str, to: &str| {
        let k = rows.iter().position(|row| row[1] == from);
        let k = k.unwrap_or_else(|| panic!("{from} has no row in the table"));
        // A row may name only rows above it.
        let above =
            |name: &&str| rows[..k].iter().any(|row| name.split("::").next() == Some(&row[1]));
        let mut allowed = rows[k][3].split(", ").filter(above).chain(["base", from]);
        allowed.any(|name| to == name || to.starts_with(&format!("{name}::")))
    };
    for (from, to) in arrows().iter().filter(|(from, _)| !from.is_empty()) {
        assert!(
            allows(&from[0], &to.join("::")),
            "{} may not use {}",
            from.join("::"),
            to.join("::")
        );
    }
}

#[test]
fn no_modules_use_each_other_in_a_circle() {
    // What lies beside each other in the innermost folder that holds both: a file and the folder of
    // its name are one.
    let beside = |(a, b): (Name, Name)| {
        let k = a.iter().zip(&b).take_while(|(x, y)| x == y).count();
        (a.len() > k && b.len() > k).then(|| (a[..=k].join("::"), b[..=k].join("::")))
    };
    let arrows: BTreeSet<_> = arrows().into_iter().filter_map(beside).collect();
    assert!(arrows.len() > 100, "the sources were not read");
    let reaches = |from: &str, to: &str| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
        while let Some(at) = next.pop() {
            let further = arrows.iter().filter(|(a, _)| a == at).map(|(_, b)| b.as_str());
            next.extend(further.filter(|b| seen.insert(*b)).collect::<Vec<_>>());
        }
        seen.contains(to)
    };
    let circles: Vec<_> = arrows.iter().filter(|(a, b)| reaches(b, a)).collect();
    assert!(circles.is_empty(), "circles: {circles:#?}");
}
