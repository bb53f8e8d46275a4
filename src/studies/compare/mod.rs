//! `immersa compare`: a scene and its FreeFEM twin on the same mesh, with the same step and the
//! same values.

mod page;

use super::campaign::Campaign;
use super::freefem::{Case, INSTALL, Reading};
use super::trial::{Outcome, Trial};
use super::twin::{Loop, Twin};
use crate::base::{Error, Result};
use crate::output::{Page, Series, rounded, same_time};
use std::path::Path;

/// Steps for which a loop is timed that is not the twin's first: enough for a mean, few enough to
/// wait for.
const TIMED_STEPS: usize = 10;

/// Options of a comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Repetitions of all runs; of the times the least counts.
    pub repeat: usize,
    /// Largest differences that are accepted, relative to the largest value of the quantity; those
    /// with a name before those without.
    pub bounds: Vec<Bound>,
    /// Keep FreeFEM's result in `data/` beside the twin under this name.
    pub record: Option<String>,
}

/// A bound of a difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// The column; all columns without one of their own if there is none.
    pub column: Option<String>,
    /// The bound.
    pub value: f64,
}

impl std::str::FromStr for Bound {
    type Err = String;
    /// `1e-3` or `membrane.horizontal=1e-5`.
    fn from_str(text: &str) -> std::result::Result<Bound, String> {
        let (column, number) = match text.split_once('=') {
            Some((column, number)) => (Some(column.trim().to_string()), number),
            None => (None, text),
        };
        let value = number.trim().parse().ok().filter(|v: &f64| *v > 0.0 && v.is_finite());
        let value = value
            .ok_or("write a positive number, or COLUMN=NUMBER, as in membrane.horizontal=1e-5")?;
        Ok(Bound { column, value })
    }
}

/// Cost of a program.
pub(super) struct Cost {
    pub who: String,
    steps: f64,
    first: f64,
    /// CPU seconds of a step after the first.
    pub per_step: f64,
}

/// Costs of the programs on one mesh.
pub(super) struct Costs {
    /// Unknowns of velocity, pressure and level sets.
    pub unknowns: f64,
    /// True if FreeFEM's times are recorded ones.
    pub recorded: bool,
    /// Ours, then those of FreeFEM's loops.
    pub of: Vec<Cost>,
}

/// A quantity that both programs give.
struct Pair<'a> {
    name: &'a str,
    ours: Vec<f64>,
    theirs: Vec<f64>,
}

impl Pair<'_> {
    fn largest_value(&self) -> f64 {
        self.theirs.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
    }
    /// KeyNumber of the row with the largest difference, and the difference.
    fn worst(&self) -> (usize, f64) {
        let differences =
            self.ours.iter().zip(&self.theirs).map(|(a, b)| (a - b).abs()).enumerate();
        differences.fold((0, 0.0), |m, d| if d.1 > m.1 || d.1.is_nan() { d } else { m })
    }
    fn relative(&self) -> f64 {
        let (_, difference) = self.worst();
        if difference == 0.0 { 0.0 } else { difference / self.largest_value() }
    }
}

/// Compares the scene of the campaign, which has the scheme of the twin, with the twin.
///
/// # Errors
/// A scene or a twin that cannot be run, or whose run failed; no quantity that both give; FreeFEM
/// not installed and nothing recorded that fits.
pub fn compare(campaign: &mut Campaign<'_>, twin: &Twin, options: &Comparison) -> Result<Page> {
    compare_and_cost(campaign, twin, options).map(|(found, _)| found)
}

/// [`compare`], and what the programs cost.
pub(super) fn compare_and_cost(
    campaign: &mut Campaign<'_>,
    twin: &Twin,
    options: &Comparison,
) -> Result<(Page, Costs)> {
    let scene = campaign.scene();
    let case = Case::new(twin, scene)?;
    let (ours, readings) = runs(campaign, &case, twin.loops(), options.repeat.max(1))?;
    let (Some(outcome), Some(reading)) = (ours.first(), readings.first().and_then(|r| r.first()))
    else {
        return Err(Error::internal("a comparison without runs"));
    };
    let (times, pairs) = common(&outcome.series, &reading.table, twin.path())?;
    if let Some(name) = &options.record {
        record(reading, twin, name)?;
    }
    write_both(campaign.folder(), &times, &pairs)?;
    let costs = costs(&ours, &readings, twin.loops());
    let mut found = Page {
        title: format!("{}: immersa and FreeFEM", scene.title),
        subtitle: format!(
            "{}, dt = {:?}, to t = {:?}",
            case.size,
            scene.time.step,
            times.last().copied().unwrap_or(0.0)
        ),
        ..Page::default()
    };
    found.tables = vec![
        page::differences(&times, &pairs),
        page::side_by_side(&times, &pairs),
        page::times_of(&costs, twin.loops(), reading),
    ];
    found.charts = page::charts(&times, &pairs, reading);
    found.statements = page::statements(&pairs, &costs, reading);
    found.alarms = page::alarms(&pairs, &options.bounds);
    found.notes = page::notes(&case, twin, reading, &pairs, outcome);
    found.key_numbers = page::key_numbers(&pairs, &costs, reading);
    let costs = Costs {
        unknowns: outcome.unknowns() as f64,
        recorded: reading.recorded.is_some(),
        of: costs,
    };
    Ok((found, costs))
}

