//! Scenes: descriptions of a run, read from TOML with all values checked and errors with their
//! position.

mod adapt;
mod charts;
mod checks;
mod cuts;
mod errors;
mod explanation;
pub mod expression;
mod geometry;
mod images;
mod initial;
mod json_schema;
mod kept;
pub mod keys;
mod measure;
mod meshing;
mod nearest;
mod overrides;
mod pacing;
mod period;
mod placing;
mod plan;
mod points;
mod problem;
pub mod problems;
mod read;
mod redistance;
pub mod reference;
mod refined;
mod remedies;
pub mod render;
mod row;
pub mod run;
pub mod schema;
mod script;
mod shapes;
mod sides;
mod site;
mod start;
pub mod structures;
#[cfg(test)]
pub(crate) mod tests;
mod view;
mod words;

pub use explanation::{Explanation, explain};
pub use expression::{Expression, ExpressionError};
pub use json_schema::json_schema;
pub use plan::Plan;
pub use problem::{Advice, ElasticWave, Facts, Limits, Moment, Problem, ProfileColumn};
pub use problems::{Advected, ImmersedFlow, Segmented, problem};
pub use read::KEYS;
pub use row::Row;
pub use script::Script;
pub use structures::{StructureKind, Traits};

use crate::base::{Error, Result, Snippet};
use crate::flow::Fluid;
use crate::sim::ConvectionScheme;
use keys::{Document, Item};
use std::path::{Path, PathBuf};

/// Reynolds number of the domain above which a flow without structures is convected implicitly.
pub(in crate::scene) const CONVECTED: f64 = 10.0;

/// A scene: its tables, its structures and its source text.
///
/// Dereferences to its [`Script`]. Scenes are equal if their tables and structures are equal.
///
/// # Examples
/// ```
/// use immersa::scene::{Scene, problem};
/// use std::path::Path;
///
/// let text = r#"
/// mesh.rectangle = { min = [0, 0], max = [2, 2], cells = [16, 16] }
/// fluid = { density = 1.0, viscosity = 0.1 }
/// [[membrane]]
/// name = "skin"
/// shape.circle = { centre = [1, 1], radius = 0.4 }
/// area.linear = { modulus = 1.0 }
/// [time]
/// end = 0.1
/// step = 0.05
/// "#;
/// let scene = Scene::parse_with(text, Path::new("scene.toml"), &["time.step=0.1".into()])?;
/// assert_eq!(scene.structures()[0].name(), "skin");
/// let mut problem = problem(&scene)?;
/// problem.step()?;
/// assert_eq!(problem.moment().time, 0.1);
/// # Ok::<(), immersa::base::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    script: Script,
    structures: Vec<Box<dyn StructureKind>>,
    path: PathBuf,
}

impl std::ops::Deref for Scene {
    type Target = Script;
    fn deref(&self) -> &Script {
        &self.script
    }
}

impl PartialEq for Scene {
    fn eq(&self, other: &Scene) -> bool {
        self.script.tables == other.script.tables && self.structures == other.structures
    }
}

impl Scene {
    /// Reads a scene from the `text` of the file `path`, which is not opened.
    ///
    /// # Errors
    /// Of kind [`Scene`](crate::base::Kind::Scene), for the first invalid value, with its position
    /// in the text.
    pub fn parse(text: &str, path: &Path) -> Result<Scene> {
        Scene::parse_with(text, path, &[])
    }

    /// Reads a scene and overrides single values; each override has the form `key.sub=value`.
    ///
    /// The value is parsed as TOML, or else taken as text; `membrane.0.stretch` is the stretch of
    /// the first membrane.
    ///
    /// # Errors
    /// As for [`parse`](Scene::parse).
    pub fn parse_with(text: &str, path: &Path, overrides: &[String]) -> Result<Scene> {
        Scene::read(Document::parse(text, &path.display().to_string())?, path, overrides)
    }

    /// Returns the scene with single values overridden; each override has the form `key.sub=value`.
    ///
    /// # Errors
    /// As for [`parse_with`](Scene::parse_with).
    pub fn with(&self, overrides: &[String]) -> Result<Scene> {
        Scene::read(self.script.document.clone(), &self.path, overrides)
    }

    fn read(mut document: Document, path: &Path, overrides: &[String]) -> Result<Scene> {
        for text in overrides {
            overrides::apply(&mut document, text)?;
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let (tables, structures) = read::read(&Item::root(&document), folder, &scene_name(path))?;
        Ok(Scene {
            script: Script { tables, document, start: None },
            structures,
            path: path.to_path_buf(),
        })
    }

    /// Reads the scene file `path` and overrides single values.
    ///
    /// # Errors
    /// As for [`parse_with`](Scene::parse_with). A file that cannot be read or is not UTF-8 is also
    /// an error of kind `Scene`.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Scene> {
        let bytes = crate::base::read_plain(path).map_err(|e| {
            Error::scene(format!("the scene cannot be read: {e}"))
                .at(path.display().to_string())
                .value(path.display())
                .remedy("give the path of a scene file (.toml), or make one with `immersa new`")
        })?;
        let text = String::from_utf8(bytes).map_err(|e| not_utf8(path, &e))?;
        Scene::parse_with(&text, path, overrides)
    }

