//! Legends: the curves with names, in a column right of the plot or in columns below it.

use super::style::Style;
use super::svg::{Anchor, Canvas};
use super::text::{width, wrap};

/// Font size of a legend.
const SIZE: f64 = 12.0;
/// Distance of baselines.
const LINE: f64 = 15.0;
/// Distance of entries, added to that of lines.
const BETWEEN: f64 = 4.0;
/// Length of the line or room of the mark before a name.
const KEY: f64 = 20.0;
/// Distance between a key and its name.
const GAP: f64 = 6.0;
/// Distance between columns.
const COLUMN_GAP: f64 = 20.0;
/// Longest line of a name right of the plot; a legend with longer ones would take the room of the
/// data.
const LONGEST: f64 = 92.0;

/// A legend with its extent.
#[derive(Clone, Debug, Default)]
pub struct Legend {
    entries: Vec<Entry>,
    /// Width and height in pixels.
    pub extent: [f64; 2],
}

#[derive(Clone, Debug)]
struct Entry {
    style: Style,
    lines: Vec<String>,
    /// Upper left corner relative to that of the legend.
    at: [f64; 2],
}

impl Legend {
    /// A legend in one column, if its names are short enough and it is not higher than `height`.
    pub fn column(names: &[(&str, Style)], height: f64) -> Option<Legend> {
        let mut legend = Legend::default();
        for (name, style) in names {
            let lines = wrap(name, SIZE, LONGEST);
            let of_name = lines.iter().map(|l| KEY + GAP + width(l, SIZE)).fold(0.0, f64::max);
            let at = [0.0, legend.extent[1]];
            legend.extent = [legend.extent[0].max(of_name), at[1] + height_of(&lines)];
            legend.entries.push(Entry { style: *style, lines, at });
        }
        let few = legend.entries.iter().all(|e| e.lines.len() <= 2);
        (few && legend.extent[1] <= height).then_some(legend)
    }
    /// A legend in equal columns side by side, at most `room` wide.
    pub fn columns(names: &[(&str, Style)], room: f64) -> Legend {
        let lines: Vec<_> = names.iter().map(|n| wrap(n.0, SIZE, room - KEY - GAP)).collect();
        let widest = lines.iter().flatten().map(|l| width(l, SIZE)).fold(0.0, f64::max);
        let step = KEY + GAP + widest + COLUMN_GAP;
        let columns = (((room + COLUMN_GAP) / step) as usize).max(1);
        let rows = names.len().div_ceil(columns).max(1);
        let mut legend = Legend { extent: [room, 0.0], ..Legend::default() };
        for row in 0..rows {
            let top = legend.extent[1];
            for k in (row..names.len()).step_by(rows) {
                let (style, lines) = (names[k].1, lines[k].clone());
                let at = [(k / rows) as f64 * step, top];
                legend.extent[1] = legend.extent[1].max(top + height_of(&lines));
                legend.entries.push(Entry { style, lines, at });
            }
        }
        legend
    }
    /// Draws the legend with its upper left corner at the given point.
    pub fn draw(&self, canvas: &mut Canvas, corner: [f64; 2]) {
        for entry in &self.entries {
            let [x, y] = [corner[0] + entry.at[0], corner[1] + entry.at[1]];
            entry.style.draw_key(canvas, [x, x + KEY], y + 0.5 * LINE);
            for (k, line) in entry.lines.iter().enumerate() {
                // The middle of the small letters is at the height of the key.
                let baseline = y + k as f64 * LINE + 0.5 * LINE + 0.35 * SIZE;
                canvas.text(line, [x + KEY + GAP, baseline], Anchor::Start, SIZE);
            }
        }
    }
}

fn height_of(lines: &[String]) -> f64 {
    lines.len() as f64 * LINE + BETWEEN
}
