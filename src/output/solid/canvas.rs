//! Triangles and lines with depth, drawn sample by sample, several samples a pixel.

use super::super::raster::{Image, Segment, distance};
use super::camera::Spot;
use rayon::prelude::*;

/// Samples of a pixel in each direction.
const FINE: usize = 3;
/// Rows of pixels that are worked on together.
const BAND: usize = 16;
/// No triangle.
const NOTHING: u32 = u32::MAX;

/// A triangle in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    pub spots: [Spot; 3],
    /// The part of the scene it belongs to, and its number there.
    pub part: u32,
    pub number: u32,
}

/// Lines of one kind. Where several meet, the ink is laid once.
#[derive(Clone, Debug)]
pub(super) struct Stroke {
    pub lines: Vec<[Spot; 2]>,
    /// Pixels.
    pub width: f64,
    pub rgb: [u8; 3],
    /// Opacity where nothing is in front of it, and where something is.
    pub opacity: [f32; 2],
    /// Bias of a line towards the viewer, in units of [`Spot::near`].
    pub lift: f64,
}

/// Elements of a picture of the given size.
pub(super) struct Canvas {
    pub width: usize,
    pub height: usize,
    pub facets: Vec<Facet>,
    pub strokes: Vec<Stroke>,
}

/// The samples of some rows of pixels.
struct Band {
    columns: usize,
    /// First row of samples, and their number.
    first: usize,
    rows: usize,
    near: Vec<f64>,
    facet: Vec<u32>,
    rgb: Vec<[f32; 3]>,
}

impl Canvas {
    /// Draws on white. `shade` gives the colour, red to blue in 0 to 255, of a triangle at the
    /// point with the given weights of its corners in the picture; it is called once for each
    /// sample that shows a triangle.
    pub fn draw(&self, shade: impl Fn(&Facet, [f64; 3]) -> [f32; 3] + Sync) -> Image {
        let mut rgb = vec![255u8; 3 * self.width * self.height];
        rgb.par_chunks_mut(3 * self.width * BAND).enumerate().for_each(|(k, part)| {
            let rows = FINE * part.len() / (3 * self.width);
            let mut band = Band::new(FINE * self.width, FINE * BAND * k, rows);
            self.facets.iter().enumerate().for_each(|(i, f)| band.cover(f, i as u32));
            band.shade(&self.facets, &shade);
            self.strokes.iter().for_each(|s| band.stroke(s));
            band.resolve(part);
        });
        Image::new(self.width, self.height, rgb)
    }
}

/// The place of a spot in samples.
fn fine(s: &Spot) -> [f64; 2] {
    s.at.map(|v| v * FINE as f64)
}

