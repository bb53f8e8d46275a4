//! Films from pictures: GIF always, MP4 if the program `ffmpeg` is on the PATH.

use super::file::{cannot_write, write_file};
use super::palette;
use super::raster::Image;
use crate::base::{Error, Result, Warning};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// The files of a film.
#[derive(Clone, Debug)]
pub struct Film {
    /// The GIF file.
    pub gif: PathBuf,
    /// The MP4 file, if `ffmpeg` was there and did its work.
    pub mp4: Option<PathBuf>,
    /// Failure of `ffmpeg`, if it failed.
    pub warning: Option<Warning>,
}

/// Writes `stem.gif` and, with `ffmpeg`, `stem.mp4`: one picture after the other, `per_second` of
/// them in a second. The last one stays a little before the film begins again. Pictures are taken
/// one by one and not kept.
///
/// # Errors
/// A picture that failed; no picture; pictures of different sizes; a file that cannot be written.
pub fn write_film(
    stem: &Path,
    pictures: impl IntoIterator<Item = Result<Image>>,
    per_second: f64,
) -> Result<Film> {
    film(stem, pictures, per_second, "ffmpeg")
}

fn film(
    stem: &Path,
    pictures: impl IntoIterator<Item = Result<Image>>,
    per_second: f64,
    ffmpeg: &str,
) -> Result<Film> {
    let (gif_path, mp4_path) = (stem.with_extension("gif"), stem.with_extension("mp4"));
    let mut pictures = pictures.into_iter().peekable();
    let size = match pictures.peek() {
        Some(Ok(first)) => [first.width(), first.height()],
        Some(Err(e)) => return Err(e.clone()),
        None => {
            return Err(
                Error::input("a film needs at least one picture").at(stem.display().to_string())
            );
        }
    };
    let mut gif = Gif::new(size, per_second)?;
    let mut mp4 = Mp4::start(ffmpeg, &mp4_path, size, per_second);
    while let Some(picture) = pictures.next() {
        let picture = picture?;
        if [picture.width(), picture.height()] != size {
            return Err(Error::internal("the pictures of a film differ in size")
                .at(stem.display().to_string()));
        }
        gif.add(&picture, pictures.peek().is_none())?;
        if let Some(mp4) = &mut mp4 {
            mp4.add(&picture);
        }
    }
    write_file(&gif_path, &gif.finish()?)?;
    match mp4.map(Mp4::finish) {
        None => Ok(Film { gif: gif_path, mp4: None, warning: None }),
        Some(Ok(())) => Ok(Film { gif: gif_path, mp4: Some(mp4_path), warning: None }),
        Some(Err(why)) => {
            let warning =
                Warning::new(format!("ffmpeg wrote no MP4 film: {why}"), "the GIF film is there");
            Ok(Film { gif: gif_path, mp4: None, warning: Some(warning) })
        }
    }
}

struct Gif {
    encoder: gif::Encoder<Vec<u8>>,
    size: [u16; 2],
    /// Hundredths of a second.
    delay: u16,
}

impl Gif {
    fn new([width, height]: [usize; 2], per_second: f64) -> Result<Gif> {
        let side = |n: usize| {
            u16::try_from(n).map_err(|_| Error::input("a film is too large for GIF").value(n))
        };
        let size = [side(width)?, side(height)?];
        let mut encoder = gif::Encoder::new(Vec::new(), size[0], size[1], &[]).map_err(failed)?;
        encoder.set_repeat(gif::Repeat::Infinite).map_err(failed)?;
        // Browsers slow down films with shorter delays than two hundredths.
        Ok(Gif { encoder, size, delay: (100.0 / per_second).round().clamp(2.0, 1000.0) as u16 })
    }
    fn add(&mut self, picture: &Image, last: bool) -> Result<()> {
        let (palette, pixels) = palette::reduce(picture.rgb());
        let mut frame =
            gif::Frame::from_palette_pixels(self.size[0], self.size[1], pixels, palette, None);
        frame.delay = if last { self.delay.max(150) } else { self.delay };
        self.encoder.write_frame(&frame).map_err(failed)
    }
    fn finish(self) -> Result<Vec<u8>> {
        self.encoder.into_inner().map_err(|e| Error::internal("cannot encode a film").value(e))
    }
}

fn failed(e: gif::EncodingError) -> Error {
    Error::internal("cannot encode a film").value(e)
}

