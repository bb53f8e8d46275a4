//! The pages of the book: their links, figures, scenes and numbers.
//!
//! A figure has a line `<!-- keep FROM as TO -->` above it, which `book/make` obeys. A number has
//! `<!-- is WHAT -->` behind it: a place in a table, `FILE time=T COLUMN`, or an expression and the
//! names in it, `EXPRESSION; NAME FILE time=T COLUMN; ...`. What no run of ours gives has `<!--
//! from WHERE -->`.

use immersa::scene::keys::{Keys, Kind};
use immersa::scene::{Expression, KEYS, Scene, problem, reference};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A page as it is written, without what it includes.
struct Page {
    path: PathBuf,
    text: String,
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src")
}

/// The pages of the summary.
fn pages() -> Vec<Page> {
    let summary = fs::read_to_string(source().join("SUMMARY.md")).unwrap();
    let pages: Vec<Page> = links(&summary)
        .map(|link| {
            let path = source().join(link);
            let text =
                fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            Page { path, text }
        })
        .collect();
    assert!(pages.len() > 10);
    pages
}

/// The targets of the links and images of a text.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link)
}

/// The insides of what begins with `from` and ends with `to`.
fn between<'a>(text: &'a str, from: &'a str, to: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(from).skip(1).filter_map(move |rest| rest.split_once(to)).map(|(inside, _)| inside)
}

/// The text without fenced code, code, formulas and comments, as long as before.
fn prose(text: &str) -> String {
    let mut prose = text.to_string();
    for (from, to) in [
        ("```", "```"),
        ("<!--", "-->"),
        ("`", "`"),
        ("$$", "$$"),
        ("$", "$"),
        ("](", ")"),
        ("{{", "}}"),
    ] {
        let mut at = 0;
        while let Some(start) = prose[at..].find(from).map(|i| at + i) {
            let Some(end) =
                prose[start + from.len()..].find(to).map(|i| start + from.len() + i + to.len())
            else {
                break;
            };
            let blank: String =
                prose[start..end].bytes().map(|b| if b == b'\n' { '\n' } else { ' ' }).collect();
            prose.replace_range(start..end, &blank);
            at = end;
        }
    }
    prose
}

/// The name that mdBook gives to a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || " _-".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

#[test]
fn every_link_and_include_of_the_book_leads_somewhere() {
    for page in pages() {
        let folder = page.path.parent().unwrap();
        for link in links(&page.text).filter(|l| !l.starts_with("http")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let path = if file.is_empty() { page.path.clone() } else { folder.join(file) };
            assert!(path.exists(), "{}: the link {link} is broken", page.path.display());
            if !heading.is_empty() {
                let text = fs::read_to_string(&path).unwrap();
                let found =
                    text.lines().filter_map(|l| Some(l.strip_prefix('#')?.trim_start_matches('#')));
                assert!(
                    found.map(anchor).any(|a| a == heading),
                    "{}: no heading {link}",
                    page.path.display()
                );
            }
        }
        for include in between(&page.text, "{{#include ", "}}") {
            let (file, part) = include.split_once(':').unwrap_or((include, ""));
            let text =
                fs::read_to_string(folder.join(file)).unwrap_or_else(|e| panic!("{include}: {e}"));
            let named = part.starts_with(|c: char| c.is_alphabetic());
            assert!(
                !named || text.contains(&format!("ANCHOR: {part} ")),
                "{}: {include}",
                page.path.display()
            );
        }
    }
}

