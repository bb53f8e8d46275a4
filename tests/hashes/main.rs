//! All scenes of the repository, shortened, by this program and by an older one: nothing may
//! differ.
//!
//! `cargo test --release --test hashes -- [COMMIT]`; `--help` has the options.

mod difference;
mod outcome;
mod scenes;
mod shorten;

use clap::Parser;
use immersa::base::fnv1a;
use outcome::Outcome;
use rayon::prelude::*;
use scenes::Case;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Runs all scenes of the repository, shortened, with two programs and compares what they leave.
#[derive(Parser)]
struct Arguments {
    /// The commit whose program is compared with.
    #[arg(default_value = "HEAD")]
    commit: String,
    /// A program to compare with, in place of one built from a commit.
    #[arg(long, value_name = "PATH", conflicts_with = "commit")]
    program: Option<PathBuf>,
    /// The program under test, in place of the one built with this test.
    #[arg(long, value_name = "PATH", default_value = env!("CARGO_BIN_EXE_immersa"))]
    this: PathBuf,
    /// Only scenes whose name contains this.
    #[arg(long, value_name = "NAME", default_value = "")]
    only: String,
    /// A line for every scene: how it ended, the hash of what it left, its name.
    #[arg(long)]
    print: bool,
}

/// How two runs of a scene compare.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Same,
    RefusedByBoth,
    Differ,
    RefusedByOne,
}

impl Verdict {
    fn is_good(self) -> bool {
        matches!(self, Verdict::Same | Verdict::RefusedByBoth)
    }
    fn words(self) -> &'static str {
        match self {
            Verdict::Same => "same",
            Verdict::Differ => "differ",
            Verdict::RefusedByBoth => "refused by both",
            Verdict::RefusedByOne => "refused by one",
        }
    }
}

/// A scene that was run by both programs.
struct Compared {
    name: String,
    verdict: Verdict,
    hash: u64,
    differences: Vec<String>,
    /// Stopped and resumed by this program; none where no run was stopped before its end.
    resumed: Option<Vec<String>>,
}

fn main() -> ExitCode {
    match compare_all(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(e) => {
            say(&format!("error: {e}"));
            ExitCode::from(2)
        }
    }
}

#[allow(clippy::print_stdout, reason = "the result of the command")]
fn say(line: &str) {
    println!("{line}");
}

/// Compares the programs on all scenes; true where nothing differs.
fn compare_all(arguments: &Arguments) -> Result<bool> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let this = arguments.this.canonicalize()?;
    let that = match &arguments.program {
        Some(program) => program.canonicalize()?,
        None => built(root, &arguments.commit)?,
    };
    let mut cases = scenes::all(root)?;
    let all = cases.len();
    cases.retain(|case| case.name.contains(&arguments.only));
    say(&format!("{} of {all} scenes, {} against {}", cases.len(), this.display(), that.display()));
    let mut good = same_reference(&this, &that)?;
    let (mut counts, mut resumed) = (BTreeMap::new(), 0);
    // In portions: lines come in a fixed order and before the last scene has run.
    for portion in cases.chunks(32) {
        let compared =
            portion.par_iter().map(|case| compare(case, &this, &that).map_err(|e| e.to_string()));
        for result in compared.collect::<Vec<_>>() {
            let result = result?;
            *counts.entry(result.verdict).or_insert(0) += 1;
            resumed += usize::from(result.resumed.is_some());
            good &= report(&result, arguments.print);
        }
    }
    let counts = [Verdict::Same, Verdict::Differ, Verdict::RefusedByBoth, Verdict::RefusedByOne]
        .map(|v| format!("{} {}", counts.get(&v).unwrap_or(&0), v.words()));
    say(&format!("{}; {resumed} were stopped and resumed", counts.join(", ")));
    Ok(good)
}

/// Prints what there is to say of a scene; true where nothing differs.
fn report(compared: &Compared, print: bool) -> bool {
    let Compared { name, verdict, hash, differences, resumed } = compared;
    let after_stop = resumed.iter().flatten().map(|line| format!("after --resume: {line}"));
    let lines: Vec<String> = differences.iter().cloned().chain(after_stop).collect();
    if print || !lines.is_empty() {
        let told = lines.first().map_or(String::new(), |line| format!(": {line}"));
        let more = if lines.len() > 1 {
            format!(" (and {} more)", lines.len() - 1)
        } else {
            String::new()
        };
        say(&format!("{:<15} {hash:016x} {name}{told}{more}", verdict.words()));
    }
    verdict.is_good() && lines.is_empty()
}

fn compare(case: &Case, this: &Path, that: &Path) -> Result<Compared> {
    let [mine, theirs] = [this, that].map(|program| Outcome::of(program, case));
    let (mine, theirs) = (mine?, theirs?);
    let differences = difference::between(&mine, &theirs);
    let verdict = match (mine.code == 0, theirs.code == 0) {
        (true, false) | (false, true) => Verdict::RefusedByOne,
        _ if !differences.is_empty() => Verdict::Differ,
        (true, true) => Verdict::Same,
        (false, false) => Verdict::RefusedByBoth,
    };
    let stopped =
        if case.resumes && mine.code == 0 { Outcome::in_parts(this, case)? } else { None };
    let resumed =
        stopped.map(|parts| difference::between(&parts.uncounted(), &mine.clone().uncounted()));
    Ok(Compared { name: case.name.clone(), verdict, hash: mine.hash(), differences, resumed })
}

/// Compares what the programs say may stand in a scene.
fn same_reference(this: &Path, that: &Path) -> Result<bool> {
    let print = |program: &Path| Command::new(program).arg("reference").output().map(|o| o.stdout);
    let (mine, theirs) = (print(this)?, print(that)?);
    let found = difference::in_file("reference", &mine, &theirs);
    let (words, told) = match &found {
        Some(line) => ("differ", format!(": {line}")),
        None => ("same", String::new()),
    };
    say(&format!("{words:<15} {:016x} immersa reference{told}", fnv1a(&mine)));
    Ok(found.is_none())
}

/// The program of a commit, built once and kept in `target/hashes`.
fn built(root: &Path, commit: &str) -> Result<PathBuf> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").current_dir(root).args(arguments).output()?;
        if output.status.success() {
            return Ok(String::from_utf8(output.stdout)?.trim().to_owned());
        }
        Err(Box::<dyn Error>::from(String::from_utf8_lossy(&output.stderr).trim().to_owned()))
    };
    let id = git(&["rev-parse", "--verify", &format!("{commit}^{{commit}}")])?;
    let kept = root.join("target/hashes");
    let program = kept.join(&id).join("immersa");
    if program.exists() {
        return Ok(program);
    }
    say(&format!("building the program of {id}"));
    let tree = kept.join(&id).join("tree");
    let path = tree.to_str().ok_or("the path of the repository is not UTF-8")?;
    git(&["worktree", "prune"])?;
    if !tree.exists() {
        git(&["worktree", "add", "--detach", path, &id])?;
    }
    // Dependencies are built once for all commits.
    let build = kept.join("build");
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["build", "--release", "--bin", "immersa", "--target-dir"]).arg(&build);
    if !cargo.current_dir(&tree).status()?.success() {
        return Err(format!("{id} cannot be built").into());
    }
    std::fs::copy(build.join("release/immersa"), &program)?;
    git(&["worktree", "remove", "--force", path])?;
    Ok(program)
}
