//! `[mesh]`: where the mesh comes from.

use super::shape::Shape;
use crate::base::{Error, Result};
use crate::mesh::{self, Diagonals, Mesh, gmsh};
use crate::scene::keys::{Absent::*, Keys, Kind::*, row, words};
use crate::scene::keys::{Context, Item, Table};
use crate::scene::keys::{Writer, key, list, name, number, text, vector};
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
        /// How many times every triangle is cut into four, every tetrahedron into eight.
        refine: usize,
        /// Curves (in space: surfaces) that boundaries of the mesh stand for, by name: new points of a refined mesh are moved onto them.
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
    /// A box of tetrahedra that is fine about a sphere: [`mesh::ball_in_box`].
    BallInBox {
        /// Corner with the smallest coordinates.
        min: [f64; 3],
        /// Corner with the largest coordinates.
        max: [f64; 3],
        /// Boxes along each axis before cells are bisected.
        cells: [usize; 3],
        /// Centre of the sphere.
        centre: [f64; 3],
        /// Radius of the sphere.
        radius: f64,
        /// Cells that come nearer to the sphere are fine.
        band: f64,
        /// Their length, the third shortest edge, is at most this.
        edge: f64,
    },
}

const DIAGONALS: [(&str, Diagonals); 3] =
    [("right", Diagonals::Right), ("left", Diagonals::Left), ("union-jack", Diagonals::UnionJack)];
const DIAGONAL_WORDS: [&str; 3] = words(&DIAGONALS);

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "Where the mesh comes from: exactly one of file, rectangle, disc, box and ball_in_box.",
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
        row("ball_in_box", Table(&BALL_IN_BOX), "", OneOf, "A box of tetrahedra that is fine about a sphere."),
        row(
            "refine",
            Value("whole number from 0 to 10"),
            "",
            Default("0"),
            "How often every triangle of a mesh file is cut into four, every tetrahedron into eight.",
        ),
        row(
            "geometry",
            Value("shapes with names, each as in `membrane.shape`"),
            "",
            Optional,
            "Curves (in space: surfaces) that new points on named boundaries of a mesh file are moved onto when it is refined.",
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

static BALL_IN_BOX: Keys = Keys {
    about: "A box of equal boxes, each cut into tetrahedra, which are bisected until those near a sphere are fine.",
    keys: &[
        row("min", Value("point"), "m", Required, "Corner with the smallest coordinates."),
        row("max", Value("point"), "m", Required, "Corner with the largest coordinates."),
        row(
            "cells",
            Value("three whole numbers from 1 to 100000"),
            "",
            Required,
            "Boxes along each axis before cells are bisected.",
        ),
        row("centre", Value("point"), "m", Required, "Centre of the sphere."),
        row("radius", Value("number > 0"), "m", Required, "Radius of the sphere."),
        row("band", Value("number > 0"), "m", Required, "Cells that come nearer to the sphere than this are fine."),
        row(
            "edge",
            Value("number > 0"),
            "m",
            Required,
            "Longest edge of fine cells: the third shortest of their six, as for the band of a membrane.",
        ),
    ],
};

/// A mesh refined more often has a million times its triangles.
const MOST_REFINEMENTS: usize = 10;
/// More cells along an axis exceed any memory.
const MOST_CELLS: usize = 100_000;

impl MeshSource {
    /// Reads `[mesh]`. Without a word from the scene a mesh file has the dimension `assumed`, or that which it says, or 2.
    pub(in crate::scene) fn read(
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
            "ball_in_box" => ball_in_box(&item.table(&BALL_IN_BOX)?),
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
            MeshSource::Box { .. } | MeshSource::BallInBox { .. } => 3,
        }
    }

    /// The mesh in space that this generates; `None` for files and for meshes of the plane.
    pub fn generated(&self) -> Option<Result<Mesh<3>>> {
        match *self {
            MeshSource::Box { min, max, cells } => Some(mesh::box_mesh(min, max, cells)),
            MeshSource::BallInBox { min, max, cells, centre, radius, band, edge } => {
                Some(mesh::ball_in_box(min, max, cells, centre, radius, band, edge))
            }
            _ => None,
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

    pub(in crate::scene) fn write(&self, out: &mut Writer) {
        out.header("[mesh]");
        match self {
            MeshSource::File { path, dimension, refine, geometry } => {
                out.entry("file", text(&path.to_string_lossy()));
                if *dimension == 3 {
                    out.entry("dimension", dimension);
                }
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
            MeshSource::BallInBox { min, max, cells, centre, radius, band, edge } => {
                let (min, max, cells, centre) = (vector(min), vector(max), whole(cells), vector(centre));
                let [radius, band, edge] = [radius, band, edge].map(|x| number(*x));
                out.entry(
                    "ball_in_box",
                    format_args!(
                        "{{ min = {min}, max = {max}, cells = {cells}, centre = {centre}, radius = {radius}, band = {band}, edge = {edge} }}"
                    ),
                );
            }
        }
    }
}

fn ball_in_box(table: &Table) -> Result<MeshSource> {
    let min = table.required("min", "give the lowest corner: min = [-1, -1, -1]", Item::vector)?;
    Ok(MeshSource::BallInBox {
        min,
        max: table.required("max", "give the highest corner: max = [1, 1, 1]", |i| above(i, &min))?,
        cells: table.required("cells", "give cells = [8, 8, 8]", |i| i.counts(MOST_CELLS))?,
        centre: table.required("centre", "give the centre of the sphere: centre = [0, 0, 0]", Item::vector)?,
        radius: table.required("radius", "give the radius of the sphere: radius = 0.5", Item::positive)?,
        band: table.required("band", "give how far fine cells reach: band = 0.2", Item::positive)?,
        edge: table.required("edge", "give the edge of fine cells: edge = 0.05", Item::positive)?,
    })
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

/// The path from the root of the file system.
pub(in crate::scene) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}
