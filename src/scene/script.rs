//! The tables of a scene and their source text.

use super::keys::Document;
use super::schema::Tables;
use crate::base::Error;
use std::path::PathBuf;

/// The tables of a scene and their source text, for errors with their position.
#[derive(Clone, Debug)]
pub struct Script {
    pub(super) tables: Tables,
    pub(super) document: Document,
    /// The start that a run which goes on has kept, in place of the run in `initial.from`.
    pub(super) start: Option<PathBuf>,
}

impl std::ops::Deref for Script {
    type Target = Tables;
    fn deref(&self) -> &Tables {
        &self.tables
    }
}

impl Script {
    /// Attaches the position of the value at `keys`, such as `["boundary", "inlet"]`, to an error;
    /// if it is absent, that of the innermost table on its path.
    pub fn blame(&self, keys: &[&str], error: Error) -> Error {
        let placed = self.document.error(&self.document.locate(keys), &keys.join("."), "");
        let error = error.at(placed.place());
        match placed.source_snippet() {
            Some(snippet) => error.snippet(snippet.clone()),
            None => error,
        }
    }
    /// Dimensions of space: 2 or 3, those of the mesh.
    pub fn dimension(&self) -> usize {
        self.tables.mesh.dimension()
    }
}
