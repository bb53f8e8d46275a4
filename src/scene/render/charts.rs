//! Charts of the series and of the profiles, each with a caption that explains the curves and signs
//! of errors.

use super::folder::RunFolder;
use super::segmentation;
use crate::output::{Series, Stroke, rounded};
use crate::scene::charts::{Plot, Sheet};
use crate::scene::keys::Named;
use crate::scene::schema::{Probe, Profile, Quantity};

/// All charts that the folder has values for, in the order of the page.
pub(super) fn draw(run: &RunFolder) -> Vec<Plot> {
    let mut charts = Vec::new();
    if run.scene.image.is_some() {
        return segmentation::draw(run);
    }
    let columns = run.columns();
    if run.column("time").is_some() {
        let sheet = || columns.sheet();
        charts.extend(run.scene.structures().iter().flat_map(|s| s.charts(&columns)));
        let common = [stretch, area, map, energies, balance, speed, steps, fluxes];
        charts.extend(common.iter().filter_map(|chart| chart(run, sheet())));
        charts.extend(run.scene.output.probes.iter().filter_map(|p| probe(run, p, sheet())));
        let forces = run.scene.output.forces.iter();
        charts.extend(forces.clone().filter_map(|f| force(run, &f.name, sheet())));
        charts.extend(forces.filter_map(|f| coefficients(run, &f.name, sheet())));
    }
    charts.extend(run.profiles.iter().filter_map(|(p, table)| profile(run, p, table)));
    charts
}

/// Perimeters (in space: surfaces) over the length (area) at rest, which is that at the start over
/// the stretch there.
fn stretch(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    let (alone, words) = (run.scene.acting().count() == 1, run.words());
    // For a passive level set the length itself is drawn. With a map the area at rest is not the
    // initial area over a constant.
    for s in run.scene.acting() {
        let (name, traits) = (s.name(), s.traits());
        if !traits.has_size_at_rest {
            continue;
        }
        let Some(perimeter) = run.column_of(name, words.own) else { continue };
        let rest = perimeter.first().map_or(f64::NAN, |p| p / traits.slope);
        sheet.add(name, Some(perimeter.iter().map(|p| p / rest).collect()), Stroke::Line);
        let least = run.columns().round_radius(name).filter(|_| alone);
        let size = |r: Vec<f64>| r.iter().map(|r| (words.round_size)(*r) / rest).collect();
        sheet.add(words.round, least.map(size), Stroke::Dashed);
    }
    let (own, size, round, enclosed) = (words.own, words.size, words.round, words.enclosed);
    let least = match alone {
        true => {
            format!(" Dashed: that of a {round} of the same {enclosed}, the least there can be.")
        }
        false => String::new(),
    };
    sheet.draw(
        "stretch",
        ["Mean stretch", &format!("{own} / {size} at rest")],
        format!(
            "The {own} over its {size} at rest: above 1 a membrane pulls.{least} Below the \
             {round} it cannot come: then {enclosed} is lost."
        ),
    )
}

/// The error of the backward map, by its determinant.
fn map(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    sheet.line("rms(det grad Y - 1)", run.column("map_error"));
    sheet.draw(
        "map",
        ["Error of the backward map", "rms(det grad Y - 1)"],
        "How far the composed backward map is from keeping areas, which the flow does: an \
         estimate of its error. It grows with time; a smaller numerics.remap or a finer mesh \
         lessens it.",
    )
}

fn area(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    let enclosed = run.words().enclosed;
    for name in run.scene.interfaces() {
        let change = |a: &[f64]| a.iter().map(|v| 100.0 * (v / a[0] - 1.0)).collect();
        sheet.add(name, run.column_of(name, enclosed).map(change), Stroke::Line);
    }
    sheet.draw(
        enclosed,
        [&format!("Change of the enclosed {enclosed}"), "change (%)"],
        "No fluid crosses an interface, so the truth is zero. A few hundredths of a per cent are \
         the error of the mesh and shrink with it; a steady drift to a per cent or more would \
         mean that the mesh is too coarse or grad_div too small.",
    )
}

