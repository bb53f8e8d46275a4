//! Layout of a chart: margins from the extents of labels and legend, the frame of the plot, and
//! what stands around it.

use super::axis::{Axis, Tick};
use super::legend::Legend;
use super::style::{NEUTRAL, Style};
use super::svg::{Anchor, Canvas, Pen};
use super::text::{Label, width, wrap};

/// Width of the drawing,
/// such that texts can be read where it is 370 pixels wide, on a telephone.
pub const WIDTH: f64 = 460.0;
/// Height of the drawing without a legend below the plot.
pub const HEIGHT: f64 = 300.0;
/// Font size of the title.
pub const TITLE: f64 = 15.0;
/// Font size of the labels of axes.
pub const LABEL: f64 = 13.0;
/// Font size of the note under the title.
const NOTE: f64 = 12.0;
/// Font size of the numbers on axes.
const NUMBER: f64 = 12.0;
/// Distance of baselines over the font size.
pub const LEADING: f64 = 1.3;
/// Empty border of the drawing, and distance between what stands side by side.
const BORDER: f64 = 8.0;
/// Length of a tick, and of a minor one.
const TICK: [f64; 2] = [5.0, 3.0];
/// Distance between a tick and its number, and between numbers and the label of the axis.
const GAP: f64 = 4.0;
/// Least distance between numbers on the horizontal axis.
const BETWEEN: f64 = 10.0;

/// The plot: its axes and its place in the drawing.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    axes: [Axis; 2],
    /// Left end.
    pub left: f64,
    /// Right end.
    pub right: f64,
    top: f64,
    bottom: f64,
}

impl Frame {
    /// The place of a point in the drawing.
    pub fn place(&self, point: [f64; 2]) -> [f64; 2] {
        [self.x(self.axes[0].fraction(point[0])), self.y(self.axes[1].fraction(point[1]))]
    }
    /// Its axes.
    pub fn axes(&self) -> &[Axis; 2] {
        &self.axes
    }
    /// Left and right end, upper and lower end.
    pub fn ends(&self) -> [f64; 4] {
        [self.left, self.right, self.top, self.bottom]
    }
    fn x(&self, fraction: f64) -> f64 {
        self.left + fraction * (self.right - self.left)
    }
    fn y(&self, fraction: f64) -> f64 {
        self.bottom + fraction * (self.top - self.bottom)
    }
}

/// Everything about a chart but its curves.
#[derive(Debug)]
pub struct Layout {
    /// The plot.
    pub frame: Frame,
    /// Width and height of the drawing.
    pub size: [f64; 2],
    ticks: [Vec<Tick>; 2],
    title: Vec<String>,
    note: Vec<String>,
    labels: [Vec<String>; 2],
    legend: Legend,
    /// Upper left corner of the legend.
    corner: [f64; 2],
}

impl Layout {
    /// The layout for the axes, the title and the note under it, the labels of the axes and the
    /// curves with a name.
    pub fn new(
        axes: [Axis; 2],
        [title, note]: [&str; 2],
        labels: [&str; 2],
        names: &[(&str, Style)],
    ) -> Layout {
        let title = wrap(title, TITLE, WIDTH - 2.0 * BORDER);
        let note = wrap(note, NOTE, WIDTH - 2.0 * BORDER);
        let above = height(&title, TITLE) + height(&note, NOTE);
        let top = BORDER + above + if above > 0.0 { GAP } else { 0.0 };
        let x_label = wrap(labels[0], LABEL, 0.6 * WIDTH);
        let bottom = HEIGHT - BORDER - height(&x_label, LABEL) - under_axis();
        let y_label = wrap(labels[1], LABEL, bottom - top);
        let y_ticks = axes[1].ticks(|ticks| rows_fit(ticks, bottom - top));
        let left = BORDER + height(&y_label, LABEL) + GAP + widest(&y_ticks) + GAP + TICK[0];
        let beside = Legend::column(names, bottom - top);
        let room = beside.as_ref().map_or(0.0, |l| l.extent[0]);
        let room = if room > 0.0 { room + BORDER } else { 0.0 };
        let (x_ticks, right) = horizontal(&axes[0], left, WIDTH - BORDER - room);
        let (legend, corner, height) = match beside {
            Some(legend) => (legend, [right + BORDER, top], HEIGHT),
            None => {
                let legend = Legend::columns(names, WIDTH - BORDER - left);
                let height = HEIGHT + legend.extent[1] + BORDER;
                (legend, [left, HEIGHT], height)
            }
        };
        Layout {
            frame: Frame { axes, left, right, top, bottom },
            size: [WIDTH, height],
            ticks: [x_ticks, y_ticks],
            title,
            note,
            labels: [x_label, y_label],
            legend,
            corner,
        }
    }
    /// Draws grid, axes, texts and legend.
    pub fn draw(&self, canvas: &mut Canvas) {
        let Frame { left, right, top, bottom, .. } = self.frame;
        canvas.group("ticks", |canvas| {
            self.ticks[0].iter().for_each(|tick| self.draw_x_tick(tick, canvas));
            self.ticks[1].iter().for_each(|tick| self.draw_y_tick(tick, canvas));
        });
        canvas.line(&[[left, top], [left, bottom], [right, bottom]], AXIS);
        for (k, line) in self.title.iter().enumerate() {
            let y = BORDER + baseline(k, TITLE);
            let x = centred(line, TITLE, 0.5 * (left + right), WIDTH);
            canvas.text(line, [x, y], Anchor::Middle, TITLE);
        }
        for (k, line) in self.note.iter().enumerate() {
            let y = BORDER + height(&self.title, TITLE) + baseline(k, NOTE);
            let x = centred(line, NOTE, 0.5 * (left + right), WIDTH);
            canvas.text(line, [x, y], Anchor::Middle, NOTE);
        }
        for (k, line) in self.labels[0].iter().enumerate() {
            let x = centred(line, LABEL, 0.5 * (left + right), WIDTH);
            let y = bottom + under_axis() + baseline(k, LABEL);
            canvas.text(line, [x, y], Anchor::Middle, LABEL);
        }
        for (k, line) in self.labels[1].iter().enumerate() {
            let y = centred(line, LABEL, 0.5 * (top + bottom), HEIGHT);
            canvas.upright(line, [BORDER + baseline(k, LABEL), y], Anchor::Middle, LABEL);
        }
        self.legend.draw(canvas, self.corner);
    }
    fn draw_x_tick(&self, tick: &Tick, canvas: &mut Canvas) {
        let Frame { top, bottom, .. } = self.frame;
        let x = self.frame.x(tick.at);
        let Some(label) = &tick.label else {
            return canvas.line(&[[x, bottom], [x, bottom + TICK[1]]], AXIS);
        };
        canvas.line(&[[x, top], [x, bottom]], GRID);
        canvas.line(&[[x, bottom], [x, bottom + TICK[0]]], AXIS);
        let y = bottom + TICK[0] + GAP + baseline(0, NUMBER);
        canvas.label(label, [x, y], Anchor::Middle, NUMBER);
    }
    fn draw_y_tick(&self, tick: &Tick, canvas: &mut Canvas) {
        let Frame { left, right, .. } = self.frame;
        let y = self.frame.y(tick.at);
        let Some(label) = &tick.label else {
            return canvas.line(&[[left - TICK[1], y], [left, y]], AXIS);
        };
        canvas.line(&[[left, y], [right, y]], GRID);
        canvas.line(&[[left - TICK[0], y], [left, y]], AXIS);
        canvas.label(label, [left - TICK[0] - GAP, y + 0.36 * NUMBER], Anchor::End, NUMBER);
    }
}

