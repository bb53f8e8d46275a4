//! Tables, charts and sentences of a comparison.

use super::{Bound, Cost, Pair};
use crate::output::{Cell, Chart, Curve, Figure, KeyNumber, Stroke, Table, rounded};
use crate::studies::freefem::{Case, INSTALL, Reading};
use crate::studies::trial::Outcome;
use crate::studies::twin::{Loop, Twin};

/// Times at which values are printed side by side.
const SHOWN_TIMES: usize = 2;

pub(super) fn differences(times: &[f64], pairs: &[Pair<'_>]) -> Table {
    let header = ["quantity", "largest value", "largest difference", "at t", "relative"];
    let mut table = Table::new("differences", "Differences", header);
    for p in pairs {
        let (row, difference) = p.worst();
        let [value, relative] = [p.largest_value(), p.relative()];
        table.rows.push(vec![
            Cell::text(p.name),
            Cell::number(value, 5),
            Cell::number(difference, 2),
            Cell::number(times[row], 4),
            Cell::number(relative, 2),
        ]);
    }
    table.caption = format!(
        "Over {} common times; relative to FreeFEM's largest value of the quantity.",
        times.len()
    );
    table
}

pub(super) fn side_by_side(times: &[f64], pairs: &[Pair<'_>]) -> Table {
    let header = ["t", "quantity", "immersa", "FreeFEM", "difference"];
    let mut table = Table::new("values", "Side by side", header);
    let count = SHOWN_TIMES.min(times.len() - 1).max(1);
    let mut rows: Vec<usize> = (1..=count).map(|k| k * (times.len() - 1) / count).collect();
    rows.dedup();
    for row in rows {
        for p in pairs {
            let number = |v: f64| Cell::number(v, 7);
            let [a, b] = [p.ours[row], p.theirs[row]];
            table.rows.push(vec![
                Cell::number(times[row], 4),
                Cell::text(p.name),
                number(a),
                number(b),
                Cell::number(a - b, 2),
            ]);
        }
    }
    table.caption = "All common times are in side_by_side.csv.".into();
    table
}

pub(super) fn times_of(costs: &[Cost], loops: &[Loop], reading: &Reading) -> Table {
    let title = "CPU seconds a step, one thread";
    let mut table = Table::new(
        "times",
        title,
        ["program", "steps", "first step", "per later step", "over immersa's"],
    );
    let ours = costs.first().map_or(f64::NAN, |c| c.per_step);
    for (k, c) in costs.iter().enumerate() {
        // Seconds of another machine say nothing about ours.
        let ratio = if k > 0 && reading.recorded.is_some() { f64::NAN } else { c.per_step / ours };
        let number = |v: f64| Cell::number(v, 3);
        table.rows.push(vec![
            Cell::text(&c.who),
            Cell::number(c.steps, 6),
            number(c.first),
            number(c.per_step),
            number(ratio),
        ]);
    }
    table.caption = "The least of the repetitions, which were run in turn. Set-up and output are \
        left out; the first step factors, and ours counts its energy balance in every step."
        .into();
    for work in loops.iter().filter(|l| !l.words.is_empty()) {
        table.caption += &format!(" FreeFEM's {} loop: {}.", work.name, work.words);
    }
    if reading.recorded.is_some() {
        table.caption += " FreeFEM's seconds are those of the machine where they were recorded.";
    }
    table
}

pub(super) fn charts(times: &[f64], pairs: &[Pair<'_>], reading: &Reading) -> Vec<Figure> {
    let theirs = if reading.recorded.is_some() { "FreeFEM (recorded)" } else { "FreeFEM" };
    let mut all = Vec::new();
    for p in pairs {
        let curve = |name, y, stroke| Curve { name, x: times, y, stroke, colour: None };
        let curves =
            vec![curve("immersa", &p.ours, Stroke::Line), curve(theirs, &p.theirs, Stroke::Points)];
        let chart = Chart { x_label: "time", y_label: p.name, curves, ..Chart::default() };
        let caption =
            format!("The largest difference is {} of the largest value.", rounded(p.relative(), 2));
        all.push(Figure::chart(p.name.replace('.', "_"), p.name, chart.svg(), caption));
    }
    let relative: Vec<Vec<f64>> = pairs
        .iter()
        .map(|p| {
            let largest = p.largest_value();
            p.ours.iter().zip(&p.theirs).map(|(a, b)| (a - b).abs() / largest).collect()
        })
        .collect();
    let curves = pairs
        .iter()
        .zip(&relative)
        .map(|(p, y)| Curve { name: p.name, x: times, y, ..Curve::default() })
        .collect();
    let chart = Chart {
        x_label: "time",
        y_label: "difference over largest value",
        log_y: true,
        curves,
        ..Chart::default()
    };
    let caption = "Relative to FreeFEM's largest value of the quantity.";
    all.push(Figure::chart("differences", "Differences", chart.svg(), caption));
    all
}

pub(super) fn statements(pairs: &[Pair<'_>], costs: &[Cost], reading: &Reading) -> Vec<String> {
    let largest = pairs.iter().max_by(|a, b| a.relative().total_cmp(&b.relative()));
    let mut said: Vec<String> = largest
        .map(|p| {
            format!(
                "All quantities agree within {} of their largest values; {} differs most.",
                rounded(p.relative(), 2),
                p.name
            )
        })
        .into_iter()
        .collect();
    if reading.recorded.is_some() {
        said.push(
            "FreeFEM is not installed here: its results are recorded ones, and its times cannot \
             be compared."
                .into(),
        );
    } else if let [ours, theirs @ ..] = costs {
        said.extend(theirs.iter().filter(|c| c.per_step.is_finite()).map(|c| {
            format!(
                "A step takes immersa {} s of CPU time and {} {} s: {} times as long.",
                rounded(ours.per_step, 3),
                c.who,
                rounded(c.per_step, 3),
                rounded(c.per_step / ours.per_step, 2)
            )
        }));
    }
    said
}

pub(super) fn alarms(pairs: &[Pair<'_>], bounds: &[Bound]) -> Vec<String> {
    let own = |p: &Pair| bounds.iter().find(|b| b.column.as_deref() == Some(p.name));
    let general = bounds.iter().find(|b| b.column.is_none());
    let mut alarms: Vec<String> = pairs
        .iter()
        .filter_map(|p| own(p).or(general).map(|b| (p, b.value)))
        // A difference that is no number is beyond any bound.
        .filter(|(p, bound)| p.relative().is_nan() || p.relative() > *bound)
        .map(|(p, bound)| {
            format!(
                "{} differs by {} of its largest value, more than the {bound:?} that was asked \
                 for.",
                p.name,
                rounded(p.relative(), 2)
            )
        })
        .collect();
    let unknown = bounds
        .iter()
        .filter_map(|b| b.column.as_deref())
        .filter(|c| pairs.iter().all(|p| p.name != *c));
    alarms
        .extend(unknown.map(|c| format!("{c} was to be compared, but not both programs give it.")));
    alarms
}

pub(super) fn notes(
    case: &Case<'_>,
    twin: &Twin,
    reading: &Reading,
    pairs: &[Pair<'_>],
    outcome: &Outcome,
) -> Vec<String> {
    let mut notes = Vec::new();
    if let Some(file) = &reading.recorded {
        notes.push(format!(
            "FreeFEM's results are recorded ones, made by {}: {}; {INSTALL}.",
            reading.about.made_by,
            file.display()
        ));
    }
    if !twin.settings().is_empty() {
        notes.push(format!(
            "So that both have the same scheme, the twin sets: {}; --set changes it.",
            twin.settings().join(", ")
        ));
    }
    let labels: Vec<String> = case.labels.iter().map(|(name, k)| format!("{name} {k}")).collect();
    notes.push(format!("Labels of the boundaries in the mesh for FreeFEM: {}.", labels.join(", ")));
    let alone =
        reading.table.names.iter().filter(|n| *n != "time" && pairs.iter().all(|p| p.name != *n));
    let alone: Vec<&str> = alone.map(String::as_str).collect();
    if !alone.is_empty() {
        notes.push(format!("Of the twin's columns the series has no {}.", alone.join(", ")));
    }
    notes.extend(
        outcome.summary.alarms.iter().map(|a| format!("immersa's run raised an alarm. {a}")),
    );
    notes
}

pub(super) fn key_numbers(pairs: &[Pair<'_>], costs: &[Cost], reading: &Reading) -> Vec<KeyNumber> {
    let worst = pairs.iter().map(Pair::relative).fold(0.0, f64::max);
    let made =
        if reading.recorded.is_some() { "FreeFEM's results are recorded" } else { "both run now" };
    let number = |label: &str, value: String, note: &str| KeyNumber {
        label: label.into(),
        value,
        note: note.into(),
    };
    let mut all = vec![number("Largest difference", rounded(worst, 2), made)];
    if let [ours, theirs @ ..] = costs {
        all.push(number("CPU seconds a step", rounded(ours.per_step, 3), "immersa, one thread"));
        let live = theirs.iter().filter(|c| reading.recorded.is_none() && c.per_step.is_finite());
        all.extend(live.map(|c| {
            number(
                &format!("{}, over immersa's", c.who),
                format!("{} times", rounded(c.per_step / ours.per_step, 2)),
                "CPU time of a step",
            )
        }));
    }
    all
}
