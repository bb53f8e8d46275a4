//! Segmentation of an image by a level set: construction, comparison with a known answer, and the
//! files written at the end.

use super::{fields, ground, interfaces};
use crate::base::{Error, PHASES, Result, Warning, fnv1a, length};
use crate::flow::StepReport;
use crate::levelset::{
    Contour, Redistance, Redistancing, Segmentation, SegmentationWeights, band_edges,
};
use crate::mesh::{Mesh, Point, Quality};
use crate::output::{GreyImage, Pixels, write_file};
use crate::scene::Scene;
use crate::scene::measure::{self, Probes};
use crate::scene::plan::{self, Plan};
use crate::scene::problem::{Advice, Facts, Limits, Moment, Problem, ProfileColumn};
use crate::scene::remedies::with_keys;
use crate::scene::row::Row;
use crate::scene::site::Site;
use crate::scene::view::View;
use crate::sim::{Segmenting, State};
use crate::structure::LevelSet;
use std::any::Any;
use std::path::Path;

/// Default half-width of the band in edges of the mesh: four pixels on the mesh generated for an
/// image. With one edge the band is too thin for the mesh: the contour of
/// `examples/active-contours` takes ten times as long.
const BAND: f64 = 2.0;
/// Grey levels of the mask above this are inside.
const MIDDLE: f64 = 0.5;
/// Fraction of a pixel by which a mesh may extend beyond the image.
const ROUNDING: f64 = 1e-6;

/// The level set of a scene that segments an image, ready to run.
pub struct Segmented<const D: usize = 2> {
    /// The segmentation, initially at time 0.
    pub segmenting: Segmenting<D>,
    /// Warnings before the first step.
    pub warnings: Vec<Warning>,
    /// Half-width of the band.
    pub thickness: f64,
    /// Quality of the mesh.
    pub quality: Quality<D>,
    pub(in crate::scene) scene: Scene,
    answer: Option<Answer>,
    probes: Probes<D>,
}

impl<const D: usize> Segmented<D> {
    /// Builds the segmentation of a scene.
    ///
    /// # Errors
    /// An image that cannot be read or is smaller than the mesh; otherwise as for level sets.
    pub fn new(scene: &Scene) -> Result<Segmented<D>> {
        let Some(image) = &scene.image else {
            return Err(Error::internal("no image is segmented"));
        };
        let (site, _) = ground::site::<D>(scene)?;
        let place = |e| scene.blame(&["image", "file"], e);
        let picture = GreyImage::read(&image.file).map_err(place)?;
        let pixels = Pixels { size: [picture.width(), picture.height()], side: image.pixel };
        check_within(scene, &site, &pixels)?;
        let contour = contour(scene, &site)?;
        let edges = band_edges(&site.space, &contour.phi, 0.0).map_or(0.0, |e| e.largest);
        let thickness = scene.numerics.thickness.unwrap_or(BAND * edges);
        let at = |x: &Point<D>| [x[0] / pixels.side, x[1] / pixels.side];
        let weights =
            SegmentationWeights { fidelity: image.fidelity, length: image.length, thickness };
        let grey = |x: &Point<D>| {
            let [x, y] = at(x);
            picture.at(x, y)
        };
        let segmentation = Segmentation::new(&site.space, grey, weights)?;
        let nodal = site.space.interpolate(|x| {
            let [x, y] = at(x);
            picture.smooth(x, y)
        });
        let method = Redistancing { method: Redistance::Exact, volume: false };
        let steps = (scene.time.step, image.rebuild, method);
        Ok(Segmented {
            segmenting: Segmenting::new(&site.space, (segmentation, nodal), steps, contour)?,
            thickness,
            probes: Probes::new(scene, &site.mesh)?,
            answer: Answer::of(scene)?,
            scene: scene.clone(),
            warnings: site.warnings,
            quality: site.quality,
        })
    }

    pub(in crate::scene) fn view(&self) -> View<'_, D> {
        View {
            tables: &self.scene,
            carried: self.segmenting.carried(),
            state: self.segmenting.state(),
            flow: None,
            thickness: Some(self.thickness),
            carried_bands: &[],
        }
    }
    fn in_plane(&self) -> Option<&Segmenting<2>> {
        (&self.segmenting as &dyn Any).downcast_ref()
    }
}

