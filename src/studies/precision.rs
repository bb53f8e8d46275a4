//! `immersa study precision`: error against cost for methods, meshes and steps.

mod report;

use super::axis::{self, Axis, Choice};
use super::campaign::Campaign;
use super::freefem::Case;
use super::front::Offer;
pub use super::method::Measurement;
use super::method::Method;
use super::trial::{Outcome, Trial};
use super::twin::Twin;
use crate::base::{Error, Kind, Result};
use crate::output::{Page, Series};
use crate::scene::keys::advice;
use crate::scene::{Scene, problem};

/// Options of a precision study.
#[derive(Clone, Debug, Default)]
pub struct Precision {
    /// The methods; none stands for the scene as it is.
    pub methods: Vec<Method>,
    /// Other keys of the scene and the values that they take, all combined.
    pub factors: Vec<Axis>,
    /// Cells along the first axis of the mesh; none stands for those of the scene.
    pub cells: Vec<usize>,
    /// Time steps; none stands for that of the scene.
    pub steps: Vec<f64>,
    /// The quantities that are measured.
    pub quantities: Vec<Measurement>,
    /// What is right.
    pub truth: Truth,
    /// Errors for which the cheapest setting is reported.
    pub tolerances: Vec<f64>,
    /// FreeFEM's script, to be run on the same meshes with the same steps.
    pub twin: Option<Twin>,
    /// Settings for the twin; none stands for those of the study.
    pub twin_methods: Vec<Method>,
    /// Repetitions of all runs; of the times the least counts.
    pub repeat: usize,
}

/// What is right.
#[derive(Clone, Debug, PartialEq)]
pub enum Truth {
    /// The values of the quantities, in their order.
    Exact(Vec<f64>),
    /// A run with these settings.
    Reference(Method),
}

impl Default for Truth {
    fn default() -> Truth {
        Truth::Exact(Vec::new())
    }
}

/// A setting, what it cost and how far off it was.
#[derive(Clone, Debug)]
struct CostPoint {
    method: String,
    /// Mesh, step and other values, in words.
    setting: String,
    /// The same by name.
    values: Vec<(String, String)>,
    /// Points of the same family are joined by a line: the number of their mesh and their factors.
    family: String,
    /// Relative error of each quantity; NaN if the run failed.
    errors: Vec<f64>,
    cpu: f64,
    unknowns: f64,
    /// Bytes; NaN for FreeFEM.
    memory: f64,
    end: String,
    ours: bool,
}

impl CostPoint {
    /// The largest of its errors; NaN if one is.
    fn error(&self) -> f64 {
        if self.errors.iter().any(|e| e.is_nan()) { f64::NAN } else { self.errors.iter().copied().fold(0.0, f64::max) }
    }
    /// The error if anything of the result is right: NaN from 100 % on, which is how a run may end that was unstable without overflow.
    fn usable(&self) -> f64 {
        Some(self.error()).filter(|e| *e < 1.0).unwrap_or(f64::NAN)
    }
    fn offer(&self) -> Offer {
        Offer { cost: self.cpu, error: self.usable() }
    }
}

/// The right values and how far they can be trusted.
#[derive(Clone, Debug, Default)]
struct Reference {
    values: Vec<f64>,
    /// Estimated relative error of each value.
    own: Vec<f64>,
    /// Its origin.
    words: String,
    /// Notes on the estimate of its own error.
    notes: Vec<String>,
}

impl Reference {
    fn error(&self) -> f64 {
        self.own.iter().fold(0.0, |m: f64, e| m.max(*e))
    }
}

/// A combination of mesh, step and factors; methods are run in it one after the other.
#[derive(Clone, Debug, Default)]
struct Combination {
    words: String,
    /// The same by name.
    values: Vec<(String, String)>,
    /// The same without the step.
    family: String,
    set: Vec<String>,
    cells: Option<usize>,
    step: Option<f64>,
}

