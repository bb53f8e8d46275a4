//! The layers of ARCHITECTURE.md: a module uses only what its row of the table allows.

use std::fs;
use std::path::Path;

/// Module, and what it may use besides itself and `base`.
const LAYERS: &[(&str, &[&str])] = &[
    ("base", &[]),
    ("mesh", &[]),
    ("linalg", &[]),
    ("fem", &["mesh", "linalg"]),
    ("transport", &["fem", "mesh"]),
    ("levelset", &["transport", "fem", "mesh", "linalg"]),
    ("flow", &["transport", "fem", "mesh", "linalg"]),
    ("structure", &["flow", "levelset", "transport", "fem", "mesh", "linalg"]),
    ("elastic", &["structure", "flow::term", "levelset", "transport", "fem", "mesh"]),
    ("output", &["levelset", "fem", "mesh"]),
    ("sim", &["structure", "flow", "levelset", "transport", "fem", "mesh", "linalg"]),
    ("scene", &["sim", "structure", "elastic", "flow", "levelset", "transport", "fem", "mesh", "output"]),
    ("studies", &["scene", "sim", "output", "levelset", "fem", "mesh"]),
    ("cli", &["scene", "studies", "output", "mesh"]),
    // src/main.rs
    ("main", &["cli"]),
];

#[test]
fn every_module_uses_only_what_its_layer_allows() {
    let mut sources = Vec::new();
    read_sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut Vec::new(), &mut sources);
    assert!(sources.len() > 5, "the sources were not found");
    let complaints = complaints(&sources);
    assert!(complaints.is_empty(), "arrows that ARCHITECTURE.md does not allow:\n{}", complaints.join("\n"));
}

/// A source file: its path for messages, its module path and its text.
struct Source {
    file: String,
    module: Vec<String>,
    text: String,
}

fn read_sources(folder: &Path, module: &mut Vec<String>, sources: &mut Vec<Source>) {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            module.push(name);
            read_sources(&path, module, sources);
            module.pop();
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let mut module = module.clone();
            if name != "mod" && !(name == "lib" && module.is_empty()) {
                module.push(name);
            }
            sources.push(Source { file: path.display().to_string(), module, text: fs::read_to_string(path).unwrap() });
        }
    }
}

fn complaints(sources: &[Source]) -> Vec<String> {
    let scans: Vec<Scan> = sources.iter().map(|source| scan(&source.module, &source.text)).collect();
    let for_tests: Vec<&Vec<String>> = scans.iter().flat_map(|scan| &scan.test_modules).collect();
    let mut complaints = Vec::new();
    for (source, scan) in sources.iter().zip(&scans) {
        // The root only declares modules and may re-export what it likes.
        let Some(layer) = source.module.first() else { continue };
        if for_tests.iter().any(|module| source.module.starts_with(module)) {
            continue;
        }
        let Some((_, allowed)) = LAYERS.iter().find(|(name, _)| name == layer) else {
            complaints.push(format!("{}: module {layer} has no row in the table", source.file));
            continue;
        };
        for (target, line) in scan.arrows.iter().filter(|(target, _)| !is_allowed(layer, allowed, target)) {
            complaints.push(format!("{}:{line}: {layer} uses crate::{}", source.file, target.join("::")));
        }
    }
    complaints
}

fn is_allowed(layer: &str, allowed: &[&str], target: &[String]) -> bool {
    let starts_with =
        |prefix: &str| prefix.split("::").enumerate().all(|(k, part)| target.get(k).is_some_and(|t| t == part));
    starts_with(layer) || starts_with("base") || allowed.iter().any(|prefix| starts_with(prefix))
}

/// What a source file refers to.
#[derive(Default)]
struct Scan {
    /// Paths from the root of the crate, with the line where they stand.
    arrows: Vec<(Vec<String>, usize)>,
    /// Modules in files of their own that are compiled for tests only.
    test_modules: Vec<Vec<String>>,
}

