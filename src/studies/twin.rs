//! Twins: FreeFEM scripts that compute the same thing as a scene.
//!
//! Comments of a twin, or of the files it includes, declare its arguments and assumptions:
//!
//! ```text
//! //@ -lambda membrane.0.area.linear.modulus
//! //@ set numerics.coupling=explicit
//! //@ loop expert  matrix factored once
//! ```
//!
//! The first line names the value of the scene that a switch takes, the second a value with which
//! the scene has the scheme of the twin, the third a variant of its time loop, `-loop expert`, with
//! a description.
//!
//! Every twin takes `-mesh` (a mesh file, see [`mesh::freefem`](crate::mesh::freefem)), `-dt`,
//! `-tmax`, `-every` (time between two rows) and `-out`, the name of the CSV file that it writes: a
//! column `time`, and others named as in `series.csv`. On standard output it prints its cost, in
//! lines of a name and a number: `steps`, `unknowns`, `first_step` and `per_step`, the CPU seconds
//! of the first and of a later step; and `freefem`, the version.

use crate::base::{Error, Result};
use crate::output::read_text;
use crate::scene::{Problem, Scene};
use std::path::{Path, PathBuf};

/// Largest depth of nested includes.
const DEEPEST: usize = 8;

/// A FreeFEM script and its declarations.
#[derive(Clone, Debug)]
pub struct Twin {
    path: PathBuf,
    /// The script and all that it includes.
    text: String,
    settings: Vec<String>,
    /// Switch, and key of the scene.
    switches: Vec<(String, String)>,
    loops: Vec<Loop>,
}

/// A variant of the time loop of a twin.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Loop {
    /// The value of `-loop`; empty for a twin that has no such switch.
    pub name: String,
    /// Description of its work.
    pub words: String,
}

impl Twin {
    /// Default path of the twin of a scene: `twin.edp` beside it.
    pub fn beside(scene: &Path) -> PathBuf {
        scene.with_file_name("twin.edp")
    }
    /// Reads a twin.
    ///
    /// # Errors
    /// A script that cannot be read, or a declaration that is not understood.
    pub fn read(path: &Path) -> Result<Twin> {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        if !path.exists() {
            return Err(Error::input("the scene has no FreeFEM twin")
                .at(path.display().to_string())
                .value(path.display())
                .remedy(
                    "name a FreeFEM script with --twin FILE.edp; examples/listing/twin.edp shows \
                     what it must do",
                ));
        }
        let text = expanded(&path, DEEPEST)?;
        let mut twin =
            Twin { path, text: String::new(), settings: vec![], switches: vec![], loops: vec![] };
        for line in text.lines().filter_map(|l| l.trim().strip_prefix("//@")) {
            twin.declare(line.trim())?;
        }
        if twin.loops.is_empty() {
            twin.loops.push(Loop::default());
        }
        Ok(Twin { text, ..twin })
    }

    fn declare(&mut self, line: &str) -> Result<()> {
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        match word {
            "set" if rest.contains('=') => self.settings.push(rest.to_string()),
            "loop" if !rest.is_empty() => {
                let (name, words) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
                self.loops.push(Loop { name: name.into(), words: words.trim().into() });
            }
            _ if word.starts_with('-') && !rest.is_empty() => {
                self.switches.push((word.into(), rest.into()))
            }
            _ => {
                return Err(Error::input("a declaration of the twin is not understood")
                    .at(self.path.display().to_string())
                    .value(format!("//@ {line}"))
                    .remedy(
                        "write `//@ -switch key.of.the.scene`, `//@ set key=value` or `//@ loop \
                         NAME what it does`",
                    ));
            }
        }
        Ok(())
    }

    /// The script.
    pub fn path(&self) -> &Path {
        &self.path
    }
    /// Its text, with that of the files it includes.
    pub(super) fn text(&self) -> &str {
        &self.text
    }
    /// Assignments, each `key=value`, that give a scene the scheme of the twin.
    pub fn settings(&self) -> &[String] {
        &self.settings
    }
    /// The variants of the time loop, one at least; the first is the default.
    pub fn loops(&self) -> &[Loop] {
        &self.loops
    }

