//! Parameters that differ between the trials of a study: keys of the scene, and the values they
//! take.

use crate::base::{Error, Result};
use crate::scene::Scene;
use crate::scene::schema::MeshSource;

/// A value on an [`Axis`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choice {
    /// The name of the axis.
    pub name: String,
    /// The value as it is shown.
    pub value: String,
    /// Name in a sentence: `n = 60`, `implicit coupling`.
    pub label: String,
    /// Assignment in the scene, `key.sub=value`.
    pub set: String,
}

impl Choice {
    fn new(name: &str, value: &str, set: String) -> Choice {
        Choice { name: name.into(), value: value.into(), label: format!("{name} = {value}"), set }
    }
    /// The value as a number, if it is one.
    pub fn number(&self) -> Option<f64> {
        self.value.parse().ok().filter(|v: &f64| v.is_finite())
    }
}

/// A key of the scene and the values it takes in a study.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Axis {
    /// Its name, short.
    pub name: String,
    /// The values, in their order.
    pub choices: Vec<Choice>,
}

impl Axis {
    /// Reads `KEY=V1,V2,...`; `option` is the option of the command line that it was given with.
    /// Commas in brackets and quotes belong to a value.
    ///
    /// # Errors
    /// No key, no values or an empty one. Whether the scene knows the key shows when a scene is
    /// made of it.
    pub fn parse(text: &str, option: &str) -> Result<Axis> {
        let wrong = |what: &str| {
            Error::scene(what).at(option).value(text).remedy(format!(
                "write {option} KEY=V1,V2, for example {option} membrane.0.area.linear.modulus=1,10"
            ))
        };
        let (key, values) =
            text.split_once('=').ok_or_else(|| wrong("a key and its values are wanted"))?;
        let (key, values) = (key.trim(), split(values));
        if key.is_empty() {
            return Err(wrong("the key is empty"));
        }
        if values.iter().any(|v| v.is_empty()) {
            return Err(wrong("a value is empty"));
        }
        let name = short_name(key);
        let choices = values.iter().map(|v| Choice::new(&name, v, format!("{key}={v}"))).collect();
        Ok(Axis { name, choices })
    }
    /// Coupling of the force of a membrane to a step: `explicit`, `implicit`, or others that the
    /// scene knows.
    pub fn coupling(values: &[String]) -> Axis {
        let choice = |v: &String| Choice {
            label: format!("{v} coupling"),
            ..Choice::new("coupling", v, format!("numerics.coupling={v}"))
        };
        Axis { name: "coupling".into(), choices: values.iter().map(choice).collect() }
    }
    /// The order in time.
    pub fn order(values: &[String]) -> Axis {
        let choice = |v: &String| Choice {
            label: format!("order {v}"),
            ..Choice::new("order", v, format!("time.order={v}"))
        };
        Axis { name: "order".into(), choices: values.iter().map(choice).collect() }
    }
    /// The cells of a generated mesh along its first side (a disc: along a radius); those along the
    /// others in proportion.
    ///
    /// # Errors
    /// The mesh comes from a file.
    pub fn cells(scene: &Scene, values: &[usize]) -> Result<Axis> {
        let scaled = |of: &[usize], n: usize| {
            let first = of.first().copied().unwrap_or(1).max(1) as f64;
            let cells = of
                .iter()
                .map(|&c| ((c as f64 * n as f64 / first).round() as usize).max(1).to_string());
            format!("[{}]", cells.collect::<Vec<_>>().join(", "))
        };
        let set = |n: usize| match &scene.mesh {
            MeshSource::Rectangle(r) => Ok(format!("mesh.rectangle.cells={}", scaled(&r.cells, n))),
            MeshSource::Box(b) => Ok(format!("mesh.box.cells={}", scaled(&b.cells, n))),
            MeshSource::BallInBox(b) => {
                Ok(format!("mesh.ball_in_box.cells={}", scaled(&b.cells, n)))
            }
            MeshSource::Disc(_) => Ok(format!("mesh.disc.cells={n}")),
            MeshSource::File { path, .. } => {
                Err(Error::scene("a mesh from a file has no number of cells to be set")
                    .at("--cells")
                    .value(path.display())
                    .remedy(
                        "refine it with --vary mesh.refine=0,1,2 or give files: --vary \
                         mesh.file=coarse.msh,fine.msh",
                    ))
            }
        };
        let choices = values.iter().map(|&n| Ok(Choice::new("n", &n.to_string(), set(n)?)));
        Ok(Axis { name: "n".into(), choices: choices.collect::<Result<_>>()? })
    }
}

