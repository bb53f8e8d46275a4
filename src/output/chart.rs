//! Line charts as SVG, drawn by `kuva`; this is the only file that names it.
//!
//! Text takes the colour of the page around it (`currentColor`), lines and marks have colours that colour-blind readers
//! can tell apart (Okabe and Ito) and that show on white and on black: one chart serves a light and a dark page.

use super::markup::escape;
use super::numbers::{tick_text, trimmed};
use crate::base::fnv1a;
use kuva::plot::legend::LegendPosition;
use kuva::plot::line::LinePlot;
use kuva::plot::scatter::ScatterPlot;
use kuva::render::annotations::TextAnnotation;
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render_utils::{format_log_tick, generate_ticks_log};
use kuva::render::theme::Theme;
use std::sync::Arc;

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stroke {
    /// A full line.
    #[default]
    Line,
    /// A dashed line: references and slopes.
    Dashed,
    /// Marks: measured or published values.
    Points,
    /// Marks joined by a line: a row of runs.
    Marked,
}

impl Stroke {
    fn has_marks(self) -> bool {
        matches!(self, Stroke::Points | Stroke::Marked)
    }
}

/// A curve of a chart. Points with a coordinate that is not finite, or not positive on a logarithmic axis, leave a gap.
#[derive(Clone, Copy, Debug, Default)]
pub struct Curve<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Abscissas.
    pub x: &'a [f64],
    /// Ordinates.
    pub y: &'a [f64],
    /// How it is drawn.
    pub stroke: Stroke,
    /// Number of its colour; its place among the curves without it.
    pub colour: Option<usize>,
}

/// A triangle that shows a slope on logarithmic axes, its order written at its upright side: a power of `x` from `x[0]` to `x[1]`
/// that is `y` at `x[0]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Left and right end.
    pub x: [f64; 2],
    /// The ordinate at the left end.
    pub y: f64,
    /// The power.
    pub order: f64,
    /// Whether the triangle lies above its slope, for a place above the curves; else below.
    pub above: bool,
}

impl Slope {
    /// The ordinate at the right end.
    fn end(&self) -> f64 {
        self.y * (self.x[1] / self.x[0]).powf(self.order)
    }
    /// The corner with the right angle.
    fn corner(&self) -> (f64, f64) {
        if self.above { (self.x[0], self.end()) } else { (self.x[1], self.y) }
    }
    fn corners(&self) -> [(f64, f64); 3] {
        [(self.x[0], self.y), (self.x[1], self.end()), self.corner()]
    }
}

