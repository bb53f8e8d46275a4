//! Pictures of the stored fields, and the film made of them.

use super::folder::{RunFolder, StoredFields};
use crate::base::{Error, Result, Warning};
use crate::mesh::Point;
use crate::output::solid::{Coat, Pattern, Slice, SolidPicture, Surface, View};
use crate::output::{
    Arrows, ColourMap, Content, FieldData, Figure, Film, Image, Picture, Scale, Snapshot,
    cannot_write, read_file, read_vtu, rounded, write_file, write_film,
};
use crate::scene::points::point;
use crate::scene::schema::{Cut, Quantity};
use rayon::prelude::*;
use std::path::PathBuf;

/// Pictures and film of a run.
#[derive(Default)]
pub(super) struct Gallery {
    pub files: Vec<PathBuf>,
    /// The film; the first, the middle and the last picture.
    pub figures: Vec<Figure>,
}

/// The planes shown in space if there is no interface, through the middle: normal to y and to z.
const SLICES: [usize; 2] = [1, 2];
/// Maximum number of frames in a film, so that the page remains small enough to open.
const MOST_FRAMES: usize = 150;

/// Draws all stored fields of a run.
pub(super) fn draw(run: &mut RunFolder) -> Result<Gallery> {
    leave_out_start(run)?;
    match run.scene.dimension() {
        _ if !wanted(run) => Ok(Gallery::default()),
        2 => draw_with::<2>(run, Painter::paint),
        _ => draw_with::<3>(run, Painter::paint_solid),
    }
}

/// Leaves out the start where it has no pressure to be shown.
fn leave_out_start(run: &mut RunFolder) -> Result<()> {
    let Some(first) = run.frames.first() else { return Ok(()) };
    let is_known = match run.scene.dimension() {
        _ if run.scene.output.picture.field != Quantity::Pressure => true,
        2 => knows_pressure(&read_vtu::<2>(&first.file)?),
        _ => knows_pressure(&read_vtu::<3>(&first.file)?),
    };
    if !is_known {
        let first = run.frames.remove(0);
        let earlier = run.path.join("pictures").join(format!("{}.png", first.name));
        // Of another field.
        if earlier.is_file() {
            std::fs::remove_file(&earlier).map_err(|e| cannot_write(&earlier, &e))?;
        }
    }
    Ok(())
}

/// False if the pressure is not known anywhere; a file without one is not judged.
fn knows_pressure<const D: usize>(snapshot: &Snapshot<D>) -> bool {
    snapshot.scalar("pressure").map_or(true, |p| p.iter().any(|v| v.is_finite()))
}

/// Makes the picture of a frame.
type Paint = fn(&Painter, &StoredFields) -> Result<Image>;

fn draw_with<const D: usize>(run: &mut RunFolder, picture: Paint) -> Result<Gallery> {
    let folder = run.folder("pictures")?;
    let painter = Painter::new::<D>(run)?;
    let file = |f: &StoredFields| folder.join(format!("{}.png", f.name));
    let paint = |frame: &StoredFields| -> Result<Image> {
        let image = picture(&painter, frame)?;
        write_file(&file(frame), &image.png()?)?;
        Ok(image)
    };
    // In batches, so that memory is bounded for runs of any length.
    let batch = 2 * rayon::current_num_threads();
    let mut images =
        run.frames.chunks(batch).flat_map(|part| part.par_iter().map(paint).collect::<Vec<_>>());
    let mut gallery =
        Gallery { files: run.frames.iter().map(file).collect(), ..Gallery::default() };
    if run.scene.output.film && run.frames.len() > 1 {
        let every = run.frames.len().div_ceil(MOST_FRAMES);
        let shown = images
            .enumerate()
            .filter(|(i, image)| i % every == 0 || image.is_err())
            .map(|(_, image)| image);
        let seconds = run.frames.len().min(MOST_FRAMES) as f64 / 6.0;
        let film = write_film(&run.path.join("film"), shown, seconds.clamp(4.0, 25.0))?;
        gallery.figures.push(film_figure(&film, painter.film_caption(run, every))?);
        gallery.files.extend([Some(film.gif), film.mp4].into_iter().flatten());
        run.warnings.extend(film.warning);
    } else {
        images.try_for_each(|image| image.map(drop))?;
    }
    gallery.figures.extend(shown(run, file)?);
    Ok(gallery)
}

