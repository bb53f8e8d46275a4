//! `[mesh]`: where the mesh comes from.

use super::keys::{Absent::*, Keys, Kind::*, row, words};
use super::shape::Shape;
use super::write::{Writer, key, list, name, number, text, vector};
use crate::base::{Error, Result};
use crate::mesh::{Diagonals, gmsh};
use crate::scene::item::{Context, Item, Table as ItemTable};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where the mesh comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    /// A gmsh file.
    File {
        /// The file, as an absolute path.
        path: PathBuf,
        /// 3 for a mesh of tetrahedra, 2 for one of triangles.
        dimension: usize,
        /// How many times every triangle is cut into four.
        refine: usize,
        /// Curves that boundaries of the mesh stand for, by name: new points of a refined mesh are moved onto them.
        geometry: Vec<(String, Shape)>,
    },
    /// A rectangle of `cells[0] x cells[1]` rectangles, each cut into triangles.
    Rectangle {
        /// Lower left corner.
        min: [f64; 2],
        /// Upper right corner.
        max: [f64; 2],
        /// Rectangles along each axis.
        cells: [usize; 2],
        /// How each rectangle is cut.
        diagonals: Diagonals,
    },
    /// A disc.
    Disc {
        /// Centre.
        centre: [f64; 2],
        /// Radius.
        radius: f64,
        /// Cells along a radius.
        cells: usize,
    },
    /// A box of tetrahedra.
    Box {
        /// Corner with the smallest coordinates.
        min: [f64; 3],
        /// Corner with the largest coordinates.
        max: [f64; 3],
        /// Boxes along each axis.
        cells: [usize; 3],
    },
}

const DIAGONALS: [(&str, Diagonals); 3] =
    [("right", Diagonals::Right), ("left", Diagonals::Left), ("union-jack", Diagonals::UnionJack)];
const DIAGONAL_WORDS: [&str; 3] = words(&DIAGONALS);

pub(super) static KEYS: Keys = Keys {
    about: "Where the mesh comes from: exactly one of file, rectangle, disc and box.",
    keys: &[
        row(
            "file",
            Value("path"),
            "",
            OneOf,
            "A mesh of gmsh (MSH 2.2, 4.0 or 4.1), relative to the folder of the scene.",
        ),
        row(
            "dimension",
            Value("2 or 3"),
            "",
            Derived("3 where the file has tetrahedra"),
            "Whether a mesh file has triangles or tetrahedra. Where this is written, the file is not looked into before it is needed.",
        ),
        row("rectangle", Table(&RECTANGLE), "", OneOf, "A rectangle; its sides are left, right, bottom and top."),
        row("disc", Table(&DISC), "", OneOf, "A disc."),
        row(
            "box",
            Table(&BOX),
            "",
            OneOf,
            "A box of tetrahedra; its sides are left and right (in x), bottom and top (in y), back and front (in z).",
        ),
        row(
            "refine",
            Value("whole number from 0 to 10"),
            "",
            Default("0"),
            "How often every triangle of a mesh file is cut into four.",
        ),
        row(
            "geometry",
            Value("shapes with names, each as in `membrane.shape`"),
            "",
            Optional,
            "Curves that new points on named boundaries of a mesh file are moved onto when it is refined.",
        ),
        row(
            "adapt",
            Table(&super::adapt::KEYS),
            "",
            Optional,
            "Makes the mesh follow the interfaces and, if wanted, fields.",
        ),
    ],
};

static RECTANGLE: Keys = Keys {
    about: "A rectangle of equal rectangles, each cut into triangles.",
    keys: &[
        row("min", Value("point"), "m", Required, "Lower left corner."),
        row("max", Value("point"), "m", Required, "Upper right corner."),
        row("cells", Value("two whole numbers from 1 to 100000"), "", Required, "Rectangles along each axis."),
        row(
            "diagonals",
            Choice(&DIAGONAL_WORDS),
            "",
            Default("\"right\""),
            "How each is cut: by the diagonal that rises to the right, to the left, or by both in turn.",
        ),
    ],
};

