//! `[mesh]`: source of the mesh.

use super::adapt::Adapt;
use super::shape::Shape;
use crate::base::{Error, Result};
use crate::mesh::{self, Diagonals, Mesh, gmsh};
use crate::scene::keys::{
    Absent, Context, Count, Counts, Form, Item, Keys, Kind, Opt, Positive, Table, Tabled, Toml,
    Vector, Writer, key, row, table, words,
};
use std::path::{Component, Path, PathBuf};

/// Source of the mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    /// A gmsh file.
    File {
        /// The file, as an absolute path.
        path: PathBuf,
        /// 3 for a mesh of tetrahedra, 2 for one of triangles.
        dimension: usize,
        /// Number of refinements, each of which divides a triangle into four, a tetrahedron into
        /// eight.
        refine: usize,
        /// Curves (in space: surfaces) of boundaries of the mesh, by name: new points of a refined
        /// mesh are projected onto them.
        geometry: Vec<(String, Shape)>,
    },
    /// A rectangle of triangles.
    Rectangle(Rectangle),
    /// A disc.
    Disc(Disc),
    /// A box of tetrahedra.
    Box(Block),
    /// A box of tetrahedra, refined near a sphere: [`mesh::ball_in_box`].
    BallInBox(BallInBox),
}

table! {
    /// A rectangle of equal rectangles, each cut into triangles.
    Rectangle: Copy {
        /// Lower left corner.
        min: [f64; 2] [Vector<2>, "m", Required("give the lower left corner: min = [0, 0]")],
        /// Upper right corner.
        max: [f64; 2] [Vector<2>, "m", Required("give the upper right corner: max = [1, 1]")],
        /// Rectangles along each axis.
        cells: [usize; 2] [Counts<2, MOST_CELLS>, Required("give cells = [30, 30]")],
        /// How each is cut: by the diagonal that rises to the right, to the left, or by both in
        /// turn.
        diagonals: Diagonals [DiagonalWords, Default("right")],
    } check Rectangle::check;
}

table! {
    /// A disc.
    Disc: Copy {
        /// Centre.
        centre: [f64; 2] [Vector<2>, "m", Required("give the centre: centre = [0, 0]")],
        /// Radius.
        radius: f64 [Positive, "m", Required("give the radius: radius = 1")],
        /// Cells along a radius.
        cells: usize [Count<1, MOST_CELLS>, Required("give the cells along a radius: cells = 20")],
    }
}

table! {
    /// A box of equal boxes, each cut into tetrahedra.
    Block: Copy {
        /// Corner with the smallest coordinates.
        min: [f64; 3] [Vector<3>, "m", Required("give the lowest corner: min = [0, 0, 0]")],
        /// Corner with the largest coordinates.
        max: [f64; 3] [Vector<3>, "m", Required("give the highest corner: max = [1, 1, 1]")],
        /// Boxes along each axis.
        cells: [usize; 3] [Counts<3, MOST_CELLS>, Required("give cells = [10, 10, 10]")],
    } check Block::check;
}

table! {
    /// A box of equal boxes, each cut into tetrahedra, which are bisected until those near a sphere
    /// are fine.
    BallInBox: Copy {
        /// Corner with the smallest coordinates.
        min: [f64; 3] [Vector<3>, "m", Required("give the lowest corner: min = [-1, -1, -1]")],
        /// Corner with the largest coordinates.
        max: [f64; 3] [Vector<3>, "m", Required("give the highest corner: max = [1, 1, 1]")],
        /// Boxes along each axis before cells are bisected.
        cells: [usize; 3] [Counts<3, MOST_CELLS>, Required("give cells = [8, 8, 8]")],
        /// Centre of the sphere.
        centre: [f64; 3] [Vector<3>, "m",
            Required("give the centre of the sphere: centre = [0, 0, 0]")],
        /// Radius of the sphere.
        radius: f64 [Positive, "m", Required("give the radius of the sphere: radius = 0.5")],
        /// Cells that come nearer to the sphere than this are fine: more than
        /// `numerics.thickness`, if there is a band.
        band: Option<f64> [Opt<Positive>, "m", Derived("3 edges")],
        /// Longest edge of fine cells: the third shortest of their six, as for the band of a
        /// membrane.
        edge: f64 [Positive, "m", Required("give the edge of fine cells: edge = 0.05")],
    } check BallInBox::check;
}

