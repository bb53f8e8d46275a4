//! Tells the program its version, with the commit: that of the repository of the sources, or the one
//! that cargo writes into a package for a registry.

use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_string())
}

/// The commit of a package; its folder may lie in a repository of something else.
fn packaged() -> Option<String> {
    let about = std::fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let commit = about.split("\"sha1\": \"").nth(1)?.get(..10)?;
    Some(commit.to_string())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={log}");
    }
    let version = env!("CARGO_PKG_VERSION");
    let version = match packaged().or_else(|| git(&["rev-parse", "--short=10", "HEAD"])) {
        Some(commit) => format!("{version} ({commit})"),
        None => version.to_string(),
    };
    println!("cargo::rustc-env=IMMERSA_VERSION={version}");
}
