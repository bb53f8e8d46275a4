//! Charts of columns of a series, each with a caption.

use super::words::{Words, words};
use crate::output::{Chart, Curve, Figure, Series, Stroke};

/// A chart under construction, as a list of curves.
pub struct Sheet<'a> {
    pub x_label: &'static str,
    pub x: &'a [f64],
    pub curves: Vec<(String, Vec<f64>, Stroke)>,
}

impl<'a> Sheet<'a> {
    /// Adds a curve, if there is one.
    pub fn add(&mut self, name: impl Into<String>, y: Option<Vec<f64>>, stroke: Stroke) {
        self.curves.extend(y.map(|y| (name.into(), y, stroke)));
    }
    /// Adds a full line.
    pub fn line(&mut self, name: impl Into<String>, y: Option<&[f64]>) {
        self.add(name, y.map(<[f64]>::to_vec), Stroke::Line);
    }
    /// Adds a dashed line.
    pub fn dashed(&mut self, name: impl Into<String>, y: Option<Vec<f64>>) {
        self.add(name, y, Stroke::Dashed);
    }
    /// The chart, if it has any data.
    pub fn draw(
        self,
        name: impl Into<String>,
        [title, y_label]: [&str; 2],
        caption: impl Into<String>,
    ) -> Option<Figure> {
        if self.curves.is_empty() {
            return None;
        }
        let curves = self.curves.iter().map(|(name, y, stroke)| Curve {
            name,
            x: self.x,
            y,
            stroke: *stroke,
            colour: None,
        });
        let chart = Chart {
            title,
            x_label: self.x_label,
            y_label,
            curves: curves.collect(),
            ..Chart::default()
        };
        Some(Figure::chart(name, title, chart.svg(), caption))
    }
}

/// Columns of a series over time.
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    /// The series.
    pub series: &'a Series,
    /// Dimensions of space.
    pub dimension: usize,
}

impl<'a> Columns<'a> {
    /// An empty chart over time.
    pub fn sheet(&self) -> Sheet<'a> {
        Sheet { x_label: "time", x: self.column("time").unwrap_or_default(), curves: Vec::new() }
    }
    /// Vocabulary for the dimension.
    pub fn words(&self) -> &'static Words {
        words(self.dimension)
    }
    /// A column of the series; `None` if it does not exist or has no rows.
    pub fn column(&self, name: &str) -> Option<&'a [f64]> {
        self.series.column(name).ok().filter(|c| !c.is_empty())
    }
    /// A column of a structure.
    pub fn column_of(&self, structure: &str, quantity: &str) -> Option<&'a [f64]> {
        self.column(&format!("{structure}.{quantity}"))
    }
    /// Radius of the circle of the enclosed area (in space: of the sphere of the volume).
    pub fn round_radius(&self, name: &str) -> Option<Vec<f64>> {
        let words = self.words();
        let enclosed = self.column_of(name, words.enclosed)?;
        Some(enclosed.iter().map(|v| (words.radius)(*v)).collect())
    }

    /// Semi-axes of a structure, which is round when at rest or not.
    pub fn axes(&self, name: &str, round_at_rest: bool) -> Option<Figure> {
        let (words, mut sheet) = (self.words(), self.sheet());
        words
            .axes
            .iter()
            .for_each(|(column, what)| sheet.line(*what, self.column_of(name, column)));
        if !sheet.curves.is_empty() {
            sheet.dashed(words.round, self.round_radius(name));
        }
        let title = format!("Semi-axes of {name}");
        let end = match (round_at_rest, words.axes.len()) {
            (false, _) => "",
            (true, 2) => {
                ", the shape at rest in a fluid at rest; both axes end there when nothing drives \
                 the flow"
            }
            (true, _) => {
                ", the shape at rest in a fluid at rest; all axes end there when nothing drives \
                 the flow"
            }
        };
        sheet.draw(
            format!("axes-{name}"),
            [&title, "length"],
            format!(
                "Semi-axes of the {} that has the second moments of the inside. Dashed: the \
                 radius of the {} of the same {}{end}. A zigzag from row to row would mean that \
                 the time step is too large for the stiffness of the membrane.",
                words.oval, words.round, words.enclosed,
            ),
        )
    }

    /// Half-chords of a structure, or else its extents.
    pub fn chords<'b>(&self, name: &str, chords: impl Iterator<Item = &'b str>) -> Option<Figure> {
        let (words, mut sheet) = (self.words(), self.sheet());
        chords.for_each(|c| sheet.line(c, self.column_of(name, c)));
        let title = format!("Half-chords of {name}");
        if !sheet.curves.is_empty() {
            let caption = format!(
                "Half the distance of the two points where a line of the scene crosses the {cut}: \
                 on a centred {oval} along the axes, its semi-axis. Where a chord parts from the \
                 semi-axis the shape is no {oval}. A gap means that the line misses the {cut}.",
                cut = words.cut,
                oval = words.oval
            );
            return sheet.draw(format!("chords-{name}"), [&title, "length"], caption);
        }
        words
            .extents
            .iter()
            .for_each(|(column, what)| sheet.line(*what, self.column_of(name, column)));
        let title = format!("Extents of {name}");
        let caption = format!(
            "{} of the {}. On an {oval} along the axes they are its semi-axes; where they part \
             from them the shape is turned, or no {oval}.",
            words.widths,
            words.cut,
            oval = words.oval
        );
        sheet.draw(format!("extents-{name}"), [&title, "length"], caption)
    }
}
