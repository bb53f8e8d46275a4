//! Grey images: read from PNG files and written as such.

use super::file::read;
use crate::base::{Error, Result};
use png::{BitDepth, ColorType, Decoder, Encoder, Limits, Transformations};
use std::io::Cursor;
use std::path::Path;

/// Grey levels between 0 (black) and 1 (white), row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyImage {
    width: usize,
    height: usize,
    levels: Vec<f64>,
}

/// More pixels are refused: an image is held in memory, and so is a mesh for it.
const MOST_PIXELS: usize = 1 << 24;
/// Weights of red, green and blue in the grey level (ITU-R BT.601).
const LUMA: [f64; 3] = [0.299, 0.587, 0.114];
/// First bytes of other formats that an image is often kept in.
const OTHERS: [(&[u8], &str); 7] = [
    (b"\xff\xd8\xff", "JPEG"),
    (b"GIF8", "GIF"),
    (b"BM", "BMP"),
    (b"II*\0", "TIFF"),
    (b"MM\0*", "TIFF"),
    (b"RIFF", "WebP"),
    (b"P", "PNM"),
];

impl GreyImage {
    /// An image of `width` columns from `levels`, row by row from the top; levels beyond 0 and 1
    /// are written as these.
    ///
    /// # Errors
    /// The number of levels is no multiple of the width.
    pub fn new(width: usize, levels: Vec<f64>) -> Result<GreyImage> {
        if width == 0 || levels.is_empty() || !levels.len().is_multiple_of(width) {
            return Err(Error::internal("an image needs full rows")
                .value(format!("{} levels in rows of {width}", levels.len())));
        }
        Ok(GreyImage { width, height: levels.len() / width, levels })
    }

    /// Width and height of the image in a PNG file, from its first bytes.
    ///
    /// # Errors
    /// Those of [`read`](Self::read), as far as the first bytes tell.
    pub fn size(path: &Path) -> Result<[usize; 2]> {
        let bytes = bytes_of(path)?;
        let mut decoder = decoder(&bytes, path)?;
        let info = decoder.read_header_info().map_err(|e| damaged(path, &e))?;
        checked_size(path, [info.width, info.height])
    }

