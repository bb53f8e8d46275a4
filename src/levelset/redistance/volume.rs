//! Correction of the enclosed area or volume by a constant.

use super::super::interface::extents;
use crate::base::Result;
use crate::fem::Space;

/// Relative error of the enclosed area or volume at which the search stops.
const TOLERANCE: f64 = 1e-13;
/// Largest number of cuts.
const MOST_CUTS: usize = 20;

/// Adds to `phi` the constant `c` for which its cut interface encloses `wanted`, by the secant
/// method, which starts with `d(volume)/dc = -area/slope`, the derivative where
/// `|grad phi| = slope`. An empty interface does not change.
///
/// # Errors
/// Those of the cut.
pub(super) fn restore<const D: usize>(
    space: &Space<D>,
    wanted: f64,
    slope: f64,
    phi: &mut [f64],
) -> Result<()> {
    let mut shifted = phi.to_vec();
    let mut last: Option<(f64, f64)> = None;
    let mut best = (f64::INFINITY, 0.0);
    let mut c = 0.0;
    for _ in 0..MOST_CUTS {
        shifted.iter_mut().zip(phi.iter()).for_each(|(s, v)| *s = v + c);
        let [enclosed, area] = extents(space, &shifted)?;
        let miss = enclosed - wanted;
        if miss.abs() < best.0 {
            best = (miss.abs(), c);
        }
        if miss.abs() <= TOLERANCE * wanted || area == 0.0 {
            break;
        }
        let secant = last.map(|(before, miss_before)| (miss - miss_before) / (c - before));
        let derivative = secant.filter(|d| *d < 0.0 && d.is_finite()).unwrap_or(-area / slope);
        last = Some((c, miss));
        c -= miss / derivative;
    }
    phi.iter_mut().for_each(|v| *v += best.1);
    Ok(())
}