static DISC: Keys = Keys {
    about: "A disc.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row("radius", Value("number > 0"), "m", Required, "Radius."),
        row("cells", Value("whole number from 1 to 100000"), "", Required, "Cells along a radius."),
    ],
};

static BOX: Keys = Keys {
    about: "A box of equal boxes, each cut into tetrahedra.",
    keys: &[
        row("min", Value("point"), "m", Required, "Corner with the smallest coordinates."),
        row("max", Value("point"), "m", Required, "Corner with the largest coordinates."),
        row("cells", Value("three whole numbers from 1 to 100000"), "", Required, "Boxes along each axis."),
    ],
};

/// A mesh refined more often has a million times its triangles.
const MOST_REFINEMENTS: usize = 10;
/// More cells along an axis exceed any memory.
const MOST_CELLS: usize = 100_000;

impl MeshSource {
    /// Reads `[mesh]`. Without a word from the scene a mesh file has the dimension `assumed`, or that which it says, or 2.
    pub(super) fn read(
        item: &Item,
        folder: &Path,
        constants: &BTreeMap<String, f64>,
        assumed: Option<usize>,
    ) -> Result<MeshSource> {
        let mesh = item.table(&KEYS)?;
        let (kind, item) = mesh.exactly_one(&KEYS)?;
        for (key, remedy) in [
            ("refine", format!("give the {kind} more cells")),
            ("geometry", format!("give the {kind} more cells")),
            ("dimension", format!("leave it out: a {kind} has one dimension only")),
        ] {
            if let (Some(item), true) = (mesh.get(key), kind != "file") {
                return Err(item.key_error(format!("`{key}` is for mesh files")).remedy(remedy));
            }
        }
        match kind {
            "file" => {
                let file = item.text()?;
                if file.is_empty() {
                    return Err(item.error("the name of the mesh file is empty").remedy("name a gmsh file (.msh)"));
                }
                let path = absolute(&folder.join(file));
                let dimension = match mesh.optional("dimension", |i| i.count(2, 3))? {
                    Some(dimension) => dimension,
                    // What is wrong with the file is told when the mesh is made.
                    None => assumed.or_else(|| gmsh::dimension(&path).ok()).unwrap_or(2),
                };
                if dimension == 3 {
                    check_unrefined(&mesh)?;
                }
                let context = Context { dimension, constants: constants.clone() };
                Ok(MeshSource::File {
                    path,
                    dimension,
                    refine: mesh.optional("refine", |i| i.count(0, MOST_REFINEMENTS))?.unwrap_or(0),
                    geometry: mesh.optional("geometry", |i| curves(i, &context))?.unwrap_or_default(),
                })
            }
            "rectangle" => {
                let table = item.table(&RECTANGLE)?;
                let min = table.required("min", "give the lower left corner: min = [0, 0]", Item::vector)?;
                Ok(MeshSource::Rectangle {
                    min,
                    max: table.required("max", "give the upper right corner: max = [1, 1]", |i| above(i, &min))?,
                    cells: table.required("cells", "give cells = [30, 30]", |i| i.counts(MOST_CELLS))?,
                    diagonals: table.optional("diagonals", |i| i.choice(&DIAGONALS))?.unwrap_or(Diagonals::Right),
                })
            }
            "disc" => {
                let table = item.table(&DISC)?;
                Ok(MeshSource::Disc {
                    centre: table.required("centre", "give the centre: centre = [0, 0]", Item::vector)?,
                    radius: table.required("radius", "give the radius: radius = 1", Item::positive)?,
                    cells: table
                        .required("cells", "give the cells along a radius: cells = 20", |i| i.count(1, MOST_CELLS))?,
                })
            }
            _ => {
                let table = item.table(&BOX)?;
                let min = table.required("min", "give the lowest corner: min = [0, 0, 0]", Item::vector)?;
                Ok(MeshSource::Box {
                    min,
                    max: table.required("max", "give the highest corner: max = [1, 1, 1]", |i| above(i, &min))?,
                    cells: table.required("cells", "give cells = [10, 10, 10]", |i| i.counts(MOST_CELLS))?,
                })
            }
        }
    }

