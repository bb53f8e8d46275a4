//! The combinations and methods of a precision study.

use super::{Precision, Truth};
use crate::base::{Error, Result};
use crate::scene::keys::advice;
use crate::scene::problem;
use crate::studies::axis::{self, Axis, Choice};
use crate::studies::campaign::Campaign;
use crate::studies::method::Method;

/// A combination of mesh, step and factors; methods are run in it one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Combination {
    pub words: String,
    /// The same by name.
    pub values: Vec<(String, String)>,
    /// The same without the step.
    pub family: String,
    pub set: Vec<String>,
    pub cells: Option<usize>,
    pub step: Option<f64>,
}

/// Refuses options that are wrong before the first run.
pub(super) fn check(
    campaign: &Campaign<'_>,
    options: &Precision,
    quantities: &[(String, f64)],
) -> Result<()> {
    let scene = campaign.scene();
    if quantities.is_empty() {
        return Err(Error::scene("a study of precision needs a quantity").at("--quantity").remedy(
            "name a column of series.csv, with @TIME if it is not the end: --quantity \
             membrane.area@0.4",
        ));
    }
    let columns = problem(scene)?.row()?.names().to_vec();
    if let Some((column, _)) = quantities.iter().find(|q| !columns.contains(&q.0)) {
        return Err(Error::scene("the series has no such column")
            .at("--quantity")
            .value(column)
            .remedy(advice(column, columns.iter().map(String::as_str))));
    }
    if let Some((column, t)) = quantities.iter().find(|(_, t)| !(0.0..=scene.time.end).contains(t))
    {
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
    let mut names: Vec<&str> =
        options.methods.iter().chain(&options.twin_methods).map(|m| m.name.as_str()).collect();
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
pub(super) fn settings(campaign: &Campaign<'_>, options: &Precision) -> Result<Vec<Combination>> {
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
pub(super) fn methods(options: &Precision, setting: &Combination) -> Vec<Method> {
    if options.methods.is_empty() {
        return vec![Method::default()];
    }
    options.methods.iter().filter(|m| fits(m, options, setting)).cloned().collect()
}

/// The settings that the twin is run with in a setting.
pub(super) fn twin_methods(
    options: &Precision,
    setting: &Combination,
) -> impl Iterator<Item = Method> {
    let plain = Method { name: "FreeFEM".into(), ..Method::default() };
    let all =
        if options.twin_methods.is_empty() { vec![plain] } else { options.twin_methods.clone() };
    all.into_iter().filter(move |m| fits(m, options, setting))
}

/// True if a method is run in a setting: one that has no meshes or steps of its own takes those of
/// the study.
fn fits(method: &Method, options: &Precision, setting: &Combination) -> bool {
    let cells = method.cells.as_ref().unwrap_or(&options.cells);
    let steps = method.steps.as_ref().unwrap_or(&options.steps);
    setting.cells.is_none_or(|n| cells.is_empty() || cells.contains(&n))
        && setting.step.is_none_or(|dt| steps.is_empty() || steps.contains(&dt))
}
