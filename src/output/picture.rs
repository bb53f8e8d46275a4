//! Pictures of fields in the plane: colours, colour bar, level sets, arrows, mesh.

use super::clip::clipped;
use super::colours::{ColourMap, Colours, Scale};
use super::field::{FieldData, on_nodes};
use super::legend::{QUIET, draw_bar, draw_title};
use super::lettering::{self, Align};
use super::numbers::{tick_text, ticks};
use super::raster::{Image, Ink, Segment};
use super::sampling::Lattice;
use crate::base::Result;
use crate::fem::Space;
use crate::mesh::Point;
use nalgebra::SVector;

/// A picture of a field. Pixels are evaluated in the true finite element, four to a pixel.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// The space of all fields shown; on a P2 space a field may also be P1.
    pub space: &'a Space<2>,
    /// The field that is coloured; a vector field by its length.
    pub field: FieldData<'a, 2>,
    /// The range of the colours; [`Scale::of`] the field, or one for all frames of a film.
    pub scale: Scale,
    /// The colours; by default those that fit the values. On greys level sets are drawn in a
    /// colour.
    pub colours: Option<ColourMap>,
    /// Lower and upper corner of the part of the plane that is shown, if not the whole domain.
    pub window: Option<[Point<2>; 2]>,
    /// Title, with the unit if there is one.
    pub title: &'a str,
    /// Time, shown at the upper right.
    pub time: Option<f64>,
    /// Level-set functions whose zero line is drawn.
    pub interfaces: Vec<&'a [f64]>,
    /// A velocity drawn as arrows on a coarse lattice.
    pub arrows: Option<Arrows<'a>>,
    /// Draws the edges of the mesh.
    pub mesh: bool,
    /// Largest width and height in pixels; the picture takes what the shape of the domain needs.
    pub size: [usize; 2],
}

/// A velocity to be drawn as arrows, whose length grows with the root of the speed.
#[derive(Clone, Copy, Debug)]
pub struct Arrows<'a> {
    /// The velocity at the nodes.
    pub velocity: &'a [SVector<f64, 2>],
    /// The speed of the longest arrow; for a film the greatest of all frames.
    pub fastest: f64,
}

/// Pixels around the drawing.
const LEFT: f64 = 58.0;
const RIGHT: f64 = 116.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 42.0;
/// Smallest height of the colour bar, and smallest width of the drawing's place.
const SMALLEST: f64 = 130.0;
/// Pixels between arrows.
const SPACING: f64 = 30.0;

const LINE: Ink = Ink::solid([12, 12, 16]);
/// On greys.
const LINE_ON_GREY: Ink = Ink::solid([224, 58, 22]);