words! {
    DiagonalWords: Diagonals {
        "right" = Diagonals::Right, "left" = Diagonals::Left, "union-jack" = Diagonals::UnionJack,
    }
}

/// Written by hand: some of its keys are for files only, and `adapt` is read elsewhere.
pub(in crate::scene) static KEYS: Keys = Keys {
    about: "Where the mesh comes from: exactly one of file, rectangle, disc, box and ball_in_box.",
    keys: &[
        row(
            "file",
            Kind::Value("path", Form::Text),
            "",
            Absent::OneOf,
            "A mesh of gmsh (MSH 2.2, 4.0 or 4.1), relative to the folder of the scene.",
        ),
        row(
            "dimension",
            Kind::Count([2, 3]),
            "",
            Absent::Derived("3 where the file has tetrahedra"),
            "Whether a mesh file has triangles or tetrahedra. Where this is written, the file is \
             not looked into before it is needed.",
        ),
        row(
            "rectangle",
            Kind::Table(Rectangle::KEYS),
            "",
            Absent::OneOf,
            "A rectangle; its sides are left, right, bottom and top.",
        ),
        row("disc", Kind::Table(Disc::KEYS), "", Absent::OneOf, "A disc."),
        row(
            "box",
            Kind::Table(Block::KEYS),
            "",
            Absent::OneOf,
            "A box of tetrahedra; its sides are left and right (in x), bottom and top (in y), \
             back and front (in z).",
        ),
        row(
            "ball_in_box",
            Kind::Table(BallInBox::KEYS),
            "",
            Absent::OneOf,
            "A box of tetrahedra that is fine about a sphere.",
        ),
        row(
            "refine",
            Kind::Count([0, MOST_REFINEMENTS]),
            "",
            Absent::Default("0"),
            "How often every triangle of a mesh file is cut into four, every tetrahedron into \
             eight.",
        ),
        row(
            "geometry",
            Kind::Value(
                "shapes with names, each as in `membrane.shape`",
                Form::Names(&Form::Like("membrane.shape")),
            ),
            "",
            Absent::Optional,
            "Curves (in space: surfaces) that new points on named boundaries of a mesh file are \
             moved onto when it is refined.",
        ),
        row(
            "adapt",
            Kind::Table(Adapt::KEYS),
            "",
            Absent::Optional,
            "Makes the mesh follow the interfaces and, if wanted, fields.",
        ),
    ],
};

/// Maximum number of refinements: after this many a mesh has a million times its triangles.
const MOST_REFINEMENTS: usize = 10;
/// Maximum number of cells along an axis: more exceed any memory.
const MOST_CELLS: usize = 100_000;

