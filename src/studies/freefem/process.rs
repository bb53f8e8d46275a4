//! The process of FreeFEM: its start, its end, and the reason of a failure.

use crate::base::{Error, Result};
use crate::output::write_file;
use std::fs::File;
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// File in the folder of a run with the reason of its failure.
pub(super) const FAILED: &str = "failed.txt";
/// Lines of its output that an error shows.
const SHOWN: usize = 8;

/// Runs a command; the result is its output, `None` if the program is not there.
pub(super) fn execute(
    mut command: Command,
    folder: &Path,
    script: &Path,
    stop: &AtomicBool,
) -> Result<Option<String>> {
    let path = folder.join("log.txt");
    let broken = |e: std::io::Error| {
        Error::input("FreeFEM cannot be run").at(script.display().to_string()).value(e)
    };
    let log = File::create(&path).map_err(broken)?;
    command.stdout(log.try_clone().map_err(broken)?).stderr(log).stdin(std::process::Stdio::null());
    let status = match command.spawn() {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        started => started.and_then(|child| wait(child, stop)).map_err(broken)?,
    };
    if stop.load(Ordering::Relaxed) {
        return Err(Error::interrupted(
            "the study was interrupted while FreeFEM ran; all runs that ended are kept",
        )
        .remedy("start the same command again: it goes on from here"));
    }
    let text = String::from_utf8_lossy(&std::fs::read(&path).map_err(broken)?).into_owned();
    if status.success() {
        return Ok(Some(text));
    }
    let reason = format!(
        "{status}; see {}; by hand: {}; its last words: {}",
        path.display(),
        words(&command),
        tail(&text)
    );
    // Kept like a result: the same script with the same values would fail again.
    write_file(&folder.join(FAILED), reason.as_bytes())?;
    Err(failure(script, reason))
}

pub(super) fn failure(script: &Path, reason: String) -> Error {
    Error::computation("FreeFEM failed")
        .at(script.display().to_string())
        .value(reason)
        .remedy("mend the script, or take a smaller time.step: explicit coupling has a limit")
}

/// Waits for the end of a program, or ends it when `stop` is set.
fn wait(mut child: Child, stop: &AtomicBool) -> std::io::Result<ExitStatus> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if stop.load(Ordering::Relaxed) {
            // It may have ended by itself, Ctrl-C being for both.
            let _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn words(command: &Command) -> String {
    let all = std::iter::once(command.get_program()).chain(command.get_args());
    all.map(|w| w.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

/// The last lines of a text.
pub(super) fn tail(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    if lines.is_empty() {
        "none".into()
    } else {
        format!("\n{}", lines[lines.len().saturating_sub(SHOWN)..].join("\n"))
    }
}
