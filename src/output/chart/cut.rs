//! The range of an axis that the first values of a series do not dwarf: where a motion is set in
//! at once, they can be many times all that follow.

use super::Piece;
use crate::base::rounded;

/// Part of the values that may be beyond the range.
const PART: f64 = 0.1;
/// Least factor by which the range of all values exceeds that of the rest.
const FACTOR: f64 = 4.0;

/// A range of ordinates, and what is beyond it.
#[derive(Debug, PartialEq)]
pub struct Cut {
    /// Least and greatest ordinate of the rest.
    pub range: [f64; 2],
    /// What is cut off, in words.
    pub note: String,
}

/// The range of lines without their beginnings, where these dwarf the rest; `None` if nothing is
/// beyond it.
pub fn start(lines: &[Vec<Piece>]) -> Option<Cut> {
    let lines: Vec<Piece> = lines.iter().map(|pieces| pieces.concat()).collect();
    let ranges = lines.iter().filter_map(|points| of_rest(points).or_else(|| range(points)));
    let range = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    let beyond: Vec<_> =
        lines.iter().flatten().filter(|p| p[1] < range[0] || p[1] > range[1]).collect();
    let farthest = beyond.iter().copied().max_by(|a, b| a[1].abs().total_cmp(&b[1].abs()))?;
    let what = match beyond.len() {
        1 => "Cut off: the value".to_string(),
        n => format!("Cut off: {n} values, the largest"),
    };
    let value = rounded(farthest[1], 3).replace('-', "−");
    let note = format!("{what} {value} at {}", rounded(farthest[0], 6));
    Some(Cut { range, note })
}

/// The range of a line without a beginning that dwarfs the rest, of a tenth of the points at most;
/// `None` if none does.
fn of_rest(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    // The value at the start itself is often the zero that it is compared with.
    let most = ((PART * points.len() as f64) as usize).max(2).min(points.len().checked_sub(2)?);
    let mut found = range(points)?;
    let whole = found;
    for k in 1..=most {
        let rest = range(&points[k..])?;
        if rest[1] > rest[0] && found[1] - found[0] > FACTOR * (rest[1] - rest[0]) {
            found = rest;
        }
    }
    (found != whole).then_some(found)
}

fn range(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let pick = |f: fn(f64, f64) -> f64| points.iter().map(|p| p[1]).reduce(f);
    Some([pick(f64::min)?, pick(f64::max)?])
}

/// The parts of a line between two ordinates; where it leaves it is drawn to the end of the range.
pub fn clipped(piece: &[[f64; 2]], [low, high]: [f64; 2]) -> Vec<Piece> {
    let inside = |p: &[f64; 2]| (low..=high).contains(&p[1]);
    let mut parts = vec![Piece::new()];
    if let [point] = piece {
        return if inside(point) { vec![piece.to_vec()] } else { Vec::new() };
    }
    for ends in piece.windows(2) {
        let [a, b] = [ends[0], ends[1]];
        let at = |y: f64| [a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]), y];
        if a[1].max(b[1]) < low || a[1].min(b[1]) > high {
            continue;
        }
        let [from, to] = [a, b].map(|p| match p[1] {
            y if y < low => at(low),
            y if y > high => at(high),
            _ => p,
        });
        if !inside(&a) || parts.last().is_some_and(|part| part.is_empty()) {
            parts.push(vec![from]);
        }
        if let Some(part) = parts.last_mut() {
            part.push(to);
        }
    }
    parts.retain(|part| !part.is_empty());
    parts
}