const AXIS: Pen<'static> = Pen { colour: NEUTRAL, width: 1.0, dash: "", opacity: 1.0 };
const GRID: Pen<'static> = Pen { colour: NEUTRAL, width: 0.6, dash: "", opacity: 0.35 };

/// Height of lines of text.
fn height(lines: &[String], size: f64) -> f64 {
    lines.len() as f64 * LEADING * size
}

/// Baseline of line `k` below the upper end of a text.
fn baseline(k: usize, size: f64) -> f64 {
    (k as f64 * LEADING + 1.0) * size
}

/// Height of the ticks of the horizontal axis with their numbers.
fn under_axis() -> f64 {
    TICK[0] + GAP + LEADING * NUMBER + GAP
}

/// The centre of a text that is centred about `middle`, or near it where it would pass the ends of
/// the drawing.
fn centred(text: &str, size: f64, middle: f64, end: f64) -> f64 {
    let half = 0.5 * width(text, size) + 0.5 * BORDER;
    if 2.0 * half < end { middle.clamp(half, end - half) } else { 0.5 * end }
}

fn numbers(ticks: &[Tick]) -> impl Iterator<Item = (f64, &Label)> {
    ticks.iter().filter_map(|t| Some((t.at, t.label.as_ref()?)))
}

fn widest(ticks: &[Tick]) -> f64 {
    numbers(ticks).map(|(_, l)| l.width(NUMBER)).fold(0.0, f64::max)
}

/// True if the numbers of a vertical axis do not touch.
fn rows_fit(ticks: &[Tick], length: f64) -> bool {
    let places: Vec<f64> = numbers(ticks).map(|(at, _)| at * length).collect();
    places.len() > 1 && places.windows(2).all(|p| p[1] - p[0] >= 1.8 * NUMBER)
}

/// True if the numbers of a horizontal axis do not touch.
fn columns_fit(ticks: &[Tick], length: f64) -> bool {
    let half = |l: &Label| 0.5 * l.width(NUMBER);
    let ends = |(at, l): (f64, &Label)| [at * length - half(l), at * length + half(l)];
    let ends: Vec<[f64; 2]> = numbers(ticks).map(ends).collect();
    ends.len() > 1 && ends.windows(2).all(|p| p[1][0] - p[0][1] >= BETWEEN)
}

/// The ticks of the horizontal axis and its right end, drawn in where the last number would pass
/// `end`.
fn horizontal(axis: &Axis, left: f64, end: f64) -> (Vec<Tick>, f64) {
    let ticks = axis.ticks(|ticks| columns_fit(ticks, end - left));
    let past = |right: f64| {
        let last = |(at, l): (f64, &Label)| at * (right - left) + 0.5 * l.width(NUMBER);
        // The border beyond the end may be used.
        left + numbers(&ticks).map(last).fold(0.0, f64::max) - end - 0.5 * BORDER
    };
    let right = end - past(end).max(0.0);
    (ticks, right)
}
