//! What a scene would compute, as text and as JSON.

use super::Scene;
use super::plan::Plan;
use super::problem::{ElasticWave, Facts, Limits};
use super::problems::problem;
use super::schema::MeshSource;
use crate::base::{Result, Warning};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// What a scene would compute: its plan, its sizes and what is wrong with it.
pub struct Explanation {
    scene: Scene,
    /// The plan in words.
    pub plan: Plan,
    /// Warnings before the first step.
    pub warnings: Vec<Warning>,
    /// Sizes.
    pub facts: Facts,
    /// Limits and lengths at the start.
    pub limits: Limits,
    /// The slowest elastic wave of each structure that has one.
    pub waves: Vec<ElasticWave>,
    /// Numbers without units, by their names.
    pub numbers: Vec<(String, f64)>,
    /// Values of `[numerics]` that were derived or given, by their keys.
    pub derived: Vec<(&'static str, f64)>,
    /// Names of the columns of the series.
    pub columns: Vec<String>,
}

/// Explains a scene without computing it.
///
/// # Errors
/// Those of [`problem`](super::problem()) and of [`Problem::plan`](super::Problem::plan).
pub fn explain(scene: &Scene) -> Result<Explanation> {
    let mut problem = problem(scene)?;
    Ok(Explanation {
        scene: scene.clone(),
        plan: problem.plan()?,
        warnings: problem.warnings().to_vec(),
        facts: problem.facts(),
        limits: problem.limits(),
        waves: problem.waves(),
        numbers: problem.numbers(),
        derived: problem.derived(),
        columns: problem.row()?.names().to_vec(),
    })
}

impl Explanation {
    /// The title, the plan and the warnings, ready to print.
    pub fn text(&self) -> String {
        let warnings: String = self.warnings.iter().map(|w| format!("warning: {w}\n")).collect();
        format!("{}\n\n{}\n{warnings}", self.scene.title, self.plan)
    }

    /// The same for other programs; the names are those of `summary.json` where a run has the same.
    pub fn json(&self) -> Value {
        let (scene, facts, limits) = (&self.scene, &self.facts, &self.limits);
        let [velocity, pressure, level_set] = facts.unknowns;
        let structures = scene.structures().iter();
        json!({
            "version": crate::base::VERSION,
            "title": scene.title,
            "units": scene.units.words(),
            "scene": scene.path().display().to_string(),
            "problem": self.problem(),
            "dimension": scene.dimension(),
            "mesh": match &scene.mesh {
                MeshSource::File { path, .. } => json!(path.display().to_string()),
                _ => Value::Null,
            },
            "cells": facts.cells,
            "edge": facts.edge,
            "adapted": facts.adapted,
            "unknowns": { "velocity": velocity, "pressure": pressure, "level_set": level_set },
            "factor_entries": facts.factor.map(|(entries, _)| entries),
            "factor_memory": facts.factor.map(|(_, bytes)| bytes),
            "memory": facts.memory,
            "time": {
                "end": scene.time.end,
                "step": scene.time.step,
                "steps": scene.time.tolerance.is_none().then(|| scene.time.steps()),
                "tolerance": scene.time.tolerance,
                "order": scene.time.order,
            },
            "structures": structures
                .map(|s| json!({ "name": s.name(), "list": s.list() }))
                .collect::<Vec<_>>(),
            "limits": {
                "thickness": limits.thickness,
                "band_edges": limits.band_edges,
                "explicit_limit": limits.explicit_limit,
                "stretched_limit": limits.stretched_limit,
            },
            "waves": self.waves
                .iter()
                .map(|w| json!({ "name": w.name, "period": w.period }))
                .collect::<Vec<_>>(),
            "numbers": self.numbers.iter().cloned().collect::<BTreeMap<_, _>>(),
            "numerics": self.derived.iter().copied().collect::<BTreeMap<_, _>>(),
            "columns": std::iter::once("time")
                .chain(self.columns.iter().map(String::as_str))
                .collect::<Vec<_>>(),
            "warnings": self.warnings
                .iter()
                .map(|w| json!({ "what": w.what, "remedy": w.remedy }))
                .collect::<Vec<_>>(),
            "plan": self.plan
                .sections()
                .map(|(heading, lines)| json!({ "heading": heading, "lines": lines }))
                .collect::<Vec<_>>(),
        })
    }

    /// The kind of problem, in a word.
    fn problem(&self) -> &'static str {
        match (&self.scene.image, self.scene.fluid.is_prescribed()) {
            (Some(_), _) => "segmentation",
            (None, true) => "advection",
            (None, false) => "flow",
        }
    }
}
