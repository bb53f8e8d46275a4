//! `[[membrane]]`: elastic interfaces.

use super::build::{self, Build, band_of};
use super::{KindIn, Registered, StructureKind, Traits, laws};
use crate::base::{Error, Result};
use crate::elastic::{AreaFrom, AreaLaw, Band, Force, SharpMembrane, ShearMembrane, SurfaceLaw};
use crate::mesh::Point;
use crate::output::Figure;
use crate::scene::charts::Columns;
use crate::scene::cuts::{self, Cuts};
use crate::scene::expression::Expression;
use crate::scene::keys::{
    Absent::*, Context, Item, Keys, Kind::*, Writer, expressions, identifier, name as word, number, row, text, words,
};
use crate::scene::points::coordinates;
use crate::scene::row::Row;
use crate::scene::schema::{Numerics, Shape, Tables, shape};
use crate::scene::view::View;
use crate::structure::{Immersed, ImmersedInterface, InitialFunction, RestMap, Structure, SurfaceStrain};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// The kind `[[membrane]]`.
pub(super) const KIND: Registered = Registered {
    list: "membrane",
    keys: &KEYS,
    doc: "Elastic interfaces.",
    #[cfg(test)]
    example: |_| "area.linear = { modulus = 1 }",
    read: |item, _, context| Ok(Box::new(Membrane::read(item, context)?)),
};

/// A closed elastic membrane.
#[derive(Clone, Debug, PartialEq)]
pub struct Membrane {
    /// Its name in results; unique in the scene.
    pub name: String,
    /// Form at time 0.
    pub shape: Shape,
    /// Stretch r at time 0: length over length at rest.
    pub stretch: f64,
    /// Law of its elastic energy; of one that resists shear, that for small changes of its area.
    pub area: AreaLaw,
    /// Law of one that resists shear too.
    pub surface: Option<SurfaceLaw>,
    /// Position at rest of the material at a point at time 0, beside the stretch: three expressions,
    /// or none for the same place.
    pub map: Vec<Expression>,
    /// Source of the change of its area, if it resists shear.
    pub area_from: AreaFrom,
    /// True if its level set is `phi0(Y)` in place of being carried.
    pub mapped: bool,
    /// Place where its force acts.
    pub force: Force,
    /// Mass per length (2-D) or area (3-D), >= 0.
    pub mass: f64,
    /// Lines and planes along which it is measured.
    pub cuts: Cuts,
}

pub(super) const FORCES: [(&str, Force); 2] = [("smeared", Force::Smeared), ("sharp", Force::Sharp)];
pub(super) const FORCE_WORDS: [&str; FORCES.len()] = words(&FORCES);
const AREAS: [(&str, AreaFrom); 2] = [("slope", AreaFrom::Slope), ("map", AreaFrom::Map)];
const AREA_WORDS: [&str; AREAS.len()] = words(&AREAS);
const LEVEL_SETS: [(&str, bool); 2] = [("carried", false), ("mapped", true)];
const LEVEL_SET_WORDS: [&str; LEVEL_SETS.len()] = words(&LEVEL_SETS);

