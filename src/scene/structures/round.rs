//! Measurements of drops only: roundness and mean velocity.

use crate::base::Result;
use crate::mesh::Point;
use crate::scene::charts::{Columns, Plot};
use crate::scene::row::Row;
use crate::scene::view::View;
use std::f64::consts::PI;

/// Axes by name.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Name of the column of the roundness.
fn roundness(dimension: usize) -> &'static str {
    if dimension == 2 { "circularity" } else { "sphericity" }
}

/// Measures structure number `k` with the enclosed measure `enclosed` and the length (in space:
/// area) `own`: the size of the round form of the same measure over `own`, at most 1, and the mean
/// velocity inside.
///
/// The velocity is computed over the interface, `int_S (x - c)_i u . n ds / enclosed`, which is the
/// mean of `u_i` for any `c` if the velocity is divergence-free. It is NaN for a drop that is cut
/// by walls or periodic sides.
///
/// # Errors
/// A level set that is not finite.
pub(super) fn measure<const D: usize>(
    view: &View<'_, D>,
    (name, k): (&str, usize),
    [enclosed, own]: [f64; 2],
    row: &mut Row,
) -> Result<()> {
    let round = match D {
        2 => 2.0 * (PI * enclosed).sqrt(),
        _ => (36.0 * PI * enclosed * enclosed).cbrt(),
    };
    let (space, u) = (view.carried.space(), &view.state.flow.u);
    let points = view.surface(k)?;
    let zero = Point::<D>::zeros();
    let (mut flux, mut closed, mut middle) = (zero, zero, zero);
    points.iter().for_each(|p| middle += p.at.x * (p.at.weight / own));
    for p in &points {
        let through = space.value(u, p.at.cell, &p.at.barycentric).dot(&p.normal);
        flux += (p.at.x - middle) * (p.at.weight * through);
        closed += p.normal * p.at.weight;
    }
    // The integral of the normal over a closed interface vanishes.
    let whole = closed.norm() < 1e-3 * own;
    row.put(format!("{name}.{}", roundness(D)), if whole { round / own } else { f64::NAN });
    for (axis, f) in AXES.iter().zip(flux.iter()) {
        row.put(format!("{name}.velocity_{axis}"), if whole { f / enclosed } else { f64::NAN });
    }
    Ok(())
}

/// The column of a drop; `None` if walls or periodic sides cut it at all times, so that it has no
/// values.
fn measured<'a>(of: &Columns<'a>, name: &str, column: &str) -> Option<&'a [f64]> {
    of.column_of(name, column).filter(|values| values.iter().any(|v| v.is_finite()))
}

/// The mean velocity of a drop over time.
pub(super) fn velocity_chart(of: &Columns<'_>, name: &str) -> Option<Plot> {
    let mut sheet = of.sheet();
    for axis in &AXES[..of.dimension] {
        sheet.line(*axis, measured(of, name, &format!("velocity_{axis}")));
    }
    let caption =
        "Components of the mean velocity of what is inside, by the flux through the interface.";
    sheet.draw(format!("velocity-{name}"), [&format!("Velocity of {name}"), "velocity"], caption)
}

/// Roundness of a drop over time.
pub(super) fn roundness_chart(of: &Columns<'_>, name: &str) -> Option<Plot> {
    let (words, mut sheet) = (of.words(), of.sheet());
    let column = roundness(of.dimension);
    sheet.line(column, measured(of, name, column));
    let caption = format!(
        "The {size} of the {round} that holds the same {enclosed} over that of the drop: 1 for a \
         {round}.",
        size = words.size,
        round = words.round,
        enclosed = words.enclosed
    );
    sheet.draw(format!("{column}-{name}"), [&format!("Form of {name}"), column], caption)
}