#[test]
fn every_example_is_a_page_of_the_book() {
    let pages: Vec<PathBuf> = pages().into_iter().map(|p| p.path).collect();
    for folder in fs::read_dir(source().join("examples"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_dir())
    {
        assert!(
            pages.contains(&folder.join("README.md")),
            "{} is not in SUMMARY.md",
            folder.display()
        );
    }
}

#[test]
fn the_page_about_the_scene_is_the_reference() {
    let page = fs::read_to_string(source().join("reference/scene.md")).unwrap();
    assert!(
        page == reference::reference(None).unwrap(),
        "run book/make, or immersa reference > book/src/reference/scene.md"
    );
}

/// The columns of the series of a scene.
fn columns(scene: &Scene) -> Vec<String> {
    problem(scene).unwrap().row().unwrap().names().to_vec()
}

#[test]
fn the_page_about_the_series_has_every_column() {
    let page = fs::read_to_string(source().join("reference/series.md")).unwrap();
    let scene = r#"
        mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }
        fluid.viscosity = 1
        time = { end = 1, step = 1 }
        exact = { velocity = [0, 0], pressure = 0 }
        [[membrane]]
        name = "MEMBRANE"
        shape.circle = { centre = [0.5, 0.5], radius = 0.2 }
        area.tension = { tension = 1 }
        chords.CHORD = { through = [0, 0], direction = [1, 0] }
        [[level_set]]
        name = "LEVEL_SET"
        shape.circle = { centre = [0.5, 0.5], radius = 0.2 }
        markers = 3
        [numerics]
        transport = "composed"
        thickness = 0.2
        [output]
        probes.PROBE = { at = [0, 0], of = "pressure" }
        forces.FORCE = { boundary = "left", about = [0, 0] }
        fluxes.FLUX = { boundary = "left" }
        deltas = ["smeared", "smereka1", "smereka2", "towers"]
        curvature = true
    "#;
    let scene = Scene::parse(scene, Path::new("scene.toml")).unwrap();
    let drop = r#"
        mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [8, 8] }
        fluid.viscosity = 1
        time = { end = 1, step = 1 }
        drop = [{ name = "DROP", shape.circle = { centre = [0.5, 0.5], radius = 0.2 }, tension = 1 }]
    "#;
    let drop = Scene::parse(drop, Path::new("scene.toml")).unwrap();
    let image = Scene::load(
        &source().join("examples/active-contours/scene.toml"),
        &["level_set.0.name=LEVEL_SET".into()],
    );
    for column in [scene, drop, image.unwrap()].iter().flat_map(columns) {
        // Level sets and drops have the columns of a membrane.
        let like = column.replace("LEVEL_SET", "MEMBRANE").replace("DROP", "MEMBRANE");
        assert!(
            [&column, &like].iter().any(|c| page.contains(&format!("`{c}`"))),
            "{column} is not on the page"
        );
    }
}

/// The run folders that the commands of a text write to, by the rules of `immersa run`.
fn run_folders(text: &str) -> Vec<String> {
    let blocks = between(text, "```sh", "```").collect::<Vec<_>>().join("\n").replace("\\\n", " ");
    let mut folders = Vec::new();
    for line in blocks.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let after =
            |word: &str| words.iter().position(|w| *w == word).and_then(|i| words.get(i + 1));
        let out = after("--out");
        let study = after("study").or(words.contains(&"compare").then_some(&"compare"));
        let scene = words.iter().find(|w| w.ends_with(".toml")).map(Path::new);
        let name = scene.and_then(|s| {
            if s.ends_with("scene.toml") { s.parent()?.file_name() } else { s.file_stem() }
        });
        match (out, name) {
            (Some(out), _) => folders.push(out.to_string()),
            (None, Some(name)) => folders.push(match study {
                Some(study) => format!("studies/{}-{study}", name.to_string_lossy()),
                None => format!("runs/{}", name.to_string_lossy()),
            }),
            _ => (),
        }
    }
    folders
}

#[test]
fn every_figure_is_made_by_a_command_above_it() {
    for page in pages() {
        let name = page.path.display();
        let mut kept: Vec<(&str, &str)> = Vec::new();
        for (i, line) in page.text.lines().enumerate() {
            let above = page.text.lines().take(i).collect::<Vec<_>>().join("\n");
            if let Some((from, to)) = line
                .strip_prefix("<!-- keep ")
                .and_then(|l| l.strip_suffix(" -->")?.split_once(" as "))
            {
                let to = to.split(" at ").next().unwrap();
                // Of a folder with a variable of the shell, what stands before that.
                let made = run_folders(&above).iter().any(|f| match f.split_once('$') {
                    Some((start, _)) => from.starts_with(start),
                    None => from.starts_with(&format!("{f}/")),
                });
                let written = above.contains(&format!("> {from}"));
                assert!(made || written, "{name}: no command above line {} makes {from}", i + 1);
                let size =
                    fs::metadata(page.path.parent().unwrap().join(to)).map_or(0, |m| m.len());
                assert!(size > 0, "{name}: {to} is missing, run book/make");
                kept.push((from, to));
            }
            for (_, image) in
                line.match_indices("![").filter_map(|(i, _)| line[i..].split_once("]("))
            {
                let image = image.split(')').next().unwrap();
                let caption: String = page.text.lines().skip(i + 1).take(4).collect();
                let Some((from, _)) = kept.iter().find(|k| k.1 == image) else {
                    panic!("{name}: line {} shows {image}, which no command makes", i + 1)
                };
                assert!(
                    caption.contains(from),
                    "{name}: the caption of {image} does not say that it is {from}"
                );
            }
        }
        for include in between(&page.text, "{{#include data/", "}}") {
            let file = format!("data/{}", include.split(':').next().unwrap());
            assert!(kept.iter().any(|k| k.1 == file), "{name}: {file} is made by no command");
        }
    }
}