impl MeshSource {
    /// Reads `[mesh]`. Unless the scene gives it, the dimension of a mesh file is `assumed`, or
    /// that in the file, or 2.
    pub(in crate::scene) fn read(
        item: &Item,
        context: &Context,
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
            "file" => file(&mesh, &item, context, assumed),
            "rectangle" => Rectangle::read(&item, context).map(MeshSource::Rectangle),
            "disc" => Disc::read(&item, context).map(MeshSource::Disc),
            "ball_in_box" => BallInBox::read(&item, context).map(MeshSource::BallInBox),
            _ => Block::read(&item, context).map(MeshSource::Box),
        }
    }

    /// Dimension of space: 2 or 3.
    pub fn dimension(&self) -> usize {
        match self {
            MeshSource::File { dimension, .. } => *dimension,
            MeshSource::Rectangle(_) | MeshSource::Disc(_) => 2,
            MeshSource::Box(_) | MeshSource::BallInBox(_) => 3,
        }
    }

    /// The generated mesh in space; `None` for files and for meshes of the plane.
    pub fn generated(&self) -> Option<Result<Mesh<3>>> {
        match *self {
            MeshSource::Box(Block { min, max, cells }) => Some(mesh::box_mesh(min, max, cells)),
            MeshSource::BallInBox(BallInBox { min, max, cells, centre, radius, band, edge }) => {
                // A band of the default thickness has 2.5 edges.
                let band = band.unwrap_or(3.0 * edge);
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
                out.entry("file", path.toml());
                if *dimension == 3 {
                    out.entry("dimension", dimension);
                }
                out.entry("refine", refine);
                for (name, curve) in geometry {
                    out.entry(&format!("geometry.{}", key(name)), curve.inline());
                }
            }
            MeshSource::Rectangle(rectangle) => out.entry("rectangle", rectangle.inline()),
            MeshSource::Disc(disc) => out.entry("disc", disc.inline()),
            MeshSource::Box(block) => out.entry("box", block.inline()),
            MeshSource::BallInBox(ball) => out.entry("ball_in_box", ball.inline()),
        }
    }
}

/// Reads a mesh file; `item` is its name.
fn file(
    mesh: &Table<'_>,
    item: &Item<'_>,
    context: &Context,
    assumed: Option<usize>,
) -> Result<MeshSource> {
    let file = item.text()?;
    if file.is_empty() {
        return Err(item
            .error("the name of the mesh file is empty")
            .remedy("name a gmsh file (.msh)"));
    }
    let path = absolute(&context.folder.join(file));
    let dimension = match mesh.optional("dimension", |i| i.count(2, 3))? {
        Some(dimension) => dimension,
        // Errors of the file are reported when the mesh is built.
        None => assumed.or_else(|| gmsh::dimension(&path).ok()).unwrap_or(2),
    };
    let context = Context { dimension, ..context.clone() };
    Ok(MeshSource::File {
        path,
        dimension,
        refine: mesh.optional("refine", |i| i.count(0, MOST_REFINEMENTS))?.unwrap_or(0),
        geometry: mesh.optional("geometry", |i| curves(i, &context))?.unwrap_or_default(),
    })
}

/// Reads the curves, by the name of their boundary.
fn curves(item: &Item, context: &Context) -> Result<Vec<(String, Shape)>> {
    item.open_table()?
        .items()
        .map(|(name, item)| Ok((name.to_string(), Shape::read(&item, context)?)))
        .collect()
}

impl Rectangle {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        above(table, &self.min, &self.max)
    }
}

impl Block {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        above(table, &self.min, &self.max)
    }
}

impl BallInBox {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        above(table, &self.min, &self.max)
    }
}

/// Rejects a corner `max` that is not larger than `min` in every coordinate.
fn above(table: &Table<'_>, min: &[f64], max: &[f64]) -> Result<()> {
    match table.get("max").filter(|_| !max.iter().zip(min).all(|(a, b)| a > b)) {
        None => Ok(()),
        Some(item) => Err(item
            .error(format!("`{}` must be larger than min = {min:?} in every coordinate", item.key))
            .remedy("exchange min and max, or widen the mesh")),
    }
}

/// The absolute path.
pub(in crate::scene) fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

/// The path from `folder`, which exists, to a file or folder that does; `None` where they have no
/// folder in common, or for a folder that cannot be read.
pub(in crate::scene) fn relative(path: &Path, folder: &Path) -> Option<PathBuf> {
    // The name itself may be a link, and stays one.
    let (parent, name) = (path.parent()?.canonicalize().ok()?, path.file_name()?);
    let folder = folder.canonicalize().ok()?;
    let shared = parent.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    // The first component is the root.
    if shared < 2 {
        return None;
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    Some(up.chain(parent.components().skip(shared)).chain([Component::Normal(name)]).collect())
}
