//! The program as a user starts it, and what it leaves in a run folder.

use immersa::output::Series;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A membrane in a box whose lid begins to move: small, but with every kind of output except
/// pictures.
pub const SCENE: &str = r#"title = "A membrane under a lid"
[mesh]
rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16], diagonals = "union-jack" }
[fluid]
viscosity = 0.01
[boundary.walls]
no_slip = true
[boundary.top]
velocity = ["0.2 * t * sin(pi * x / 2)", 0]
[[membrane]]
shape.ellipse = { centre = [1, 1], semi_axes = [0.55, 0.4] }
stretch = 1.2
area.linear = { modulus = 1 }
[membrane.chords]
horizontal = { through = [1, 1], direction = [1, 0] }
[time]
end = 0.4
step = 0.01
[numerics]
thickness = 0.2
[output]
every = 0.01
fields = 0.01
pictures = false
checkpoint = 0
probes.middle = { at = [1.1, 0.9], of = "velocity" }
forces.lid = { boundary = "top" }
fluxes.side = { boundary = "left" }
[output.profiles]
pressure = { from = [0, 1], to = [2, 1], of = "pressure", points = 20, times = [0.05, 0.2, 0.4] }
"#;

/// How the program ended, and what it said.
pub struct Ended {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    fn of(output: Output) -> Ended {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        // A signal gives no code.
        let code = output.status.code().unwrap_or(-1);
        Ended { code, stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// The exit code is `code` and the message contains all the words.
    pub fn expect(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "{}", self.stderr);
        for word in words {
            assert!(self.stderr.contains(word), "`{word}` is missing in\n{}", self.stderr);
        }
    }
}

/// A new folder with the file `scene.toml`.
pub fn folder_with(scene: &(impl AsRef<[u8]> + ?Sized)) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), scene).unwrap();
    folder
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_immersa"));
    command.current_dir(folder).args(arguments);
    command
}

/// Runs `immersa ARGUMENTS` in a folder.
pub fn immersa(folder: &Path, arguments: &[&str]) -> Ended {
    Ended::of(command(folder, arguments).output().unwrap())
}

/// The same with a limit on the size of files, in blocks of 512 bytes, that is an error as on a
/// full disk.
pub fn immersa_within(folder: &Path, blocks: u64, arguments: &[&str]) -> Ended {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command
        .current_dir(folder)
        .args(["-c", &script, env!("CARGO_BIN_EXE_immersa")])
        .args(arguments);
    Ended::of(command.output().unwrap())
}

/// Starts `immersa ARGUMENTS` in a folder.
pub fn start(folder: &Path, arguments: &[&str]) -> Child {
    command(folder, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits for the end of a program that was started.
pub fn wait(child: Child) -> Ended {
    Ended::of(child.wait_with_output().unwrap())
}

/// Sends the signal of Ctrl-C.
pub fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Waits until `ready` holds or the program ended.
pub fn wait_until(child: &mut Child, ready: impl Fn() -> bool) {
    let start = Instant::now();
    while !ready() && child.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < Duration::from_secs(60), "the program hangs");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Goes on with the run `out` of `scene.toml`.
pub fn resume(folder: &Path, out: &str) -> Ended {
    immersa(folder, &["run", "scene.toml", "--resume", "--out", out])
}

/// Interrupts runs of the scene with Ctrl-C until one of them had not ended before the signal came,
/// at about row `row`.
pub fn interrupted(folder: &Path, out: &str, row: usize) -> Ended {
    for _ in 0..10 {
        let run = folder.join(out);
        let mut child = start(folder, &["run", "scene.toml", "--out", out]);
        // Once there is a folder, Ctrl-C is heard.
        wait_until(&mut child, || run.join("scene.toml").exists() && rows(&run) >= row);
        interrupt(&child);
        let ended = wait(child);
        if ended.code != 0 {
            return ended;
        }
        fs::remove_dir_all(run).unwrap();
    }
    panic!("every run ended before it was interrupted");
}

/// Runs `scene.toml` of a folder at once, and again with an interruption after the first step from
/// which it goes on; both must end with the words `done`. The two run folders.
pub fn run_whole_and_in_parts(folder: &Path, done: &str) -> [PathBuf; 2] {
    immersa(folder, &["run", "scene.toml", "--out", "whole"]).expect(0, &[done]);
    interrupted(folder, "parts", 2).expect(130, &["interrupted", "--resume"]);
    resume(folder, "parts").expect(0, &[done]);
    ["whole", "parts"].map(|out| folder.join(out))
}

/// Rows of the series of a run folder, its header not counted; 0 before there is one.
pub fn rows(run: &Path) -> usize {
    fs::read(run.join("series.csv"))
        .map_or(0, |s| s.iter().filter(|b| **b == b'\n').count().saturating_sub(1))
}

/// Files that say who ran, and when.
const OF_PROCESS: [&str; 3] = ["immersa.run", "log.txt", "checkpoint/earlier.bin"];

/// All files below a folder by their path in it, except those of the process.
pub fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_str().unwrap().to_string();
                if !OF_PROCESS.contains(&&*name) {
                    all.insert(name, fs::read(path).unwrap());
                }
            }
        }
    }
    all
}

/// The series of a run.
pub fn series(run: &Path) -> Series {
    Series::read(&run.join("series.csv")).unwrap()
}

/// The summary of a run.
pub fn summary(run: &Path) -> Value {
    serde_json::from_slice(&fs::read(run.join("summary.json")).unwrap()).unwrap()
}

/// Two run folders hold the same files with the same bytes, apart from the seconds that the runs
/// took and the processes that computed them.
pub fn assert_same(a: &Path, b: &Path) {
    let (first, second) = (files(a), files(b));
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&first), names(&second));
    for (name, content) in &first {
        match name.as_str() {
            "summary.json" => assert_eq!(timeless(content), timeless(&second[name])),
            "checkpoint/latest.bin" => assert_eq!(checkpoint(content), checkpoint(&second[name])),
            // It prints the seconds; all else in it comes from the other files.
            "report.html" => {}
            _ => assert!(
                *content == second[name],
                "{name} differs in {} and {}",
                a.display(),
                b.display()
            ),
        }
    }
}

fn timeless(json: &[u8]) -> Value {
    let mut value: Value = serde_json::from_slice(json).unwrap();
    let all = value.as_object_mut().unwrap();
    let removed = ["seconds", "cpu_seconds", "step_seconds", "sessions"].map(|key| all.remove(key));
    assert!(removed.iter().all(Option::is_some));
    // In the summary alone, and measured too.
    all.remove("bandwidth");
    value
}

/// The record without its seconds, and the bytes of the state.
fn checkpoint(bytes: &[u8]) -> (Value, Vec<u8>) {
    let size = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let (record, state) = bytes[16..].split_at(size);
    (timeless(record), state.to_vec())
}