impl<const D: usize> Problem for Segmented<D> {
    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
    fn plan(&mut self) -> Result<Plan> {
        let (scene, view, eps) = (&self.scene, self.view(), self.thickness);
        let Some(image) = &scene.image else {
            return Err(Error::internal("no image is segmented"));
        };
        let names: Vec<String> = scene.interfaces().map(|name| format!("`{name}`")).collect();
        let (alpha, beta, names) = (image.fidelity, image.length, names.join(", "));
        let solved = vec![
            format!(
                "no flow: the level set {names} segments the image {}, side of a pixel {}",
                image.file.display(),
                image.pixel
            ),
            format!(
                "it descends along {alpha} E1 + {beta} E2, misfit and length, by (1.29) with c1 \
                 and c2 the mean levels inside and outside"
            ),
            format!(
                "its zero line moves by {eps} in a step at most, and finds only objects that it \
                 reaches"
            ),
        ];
        let memory = self.segmenting.bytes() as f64 / 1e6;
        let unknowns = plan::level_sets(&view).into_iter();
        let given = if scene.numerics.thickness.is_some() { "" } else { " (derived)" };
        let rebuild = match image.rebuild {
            1 => "every step".to_string(),
            n => format!("every {n} steps"),
        };
        let numerics = vec![
            format!(
                "step {}, implicit in the length; one scalar matrix, factored in each step",
                scene.time.step
            ),
            format!(
                "band half-width {}{given}; a signed distance again after {rebuild}",
                length(eps)
            ),
        ];
        let left_out =
            "flow, pressure and boundary conditions: an image is segmented, and nothing flows";
        Ok(Plan::new([
            plan::mesh(scene, &view, (&self.quality, None)),
            ("Solved", solved),
            (
                "Unknowns",
                unknowns
                    .chain([format!("no matrix of a flow; memory about {memory:.0} MB")])
                    .collect(),
            ),
            ("Numerics", numerics),
            (
                "Left out",
                std::iter::once(left_out.to_string()).chain(plan::third_dimension(D)).collect(),
            ),
            ("Steps", vec![plan::steps(scene)]),
        ]))
    }
    fn limits(&self) -> Limits {
        Limits { thickness: Some(self.thickness), ..Limits::default() }
    }
    fn step(&mut self) -> Result<StepReport> {
        with_keys(self.segmenting.step())
    }
    fn moment(&self) -> Moment {
        let state = self.segmenting.state();
        Moment::regular(state.steps, state.time, self.segmenting.dt())
    }
    fn row(&self) -> Result<Row> {
        let (mut row, view) = (Row::default(), self.view());
        measure::structures(&view, self.scene.structures(), &mut row)?;
        let (fit, parts) = self.segmenting.fit()?;
        row.put("energy", fit.fidelity + fit.length);
        row.put("energy_fidelity", fit.fidelity);
        row.put("energy_length", fit.length);
        row.put("c1", fit.levels[0]);
        row.put("c2", fit.levels[1]);
        row.put("components", parts as f64);
        if let Some((answer, segmenting)) = self.answer.as_ref().zip(self.in_plane()) {
            let [area, wrong] = answer.compare(segmenting);
            row.put("area_error", area);
            row.put("misclassified", wrong);
        }
        measure::maps(&view, &mut row);
        self.probes.measure(&view, &mut row);
        measure::rest(&view, &mut row)?;
        Ok(row)
    }
    fn profile(&self, k: usize) -> Vec<ProfileColumn> {
        self.probes.profile(&self.view(), k)
    }
    fn profile_points(&self, k: usize) -> Vec<Vec<f64>> {
        self.probes.points(k)
    }
    fn write_fields(&self, path: &Path) -> Result<()> {
        fields::write(path, &self.view(), Some(self.segmenting.image()), [None, None])
    }
    fn write_boundaries(&self, path: &Path) -> Result<()> {
        interfaces::write_boundaries(path, self.segmenting.carried().mesh())
    }
    /// Writes `contours.csv`, `segmented.png` with the two mean levels, and `mask.png`, white
    /// inside.
    fn write_results(&self, folder: &Path) -> Result<()> {
        let (Some(image), Some(segmenting)) = (&self.scene.image, self.in_plane()) else {
            return Ok(());
        };
        let pixels = image.pixels().map_err(|e| self.scene.blame(&["image", "file"], e))?;
        let (space, phi) = (segmenting.carried().space(), segmenting.level_set());
        pixels.contours(&Contour::new(space, &phi)?)?.write(&folder.join("contours.csv"))?;
        let (inside, levels) =
            (pixels.inside(space, &phi), segmenting.segmentation().levels(&phi)?);
        for (name, [inner, outer]) in [("segmented.png", levels), ("mask.png", [1.0, 0.0])] {
            let grey = inside.iter().map(|i| if *i { inner } else { outer }).collect();
            write_file(&folder.join(name), &GreyImage::new(pixels.size[0], grey)?.png()?)?;
        }
        Ok(())
    }
    fn mesh_hash(&self) -> u64 {
        fnv1a(&self.segmenting.carried().mesh().to_bytes())
    }
    fn save(&self, tag: u64) -> [Vec<u8>; 2] {
        [Vec::new(), self.segmenting.state().to_bytes(tag)]
    }
    fn restore(&mut self, [_, state]: [&[u8]; 2], tag: u64, _: Option<[f64; 2]>) -> Result<()> {
        with_keys(State::from_bytes(state, tag).and_then(|state| self.segmenting.restore(state)))
    }
    fn take_costs(&mut self) -> ([f64; PHASES.len()], u64) {
        (self.segmenting.take_costs(), 0)
    }
    fn facts(&self) -> Facts {
        Facts {
            cells: self.segmenting.carried().mesh().cell_count(),
            edge: self.quality.greatest_diameter.value,
            memory: self.segmenting.bytes(),
            unknowns: [0, 0, fields::level_set_unknowns(&self.view())],
            ..Facts::default()
        }
    }
    fn plane_mesh(&self) -> Option<&Mesh<2>> {
        ground::plane(self.segmenting.carried().mesh())
    }
    fn advice(&self) -> Advice {
        Advice { area: vec!["a finer mesh".into()], ..Advice::default() }
    }
}

