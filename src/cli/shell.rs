//! `immersa completions` and `immersa man`: the commands for shells and manuals.

use super::{Cli, print};
use crate::base::{Error, Result};
use clap::CommandFactory;
use std::path::PathBuf;

#[derive(clap::Args)]
pub(super) struct Completions {
    /// The shell
    shell: clap_complete::Shell,
}

pub(super) fn completions(arguments: &Completions) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "immersa", &mut script);
    print(&String::from_utf8_lossy(&script))
}

#[derive(clap::Args)]
pub(super) struct Man {
    /// A folder for the pages of all commands, immersa.1, immersa-run.1, ...; without it, the page of
    /// the program is printed
    folder: Option<PathBuf>,
}

pub(super) fn man(arguments: &Man) -> Result<()> {
    let mut command = Cli::command().disable_help_subcommand(true);
    let Some(folder) = &arguments.folder else {
        let mut page = Vec::new();
        let made = clap_mangen::Man::new(command).render(&mut page);
        made.map_err(|e| Error::internal(format!("the manual cannot be made: {e}")))?;
        return print(&String::from_utf8_lossy(&page));
    };
    command.build();
    let written =
        std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(command, folder));
    written.map_err(|e| {
        Error::input(format!("the manual cannot be written: {e}"))
            .at(folder.display().to_string())
            .value(folder.display())
            .remedy("name a folder that can be written, such as ~/.local/share/man/man1")
    })
}
