//! `immersa compare --cells`: what a step costs both programs on several meshes.

use super::axis::{Axis, Choice};
use super::campaign::Campaign;
use super::compare::{Comparison, Costs, compare_and_cost};
use super::files;
use super::twin::Twin;
use crate::base::Result;
use crate::output::{Cell, Chart, Curve, Figure, KeyNumber, Page, Stroke, Table, rounded};

/// [`compare`](super::compare) on generated meshes with these `cells` along the first side, each in
/// a folder of its own with all its tables, and the costs of all in one table.
///
/// # Errors
/// As [`compare`](super::compare) and [`Axis::cells`].
pub fn compare_meshes(
    campaign: &mut Campaign<'_>,
    twin: &Twin,
    options: &Comparison,
    cells: &[usize],
) -> Result<Page> {
    let (scene, stop, folder) =
        (campaign.scene(), campaign.stop(), campaign.folder().to_path_buf());
    let mut all: Vec<(Choice, Page, Costs)> = Vec::new();
    for choice in Axis::cells(scene, cells)?.choices {
        let scene = scene.with(std::slice::from_ref(&choice.set))?;
        let folder = folder.join(format!("n{}", choice.value));
        campaign.listener().note(&choice.label);
        let mut one = Campaign::new(&scene, &folder, stop, campaign.listener());
        let (found, costs) = compare_and_cost(&mut one, twin, options)?;
        files::write(&found, &folder, "")?;
        all.push((choice, found, costs));
    }
    let mut found = Page {
        title: format!("{}: what a step costs", scene.title),
        subtitle: format!(
            "immersa and FreeFEM, dt = {:?}, to t = {:?}",
            scene.time.step, scene.time.end
        ),
        ..Page::default()
    };
    for (choice, one, _) in &all {
        let said = |texts: &[String]| {
            texts.iter().map(|t| format!("{}: {t}", choice.label)).collect::<Vec<_>>()
        };
        found.alarms.extend(said(&one.alarms));
        found.statements.extend(said(&one.statements));
    }
    if let Some((_, one, _)) = all.first() {
        found.notes.clone_from(&one.notes);
    }
    found.notes.push("The folder of each mesh has the differences and values side by side.".into());
    found.tables = vec![table(&all)];
    found.charts = chart(&all).into_iter().collect();
    found.key_numbers = headline(&all);
    Ok(found)
}

fn table(all: &[(Choice, Page, Costs)]) -> Table {
    let mut header = vec!["n".to_string(), "unknowns".into()];
    for (k, cost) in all.first().map_or(&[][..], |(.., c)| &c.of).iter().enumerate() {
        header.push(cost.who.clone());
        if k > 0 {
            header.push(format!("{} over immersa's", cost.who));
        }
    }
    let mut table = Table::new("costs", "CPU seconds a step after the first, one thread", header);
    for (choice, _, costs) in all {
        let ours = costs.of.first().map_or(f64::NAN, |c| c.per_step);
        let mut row = vec![Cell::text(&choice.value), Cell::number(costs.unknowns, 7)];
        for (k, cost) in costs.of.iter().enumerate() {
            row.push(Cell::number(cost.per_step, 3));
            if k > 0 {
                let ratio = if costs.recorded { f64::NAN } else { cost.per_step / ours };
                row.push(Cell::number(ratio, 3));
            }
        }
        table.rows.push(row);
    }
    table.caption = "Both programs ran in turn on the same mesh with the same step; the least of \
        the repetitions. Ours counts its energy balance in every step; FreeFEM's rows are not \
        counted."
        .into();
    table
}

/// Cost over unknowns, both logarithmic.
fn chart(all: &[(Choice, Page, Costs)]) -> Option<Figure> {
    let programs = all.first()?.2.of.len();
    let x: Vec<f64> = all.iter().map(|(.., c)| c.unknowns).collect();
    let columns: Vec<Vec<f64>> = (0..programs)
        .map(|k| all.iter().map(|(.., c)| c.of.get(k).map_or(f64::NAN, |c| c.per_step)).collect())
        .collect();
    let names = all[0].2.of.iter().map(|c| c.who.as_str());
    let curves = names.zip(&columns).map(|(name, y)| Curve {
        name,
        x: &x,
        y,
        stroke: Stroke::Marked,
        colour: None,
    });
    let chart = Chart {
        x_label: "unknowns",
        y_label: "CPU seconds a step",
        log_x: true,
        log_y: true,
        curves: curves.collect(),
        ..Chart::default()
    };
    let caption = "CPU seconds of one step after the first, one thread.";
    Some(Figure::chart("costs", "Cost of a step", chart.svg(), caption))
}

/// The least factor between each of FreeFEM's loops and us, over all meshes.
fn headline(all: &[(Choice, Page, Costs)]) -> Vec<KeyNumber> {
    let Some((.., first)) = all.first().filter(|(.., c)| !c.recorded) else { return Vec::new() };
    let factor = |k: usize| {
        let ratios =
            all.iter().filter_map(|(.., c)| Some(c.of.get(k)?.per_step / c.of.first()?.per_step));
        ratios.fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), r| (l.min(r), h.max(r)))
    };
    let loops = first.of.iter().enumerate().skip(1);
    let number = |(k, cost): (usize, &super::compare::Cost)| {
        let (low, high) = factor(k);
        KeyNumber {
            label: format!("{}, over immersa's", cost.who),
            value: format!("{} to {} times", rounded(low, 2), rounded(high, 2)),
            note: "CPU time of a step, over the meshes".into(),
        }
    };
    loops.map(number).collect()
}
