//! `[image]`: an image segmented into two grey levels by a level set, without a flow.

use super::mesh::{MeshSource, Rectangle, absolute};
use crate::base::Result;
use crate::mesh::Diagonals;
use crate::output::{GreyImage, Pixels};
use crate::scene::keys::{
    Context, Count, Form, Item, Kind, NonNegative, Opt, Positive, Table, kinds, table,
};
use std::path::PathBuf;

table! {
    /// An image that the one level set of the scene cuts into two grey levels, in place of a flow:
    /// it descends along `fidelity` times the misfit plus `length` times its length, and the time
    /// is that of this descent. Grey levels are from 0 (black) to 1 (white). The lower left corner
    /// of the image is the origin.
    Image {
        /// A PNG file, relative to the folder of the scene: grey or colour, which is turned to
        /// grey.
        file: PathBuf [File, Required("name a PNG file: file = \"shapes.png\"")],
        /// Side of a pixel.
        pixel: f64 [Positive, "m", Default(1.0)],
        /// Weight alpha of the misfit E1, the integral of the squared difference of the image and
        /// the mean level of the side. It sets the scale of time.
        fidelity: f64 [Positive, "m2/s", Default(1.0)],
        /// Weight beta of the length E2. Over `fidelity` and the squared difference of the two
        /// levels it is a radius: round spots below it shrink and vanish.
        length: f64 [NonNegative, "m3/s", Required("give the weight of the length: length = 0.2")],
        /// After how many steps the level set is made a signed distance again.
        rebuild: usize [Count<1, 1_000_000>, "steps", Default(1)],
        /// The right answer as a PNG file of the same size, white inside, if it is known: the run
        /// counts the pixels that are on the wrong side.
        mask: Option<PathBuf> [Opt<File>],
    }
}

kinds! {
    /// A PNG file, as an absolute path.
    File: PathBuf = Kind::Value("path", Form::Text), file;
}

/// Maximum number of pixels for an automatic mesh: its matrix has as many unknowns as the image has
/// pixels.
const MOST_PIXELS: usize = 1 << 20;

fn file(item: &Item, context: &Context) -> Result<PathBuf> {
    match item.text()? {
        "" => Err(item
            .error("the name of the image is empty")
            .remedy("name a PNG file: file = \"shapes.png\"")),
        file => Ok(absolute(&context.folder.join(file))),
    }
}

impl Image {
    /// The pixel grid of the image.
    ///
    /// # Errors
    /// Those of [`GreyImage::size`].
    pub fn pixels(&self) -> Result<Pixels> {
        Ok(Pixels { size: GreyImage::size(&self.file)?, side: self.pixel })
    }

    /// The default mesh of a scene: a rectangle over the image with squares of two pixels, so that
    /// the P2 nodes are the corners of the pixels.
    pub(in crate::scene) fn mesh(&self, item: &Item) -> Result<MeshSource> {
        let written = item.open_table()?.get("file");
        let size =
            GreyImage::size(&self.file).map_err(|e| written.as_ref().unwrap_or(item).blame(e))?;
        if size[0] * size[1] > MOST_PIXELS {
            return Err(item
                .key_error(format!(
                    "an image of {} x {} pixels would make too large a mesh",
                    size[0], size[1]
                ))
                .remedy(
                    "make the image smaller, or give a coarser [mesh] with a rectangle over it",
                ));
        }
        Ok(MeshSource::Rectangle(Rectangle {
            min: [0.0; 2],
            max: size.map(|n| n as f64 * self.pixel),
            cells: size.map(|n| n.div_ceil(2)),
            diagonals: Diagonals::UnionJack,
        }))
    }
}

/// List of the level sets, which can segment an image.
const CONTOUR: &str = "level_set";

/// Checks that an image is segmented by one level set in the plane, without tables and keys of a
/// flow.
pub(in crate::scene) fn check(
    scene: &Table<'_>,
    image: &Item,
    dimension: usize,
    lists: &[&str],
) -> Result<()> {
    if dimension != 2 {
        return Err(image
            .key_error("an image is plane, and the mesh has 3 dimensions")
            .remedy("leave [mesh] out, or give a rectangle over the image"));
    }
    let acting = lists.iter().filter(|list| **list != CONTOUR);
    let structures = acting.map(|k| (*k, format!("nothing flows that a {k} could act on")));
    let tables = [
        ("fluid", "nothing flows"),
        ("initial", "nothing flows"),
        ("boundary", "nothing flows through a boundary"),
        ("exact", "there is no flow to compare"),
    ];
    let tables = tables.map(|(key, why)| (key, why.to_string()));
    for (key, why) in tables.into_iter().chain(structures) {
        if let Some(item) = scene.get(key) {
            return Err(item
                .key_error(format!("`{key}` means nothing beside `image`: {why}"))
                .remedy(format!("leave {key} out, or image")));
        }
    }
    for (table, keys) in [
        ("mesh", &["adapt"][..]),
        ("time", &["tolerance"]),
        ("output", &["forces", "fluxes", "backward_map"]),
        ("numerics", &["transport", "surface_tension", "pressure"]),
    ] {
        let Some(open) = scene.get(table).map(|i| i.open_table()).transpose()? else { continue };
        let written = keys.iter().filter_map(|key| open.get(key));
        if let Some(item) = written
            .into_iter()
            .find(|i| !i.is_false() && !["nodal", "P1"].iter().any(|word| i.is_word(word)))
        {
            return Err(item
                .key_error(format!(
                    "`{}` means nothing beside `image`, where nothing flows",
                    item.key
                ))
                .remedy("leave it out"));
        }
    }
    let numerics = scene.get("numerics").map(|i| i.open_table()).transpose()?;
    if let Some(item) = numerics.and_then(|t| t.get("redistance")) {
        return Err(item
            .key_error(
                "beside `image` the level set becomes a distance in any case, after every \
                 `image.rebuild` steps",
            )
            .remedy("leave numerics.redistance out, or give image.rebuild"));
    }
    check_contour(scene, image)
}

/// Checks that there is one level set, without markers.
fn check_contour(scene: &Table<'_>, image: &Item) -> Result<()> {
    let start = "give one: [[level_set]] with shape.circle = { centre = [64, 64], radius = 40 }";
    let Some(item) = scene.get(CONTOUR) else {
        return Err(image
            .key_error("the scene has an image and no contour to start from")
            .remedy(start));
    };
    match &item.list()?[..] {
        [one] => match one.open_table()?.get("markers").filter(|i| !i.is_zero()) {
            Some(item) => Err(item
                .key_error("markers are carried by a flow, and nothing flows")
                .remedy("leave them out")),
            None => Ok(()),
        },
        all => Err(item
            .key_error(format!("one level set segments the image, and the scene has {}", all.len()))
            .remedy("join the shapes: [[level_set]] with shape.union = [...]")),
    }
}