impl Band {
    fn new(columns: usize, first: usize, rows: usize) -> Band {
        let n = columns * rows;
        Band {
            columns,
            first,
            rows,
            near: vec![f64::NEG_INFINITY; n],
            facet: vec![NOTHING; n],
            rgb: vec![[255.0; 3]; n],
        }
    }
    /// The samples whose centres lie within `reach` of the box of the points: columns, and rows of
    /// this band.
    fn range(&self, points: &[[f64; 2]], reach: f64) -> [std::ops::Range<usize>; 2] {
        let range = |axis: usize, first: usize, n: usize| {
            let (low, high) =
                points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| {
                    (a.min(p[axis]), b.max(p[axis]))
                });
            let at = |v: f64| (v - 0.5 - first as f64).clamp(0.0, n as f64);
            let (a, b) =
                (at((low - reach).ceil()) as usize, (at(high + reach) + 1.0).floor() as usize);
            a..b.min(n).max(a)
        };
        [range(0, 0, self.columns), range(1, self.first, self.rows)]
    }
    /// Enters a triangle where nothing nearer is there yet.
    fn cover(&mut self, f: &Facet, number: u32) {
        let p = f.spots.each_ref().map(fine);
        if !p.iter().flatten().all(|v| v.is_finite()) {
            return;
        }
        let Some(weights) = Weights::new(&p) else { return };
        let [columns, rows] = self.range(&p, 0.0);
        for row in rows {
            for column in columns.clone() {
                let l = weights.at([column as f64 + 0.5, (self.first + row) as f64 + 0.5]);
                // A sample on an edge belongs to both triangles; the tolerance keeps rounding from
                // leaving it to none.
                if l.iter().any(|&l| l < -1e-9) {
                    continue;
                }
                let near = l[0] * f.spots[0].near + l[1] * f.spots[1].near + l[2] * f.spots[2].near;
                let i = row * self.columns + column;
                if near > self.near[i] {
                    (self.near[i], self.facet[i]) = (near, number);
                }
            }
        }
    }
    fn shade(&mut self, facets: &[Facet], shade: &impl Fn(&Facet, [f64; 3]) -> [f32; 3]) {
        // Neighbours mostly show the same triangle.
        let mut last = (NOTHING, None);
        for (i, &number) in self.facet.iter().enumerate().filter(|(_, n)| **n != NOTHING) {
            let f = &facets[number as usize];
            if last.0 != number {
                last = (number, Weights::new(&f.spots.each_ref().map(fine)));
            }
            if let Some(weights) = &last.1 {
                let at =
                    [(i % self.columns) as f64 + 0.5, (self.first + i / self.columns) as f64 + 0.5];
                self.rgb[i] = shade(f, weights.at(at));
            }
        }
    }
    fn stroke(&mut self, stroke: &Stroke) {
        let reach = 0.5 * stroke.width * FINE as f64 + 0.5;
        let mut ink: Vec<f32> = Vec::new();
        for line in &stroke.lines {
            let segment: Segment = line.each_ref().map(fine);
            let [columns, rows] = self.range(&segment, reach);
            if columns.is_empty()
                || rows.is_empty()
                || !segment.iter().flatten().all(|v| v.is_finite())
            {
                continue;
            }
            ink.resize(self.near.len(), 0.0);
            for row in rows {
                for column in columns.clone() {
                    let p = [column as f64 + 0.5, (self.first + row) as f64 + 0.5];
                    let (far, s) = distance(p, &segment);
                    let covered = (reach - far).clamp(0.0, 1.0) as f32;
                    if covered > 0.0 {
                        let i = row * self.columns + column;
                        let near = line[0].near + s * (line[1].near - line[0].near) + stroke.lift;
                        ink[i] =
                            ink[i].max(covered * stroke.opacity[usize::from(near < self.near[i])]);
                    }
                }
            }
        }
        for (pixel, &a) in self.rgb.iter_mut().zip(&ink).filter(|(_, a)| **a > 0.0) {
            for (below, above) in pixel.iter_mut().zip(stroke.rgb) {
                *below += (f32::from(above) - *below) * a;
            }
        }
    }
    /// The means of the samples of each pixel.
    fn resolve(&self, out: &mut [u8]) {
        for (k, pixel) in out.chunks_exact_mut(3).enumerate() {
            let width = self.columns / FINE;
            let corner = FINE * (k / width) * self.columns + FINE * (k % width);
            for (c, value) in pixel.iter_mut().enumerate() {
                let samples = (0..FINE * FINE)
                    .map(|s| self.rgb[corner + s / FINE * self.columns + s % FINE][c]);
                *value =
                    (samples.sum::<f32>() / (FINE * FINE) as f32).round().clamp(0.0, 255.0) as u8;
            }
        }
    }
}

/// The weights of the corners of a triangle at the points of its plane.
struct Weights {
    origin: [f64; 2],
    /// Rows: gradients of the weights of the last two corners.
    gradient: [[f64; 2]; 2],
}

