//! Stability of values of a scene at its own time step.

use super::verdict::Verdict;
use super::{cells, check, columns, heading, per_cent, refusals, trial};
use crate::base::Result;
use crate::output::{Cell, Chart, Curve, Figure, Page, Stroke, Table, rounded};
use crate::scene::problem;
use crate::studies::axis::{Axis, Choice, assignments, combinations, in_words};
use crate::studies::{Campaign, Trial};

/// A scan of values that are not the step.
#[derive(Clone, Debug)]
pub struct Scan {
    /// The parameters that differ; the first axis is that of the charts.
    pub axes: Vec<Axis>,
    /// Steps of a run; those of the scene without it.
    pub steps: Option<usize>,
    /// Growth of the energy beyond the balance above which a run is unstable,
    /// [`TOLERANCE`](super::TOLERANCE) or another.
    pub tolerance: f64,
}

/// Outcome of a combination.
struct ScanPoint {
    combination: Vec<Choice>,
    /// Half-width of the band over the longest edge in it; NaN where the scene cannot be run.
    resolution: f64,
    verdict: Verdict,
}

impl ScanPoint {
    /// The value on the first axis.
    fn first(&self) -> Option<&Choice> {
        self.combination.first()
    }
    /// True if the values on all axes but the first are these.
    fn is_of(&self, rest: &[Choice]) -> bool {
        self.combination.iter().skip(1).eq(rest)
    }
    /// True if the values on the axes after the second are these.
    fn is_in(&self, panel: &[Choice]) -> bool {
        self.combination.iter().skip(2).eq(panel)
    }
    fn is_at(&self, first: &Choice, rest: &[Choice]) -> bool {
        self.first() == Some(first) && self.is_of(rest)
    }
}

/// Largest value of a chart, in per cent.
const CEILING: f64 = 1e3;
/// The colour of charts that no curve takes.
const GREY: usize = 6;

impl Scan {
    /// Runs all combinations; the result is a page of their outcomes.
    ///
    /// # Errors
    /// Values that the scene does not take; as for [`Campaign::run`]. A run that fails or is
    /// refused is a result.
    pub fn conduct(&self, campaign: &mut Campaign<'_>) -> Result<Page> {
        check(campaign, &self.axes, &[])?;
        let all = combinations(&self.axes);
        let mut points = Vec::new();
        for (k, combination) in all.iter().enumerate() {
            let scene = campaign.scene_of(&Trial::new("", assignments(combination)))?;
            let run = trial(combination, scene.time.step, self.steps.unwrap_or(scene.time.steps()));
            let outcome = campaign.run(&run, k + 1, all.len())?;
            let verdict = Verdict::of(&outcome, self.tolerance)?;
            // A mesh that cannot be read ended the study above.
            let limits = problem(&scene).map(|p| p.limits()).ok();
            let resolution = limits.and_then(|l| Some(l.thickness? / l.band_edges?[1]));
            let resolution = resolution.unwrap_or(f64::NAN);
            points.push(ScanPoint { combination: combination.clone(), resolution, verdict });
        }
        let mut tables = vec![self.table(&points)];
        tables.extend(self.map(&points));
        Ok(Page {
            title: format!("Stability: {}", campaign.scene().title),
            subtitle: format!("{} combinations of values at the time step of the scene", all.len()),
            statements: self.statements(&points),
            notes: self.notes(&points),
            tables,
            charts: self.charts(&points),
            ..Page::default()
        })
    }

    fn table(&self, points: &[ScanPoint]) -> Table {
        let header = ["band/edge", "growth", "from_nowhere", "area", "outcome"];
        let mut table = Table::new("scan", "Outcomes", columns(&self.axes, &header));
        for p in points {
            let v = &p.verdict;
            let numbers = [v.growth, v.residual, v.area].map(|v| Cell::number(v, 3));
            let [resolution, outcome] = [Cell::number(p.resolution, 3), Cell::text(v.in_words())];
            table.rows.push(
                [cells(&p.combination), vec![resolution], numbers.to_vec(), vec![outcome]].concat(),
            );
        }
        table.caption = "Growth: of kinetic and elastic energy beyond what was there and was put \
            in, over that. From_nowhere: the residual of the energy balance (3.23). Area: \
            relative change of an enclosed area. Of each the largest in the run."
            .into();
        table
    }

    /// The outcomes with the values of the first axis side by side.
    fn map(&self, points: &[ScanPoint]) -> Option<Table> {
        let [first, others @ ..] = &self.axes[..] else { return None };
        let rows = combinations(others);
        if rows.len() < 2 {
            return None;
        }
        let header = others
            .iter()
            .map(|a| a.name.clone())
            .chain(first.choices.iter().map(|c| c.label.clone()));
        let mut table = Table::new(
            "map",
            "Residual of the energy balance, or start of the instability",
            header,
        );
        for rest in rows {
            let outcome = |choice: &Choice| {
                let found = points.iter().find(|p| p.is_at(choice, &rest)).map(|p| &p.verdict);
                Cell::text(found.map_or_else(String::new, |v| match v.is_stable() {
                    true => per_cent(v.residual),
                    false => v.in_words(),
                }))
            };
            table
                .rows
                .push(cells(&rest).into_iter().chain(first.choices.iter().map(outcome)).collect());
        }
        Some(table)
    }