/// A chart of one or more curves.
#[derive(Clone, Debug, Default)]
pub struct Chart<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Label of the horizontal axis, with the unit if there is one.
    pub x_label: &'a str,
    /// Label of the vertical axis, with the unit if there is one.
    pub y_label: &'a str,
    /// Whether the horizontal axis is logarithmic.
    pub log_x: bool,
    /// Whether the vertical axis is logarithmic.
    pub log_y: bool,
    /// The curves.
    pub curves: Vec<Curve<'a>>,
    /// Slope triangles; drawn where both axes are logarithmic.
    pub slopes: Vec<Slope>,
}

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 350.0;
/// Size of the numbers on axes.
const TICK_SIZE: u32 = 12;
/// Pixels left of the axis of a chart but for the numbers there.
const LEFT: f64 = 36.0;
/// Okabe and Ito (2008), the blue a little brighter for dark pages, those with the least contrast to white last, and grey.
const COLOURS: [&str; 7] = ["#1F82C0", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#888888"];
/// What is neither a curve nor text; shows on white and on black.
const NEUTRAL: &str = COLOURS[6];
/// A line of more points is thinned; no screen shows more.
const MOST_POINTS: usize = 4000;

impl Chart<'_> {
    /// The chart as an SVG document that scales to the width of its page.
    pub fn svg(&self) -> String {
        let parts: Vec<Vec<Vec<(f64, f64)>>> = self.curves.iter().map(|c| self.pieces(c)).collect();
        let slopes: Vec<&Slope> = self.slopes.iter().filter(|s| self.can_draw(s)).collect();
        let corners: Vec<(f64, f64)> = slopes.iter().flat_map(|s| s.corners()).collect();
        let all = || parts.iter().flatten().flatten().chain(&corners);
        let only_lines = self.curves.iter().all(|c| !c.stroke.has_marks());
        let x = Axis::of(all().map(|p| p.0), self.log_x, if only_lines && !self.log_x { 0.0 } else { 0.04 });
        let y = Axis::of(all().map(|p| p.1), self.log_y, 0.05);
        let (Some(x), Some(y)) = (x, y) else { return self.empty() };
        let mut plots = Vec::new();
        for (i, (curve, pieces)) in self.curves.iter().zip(&parts).enumerate() {
            let colour = COLOURS[curve.colour.unwrap_or(i) % COLOURS.len()];
            for (k, piece) in pieces.iter().enumerate() {
                let data = || piece.iter().map(|p| (x.scaled(p.0), y.scaled(p.1)));
                let name = (k == 0 && self.curves.len() > 1 && !curve.name.is_empty()).then_some(curve.name);
                if curve.stroke != Stroke::Points {
                    // The legend of a marked line shows its marks.
                    plots.push(line(data(), curve.stroke, colour, name.filter(|_| curve.stroke != Stroke::Marked)));
                }
                if curve.stroke.has_marks() {
                    plots.push(marks(data(), colour, name));
                }
            }
        }
        plots.extend(slopes.iter().map(|s| triangle(s, &x, &y)));
        let mut layout = Layout::auto_from_plots(&plots)
            .with_x_label(self.x_label)
            .with_y_label(self.y_label)
            .with_theme(theme())
            .with_width(WIDTH)
            .with_height(HEIGHT)
            .with_legend_position(LegendPosition::OutsideRightTop)
            .with_title_size(16)
            .with_label_size(13)
            .with_tick_size(TICK_SIZE)
            .with_body_size(12)
            .with_grid_line_width(0.6)
            .with_x_axis_min(x.scaled(x.low))
            .with_x_axis_max(x.scaled(x.high))
            .with_y_axis_min(y.scaled(y.low))
            .with_y_axis_max(y.scaled(y.high))
            .with_x_tick_format(x.format())
            .with_y_tick_format(y.format());
        if !self.title.is_empty() {
            layout = layout.with_title(self.title);
        }
        // The room for numbers and labels is measured on these ranges.
        layout.x_range = (x.scaled(x.low), x.scaled(x.high));
        layout.y_range = (y.scaled(y.low), y.scaled(y.high));
        layout.data_x_range = self.log_x.then_some(layout.x_range);
        layout.data_y_range = self.log_y.then_some(layout.y_range);
        if self.log_x {
            layout = layout.with_log_x();
        }
        if self.log_y {
            layout = layout.with_log_y();
            // `kuva` makes room for numbers as it would write them.
            let [made, wanted] = y.room();
            if wanted > made {
                layout.force_margin_left = Some(LEFT + wanted);
                layout = layout.with_y_label_offset(made - wanted, 0.0);
            }
        }
        for slope in slopes {
            layout = layout.with_annotation(number(slope, &x, &y));
        }
        self.scalable(&kuva::render_to_svg(plots, layout))
    }
    fn can_draw(&self, slope: &Slope) -> bool {
        let good = |v: f64| v.is_finite() && v > 0.0;
        self.log_x && self.log_y && slope.corners().iter().all(|p| good(p.0) && good(p.1))
    }
    /// The runs of points that can be drawn.
    fn pieces(&self, curve: &Curve) -> Vec<Vec<(f64, f64)>> {
        let good = |v: f64, log: bool| v.is_finite() && (!log || v > 0.0);
        let mut pieces = vec![Vec::new()];
        for (&x, &y) in curve.x.iter().zip(curve.y) {
            match pieces.last_mut() {
                Some(last) if good(x, self.log_x) && good(y, self.log_y) => last.push((x, y)),
                Some(last) if !last.is_empty() => pieces.push(Vec::new()),
                _ => {}
            }
        }
        pieces.retain(|p| !p.is_empty());
        pieces.iter().map(|p| if curve.stroke.has_marks() { p.clone() } else { thinned(p) }).collect()
    }
    /// Lets the drawing scale and names it for those who cannot see it.
    fn scalable(&self, svg: &str) -> String {
        let Some((head, body)) = svg.split_once('>') else { return self.empty() };
        let fixed = format!(" width=\"{WIDTH}\" height=\"{HEIGHT}\"");
        let fluid = format!(" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\"", escape(self.title));
        steady(&format!("{}>{body}", head.replace(&fixed, &fluid)))
    }
    /// What stands in for a chart without a point.
    fn empty(&self) -> String {
        let line = |y: u32, size: u32, text: &str| {
            format!(
                "<text x=\"50%\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"middle\" fill=\"currentColor\">{}</text>",
                escape(text)
            )
        };
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} 120\" role=\"img\" font-family=\"sans-serif\">{}{}</svg>",
            line(30, 16, self.title),
            line(70, 13, "no values that can be drawn")
        )
    }
}

