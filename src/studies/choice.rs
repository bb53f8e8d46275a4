//! What the runs of a study differ in, as it is written on the command line.

use crate::base::{Error, Result};
use crate::scene::Scene;
use crate::scene::schema::MeshSource;
use std::str::FromStr;

/// Settings with a name: `BDF2 implicit: time.order=2 numerics.coupling=implicit`.
///
/// Beside keys of the scene, `cells=30,60` and `steps=0.02,0.01` give it meshes and steps of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Method {
    /// The name; may be empty.
    pub name: String,
    /// What is set, each `key=value`.
    pub set: Vec<String>,
    /// Its meshes, if they are not those of the study.
    pub cells: Option<Vec<usize>>,
    /// Its steps, if they are not those of the study.
    pub steps: Option<Vec<f64>>,
}

impl Method {
    /// Reads settings without a name.
    ///
    /// # Errors
    /// A word that is no `key=value`, or a number that is none.
    pub fn settings(text: &str) -> std::result::Result<Method, String> {
        let mut method = Method::default();
        let mut words: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            // A list may be written with blanks: cells=[30, 30].
            match words.last_mut().filter(|last| !is_whole(last)) {
                Some(last) => *last += word,
                None => words.push(word.to_string()),
            }
        }
        for word in words {
            match word.split_once('=') {
                Some(("cells", list)) => method.cells = Some(numbers(list)?),
                Some(("step" | "steps", list)) => method.steps = Some(numbers(list)?),
                Some((key, value)) if !key.is_empty() && !value.is_empty() => method.set.push(word),
                _ => return Err(format!("`{word}` is no key=value; write for example time.order=2")),
            }
        }
        Ok(method)
    }
}

impl FromStr for Method {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Method, String> {
        let (name, settings) =
            text.split_once(':').ok_or("write a name, a colon and settings: \"BDF2: time.order=2\"")?;
        if name.trim().is_empty() {
            return Err("a method needs a name before the colon: \"BDF2: time.order=2\"".into());
        }
        Ok(Method { name: name.trim().into(), ..Method::settings(settings)? })
    }
}

/// A key of the scene and the values it takes in turn: `numerics.grad_div=1,5`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Factor {
    /// The key.
    pub key: String,
    /// The values.
    pub values: Vec<String>,
}

impl FromStr for Factor {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Factor, String> {
        let (key, list) = text.split_once('=').ok_or("write a key and its values: numerics.grad_div=1,5")?;
        let values = items(list);
        if key.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err("write a key and its values: numerics.grad_div=1,5".into());
        }
        Ok(Factor { key: key.trim().into(), values })
    }
}

/// A column of the series at a time: `membrane.horizontal@0.4`.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// The column.
    pub column: String,
    /// The time; the end of the scene without it.
    pub time: Option<f64>,
}

impl FromStr for Quantity {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Quantity, String> {
        let (column, time) = match text.split_once('@') {
            Some((column, time)) => (column, Some(time.trim().parse().map_err(|_| format!("`{time}` is no time"))?)),
            None => (text, None),
        };
        if column.trim().is_empty() {
            return Err("write a column of series.csv, and a time if it is not the end: membrane.area@0.4".into());
        }
        Ok(Quantity { column: column.trim().into(), time })
    }
}

/// Positive numbers, separated by commas.
///
/// # Errors
/// One that is not.
pub fn numbers<T: FromStr + PartialOrd + Default>(list: &str) -> std::result::Result<Vec<T>, String> {
    let number = |v: &str| v.trim().parse::<T>().ok().filter(|v| *v > T::default());
    list.split(',').map(|v| number(v).ok_or_else(|| format!("`{v}` is not a positive number"))).collect()
}

/// What to set for `n` cells along the first axis of a generated mesh, the others in the proportion of the scene.
///
/// # Errors
/// A mesh that is read from a file.
pub fn cells(scene: &Scene, n: usize) -> Result<String> {
    match &scene.mesh {
        MeshSource::Rectangle { cells: [x, y], .. } => {
            let m = (n as f64 * *y as f64 / *x as f64).round().max(1.0);
            Ok(format!("mesh.rectangle.cells=[{n}, {m}]"))
        }
        MeshSource::Disc { .. } => Ok(format!("mesh.disc.cells={n}")),
        _ => Err(Error::scene("the mesh of the scene is not generated, so that its cells cannot be chosen")
            .at("--cells")
            .value(n)
            .remedy("name mesh files instead: --vary mesh.file=coarse.msh,fine.msh")),
    }
}

/// Whether all brackets of a word are closed.
fn is_whole(word: &str) -> bool {
    let count = |brackets: &[char]| word.chars().filter(|c| brackets.contains(c)).count();
    count(&['[', '{']) == count(&[']', '}'])
}

/// The values of a list, separated by commas outside of brackets.
fn items(list: &str) -> Vec<String> {
    let mut items: Vec<String> = Vec::new();
    for part in list.split(',') {
        match items.last_mut().filter(|last| !is_whole(last)) {
            Some(last) => *last += &format!(",{part}"),
            None => items.push(part.to_string()),
        }
    }
    items.iter().map(|v| v.trim().to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_factors_and_quantities_are_read() {
        let m: Method =
            "BDF2 implicit: time.order=2 mesh.rectangle.cells=[3, 4] steps=0.02,1e-2 cells=30".parse().unwrap();
        assert_eq!(
            (m.name.as_str(), m.set.join(" ")),
            ("BDF2 implicit", "time.order=2 mesh.rectangle.cells=[3,4]".into())
        );
        assert_eq!((m.steps, m.cells), (Some(vec![0.02, 0.01]), Some(vec![30])));
        let f: Factor = "mesh.rectangle.cells=[3, 3],[4,4]".parse().unwrap();
        assert_eq!(f.values, ["[3, 3]", "[4,4]"]);
        let q: Quantity = "membrane.area@0.4".parse().unwrap();
        assert_eq!(q, Quantity { column: "membrane.area".into(), time: Some(0.4) });
    }

    #[test]
    fn what_is_wrong_is_told() {
        for text in ["time.order=2", ": time.order=2", "a: order", "a: steps=0", "a: cells=x"] {
            assert!(!text.parse::<Method>().unwrap_err().is_empty(), "{text}");
        }
        assert!("numerics.grad_div".parse::<Factor>().is_err() && "k=1,,2".parse::<Factor>().is_err());
        assert!("@1".parse::<Quantity>().is_err() && "area@soon".parse::<Quantity>().is_err());
    }
}
