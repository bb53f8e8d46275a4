//! `[initial]`: a flow that starts from an earlier run.

use super::fluid::Fluid;
use super::mesh::absolute;
use crate::base::Result;
use crate::scene::keys::{
    Context, Form, Item, Kind, NonNegative, Opt, Table, Tabled, kinds, table,
};
use std::path::PathBuf;

table! {
    /// The flow of an earlier run as the start of this one, in place of `fluid.initial_velocity`:
    /// its velocity and its pressure, on the same mesh as they are, on another one interpolated.
    /// The time begins at 0 again, and all structures start as this scene says.
    Initial {
        /// The folder of that run, relative to the folder of the scene.
        from: PathBuf [Folder, Required("name the folder of a run: from = \"runs/steady\"")],
        /// A time of that run whose fields it has stored.
        time: Option<f64> [Opt<NonNegative>, "s", Derived("its end, if it has finished")],
    }
}

kinds! {
    /// A folder, as an absolute path.
    Folder: PathBuf = Kind::Value("path", Form::Text), folder;
}

fn folder(item: &Item, context: &Context) -> Result<PathBuf> {
    match item.text()? {
        "" => Err(item
            .error("the name of the folder is empty")
            .remedy("name the folder of a run: from = \"runs/steady\"")),
        name => Ok(absolute(&context.folder.join(name))),
    }
}

impl Initial {
    /// Reads the start of a scene with this fluid.
    pub(in crate::scene) fn read_for(
        scene: &Table<'_>,
        fluid: &Fluid,
        context: &Context,
    ) -> Result<Option<Initial>> {
        let Some(item) = scene.get("initial") else { return Ok(None) };
        if fluid.is_prescribed() {
            return Err(item
                .key_error(
                    "the velocity is prescribed, and there is no flow that could start from \
                     another run",
                )
                .remedy("leave initial out, or give a viscosity in place of prescribed_velocity"));
        }
        let table = scene.get("fluid").map(|i| i.open_table()).transpose()?;
        if let Some(given) = table.and_then(|t| t.get("initial_velocity")) {
            return Err(given
                .key_error("the velocity at time 0 is that of the run in `initial.from`")
                .remedy("keep one of the two: leave out fluid.initial_velocity, or [initial]"));
        }
        Initial::read(&item, context).map(Some)
    }
}
