//! Units of the columns of a series.

use super::charts::quantity_name;
use super::folder::RunFolder;

/// The unit of a column of the series; empty for a pure number, and where it is not known.
pub(super) fn of_column(run: &RunFolder, column: &str) -> String {
    match quantity(run, column) {
        Some(quantity) => run.unit(&quantity),
        None if column.ends_with(".angle") && !run.scene.units.is_empty() => "°".into(),
        None => String::new(),
    }
}

/// What a column holds, by the tables of the scene that ask for it, or by its name.
fn quantity(run: &RunFolder, column: &str) -> Option<String> {
    let output = &run.scene.output;
    // PROBE, FORCE_x: what follows a name of the scene.
    let after = |name: &str| match column.strip_prefix(name) {
        Some(rest) if rest.is_empty() || rest.starts_with('_') => Some(rest),
        _ => None,
    };
    if let Some(probe) = output.probes.iter().find(|p| after(&p.name).is_some()) {
        return Some(quantity_name(probe.of).into());
    }
    if let Some(rest) = output.forces.iter().find_map(|f| after(&f.name)) {
        return match rest {
            "_drag" | "_lift" => None,
            "_recirculation" => Some("length".into()),
            _ => Some(if rest.contains("_moment") { "moment" } else { "force" }.into()),
        };
    }
    if output.fluxes.iter().any(|f| after(&f.name) == Some("")) {
        return Some("volume per time".into());
    }
    if let Some(rest) = output.curves.iter().find_map(|c| after(&c.name)) {
        return Some(rest.trim_start_matches('_').into());
    }
    let Some((structure, quantity)) = column.split_once('.') else { return Some(column.into()) };
    let structure = run.scene.structures().iter().find(|s| s.name() == structure)?;
    let cut = |name: &String| {
        quantity
            .strip_prefix(name.as_str())
            .is_some_and(|rest| rest.is_empty() || rest == "_radius" || rest.starts_with("_mode_"))
    };
    Some(if structure.chords().iter().any(cut) { "length" } else { quantity }.into())
        .filter(|q: &String| q != "angle")
}