fn scan(module: &[String], text: &str) -> Scan {
    let tokens = tokens(text);
    let at = |k: usize| tokens.get(k).map_or("", |token| token.text.as_str());
    let mut scan = Scan::default();
    let mut module = module.to_vec();
    // Depths of braces at which inline modules were opened.
    let mut inline = Vec::new();
    let mut depth = 0;
    let mut k = 0;
    while k < tokens.len() {
        let is_path = at(k + 1) == "::" && (k == 0 || at(k - 1) != "::");
        match at(k) {
            "#" if (1..=6).map(|d| at(k + d)).eq(["[", "cfg", "(", "test", ")", "]"]) => {
                let item = end_of_attributes(&tokens, k);
                if at(item) == "mod" && at(item + 2) == ";" {
                    scan.test_modules.push([module.as_slice(), &[at(item + 1).to_owned()]].concat());
                }
                k = end_of_item(&tokens, item);
                continue;
            }
            "mod" if at(k + 2) == "{" => {
                module.push(at(k + 1).to_owned());
                inline.push(depth);
                k += 1;
            }
            "{" => depth += 1,
            "}" => {
                depth -= 1;
                if inline.last() == Some(&depth) {
                    inline.pop();
                    module.pop();
                }
            }
            "crate" | "self" | "super" if is_path => {
                k = paths(&tokens, k, module.clone(), &mut scan.arrows);
                continue;
            }
            "immersa" if is_path && module == ["main"] => {
                k = paths(&tokens, k + 2, Vec::new(), &mut scan.arrows);
                continue;
            }
            // `use crate as name` would hide every arrow behind `name`.
            "crate" if at(k + 1) == "as" => scan.arrows.push((Vec::new(), tokens[k].line)),
            _ => {}
        }
        k += 1;
    }
    scan
}

/// Reads a path or a tree of `use` that starts at token `k` in the module `prefix`; returns the token after it.
fn paths(tokens: &[Token], mut k: usize, mut prefix: Vec<String>, arrows: &mut Vec<(Vec<String>, usize)>) -> usize {
    let at = |k: usize| tokens.get(k).map_or("", |token| token.text.as_str());
    match at(k) {
        "{" => {
            k += 1;
            while k < tokens.len() && at(k) != "}" {
                k = if at(k) == "," { k + 1 } else { paths(tokens, k, prefix.clone(), arrows) };
            }
            return k + 1;
        }
        "crate" => prefix.clear(),
        "super" => drop(prefix.pop()),
        "self" => {}
        name => prefix.push(name.to_owned()),
    }
    let next = at(k + 2);
    if at(k + 1) == "::" && (is_word(next) || next == "{" || next == "*") {
        return paths(tokens, k + 2, prefix, arrows);
    }
    arrows.push((prefix, tokens.get(k).map_or(0, |token| token.line)));
    if at(k + 1) == "as" { k + 3 } else { k + 1 }
}

/// The first token after the attributes that start at token `k`.
fn end_of_attributes(tokens: &[Token], mut k: usize) -> usize {
    while tokens.get(k).is_some_and(|token| token.text == "#") {
        k = end_of_brackets(tokens, k + 1);
    }
    k
}

/// The token after the item that starts at token `k`: after its semicolon or its block.
fn end_of_item(tokens: &[Token], mut k: usize) -> usize {
    while let Some(token) = tokens.get(k) {
        match token.text.as_str() {
            ";" => return k + 1,
            "{" => return end_of_brackets(tokens, k),
            "(" | "[" => k = end_of_brackets(tokens, k),
            _ => k += 1,
        }
    }
    k
}

/// The token after the bracket that closes the one at token `k`.
fn end_of_brackets(tokens: &[Token], mut k: usize) -> usize {
    let mut depth = 0;
    while let Some(token) = tokens.get(k) {
        match token.text.as_str() {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ => {}
        }
        k += 1;
        if depth == 0 {
            break;
        }
    }
    k
}