/// The names of clipping paths made from the drawing itself: `kuva` counts them within a process, so that the same chart
/// would have other bytes the next time. On one page, only charts that are the same share a name.
fn steady(svg: &str) -> String {
    const NAME: &str = "kuva-clip-";
    let renamed = |to: &str| {
        let mut known = Vec::new();
        let mut pieces = svg.split(NAME);
        let mut out = pieces.next().unwrap_or_default().to_string();
        for piece in pieces {
            let rest = piece.trim_start_matches(|c: char| c.is_ascii_digit());
            let number = &piece[..piece.len() - rest.len()];
            let k = known.iter().position(|n| *n == number).unwrap_or(known.len());
            if k == known.len() {
                known.push(number);
            }
            out += &format!("clip-{to}{k}{rest}");
        }
        out
    };
    let hash = fnv1a(renamed("").as_bytes());
    renamed(&format!("{hash:016x}-"))
}

fn marks(data: impl Iterator<Item = (f64, f64)>, colour: &str, name: Option<&str>) -> Plot {
    let plot = ScatterPlot::new().with_data(data).with_color(colour).with_size(4.0);
    match name {
        Some(name) => plot.with_legend(name).into(),
        None => plot.into(),
    }
}

fn line(data: impl Iterator<Item = (f64, f64)>, stroke: Stroke, colour: &str, name: Option<&str>) -> Plot {
    let plot = LinePlot::new().with_data(data).with_color(colour).with_stroke_width(1.8);
    let plot = if stroke == Stroke::Dashed { plot.with_dashed() } else { plot };
    match name {
        Some(name) => plot.with_legend(name).into(),
        None => plot.into(),
    }
}

/// The sides of a slope triangle.
fn triangle(slope: &Slope, x: &Axis, y: &Axis) -> Plot {
    let [a, b, c] = slope.corners();
    let data = [a, b, c, a].map(|p| (x.scaled(p.0), y.scaled(p.1)));
    LinePlot::new().with_data(data).with_color(NEUTRAL).with_stroke_width(1.2).into()
}

/// The order of a slope, beside the middle of the upright side of its triangle.
fn number(slope: &Slope, x: &Axis, y: &Axis) -> TextAnnotation {
    // Fractions of the axes that move the text, whose foot is written six pixels up, aside and down to its place.
    let (aside, down) = (x.fraction(0.02), y.fraction(0.04));
    let (at, _) = slope.corner();
    let middle = (slope.y * slope.end()).sqrt();
    let text = trimmed(&format!("{:.1}", slope.order));
    let place = if slope.above { at / aside } else { at * aside };
    TextAnnotation::new(text, x.scaled(place), y.scaled(middle / down)).with_color("currentColor").with_font_size(12)
}

fn theme() -> Theme {
    Theme {
        background: "none".into(),
        axis_color: "#888888".into(),
        grid_color: "rgba(128,128,128,0.3)".into(),
        tick_color: "#888888".into(),
        text_color: "currentColor".into(),
        legend_bg: "none".into(),
        legend_border: "none".into(),
        ..Theme::light()
    }
}

/// At most [`MOST_POINTS`] of the points of a line: from every bin the lowest and the highest, so that no peak is lost.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    if points.len() <= MOST_POINTS {
        return points.to_vec();
    }
    let bin = points.len().div_ceil(MOST_POINTS / 2 - 1);
    let mut keep = vec![0, points.len() - 1];
    for start in (0..points.len()).step_by(bin) {
        let of_bin = || start..(start + bin).min(points.len());
        keep.extend(of_bin().min_by(|&a, &b| points[a].1.total_cmp(&points[b].1)));
        keep.extend(of_bin().max_by(|&a, &b| points[a].1.total_cmp(&points[b].1)));
    }
    keep.sort_unstable();
    keep.dedup();
    keep.into_iter().map(|i| points[i]).collect()
}

/// The range of an axis and how its numbers are written.
struct Axis {
    low: f64,
    high: f64,
    log: bool,
    /// On a logarithmic axis, the power of ten that values are multiplied by: `kuva` draws no ticks below 1e-10.
    shift: i32,
}