fn energies(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    let kinetic = run.column("energy_kinetic")?;
    let elastic = run.column("energy_elastic").filter(|e| e.iter().any(|v| *v != 0.0));
    let total: Vec<f64> = match elastic {
        Some(elastic) => kinetic.iter().zip(elastic).map(|(k, e)| k + e).collect(),
        None => kinetic.to_vec(),
    };
    let dissipated = run.column("dissipation").map(|rate| cumulative(sheet.x, rate));
    let sum = |d: &Vec<f64>| d.iter().zip(&total).map(|(d, t)| d + t).collect();
    let level = dissipated.as_ref().map(sum);
    sheet.line("kinetic", Some(kinetic));
    if let Some(elastic) = elastic {
        sheet.line("elastic", Some(elastic));
        sheet.add("sum", Some(total), Stroke::Line);
    }
    sheet.add("dissipated", dissipated, Stroke::Line);
    sheet.add("together", level, Stroke::Dashed);
    sheet.draw(
        "energy",
        ["Energy", "energy"],
        "What the flow and the membranes hold, and what viscosity has taken since the start. \
         Dashed: together, which is the energy at the start and the work of walls and forces. \
         When nothing drives the flow the energy held can only fall and the dashed line is level; \
         if it then rises, the energy is spurious.",
    )
}

/// The integral of a rate since the first row, by the trapezoidal rule.
fn cumulative(x: &[f64], rate: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = x.windows(2).zip(rate.windows(2)).map(|(x, r)| 0.5 * (x[1] - x[0]) * (r[0] + r[1]));
    std::iter::once(0.0)
        .chain(steps.map(|s| {
            sum += s;
            sum
        }))
        .collect()
}

fn balance(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    let residual = run.column("energy_balance").map(|b| b.iter().map(|v| 100.0 * v).collect());
    sheet.add("balance", residual, Stroke::Line);
    sheet.cut_start = true;
    sheet.draw(
        "energy-balance",
        ["Energy balance", "residual (%)"],
        "Spurious energy since the start, the residual of (3.23), over the energy in play, which \
         is little while a flow starts from rest. The truth is zero; a fraction of a per cent is \
         the error of the scheme, which a smaller step or a finer mesh lessens. Several per cent \
         and rising faster and faster would be an instability: then believe nothing on this page. \
         Where a flow is set in motion at once, the first values can dwarf all others; they are \
         then cut off, and the chart says so.",
    )
}

fn speed(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    sheet.line("speed", run.column("velocity_max"));
    sheet.draw(
        "speed",
        ["Largest speed", "speed"],
        "The largest speed at a node. It changes smoothly but at the start; spikes, or growth \
         without a cause, are the first sign of an instability.",
    )
}

fn steps(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    sheet.line("Courant number", run.column("cfl"));
    let mut caption =
        "How many cells the fluid crosses in a step; more than about 1 costs accuracy.".to_string();
    if run.scene.acting().next().is_some() {
        sheet.line("step / explicit limit", run.column("step_over_limit"));
        caption += " And the step over the largest one that explicit coupling allows (1.54): \
            above 1 explicit coupling is unstable, while implicit coupling is not.";
        if run.scene.acting().any(|s| s.traits().resists_shear) {
            caption += " With shear this limit is on the safe side: steps of 1.4 to 4.1 times it \
                were found stable.";
        }
    }
    sheet.draw("step", ["Time step", "ratio"], caption)
}

fn fluxes(run: &RunFolder, mut sheet: Sheet) -> Option<Plot> {
    for flux in &run.scene.output.fluxes {
        sheet.line(flux.name.as_str(), run.column(&flux.name));
    }
    sheet.draw(
        "fluxes",
        ["Fluxes", "volume per time"],
        "What leaves through the boundaries in unit time, negative where it enters. Over the \
         whole boundary they must cancel.",
    )
}