/// Runs all methods on all meshes with all steps; the result is a page of errors and costs.
///
/// # Errors
/// A value that the scene does not take, a quantity that the series has not; a reference run that failed; and those of
/// [`Campaign::run`].
pub fn precision(campaign: &mut Campaign<'_>, options: &Precision) -> Result<Page> {
    let end = campaign.scene().time.end;
    let quantities: Vec<(String, f64)> =
        options.quantities.iter().map(|q| (q.column.clone(), q.time.unwrap_or(end))).collect();
    check(campaign, options, &quantities)?;
    let settings = settings(campaign, options)?;
    for setting in &settings {
        for method in methods(options, setting) {
            axis::check_distinct(setting.set.iter().chain(&method.set).map(String::as_str))?;
        }
    }
    let reference = reference(campaign, &options.truth, &quantities)?;
    let mut points: Vec<CostPoint> = Vec::new();
    let repeat = options.repeat.max(1);
    let of = repeat * settings.iter().map(|s| methods(options, s).len()).sum::<usize>();
    let twin = options.twin.as_ref();
    let mut k = 0;
    for repetition in 0..repeat {
        for setting in &settings {
            for method in methods(options, setting) {
                k += 1;
                let label = [method.name.as_str(), &setting.words].join(", ");
                let set = [setting.set.clone(), method.set.clone()].concat();
                let trial = Trial { label: label.trim_start_matches(", ").into(), set, repetition };
                let outcome = campaign.run(&trial, k, of)?;
                merge(&mut points, of_ours(&method.name, setting, &outcome, &quantities, &reference)?);
            }
            for (twin, method) in
                twin.into_iter().flat_map(|twin| twin_methods(options, setting).map(move |m| (twin, m)))
            {
                merge(&mut points, of_freefem(campaign, twin, setting, &method, repetition, &quantities, &reference)?);
            }
        }
    }
    Ok(report::findings(campaign.scene(), options, &quantities, &reference, &points))
}

/// Checks what can be known before the first run.
fn check(campaign: &Campaign<'_>, options: &Precision, quantities: &[(String, f64)]) -> Result<()> {
    let scene = campaign.scene();
    if quantities.is_empty() {
        return Err(Error::scene("a study of precision needs a quantity")
            .at("--quantity")
            .remedy("name a column of series.csv, with @TIME if it is not the end: --quantity membrane.area@0.4"));
    }
    let columns = problem(scene)?.row()?.names().to_vec();
    if let Some((column, _)) = quantities.iter().find(|q| !columns.contains(&q.0)) {
        return Err(Error::scene("the series has no such column")
            .at("--quantity")
            .value(column)
            .remedy(advice(column, columns.iter().map(String::as_str))));
    }
    if let Some((column, t)) = quantities.iter().find(|(_, t)| !(0.0..=scene.time.end).contains(t)) {
        return Err(Error::scene(format!("the time of {column} lies outside the run"))
            .at("--quantity")
            .value(t)
            .remedy(format!("give a time from 0 to time.end = {:?}", scene.time.end)));
    }
    if let Truth::Exact(values) = &options.truth
        && values.len() != quantities.len()
    {
        return Err(Error::scene("an exact value is needed for every quantity")
            .at("--exact")
            .value(format!("{} values for {} quantities", values.len(), quantities.len()))
            .remedy("give --exact once for each --quantity, in the same order, or --reference"));
    }
    let mut names: Vec<&str> = options.methods.iter().chain(&options.twin_methods).map(|m| m.name.as_str()).collect();
    names.sort_unstable();
    if let Some(twice) = names.windows(2).find(|w| w[0] == w[1]) {
        return Err(Error::scene("two methods have the same name")
            .at("--method")
            .value(twice[0])
            .remedy("name them differently"));
    }
    Ok(())
}

