//! The tables of a scene and the text they were read from.

use super::keys::Document;
use super::schema::Tables;
use crate::base::Error;

/// The tables of a scene and the text they were read from, for errors with their place.
#[derive(Clone, Debug)]
pub struct Script {
    pub(super) tables: Tables,
    pub(super) document: Document,
}

impl std::ops::Deref for Script {
    type Target = Tables;
    fn deref(&self) -> &Tables {
        &self.tables
    }
}

impl Script {
    /// Says of an error that it is about the value at `keys`, such as `["boundary", "inlet"]`, or
    /// about the innermost table on the way there that is written.
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