impl Axis {
    /// The axis for the values, widened by `margin` of its length at both ends; none without values.
    fn of(values: impl Iterator<Item = f64>, log: bool, margin: f64) -> Option<Axis> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            return None;
        }
        if log {
            let room = 10f64.powf(margin.max(0.02) * (high / low).log10().max(2.0));
            let shift = -low.log10().floor() as i32;
            let (low, high) = with_two_ticks((low / room).max(f64::MIN_POSITIVE), (high * room).min(f64::MAX));
            return Some(Axis { low, high, log, shift });
        }
        // Rounding must not be drawn as a curve.
        let flat = high - low <= 1e-12 * low.abs().max(high.abs());
        let room = if flat { 0.05 * low.abs().max(f64::MIN_POSITIVE * 1e9) } else { margin * (high - low) };
        let room = if low == 0.0 && high == 0.0 { 1.0 } else { room };
        Some(Axis { low: low - room, high: high + room, log, shift: 0 })
    }
    /// The factor that leads over a part of a logarithmic axis.
    fn fraction(&self, part: f64) -> f64 {
        (self.high / self.low).powf(part)
    }
    /// The value as it is handed to `kuva`.
    fn scaled(&self, v: f64) -> f64 {
        if self.shift == 0 { v } else { v * 10f64.powi(self.shift) }
    }
    /// The pixels that `kuva` leaves for the numbers of a logarithmic vertical axis, and those that our numbers take.
    fn room(&self) -> [f64; 2] {
        let ticks = generate_ticks_log(self.scaled(self.low), self.scaled(self.high));
        let width = |text: String| 0.64 * f64::from(TICK_SIZE) * text.chars().count() as f64;
        let widest = |text: &dyn Fn(f64) -> String| ticks.iter().map(|&v| width(text(v))).fold(0.0, f64::max);
        [widest(&format_log_tick).max(2.0 * f64::from(TICK_SIZE)), widest(&|v| power_text(v, self.shift))]
    }
    fn format(&self) -> TickFormat {
        let (low, high, log, shift) = (self.low, self.high, self.log, self.shift);
        TickFormat::Custom(Arc::new(move |v| {
            if log { power_text(v, shift) } else { tick_text(v, (high - low) / 5.0, low.abs().max(high.abs())) }
        }))
    }
}

/// The range of a logarithmic axis, widened until it has two of its ticks, which are 1, 2 and 5 times the powers of ten.
fn with_two_ticks(mut low: f64, mut high: f64) -> (f64, f64) {
    let decade = |v: f64| 10f64.powf(v.log10().floor());
    let above = |v: f64| [1.0, 2.0, 5.0, 10.0, 20.0].map(|m| m * decade(v)).into_iter().find(|t| *t > v * (1.0 + 1e-9));
    let below = |v: f64| [5.0, 2.0, 1.0, 0.5].map(|m| m * decade(v)).into_iter().find(|t| *t < v * (1.0 - 1e-9));
    for _ in 0..2 {
        let second = above(low * (1.0 - 1e-6)).and_then(above);
        match (second, below(low), above(high)) {
            (Some(tick), Some(down), Some(up)) if tick > high && high > low && up.is_finite() && down > 0.0 => {
                if low / down < up / high { low = down / 1.02 } else { high = up * 1.02 }
            }
            _ => break,
        }
    }
    (low, high)
}

/// A number on a logarithmic axis, `v * 10^-shift`.
fn power_text(v: f64, shift: i32) -> String {
    let exponent = (v.log10() + 1e-9).floor() as i32;
    let mantissa = (v / 10f64.powi(exponent)).round() as i64;
    let exponent = exponent - shift;
    if (-3..=4).contains(&exponent) {
        return trimmed(&format!(
            "{:.*}",
            exponent.min(0).unsigned_abs() as usize,
            mantissa as f64 * 10f64.powi(exponent)
        ));
    }
    let raised: String = exponent.to_string().chars().map(superscript).collect();
    // Short, since `kuva` leaves no room for more.
    if mantissa == 1 { format!("10{raised}") } else { format!("{mantissa}e{exponent}") }
}

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        d => d.to_digit(10).and_then(|d| char::from_u32('⁰' as u32 + d)).unwrap_or(d),
    }
}

#[cfg(test)]
mod tests {
    use super::super::markup::tests::assert_well_formed;
    use super::*;

