//! The report page of a run.

use super::balances::{
    area_change, balances, columns, energy_balance, per_cent, phases, rows, solves, steps,
};
use super::folder::RunFolder;
use super::pictures::Gallery;
use crate::base::Warning;
use crate::output::{Cell, Figure, KeyNumber, Page, Table, rounded};
use crate::scene::StructureKind;
use crate::scene::run::Session;
use crate::scene::structures::FindingValue;

/// The page.
pub(super) fn compose(run: &RunFolder, gallery: Gallery, charts: Vec<Figure>) -> Page {
    let tables = [balances(run), columns(run), solves(run), phases(run), steps(run)];
    Page {
        title: title(run),
        subtitle: subtitle(run),
        origin: origin(run),
        alarms: ending(run).into_iter().chain(run.summary.alarms.iter().cloned()).collect(),
        notes: run
            .summary
            .warnings
            .iter()
            .cloned()
            .chain(run.warnings.iter().map(Warning::to_string))
            .collect(),
        key_numbers: key_numbers(run),
        tables: tables.into_iter().filter(|t| !t.rows.is_empty()).collect(),
        texts: vec![
            ("What was computed".into(), run.summary.plan.clone()),
            ("Settings".into(), run.scene.to_toml()),
        ],
        sheet: rows(run),
        details: vec![files(run, &gallery)],
        pictures: gallery.figures,
        charts,
        footer: format!(
            "Made by immersa {} from the files in this folder; `immersa render` makes it again. \
             The equations are those of G.-H. Cottet, E. Maitre and T. Milcent, Level Set Methods \
             for Fluid-Structure Interaction, Springer 2022; numbers such as (3.23) are theirs.",
            crate::base::VERSION
        ),
        ..Page::default()
    }
}

fn title(run: &RunFolder) -> String {
    let titles = [&run.summary.title, &run.scene.title];
    titles.into_iter().find(|t| !t.is_empty()).cloned().unwrap_or_else(|| "A run of immersa".into())
}

fn subtitle(run: &RunFolder) -> String {
    let time = &run.scene.time;
    let mut parts = Vec::new();
    parts.extend(run.summary.cells.map(|n| format!("{} cells", grouped(n))));
    let step = run.measured(rounded(time.step, 6), "time");
    let steps = |n| match time.tolerance {
        Some(tolerance) => format!(
            "{} steps that follow the error, tolerance {}",
            grouped(n),
            rounded(tolerance, 6)
        ),
        None => format!("{} steps of {step}", grouped(n)),
    };
    parts.extend(run.summary.steps.map(steps));
    if !run.scene.fluid.is_prescribed() {
        parts.push(format!("order {} in time", time.order));
    }
    if !run.scene.units.is_empty() {
        parts.push(format!("units: {}", run.scene.units.words()));
    }
    parts.join(" · ")
}

/// When, by which command, program and machine the run was computed; each of them, where it was
/// continued.
fn origin(run: &RunFolder) -> Vec<(String, String)> {
    let sessions = &run.summary.sessions;
    let of = |name: &str, text: &dyn Fn(&Session) -> String| {
        let mut all: Vec<String> = sessions.iter().map(text).collect();
        all.dedup();
        (name.to_string(), all.join("\n"))
    };
    let day = |time: &str| time.replace('T', " ").replace('Z', " UTC");
    let dates = |s: &Session| match s.started.split_once('T').zip(s.ended.split_once('T')) {
        Some((from, to)) if from.0 == to.0 => {
            day(&format!("{} {} to {}", from.0, from.1.trim_end_matches('Z'), to.1))
        }
        _ => format!("{} to {}", day(&s.started), day(&s.ended)),
    };
    let entries = [
        of("Computed", &dates),
        of("Command", &|s| s.command.clone()),
        of("Version", &|s| format!("immersa {}", s.version)),
        of("Machine", &|s| s.machine.clone()),
    ];
    entries.into_iter().filter(|(_, text)| !text.is_empty()).collect()
}