/// True if there is anything to draw; warns of pictures that the scene asks for and cannot be made.
fn wanted(run: &mut RunFolder) -> bool {
    let output = &run.scene.output;
    if output.pictures.is_none() {
        return false;
    }
    let missing = match run.frames.len() {
        0 => ["no pictures: the run has stored no fields", "it ended before the first step"],
        1 if output.film => {
            ["no film: the run has stored fields of one time only", "see the picture"]
        }
        _ => return true,
    };
    run.warnings.push(Warning::new(missing[0], missing[1]));
    run.frames.len() == 1
}

fn film_figure(film: &Film, caption: String) -> Result<Figure> {
    let content = match &film.mp4 {
        Some(mp4) => Content::Mp4(read_file(mp4)?),
        None => Content::Gif(read_file(&film.gif)?),
    };
    Ok(Figure { name: String::new(), title: "Film".into(), content, caption })
}

/// The first, the middle and the last picture.
fn shown(run: &RunFolder, file: impl Fn(&StoredFields) -> PathBuf) -> Result<Vec<Figure>> {
    let last = run.frames.len().saturating_sub(1);
    let mut chosen = vec![(last, "The end"), (last / 2, "Halfway"), (0, "The start")];
    chosen.dedup_by_key(|c| c.0);
    let chosen = chosen.into_iter().rev().filter_map(|(k, when)| Some((run.frames.get(k)?, when)));
    let figure = |(frame, when): (&StoredFields, &str)| {
        let title = format!("{when}, t = {}.", rounded(frame.time, 6));
        let content = Content::Png(read_file(&file(frame))?);
        Ok(Figure { name: String::new(), title, content, caption: String::new() })
    };
    chosen.map(figure).collect()
}

/// Numbers of checkerboard fields around the equator and from pole to pole.
const GLOBE: [usize; 2] = [16, 8];

/// Style of the pictures of a run, all in one scale.
struct Painter {
    quantity: Quantity,
    mesh: bool,
    size: usize,
    interfaces: Vec<String>,
    scale: Scale,
    colours: Option<ColourMap>,
    /// The largest speed, if arrows are drawn.
    fastest: Option<f64>,
    /// In space: direction of the viewer, and the displayed plane.
    view: [f64; 2],
    slice: Option<Cut>,
    /// The part of the domain that is shown.
    window: Option<[Vec<f64>; 2]>,
    /// Mean position at rest of the material of the interface: the middle of its checkerboard.
    middle: Point<3>,
}

impl Painter {
    /// Reads all fields once to determine the scale.
    fn new<const D: usize>(run: &RunFolder) -> Result<Painter> {
        let picture = &run.scene.output.picture;
        let of_image = picture.field == Quantity::Image;
        let mut painter = Painter {
            quantity: picture.field,
            mesh: picture.mesh,
            size: picture.size,
            interfaces: run.scene.interfaces().map(str::to_string).collect(),
            scale: Scale::of::<2>(FieldData::Scalar(&[])),
            colours: picture.colours.or(of_image.then_some(ColourMap::Grey)),
            fastest: None,
            view: picture.view.unwrap_or_default(),
            slice: picture.slice,
            window: picture.window.as_ref().map(|w| [w.min.clone(), w.max.clone()]),
            middle: Point::<3>::zeros(),
        };
        if let (Quantity::Checkerboard, Some(first)) = (painter.quantity, run.frames.first()) {
            let snapshot = read_vtu::<3>(&first.file)?;
            painter.middle =
                painter.middle_of(&snapshot).map_err(|e| e.at(first.file.display().to_string()))?;
        }
        painter.scale = match picture.range {
            Some([low, high]) => Scale { low, high, fixed: true },
            None => {
                let ranges = run.frames.par_iter().map(|f| painter.range::<D>(f));
                ranges.collect::<Result<Vec<_>>>()?.into_iter().fold(painter.scale, Scale::with)
            }
        };
        if painter.quantity == Quantity::Speed {
            painter.fastest = Some(painter.scale.high);
        }
        Ok(painter)
    }

