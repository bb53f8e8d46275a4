//! Pictures of three-dimensional runs: lit surfaces and slices in the box of the domain.
//!
//! Drawn by our own small renderer: triangles with depth, three by three samples a pixel, in bands
//! of rows that threads share; the same bits for any number of threads.

mod camera;
mod canvas;
mod coat;
mod frame;
mod light;
mod pattern;
mod slice;
mod surface;
#[cfg(test)]
mod tests;

pub use camera::{Projection, View};
pub use coat::Coat;
pub use pattern::Pattern;
pub use slice::Slice;
pub use surface::{Paint, Surface};

use super::colours::{ColourMap, Colours, Scale};
use super::legend::{draw_bar, draw_title};
use super::raster::Image;
use crate::base::{Error, Result};
use crate::fem::Space;
use crate::mesh::Point;
use camera::Camera;
use canvas::{Canvas, Facet};
use frame::BoxEdges;
use light::Lights;
use slice::CutPlane;

/// A picture of surfaces and slices in the box of a domain.
#[derive(Clone, Debug)]
pub struct SolidPicture<'a> {
    /// The space of all fields shown; its mesh gives the box.
    pub space: &'a Space<3>,
    /// Surfaces, such as the membrane; they hide what is behind them.
    pub surfaces: Vec<Surface>,
    /// Slices through the domain.
    pub slices: Vec<Slice<'a>>,
    /// Level-set functions whose zero line is drawn on every slice.
    pub interfaces: Vec<&'a [f64]>,
    /// The range of the colours, of slices and surfaces alike; [`Scale::of`] the field, or one for
    /// all frames of a film.
    pub scale: Scale,
    /// The colours; by default those that fit the values.
    pub colours: Option<ColourMap>,
    /// Lower and upper corner of the part of the domain that is shown, if not all of it: slices end
    /// there, surfaces do not.
    pub window: Option<[Point<3>; 2]>,
    /// Position of the viewer.
    pub view: View,
    /// Title, with the unit if there is one.
    pub title: &'a str,
    /// Time, shown at the upper right.
    pub time: Option<f64>,
    /// Largest width and height in pixels; the picture takes what the shape of the box needs.
    pub size: [usize; 2],
}

/// Pixels around the box, and beside them for the colour bar.
const SIDE: f64 = 66.0;
const TOP: f64 = 54.0;
const BOTTOM: f64 = 50.0;
const BAR: f64 = 84.0;
/// Smallest width and height of the drawing's place.
const SMALLEST: f64 = 130.0;

impl<'a> SolidPicture<'a> {
    /// An empty box, at most 860 by 760 pixels.
    pub fn new(space: &'a Space<3>, title: &'a str) -> SolidPicture<'a> {
        SolidPicture {
            space,
            surfaces: Vec::new(),
            slices: Vec::new(),
            interfaces: Vec::new(),
            scale: Scale::new(f64::INFINITY, f64::NEG_INFINITY),
            colours: None,
            window: None,
            view: View::default(),
            title,
            time: None,
            size: [860, 760],
        }
    }
    /// Draws it.
    ///
    /// # Errors
    /// A view that is not finite, a window without volume; a slice beside it; a field or surface
    /// with a wrong number of values (a defect of the caller).
    pub fn draw(&self) -> Result<Image> {
        let shown = self.shown()?;
        let (camera, place) = self.place(shown)?;
        let cut = |s: &Slice| CutPlane::new(self.space, s, &self.interfaces, &shown);
        let cuts = self.slices.iter().map(cut).collect::<Result<Vec<_>>>()?;
        self.surfaces.iter().try_for_each(Surface::check)?;
        let frame = BoxEdges::new(&camera, shown);
        let count = self.surfaces.len();
        let surfaces =
            self.surfaces.iter().enumerate().flat_map(|(k, s)| s.facets(&camera, k as u32));
        let slices =
            cuts.iter().enumerate().flat_map(|(k, s)| s.facets(&camera, (count + k) as u32));
        let facets = surfaces.chain(slices).collect();
        let canvas = Canvas {
            width: place.image[0],
            height: place.image[1],
            facets,
            strokes: frame.strokes(),
        };
        let (lights, colours) = (Lights::new(&camera), Colours::new(self.scale, self.colours));
        let mut image = canvas.draw(|f: &Facet, l| match self.surfaces.get(f.part as usize) {
            Some(surface) => surface.shade(f, l, &camera, &lights, &colours),
            None => cuts[f.part as usize - count].shade(f, l, &camera, &colours),
        });
        frame.draw_axes(&mut image);
        if self.has_bar() {
            let at = [place.image[0] - BAR as usize, TOP as usize + place.height / 10];
            draw_bar(&mut image, &colours, at, place.height * 4 / 5);
        }
        draw_title(&mut image, self.title, self.time, 24.0);
        Ok(image)
    }
    /// The corners of the box that is shown.
    fn shown(&self) -> Result<[Point<3>; 2]> {
        let [low, high] = self.window.unwrap_or_else(|| self.space.mesh().bounding_box().into());
        if (0..3).all(|k| low[k] < high[k] && (high[k] - low[k]).is_finite()) {
            return Ok([low, high]);
        }
        Err(Error::input("the box of a picture has no volume")
            .value(format!("from {:?} to {:?}", low.as_slice(), high.as_slice()))
            .remedy("give the lower corner, then the upper one"))
    }
    /// True if a surface is coloured by numbers.
    fn has_bar(&self) -> bool {
        !self.slices.is_empty() || self.surfaces.iter().any(|s| matches!(s.paint, Paint::Scalar(_)))
    }
    /// The camera, and where the drawing lies.
    fn place(&self, shown: [Point<3>; 2]) -> Result<(Camera, Place)> {
        let View { azimuth, elevation, .. } = self.view;
        if !(azimuth.is_finite() && elevation.is_finite()) {
            return Err(Error::input("the direction of view is not finite")
                .value(format!("azimuth {azimuth}, elevation {elevation}"))
                .remedy("give angles in degrees"));
        }
        let right = if self.has_bar() { SIDE + BAR } else { SIDE };
        let room = [self.size[0] as f64 - SIDE - right, self.size[1] as f64 - TOP - BOTTOM]
            .map(|r| r.max(SMALLEST));
        let mut camera = Camera::new(&self.view, shown);
        let taken = camera.fit(&BoxEdges::vertices(shown), room);
        let place = taken.map(|t| t.max(SMALLEST));
        camera.shift([SIDE + 0.5 * (place[0] - taken[0]), TOP + 0.5 * (place[1] - taken[1])]);
        // Films in H.264 want even numbers.
        let even = |n: f64| 2 * (0.5 * n).floor() as usize;
        let image = [even(SIDE + place[0] + right), even(TOP + place[1] + BOTTOM)];
        Ok((camera, Place { image, height: place[1] as usize }))
    }
}

/// Sizes in pixels.
struct Place {
    /// Width and height of the picture.
    image: [usize; 2],
    /// Height of the drawing.
    height: usize,
}
