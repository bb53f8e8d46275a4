//! `immersa study phases`.

use super::Common;
use crate::base::{Error, Result};
use crate::studies::{Axis, Phases};

/// What the structures of a scene do over one or more parameters: a phase diagram.
#[derive(clap::Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Values of a key, as in --vary vesicle.0.viscosity=1,4,8; those of the first are columns
    #[arg(long, value_name = "KEY=V1,V2")]
    vary: Vec<String>,
}

impl Arguments {
    pub(super) fn conduct(&self) -> Result<()> {
        if self.vary.is_empty() {
            return Err(Error::scene("a phase diagram needs parameters")
                .at("--vary")
                .remedy("name one or two: --vary vesicle.0.viscosity=1,4,8"));
        }
        let axes =
            self.vary.iter().map(|t| Axis::parse(t, "--vary")).collect::<Result<Vec<_>>>()?;
        self.common.conduct("phases", |campaign| Phases { axes }.conduct(campaign))
    }
}
