//! The page of a precision study.

use super::charts::charts;
use super::{CostPoint, Precision, Reference, offers};
use crate::output::{Cell, KeyNumber, Page, Table, rounded};
use crate::scene::Scene;
use crate::studies::front::{cheapest, front};
use crate::studies::per_cent;

pub(super) fn page(
    scene: &Scene,
    options: &Precision,
    quantities: &[(String, f64)],
    reference: &Reference,
    points: &[CostPoint],
) -> Page {
    let names: Vec<String> = quantities.iter().map(|(c, t)| format!("{c} at t = {t:?}")).collect();
    let what = match quantities.first() {
        Some((_, t)) if quantities.iter().all(|q| q.1 == *t) => {
            let columns: Vec<&str> = quantities.iter().map(|q| q.0.as_str()).collect();
            format!("{} at t = {t:?}", columns.join(", "))
        }
        _ => names.join(", "),
    };
    let mut found = Page {
        title: format!("{}: error and cost", scene.title),
        subtitle: format!("Error of {what}, against CPU seconds of the time steps"),
        ..Page::default()
    };
    found.tables.push(all(points, &names));
    found.tables.push(best(points, &options.tolerances));
    found.statements =
        options.tolerances.iter().map(|t| sentence(points, *t, &what, reference)).collect();
    found.notes = notes(scene, options, reference, points);
    let methods: Vec<&str> = options.methods.iter().map(|m| m.name.as_str()).collect();
    found.charts = charts(points, &methods, &what, reference);
    found.key_numbers = options.tolerances.iter().filter_map(|t| number(points, *t)).collect();
    found
}

fn all(points: &[CostPoint], names: &[String]) -> Table {
    let front = front(&offers(points));
    let values: Vec<&str> =
        points.first().map(|p| p.values.iter().map(|v| v.0.as_str()).collect()).unwrap_or_default();
    let fixed = ["error", "CPU", "unknowns", "memory", "front", "end"];
    let single: Vec<&str> =
        if names.len() > 1 { names.iter().map(String::as_str).collect() } else { vec![] };
    let mut table =
        Table::new("points", "All runs", [&["method"], &values[..], &fixed, &single[..]].concat())
            .with_unit("CPU", "s")
            .with_unit("memory", "MB");
    for (i, p) in points.iter().enumerate() {
        let mut row = vec![Cell::text(&p.method)];
        row.extend(
            p.values
                .iter()
                .map(|(_, v)| v.parse().map_or_else(|_| Cell::text(v), |v| Cell::number(v, 6))),
        );
        row.extend([
            Cell::number(p.error(), 3),
            Cell::number(p.cpu, 3),
            Cell::number(p.unknowns, 7),
            Cell::number(p.memory / 1e6, 3),
            Cell::text(if front.contains(&i) { "yes" } else { "" }),
            Cell::text(&p.end),
        ]);
        row.extend(single.iter().zip(&p.errors).map(|(_, e)| Cell::number(*e, 3)));
        table.rows.push(row);
    }
    table.caption = "The error is relative, the largest of the quantities; `front` marks the runs \
        that no other beats in both error and CPU time."
        .into();
    table
}

fn best(points: &[CostPoint], tolerances: &[f64]) -> Table {
    let mut table = Table::new(
        "cheapest",
        "The cheapest setting for an error",
        ["error", "method", "setting", "reached", "CPU"],
    )
    .with_unit("CPU", "s");
    for &tolerance in tolerances {
        let mut row = vec![Cell::text(per_cent(tolerance))];
        match cheapest(&offers(points), tolerance) {
            Some(Ok(i)) => {
                let p = &points[i];
                row.extend([
                    Cell::text(&p.method),
                    Cell::text(&p.setting),
                    Cell::text(per_cent(p.error())),
                    Cell::number(p.cpu, 3),
                ]);
            }
            _ => row.extend([
                Cell::text("none"),
                Cell::text(""),
                Cell::text("-"),
                Cell::optional(None, 3),
            ]),
        }
        table.rows.push(row);
    }
    table
}

/// The cost of an error, in a sentence.
fn sentence(points: &[CostPoint], tolerance: f64, what: &str, reference: &Reference) -> String {
    let told = |p: &CostPoint| {
        [p.setting.as_str(), &p.method, &format!("{} s", rounded(p.cpu, 2))]
            .iter()
            .filter(|w| !w.is_empty())
            .fold(
                String::new(),
                |s, w| if s.is_empty() { w.to_string() } else { format!("{s}, {w}") },
            )
    };
    let (ours, theirs): (Vec<CostPoint>, Vec<CostPoint>) =
        points.iter().cloned().partition(|p| p.ours);
    let of = |points: &[CostPoint]| match cheapest(&offers(points), tolerance) {
        Some(Ok(i)) => format!("{} (error {})", told(&points[i]), per_cent(points[i].error())),
        Some(Err(i)) => format!(
            "not reached; closest came {} with {}",
            told(&points[i]),
            per_cent(points[i].error())
        ),
        None => "no run finished".into(),
    };
    let who = if theirs.is_empty() { "" } else { "immersa: " };
    let mut text = format!("{} in {what}: {who}{}", per_cent(tolerance), of(&ours));
    if !theirs.is_empty() {
        text += &format!("; FreeFEM: {}", of(&theirs).replace(", FreeFEM, ", ", "));
    }
    if tolerance < reference.error() {
        text += &format!(". The reference itself is known to {} only", per_cent(reference.error()));
    }
    text + "."
}