    fn statements(&self, points: &[ScanPoint]) -> Vec<String> {
        let Some(first) = self.axes.first() else { return Vec::new() };
        let sentence = |rest: Vec<Choice>| {
            let of = points.iter().filter(|p| p.is_of(&rest));
            let (mut stable, mut unstable, mut refused) = (Vec::new(), Vec::new(), Vec::new());
            for p in of {
                let value = p.first().map_or("", |c| c.value.as_str());
                match (&p.verdict.refused, p.verdict.unstable_from) {
                    (Some(_), _) => refused.push(value.to_string()),
                    (None, Some(t)) => {
                        unstable.push(format!("{value} (from t = {})", rounded(t, 3)))
                    }
                    (None, None) => stable.push(value.to_string()),
                }
            }
            let parts = [("unstable", unstable), ("stable", stable), ("refused", refused)];
            let part = |(word, values): &(&str, Vec<String>)| {
                format!("{word} at {} = {}", first.name, values.join(", "))
            };
            let text =
                parts.iter().filter(|p| !p.1.is_empty()).map(part).collect::<Vec<_>>().join("; ");
            match rest.is_empty() {
                true => format!("At the step of the scene {text}."),
                false => format!("{}{text}.", heading(&rest)),
            }
        };
        combinations(self.axes.get(1..).unwrap_or_default()).into_iter().map(sentence).collect()
    }

    fn notes(&self, points: &[ScanPoint]) -> Vec<String> {
        let mut notes = vec![format!(
            "A run is unstable when it fails, or when kinetic and elastic energy exceed the \
             energy at the start and the work put in by more than {}.",
            per_cent(self.tolerance)
        )];
        notes.extend(refusals(
            points.iter().filter_map(|p| Some((&p.combination[..], p.verdict.refused.as_deref()?))),
        ));
        notes
    }

    /// Residual of the energy balance and change of the area over the first axis, if it has two
    /// numbers or more, a curve for each value of the second and charts of their own for those of
    /// the others.
    fn charts(&self, points: &[ScanPoint]) -> Vec<Figure> {
        let [first, others @ ..] = &self.axes[..] else { return Vec::new() };
        if first.choices.iter().filter(|c| c.number().is_some()).count() < 2 {
            return Vec::new();
        }
        let second = combinations(others.get(..1).unwrap_or_default());
        let panels = combinations(others.get(1..).unwrap_or_default());
        let values: [(&str, &str, Value); 2] = [
            ("energy", "Residual of the energy balance", |v| v.residual),
            ("area", "Change of the enclosed area", |v| v.area),
        ];
        let mut charts = Vec::new();
        for (name, what, value) in &values {
            for panel in &panels {
                let of = |c: &Vec<Choice>| (in_words(c), [&c[..], panel].concat());
                let curves = second.iter().map(of);
                let curves = curves.map(|(words, rest)| {
                    curve(words, points.iter().filter(|p| p.is_of(&rest)), value)
                });
                let within =
                    points.iter().filter(|p| p.is_in(panel) && p.verdict.unstable_from.is_some());
                let lines: Vec<Line> =
                    curves.chain([curve("unstable".into(), within, value)]).collect();
                let title = [format!("{what} over {}", first.name), in_words(panel)];
                let file = std::iter::once(format!("{name}-over-{}", first.name))
                    .chain(panel.iter().map(|c| c.label.clone()));
                charts.extend(chart(first, file.collect::<Vec<_>>().join("-"), title, &lines));
            }
        }
        charts
    }
}

/// Value of a run that a chart shows.
type Value = fn(&Verdict) -> f64;
/// A name and the abscissas and ordinates of a curve.
type Line = (String, Vec<f64>, Vec<f64>);

/// A curve over the first axis, in per cent up to [`CEILING`].
fn curve<'a>(
    name: String,
    points: impl Iterator<Item = &'a ScanPoint>,
    value: &dyn Fn(&Verdict) -> f64,
) -> Line {
    let shown = |v: f64| if v > CEILING { CEILING } else { v };
    let at = |p: &ScanPoint| {
        [
            p.first().and_then(Choice::number).unwrap_or(f64::NAN),
            shown((100.0 * value(&p.verdict)).abs()),
        ]
    };
    let mut row: Vec<[f64; 2]> = points.map(at).collect();
    row.sort_by(|a, b| a[0].total_cmp(&b[0]));
    (name, row.iter().map(|p| p[0]).collect(), row.iter().map(|p| p[1]).collect())
}

/// The chart of some curves and, as the last one, the points that are unstable; none without a
/// value.
fn chart(axis: &Axis, file: String, title: [String; 2], lines: &[Line]) -> Option<Figure> {
    if lines.iter().all(|(_, _, y)| y.iter().all(|v| v.is_nan())) {
        return None;
    }
    let curves =
        lines.iter().enumerate().filter(|(_, line)| !line.1.is_empty()).map(|(i, (name, x, y))| {
            let unstable = i + 1 == lines.len();
            let name = if name.is_empty() { "measured" } else { name };
            let stroke = if unstable { Stroke::Points } else { Stroke::Marked };
            Curve { name, x, y, stroke, colour: Some(if unstable { GREY } else { i % GREY }) }
        });
    let numbers = || axis.choices.iter().filter_map(Choice::number);
    let (low, high) = (numbers().fold(f64::INFINITY, f64::min), numbers().fold(0.0, f64::max));
    let title = title.iter().filter(|t| !t.is_empty()).cloned().collect::<Vec<_>>().join(", ");
    let svg = Chart {
        title: &title,
        x_label: &axis.name,
        y_label: "the largest in a run, %",
        log_x: low > 0.0 && high > 4.0 * low,
        log_y: true,
        curves: curves.collect(),
        ..Chart::default()
    }
    .svg();
    let letter =
        |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { Some(c) } else { None };
    let name: String =
        file.replace(" = ", "-").replace(' ', "-").chars().filter_map(letter).collect();
    let caption =
        format!("Magnitudes. Grey: unstable runs; what is above {CEILING} % is drawn there.");
    Some(Figure::chart(name, title, svg, caption))
}