    fn curve<'a>(name: &'a str, x: &'a [f64], y: &'a [f64], stroke: Stroke) -> Curve<'a> {
        Curve { name, x, y, stroke, colour: None }
    }

    #[test]
    fn a_chart_is_well_formed_and_names_everything() {
        let x: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.02).collect();
        let y: Vec<f64> = x.iter().map(|x| (7.0 * x).sin()).collect();
        let svg = Chart {
            title: "Axes <a> & \"b\"",
            x_label: "time (s)",
            y_label: "length (m)",
            curves: vec![
                curve("axis_1 < axis_2", &x, &y, Stroke::Line),
                curve("FreeFEM", &x[..9], &y[..9], Stroke::Points),
            ],
            ..Chart::default()
        }
        .svg();
        assert_well_formed(&svg);
        for text in ["time (s)", "length (m)", "axis_1 &lt; axis_2", "FreeFEM", "Axes &lt;a&gt; &amp;", "viewBox"] {
            assert!(svg.contains(text), "{text} is missing");
        }
        assert_eq!(svg.matches("<circle").count(), 9 + 1, "a mark a point and one in the legend");
    }

    #[test]
    fn the_same_chart_has_the_same_bytes_and_another_one_other_names() {
        let chart =
            |y: &[f64]| Chart { curves: vec![curve("a", &[1.0, 2.0], y, Stroke::Line)], ..Chart::default() }.svg();
        let first = chart(&[1.0, 2.0]);
        assert_eq!(first, chart(&[1.0, 2.0]));
        let name = |svg: &str| svg.split("url(#").nth(1).unwrap().split(')').next().unwrap().to_string();
        assert!(first.contains(&format!("id=\"{}\"", name(&first))));
        assert_ne!(name(&first), name(&chart(&[2.0, 1.0])));
    }

    #[test]
    fn values_that_cannot_be_drawn_leave_gaps() {
        let x = [1.0, 2.0, 3.0, 4.0, 5.0];
        let y = [1.0, f64::NAN, -2.0, 0.5, 0.25];
        let chart = |log_y| Chart { log_y, curves: vec![curve("a", &x, &y, Stroke::Line)], ..Chart::default() };
        assert_eq!(
            chart(false).pieces(&chart(false).curves[0]),
            [vec![(1.0, 1.0)], vec![(3.0, -2.0), (4.0, 0.5), (5.0, 0.25)]]
        );
        assert_eq!(chart(true).pieces(&chart(true).curves[0]), [vec![(1.0, 1.0)], vec![(4.0, 0.5), (5.0, 0.25)]]);
        for y in [&[][..], &[f64::INFINITY; 5], &[0.0; 5], &[1e300; 5], &[5e-324; 5], &y] {
            for log_y in [false, true] {
                assert_well_formed(
                    &Chart { log_y, curves: vec![curve("a", &x, y, Stroke::Line)], ..Chart::default() }.svg(),
                );
            }
        }
    }

    #[test]
    fn thinning_keeps_ends_and_peaks() {
        let mut points: Vec<_> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[54_321].1 = 1.0;
        let thin = thinned(&points);
        assert!(thin.len() <= MOST_POINTS + 2);
        assert!(thin.contains(&points[0]) && thin.contains(&points[99_999]) && thin.contains(&points[54_321]));
    }

    #[test]
    fn numbers_on_logarithmic_axes_are_powers() {
        assert_eq!(power_text(1.0, 14), "10⁻¹⁴");
        assert_eq!(power_text(5e3, 14), "5e-11");
        assert_eq!(power_text(0.05, 0), "0.05");
    }

    #[test]
    fn slopes_are_triangles_with_their_order_beside_them() {
        let (x, y) = ([0.1, 0.2, 0.4], [1e-3, 4e-3, 1.6e-2]);
        let slope = Slope { x: [0.1, 0.2], y: 5e-4, order: 2.0, above: false };
        let curves = vec![curve("e", &x, &y, Stroke::Marked)];
        let chart = Chart { log_x: true, log_y: true, curves: curves.clone(), slopes: vec![slope], ..Chart::default() };
        let svg = chart.svg();
        assert_well_formed(&svg);
        assert!(svg.contains(">2</text>") && svg.contains(NEUTRAL), "{svg}");
        assert_eq!(slope.corners(), [(0.1, 5e-4), (0.2, 2e-3), (0.2, 5e-4)]);
        let plain = Chart { log_x: true, log_y: true, curves, ..Chart::default() }.svg();
        assert!(plain.len() < svg.len());
        for bad in [Slope { y: 0.0, ..slope }, Slope { x: [0.0, 1.0], ..slope }, Slope { order: f64::NAN, ..slope }] {
            assert_well_formed(&Chart { slopes: vec![bad], ..chart.clone() }.svg());
        }
    }

    #[test]
    fn a_logarithmic_axis_has_ticks_at_rounding_level() {
        let x = [0.1, 0.2, 0.4];
        let y = [1e-15, 8e-15, 6.4e-14];
        let svg =
            Chart { log_x: true, log_y: true, curves: vec![curve("e", &x, &y, Stroke::Points)], ..Chart::default() }
                .svg();
        assert!(svg.contains("10⁻¹⁵") && svg.contains("10⁻¹⁴"), "{svg}");
    }
}