/// All runs, in turn, so that a noisy machine favours nobody: ours, and FreeFEM's by loop.
fn runs(
    campaign: &mut Campaign<'_>,
    case: &Case<'_>,
    loops: &[Loop],
    repeat: usize,
) -> Result<(Vec<Outcome>, Vec<Vec<Reading>>)> {
    let (time, runs, stop) =
        (campaign.scene().time, campaign.folder().join("runs"), campaign.stop());
    let mut ours = Vec::new();
    let mut theirs: Vec<Vec<Reading>> = vec![Vec::new(); loops.len()];
    for repetition in 0..repeat {
        let trial = Trial { label: "immersa".into(), set: vec![], repetition };
        let outcome = campaign.run(&trial, repetition + 1, repeat)?;
        if !outcome.finished() {
            return Err(Error::computation(format!(
                "immersa's own run {}",
                outcome.end.in_words()
            ))
            .value(outcome.end.reason())
            .remedy(
                "take a smaller time.step with --set: explicit coupling has a limit, which \
                 `immersa explain` prints",
            ));
        }
        ours.push(outcome);
        for (k, work) in loops.iter().enumerate() {
            let end = if k == 0 { time.end } else { time.end.min(time.step * TIMED_STEPS as f64) };
            match case.run(work, end, repetition, &runs, stop)? {
                Some(reading) => {
                    let cost = reading
                        .about
                        .per_step
                        .map_or(String::new(), |s| format!(", {} s a step", rounded(s, 3)));
                    campaign.listener().note(&format!("FreeFEM {}{cost}", work.name));
                    theirs[k].push(reading);
                }
                None => {
                    campaign
                        .listener()
                        .note("FreeFEM is not installed: its recorded result is taken");
                    return Ok((ours, vec![vec![case.recorded()?]]));
                }
            }
        }
    }
    Ok((ours, theirs))
}

/// The times that both have, and the quantities that both have, at these times.
fn common<'a>(
    ours: &Series,
    theirs: &'a Series,
    script: &Path,
) -> Result<(Vec<f64>, Vec<Pair<'a>>)> {
    let (mine, other) = (ours.column("time")?, theirs.column("time")?);
    let at = |t: f64| mine.iter().position(|&m| same_time(m, t));
    let rows: Vec<(usize, usize)> =
        other.iter().enumerate().filter_map(|(j, t)| Some((at(*t)?, j))).collect();
    let mut pairs = Vec::new();
    for (name, column) in theirs.names.iter().zip(&theirs.columns).filter(|(n, _)| *n != "time") {
        if let Ok(values) = ours.column(name) {
            let (ours, theirs) = rows.iter().map(|&(i, j)| (values[i], column[j])).unzip();
            pairs.push(Pair { name, ours, theirs });
        }
    }
    if pairs.is_empty() || rows.is_empty() {
        return Err(Error::input("the twin and the scene have no quantity or no time in common")
            .at(script.display().to_string())
            .value(format!(
                "columns of the twin: {}; {} times",
                theirs.names.join(", "),
                other.len()
            ))
            .remedy(format!(
                "name the columns of the twin as in the series: {}",
                ours.names.join(", ")
            )));
    }
    Ok((rows.iter().map(|&(_, j)| other[j]).collect(), pairs))
}

fn record(reading: &Reading, twin: &Twin, name: &str) -> Result<()> {
    if reading.recorded.is_some() {
        return Err(Error::input("there is nothing to record: FreeFEM is not installed")
            .value(name)
            .remedy(INSTALL));
    }
    let folder = twin.path().with_file_name("data");
    std::fs::create_dir_all(&folder).map_err(|e| {
        Error::input(format!("a folder cannot be made: {e}")).at(folder.display().to_string())
    })?;
    reading.keep(&folder, name)
}

/// `side_by_side.csv`: all common values of both.
fn write_both(folder: &Path, times: &[f64], pairs: &[Pair<'_>]) -> Result<()> {
    let names: Vec<[String; 2]> = pairs
        .iter()
        .map(|p| ["immersa", "freefem"].map(|who| format!("{}.{who}", p.name)))
        .collect();
    let mut columns: Vec<(&str, &[f64])> = vec![("time", times)];
    for (p, [ours, theirs]) in pairs.iter().zip(&names) {
        columns
            .extend([(ours.as_str(), p.ours.as_slice()), (theirs.as_str(), p.theirs.as_slice())]);
    }
    Series::new(&columns).write(&folder.join("side_by_side.csv"))
}

/// The least costs: ours first, then those of FreeFEM's loops.
fn costs(ours: &[Outcome], theirs: &[Vec<Reading>], loops: &[Loop]) -> Vec<Cost> {
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NAN, f64::min);
    let mine = Cost {
        who: "immersa".into(),
        steps: ours.first().and_then(|o| o.summary.steps).unwrap_or(0) as f64,
        first: least(&mut ours.iter().map(Outcome::cpu_first_step)),
        per_step: least(&mut ours.iter().map(Outcome::cpu_per_later_step)),
    };
    let of = |(work, readings): (&Loop, &Vec<Reading>)| {
        let number = |f: fn(&Reading) -> Option<f64>| {
            least(&mut readings.iter().map(|r| f(r).unwrap_or(f64::NAN)))
        };
        let who = if work.name.is_empty() {
            "FreeFEM".into()
        } else {
            format!("FreeFEM's {} loop", work.name)
        };
        Cost {
            who,
            steps: number(|r| r.about.steps),
            first: number(|r| r.about.first_step),
            per_step: number(|r| r.about.per_step),
        }
    };
    std::iter::once(mine).chain(loops.iter().zip(theirs).map(of)).collect()
}
