//! `immersa study precision`: error against cost for methods, meshes and steps.

mod charts;
mod plan;
mod reference;
mod report;

use super::axis::{self, Axis};
use super::campaign::Campaign;
use super::freefem::Case;
use super::front::Offer;
use super::method::Method;
use super::trial::{Outcome, Trial};
use super::twin::Twin;
use crate::base::{Error, Kind, Result};
use crate::output::Page;
use crate::scene::Scene;
use plan::{Combination, check, methods, settings, twin_methods};
use reference::{Reference, measured, reference, relative};

pub use super::method::Measurement;

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
    /// The reference values.
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

/// The reference values of the quantities.
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
        if self.errors.iter().any(|e| e.is_nan()) {
            f64::NAN
        } else {
            self.errors.iter().copied().fold(0.0, f64::max)
        }
    }
    /// The error if anything of the result is right: NaN from 100 % on, which is how a run may end
    /// that was unstable without overflow.
    fn usable(&self) -> f64 {
        Some(self.error()).filter(|e| *e < 1.0).unwrap_or(f64::NAN)
    }
    fn offer(&self) -> Offer {
        Offer { cost: self.cpu, error: self.usable() }
    }
}

/// Costs and errors of all points.
fn offers(points: &[CostPoint]) -> Vec<Offer> {
    points.iter().map(CostPoint::offer).collect()
}

/// Runs all methods on all meshes with all steps; the result is a page of errors and costs.
///
/// # Errors
/// A value that the scene does not take, a quantity that the series has not; a reference run that
/// failed; and those of [`Campaign::run`].
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
                merge(
                    &mut points,
                    of_ours(&method.name, setting, &outcome, &quantities, &reference)?,
                );
            }
            for (twin, method) in twin
                .into_iter()
                .flat_map(|twin| twin_methods(options, setting).map(move |m| (twin, m)))
            {
                merge(
                    &mut points,
                    of_freefem(
                        campaign,
                        twin,
                        setting,
                        &method,
                        repetition,
                        &quantities,
                        &reference,
                    )?,
                );
            }
        }
    }
    Ok(report::page(campaign.scene(), options, &quantities, &reference, &points))
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
    let scene = campaign
        .scene()
        .with(&[twin.settings(), &keep(campaign.scene(), setting), &method.set].concat())?;
    let runs = campaign.folder().join("runs");
    let work = twin.loops().first().cloned().unwrap_or_default();
    let run = Case::new(twin, &scene)
        .and_then(|c| c.run(&work, scene.time.end, again, &runs, campaign.stop()));
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
        Err(e) if matches!(e.kind(), Kind::Computation | Kind::Scene) => {
            point.end = "failed".into()
        }
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
            relative(&[1.1, 0.2], &[1.0, 0.0])
                .iter()
                .map(|e| (e * 1e6).round())
                .collect::<Vec<_>>(),
            [1e5, 2e5]
        );
        let point = |errors: &[f64]| CostPoint { errors: errors.to_vec(), ..bare() };
        assert_eq!(point(&[0.1, 0.3, 0.2]).error(), 0.3);
        assert!(point(&[1.0, 0.3]).usable().is_nan() && point(&[0.3]).usable() == 0.3);
        assert!(
            point(&[f64::NAN, 0.3]).error().is_nan() && point(&[0.3, f64::NAN]).error().is_nan()
        );
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