    fn range<const D: usize>(&self, frame: &StoredFields) -> Result<Scale> {
        let snapshot = read_vtu::<D>(&frame.file)?;
        let place = |e: Error| e.at(frame.file.display().to_string());
        match self.field(&snapshot).map_err(place)? {
            Field::Borrowed(field) => Ok(Scale::of(field)),
            Field::Vorticity(values) => {
                let strong = strong(&values);
                Ok(Scale::new(if D == 2 { -strong } else { 0.0 }, strong))
            }
            // Far from the interface the slope of the level set is not a stretch, and where fronts
            // meet it is zero.
            Field::Interface(values) => {
                let near = near_interface(&snapshot, self.level_set(&snapshot).map_err(place)?);
                let values: Vec<f64> =
                    values.iter().zip(near).filter(|(_, near)| *near).map(|(v, _)| *v).collect();
                Ok(Scale::of::<D>(FieldData::Scalar(&values)))
            }
        }
    }

    /// The field that is coloured.
    fn field<'a, const D: usize>(&self, snapshot: &'a Snapshot<D>) -> Result<Field<'a, D>> {
        Ok(match self.quantity {
            Quantity::Pressure => Field::Borrowed(FieldData::Scalar(snapshot.scalar("pressure")?)),
            Quantity::Image => Field::Borrowed(FieldData::Scalar(snapshot.scalar("image")?)),
            Quantity::Velocity | Quantity::Speed => {
                Field::Borrowed(FieldData::Vector(snapshot.vector("velocity")?))
            }
            Quantity::Vorticity => {
                Field::Vorticity(snapshot.space.vorticity(snapshot.vector("velocity")?))
            }
            Quantity::LevelSet | Quantity::Checkerboard => {
                Field::Borrowed(FieldData::Scalar(self.level_set(snapshot)?))
            }
            // Where the interface carries its stretch the slope is none.
            Quantity::Stretch => Field::Interface(match snapshot.scalar(&self.column("stretch")) {
                Ok(carried) => carried.to_vec(),
                Err(_) => stretch(snapshot, self.level_set(snapshot)?),
            }),
            Quantity::AreaChange => {
                Field::Interface(snapshot.scalar(&self.column("area_change"))?.to_vec())
            }
            Quantity::Shear => Field::Interface(snapshot.scalar(&self.column("shear"))?.to_vec()),
        })
    }

    /// The name of a field of the only interface.
    fn column(&self, field: &str) -> String {
        format!("{}.{field}", self.interfaces.first().map_or("", |name| name))
    }

    /// Position at rest of the material, at the nodes.
    fn at_rest(&self, snapshot: &Snapshot<3>) -> Result<Vec<Point<3>>> {
        let own = snapshot.vector(&self.column("displacement"));
        let displacement = own.or_else(|_| snapshot.vector("displacement"))?;
        Ok(snapshot.space.nodes().iter().zip(displacement).map(|(x, d)| x + d).collect())
    }

    /// The mean position at rest of the material near the interface.
    fn middle_of(&self, snapshot: &Snapshot<3>) -> Result<Point<3>> {
        let (near, rest) =
            (near_interface(snapshot, self.level_set(snapshot)?), self.at_rest(snapshot)?);
        let (mut sum, mut count) = (Point::<3>::zeros(), 0.0);
        for (y, _) in rest.iter().zip(near).filter(|(_, near)| *near) {
            (sum, count) = (sum + y, count + 1.0);
        }
        // Rounded to a thousandth of the size, so that a sphere in the middle of a mesh gives
        // exactly the middle.
        let (low, high) = snapshot.space.mesh().bounding_box();
        let unit = 1e-3 * (high - low).norm();
        Ok((sum / count).map(|v| (v / unit).round() * unit))
    }

    /// The level set of the interface; there is exactly one when a scene requests it.
    fn level_set<'a, const D: usize>(&self, snapshot: &'a Snapshot<D>) -> Result<&'a [f64]> {
        level_set(snapshot, self.interfaces.first().map_or("", |name| name))
    }

    fn paint(&self, frame: &StoredFields) -> Result<Image> {
        let snapshot = read_vtu::<2>(&frame.file)?;
        let place = |e: Error| e.at(frame.file.display().to_string());
        let field = self.field(&snapshot).map_err(place)?;
        let interfaces =
            self.interfaces.iter().map(|name| level_set(&snapshot, name)).collect::<Result<_>>();
        let arrows = match self.fastest {
            Some(fastest) => {
                Some(Arrows { velocity: snapshot.vector("velocity").map_err(place)?, fastest })
            }
            None => None,
        };
        Picture {
            space: &snapshot.space,
            field: field.data(),
            scale: self.scale,
            colours: self.colours,
            window: self.window.as_ref().map(|w| [0, 1].map(|k| point(&w[k]))),
            title: self.title(),
            time: Some(frame.time),
            interfaces: interfaces.map_err(place)?,
            arrows,
            mesh: self.mesh,
            size: [self.size; 2],
        }
        .draw()
    }

    /// The picture of a frame of space: the interfaces, or without any two slices through the
    /// middle.
    fn paint_solid(&self, frame: &StoredFields) -> Result<Image> {
        let snapshot = read_vtu::<3>(&frame.file)?;
        let place = |e: Error| e.at(frame.file.display().to_string());
        let field = self.field(&snapshot).map_err(place)?;
        let rest = match self.quantity {
            Quantity::Checkerboard => self.at_rest(&snapshot).map_err(place)?,
            _ => Vec::new(),
        };
        let coat = match (&field, self.quantity) {
            // The level set is zero on the interface.
            (_, Quantity::LevelSet) => Coat::Plain,
            (_, Quantity::Checkerboard) => {
                let pattern =
                    Pattern::Globe { centre: self.middle, around: GLOBE[0], along: GLOBE[1] };
                Coat::Checkerboard { characteristic: &rest, pattern }
            }
            (field, _) => Coat::Field(field.data()),
        };
        let mut picture = SolidPicture::new(&snapshot.space, self.title());
        picture.colours = self.colours;
        picture.window = self.window.as_ref().map(|w| [0, 1].map(|k| point(&w[k])));
        let [low, high] =
            picture.window.unwrap_or_else(|| snapshot.space.mesh().bounding_box().into());
        let middle = (low + high) * 0.5;
        let slice = |axis: usize, at: Option<f64>| Slice {
            axis,
            position: at.unwrap_or(middle[axis]),
            field: field.data(),
        };
        match self.slice {
            Some(Cut { axis, at }) => {
                picture.slices = vec![slice(axis, at)];
                let lines = self
                    .interfaces
                    .iter()
                    .map(|name| level_set(&snapshot, name))
                    .collect::<Result<_>>();
                picture.interfaces = lines.map_err(place)?;
            }
            None if self.interfaces.is_empty() => {
                picture.slices = SLICES.map(|axis| slice(axis, None)).to_vec();
            }
            None => {
                let surface = |name: &String| {
                    Surface::of_level_set(&snapshot.space, level_set(&snapshot, name)?, coat)
                };
                picture.surfaces =
                    self.interfaces.iter().map(surface).collect::<Result<_>>().map_err(place)?;
            }
        }
        let [azimuth, elevation] = self.view;
        picture.view = View { azimuth, elevation, ..View::default() };
        SolidPicture { scale: self.scale, time: Some(frame.time), size: [self.size; 2], ..picture }
            .draw()
    }

    fn title(&self) -> &'static str {
        match self.quantity {
            Quantity::Pressure => "Pressure",
            Quantity::Image => "Grey level",
            Quantity::Velocity | Quantity::Speed => "Speed",
            Quantity::Vorticity => "Vorticity",
            Quantity::LevelSet => "Level set φ",
            Quantity::Stretch => "Stretch |grad φ|",
            Quantity::AreaChange => "Area change Z1",
            Quantity::Shear => "Shear Z2",
            Quantity::Checkerboard => "Material of the membrane",
        }
    }

    fn film_caption(&self, run: &RunFolder, every: usize) -> String {
        let [first, last] =
            [run.frames.first(), run.frames.last()].map(|f| f.map_or(0.0, |f| f.time));
        let mut caption = format!(
            "{} from t = {} to t = {}, all pictures in one colour scale",
            self.title(),
            rounded(first, 6),
            rounded(last, 6)
        );
        if self.quantity == Quantity::Vorticity {
            caption += ", the strongest hundredth in the colours of its ends";
        }
        let solid = run.scene.dimension() == 3;
        caption += match (solid, self.interfaces.is_empty()) {
            (true, _) if self.slice.is_some() => ", on a plane; the black line is the interface",
            (false, true) => "",
            (false, false) if self.quantity == Quantity::Image => {
                "; the red line is the contour, the image the mean of the four pixels about each \
                 corner"
            }
            (false, false) => "; the black line is the interface",
            (true, true) => ", on two planes through the middle",
            (true, false) => ", on the interface",
        };
        if self.fastest.is_some() && !solid {
            caption += "; arrows show the velocity, longer by the root of the speed";
        }
        if every > 1 {
            caption += &format!("; one of {every} pictures is shown here, all are in pictures/");
        }
        caption + "."
    }
}