/// Refuses settings, each `key=value`, of which two set the same key: one of them would be named in
/// the results and not hold.
///
/// # Errors
/// The key that is set twice.
pub fn check_distinct<'a>(settings: impl IntoIterator<Item = &'a str>) -> Result<()> {
    let mut keys: Vec<&str> =
        settings.into_iter().map(|s| s.split_once('=').map_or(s, |(key, _)| key.trim())).collect();
    keys.sort_unstable();
    match keys.windows(2).find(|k| k[0] == k[1]) {
        None => Ok(()),
        Some(twice) => Err(Error::scene("a value of the scene is set twice in the same run")
            .value(twice[0])
            .remedy(
                "set it in one way: by a method, by --vary or --scan, or by an option of its own",
            )),
    }
}

/// All combinations of a value of each axis; the last axis changes first.
pub fn combinations(axes: &[Axis]) -> Vec<Vec<Choice>> {
    axes.iter().fold(vec![Vec::new()], |all, axis| {
        all.iter()
            .flat_map(|start| {
                axis.choices.iter().map(move |c| [start, std::slice::from_ref(c)].concat())
            })
            .collect()
    })
}

/// A combination in words: `explicit coupling, order 1, n = 30`.
pub fn in_words(combination: &[Choice]) -> String {
    combination.iter().map(|c| c.label.as_str()).collect::<Vec<_>>().join(", ")
}

/// Assignments of a combination in the scene.
pub fn assignments(combination: &[Choice]) -> Vec<String> {
    combination.iter().map(|c| c.set.clone()).collect()
}

/// The last part of a key, with the one before it where it would not be understood alone.
fn short_name(key: &str) -> String {
    let parts: Vec<&str> = key.split('.').map(str::trim).collect();
    let vague = |p: &&str| ["inside", "outside", "cells"].contains(p) || p.parse::<usize>().is_ok();
    let alone = parts.last().is_none_or(|p| !vague(p));
    parts[parts.len().saturating_sub(if alone { 1 } else { 2 })..].join(".")
}

/// Splits at commas outside brackets and quotes.
fn split(text: &str) -> Vec<String> {
    let (mut depth, mut quote) = (0usize, None);
    let mut parts = vec![String::new()];
    for c in text.chars() {
        match (quote, c) {
            (Some(q), _) if c == q => quote = None,
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            (None, ',') if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(last) = parts.last_mut() {
            last.push(c);
        }
    }
    parts.iter().map(|p| p.trim().to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_read_and_combined() {
        let axis = Axis::parse("numerics.thickness=0.1, 0.2", "--scan").unwrap();
        assert_eq!(
            (axis.name.as_str(), axis.choices[1].set.as_str()),
            ("thickness", "numerics.thickness=0.2")
        );
        assert_eq!(axis.choices[1].number(), Some(0.2));
        let pairs =
            Axis::parse("fluid.viscosity={ inside = 1, outside = 2 },\"a,b\",[1, 2]", "--vary")
                .unwrap();
        let values: Vec<&str> = pairs.choices.iter().map(|c| c.value.as_str()).collect();
        assert_eq!(values, ["{ inside = 1, outside = 2 }", "\"a,b\"", "[1, 2]"]);
        assert_eq!(
            Axis::parse("fluid.viscosity.inside=1", "--vary").unwrap().name,
            "viscosity.inside"
        );
        let all = combinations(&[Axis::coupling(&["explicit".into()]), axis]);
        assert_eq!(
            all.iter().map(|c| in_words(c)).collect::<Vec<_>>(),
            ["explicit coupling, thickness = 0.1", "explicit coupling, thickness = 0.2"]
        );
        assert_eq!(assignments(&all[0]), ["numerics.coupling=explicit", "numerics.thickness=0.1"]);
        for text in ["thickness", "=1", "a.b=", "a.b=1,,2"] {
            let e = Axis::parse(text, "--vary").unwrap_err();
            assert!(e.wrong_value() == text && e.advice().contains("--vary KEY"), "{e}");
        }
    }
}
