//! `immersa new`: a commented scene to start from.

use crate::base::{Error, Result};
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub(super) struct Arguments {
    /// Problem of the scene
    case: Template,
    /// The file to write; CASE.toml without it. A file that exists is left alone
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Template {
    /// An elastic membrane that relaxes in a viscous fluid
    Membrane,
    /// A square of fluid driven by its lid
    Cavity,
    /// A flow through a channel, from left to right
    Channel,
}

impl Template {
    fn name(self) -> &'static str {
        match self {
            Template::Membrane => "membrane",
            Template::Cavity => "cavity",
            Template::Channel => "channel",
        }
    }

    fn text(self) -> &'static str {
        match self {
            Template::Membrane => include_str!("cases/membrane.toml"),
            Template::Cavity => include_str!("cases/cavity.toml"),
            Template::Channel => include_str!("cases/channel.toml"),
        }
    }
}

pub(super) fn new(arguments: &Arguments) -> Result<()> {
    let path = arguments
        .out
        .clone()
        .unwrap_or_else(|| PathBuf::from(format!("{}.toml", arguments.case.name())));
    let failed = |e: std::io::Error| {
        Error::input(format!("the scene cannot be written: {e}"))
            .at(path.display().to_string())
            .value(path.display())
            .remedy("name another file with --out; one that exists is never overwritten")
    };
    let mut file = std::fs::File::create_new(&path).map_err(failed)?;
    file.write_all(arguments.case.text().as_bytes()).map_err(failed)?;
    let path = path.display();
    // The file is written; a closed standard output changes nothing about that.
    let _ = writeln!(
        std::io::stdout().lock(),
        "{path} is written; compute it with: immersa run {path}"
    );
    Ok(())
}
