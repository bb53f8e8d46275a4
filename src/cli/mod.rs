//! The command-line program: commands, messages, exit codes.

mod cases;
mod compare;
mod explain;
mod new;
mod progress;
mod reference;
mod render;
mod report;
mod run;
mod schema;
mod shell;
mod study;

use crate::base::{Error, Kind, Result};
use crate::scene::Scene;
use clap::{Args, Parser, Subcommand};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

/// Structures immersed in a flow: level sets and finite elements on unstructured meshes.
#[derive(Parser)]
#[command(name = "immersa", version = crate::base::VERSION, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 done, 1 a defect of immersa, 2 the command line or the scene is \
        wrong, 3 the mesh or another file is wrong, 4 the computation failed, 130 interrupted \
        (continue with --resume)."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Compute a scene
    Run(run::Arguments),
    /// Say what a scene solves and what it leaves out, without computing it
    Explain(explain::Arguments),
    /// Make pictures, a film, charts and the report of finished runs
    Render(render::Arguments),
    /// Write a commented scene to start from
    New(new::Arguments),
    /// Compute a scene many times, to learn what its numbers are worth
    #[command(subcommand)]
    Study(study::Study),
    /// Compute a scene here and in FreeFEM: differences and times
    Compare(compare::Arguments),
    /// Print what may stand in a scene: keys, values, units, defaults
    Reference(reference::Arguments),
    /// Print the scene format as a JSON Schema, by which editors complete and check scenes
    Schema,
    /// Print the completions of a shell
    Completions(shell::Completions),
    /// Print the manual page, or write the pages of all commands
    Man(shell::Man),
}

/// A scene and changes to it.
#[derive(Args)]
struct SceneArguments {
    /// The scene file
    scene: PathBuf,
    #[command(flatten)]
    overrides: Overrides,
}

/// Changes to a scene.
#[derive(Args)]
struct Overrides {
    /// Set one value of the scene, as in --set time.step=1e-3 or --set membrane.0.stretch=1.1
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl SceneArguments {
    /// The scene, every value checked, with all files it names at hand.
    fn load(&self) -> Result<Scene> {
        self.load_after(&[])
    }
    /// The same with values set before those of the command line.
    fn load_after(&self, settings: &[String]) -> Result<Scene> {
        let scene = Scene::load(&self.scene, &[settings, &self.overrides.set].concat())?;
        scene.check_files()?;
        Ok(scene)
    }
    /// The scene file.
    fn path(&self) -> &Path {
        &self.scene
    }
}

/// Runs the program on the arguments of the process; the result is its exit code.
pub fn main() -> ExitCode {
    std::panic::set_hook(Box::new(report::defect));
    ExitCode::from(guarded(|| match Cli::try_parse() {
        Ok(cli) => match dispatch(cli.command) {
            Ok(()) => 0,
            Err(e) => report::error(&e),
        },
        Err(e) => report::usage(&e),
    }))
}

fn dispatch(command: Command) -> Result<()> {
    match command {
        Command::Run(a) => run::run(&a),
        Command::Explain(a) => explain::explain(&a),
        Command::Render(a) => render::render(&a),
        Command::New(a) => new::new(&a),
        Command::Study(s) => study::study(&s),
        Command::Compare(a) => compare::compare(&a),
        Command::Reference(a) => reference::reference(&a),
        Command::Schema => schema::schema(),
        Command::Completions(a) => shell::completions(&a),
        Command::Man(a) => shell::man(&a),
    }
}

/// Prints a text on standard output. A closed pipe is no reason to fail, a full disk is one.
///
/// # Errors
/// The text cannot be written.
fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::input("the output cannot be written")
                .at("standard output")
                .value(e)
                .remedy("free space on the disk it goes to"))
        }
        _ => Ok(()),
    }
}

/// A flag that Ctrl-C, SIGTERM and SIGHUP set; when one comes again the program ends at once, the
/// last checkpoint being still there.
fn stop_on_interrupt() -> &'static AtomicBool {
    static STOP: AtomicBool = AtomicBool::new(false);
    // Without a handler Ctrl-C ends the program at once, too.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(Kind::Interrupted.exit_code().into());
        }
    });
    &STOP
}

/// Largest number of threads that is taken for meant.
const MOST_THREADS: usize = 256;

fn set_threads(threads: Option<std::num::NonZeroUsize>) -> Result<()> {
    let Some(n) = threads else { return Ok(()) };
    if n.get() > MOST_THREADS {
        return Err(Error::scene("so many threads would only wait for each other")
            .at("--threads")
            .value(n)
            .remedy(format!("give at most {MOST_THREADS}, and not more than there are cores")));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n.get()).build_global();
    pool.map_err(|e| {
        Error::scene(format!("{n} threads cannot be started: {e}"))
            .at("--threads")
            .value(n)
            .remedy("give fewer")
    })
}

/// The exit code of `work`, also when it panics: that is a defect of the program.
fn guarded(work: impl FnOnce() -> u8 + std::panic::UnwindSafe) -> u8 {
    std::panic::catch_unwind(work).unwrap_or(Error::internal("").kind().exit_code())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn a_panic_becomes_exit_code_1() {
        assert_eq!(guarded(|| [1u8, 2][std::hint::black_box(2)]), 1);
        assert_eq!(guarded(|| 4), 4);
    }
}