/// The combinations of meshes, factors and steps, as they were given.
fn settings(campaign: &Campaign<'_>, options: &Precision) -> Result<Vec<Combination>> {
    let all = || options.methods.iter().chain(&options.twin_methods);
    let own_cells = all().flat_map(|m| m.cells.iter().flatten().copied());
    let own_steps = all().flat_map(|m| m.steps.iter().flatten().copied());
    let cells = distinct(options.cells.iter().copied().chain(own_cells));
    let steps = distinct(options.steps.iter().copied().chain(own_steps));
    let step = |dt: &f64| Choice {
        name: "dt".into(),
        value: format!("{dt:?}"),
        label: format!("dt = {dt:?}"),
        set: format!("time.step={dt:?}"),
    };
    let mut axes = vec![Axis::cells(campaign.scene(), &cells)?];
    axes.extend(options.factors.iter().cloned());
    axes.push(Axis { name: "dt".into(), choices: steps.iter().map(step).collect() });
    // An axis without values leaves what the scene has.
    axes.retain(|a| !a.choices.is_empty());
    let setting = |choices: &Vec<Choice>| {
        let number = |name: &str| choices.iter().find(|c| c.name == name).and_then(Choice::number);
        let step = number("dt");
        let family = if step.is_some() { choices.len() - 1 } else { choices.len() };
        Combination {
            words: axis::in_words(choices),
            values: choices.iter().map(|c| (c.name.clone(), c.value.clone())).collect(),
            family: axis::in_words(&choices[..family]),
            set: axis::assignments(choices),
            cells: number("n").map(|n| n as usize),
            step,
        }
    };
    Ok(axis::combinations(&axes).iter().map(setting).collect())
}

fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut all, v| {
        if !all.contains(&v) {
            all.push(v);
        }
        all
    })
}

/// The methods that are run in a setting.
fn methods(options: &Precision, setting: &Combination) -> Vec<Method> {
    if options.methods.is_empty() {
        return vec![Method::default()];
    }
    options.methods.iter().filter(|m| fits(m, options, setting)).cloned().collect()
}

/// The settings that the twin is run with in a setting.
fn twin_methods(options: &Precision, setting: &Combination) -> impl Iterator<Item = Method> {
    let plain = Method { name: "FreeFEM".into(), ..Method::default() };
    let all = if options.twin_methods.is_empty() { vec![plain] } else { options.twin_methods.clone() };
    all.into_iter().filter(move |m| fits(m, options, setting))
}

/// True if a method is run in a setting: one that has no meshes or steps of its own takes those of the study.
fn fits(method: &Method, options: &Precision, setting: &Combination) -> bool {
    let cells = method.cells.as_ref().unwrap_or(&options.cells);
    let steps = method.steps.as_ref().unwrap_or(&options.steps);
    setting.cells.is_none_or(|n| cells.is_empty() || cells.contains(&n))
        && setting.step.is_none_or(|dt| steps.is_empty() || steps.contains(&dt))
}

/// The right values; a reference run is run, and run coarser for its own error.
fn reference(campaign: &mut Campaign<'_>, truth: &Truth, quantities: &[(String, f64)]) -> Result<Reference> {
    let settings = match truth {
        Truth::Exact(values) => {
            let own = vec![0.0; values.len()];
            return Ok(Reference { values: values.clone(), own, words: "exact values".into(), notes: vec![] });
        }
        Truth::Reference(settings) => settings,
    };
    let mut set = settings.set.clone();
    let n = settings.cells.as_ref().and_then(|c| c.last()).copied();
    let cells = |n: usize| Ok::<_, Error>(axis::assignments(&Axis::cells(campaign.scene(), &[n])?.choices));
    let [chosen, coarser_mesh] = [n, n.map(|n| n / 2).filter(|n| *n > 0)].map(|n| n.map(cells).transpose());
    set.extend(chosen?.unwrap_or_default());
    set.extend(settings.steps.iter().flatten().last().map(|dt| format!("time.step={dt:?}")));
    let scene = campaign.scene().with(&set)?;
    let coarser_mesh = coarser_mesh?.map(|set| set.concat());
    let trial = |label: &str, more: Option<String>| Trial::new(label, set.iter().cloned().chain(more).collect());
    let fine = campaign.run(&trial("reference", None), 1, 1)?;
    if !fine.finished() {
        return Err(Error::computation(format!("the reference run {}", fine.end.in_words()))
            .value(fine.end.reason())
            .remedy(
                "choose one that is stable with --reference: numerics.coupling=implicit, a smaller step, a finer mesh",
            ));
    }
    let values = measured(&fine.series, quantities)?;
    let mut found = Reference { own: vec![0.0; values.len()], values, ..Reference::default() };
    found.words = format!(
        "{}{}, dt = {:?}",
        if set.is_empty() { "the scene as it is: " } else { "" },
        set.join(" "),
        scene.time.step
    );
    // The error that halving takes away is 2^p - 1 times the one that is left.
    let step_order = scene.time.order as i32;
    let twice = format!("time.step={:?}", 2.0 * scene.time.step);
    let coarser = [("twice the step", Some(twice), step_order), ("half the cells", coarser_mesh, 2)];
    for (words, change, order) in coarser {
        let run = change.map(|c| campaign.run(&trial(&format!("reference, {words}"), Some(c)), 1, 1)).transpose();
        // A step that does not divide the end is no reason to stop.
        let run = run.or_else(|e| if e.kind() == Kind::Scene { Ok(None) } else { Err(e) })?;
        match run.filter(Outcome::finished).map(|o| measured(&o.series, quantities)).transpose()? {
            Some(coarse) => {
                let parts = relative(&coarse, &found.values).into_iter().map(|e| e / (2f64.powi(order) - 1.0));
                found.own.iter_mut().zip(parts).for_each(|(own, part)| *own += part);
                found.notes.push(format!("with {words} (order {order})"));
            }
            None => found.notes.push(format!("not with {words}: there is no such run")),
        }
    }
    Ok(found)
}

