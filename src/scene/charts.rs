//! Charts of columns of a series, each with a caption.

use super::schema::Units;
use super::words::{Words, words};
use crate::output::{Chart, Curve, Figure, Series, Stroke};

/// A chart with its data and its words.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Name of its file, without ending.
    pub name: String,
    /// Title.
    pub title: String,
    /// Labels of the axes, with their units.
    pub labels: [String; 2],
    /// The curves.
    pub curves: Vec<PlotCurve>,
    /// Explanation.
    pub caption: String,
    /// True if a beginning that dwarfs the rest is cut off.
    pub cut_start: bool,
}

/// A curve of a plot.
#[derive(Clone, Debug)]
pub struct PlotCurve {
    /// Name in the legend.
    pub name: String,
    /// Abscissas.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// Line, dashes or marks.
    pub stroke: Stroke,
    /// Number of its colour; its place among the curves without it.
    pub colour: Option<usize>,
}

impl Plot {
    /// The chart, drawn.
    pub fn figure(&self) -> Figure {
        let curves = self.curves.iter().map(|c| Curve {
            name: &c.name,
            x: &c.x,
            y: &c.y,
            stroke: c.stroke,
            colour: c.colour,
        });
        let curves = curves.collect();
        let [x_label, y_label] = self.labels.each_ref().map(String::as_str);
        let (title, cut_start) = (self.title.as_str(), self.cut_start);
        let chart = Chart { title, x_label, y_label, curves, cut_start, ..Chart::default() };
        Figure::chart(&self.name, title, chart.svg(), &self.caption)
    }
}

/// A chart under construction, as a list of curves.
pub struct Sheet<'a> {
    pub x: &'a [f64],
    pub curves: Vec<(String, Vec<f64>, Stroke)>,
    /// True if a beginning that dwarfs the rest is cut off.
    pub cut_start: bool,
    x_label: &'static str,
    units: &'a Units,
    dimension: usize,
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
    /// The chart, if it has any data. Labels that name a quantity get its unit.
    pub fn draw(
        self,
        name: impl Into<String>,
        [title, y_label]: [&str; 2],
        caption: impl Into<String>,
    ) -> Option<Plot> {
        if self.curves.is_empty() {
            return None;
        }
        let x = self.x.to_vec();
        let curve = |(name, y, stroke)| PlotCurve { name, x: x.clone(), y, stroke, colour: None };
        Some(Plot {
            name: name.into(),
            title: title.into(),
            labels: [self.x_label, y_label].map(|label| self.units.label(label, self.dimension)),
            curves: self.curves.into_iter().map(curve).collect(),
            caption: caption.into(),
            cut_start: self.cut_start,
        })
    }
}

/// Columns of a series over time.
#[derive(Clone, Copy)]
pub struct Columns<'a> {
    /// The series.
    pub series: &'a Series,
    /// Dimensions of space.
    pub dimension: usize,
    /// Units of the scene.
    pub units: &'a Units,
}

impl<'a> Columns<'a> {
    /// An empty chart over time.
    pub fn sheet(&self) -> Sheet<'a> {
        self.sheet_over("time", self.column("time").unwrap_or_default())
    }
    /// An empty chart over another quantity.
    pub fn sheet_over(&self, x_label: &'static str, x: &'a [f64]) -> Sheet<'a> {
        let Columns { dimension, units, .. } = *self;
        Sheet { x, curves: Vec::new(), cut_start: false, x_label, units, dimension }
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
    pub fn axes(&self, name: &str, round_at_rest: bool) -> Option<Plot> {
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
    pub fn chords<'b>(&self, name: &str, chords: impl Iterator<Item = &'b str>) -> Option<Plot> {
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