    /// Reads a PNG file: grey, colour or with a palette, 1 to 16 bits a channel. Colours become
    /// grey by `0.299 R + 0.587 G + 0.114 B` of the values as they are stored.
    ///
    /// # Errors
    /// Of kind [`Input`](crate::base::Kind::Input): the file cannot be read, is in another format
    /// or damaged, is too large, or is transparent somewhere.
    pub fn read(path: &Path) -> Result<GreyImage> {
        let bytes = bytes_of(path)?;
        let mut decoder = decoder(&bytes, path)?;
        decoder.set_transformations(Transformations::EXPAND);
        let mut reader = decoder.read_info().map_err(|e| damaged(path, &e))?;
        let [width, height] = checked_size(path, [reader.info().width, reader.info().height])?;
        let mut data =
            vec![0; reader.output_buffer_size().ok_or_else(|| too_large(path, [width, height]))?];
        let info = reader.next_frame(&mut data).map_err(|e| damaged(path, &e))?;
        data.truncate(info.buffer_size());
        let values: Vec<f64> = match info.bit_depth {
            BitDepth::Sixteen => data
                .as_chunks::<2>()
                .0
                .iter()
                .map(|v| f64::from(u16::from_be_bytes(*v)) / f64::from(u16::MAX))
                .collect(),
            _ => data.iter().map(|v| f64::from(*v) / f64::from(u8::MAX)).collect(),
        };
        // From the difference to green, so that greys stay what they are.
        let colour = |c: &[f64]| c[1] + LUMA[0] * (c[0] - c[1]) + LUMA[2] * (c[2] - c[1]);
        let channels = info.color_type.samples();
        let pixels = values.chunks_exact(channels);
        if matches!(info.color_type, ColorType::GrayscaleAlpha | ColorType::Rgba)
            && let Some(k) = pixels.clone().position(|p| p[channels - 1] < 1.0)
        {
            return Err(Error::input(
                "the image is transparent, and what is behind it is not known",
            )
            .at(path.display().to_string())
            .value(format!("pixel in column {}, row {}", k % width, k / width))
            .remedy("lay it on a background: magick in.png -background white -flatten out.png"));
        }
        let levels = pixels.map(|p| if channels < 3 { p[0] } else { colour(&p[..3]) }).collect();
        GreyImage::new(width, levels)
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }
    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }
    /// The levels, row by row from the top.
    pub fn levels(&self) -> &[f64] {
        &self.levels
    }
    /// The level at `x` columns from the left and `y` rows from the bottom: that of the pixel
    /// there, beyond the image of the nearest one.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let within = |v: f64, n: usize| (v.floor().max(0.0) as usize).min(n - 1);
        let row = self.height - 1 - within(y, self.height);
        self.levels[row * self.width + within(x, self.width)]
    }
    /// The mean of the levels over the square of a pixel around a place as in [`at`](Self::at):
    /// linear in each direction between the middles of pixels, and where four pixels meet their
    /// mean.
    pub fn smooth(&self, x: f64, y: f64) -> f64 {
        let (left, below) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (s, t) = (x - 0.5 - left, y - 0.5 - below);
        let level = |i: f64, j: f64| self.at(left + i + 0.5, below + j + 0.5);
        (1.0 - t) * ((1.0 - s) * level(0.0, 0.0) + s * level(1.0, 0.0))
            + t * ((1.0 - s) * level(0.0, 1.0) + s * level(1.0, 1.0))
    }

    /// The image as a PNG file of 8 bits.
    ///
    /// # Errors
    /// None is known; what the encoder reports is passed on.
    pub fn png(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(ColorType::Grayscale);
        encoder.set_depth(BitDepth::Eight);
        let data: Vec<u8> = self
            .levels
            .iter()
            .map(|v| (v.clamp(0.0, 1.0) * f64::from(u8::MAX)).round() as u8)
            .collect();
        let written = encoder.write_header().and_then(|mut w| {
            w.write_image_data(&data)?;
            w.finish()
        });
        written.map_err(|e| Error::internal("cannot encode an image").value(e))?;
        Ok(bytes)
    }
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    read(path).map_err(|e| {
        Error::input(format!("the image cannot be read: {}", e.wrong_value()))
            .at(path.display().to_string())
            .value(path.display())
            .remedy("correct its name; it is looked for relative to the folder of the scene")
    })
}

/// A decoder of a file that begins like a PNG.
fn decoder<'a>(bytes: &'a [u8], path: &Path) -> Result<Decoder<Cursor<&'a [u8]>>> {
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        let what = OTHERS.iter().find(|(first, _)| bytes.starts_with(first));
        let what = what.map_or_else(
            || format!("{} bytes", bytes.len()),
            |(_, name)| format!("it looks like {name}"),
        );
        return Err(Error::input("the image is not a PNG file")
            .at(path.display().to_string())
            .value(what)
            .remedy("convert it, for example with ImageMagick: magick in.jpg out.png"));
    }
    // 8 bytes a pixel at most, and one a row.
    let limits = Limits { bytes: 10 * MOST_PIXELS };
    Ok(Decoder::new_with_limits(Cursor::new(bytes), limits))
}

fn checked_size(path: &Path, size: [u32; 2]) -> Result<[usize; 2]> {
    let size = size.map(|n| n as usize);
    if size[0].saturating_mul(size[1]) > MOST_PIXELS {
        return Err(too_large(path, size));
    }
    Ok(size)
}

fn too_large(path: &Path, [width, height]: [usize; 2]) -> Error {
    Error::input(format!("the image is too large: at most {MOST_PIXELS} pixels are read"))
        .at(path.display().to_string())
        .value(format!("{width} x {height} pixels"))
        .remedy("make it smaller: magick in.png -resize 25% out.png")
}

