//! What computed a run: a process, and each one that went on with it.

use serde::{Deserialize, Serialize};
use std::time::SystemTime;

/// A process that computed a run, or a part of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Session {
    /// When it began, in UTC: `2026-01-31T12:00:00Z`.
    pub started: String,
    /// When it ended, or last kept its state; empty before it did.
    pub ended: String,
    /// Version of the program, with the commit where that is known.
    pub version: String,
    /// The command.
    pub command: String,
    /// Threads, processor and system.
    pub machine: String,
}

impl Session {
    /// The session of this process, which begins now.
    pub(super) fn begin(command: &str) -> Session {
        Session {
            started: now(),
            ended: String::new(),
            version: crate::base::VERSION.into(),
            command: command.into(),
            machine: format!("{} threads on {}", rayon::current_num_threads(), machine()),
        }
    }
}

/// The time, in UTC.
pub(super) fn now() -> String {
    humantime::format_rfc3339_seconds(SystemTime::now()).to_string()
}

/// The machine in words.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(0, std::num::NonZero::get);
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = info.lines().find_map(|l| l.strip_prefix("model name")?.split_once(": "));
    let processor = name.map_or(std::env::consts::ARCH, |(_, name)| name);
    format!("{cores} cores, {processor}, {}", std::env::consts::OS)
}
