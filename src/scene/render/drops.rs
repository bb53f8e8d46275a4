//! Charts of drops.

use super::charts::{Drawn, Sheet};
use super::folder::RunFolder;

/// The column of a drop, unless walls or periodic sides cut it all the time: then it holds no number.
fn measured<'a>(run: &'a RunFolder, name: &str, column: &str) -> Option<&'a [f64]> {
    run.column_of(name, column).filter(|values| values.iter().any(|v| v.is_finite()))
}

/// The mean velocity of a drop over time.
pub(super) fn velocity(run: &RunFolder, name: &str, mut sheet: Sheet) -> Option<Drawn> {
    for axis in &["x", "y", "z"][..run.scene.dimension()] {
        sheet.line(*axis, measured(run, name, &format!("velocity_{axis}")));
    }
    let caption = "Components of the mean velocity of what is inside, by the flux through the interface.";
    sheet.draw(format!("velocity-{name}"), [&format!("Velocity of {name}"), "velocity"], caption)
}

/// How round a drop is, over time.
pub(super) fn roundness(run: &RunFolder, name: &str, mut sheet: Sheet) -> Option<Drawn> {
    let words = run.words();
    let column = if run.scene.dimension() == 2 { "circularity" } else { "sphericity" };
    sheet.line(column, measured(run, name, column));
    let caption = format!(
        "The {size} of the {round} that holds the same {enclosed} over that of the drop: 1 for a {round}.",
        size = words.size,
        round = words.round,
        enclosed = words.enclosed
    );
    sheet.draw(format!("{column}-{name}"), [&format!("Form of {name}"), column], caption)
}