/// The only level set of the scene.
fn contour<const D: usize>(scene: &Scene, site: &Site<'_, D>) -> Result<LevelSet<D>> {
    let placed = ground::place(scene, site)?.into_iter().next().flatten();
    let (Some(placed), Some(kind)) = (placed, scene.structures().first()) else {
        return Err(Error::internal("there is no level set to segment an image with"));
    };
    if crate::levelset::surface(&site.space, &placed.nodal)?.is_empty() {
        let e = Error::scene("no part of the interface lies on the mesh")
            .remedy("move the shape, or refine the mesh");
        let [list, number] = scene.structure_keys(0);
        return Err(scene.blame(&[&list, &number, "shape"], e));
    }
    Ok(LevelSet::new(kind.name(), placed.nodal).with_function(placed.function))
}

/// Rejects a mesh that extends beyond the image.
fn check_within<const D: usize>(scene: &Scene, site: &Site<'_, D>, pixels: &Pixels) -> Result<()> {
    let (low, high) = site.mesh.bounding_box();
    let (width, height, side) = (pixels.size[0], pixels.size[1], pixels.side);
    let room = ROUNDING * side;
    let beyond = |k: usize| low[k] < -room || high[k] > (pixels.size[k] as f64 + ROUNDING) * side;
    if !(0..2).any(beyond) {
        return Ok(());
    }
    let e = Error::scene("the mesh reaches beyond the image")
        .value(format!("an image of {width} x {height} pixels of {side}"))
        .remedy("leave [mesh] out, or give a rectangle from [0, 0] within the image");
    Err(scene.blame(&["mesh"], e))
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
    /// A mask that cannot be read or differs in size from the image.
    pub fn of(scene: &Scene) -> Result<Option<Answer>> {
        let Some((image, path)) = scene.image.as_ref().and_then(|i| Some((i, i.mask.as_ref()?)))
        else {
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

    /// The relative difference of the area of pixels inside from that of the mask, and the number
    /// of misclassified pixels.
    fn compare(&self, segmenting: &Segmenting<2>) -> [f64; 2] {
        let (space, phi) = (segmenting.carried().space(), segmenting.level_set());
        let found = self.pixels.inside(space, &phi);
        let count = |inside: &[bool]| inside.iter().filter(|i| **i).count() as f64;
        let wrong = found.iter().zip(&self.inside).filter(|(a, b)| a != b).count();
        [count(&found) / count(&self.inside) - 1.0, wrong as f64]
    }
}
