//! Scenes: what a run shall do, read from TOML with every value checked and every error placed.

mod adapt;
mod checks;
mod diagnostics;
mod dimension;
mod document;
mod drops;
mod errors;
pub mod expression;
mod geometry;
mod image;
mod item;
mod model;
pub(crate) mod nearest;
mod overrides;
mod pacing;
mod passive;
mod plan;
mod redistance;
pub mod reference;
mod refined;
pub mod render;
pub mod run;
pub mod schema;
mod sheared;
mod survey;
#[cfg(test)]
mod tests;

pub use diagnostics::Diagnostics;
pub use dimension::{Dimension, In};
pub use expression::{Expression, ExpressionError};
pub use model::Model;
pub use schema::Settings;
pub use survey::{Survey, explain};

use crate::base::{Error, Result, Snippet};
use document::Document;
use item::Item;
use std::path::{Path, PathBuf};

/// A scene and where it was written.
///
/// Gives access to its [`Settings`]. Scenes are equal when their settings are.
#[derive(Clone, Debug)]
pub struct Scene {
    settings: Settings,
    path: PathBuf,
    document: Document,
}

impl std::ops::Deref for Scene {
    type Target = Settings;
    fn deref(&self) -> &Settings {
        &self.settings
    }
}

impl PartialEq for Scene {
    fn eq(&self, other: &Scene) -> bool {
        self.settings == other.settings
    }
}

impl Scene {
    /// Reads a scene from the `text` of the file `path`, which itself is not opened.
    ///
    /// Errors: of kind [`Scene`](crate::base::Kind::Scene), about the first thing that is wrong, with its place in the
    /// text.
    pub fn parse(text: &str, path: &Path) -> Result<Scene> {
        Scene::parse_with(text, path, &[])
    }

    /// Reads a scene and sets single values of it, each override written `key.sub=value`.
    ///
    /// The value is TOML, or else taken as text; `membrane.0.stretch` is the stretch of the first membrane.
    pub fn parse_with(text: &str, path: &Path, overrides: &[String]) -> Result<Scene> {
        Scene::read(Document::parse(text, &path.display().to_string())?, path, overrides)
    }

    /// The scene with single values of it set, each override written `key.sub=value`.
    ///
    /// Errors: as for [`parse_with`](Scene::parse_with).
    pub fn with(&self, overrides: &[String]) -> Result<Scene> {
        Scene::read(self.document.clone(), &self.path, overrides)
    }

    fn read(mut document: Document, path: &Path, overrides: &[String]) -> Result<Scene> {
        for text in overrides {
            overrides::apply(&mut document, text)?;
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let settings = Settings::read(&Item::root(&document), folder, &scene_name(path))?;
        Ok(Scene { settings, path: path.to_path_buf(), document })
    }

    /// Reads the scene file `path` and sets single values of it.
    ///
    /// Errors: as for [`parse_with`](Scene::parse_with); a file that cannot be read or is not UTF-8 is a wrong scene too.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Scene> {
        let bytes = std::fs::read(path).map_err(|e| {
            Error::scene(format!("the scene cannot be read: {e}"))
                .at(path.display().to_string())
                .value(path.display())
                .remedy("give the path of a scene file (.toml), or make one with `immersa new`")
        })?;
        let text = String::from_utf8(bytes).map_err(|e| not_utf8(path, &e))?;
        Scene::parse_with(&text, path, overrides)
    }

    /// The scene as TOML with every default written out; parses to an equal scene wherever it is kept.
    pub fn to_toml(&self) -> String {
        self.settings.write()
    }

    /// The name of the scene in the file system: that of its file, or of its folder when the file is `scene.toml`.
    pub fn name(&self) -> String {
        scene_name(&self.path)
    }

    /// The file the scene was read from, as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Dimensions of space: 2 or 3, those of the mesh.
    pub fn dimension(&self) -> usize {
        self.mesh.dimension()
    }

    /// Checks that the files the scene names can be read. Errors: of kind [`Input`](crate::base::Kind::Input).
    pub fn check_files(&self) -> Result<()> {
        self.mesh.check_readable().map_err(|e| self.blame(&["mesh", "file"], e))
    }

    /// Says of an error that it is about the value at `keys`, such as `["boundary", "inlet"]`, or about the innermost
    /// table on the way there that is written.
    pub fn blame(&self, keys: &[&str], error: Error) -> Error {
        let placed = self.document.error(&self.document.locate(keys), &keys.join("."), "");
        let error = error.at(placed.place());
        match placed.source_snippet() {
            Some(snippet) => error.snippet(snippet.clone()),
            None => error,
        }
    }
}

fn scene_name(path: &Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let folder = path.parent().and_then(Path::file_name).filter(|_| path.ends_with("scene.toml"));
    let name = folder.or(path.file_stem()).map(|n| n.to_string_lossy().into_owned());
    name.unwrap_or_else(|| "scene".to_string())
}

fn not_utf8(path: &Path, error: &std::string::FromUtf8Error) -> Error {
    let valid = error.utf8_error().valid_up_to();
    let byte = error.as_bytes().get(valid).copied().unwrap_or(0);
    let text = String::from_utf8_lossy(error.as_bytes().get(..valid).unwrap_or(&[])).into_owned();
    let snippet = Snippet { path: path.display().to_string(), source: text, span: valid..valid };
    let (line, column) = snippet.line_column();
    Error::scene("the scene is not text in UTF-8")
        .at(format!("{}:{line}:{column}", path.display()))
        .value(format!("byte 0x{byte:02x}"))
        .remedy("give a scene file (.toml), saved as UTF-8")
}