    /// Components of a vector: 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            MeshSource::File { dimension, .. } => *dimension,
            MeshSource::Rectangle { .. } | MeshSource::Disc { .. } => 2,
            MeshSource::Box { .. } => 3,
        }
    }

    /// Tries to open the mesh file, if there is one. Errors: it is missing or cannot be read.
    pub fn check_readable(&self) -> Result<()> {
        let MeshSource::File { path, .. } = self else { return Ok(()) };
        let failed = |e: std::io::Error| {
            Error::input(format!("the mesh file cannot be read: {e}"))
                .value(path.display())
                .remedy("correct mesh.file; it is looked for relative to the folder of the scene")
        };
        let about = std::fs::File::open(path).and_then(|f| f.metadata()).map_err(failed)?;
        if about.is_dir() { Err(failed(std::io::ErrorKind::IsADirectory.into())) } else { Ok(()) }
    }

    pub(super) fn write(&self, out: &mut Writer) {
        out.header("[mesh]");
        match self {
            MeshSource::File { path, dimension: 3, .. } => {
                out.entry("file", text(&path.to_string_lossy()));
                out.entry("dimension", 3);
            }
            MeshSource::File { path, refine, geometry, .. } => {
                out.entry("file", text(&path.to_string_lossy()));
                out.entry("refine", refine);
                for (name, curve) in geometry {
                    out.entry(&format!("geometry.{}", key(name)), curve.write());
                }
            }
            MeshSource::Rectangle { min, max, cells, diagonals } => {
                let (min, max, diagonals) = (vector(min), vector(max), name(*diagonals, &DIAGONALS));
                let cells = whole(cells);
                out.entry(
                    "rectangle",
                    format_args!("{{ min = {min}, max = {max}, cells = {cells}, diagonals = {diagonals} }}"),
                );
            }
            MeshSource::Disc { centre, radius, cells } => {
                let (centre, radius) = (vector(centre), number(*radius));
                out.entry("disc", format_args!("{{ centre = {centre}, radius = {radius}, cells = {cells} }}"));
            }
            MeshSource::Box { min, max, cells } => {
                let (min, max, cells) = (vector(min), vector(max), whole(cells));
                out.entry("box", format_args!("{{ min = {min}, max = {max}, cells = {cells} }}"));
            }
        }
    }
}

/// Refuses what is for meshes of triangles.
fn check_unrefined(mesh: &ItemTable<'_>) -> Result<()> {
    match ["refine", "geometry"].iter().find_map(|key| mesh.get(key)).filter(|i| !i.is_zero()) {
        Some(item) => Err(item
            .key_error(format!("`{}` is for meshes of triangles, and the file has tetrahedra", item.key))
            .remedy("leave it out, and mesh the volume finer (gmsh -clscale 0.5)")),
        None => Ok(()),
    }
}

/// Curves by the name of their boundary.
fn curves(item: &Item, context: &Context) -> Result<Vec<(String, Shape)>> {
    item.open_table()?.items().map(|(name, item)| Ok((name.to_string(), Shape::read(&item, context)?))).collect()
}

fn whole(v: &[usize]) -> String {
    list(v.iter().map(usize::to_string))
}

/// A corner all of whose coordinates are larger than those of `min`.
fn above<const N: usize>(item: &Item, min: &[f64; N]) -> Result<[f64; N]> {
    let max = item.vector::<N>()?;
    if max.iter().zip(min).all(|(a, b)| a > b) {
        return Ok(max);
    }
    Err(item
        .error(format!("`{}` must be larger than min = {min:?} in every coordinate", item.key))
        .remedy("exchange min and max, or widen the mesh"))
}

fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}
