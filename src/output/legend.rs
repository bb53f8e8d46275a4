//! Legend beside the drawing of a picture: the title, the time and the colour bar.

use super::colours::Colours;
use super::lettering::{self, Align};
use super::numbers::{short, tick_text, ticks_for_reading};
use super::raster::{Image, Ink};

pub(super) const TEXT: Ink = Ink::solid([38, 42, 48]);
pub(super) const QUIET: Ink = Ink::solid([96, 102, 110]);

/// The title from column `left` on, and the time at the right end of the picture.
pub(super) fn draw_title(image: &mut Image, title: &str, time: Option<f64>, left: f64) {
    let right = image.width() as f64 - 20.0;
    let time = time.map(|t| format!("t = {}", short(t))).unwrap_or_default();
    let wanted = lettering::width(title, 12.5) + lettering::width(&time, 11.0) + 24.0;
    let fit = ((right - left) / wanted).min(1.0);
    lettering::draw(image, title, [left, 30.0], 12.5 * fit, Align::Left, TEXT);
    lettering::draw(image, &time, [right, 30.0], 11.0 * fit, Align::Right, TEXT);
}

/// The colour bar, with its left upper corner at a pixel, and its numbers.
pub(super) fn draw_bar(image: &mut Image, colours: &Colours, [x, top]: [usize; 2], height: usize) {
    let Colours { low, high, ref table, .. } = *colours;
    let width = 17;
    for row in 0..height {
        let k = (table.len() - 1) * (height - 1 - row) / (height - 1).max(1);
        image.fill([x, top + row], [width, 1], table[k]);
    }
    let (right, top) = ((x + width) as f64, top as f64);
    for v in ticks_for_reading(low, high, (height as f64 / 70.0).clamp(2.0, 8.0)) {
        let y = top + height as f64 * (high - v) / (high - low);
        let text = tick_text(v, 0.2 * (high - low), low.abs().max(high.abs()));
        image.stroke(&[[[right + 2.0, y], [right + 6.0, y]]], 1.0, QUIET);
        lettering::draw(image, &text, [right + 11.0, y + 4.5], 9.0, Align::Left, TEXT);
    }
}