fn number(points: &[CostPoint], tolerance: f64) -> Option<KeyNumber> {
    let Some(Ok(i)) = cheapest(&offers(points), tolerance) else { return None };
    Some(KeyNumber {
        label: format!("{} costs", per_cent(tolerance)),
        value: format!("{} s", rounded(points[i].cpu, 2)),
        note: format!("{}, {}", points[i].method, points[i].setting),
    })
}

fn notes(
    scene: &Scene,
    options: &Precision,
    reference: &Reference,
    points: &[CostPoint],
) -> Vec<String> {
    let mut notes = vec![match &options.truth {
        super::Truth::Exact(_) => "Errors are against exact values.".to_string(),
        super::Truth::Reference(_) => format!(
            "Errors are against a reference run ({}). Its own error is about {}, estimated {}; \
             errors below it mean nothing.",
            reference.words,
            per_cent(reference.error()),
            reference.notes.join(" and ")
        ),
    }];
    // Exact values are those of whatever thickness they were made for.
    let by_run = matches!(options.truth, super::Truth::Reference(_));
    let all_methods = options.methods.iter().chain(&options.twin_methods).flat_map(|m| &m.set);
    let varies = |set: &String| set.starts_with("numerics.thickness") || set.contains(".force");
    let same = options.factors.iter().all(|f| f.name != "thickness")
        && !all_methods.into_iter().any(varies);
    if by_run && same && scene.acting().next().is_some() {
        let eps = scene.numerics.thickness.map_or(String::new(), |eps| format!(" = {eps:?}"));
        notes.push(format!(
            "The half-width eps{eps} of the band is the same in all runs: the error of thickness, \
             of first order in eps and often the largest of all, is not in this chart."
        ));
    }
    let failed: Vec<String> = points
        .iter()
        .filter(|p| p.usable().is_nan())
        .map(|p| {
            let off = match p.error() {
                e if !e.is_nan() => format!(", {} off", per_cent(e)),
                _ if p.end == "finished" => ", but a quantity has no value any more".into(),
                _ => String::new(),
            };
            format!("{}, {}: {}{off}", p.method, p.setting, p.end)
        })
        .collect();
    if !failed.is_empty() {
        notes.push(format!("Runs that are not drawn: {}.", failed.join("; ")));
    }
    notes
}

#[cfg(test)]
mod tests {
    use super::super::charts::{GREY, rows};
    use super::*;

    fn point(method: &str, setting: &str, error: f64, cpu: f64, ours: bool) -> CostPoint {
        let end = if error.is_nan() { "blew up at t = 0.1" } else { "finished" };
        CostPoint {
            method: method.into(),
            setting: setting.into(),
            values: vec![],
            family: setting.split(',').next().unwrap_or_default().into(),
            errors: vec![error],
            cpu,
            unknowns: 100.0,
            memory: 1e6,
            end: end.into(),
            ours,
        }
    }

    fn points() -> Vec<CostPoint> {
        vec![
            point("BDF1", "n = 30, dt = 0.02", 2e-2, 0.5, true),
            point("BDF2", "n = 30, dt = 0.02", 3e-3, 0.6, true),
            point("BDF1", "n = 60, dt = 0.02", 2e-2, 3.0, true),
            point("BDF2", "n = 60, dt = 0.02", 8e-4, 3.1, true),
            point("FreeFEM", "n = 60, dt = 0.001", 5e-3, 60.0, false),
            point("BDF1", "n = 60, dt = 0.1", f64::NAN, 0.1, true),
        ]
    }

    #[test]
    fn the_cheapest_setting_is_a_sentence() {
        let say = |tolerance| {
            sentence(&points(), tolerance, "perimeter at t = 1.0", &Reference::default())
        };
        assert_eq!(
            say(1e-3),
            "0.1 % in perimeter at t = 1.0: immersa: n = 60, dt = 0.02, BDF2, 3.1 s (error 0.08 \
             %); FreeFEM: not reached; closest came n = 60, dt = 0.001, 60 s with 0.5 %."
        );
        assert!(
            say(1e-5)
                .contains(": not reached; closest came n = 60, dt = 0.02, BDF2, 3.1 s with 0.08 %")
        );
        let vague = Reference { own: vec![2e-3], ..Reference::default() };
        assert!(
            sentence(&points(), 1e-3, "a", &vague)
                .ends_with("The reference itself is known to 0.2 % only.")
        );
    }

    #[test]
    fn the_table_marks_the_front_and_names_failures() {
        let marked: Vec<String> =
            all(&points(), &["a".into()]).rows.iter().map(|r| r[5].shown()).collect();
        assert_eq!(marked.concat(), "yesyesyes");
        assert_eq!(marked[2], "", "BDF1 on the finer mesh costs more and errs as much");
        let scene = "mesh.rectangle = { min = [0, 0], max = [1, 1], cells = [2, 2] }\n\
                     fluid.viscosity = 1\nboundary.walls.no_slip = true\n\
                     time = { end = 1, step = 1 }\n";
        let scene = Scene::parse(scene, std::path::Path::new("a.toml")).unwrap();
        let notes = notes(&scene, &Precision::default(), &Reference::default(), &points());
        assert!(
            notes.iter().any(|n| n.contains("BDF1, n = 60, dt = 0.1: blew up at t = 0.1")),
            "{notes:?}"
        );
    }

    #[test]
    fn lines_do_not_join_meshes() {
        let points = points();
        assert_eq!(rows(&points, &["BDF2", "BDF1"])[0].name, "BDF2");
        let rows = rows(&points, &[]);
        assert_eq!(rows.iter().map(|r| r.colour).collect::<Vec<_>>(), [0, 1, GREY]);
        assert!(rows[0].points[1].is_none() && rows[0].points.len() == 4);
    }
}