/// A running `ffmpeg` that reads pictures from its standard input.
struct Mp4 {
    process: Child,
    part: PathBuf,
    path: PathBuf,
}

impl Mp4 {
    /// None if there is no such program.
    fn start(
        ffmpeg: &str,
        path: &Path,
        [width, height]: [usize; 2],
        per_second: f64,
    ) -> Option<Mp4> {
        let part = path.with_extension("mp4.part");
        let size = format!("{width}x{height}");
        let rate = per_second.to_string();
        let process = Command::new(ffmpeg)
            .args([
                "-loglevel",
                "error",
                "-y",
                "-f",
                "rawvideo",
                "-pix_fmt",
                "rgb24",
                "-s",
                &size,
                "-r",
                &rate,
            ])
            // Every player knows H.264 with halved colours, which needs even sides.
            .args([
                "-i",
                "-",
                "-vf",
                "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white",
                "-c:v",
                "libx264",
                "-crf",
                "18",
            ])
            .args(["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"])
            .arg(&part)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        process.ok().map(|process| Mp4 { process, part, path: path.into() })
    }
    fn add(&mut self, picture: &Image) {
        // If ffmpeg has ended, `finish` reports why.
        let _ = self.process.stdin.as_mut().map(|input| input.write_all(picture.rgb()));
    }
    fn finish(self) -> std::result::Result<(), String> {
        let output = self.process.wait_with_output().map_err(|e| e.to_string())?;
        if output.status.success() {
            return fs::rename(&self.part, &self.path)
                .map_err(|e| cannot_write(&self.path, &e).to_string());
        }
        let _ = fs::remove_file(&self.part);
        let said = String::from_utf8_lossy(&output.stderr);
        Err(format!("{}; {}", output.status, said.lines().last().unwrap_or("it said nothing")))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FieldData, Picture};
    use super::*;
    use crate::fem::{Element, Space};
    use crate::mesh::{Diagonals, rectangle};
    use std::sync::Arc;

    fn pictures(n: usize) -> Vec<Result<Image>> {
        let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [3, 3], Diagonals::Right).unwrap();
        let space = Space::new(&Arc::new(mesh), Element::P2);
        let f = space.interpolate(|x| x[0]);
        let picture =
            Picture { size: [300, 260], ..Picture::new(&space, FieldData::Scalar(&f), "a film") };
        (0..n).map(|i| Picture { time: Some(i as f64), ..picture.clone() }.draw()).collect()
    }

    #[test]
    fn a_gif_holds_every_picture_in_its_colours() {
        let dir = tempfile::tempdir().unwrap();
        let film = film(&dir.path().join("speed"), pictures(3), 20.0, "no-such-program").unwrap();
        assert!(film.mp4.is_none() && film.warning.is_none());
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(fs::File::open(film.gif).unwrap()).unwrap();
        let (expected, mut delays) = (pictures(3), Vec::new());
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            let image = expected[delays.len()].as_ref().unwrap();
            assert_eq!(
                (frame.width as usize, frame.height as usize),
                (image.width(), image.height())
            );
            let error: f64 = frame
                .buffer
                .chunks_exact(4)
                .zip(image.rgb().chunks_exact(3))
                .map(|(a, b)| f64::from(a[1].abs_diff(b[1])))
                .sum();
            assert!(error / ((image.width() * image.height()) as f64) < 2.0, "mean error {error}");
            delays.push(frame.delay);
        }
        assert_eq!(delays, [5, 5, 150]);
    }

    #[cfg(unix)]
    #[test]
    fn an_ffmpeg_that_fails_gives_a_warning_and_the_gif() {
        let dir = tempfile::tempdir().unwrap();
        let film = film(&dir.path().join("speed"), pictures(2), 20.0, "false").unwrap();
        assert!(film.warning.unwrap().what.contains("ffmpeg"));
        assert!(film.gif.exists() && fs::read_dir(dir.path()).unwrap().count() == 1);
    }

    #[test]
    fn films_of_nothing_and_of_different_sizes_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let stem = dir.path().join("speed");
        assert!(write_film(&stem, Vec::new(), 20.0).unwrap_err().what().contains("at least one"));
        let mut mixed = pictures(1);
        mixed.push(Ok(Image::white(10, 10)));
        assert!(write_film(&stem, mixed, 20.0).unwrap_err().what().contains("size"));
        let e = write_film(&dir.path().join("none/speed"), pictures(1), 20.0).unwrap_err();
        assert!(e.advice().contains("--out"), "{e}");
    }
}