fn probe(run: &RunFolder, probe: &Named<Probe>, mut sheet: Sheet) -> Option<Plot> {
    let (name, of) = (&probe.name, quantity_name(probe.of));
    sheet.line(of, run.column(name));
    for component in ["x", "y", "z"] {
        sheet.line(component, run.column(&format!("{name}_{component}")));
    }
    let at: Vec<String> = probe.at.iter().map(|x| rounded(*x, 6)).collect();
    let title = format!("Probe {name}");
    sheet.draw(format!("probe-{name}"), [&title, of], format!("The {of} at ({}).", at.join(", ")))
}

fn force(run: &RunFolder, name: &str, mut sheet: Sheet) -> Option<Plot> {
    for component in ["x", "y", "z"] {
        sheet.line(component, run.column(&format!("{name}_{component}")));
        let stress = run.column(&format!("{name}_stress_{component}")).map(<[f64]>::to_vec);
        sheet.add(format!("{component}, by stress"), stress, Stroke::Dashed);
    }
    let title = format!("Force {name}");
    sheet.draw(
        format!("force-{name}"),
        [&title, "force"],
        "The force of the fluid on the boundary, from the residual of the discrete equations and \
         (dashed) from the integral of the stress. The first is the more accurate by an order; \
         the distance of the two shows how well the mesh resolves the flow at the wall.",
    )
}

fn coefficients(run: &RunFolder, name: &str, mut sheet: Sheet) -> Option<Plot> {
    sheet.line("drag", run.column(&format!("{name}_drag")));
    sheet.line("lift", run.column(&format!("{name}_lift")));
    let title = format!("Coefficients of {name}");
    sheet.draw(
        format!("coefficients-{name}"),
        [&title, "coefficient"],
        "Drag and lift over the dynamic pressure and the size of the scene's reference, by the \
         residual of the discrete equations.",
    )
}

/// Maximum number of curves in a chart: more colours cannot be distinguished.
const MOST_CURVES: usize = 6;

fn profile<'a>(run: &'a RunFolder, profile: &Named<Profile>, table: &'a Series) -> Option<Plot> {
    let (name, of) = (&profile.name, quantity_name(profile.of));
    let distance = table.column("distance").ok()?;
    let place = ["distance", "x", "y", "z"];
    let columns: Vec<_> = table
        .names
        .iter()
        .zip(&table.columns)
        .filter(|(n, _)| !place.contains(&n.as_str()))
        .collect();
    let every = columns.len().div_ceil(MOST_CURVES).max(1);
    // Counted from the end, so that the last time is included.
    let first = columns.len().saturating_sub(1) % every;
    let mut sheet = run.columns().sheet_over("distance", distance);
    columns.iter().skip(first).step_by(every).for_each(|(n, c)| sheet.line(n.as_str(), Some(c)));
    let point = |x: &[f64]| x.iter().map(|v| rounded(*v, 6)).collect::<Vec<_>>().join(", ");
    let mut caption = format!(
        "The {of} along the line from ({}) to ({}).",
        point(&profile.from),
        point(&profile.to)
    );
    if profile.of == Quantity::Pressure && run.scene.acting().next().is_some() {
        caption += " A membrane makes it jump over the thickness of its band; wiggles away from \
            the band would mean that the mesh is too coarse for it.";
    }
    if every > 1 {
        caption += &format!(" One of {every} columns is shown, all are in profiles/{name}.csv.");
    }
    sheet.draw(format!("profile-{name}"), [&format!("Profile {name}"), of], caption)
}

/// The name of a quantity, as axes have it.
pub(super) fn quantity_name(of: Quantity) -> &'static str {
    match of {
        Quantity::Pressure => "pressure",
        Quantity::Velocity => "velocity",
        Quantity::Speed => "speed",
        Quantity::Vorticity => "vorticity",
        Quantity::LevelSet => "level set",
        Quantity::Stretch => "stretch",
        Quantity::AreaChange => "area change",
        Quantity::Shear => "shear",
        Quantity::Image => "image",
        Quantity::Checkerboard => "material",
    }
}
