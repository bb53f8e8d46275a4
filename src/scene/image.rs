//! Scenes whose level set segments an image: their model, what they measure against a known answer, and the files of their end.

use super::Scene;
use super::adapt::Lengths;
use super::dimension::{Dimension, In};
use super::model::{Draft, Model};
use super::schema;
use crate::base::{Error, Result};
use crate::fem::Conditions;
use crate::levelset::{Contour, Redistance, Redistancing, Segmentation, SegmentationWeights, band_edges};
use crate::mesh::{self, Point};
use crate::output::{GreyImage, Pixels, write_file};
use crate::sim::Simulation;
use nalgebra::SVector;
use std::path::Path;
use std::sync::Arc;

/// Half-width of the band in edges of the mesh when the scene does not say: four pixels on the mesh that is made for an image. With one
/// edge the band is too thin for the mesh: the contour of `examples/active-contours` takes ten times as long.
const BAND: f64 = 2.0;
/// A level of the mask above this is inside.
const MIDDLE: f64 = 0.5;
/// Part of a pixel by which a mesh may reach beyond the image.
const ROUNDING: f64 = 1e-6;

/// Builds the model of a scene with an image.
///
/// # Errors
/// An image that cannot be read or that the mesh reaches beyond; as for level sets.
pub(super) fn segmenting<const D: usize>(
    scene: &Scene,
    image: &schema::Image,
    draft: Draft<'_, D>,
    conditions: Conditions<D>,
    quality: mesh::Quality<D>,
) -> Result<Model<D>>
where
    In<D>: Dimension<D>,
{
    let place = |e| scene.blame(&["image", "file"], e);
    let picture = GreyImage::read(&image.path).map_err(place)?;
    let pixels = Pixels { size: [picture.width(), picture.height()], side: image.pixel };
    let (low, high) = draft.mesh.bounding_box();
    let beyond =
        |k: usize| low[k] < -ROUNDING * pixels.side || high[k] > (pixels.size[k] as f64 + ROUNDING) * pixels.side;
    if (0..2).any(beyond) {
        let e = Error::scene("the mesh reaches beyond the image")
            .value(format!("an image of {} x {} pixels of {}", pixels.size[0], pixels.size[1], pixels.side))
            .remedy("leave [mesh] out, or give a rectangle from [0, 0] within the image");
        return Err(scene.blame(&["mesh"], e));
    }
    let level_sets = draft.level_sets()?;
    let edges = level_sets.iter().filter_map(|s| band_edges(draft.space, &s.phi, 0.0)).map(|e| e.largest);
    let thickness = scene.numerics.thickness.unwrap_or(BAND * edges.fold(0.0, f64::max));
    let still = Arc::new(|_: &Point<D>, _: f64| SVector::<f64, D>::zeros());
    let mut simulation = Simulation::prescribed(draft.mesh, draft.settings(conditions, 0.0), still, level_sets)?;
    let at = |x: &Point<D>| [x[0] / pixels.side, x[1] / pixels.side];
    let weights = SegmentationWeights { fidelity: image.fidelity, length: image.length, thickness };
    let space = Arc::clone(simulation.space());
    let grey = |x: &Point<D>| {
        let [x, y] = at(x);
        picture.at(x, y)
    };
    let segmentation = Segmentation::new(&space, grey, weights)?;
    let nodal = space.interpolate(|x| {
        let [x, y] = at(x);
        picture.smooth(x, y)
    });
    simulation.descend_along(segmentation, nodal);
    let how = Redistancing { method: Redistance::Exact, volume: false, cutter: In::<D>::CUTTER };
    simulation.redistance_every(image.rebuild, how);
    Ok(Model {
        simulation,
        warnings: draft.warnings,
        explicit_limit: None,
        band_edges: None,
        thickness: Some(thickness),
        velocity_scale: None,
        quality,
        wall_nodes: Vec::new(),
        lengths: None::<Lengths>,
    })
}

/// The known answer of a segmentation.
pub struct Answer {
    pixels: Pixels,
    inside: Vec<bool>,
}

impl Answer {
    /// Reads the mask of a scene, if it has one.
    ///
    /// # Errors
    /// A mask that cannot be read or has another size than the image.
    pub fn of(scene: &Scene) -> Result<Option<Answer>> {
        let Some((image, path)) = scene.image.as_ref().and_then(|i| Some((i, i.mask.as_ref()?))) else {
            return Ok(None);
        };
        let place = |e| scene.blame(&["image", "mask"], e);
        let pixels = image.pixels().map_err(|e| scene.blame(&["image", "file"], e))?;
        let mask = GreyImage::read(path).map_err(place)?;
        if [mask.width(), mask.height()] != pixels.size {
            let [width, height] = pixels.size;
            let e = Error::input("the mask and the image differ in size")
                .value(format!("{} x {} pixels", mask.width(), mask.height()))
                .remedy(format!("give a mask of {width} x {height} pixels"));
            return Err(place(e));
        }
        let inside: Vec<bool> = mask.levels().iter().map(|v| *v > MIDDLE).collect();
        if !inside.contains(&true) {
            return Err(place(
                Error::input("nothing is inside in the mask: no pixel is white")
                    .remedy("give a mask that is white inside"),
            ));
        }
        Ok(Some(Answer { pixels, inside }))
    }

    /// The area of pixels inside less that of the mask, over the latter, and the number of pixels on the wrong side.
    pub fn compare(&self, sim: &Simulation<2>) -> [f64; 2] {
        let found = self.pixels.inside(sim.space(), &sim.level_set(0));
        let count = |inside: &[bool]| inside.iter().filter(|i| **i).count() as f64;
        let wrong = found.iter().zip(&self.inside).filter(|(a, b)| a != b).count();
        [count(&found) / count(&self.inside) - 1.0, wrong as f64]
    }
}

/// Writes what a segmentation has come to: `contours.csv`, `segmented.png` with the two mean levels, and `mask.png`, white inside.
///
/// # Errors
/// The image cannot be read any more; a file cannot be written.
pub(super) fn write_segmentation(scene: &Scene, sim: &Simulation<2>, folder: &Path) -> Result<()> {
    let (Some(image), Some(segmentation)) = (&scene.image, sim.segmentation()) else { return Ok(()) };
    let (pixels, phi) = (image.pixels().map_err(|e| scene.blame(&["image", "file"], e))?, sim.level_set(0));
    pixels.contours(&Contour::new(sim.space(), &phi)?)?.write(&folder.join("contours.csv"))?;
    let (inside, levels) = (pixels.inside(sim.space(), &phi), segmentation.levels(&phi)?);
    for (name, [inner, outer]) in [("segmented.png", levels), ("mask.png", [1.0, 0.0])] {
        let grey = inside.iter().map(|i| if *i { inner } else { outer }).collect();
        write_file(&folder.join(name), &GreyImage::new(pixels.size[0], grey)?.png()?)?;
    }
    Ok(())
}