/// The quantities of a run that reached its end.
fn measured(series: &Series, quantities: &[(String, f64)]) -> Result<Vec<f64>> {
    let value = |(column, t): &(String, f64)| {
        let missing = || {
            Error::scene(format!("the series has no row at t = {t:?}, where {column} is asked for"))
                .at("--quantity")
                .value(format!("{column}@{t:?}"))
                .remedy(
                    "choose a time that is a multiple of all steps and of output.every, or set --set output.every=...",
                )
        };
        let values = series.column(column)?;
        series.row_at(*t)?.and_then(|i| values.get(i)).copied().ok_or_else(missing)
    };
    quantities.iter().map(value).collect()
}

/// Differences over the right values; as they are where a right value is zero.
fn relative(values: &[f64], right: &[f64]) -> Vec<f64> {
    let error = |(v, r): (&f64, &f64)| (v - r).abs() / if *r == 0.0 { 1.0 } else { r.abs() };
    values.iter().zip(right).map(error).collect()
}

fn of_ours(
    method: &str,
    setting: &Combination,
    outcome: &Outcome,
    quantities: &[(String, f64)],
    reference: &Reference,
) -> Result<CostPoint> {
    let errors = match outcome.finished() {
        true => relative(&measured(&outcome.series, quantities)?, &reference.values),
        false => vec![f64::NAN; quantities.len()],
    };
    let number = |v: Option<u64>| v.map_or(f64::NAN, |v| v as f64);
    Ok(CostPoint {
        method: method.into(),
        setting: setting.words.clone(),
        values: setting.values.clone(),
        family: setting.family.clone(),
        errors,
        cpu: outcome.cpu_seconds(),
        unknowns: outcome.unknowns() as f64,
        memory: number(outcome.summary.memory),
        end: outcome.end.in_words(),
        ours: true,
    })
}