fn damaged(path: &Path, e: &png::DecodingError) -> Error {
    Error::input("the image cannot be decoded")
        .at(path.display().to_string())
        .value(e)
        .remedy("write it again with the program that made it; it must be a whole PNG file")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Kind;
    use std::fs;

    /// A PNG file with these pixels.
    fn png(path: &Path, size: [u32; 2], colour: ColorType, depth: BitDepth, data: &[u8]) {
        let mut encoder = Encoder::new(fs::File::create(path).unwrap(), size[0], size[1]);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(vec![0, 0, 0, 255, 255, 255, 255, 0, 0]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
    }

    #[test]
    fn an_image_comes_back_and_every_kind_of_pixel_is_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let image = GreyImage::new(3, vec![0.0, 1.0, 0.2, 0.4, 0.6, 0.8]).unwrap();
        fs::write(&path, image.png().unwrap()).unwrap();
        assert_eq!(GreyImage::size(&path).unwrap(), [3, 2]);
        assert_eq!(GreyImage::read(&path).unwrap(), image);
        let levels = |size, colour, depth, data: &[u8]| {
            png(&path, size, colour, depth, data);
            GreyImage::read(&path).unwrap().levels().to_vec()
        };
        assert_eq!(
            levels([2, 1], ColorType::Grayscale, BitDepth::Sixteen, &[0xff, 0xff, 0x80, 0]),
            [1.0, 32768.0 / 65535.0]
        );
        assert_eq!(
            levels([3, 1], ColorType::Grayscale, BitDepth::One, &[0b1010_0000]),
            [1.0, 0.0, 1.0]
        );
        assert_eq!(
            levels([3, 1], ColorType::Indexed, BitDepth::Eight, &[1, 0, 2]),
            [1.0, 0.0, 0.299]
        );
        let colours = levels([2, 1], ColorType::Rgb, BitDepth::Eight, &[0, 255, 0, 0, 0, 255]);
        assert!((colours[0] - 0.587).abs() < 1e-15 && colours[1] == 0.114);
        assert_eq!(levels([1, 1], ColorType::GrayscaleAlpha, BitDepth::Eight, &[51, 255]), [0.2]);
    }

    #[test]
    fn what_is_no_image_that_can_be_used_is_told() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        let told = |part: &str| {
            let e = GreyImage::read(&path).unwrap_err();
            assert!(
                e.to_string().contains(part) && e.kind() == Kind::Input && !e.advice().is_empty(),
                "{part}: {e}"
            );
        };
        told("the image cannot be read");
        fs::write(&path, b"\xff\xd8\xff\xe0 and so on").unwrap();
        told("it looks like JPEG");
        fs::write(&path, b"hello").unwrap();
        told("5 bytes");
        let whole = GreyImage::new(9, vec![0.5; 81]).unwrap().png().unwrap();
        for cut in 8..whole.len() - 20 {
            fs::write(&path, &whole[..cut]).unwrap();
            told("cannot be decoded");
        }
        png(&path, [2, 1], ColorType::Rgba, BitDepth::Eight, &[0, 0, 0, 255, 0, 0, 0, 254]);
        told("column 1, row 0");
        let mut wide = whole;
        // Width and height of the header, whose check sum comes after them.
        wide[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
        fs::write(&path, &wide).unwrap();
        assert!(GreyImage::read(&path).is_err());
        png(&path, [5000, 4000], ColorType::Grayscale, BitDepth::One, &vec![0; 625 * 4000]);
        told("5000 x 4000 pixels");
        assert!(GreyImage::size(&path).is_err());
        assert!(GreyImage::new(2, vec![0.0; 3]).is_err());
    }

    #[test]
    fn places_are_counted_from_the_lower_left() {
        let image = GreyImage::new(2, vec![0.1, 0.2, 0.3, 0.4]).unwrap();
        assert_eq!(
            [image.at(0.5, 0.5), image.at(1.5, 0.5), image.at(0.5, 1.5), image.at(7.0, 9.0)],
            [0.3, 0.4, 0.1, 0.2]
        );
        assert_eq!(image.at(-3.0, f64::NAN), 0.3);
        assert!(
            (image.smooth(1.0, 1.0) - 0.25).abs() < 1e-15
                && (image.smooth(1.5, 1.0) - 0.3).abs() < 1e-15
        );
        assert_eq!(image.smooth(0.5, 1.5), 0.1);
    }
}