static KEYS: Keys = Keys {
    about: "A closed elastic membrane.",
    keys: &[
        row("name", Value("text"), "", Default("\"membrane\""), "Its name in results; unique in the scene."),
        row("shape", Table(&shape::KEYS), "", Required, "Its form at time 0."),
        row("stretch", Value("number > 0"), "", Default("1.0"), "Stretch r at time 0: length over length at rest."),
        row(
            "area",
            Table(&laws::LAWS),
            "",
            Derived("none, where `law` is given"),
            "The law of the energy E(r) of its area.",
        ),
        row(
            "shear",
            Table(&laws::SHEARS),
            "",
            Optional,
            "The law of the energy of its shear, beside that of its area; in space alone. Backward characteristics are then carried.",
        ),
        row(
            "law",
            Table(&laws::WHOLE),
            "",
            Optional,
            "A law of area and shear together, in place of `area` and `shear`; in space alone.",
        ),
        row(
            "map",
            Value("three expressions"),
            "m",
            Derived("[\"x\", \"y\", \"z\"]"),
            "Where the material that is at x, y, z at time 0 is at rest, beside the stretch: Y at time 0.",
        ),
        row(
            "area_change",
            Choice(&AREA_WORDS),
            "",
            Default("\"slope\""),
            "What Z1 is taken from where there is shear: the slope of the level set, or the map Y.",
        ),
        row(
            "level_set",
            Choice(&LEVEL_SET_WORDS),
            "",
            Default("\"carried\""),
            "Whether the level set is carried, or taken as that of time 0 at the place where the map Y comes from.",
        ),
        row(
            "force",
            Choice(&FORCE_WORDS),
            "",
            Default("\"smeared\""),
            "Where its force acts: over a band, whose half-width `numerics.thickness` makes an error of first order, or on the interface \
             itself, cut out of the cells, with the stretch carried along it.",
        ),
        row(
            "mass",
            Value("number >= 0"),
            "kg/m2",
            Default("0.0"),
            "Mass per area (in the plane: per length and unit depth).",
        ),
        row("chords", Named(&cuts::CHORD), "", Optional, "Lines along which the contour is measured."),
        row(
            "rings",
            Named(&cuts::RING),
            "",
            Optional,
            "Planes through the membrane in which its form is measured; in space alone.",
        ),
    ],
};

impl Membrane {
    fn read(item: &Item, context: &Context) -> Result<Membrane> {
        let table = item.table(&KEYS)?;
        let shape = "give one: shape.circle = { centre = [1, 1], radius = 0.5 }";
        let name = table.optional("name", identifier)?.unwrap_or_else(|| "membrane".to_string());
        let force = table.optional("force", |i| i.choice(&FORCES))?.unwrap_or(Force::Smeared);
        let (area, surface) = laws::read(&table, force, context)?;
        let needs_shear = |i: &Item| {
            i.key_error(format!("`{}` is for membranes that resist shear", i.key))
                .remedy("give shear.linear = { modulus = 1 } beside the law of area, or leave it out")
        };
        for key in ["map", "area_change", "level_set"] {
            if let (None, Some(item)) = (surface, table.get(key)) {
                return Err(needs_shear(&item));
            }
        }
        let cuts = Cuts::read(&table, context)?;
        Ok(Membrane {
            name,
            shape: table.required("shape", shape, |i| Shape::read(i, context))?,
            stretch: table.optional("stretch", Item::positive)?.unwrap_or(1.0),
            area,
            surface,
            map: table.optional("map", |i| read_map(i, context))?.unwrap_or_default(),
            area_from: table.optional("area_change", |i| i.choice(&AREAS))?.unwrap_or(AreaFrom::Slope),
            mapped: table.optional("level_set", |i| i.choice(&LEVEL_SETS))?.unwrap_or(false),
            force,
            mass: table.optional("mass", Item::non_negative)?.unwrap_or(0.0),
            cuts,
        })
    }

    /// The level set at time 0 whose distance is `distance`: times the area stretch at the start, so
    /// that its slope on the membrane is `Z1`.
    fn level_set<const D: usize>(
        &self,
        distance: Arc<InitialFunction<D>>,
        (low, high): (Point<D>, Point<D>),
    ) -> Arc<InitialFunction<D>> {
        let stretch = self.stretch;
        if self.map.is_empty() {
            return Arc::new(move |x: &Point<D>| stretch * distance(x));
        }
        let (map, h) = (self.map.clone(), 1e-6 * (high - low).norm());
        Arc::new(move |x: &Point<D>| {
            let along = |k: usize| {
                let mut step = Point::<D>::zeros();
                step[k] = h;
                distance(&(x + step)) - distance(&(x - step))
            };
            let gradient = SVector::<f64, D>::from_fn(|k, _| along(k));
            let derivative = |i: usize, j: usize| map[i].eval_with_gradient(coordinates(x), 0.0).1[j];
            let grad_y = SMatrix::<f64, D, D>::from_fn(derivative);
            let area = SurfaceStrain::new(&gradient.normalize(), &grad_y, stretch).z1;
            // In the middle of a shape its distance has no gradient.
            distance(x) * if area.is_finite() { area } else { stretch }
        })
    }

