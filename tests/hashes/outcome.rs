//! A run of a scene, and what it leaves.

use crate::Result;
use crate::scenes::Case;
use immersa::base::fnv1a;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// How the program ended, and the files of the run folder that must be the same in every run.
#[derive(Clone)]
pub struct Outcome {
    pub code: i32,
    pub said: String,
    pub files: BTreeMap<String, Vec<u8>>,
}

impl Outcome {
    /// Runs a scene in a new folder.
    pub fn of(program: &Path, case: &Case) -> Result<Outcome> {
        let kept = tempfile::tempdir()?;
        let folder = folder_with(case, &kept)?;
        let output = command(program, case, &folder).output()?;
        Outcome::read(&folder.join("run"), &output)
    }

    /// Runs a scene that is stopped after its first steps and resumed; none where every run ended
    /// before.
    pub fn in_parts(program: &Path, case: &Case) -> Result<Option<Outcome>> {
        for _ in 0..5 {
            let kept = tempfile::tempdir()?;
            let folder = folder_with(case, &kept)?;
            let run = folder.join("run");
            let mut child = command(program, case, &folder).stderr(Stdio::null()).spawn()?;
            // Two rows: the start, and one step.
            let rows = || {
                fs::read(run.join("series.csv"))
                    .map_or(0, |s| s.iter().filter(|b| **b == b'\n').count())
            };
            while rows() < 3 && child.try_wait()?.is_none() {
                std::thread::sleep(Duration::from_micros(300));
            }
            Command::new("kill")
                .args(["-INT", &child.id().to_string()])
                .stderr(Stdio::null())
                .status()?;
            if child.wait()?.code() == Some(130) {
                let output = command(program, case, &folder).arg("--resume").output()?;
                return Outcome::read(&run, &output).map(Some);
            }
        }
        Ok(None)
    }

    /// Without the count of factorisations: a run that is resumed factors a matrix that it had.
    pub fn uncounted(mut self) -> Outcome {
        if let Some(summary) = self.files.get_mut("summary.json")
            && let Ok(mut value) = serde_json::from_slice::<Value>(summary)
        {
            value["solves"]["factorisations"] = Value::Null;
            *summary = value.to_string().into_bytes();
        }
        self
    }

    /// A hash of it all.
    pub fn hash(&self) -> u64 {
        let mut bytes = self.said.clone().into_bytes();
        for (name, content) in &self.files {
            bytes.extend(name.as_bytes());
            bytes.extend(fnv1a(content).to_le_bytes());
        }
        fnv1a(&bytes)
    }

    fn read(run: &Path, output: &std::process::Output) -> Result<Outcome> {
        let mut files = BTreeMap::new();
        if run.exists() {
            read_folder(run, "", &mut files)?;
        }
        let folder = run.parent().ok_or("a run in no folder")?.display().to_string();
        let said = String::from_utf8_lossy(&output.stderr).replace(&folder, "FOLDER");
        let fact = |line: &&str| !line.trim_start().starts_with("= remedy");
        let said = said.lines().filter(fact).collect::<Vec<_>>().join("\n");
        Ok(Outcome { code: output.status.code().unwrap_or(-1), said, files })
    }
}

/// A folder with the scene; of a fixed name, which is the title of a scene without one.
fn folder_with(case: &Case, kept: &tempfile::TempDir) -> Result<PathBuf> {
    let folder = kept.path().join("scene");
    fs::create_dir(&folder)?;
    fs::write(folder.join("scene.toml"), &case.text)?;
    Ok(folder)
}

fn command(program: &Path, case: &Case, folder: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(folder).args([
        "run",
        "scene.toml",
        "--out",
        "run",
        "--quiet",
        "--threads",
        "1",
    ]);
    command.args(case.set.iter().flat_map(|change| ["--set", change]));
    command
}

/// The files below a folder. A checkpoint has a version of its own, the mark of a run names its
/// process, the report prints seconds, and
/// charts draw the numbers of the other files.
fn read_folder(folder: &Path, prefix: &str, files: &mut BTreeMap<String, Vec<u8>>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let name = format!("{prefix}{name}");
        if path.is_dir() {
            if !["checkpoint", "charts"].contains(&name.as_str()) {
                read_folder(&path, &format!("{name}/"), files)?;
            }
        } else if name == "summary.json" {
            files.insert(name, timeless(&fs::read(&path)?)?);
        } else if !["report.html", "immersa.run"].contains(&name.as_str()) {
            files.insert(name, fs::read(&path)?);
        }
    }
    Ok(())
}

/// A summary without what depends on the clock, the machine and the version.
fn timeless(json: &[u8]) -> Result<Vec<u8>> {
    let mut value: Value = serde_json::from_slice(json)?;
    for key in ["seconds", "cpu_seconds", "step_seconds", "bandwidth", "version", "sessions"] {
        value.as_object_mut().and_then(|all| all.remove(key));
    }
    Ok(serde_json::to_vec_pretty(&value)?)
}
