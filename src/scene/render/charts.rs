//! Charts of the series and of the profiles, each with a caption that says what is to be seen, and what would be wrong.

use super::folder::RunFolder;
use crate::output::{Chart, Curve, Stroke, Table};
use crate::scene::schema::{Membrane, Quantity};
use std::f64::consts::PI;

/// A chart and its words.
pub(super) struct Drawn {
    /// Name of its file, without ending.
    pub name: String,
    pub title: String,
    pub svg: String,
    pub caption: String,
}

/// The curves of a chart in the making.
struct Sheet<'a> {
    x_label: &'a str,
    x: &'a [f64],
    curves: Vec<(String, Vec<f64>, Stroke)>,
}

impl<'a> Sheet<'a> {
    fn add(&mut self, name: impl Into<String>, y: Option<Vec<f64>>, stroke: Stroke) {
        self.curves.extend(y.map(|y| (name.into(), y, stroke)));
    }
    fn line(&mut self, name: impl Into<String>, y: Option<&[f64]>) {
        self.add(name, y.map(<[f64]>::to_vec), Stroke::Line);
    }
    /// The chart, if there is anything to draw on it.
    fn draw(self, name: impl Into<String>, [title, y_label]: [&str; 2], caption: impl Into<String>) -> Option<Drawn> {
        let curve = |(name, y, stroke): &'a (String, Vec<f64>, Stroke)| Curve { name, x: self.x, y, stroke: *stroke };
        let _ = curve;
        if self.curves.is_empty() {
            return None;
        }
        let curves = self.curves.iter().map(|(name, y, stroke)| Curve { name, x: self.x, y, stroke: *stroke });
        let chart = Chart { title, x_label: self.x_label, y_label, curves: curves.collect(), ..Chart::default() };
        Some(Drawn { name: name.into(), title: format!("{title}."), svg: chart.svg(), caption: caption.into() })
    }
}

/// All charts that the folder has values for, in the order of the page.
pub(super) fn draw(run: &RunFolder) -> Vec<Drawn> {
    let mut charts = Vec::new();
    if let Some(time) = run.column("time") {
        let sheet = || Sheet { x_label: "time", x: time, curves: Vec::new() };
        for m in &run.scene.membranes {
            charts.extend(axes(run, m, sheet()));
            charts.extend(extents(run, m, sheet()));
        }
        let common = [stretch, area, energies, balance, speed, steps, fluxes];
        charts.extend(common.iter().filter_map(|chart| chart(run, sheet())));
        charts.extend(run.scene.output.probes.iter().filter_map(|p| probe(run, &p.name, p.of, sheet())));
        charts.extend(run.scene.output.forces.iter().filter_map(|f| force(run, &f.name, sheet())));
    }
    for (name, table) in &run.profiles {
        let of = run.scene.output.profiles.iter().find(|p| p.name == *name).map(|p| p.of);
        charts.extend(profile(name, table, of.map_or("value", quantity_name)));
    }
    charts
}

/// The radius of the circle of the enclosed area.
fn round_radius(run: &RunFolder, name: &str) -> Option<Vec<f64>> {
    Some(run.column_of(name, "area")?.iter().map(|a| (a / PI).sqrt()).collect())
}

fn axes(run: &RunFolder, m: &Membrane, mut sheet: Sheet) -> Option<Drawn> {
    let name = &m.name;
    sheet.line("larger", run.column_of(name, "axis_1"));
    sheet.line("smaller", run.column_of(name, "axis_2"));
    if !sheet.curves.is_empty() {
        sheet.add("circle", round_radius(run, name), Stroke::Dashed);
    }
    let title = format!("Semi-axes of {name}");
    sheet.draw(
        format!("axes-{name}"),
        [&title, "length"],
        "Semi-axes of the ellipse that has the second moments of the inside. Dashed: the radius of the circle of the same \
         area, the shape at rest in a fluid at rest; both axes end there when nothing drives the flow. A zigzag from row to \
         row would mean that the time step is too large for the stiffness of the membrane.",
    )
}