#[test]
fn every_scene_of_the_book_can_be_run_and_every_fragment_is_one() {
    for page in pages() {
        for block in between(&page.text, "```toml\n", "```") {
            let place = format!("{}:\n{block}", page.path.display());
            match block.trim().strip_prefix("{{#include ").and_then(|b| b.strip_suffix("}}")) {
                Some(file) => {
                    let scene = Scene::load(&page.path.parent().unwrap().join(file), &[])
                        .unwrap_or_else(|e| panic!("{place}\n{e}"));
                    let problem = problem(&scene).unwrap_or_else(|e| panic!("{place}\n{e}"));
                    assert!(problem.warnings().is_empty(), "{place}\n{:?}", problem.warnings());
                }
                None => {
                    known(&block.parse().unwrap_or_else(|e| panic!("{place}\n{e}")), &KEYS, &place)
                }
            }
        }
    }
}

/// Checks that the keys of a fragment are those of a scene.
fn known(table: &toml::Table, keys: &Keys, place: &str) {
    for (name, value) in table {
        let key = keys.get(name).unwrap_or_else(|| panic!("{name} is no key of a scene; {place}"));
        match (key.kind, value) {
            (Kind::Table(inner) | Kind::Either(_, _, inner), toml::Value::Table(t)) => {
                known(t, inner, place)
            }
            (Kind::Named(inner), toml::Value::Table(t)) => {
                t.values().for_each(|t| known(t.as_table().unwrap(), inner, place));
            }
            (Kind::List(inner), toml::Value::Array(list)) => {
                list.iter().for_each(|t| known(t.as_table().unwrap(), inner, place));
            }
            _ => (),
        }
    }
}

/// The cells of a line of a table, some of them in quotes.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().unwrap().push(c),
        }
    }
    cells
}

/// What stands in a table at `FILE KEY=VALUE COLUMN`: in the row where the column KEY has this
/// value, a number or words joined by `_`. Several keys are joined by `&`.
fn looked_up(folder: &Path, place: &str) -> f64 {
    let mut parts = place.trim().splitn(3, ' ');
    let [file, row, column] =
        [(); 3].map(|()| parts.next().unwrap_or_else(|| panic!("`{place}` is no place")));
    let text = fs::read_to_string(folder.join(file)).unwrap_or_else(|e| panic!("{place}: {e}"));
    let mut lines = text.lines().map(cells);
    let names = lines.next().unwrap();
    let at = |name: &str| {
        names.iter().position(|n| n == name).unwrap_or_else(|| panic!("{place}: no column {name}"))
    };
    let wanted: Vec<(usize, &str)> = row
        .split('&')
        .map(|k| k.split_once('=').unwrap())
        .map(|(key, value)| (at(key), value))
        .collect();
    let same = |cell: &str, value: &str| match (cell.parse::<f64>(), value.parse::<f64>()) {
        (Ok(a), Ok(b)) => (a - b).abs() <= 1e-9 * b.abs().max(1.0),
        _ => cell.replace(' ', "_") == value,
    };
    let mut rows = lines.filter(|cells| wanted.iter().all(|(i, value)| same(&cells[*i], value)));
    let found = rows.next().unwrap_or_else(|| panic!("{place}: no such row"));
    assert!(rows.next().is_none(), "{place}: several such rows");
    found[at(column)]
        .parse()
        .unwrap_or_else(|_| panic!("{place}: {} is no number", found[at(column)]))
}