/// A field of the snapshot, or one derived from it.
enum Field<'a, const D: usize> {
    Borrowed(FieldData<'a, D>),
    Vorticity(Vec<f64>),
    /// A field with a meaning on the interface only.
    Interface(Vec<f64>),
}

impl<const D: usize> Field<'_, D> {
    fn data(&self) -> FieldData<'_, D> {
        match self {
            Field::Borrowed(field) => *field,
            Field::Vorticity(values) | Field::Interface(values) => FieldData::Scalar(values),
        }
    }
}

fn level_set<'a, const D: usize>(snapshot: &'a Snapshot<D>, membrane: &str) -> Result<&'a [f64]> {
    snapshot.scalar(&format!("{membrane}.level_set"))
}

/// Fraction of the nodes whose vorticity may exceed the colour range: next to corners and in
/// rupturing films it is many times larger than elsewhere.
const STRONGEST: f64 = 0.01;

/// The bound that all values except the fraction [`STRONGEST`] stay below in magnitude.
fn strong(values: &[f64]) -> f64 {
    let mut moduli: Vec<f64> = values.iter().map(|v| v.abs()).filter(|v| v.is_finite()).collect();
    moduli.sort_by(f64::total_cmp);
    let last = (moduli.len() as f64 * (1.0 - STRONGEST)) as usize;
    moduli.get(last.min(moduli.len().saturating_sub(1))).copied().unwrap_or(0.0)
}

/// True for nodes of a cell that the interface cuts.
fn near_interface<const D: usize>(snapshot: &Snapshot<D>, phi: &[f64]) -> Vec<bool> {
    let space = &snapshot.space;
    let mut near = vec![false; space.len()];
    for c in 0..space.mesh().cell_count() {
        let nodes = space.cell_nodes(c);
        let inside = nodes.iter().filter(|&&n| phi[n as usize] < 0.0).count();
        if inside > 0 && inside < nodes.len() {
            nodes.iter().for_each(|&n| near[n as usize] = true);
        }
    }
    near
}

/// `|grad phi|` at the nodes, the gradient being the mean over the cells around a node.
fn stretch<const D: usize>(snapshot: &Snapshot<D>, phi: &[f64]) -> Vec<f64> {
    let space = &snapshot.space;
    space.means(|c, l| space.gradient(phi, c, l)).iter().map(|g| g.norm()).collect()
}