    /// Refuses a map to the place at rest that has no finite value at a node, or no area or a mirrored
    /// one, or a hundred times as much or as little, where the membrane may be: within its band and
    /// on the cells that it cuts.
    fn check_map<const D: usize>(&self, of: &Build<'_, '_, D>, phi: &[f64]) -> Result<()> {
        if self.map.is_empty() {
            return Ok(());
        }
        let (map, distance) = (rest_map::<D>(&self.map), &of.placed()?.nodal);
        for (n, x) in of.site.space.nodes().iter().enumerate() {
            let (y, near) = (map(x), distance[n].abs() <= of.thickness);
            let ratio = phi[n] / distance[n];
            let range = self.stretch / MOST..=self.stretch * MOST;
            let wrong_area = near && distance[n] != 0.0 && !range.contains(&ratio);
            if !y.iter().all(|v| v.is_finite()) || wrong_area {
                let what = match wrong_area {
                    true => "the map to the place at rest has no area along the membrane, or too much",
                    false => "the map to the place at rest has no finite value everywhere",
                };
                let (y, x) = (y.as_slice(), x.as_slice());
                let e = Error::scene(what)
                    .value(format!("{y:?} at {x:.4?}, area over that at rest {ratio:.3e}"))
                    .remedy("write a map that is finite on the whole mesh and keeps points of the membrane apart");
                return Err(of.blame("map", e));
            }
        }
        Ok(())
    }

    fn sheared<const D: usize>(&self, law: SurfaceLaw, of: &Build<'_, '_, D>) -> ShearMembrane<D> {
        let numerics = &of.site.script.numerics;
        let membrane = ShearMembrane::new(law, of.thickness, self.stretch)
            .with_band(self.band(numerics), self.stretch)
            .with_kernel(numerics.kernel, numerics.width)
            .with_area_from(self.area_from);
        if self.map.is_empty() { membrane } else { membrane.with_map(rest_map(&self.map)) }
    }

    fn band(&self, numerics: &Numerics) -> Band {
        band_of(numerics, self.traits().constant_tension)
    }
}

/// The largest area over that at rest, and the inverse of the least, that a map may give.
const MOST: f64 = 100.0;

fn rest_map<const D: usize>(map: &[Expression]) -> Arc<RestMap<D>> {
    let map = map.to_vec();
    Arc::new(move |x: &Point<D>| Point::<D>::from_fn(|i, _| map[i].eval(coordinates(x), 0.0)))
}

fn read_map(item: &Item, context: &Context) -> Result<Vec<Expression>> {
    let map = item.components(context)?;
    if map.iter().any(Expression::depends_on_time) {
        return Err(item.error("the map to the place at rest depends on time").remedy("write it in x, y and z alone"));
    }
    Ok(map)
}

impl<const D: usize> KindIn<D> for Membrane {
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>> {
        let script = of.site.script;
        let numerics = &script.numerics;
        // A sharp force needs no band; a fluid that changes across the interface does.
        let smeared = self.force == Force::Smeared;
        let banded = smeared || self.mass > 0.0 || of.inside.is_some();
        let renormalised = smeared && self.band(numerics) == Band::Renormalised;
        let widest = if renormalised { numerics.width.largest(D) } else { 1.0 };
        of.check_band(&self.name, banded, widest)?;
        let function = self.level_set(of.placed()?.function.clone(), of.site.mesh.bounding_box());
        let phi: Vec<f64> = match self.map.is_empty() {
            true => of.placed()?.nodal.iter().map(|d| d * self.stretch).collect(),
            false => of.site.space.interpolate(|x| function(x)),
        };
        self.check_map(of, &phi)?;
        let interface = ImmersedInterface {
            function: Some(function),
            stretch: self.stretch,
            inside: of.inside,
            surface_mass: self.mass,
            coupling: numerics.coupling,
            mapped: self.mapped,
            ..ImmersedInterface::new(&*self.name, phi, of.thickness)
        };
        Ok(match (self.surface, self.force) {
            (Some(law), _) => Immersed::boxed(interface, self.sheared(law, of)),
            (None, Force::Sharp) => Immersed::boxed(interface, SharpMembrane::new(self.area, of.mean_viscosity())),
            (None, Force::Smeared) => build::smeared(interface, self.area, (numerics, self.band(numerics))),
        })
    }
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
        view.measure_interface(k, &self.cuts, row).map(drop)
    }
}

