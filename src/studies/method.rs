//! A method: settings of a scene with a name, and meshes and steps of their own.

use std::str::FromStr;

/// Settings with a name: `BDF2 implicit: time.order=2 numerics.coupling=implicit`.
///
/// Beside keys of the scene, `cells=30,60` and `steps=0.02,0.01` give it meshes and steps of its
/// own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Method {
    /// The name; may be empty.
    pub name: String,
    /// Assignments in the scene, each `key=value`.
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
                _ => {
                    return Err(format!(
                        "`{word}` is no key=value; write for example time.order=2"
                    ));
                }
            }
        }
        Ok(method)
    }
}

impl FromStr for Method {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Method, String> {
        let (name, settings) = text
            .split_once(':')
            .ok_or("write a name, a colon and settings: \"BDF2: time.order=2\"")?;
        if name.trim().is_empty() {
            return Err("a method needs a name before the colon: \"BDF2: time.order=2\"".into());
        }
        Ok(Method { name: name.trim().into(), ..Method::settings(settings)? })
    }
}

/// A column of the series at a time: `membrane.horizontal@0.4`.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The column.
    pub column: String,
    /// The time; the end of the scene without it.
    pub time: Option<f64>,
}

impl FromStr for Measurement {
    type Err = String;
    fn from_str(text: &str) -> std::result::Result<Measurement, String> {
        let (column, time) = match text.split_once('@') {
            Some((column, time)) => {
                (column, Some(time.trim().parse().map_err(|_| format!("`{time}` is no time"))?))
            }
            None => (text, None),
        };
        if column.trim().is_empty() {
            return Err(
                "write a column of series.csv, and a time if it is not the end: membrane.area@0.4"
                    .into(),
            );
        }
        Ok(Measurement { column: column.trim().into(), time })
    }
}

/// Positive numbers, separated by commas.
fn numbers<T: FromStr + PartialOrd + Default>(list: &str) -> std::result::Result<Vec<T>, String> {
    let number = |v: &str| v.trim().parse::<T>().ok().filter(|v| *v > T::default());
    list.split(',')
        .map(|v| number(v).ok_or_else(|| format!("`{v}` is not a positive number")))
        .collect()
}

/// True if all brackets of a word are closed.
fn is_whole(word: &str) -> bool {
    let count = |brackets: &[char]| word.chars().filter(|c| brackets.contains(c)).count();
    count(&['[', '{']) == count(&[']', '}'])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn methods_and_quantities_are_read() {
        let m: Method =
            "BDF2 implicit: time.order=2 mesh.rectangle.cells=[3, 4] steps=0.02,1e-2 cells=30"
                .parse()
                .unwrap();
        assert_eq!(
            (m.name.as_str(), m.set.join(" ")),
            ("BDF2 implicit", "time.order=2 mesh.rectangle.cells=[3,4]".into())
        );
        assert_eq!((m.steps, m.cells), (Some(vec![0.02, 0.01]), Some(vec![30])));
        let q: Measurement = "membrane.area@0.4".parse().unwrap();
        assert_eq!(q, Measurement { column: "membrane.area".into(), time: Some(0.4) });
    }

    #[test]
    fn what_is_wrong_is_told() {
        for text in ["time.order=2", ": time.order=2", "a: order", "a: steps=0", "a: cells=x"] {
            assert!(!text.parse::<Method>().unwrap_err().is_empty(), "{text}");
        }
        assert!(
            "@1".parse::<Measurement>().is_err() && "area@soon".parse::<Measurement>().is_err()
        );
    }
}