/// A word, `::`, or a single other character.
struct Token {
    text: String,
    line: usize,
}

fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphanumeric() || c == '_')
}

/// The tokens of a Rust source without comments, strings, characters and lifetimes.
fn tokens(text: &str) -> Vec<Token> {
    let text: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let (mut k, mut line) = (0, 1);
    while k < text.len() {
        let rest = &text[k..];
        let length = match rest {
            ['/', '/', ..] => rest.iter().position(|&c| c == '\n').unwrap_or(rest.len()),
            ['/', '*', ..] => block_comment(rest),
            ['"', ..] => string(rest),
            ['\'', '\\', ..] => 3 + rest[3..].iter().position(|&c| c == '\'').map_or(0, |p| p + 1),
            ['\'', _, '\'', ..] => 3,
            ['\'', ..] => 1 + word(&rest[1..]),
            [':', ':', ..] => 2,
            [c, ..] if c.is_alphanumeric() || *c == '_' => raw_string(rest).unwrap_or_else(|| word(rest)),
            _ => 1,
        };
        let token: String = rest[..length.min(rest.len())].iter().collect();
        let is_code = !token.starts_with("//") && !token.starts_with("/*") && !token.contains(['"', '\'']);
        if is_code && token.trim() == token {
            tokens.push(Token { text: token.clone(), line });
        }
        line += token.matches('\n').count();
        k += length.max(1);
    }
    tokens
}

fn word(text: &[char]) -> usize {
    text.iter().position(|c| !c.is_alphanumeric() && *c != '_').unwrap_or(text.len())
}

fn block_comment(text: &[char]) -> usize {
    let (mut depth, mut k) = (0, 0);
    while k < text.len() {
        match text[k..] {
            ['/', '*', ..] => (depth, k) = (depth + 1, k + 2),
            ['*', '/', ..] => (depth, k) = (depth - 1, k + 2),
            _ => k += 1,
        }
        if depth == 0 {
            break;
        }
    }
    k
}

fn string(text: &[char]) -> usize {
    let mut k = 1;
    while k < text.len() && text[k] != '"' {
        k += if text[k] == '\\' { 2 } else { 1 };
    }
    k + 1
}

/// The length of `r"..."`, `br#"..."#` and the like, if `text` starts with one.
fn raw_string(text: &[char]) -> Option<usize> {
    let prefix = word(text);
    if !matches!(text[..prefix], ['r'] | ['b' | 'c', 'r']) {
        return None;
    }
    let hashes = text[prefix..].iter().take_while(|&&c| c == '#').count();
    if text.get(prefix + hashes) != Some(&'"') {
        return None;
    }
    let start = prefix + hashes + 1;
    let end = (start..text.len())
        .find(|&k| text[k] == '"' && text[k + 1..].iter().take_while(|&&c| c == '#').count() >= hashes);
    Some(end.map_or(text.len(), |end| end + 1 + hashes))
}

mod the_check_itself {
    use super::*;

    fn complain(files: &[(&str, &str)]) -> Vec<String> {
        let source = |&(module, text): &(&str, &str)| Source {
            file: module.to_owned(),
            module: module.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect(),
            text: text.to_owned(),
        };
        complaints(&files.iter().map(source).collect::<Vec<_>>())
    }

    fn is_bad(module: &str, text: &str) {
        assert_eq!(complain(&[(module, text)]).len(), 1, "{module}: {text}");
    }

    fn is_good(module: &str, text: &str) {
        assert_eq!(complain(&[(module, text)]), [""; 0], "{module}: {text}");
    }

