//! Pixels: an image, anti-aliased strokes on it, and PNG.

use crate::base::{Error, Result};

/// A line segment in pixels, from the upper left corner of the image.
pub(super) type Segment = [[f64; 2]; 2];

/// A colour and how much of what is below it covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ink {
    pub rgb: [u8; 3],
    pub opacity: f32,
}

impl Ink {
    pub const fn solid(rgb: [u8; 3]) -> Ink {
        Ink { rgb, opacity: 1.0 }
    }
}

/// An image of 8-bit red, green and blue, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Image {
    /// A white image.
    pub(super) fn white(width: usize, height: usize) -> Image {
        Image { width, height, rgb: vec![255; 3 * width * height] }
    }
    /// An image of the given pixels, row by row from the top.
    pub(super) fn new(width: usize, height: usize, rgb: Vec<u8>) -> Image {
        Image { width, height, rgb }
    }
    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }
    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }
    /// Red, green and blue of all pixels, row by row from the top.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }
    /// The colour of a pixel, column and row counted from the upper left; white outside of the
    /// image.
    pub fn pixel(&self, x: usize, y: usize) -> [u8; 3] {
        let at = 3 * (x + y * self.width);
        match self.rgb.get(at..at + 3) {
            Some(&[r, g, b]) if x < self.width => [r, g, b],
            _ => [255; 3],
        }
    }
    /// Lays ink over a pixel; nothing outside of the image.
    pub(super) fn blend(&mut self, x: usize, y: usize, ink: Ink, coverage: f32) {
        let at = 3 * (x + y * self.width);
        let a = ink.opacity * coverage;
        if x < self.width
            && let Some(pixel) = self.rgb.get_mut(at..at + 3)
        {
            for (below, above) in pixel.iter_mut().zip(ink.rgb) {
                *below = (f32::from(*below) * (1.0 - a) + f32::from(above) * a).round() as u8;
            }
        }
    }
    /// Draws segments with round ends. Where several meet, the ink is laid once.
    pub(super) fn stroke(&mut self, segments: &[Segment], width: f64, ink: Ink) {
        let reach = 0.5 * width + 0.5;
        let range = |a: f64, b: f64, n: usize| {
            let first = (a.min(b) - reach).floor().clamp(0.0, n as f64) as usize;
            first..((a.max(b) + reach).ceil().clamp(0.0, n as f64) as usize).max(first)
        };
        let rows = |s: &Segment| range(s[0][1], s[1][1], self.height);
        let columns = |s: &Segment| range(s[0][0], s[1][0], self.width);
        let (top, bottom) = segments
            .iter()
            .map(rows)
            .fold((usize::MAX, 0), |(a, b), r| (a.min(r.start), b.max(r.end)));
        let (left, right) = segments
            .iter()
            .map(columns)
            .fold((usize::MAX, 0), |(a, b), c| (a.min(c.start), b.max(c.end)));
        if top >= bottom || left >= right {
            return;
        }
        let mut covered = vec![0f32; (bottom - top) * (right - left)];
        for s in segments {
            for y in rows(s) {
                for x in columns(s) {
                    let (far, _) = distance([x as f64 + 0.5, y as f64 + 0.5], s);
                    let c = &mut covered[(y - top) * (right - left) + x - left];
                    *c = c.max((reach - far).clamp(0.0, width.min(1.0)) as f32);
                }
            }
        }
        for (i, &c) in covered.iter().enumerate() {
            if c > 0.0 {
                self.blend(left + i % (right - left), top + i / (right - left), ink, c);
            }
        }
    }
    /// Fills the rectangle of the given left upper corner and size.
    pub(super) fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2], rgb: [u8; 3]) {
        for row in y..y + height {
            for column in x..x + width {
                self.blend(column, row, Ink::solid(rgb), 1.0);
            }
        }
    }
    /// The image as a PNG file.
    ///
    /// # Errors
    /// None is known; what the encoder reports is passed on.
    pub fn png(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        let written = encoder.write_header().and_then(|mut w| {
            w.write_image_data(&self.rgb)?;
            w.finish()
        });
        written.map_err(|e| Error::internal("cannot encode a picture").value(e))?;
        Ok(bytes)
    }
}

/// Distance of a point to a segment, and where on it the nearest point is: 0 at its start, 1 at its
/// end.
pub(super) fn distance(p: [f64; 2], [a, b]: &Segment) -> (f64, f64) {
    let (d, r) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let length = d[0] * d[0] + d[1] * d[1];
    let s = if length > 0.0 { ((r[0] * d[0] + r[1] * d[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    // Not hypot, which takes most of the time of a picture for nothing: pixels are far from
    // overflow.
    (((r[0] - s * d[0]).powi(2) + (r[1] - s * d[1]).powi(2)).sqrt(), s)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Ink = Ink::solid([0; 3]);

    #[test]
    fn a_stroke_covers_its_area() {
        // The ink of an anti-aliased line is its length times its width, whatever its direction.
        for angle in [0.0f64, 0.3, 0.785, 1.2] {
            let mut image = Image::white(200, 200);
            let d = [60.0 * angle.cos(), 60.0 * angle.sin()];
            image.stroke(&[[[100.3 - d[0], 99.6 - d[1]], [100.3 + d[0], 99.6 + d[1]]]], 3.0, BLACK);
            let ink: f64 = image.rgb().iter().step_by(3).map(|&v| 1.0 - f64::from(v) / 255.0).sum();
            assert!((ink - 120.0 * 3.0 - 7.07).abs() < 6.0, "{angle}: {ink}");
        }
    }

    #[test]
    fn strokes_that_meet_do_not_darken_each_other() {
        let (mut one, mut two) = (Image::white(40, 20), Image::white(40, 20));
        let ink = Ink { rgb: [0; 3], opacity: 0.5 };
        one.stroke(&[[[5.0, 10.0], [35.0, 10.0]]], 2.0, ink);
        two.stroke(&[[[5.0, 10.0], [20.0, 10.0]], [[20.0, 10.0], [35.0, 10.0]]], 2.0, ink);
        assert_eq!(one, two);
        assert_eq!(one.pixel(20, 10), [128; 3]);
    }

    #[test]
    fn strokes_outside_and_not_finite_are_harmless() {
        let mut image = Image::white(10, 10);
        for bad in [-1e9, 1e9, f64::NAN, f64::INFINITY] {
            image.stroke(&[[[bad, 5.0], [bad, bad]]], 2.0, BLACK);
        }
        image.fill([8, 8], [5, 5], [1, 2, 3]);
        assert_eq!(image.pixel(9, 9), [1, 2, 3]);
        assert_eq!(image.pixel(0, 0), [255; 3]);
    }

    #[test]
    fn a_png_comes_back_as_it_was() {
        let mut image = Image::white(30, 20);
        image.stroke(&[[[0.0, 0.0], [30.0, 20.0]]], 4.0, Ink::solid([200, 30, 60]));
        let bytes = image.png().unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut rgb).unwrap();
        assert_eq!((info.width, info.height), (30, 20));
        assert_eq!(rgb, image.rgb());
    }
}