impl Weights {
    /// None if the triangle has no area.
    fn new(p: &[[f64; 2]; 3]) -> Option<Weights> {
        let [a, b] = [1, 2].map(|k| [p[k][0] - p[0][0], p[k][1] - p[0][1]]);
        let area = a[0] * b[1] - a[1] * b[0];
        let gradient = [[b[1] / area, -b[0] / area], [-a[1] / area, a[0] / area]];
        gradient
            .iter()
            .flatten()
            .all(|v| v.is_finite())
            .then_some(Weights { origin: p[0], gradient })
    }
    fn at(&self, p: [f64; 2]) -> [f64; 3] {
        let d = [p[0] - self.origin[0], p[1] - self.origin[1]];
        let [a, b] = self.gradient.map(|g| g[0] * d[0] + g[1] * d[1]);
        [1.0 - a - b, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spot(x: f64, y: f64, near: f64) -> Spot {
        Spot { at: [x, y], near, weight: 1.0 }
    }

    fn facet(spots: [Spot; 3], part: u32) -> Facet {
        Facet { spots, part, number: 0 }
    }

    fn colour(f: &Facet, _: [f64; 3]) -> [f32; 3] {
        if f.part == 0 { [200.0, 0.0, 0.0] } else { [0.0, 0.0, 200.0] }
    }

    /// A red triangle that leans through a blue one: red is nearer on the right.
    fn two(order: [usize; 2]) -> Image {
        let both = [
            facet([spot(0.0, 0.0, -1.0), spot(40.0, 0.0, 1.0), spot(0.0, 40.0, -1.0)], 0),
            facet([spot(0.0, 0.0, 0.0), spot(40.0, 0.0, 0.0), spot(0.0, 40.0, 0.0)], 1),
        ];
        Canvas {
            width: 40,
            height: 40,
            facets: order.map(|k| both[k]).to_vec(),
            strokes: Vec::new(),
        }
        .draw(colour)
    }

    #[test]
    fn the_nearer_triangle_is_seen_at_each_pixel_whatever_the_order() {
        let image = two([0, 1]);
        assert_eq!(image, two([1, 0]));
        assert_eq!(image.pixel(5, 5), [0, 0, 200]);
        assert_eq!(image.pixel(30, 5), [200, 0, 0]);
        assert_eq!(image.pixel(30, 30), [255; 3]);
    }

    #[test]
    fn triangles_that_share_an_edge_leave_no_gap_and_cover_their_area() {
        let corner = [
            spot(3.3, 2.1, 0.0),
            spot(35.2, 7.7, 0.0),
            spot(30.4, 33.1, 0.0),
            spot(5.9, 28.3, 0.0),
        ];
        let facets = vec![
            facet([corner[0], corner[1], corner[2]], 0),
            facet([corner[2], corner[3], corner[0]], 0),
        ];
        let image = Canvas { width: 40, height: 40, facets, strokes: Vec::new() }.draw(colour);
        let ink: f64 = image.rgb().chunks_exact(3).map(|p| 1.0 - f64::from(p[1]) / 255.0).sum();
        let area = |a: &Spot, b: &Spot| 0.5 * (a.at[0] * b.at[1] - a.at[1] * b.at[0]);
        let exact: f64 = (0..4).map(|k| area(&corner[k], &corner[(k + 1) % 4])).sum();
        assert!((ink / exact - 1.0).abs() < 5e-3, "{ink} {exact}");
        for k in 8..28 {
            assert_eq!(image.pixel(k, k), [200, 0, 0]);
        }
    }

    #[test]
    fn lines_behind_a_triangle_are_dimmed() {
        let square =
            vec![facet([spot(0.0, 0.0, 0.0), spot(30.0, 0.0, 0.0), spot(0.0, 60.0, 0.0)], 1)];
        let line = |y: f64, near: f64| [spot(0.0, y, near), spot(40.0, y, near)];
        let stroke = Stroke {
            lines: vec![line(5.5, -0.1), line(15.5, 0.1)],
            width: 3.0,
            rgb: [0; 3],
            opacity: [1.0, 0.25],
            lift: 0.0,
        };
        let image =
            Canvas { width: 40, height: 20, facets: square, strokes: vec![stroke] }.draw(colour);
        assert_eq!(image.pixel(5, 5), [0, 0, 150]);
        assert_eq!(image.pixel(5, 15), [0; 3]);
        assert_eq!(image.pixel(37, 5), [0; 3]);
    }

    #[test]
    fn what_is_flat_outside_or_not_finite_is_harmless() {
        let bad = [f64::NAN, f64::INFINITY, -1e9];
        let facets = bad
            .map(|v| facet([spot(v, -1.0, 0.0), spot(-2.0, -5.0, 0.0), spot(v, v, v)], 0))
            .to_vec();
        let strokes = bad.map(|v| Stroke {
            lines: vec![[spot(v, -9.0, 0.0), spot(v, v, 0.0)]],
            width: 2.0,
            rgb: [0; 3],
            opacity: [1.0; 2],
            lift: 0.0,
        });
        let image =
            Canvas { width: 10, height: 10, facets, strokes: strokes.to_vec() }.draw(colour);
        assert_eq!(image, Image::white(10, 10));
    }
}