impl<'a> Picture<'a> {
    /// A picture of `field` alone, in the scale that fits it, at most 760 by 680 pixels.
    pub fn new(space: &'a Space<2>, field: FieldData<'a, 2>, title: &'a str) -> Picture<'a> {
        let scale = Scale::of(field);
        Picture {
            space,
            field,
            scale,
            colours: None,
            window: None,
            title,
            time: None,
            interfaces: Vec::new(),
            arrows: None,
            mesh: false,
            size: [760, 680],
        }
    }
    /// Draws it.
    ///
    /// # Errors
    /// A field has a wrong number of values (a defect of the caller).
    pub fn draw(&self) -> Result<Image> {
        let area = PlotArea::of(self);
        let mut image = Image::white(area.image[0], area.image[1]);
        let colours = Colours::new(self.scale, self.colours);
        self.colour(&area, &colours, &mut image)?;
        if self.mesh {
            image.stroke(&self.edges(&area, false), 0.7, Ink { rgb: [0; 3], opacity: 0.32 });
        }
        if let Some(arrows) = &self.arrows {
            self.draw_arrows(&area, arrows, colours.signed, &mut image)?;
        }
        for phi in &self.interfaces {
            self.draw_interface(&area, &on_nodes(self.space, "level set", phi)?, &mut image);
        }
        image.stroke(&self.edges(&area, true), 1.2, QUIET);
        self.draw_axes(&area, &mut image);
        let bar = [area.image[0] - RIGHT as usize + 24, TOP as usize];
        draw_bar(&mut image, &colours, bar, area.size[1].max(SMALLEST as usize));
        draw_title(&mut image, self.title, self.time, LEFT);
        Ok(image)
    }
    /// Fills the domain with colours.
    fn colour(&self, area: &PlotArea, colours: &Colours, image: &mut Image) -> Result<()> {
        let opaque = |v: f64| {
            let [r, g, b] = colours.of(v);
            [r, g, b, 255]
        };
        let (mesh, lattice) = (self.space.mesh(), area.lattice(2.0));
        let samples = match self.field {
            FieldData::Scalar(f) => {
                let f = on_nodes(self.space, self.title, f)?;
                lattice.sample(mesh, [0u8; 4], |c, l| opaque(self.space.value(&f, c, l)))
            }
            FieldData::Vector(f) => {
                let f = on_nodes(self.space, self.title, f)?;
                lattice.sample(mesh, [0u8; 4], |c, l| opaque(self.space.value(&f, c, l).norm()))
            }
        };
        for y in 0..area.size[1] {
            for x in 0..area.size[0] {
                let four = [0, 1, lattice.columns, lattice.columns + 1]
                    .map(|k| samples[2 * y * lattice.columns + 2 * x + k]);
                let inside = four.iter().filter(|s| s[3] > 0).count() as u16;
                if inside > 0 {
                    let mean = |i: usize| {
                        (four.iter().map(|s| u16::from(s[i])).sum::<u16>() / inside) as u8
                    };
                    let ink = Ink::solid([mean(0), mean(1), mean(2)]);
                    image.blend(
                        area.corner[0] + x,
                        area.corner[1] + y,
                        ink,
                        f32::from(inside) / 4.0,
                    );
                }
            }
        }
        Ok(())
    }
    /// Edges of the mesh, or only those on its boundary.
    fn edges(&self, area: &PlotArea, boundary: bool) -> Vec<Segment> {
        let mesh = self.space.mesh();
        let mut edges = Vec::new();
        for c in 0..mesh.cell_count() {
            let cell = mesh.cell(c);
            for (k, &other) in mesh.neighbours(c).iter().enumerate() {
                let open = other == crate::mesh::NONE;
                if open || (!boundary && (other as usize) < c) {
                    let ends = [(k + 1) % 3, (k + 2) % 3]
                        .map(|v| area.pixel(&mesh.points()[cell[v] as usize]));
                    edges.extend(clipped(&ends, area.frame()));
                }
            }
        }
        edges
    }
    /// The zero line: a pixel is covered by its distance |phi| / |grad phi| to it. White beside it
    /// sets it off.
    fn draw_interface(&self, area: &PlotArea, phi: &[f64], image: &mut Image) {
        let lattice = area.lattice(1.0);
        let distance = lattice.sample(self.space.mesh(), f32::NAN, |c, l| {
            let value = self.space.value(phi, c, l).abs();
            (value / self.space.gradient(phi, c, l).norm() * area.scale) as f32
        });
        let on_grey = self.colours == Some(ColourMap::Grey);
        let line = if on_grey { LINE_ON_GREY } else { LINE };
        for (width, ink) in [(4.6, Ink { rgb: [255; 3], opacity: 0.7 }), (2.2, line)] {
            for (i, d) in distance.iter().enumerate().filter(|(_, d)| **d < 0.5 * width + 0.5) {
                let (x, y) = (i % lattice.columns, i / lattice.columns);
                image.blend(
                    area.corner[0] + x,
                    area.corner[1] + y,
                    ink,
                    (0.5 * width + 0.5 - d).min(1.0),
                );
            }
        }
    }
    fn draw_arrows(
        &self,
        area: &PlotArea,
        arrows: &Arrows,
        dark: bool,
        image: &mut Image,
    ) -> Result<()> {
        let u = on_nodes(self.space, "velocity", arrows.velocity)?;
        if !(arrows.fastest > 0.0 && arrows.fastest.is_finite()) {
            return Ok(());
        }
        let lattice = area.lattice(1.0 / SPACING);
        let zero = SVector::<f64, 2>::zeros();
        let samples = lattice.sample(self.space.mesh(), zero, |c, l| self.space.value(&u, c, l));
        let mut segments = Vec::new();
        for (i, v) in samples.iter().enumerate() {
            // By the root, so that slow parts have their direction too; the colours show how slow
            // they are.
            let length = 0.92 * SPACING * (v.norm() / arrows.fastest).min(1.0).sqrt();
            if length >= 4.0 {
                let middle = area.pixel(&lattice.point(i % lattice.columns, i / lattice.columns));
                let d = [v[0] / v.norm(), -v[1] / v.norm()];
                segments.extend(arrow(middle, d, length));
            }
        }
        // What lies around an arrow sets it off where the colours below are as light or as dark as
        // itself.
        let (arrow, around) =
            if dark { ([30, 34, 40], [255; 3]) } else { ([255; 3], [20, 24, 30]) };
        image.stroke(&segments, 3.0, Ink { rgb: around, opacity: 0.35 });
        image.stroke(&segments, 1.3, Ink { rgb: arrow, opacity: 0.9 });
        Ok(())
    }
    fn draw_axes(&self, area: &PlotArea, image: &mut Image) {
        let size = 8.5;
        for axis in 0..2 {
            let (low, high) = (area.low[axis], area.low[axis] + area.length[axis]);
            let room = area.size[axis] as f64 / 90.0;
            for v in ticks(low, high, room.clamp(2.0, 8.0)) {
                let text = tick_text(v, 0.2 * (high - low), low.abs().max(high.abs()));
                let mut at = SVector::<f64, 2>::from(area.low);
                at[axis] = v;
                let [x, y] = area.pixel(&at);
                if axis == 0 {
                    image.stroke(&[[[x, y + 2.0], [x, y + 6.0]]], 1.0, QUIET);
                    lettering::draw(image, &text, [x, y + 11.0 + size], size, Align::Centre, QUIET);
                } else {
                    image.stroke(&[[[x - 6.0, y], [x - 2.0, y]]], 1.0, QUIET);
                    lettering::draw(
                        image,
                        &text,
                        [x - 11.0, y + 0.5 * size],
                        size,
                        Align::Right,
                        QUIET,
                    );
                }
            }
        }
    }
}

/// An arrow around its middle, in direction `d`.
fn arrow(middle: [f64; 2], d: [f64; 2], length: f64) -> [Segment; 3] {
    let along = |s: f64, side: f64| {
        [middle[0] + s * d[0] - side * d[1], middle[1] + s * d[1] + side * d[0]]
    };
    let (head, tip) = ((0.36 * length).min(6.0), along(0.5 * length, 0.0));
    let wing = |side: f64| [tip, along(0.5 * length - head, side * 0.55 * head)];
    [[along(-0.5 * length, 0.0), tip], wing(1.0), wing(-1.0)]
}

/// Area of the picture that shows the domain.
struct PlotArea {
    /// Width and height of the picture.
    image: [usize; 2],
    /// Upper left corner of the drawing.
    corner: [usize; 2],
    /// Width and height of the drawing.
    size: [usize; 2],
    /// Lower left corner and lengths of the domain.
    low: [f64; 2],
    length: [f64; 2],
    /// Pixels per unit of length.
    scale: f64,
}

impl PlotArea {
    fn of(picture: &Picture) -> PlotArea {
        let (low, high) =
            picture.window.map_or_else(|| picture.space.mesh().bounding_box(), |[a, b]| (a, b));
        let length = [high[0] - low[0], high[1] - low[1]];
        let room = [picture.size[0] as f64 - LEFT - RIGHT, picture.size[1] as f64 - TOP - BOTTOM];
        let scale = (room[0].max(SMALLEST) / length[0]).min(room[1].max(SMALLEST) / length[1]);
        let size = length.map(|l| (l * scale).round().max(1.0));
        let place = size.map(|s| s.max(SMALLEST));
        // Films in H.264 want even numbers.
        let even = |n: f64| 2 * (0.5 * n).ceil() as usize;
        PlotArea {
            image: [even(LEFT + place[0] + RIGHT), even(TOP + place[1] + BOTTOM)],
            corner: [
                (LEFT + 0.5 * (place[0] - size[0])) as usize,
                (TOP + 0.5 * (place[1] - size[1])) as usize,
            ],
            size: size.map(|s| s as usize),
            low: [low[0], low[1]],
            length,
            scale,
        }
    }
    /// Left, top, right and bottom of the drawing, in pixels.
    fn frame(&self) -> [f64; 4] {
        let [x, y] = self.corner.map(|c| c as f64);
        [x, y, x + self.size[0] as f64, y + self.size[1] as f64]
    }
    /// Pixel of a point of the domain.
    fn pixel(&self, x: &SVector<f64, 2>) -> [f64; 2] {
        let at = |axis: usize| (x[axis] - self.low[axis]) / self.length[axis];
        [
            self.corner[0] as f64 + at(0) * self.size[0] as f64,
            self.corner[1] as f64 + (1.0 - at(1)) * self.size[1] as f64,
        ]
    }
    /// The centres of the pixels of the drawing, or of `fine` by `fine` parts of each (few and far
    /// if `fine < 1`).
    fn lattice(&self, fine: f64) -> Lattice {
        let count = self.size.map(|s| ((s as f64 * fine).round() as usize).max(1));
        let step = [self.length[0] / count[0] as f64, self.length[1] / count[1] as f64];
        Lattice {
            origin: [self.low[0] + 0.5 * step[0], self.low[1] + self.length[1] - 0.5 * step[1]],
            step: [step[0], -step[1]],
            columns: count[0],
            rows: count[1],
        }
    }
}

#[cfg(test)]
mod tests;