    /// The switches with the values that the scene gives them, `-dt` among them.
    ///
    /// # Errors
    /// A switch that stands for a value which the scene does not have, or has as a table or a list.
    pub(super) fn arguments(
        &self,
        scene: &Scene,
        problem: &dyn Problem,
    ) -> Result<Vec<(String, String)>> {
        let scene_values = resolved(scene, problem)?;
        let declared = self.switches.iter().map(|(switch, key)| {
            let value = key.split('.').try_fold(&scene_values, child).and_then(plain);
            let value = value.ok_or_else(|| {
                Error::scene(format!(
                    "the twin takes `{key}` for its switch {switch}, and the scene has no such \
                     value"
                ))
                .at(self.path.display().to_string())
                .value(key)
                .remedy(
                    "compare a scene of the kind that the twin is written for, or name another \
                     twin with --twin",
                )
            })?;
            Ok((switch.clone(), value))
        });
        std::iter::once(Ok(("-dt".to_string(), format!("{:?}", scene.time.step))))
            .chain(declared)
            .collect()
    }
}

/// All values of the scene, with those that the plan decides.
fn resolved(scene: &Scene, problem: &dyn Problem) -> Result<toml::Value> {
    let mut table: toml::Table = toml::from_str(&scene.to_toml())
        .map_err(|e| Error::internal(format!("a resolved scene cannot be read: {e}")))?;
    if let Some(numerics) = table.get_mut("numerics").and_then(toml::Value::as_table_mut) {
        numerics.extend(problem.derived().into_iter().map(|(key, v)| (key.to_string(), v.into())));
    }
    Ok(toml::Value::Table(table))
}

fn child<'a>(value: &'a toml::Value, key: &str) -> Option<&'a toml::Value> {
    match value {
        toml::Value::Table(table) => table.get(key),
        toml::Value::Array(items) => items.get(key.parse::<usize>().ok()?),
        _ => None,
    }
}

/// A value as a word of the command line.
fn plain(value: &toml::Value) -> Option<String> {
    match value {
        toml::Value::Float(v) => Some(format!("{v:?}")),
        toml::Value::Integer(v) => Some(v.to_string()),
        toml::Value::Boolean(v) => Some(u8::from(*v).to_string()),
        toml::Value::String(v) => Some(v.clone()),
        _ => None,
    }
}

/// The text of a script with those of the files that it includes in their places.
fn expanded(path: &Path, depth: usize) -> Result<String> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut out = String::new();
    for line in read_text(path)?.lines() {
        let included =
            line.trim().strip_prefix("include").and_then(|rest| rest.trim().strip_prefix('"'));
        match included.and_then(|rest| rest.split_once('"')) {
            // FreeFEM looks in its own folders too; what is not beside the script is left to it.
            Some((name, _)) if depth > 0 && folder.join(name).exists() => {
                out += &expanded(&folder.join(name), depth - 1)?;
            }
            _ => out += line,
        }
        out.push('\n');
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::problem;

    fn listing() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/listing/scene.toml")
    }

    #[test]
    fn a_twin_says_what_it_takes_and_assumes() {
        let twin = Twin::read(&Twin::beside(&listing())).unwrap();
        let names: Vec<&str> = twin.loops().iter().map(|l| l.name.as_str()).collect();
        assert_eq!(names, ["expert", "listing"]);
        assert!(
            twin.settings().iter().any(|s| s == "numerics.coupling=explicit"),
            "from the included file"
        );
        let scene = Scene::load(&listing(), twin.settings()).unwrap();
        let arguments = twin.arguments(&scene, &*problem(&scene).unwrap()).unwrap();
        let value = |switch: &str| arguments.iter().find(|a| a.0 == switch).unwrap().1.as_str();
        assert_eq!(
            (value("-dt"), value("-lambda"), value("-b"), value("-gd")),
            ("0.005", "1.0", "0.5", "1.0")
        );
        // What the scene leaves open is what the plan decides.
        let scene = scene
            .with(&["numerics.thickness=auto".into(), "numerics.grad_div=auto".into()])
            .unwrap();
        let arguments = twin.arguments(&scene, &*problem(&scene).unwrap()).unwrap();
        let value = |switch: &str| {
            arguments.iter().find(|a| a.0 == switch).unwrap().1.parse::<f64>().unwrap()
        };
        assert!(value("-eps") > 0.1 && value("-gd") > 1.0);
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("twin.edp");
        assert!(Twin::read(&path).unwrap_err().advice().contains("--twin"));
        std::fs::write(&path, "//@ lambda\n").unwrap();
        assert_eq!(Twin::read(&path).unwrap_err().wrong_value(), "//@ lambda");
        std::fs::write(&path, "//@ -k membrane.1.stretch\nreal x = 1;\n").unwrap();
        let twin = Twin::read(&path).unwrap();
        assert_eq!(twin.loops(), [Loop::default()]);
        let scene = Scene::load(&listing(), &[]).unwrap();
        let error = twin.arguments(&scene, &*problem(&scene).unwrap()).unwrap_err();
        assert!(
            error.what().contains("-k") && error.wrong_value() == "membrane.1.stretch",
            "{error}"
        );
    }
}