fn extents(run: &RunFolder, m: &Membrane, mut sheet: Sheet) -> Option<Drawn> {
    let name = &m.name;
    sheet.line("half width", run.column_of(name, "extent_x"));
    sheet.line("half height", run.column_of(name, "extent_y"));
    for chord in &m.chords {
        let half = run.column_of(name, &chord.name).map(<[f64]>::to_vec);
        sheet.add(chord.name.as_str(), half, Stroke::Dashed);
    }
    let title = format!("Extents and chords of {name}");
    let chords = if m.chords.is_empty() { "" } else { " Dashed: half the chords that the scene asks for." };
    sheet.draw(
        format!("extents-{name}"),
        [&title, "length"],
        format!(
            "Half the width and the height of the contour.{chords} They agree with the semi-axes as long as the shape is an \
             ellipse along the axes; where they part, it is not. A gap means that a line misses the contour."
        ),
    )
}

/// Perimeters over the length at rest, which is the perimeter at the start over the stretch there.
fn stretch(run: &RunFolder, mut sheet: Sheet) -> Option<Drawn> {
    let alone = run.scene.membranes.len() == 1;
    for m in &run.scene.membranes {
        let Some(perimeter) = run.column_of(&m.name, "perimeter") else { continue };
        let rest = perimeter.first().map_or(f64::NAN, |p| p / m.stretch);
        sheet.add(m.name.as_str(), Some(perimeter.iter().map(|p| p / rest).collect()), Stroke::Line);
        let least = round_radius(run, &m.name).filter(|_| alone);
        sheet.add("circle", least.map(|r| r.iter().map(|r| 2.0 * PI * r / rest).collect()), Stroke::Dashed);
    }
    let circle = if alone { " Dashed: that of a circle of the same area, the least there can be." } else { "" };
    sheet.draw(
        "stretch",
        ["Mean stretch", "perimeter / length at rest"],
        format!(
            "The perimeter over its length at rest: above 1 a membrane pulls.{circle} Below the circle it cannot come: then \
             area is lost."
        ),
    )
}

fn area(run: &RunFolder, mut sheet: Sheet) -> Option<Drawn> {
    for m in &run.scene.membranes {
        let change = |a: &[f64]| a.iter().map(|v| 100.0 * (v / a[0] - 1.0)).collect();
        sheet.add(m.name.as_str(), run.column_of(&m.name, "area").map(change), Stroke::Line);
    }
    sheet.draw(
        "area",
        ["Change of the enclosed area", "change (%)"],
        "No fluid crosses a membrane, so the truth is zero. A few hundredths of a per cent are the error of the mesh and \
         shrink with it; a steady drift to a per cent or more would mean that the mesh is too coarse or grad_div too small.",
    )
}

fn energies(run: &RunFolder, mut sheet: Sheet) -> Option<Drawn> {
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
        sheet.add("both", Some(total), Stroke::Line);
    }
    sheet.add("dissipated", dissipated, Stroke::Line);
    sheet.add("all", level, Stroke::Dashed);
    sheet.draw(
        "energy",
        ["Energy", "energy"],
        "Kinetic and elastic energy, their sum, and what has been dissipated since the start. Dashed: all together. When \
         nothing drives the flow the sum of both can only fall and the dashed line is level; a dashed line that rises \
         without work of walls or body forces is energy from nowhere.",
    )
}

/// The integral of a rate since the first row, by trapezes.
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

fn balance(run: &RunFolder, mut sheet: Sheet) -> Option<Drawn> {
    let residual = run.column("energy_balance").map(|b| b.iter().map(|v| 100.0 * v).collect());
    sheet.add("balance", residual, Stroke::Line);
    sheet.draw(
        "energy-balance",
        ["Energy balance", "from nowhere (%)"],
        "Energy that came from nowhere since the start, by (3.23), over the energy in play. The truth is zero. Below zero \
         the scheme itself dissipates, which a smaller step or a finer mesh lessens; above zero and rising it feeds the flow, \
         and nothing on this page should be believed.",
    )
}