/// The alarm for a run that did not come to its end.
fn ending(run: &RunFolder) -> Option<String> {
    let reached = run.summary.end_time.or_else(|| run.last("time")).map_or_else(String::new, |t| {
        let end = run.measured(rounded(run.scene.time.end, 6), "time");
        format!(" at t = {} of {end}", rounded(t, 6))
    });
    let why = run.summary.error.as_deref().unwrap_or("no reason is given");
    match run.summary.status.as_str() {
        "failed" => Some(format!(
            "The computation failed{reached}: {why}\nWhat follows is the run up to there."
        )),
        "interrupted" => Some(format!(
            "The run was interrupted{reached}; `immersa run` with --resume goes on. What follows \
             is the run up to there."
        )),
        _ => None,
    }
}

/// Structures that have an interface.
fn with_interface(run: &RunFolder) -> impl Iterator<Item = &dyn StructureKind> {
    run.scene.structures().iter().filter(|s| s.shape().is_some()).map(|s| &**s)
}

fn key_numbers(run: &RunFolder) -> Vec<KeyNumber> {
    let mut numbers: Vec<KeyNumber> =
        with_interface(run).take(MOST_MEMBRANES).flat_map(|s| of_interface(run, s)).collect();
    numbers.extend(of_segmentation(run));
    numbers.extend(of_flow(run));
    numbers.extend(of_forces(run));
    numbers.extend(findings(run));
    numbers.extend(of_cost(run));
    numbers
}

fn number(label: &str, value: String, note: String) -> KeyNumber {
    KeyNumber { label: label.into(), value, note }
}

/// Size and enclosed area of a structure.
fn of_interface(run: &RunFolder, structure: &dyn StructureKind) -> Vec<KeyNumber> {
    let mut numbers = Vec::new();
    let name = structure.name();
    let of = if run.scene.interfaces().count() > 1 { format!(" of {name}") } else { String::new() };
    let last = |quantity: &str| run.last(&format!("{name}.{quantity}"));
    let elastic = structure.traits().acts;
    let words = run.words();
    let (enclosed, round) = (words.enclosed, words.round);
    let axes: Option<Vec<f64>> = words.axes.iter().map(|(column, _)| last(column)).collect();
    if let Some(length) = last(words.own).filter(|_| !elastic) {
        let note = last("markers_length")
            .map_or_else(String::new, |l| format!("by markers: {}", rounded(l, 4)));
        let length = run.measured(rounded(length, 4), words.own);
        numbers.push(number(&format!("{}{of}", capitalised(words.size)), length, note));
    } else if let Some(axes) = axes {
        let radius = last(enclosed).map(words.radius);
        let note = radius.map_or_else(String::new, |r| {
            format!("{round} of the same {enclosed}: {}", rounded(r, 4))
        });
        let axes = run.measured(side_by_side(&axes), "length");
        numbers.push(number(&format!("Semi-axes{of}"), axes, note));
    }
    if let Some(area) = last(enclosed) {
        let note = area_change(run, name)
            .filter(|_| run.scene.image.is_none())
            .map_or_else(String::new, |c| format!("changed by {}; exact: 0", per_cent(c)));
        numbers.push(number(
            &format!("{} inside{of}", capitalised(enclosed)),
            run.measured(rounded(area, 5), enclosed),
            note,
        ));
    }
    numbers
}

fn of_segmentation(run: &RunFolder) -> Vec<KeyNumber> {
    let mut numbers = Vec::new();
    if let Some(parts) = run.last("components") {
        let levels = run.last("c1").zip(run.last("c2"));
        let note = levels.map_or_else(String::new, |(a, b)| {
            format!("grey {} inside, {} outside", rounded(a, 3), rounded(b, 3))
        });
        numbers.push(number("Connected parts", rounded(parts, 6), note));
    }
    if let Some(wrong) = run.last("misclassified") {
        let note = run
            .last("area_error")
            .map_or_else(String::new, |e| format!("area of the mask: off by {}", per_cent(e)));
        numbers.push(number("Pixels on the wrong side", rounded(wrong, 6), note));
    }
    numbers
}