/// The twin's first loop on the same mesh with the same step. A run that fails is a point, too.
fn of_freefem(
    campaign: &mut Campaign<'_>,
    twin: &Twin,
    setting: &Combination,
    method: &Method,
    again: usize,
    quantities: &[(String, f64)],
    reference: &Reference,
) -> Result<CostPoint> {
    let scene = campaign.scene().with(&[twin.settings(), &keep(campaign.scene(), setting), &method.set].concat())?;
    let runs = campaign.folder().join("runs");
    let work = twin.loops().first().cloned().unwrap_or_default();
    let run = Case::new(twin, &scene).and_then(|c| c.run(&work, scene.time.end, again, &runs, campaign.stop()));
    let mut point = CostPoint {
        method: method.name.clone(),
        setting: setting.words.clone(),
        values: setting.values.clone(),
        family: setting.family.clone(),
        errors: vec![f64::NAN; quantities.len()],
        cpu: f64::NAN,
        unknowns: f64::NAN,
        memory: f64::NAN,
        end: "finished".into(),
        ours: false,
    };
    match run {
        Ok(Some(reading)) => {
            point.errors = relative(&measured(&reading.table, quantities)?, &reference.values);
            point.cpu = reading.about.cpu_seconds();
            point.unknowns = reading.about.unknowns.unwrap_or(f64::NAN);
        }
        Ok(None) => {
            return Err(Error::input("FreeFEM is not installed")
                .at("--twin")
                .value("FreeFem++")
                .remedy(format!("{}, or leave --twin out", super::freefem::INSTALL)));
        }
        Err(e) if matches!(e.kind(), Kind::Computation | Kind::Scene) => point.end = "failed".into(),
        Err(e) => return Err(e),
    }
    campaign.listener().note(&format!("{}, {}: {}", method.name, setting.words, point.end));
    Ok(point)
}

/// Assignments of the study that the twin's scene keeps: all but the scheme, which is the twin's.
fn keep(scene: &Scene, setting: &Combination) -> Vec<String> {
    let grad_div = scene.numerics.grad_div.map_or("auto".to_string(), |v| format!("{v:?}"));
    let mut set = vec![
        format!("time.end={:?}", scene.time.end),
        format!("time.step={:?}", scene.time.step),
        format!("output.every={:?}", scene.output.every),
        format!("numerics.grad_div={grad_div}"),
    ];
    set.extend(setting.set.iter().cloned());
    set
}

/// Adds a point, or takes the lesser cost of two that are the same run.
fn merge(points: &mut Vec<CostPoint>, point: CostPoint) {
    match points.iter_mut().find(|p| p.method == point.method && p.setting == point.setting) {
        Some(known) => known.cpu = known.cpu.min(point.cpu),
        None => points.push(point),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_point_is_the_largest_and_nothing_if_one_failed() {
        assert_eq!(
            relative(&[1.1, 0.2], &[1.0, 0.0]).iter().map(|e| (e * 1e6).round()).collect::<Vec<_>>(),
            [1e5, 2e5]
        );
        let point = |errors: &[f64]| CostPoint { errors: errors.to_vec(), ..bare() };
        assert_eq!(point(&[0.1, 0.3, 0.2]).error(), 0.3);
        assert!(point(&[1.0, 0.3]).usable().is_nan() && point(&[0.3]).usable() == 0.3);
        assert!(point(&[f64::NAN, 0.3]).error().is_nan() && point(&[0.3, f64::NAN]).error().is_nan());
    }

    #[test]
    fn a_repetition_lowers_the_cost_only() {
        let mut points = Vec::new();
        for cpu in [2.0, 1.0, 3.0] {
            merge(&mut points, CostPoint { cpu, ..bare() });
        }
        assert_eq!((points.len(), points[0].cpu), (1, 1.0));
    }

    #[test]
    fn methods_may_have_steps_of_their_own() {
        let method = |text: &str| text.parse::<Method>().unwrap();
        let options = Precision {
            methods: vec![method("a: time.order=1 steps=0.1"), method("b: time.order=2")],
            steps: vec![0.2, 0.1],
            ..Precision::default()
        };
        let names = |dt: f64| {
            let setting = Combination { step: Some(dt), ..Combination::default() };
            methods(&options, &setting).iter().map(|m| m.name.clone()).collect::<Vec<_>>().concat()
        };
        assert_eq!((names(0.2), names(0.1)), ("b".to_string(), "ab".to_string()));
    }

    fn bare() -> CostPoint {
        let text = String::new;
        CostPoint {
            method: text(),
            setting: text(),
            values: vec![],
            family: text(),
            errors: vec![0.1],
            cpu: 1.0,
            unknowns: 1.0,
            memory: 1.0,
            end: text(),
            ours: true,
        }
    }
}