fn speed(run: &RunFolder, mut sheet: Sheet) -> Option<Drawn> {
    sheet.line("speed", run.column("velocity_max"));
    sheet.draw(
        "speed",
        ["Largest speed", "speed"],
        "The largest speed at a node. It changes smoothly but at the start; spikes, or growth without a cause, are the first \
         sign of an instability.",
    )
}

fn steps(run: &RunFolder, mut sheet: Sheet) -> Option<Drawn> {
    sheet.line("Courant number", run.column("cfl"));
    let over = run.column("step_over_limit").filter(|c| c.iter().any(|v| *v != 0.0));
    sheet.line("step / explicit limit", over);
    sheet.draw(
        "step",
        ["Time step", "ratio"],
        "How many cells the fluid crosses in a step, and the step over the largest one that explicit coupling allows (1.54). \
         Explicit coupling is unstable above 1; implicit coupling is stable there, but accuracy asks for a Courant number of \
         about 1 or less.",
    )
}

fn fluxes(run: &RunFolder, mut sheet: Sheet) -> Option<Drawn> {
    for flux in &run.scene.output.fluxes {
        sheet.line(flux.name.as_str(), run.column(&flux.name));
    }
    sheet.draw(
        "fluxes",
        ["Fluxes", "volume per time"],
        "What leaves through the boundaries in unit time, negative where it enters. Over the whole boundary they must cancel.",
    )
}

fn probe(run: &RunFolder, name: &str, of: Quantity, mut sheet: Sheet) -> Option<Drawn> {
    sheet.line(quantity_name(of), run.column(name));
    for component in ["x", "y", "z"] {
        sheet.line(component, run.column(&format!("{name}_{component}")));
    }
    let title = format!("Probe {name}");
    sheet.draw(format!("probe-{name}"), [&title, quantity_name(of)], format!("The {} at a point.", quantity_name(of)))
}

fn force(run: &RunFolder, name: &str, mut sheet: Sheet) -> Option<Drawn> {
    for component in ["x", "y", "z"] {
        sheet.line(component, run.column(&format!("{name}_{component}")));
        let stress = run.column(&format!("{name}_stress_{component}")).map(<[f64]>::to_vec);
        sheet.add(format!("{component}, by stress"), stress, Stroke::Dashed);
    }
    let title = format!("Force {name}");
    sheet.draw(
        format!("force-{name}"),
        [&title, "force"],
        "The force of the fluid on the boundary, from the residual of the discrete equations and (dashed) from the integral \
         of the stress. The first is the more accurate by an order; the distance of the two shows how well the mesh \
         resolves the flow at the wall.",
    )
}

/// Curves on one chart at most: more colours cannot be told apart.
const MOST_CURVES: usize = 6;

fn profile(name: &str, table: &Table, of: &str) -> Option<Drawn> {
    let distance = table.column("distance").ok()?;
    let place = ["distance", "x", "y", "z"];
    let columns: Vec<_> =
        table.names.iter().zip(&table.columns).filter(|(n, _)| !place.contains(&n.as_str())).collect();
    let every = columns.len().div_ceil(MOST_CURVES).max(1);
    let mut sheet = Sheet { x_label: "distance", x: distance, curves: Vec::new() };
    // Counted from the end, so that the last time is among them.
    let first = columns.len().saturating_sub(1) % every;
    columns.iter().skip(first).step_by(every).for_each(|(n, c)| sheet.line(n.as_str(), Some(c)));
    let left_out = if every > 1 {
        format!(" One of {every} columns is shown, all are in profiles/{name}.csv.")
    } else {
        String::new()
    };
    let title = format!("Profile {name}");
    sheet.draw(
        format!("profile-{name}"),
        [&title, of],
        format!(
            "The {of} along a line, over the distance from its first point. A membrane makes the pressure jump over the \
             thickness of its band; wiggles away from it would mean that the mesh is too coarse for the band.{left_out}"
        ),
    )
}

pub(super) fn quantity_name(of: Quantity) -> &'static str {
    match of {
        Quantity::Pressure => "pressure",
        Quantity::Velocity => "velocity",
        Quantity::Speed => "speed",
        Quantity::LevelSet => "level set",
        Quantity::Stretch => "stretch",
    }
}