fn of_flow(run: &RunFolder) -> Vec<KeyNumber> {
    let mut numbers = Vec::new();
    if let Some(balance) = energy_balance(run) {
        let note = "residual over the energy in play; exact: 0";
        numbers.push(number("Energy balance", per_cent(balance), note.into()));
    }
    if let Some(kinetic) = run.last("energy_kinetic") {
        let energy = kinetic + run.last("energy_elastic").unwrap_or(0.0);
        let rise = run.summary.balance.largest_rise;
        let note = rise.map_or_else(String::new, |r| {
            format!("largest rise in a step: {} of the first", per_cent(r))
        });
        let energy = run.measured(rounded(energy, 4), "energy");
        numbers.push(number("Energy at the end", energy, note));
    }
    if let Some(speed) = run.last("velocity_max") {
        numbers.push(number(
            "Largest speed at the end",
            run.measured(rounded(speed, 4), "speed"),
            peak(run).unwrap_or_default(),
        ));
    }
    numbers
}

/// Coefficients and Strouhal numbers of the forces that have a reference.
fn of_forces(run: &RunFolder) -> Vec<KeyNumber> {
    let mut numbers = Vec::new();
    for force in run.scene.output.forces.iter().filter(|f| f.reference.is_some()) {
        let name = &force.name;
        if let Some(drag) = run.last(&format!("{name}_drag")) {
            let lift = run.last(&format!("{name}_lift"));
            let note = lift.map_or_else(String::new, |l| format!("lift: {}", rounded(l, 4)));
            numbers.push(number(
                &format!("Drag coefficient of {name} at the end"),
                rounded(drag, 5),
                note,
            ));
        }
        if let Some(length) = run.last(&format!("{name}_recirculation")) {
            numbers.push(number(
                &format!("Length of the recirculation behind {name} at the end"),
                run.measured(rounded(length, 4), "length"),
                "from the rear, along the stream through the centre".into(),
            ));
        }
        if let Some(found) = run.summary.strouhal.get(name) {
            let note = format!(
                "{} periods of the lift, which differ by up to {}",
                found.periods,
                per_cent(found.spread)
            );
            let value = rounded(found.strouhal, 4);
            numbers.push(number(&format!("Strouhal number of {name}"), value, note));
        }
    }
    numbers
}

/// What the series says of each structure.
fn findings(run: &RunFolder) -> Vec<KeyNumber> {
    let (columns, several) = (run.columns(), run.scene.interfaces().count() > 1);
    let of = |s: &dyn StructureKind| {
        let of = if several { format!(" of {}", s.name()) } else { String::new() };
        let shown = s.findings(&columns).into_iter().map(|f| {
            let value = match f.value {
                FindingValue::Word(word) => word.to_string(),
                FindingValue::Number(value) => rounded(value, 5),
            };
            number(&format!("{}{of}", f.names[1]), value, f.note)
        });
        shown.collect::<Vec<_>>()
    };
    run.scene.structures.iter().flat_map(|s| of(&**s)).collect()
}

fn of_cost(run: &RunFolder) -> Option<KeyNumber> {
    let seconds: Vec<f64> = run.summary.seconds.values().flatten().copied().collect();
    let unknowns: u64 = run.summary.unknowns.values().sum();
    let note =
        if unknowns > 0 { format!("for {} unknowns", grouped(unknowns)) } else { String::new() };
    (!seconds.is_empty()).then(|| number("Computed in", duration(seconds.iter().sum()), note))
}

/// Lengths with equally many decimals, four digits of the largest.
fn side_by_side(lengths: &[f64]) -> String {
    let decade = lengths.iter().fold(0.0, |m: f64, l| m.max(l.abs())).log10().floor();
    let decimals = (3.0 - decade).max(0.0) as usize;
    let shown = |l: &f64| match (-3.0..6.0).contains(&decade) {
        true => format!("{l:.decimals$}"),
        false => rounded(*l, 4),
    };
    lengths.iter().map(shown).collect::<Vec<_>>().join(" × ")
}

/// A word with an initial capital.
fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Maximum number of membranes with values at the top of the page; the others are in the tables.
const MOST_MEMBRANES: usize = 2;