    /// The scene with the start in a field file in place of the run in `initial.from`.
    pub(in crate::scene) fn begun(&self, start: PathBuf) -> Scene {
        let mut scene = self.clone();
        scene.script.start = Some(start);
        scene
    }

    /// The scene as TOML with all defaults; parses to an equal scene in any folder.
    pub fn to_toml(&self) -> String {
        read::write(&self.script.tables, &self.structures)
    }
    /// The same for a file in `folder`: files that it names are given relative to the folder, so
    /// that both can be moved together.
    pub(in crate::scene) fn to_toml_in(&self, folder: &Path) -> String {
        let mut scene = self.clone();
        let tables = &mut scene.script.tables;
        let mut files: Vec<&mut PathBuf> = Vec::new();
        if let schema::MeshSource::File { path, .. } = &mut tables.mesh {
            files.push(path);
        }
        if let Some(image) = &mut tables.image {
            files.push(&mut image.file);
            files.extend(image.mask.as_mut());
        }
        files.extend(tables.initial.as_mut().map(|initial| &mut initial.from));
        for file in files {
            *file = schema::relative(file, folder).unwrap_or_else(|| file.clone());
        }
        scene.to_toml()
    }

    /// Name of the scene in the file system: that of its file, or of its folder if the file is
    /// `scene.toml`.
    pub fn name(&self) -> String {
        scene_name(&self.path)
    }

    /// The path of the scene file as given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The structures, in the order of their columns.
    pub fn structures(&self) -> &[Box<dyn StructureKind>] {
        &self.structures
    }
    /// Structures that act on the flow.
    pub fn acting(&self) -> impl Iterator<Item = &dyn StructureKind> {
        self.structures.iter().filter(|s| s.traits().acts).map(|s| &**s)
    }
    /// Names of the structures that have an interface.
    pub fn interfaces(&self) -> impl Iterator<Item = &str> {
        self.structures.iter().filter(|s| s.shape().is_some()).map(|s| s.name())
    }
    /// Key of the list of structure number `k` in the scene, and its index in this list.
    pub fn structure_keys(&self, k: usize) -> [String; 2] {
        let list = self.structures[k].list();
        let number = self.structures[..k].iter().filter(|s| s.list() == list).count();
        [list.to_string(), number.to_string()]
    }
    /// Fluid inside a structure, if it differs from that outside: the fluid specified by the
    /// structure (which may equal that outside, and lie in another drop), or the inside fluid of
    /// `[fluid]`, which belongs to the only structure of the scene.
    pub fn inside(&self, structure: &dyn StructureKind) -> Option<Fluid> {
        let (outside, traits) = (self.outside(), structure.traits());
        if !traits.acts {
            return None;
        }
        if let [density, viscosity] = traits.own_fluid
            && (density.is_some() || viscosity.is_some())
        {
            return Some(Fluid {
                density: density.unwrap_or(outside.density),
                viscosity: viscosity.unwrap_or(outside.viscosity),
            });
        }
        let (density, viscosity) = (self.fluid.density.inside, self.fluid.viscosity.inside);
        let inside = Fluid { density, viscosity };
        (inside != outside).then_some(inside)
    }
    /// All fluids, beginning with that outside the structures.
    pub fn fluids(&self) -> impl Iterator<Item = Fluid> {
        let inside = self.structures.iter().filter_map(|s| self.inside(&**s));
        std::iter::once(self.outside()).chain(inside)
    }
    /// True if some fluid has mass; otherwise the Stokes equations are solved.
    pub fn has_inertia(&self) -> bool {
        self.fluids().any(|f| f.density > 0.0)
    }

    /// The scheme for convection at a Reynolds number of the domain; `None` for no convection.
    ///
    /// A flow alone above Reynolds number 10 is convected implicitly: at the same step and cost the
    /// forces on a cylinder are 3 to 5 times as accurate (DFG 2D-2). Below, and with structures,
    /// whose forces limit the step, characteristics keep a matrix that is factored once.
    pub fn convection(&self, reynolds: f64) -> Option<ConvectionScheme> {
        let alone = self.structures().is_empty();
        let derived = match alone && (reynolds > CONVECTED || self.time.order == 3) {
            true => ConvectionScheme::Implicit,
            false => ConvectionScheme::Characteristics,
        };
        self.numerics.convection.unwrap_or(self.has_inertia().then_some(derived))
    }

    /// Checks that all files named in the scene can be read.
    ///
    /// # Errors
    /// Of kind [`Input`](crate::base::Kind::Input).
    pub fn check_files(&self) -> Result<()> {
        self.mesh.check_readable().map_err(|e| self.blame(&["mesh", "file"], e))
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