fn value_of(folder: &Path, what: &str) -> f64 {
    if what.split_whitespace().next().is_some_and(|file| file.ends_with(".csv")) {
        return looked_up(folder, what);
    }
    let (expression, names) =
        what.split_once(';').unwrap_or_else(|| panic!("`{what}` names no data"));
    let constants: BTreeMap<String, f64> = names
        .split(';')
        .filter(|name| !name.trim().is_empty())
        .map(|name| {
            let (name, place) = name.trim().split_once(' ').unwrap();
            (name.to_string(), looked_up(folder, place))
        })
        .collect();
    let expression = Expression::parse(expression, &constants)
        .unwrap_or_else(|e| panic!("`{what}`: {}", e.message));
    expression.is_constant().unwrap_or_else(|| panic!("`{what}` is not a number"))
}

/// Whether `shown` is what `value` is when it is rounded to the digits that are shown.
fn rounds_to(value: f64, shown: &str) -> bool {
    let (digits, exponent) = shown.split_once('e').unwrap_or((shown, "0"));
    let decimals = digits.split_once('.').map_or(0, |(_, d)| d.len());
    let last = 10f64.powi(exponent.parse::<i32>().unwrap() - decimals as i32);
    (value - shown.parse::<f64>().unwrap()).abs() <= 0.5 * last * (1.0 + 1e-6)
}

/// The number that a text ends with, and whether it is in per cent.
fn number_before(text: &str) -> Option<(&str, bool)> {
    let (text, percent) = match text.strip_suffix(" %") {
        Some(text) => (text, true),
        None => (text, false),
    };
    let from = text
        .rfind(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)))
        .map_or(0, |i| i + text[i..].chars().next().unwrap().len_utf8());
    let number = &text[from..];
    number.parse::<f64>().is_ok().then_some((number, percent))
}

#[test]
fn every_number_in_the_book_is_that_of_its_data() {
    let mut checked = 0;
    for page in pages() {
        let folder = page.path.parent().unwrap();
        let mut rest = page.text.as_str();
        let mut before = String::new();
        while let Some((text, marked)) = rest.split_once("<!-- is ") {
            before.push_str(text);
            let (what, after) = marked.split_once(" -->").unwrap();
            let (shown, percent) =
                number_before(&before).unwrap_or_else(|| panic!("no number before `{what}`"));
            let value = value_of(folder, what) * if percent { 100.0 } else { 1.0 };
            assert!(
                rounds_to(value, shown),
                "{}: {shown} is shown, the data have {value} ({what})",
                page.path.display()
            );
            checked += 1;
            before.clear();
            rest = after;
        }
    }
    assert!(checked > 10);
}

#[test]
fn every_measured_number_in_the_book_says_where_it_comes_from() {
    for page in pages() {
        let (text, prose) = (&page.text, prose(&page.text));
        // A page may name one source for all of its numbers.
        if text.contains("<!-- numbers from ") {
            continue;
        }
        let mut at = 0;
        for word in prose.split(|c: char| !(c.is_ascii_digit() || ".e-".contains(c))) {
            let start = at;
            at += word.len() + prose[at + word.len()..].chars().next().map_or(0, char::len_utf8);
            let number = word.trim_matches(|c| "e-.".contains(c));
            let digits =
                number.trim_start_matches(['0', '.']).chars().filter(char::is_ascii_digit).count();
            let measured =
                number.matches('.').count() == 1 && digits >= 3 && number.parse::<f64>().is_ok();
            if !measured {
                continue;
            }
            // The number of a figure, a remark or an equation of the source book.
            let end = start + word.len();
            let equation = ["Fig. ", "remark "].iter().any(|what| prose[..start].ends_with(what))
                || prose[..start].ends_with('(') && prose[end..].starts_with([')', ',']);
            let quoted = text[end..].trim_start_matches(" %").starts_with("<!-- ");
            assert!(equation || quoted, "{}: where does {number} come from?", page.path.display());
        }
    }
}

#[test]
fn numbers_are_read_and_rounded_as_they_are_shown() {
    assert!(
        rounds_to(0.12345, "0.123") && !rounds_to(0.1236, "0.123") && rounds_to(-1.5e-4, "-1.5e-4")
    );
    assert!(rounds_to(0.5, "0.5") && !rounds_to(0.56, "0.5") && rounds_to(12345.0, "1.23e4"));
    assert_eq!(number_before("it is 0.013 %"), Some(("0.013", true)));
    assert_eq!(number_before("| -2.5e-3"), Some(("-2.5e-3", false)));
    assert_eq!(number_before("no number"), None);
    assert_eq!(prose("a `b 1` $c$ d").len(), 13);
    assert_eq!(anchor(" `[[membrane]]`"), "membrane");
}