    #[test]
    fn allowed_arrows_pass() {
        is_good("fem::assembly", "use crate::{base::{Error, Result}, linalg::*, mesh::Mesh}; use super::space::Space;");
        is_good("elastic::membrane", "use crate::flow::term::MomentumTerm; use crate::levelset::LevelSet as Phi;");
        is_good("mesh", "pub(crate) fn f() {} pub(in crate::mesh) fn g() { self::h(); std::mem::take(x); }");
        is_good("main", "fn main() -> ExitCode { immersa::cli::main() }");
        is_good("", "pub mod base; pub use crate::sim::Simulation;");
    }

    #[test]
    fn forbidden_uses_are_found() {
        is_bad("mesh", "use crate::fem::Space;");
        is_bad("mesh", "use crate::{base::Error, fem::{self as spaces}, linalg::{}};");
        is_bad("levelset::shape", "use crate::{fem::{norm::{L2}}, flow};");
        is_bad("base", "use crate::mesh::*;");
        is_bad("elastic::tension", "use crate::flow::Solver;");
        is_bad("elastic::tension", "use crate::flow::{solver, term};");
        is_bad("rigid", "use crate::elastic::Law;");
        is_bad("main", "use immersa::sim::Simulation;");
    }

    #[test]
    fn paths_outside_of_uses_are_found() {
        is_bad("flow::solver", "fn f() -> f64 { 1.0 + crate::levelset::zero::<2>() }");
        is_bad("output", "fn f(x: &'static crate::sim::State<'_, 2>) {}");
        is_bad("mesh", "macro_rules! m { () => { $crate::fem::f() } }");
        is_bad("mesh", "const A: char = '\\''; const B: char = '\"'; use crate::fem;");
    }

    #[test]
    fn super_and_inline_modules_are_followed() {
        is_good("flow::solver", "use super::super::mesh::Mesh; use super::term::{self, super::pressure};");
        is_bad("flow::solver", "use super::super::sim::Clock;");
        is_bad("flow", "use super::sim::Clock;");
        is_bad("flow", "mod a { mod b { use super::super::super::sim::Clock; } }");
        is_good("flow", "mod a { mod b { use super::super::super::mesh::Mesh; } } use self::a::sim;");
        is_bad("flow", "mod a { fn f() {} } use super::sim::Clock;");
        is_bad("flow::solver", "use super::{super::sim::Clock, term};");
    }

    #[test]
    fn the_root_cannot_be_imported() {
        is_bad("mesh", "use crate::*;");
        is_bad("mesh", "use super::*;");
        is_bad("mesh", "use crate as immersa;");
        is_bad("mesh", "use crate::{self as immersa};");
        is_bad("weather", "fn f() {}");
    }

    #[test]
    fn comments_strings_and_tests_are_ignored() {
        is_good(
            "mesh",
            "/// See [`crate::fem::Space`].\n//! crate::sim\n/* crate::a /* nested */ crate::sim */ fn f() {}",
        );
        is_good("mesh", "const A: &str = \"crate::fem \\\" crate::sim\"; const B: &str = r#\"crate::\"sim\"#;");
        is_good("mesh", "#[cfg(test)]\n#[allow(x)]\nmod tests { use crate::sim::Clock; mod m { fn f() {} } }");
        is_good("mesh", "#[cfg(test)] fn f(x: [u8; 3]) -> u8 { crate::sim::g() }");
        is_bad("mesh", "#[cfg(test)] use crate::flow::{a, b}; use crate::sim::Clock;");
        is_bad("mesh", "#[cfg(test)] mod tests { } use crate::sim::Clock;");
        let files = [("mesh", "#[cfg(test)] mod testing;"), ("mesh::testing", "use crate::sim::Clock;")];
        assert_eq!(complain(&files), [""; 0]);
        assert_eq!(complain(&files[1..]).len(), 1);
    }

    #[test]
    fn the_complaint_names_file_line_and_arrow() {
        let all = complain(&[("fem::norm", "use crate::base::Error;\n\n/*\n*/ use crate::sim::{\n    Clock,\n};")]);
        assert_eq!(all, ["fem::norm:5: fem uses crate::sim::Clock"]);
    }
}