/// The greatest speed of the run and its time.
fn peak(run: &RunFolder) -> Option<String> {
    let speeds = run.column("time")?.iter().zip(run.column("velocity_max")?);
    // Reversed, so that the first of equal maxima is found.
    let (t, v) = speeds.rev().filter(|(_, v)| v.is_finite()).max_by(|a, b| a.1.total_cmp(b.1))?;
    Some(format!("greatest: {} at t = {}", rounded(*v, 4), rounded(*t, 4)))
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{} s", rounded(s, 3)),
        s if s < 6000.0 => format!("{} min", rounded(s / 60.0, 3)),
        s => format!("{} h", rounded(s / 3600.0, 3)),
    }
}

/// An integer with its digits in groups of three.
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let starts = |i: usize| i > 0 && (digits.len() - i).is_multiple_of(3);
    digits
        .chars()
        .enumerate()
        .flat_map(|(i, c)| starts(i).then_some('\u{202f}').into_iter().chain([c]))
        .collect()
}

/// The files of the folder, and how to open them.
fn files(run: &RunFolder, gallery: &Gallery) -> Table {
    let pressure =
        if run.scene.fluid.is_prescribed() { ["", ""] } else { [", pressure", " or `pressure`"] };
    let fields = match run.scene.interfaces().next() {
        Some(name) if run.scene.image.is_some() => {
            format!(
                "the image and the level set `{name}.level_set` for ParaView; the contour is its \
                 zero line"
            )
        }
        Some(name) => format!(
            "velocity{} and level sets for ParaView: File > Open, Apply, then colour by \
             `velocity`{}. The interface: Filters > Contour by `{name}.level_set` at 0. In \
             Python: meshio.read of a .vtu",
            pressure[0], pressure[1]
        ),
        None => "velocity and pressure for ParaView: File > Open, Apply, then colour by \
            `velocity` or `pressure`. In Python: meshio.read of a .vtu"
            .to_string(),
    };
    let film = gallery.files.iter().any(|f| f.extension().is_some_and(|e| e == "gif"));
    let segmented = run.path.join("contours.csv").is_file();
    let rows = [
        (
            "scene.toml",
            true,
            "the scene with all defaults; `immersa run` computes it again".to_string(),
        ),
        ("series.csv", true, "one row a sample, for a spreadsheet or pandas.read_csv".to_string()),
        ("contours.csv", segmented, "the contours, in columns and rows of the image".into()),
        (
            "segmented.png",
            segmented,
            "the image in its two levels; the inside in white is in mask.png".into(),
        ),
        ("profiles/", !run.profiles.is_empty(), "values along lines, a column a time".to_string()),
        ("fields.pvd", !run.frames.is_empty(), fields),
        (
            "interfaces.pvd",
            run.path.join("interfaces.pvd").is_file(),
            "the interfaces as lines (in space: triangles) with what they carry, for ParaView"
                .to_string(),
        ),
        (
            "boundaries.vtp",
            run.path.join("boundaries.vtp").is_file(),
            "the boundary with its names, for ParaView".to_string(),
        ),
        (
            "fields.vtkhdf",
            run.path.join("fields.vtkhdf").is_file(),
            "the fields of all times in one file, for ParaView".to_string(),
        ),
        (
            "pictures/",
            !gallery.figures.is_empty(),
            "a picture of every stored field, PNG".to_string(),
        ),
        (
            "film.gif",
            film,
            "the pictures as a film (film.mp4 too where ffmpeg is installed)".to_string(),
        ),
        ("charts/", run.column("time").is_some(), "the charts of this page, SVG".to_string()),
        (
            "summary.json",
            true,
            "how the run ended, its balances and times, for other programs".to_string(),
        ),
        (
            "log.txt",
            run.path.join("log.txt").is_file(),
            "what the terminal showed, with times".to_string(),
        ),
    ];
    let row = |(name, _, what): (&str, bool, String)| vec![Cell::file(name), Cell::text(what)];
    Table::new("", "Files in this folder", ["file", "what it holds"])
        .with_rows(rows.into_iter().filter(|r| r.1).map(row))
}