impl StructureKind for Membrane {
    fn name(&self) -> &str {
        &self.name
    }
    fn list(&self) -> &'static str {
        "membrane"
    }
    fn shape(&self) -> Option<&Shape> {
        Some(&self.shape)
    }
    fn traits(&self) -> Traits {
        let not_periodic = match (self.map.is_empty(), self.mapped) {
            (false, _) => Some(("map", "a map to the place at rest")),
            (true, true) => Some(("level_set", "a level set taken from the map")),
            (true, false) => None,
        };
        Traits {
            slope: self.stretch,
            constant_tension: self.surface.is_none() && matches!(self.area, AreaLaw::Tension { .. }),
            modulus: self.surface.map_or(self.area.modulus(), SurfaceLaw::modulus),
            pulls: self.area.modulus() > 0.0,
            sharp: self.force == Force::Sharp,
            mass: self.mass,
            resists_shear: self.surface.is_some(),
            not_periodic,
            round_at_rest: self.surface.is_none(),
            ..Traits::default()
        }
    }
    fn words(&self) -> Vec<String> {
        let mass = match self.mass > 0.0 {
            true => format!(", surface mass {} (3.19)", self.mass),
            false => String::new(),
        };
        let (name, stretch) = (&self.name, self.stretch);
        let law = laws::words(self.area, self.surface);
        if self.surface.is_none() {
            return vec![format!(
                "membrane `{name}`: stress (3.16) with {law}, initial stretch {stretch}{mass}; its level set by (3.22)"
            )];
        }
        let level_set = if self.mapped { "phi0(Y) (3.32)" } else { "carried by (3.31)" };
        let from = match self.area_from {
            AreaFrom::Slope => "|grad phi| (3.42)",
            AreaFrom::Map => "the map (3.40)",
        };
        let mut lines = vec![
            format!("membrane `{name}`: forces F1 + F2 (3.47) with {law}, initial stretch {stretch}{mass}"),
            format!(
                "its level set {level_set}, Z1 from {from}, Z2 from the backward characteristics Y by (3.38), (3.41)"
            ),
        ];
        if !self.map.is_empty() {
            let map: Vec<&str> = self.map.iter().map(Expression::text).collect();
            lines.push(format!("at rest its material is at ({})", map.join(", ")));
        }
        lines
    }
    fn numerics(&self, tables: &Tables) -> Option<String> {
        if self.force == Force::Sharp {
            let pulls = self.area.modulus() > 0.0;
            return pulls.then(|| {
                format!("force of `{}` on the interface itself, with the stretch carried along it", self.name)
            });
        }
        Some(build::band_words(&self.name, &tables.numerics, self.band(&tables.numerics)))
    }
    fn chords(&self) -> Vec<String> {
        self.cuts.names().map(str::to_string).collect()
    }
    fn charts(&self, of: &Columns<'_>) -> Vec<Figure> {
        let cuts = &self.cuts;
        let (axes, chords) = (of.axes(&self.name, self.surface.is_none()), of.chords(&self.name, cuts.names()));
        axes.into_iter().chain(chords).collect()
    }
    fn write(&self, out: &mut Writer) {
        out.header("[[membrane]]");
        out.entry("name", text(&self.name));
        out.entry("shape", self.shape.write());
        out.entry("stretch", number(self.stretch));
        laws::write(self.area, self.surface, out);
        if self.surface.is_some() {
            if !self.map.is_empty() {
                out.entry("map", expressions(&self.map));
            }
            out.entry("area_change", word(self.area_from, &AREAS));
            out.entry("level_set", word(self.mapped, &LEVEL_SETS));
        }
        out.entry("force", word(self.force, &FORCES));
        out.entry("mass", number(self.mass));
        self.cuts.write(out);
    }
    fn boxed(&self) -> Box<dyn StructureKind> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
