//! Elements of an SVG drawing. Coordinates are pixels from the upper left corner, written with two
//! decimals.

use super::super::markup::escape;
use super::super::numbers::trimmed;
use super::text::{Label, RAISED, TYPEFACES};
use std::fmt::Write;

/// Appearance of a line.
#[derive(Clone, Copy, Debug)]
pub struct Pen<'a> {
    /// Colour.
    pub colour: &'a str,
    /// Width in pixels.
    pub width: f64,
    /// Lengths of dashes and gaps in pixels; a full line if empty.
    pub dash: &'a str,
    /// Opacity between 0 and 1.
    pub opacity: f64,
}

/// Position of a text relative to its anchor point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the point.
    Start,
    /// The text is centred about the point.
    Middle,
    /// The text ends at the point.
    End,
}

/// Form of a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A disc.
    Disc,
    /// A closed polygon about the origin, of about the area of the unit disc.
    Polygon(&'static [[f64; 2]]),
}

/// The forms of marks: disc, square, triangle, diamond, triangle upside down, plus, cross,
/// hourglass.
pub const SHAPES: [Shape; 8] = [
    Shape::Disc,
    Shape::Polygon(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
    Shape::Polygon(&[[0.0, -1.3], [1.2, 0.85], [-1.2, 0.85]]),
    Shape::Polygon(&[[0.0, -1.35], [1.15, 0.0], [0.0, 1.35], [-1.15, 0.0]]),
    Shape::Polygon(&[[0.0, 1.3], [1.2, -0.85], [-1.2, -0.85]]),
    Shape::Polygon(&[
        [-0.4, -1.25],
        [0.4, -1.25],
        [0.4, -0.4],
        [1.25, -0.4],
        [1.25, 0.4],
        [0.4, 0.4],
        [0.4, 1.25],
        [-0.4, 1.25],
        [-0.4, 0.4],
        [-1.25, 0.4],
        [-1.25, -0.4],
        [-0.4, -0.4],
    ]),
    Shape::Polygon(&[
        [0.0, -0.57],
        [0.6, -1.17],
        [1.17, -0.6],
        [0.57, 0.0],
        [1.17, 0.6],
        [0.6, 1.17],
        [0.0, 0.57],
        [-0.6, 1.17],
        [-1.17, 0.6],
        [-0.57, 0.0],
        [-1.17, -0.6],
        [-0.6, -1.17],
    ]),
    Shape::Polygon(&[[-1.2, -1.2], [1.2, -1.2], [-1.2, 1.2], [1.2, 1.2]]),
];

/// An SVG drawing in the making.
#[derive(Debug, Default)]
pub struct Canvas {
    body: String,
}

impl Canvas {
    /// What `draw` draws, as a group that scripts find by its class.
    pub fn group(&mut self, class: &str, draw: impl FnOnce(&mut Canvas)) {
        self.element(&format!("<g class=\"{class}\">"));
        draw(self);
        self.element("</g>");
    }
    /// A polyline; a single point becomes a dot.
    pub fn line(&mut self, points: &[[f64; 2]], pen: Pen<'_>) {
        let mut d = path(points);
        if let [point] = points {
            d += &format!("L{}", pair(*point));
        }
        let mut style = format!("stroke=\"{}\" stroke-width=\"{}\"", pen.colour, px(pen.width));
        if !pen.dash.is_empty() {
            style += &format!(" stroke-dasharray=\"{}\"", pen.dash);
        }
        if pen.opacity < 1.0 {
            style += &format!(" stroke-opacity=\"{}\"", px(pen.opacity));
        }
        let round = if points.len() == 2 { "" } else { " stroke-linejoin=\"round\"" };
        let round = if points.len() == 1 { " stroke-linecap=\"round\"" } else { round };
        self.element(&format!("<path d=\"{d}\" fill=\"none\" {style}{round}/>"));
    }
    /// A mark of the given form and radius.
    pub fn mark(&mut self, shape: Shape, at: [f64; 2], radius: f64, colour: &str) {
        let element = match shape {
            Shape::Disc => {
                let [x, y] = at.map(px);
                format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{}\" fill=\"{colour}\"/>", px(radius))
            }
            Shape::Polygon(corners) => {
                let corner = |c: &[f64; 2]| [at[0] + radius * c[0], at[1] + radius * c[1]];
                let corners: Vec<[f64; 2]> = corners.iter().map(corner).collect();
                format!("<path d=\"{}Z\" fill=\"{colour}\"/>", path(&corners))
            }
        };
        self.element(&element);
    }
    /// A text whose baseline passes through the point.
    pub fn text(&mut self, text: &str, at: [f64; 2], anchor: Anchor, size: f64) {
        self.write(&escape(text), at, anchor, size, "");
    }
    /// A text that runs upwards, its baseline through the point.
    pub fn upright(&mut self, text: &str, at: [f64; 2], anchor: Anchor, size: f64) {
        let turned = format!(" transform=\"rotate(-90 {})\"", pair(at));
        self.write(&escape(text), at, anchor, size, &turned);
    }
    /// A number of an axis.
    pub fn label(&mut self, label: &Label, at: [f64; 2], anchor: Anchor, size: f64) {
        let mut text = escape(&label.text);
        if let Some(exponent) = &label.exponent {
            let (up, small) = (px(-0.4 * size), px(RAISED * size));
            let exponent = escape(exponent);
            text += &format!("<tspan dy=\"{up}\" font-size=\"{small}\">{exponent}</tspan>");
        }
        self.write(&text, at, anchor, size, "");
    }
    fn write(&mut self, content: &str, at: [f64; 2], anchor: Anchor, size: f64, turned: &str) {
        let ([x, y], size) = (at.map(px), px(size));
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let place = format!("x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{anchor}{turned}");
        self.element(&format!("<text {place}>{content}</text>"));
    }
    fn element(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }
    /// The document, which scales to the width of its page; `name` is for readers who cannot see
    /// it, `data` for scripts.
    pub fn document(self, [width, height]: [f64; 2], name: &str, data: &str) -> String {
        let data = match data {
            "" => String::new(),
            data => format!(" data-chart=\"{}\"", escape(data)),
        };
        format!(
            "{OF_CHART} viewBox=\"0 0 {} {}\" role=\"img\" \
             aria-label=\"{}\" font-family=\"{TYPEFACES}\" fill=\"currentColor\"{data}>\n{}</svg>\n",
            px(width),
            px(height),
            escape(name),
            self.body
        )
    }
}

/// The beginning of every chart, by which it is known.
pub const OF_CHART: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"immersa-chart\"";

/// The commands of a polyline.
fn path(points: &[[f64; 2]]) -> String {
    let mut d = String::with_capacity(14 * points.len());
    for (k, point) in points.iter().enumerate() {
        // Writing into a string cannot fail.
        let _ = write!(d, "{}{}", if k == 0 { 'M' } else { 'L' }, pair(*point));
    }
    d
}

fn pair(point: [f64; 2]) -> String {
    let [x, y] = point.map(px);
    format!("{x} {y}")
}

/// A length in pixels.
fn px(v: f64) -> String {
    trimmed(&format!("{v:.2}"))
}
