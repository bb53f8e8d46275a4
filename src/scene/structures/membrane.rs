//! `[[membrane]]`: elastic interfaces.

use super::build::{self, Build, band_of};
use super::{KindIn, Registered, StructureKind, Traits, laws};
use crate::base::{Error, Result};
use crate::elastic::{
    AreaFrom, AreaLaw, Band, Force, SharpMembrane, SharpShearMembrane, ShearLaw, ShearMembrane,
    SurfaceLaw,
};
use crate::mesh::Point;
use crate::scene::charts::{Columns, Plot};
use crate::scene::cuts::{self, Chord, Cuts, Ring};
use crate::scene::expression::Expression;
use crate::scene::keys::{
    Context, Form, Identifier, Item, Kind, Many, Named, Nested, NonNegative, Opt, Positive, Table,
    Tabled, Writer, kinds, optional, table, words,
};
use crate::scene::points::coordinates;
use crate::scene::row::Row;
use crate::scene::schema::{Numerics, Shape, Tables};
use crate::scene::view::View;
use crate::structure::{
    Immersed, ImmersedInterface, InitialFunction, RestMap, Structure, SurfaceStrain,
};
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// The kind `[[membrane]]`.
pub(super) const KIND: Registered = Registered {
    list: "membrane",
    keys: Membrane::KEYS,
    doc: "Elastic interfaces.",
    #[cfg(test)]
    example: |_| "area.linear = { modulus = 1 }",
    read: |item, numerics, context| Ok(Box::new(Membrane::read_for(item, numerics, context)?)),
};

table! {
    /// A closed elastic membrane.
    Membrane {
        /// Its name in results; unique in the scene.
        name: String [Identifier, Default("membrane")],
        /// Its form at time 0.
        shape: Shape [Nested<Shape>,
            Required("give one: shape.circle = { centre = [1, 1], radius = 0.5 }")],
        /// Stretch r at time 0: length over length at rest.
        stretch: f64 [Positive, Default(1.0)],
        /// The law of the energy E(r) of its area.
        area: Option<AreaLaw> [Opt<Nested<AreaLaw>>, Derived("none, where `law` is given")],
        /// The law of the energy of its shear, beside that of its area; in space alone. Backward
        /// characteristics are then carried, unless the force is sharp.
        shear: Option<ShearLaw> [Opt<Nested<ShearLaw>>],
        /// A law of area and shear together, in place of `area` and `shear`; in space alone.
        law: Option<SurfaceLaw> [Opt<Nested<SurfaceLaw>>],
        /// Where the material that is at x, y, z at time 0 is at rest, beside the stretch: Y at
        /// time 0.
        map: Vec<Expression> [Many<Map>, "m", Derived("[\"x\", \"y\", \"z\"]")],
        /// What a smeared force takes the stretch (in space: the area change Z1) from: the slope of
        /// the level set; where there is shear the map Y; where there is none a density that the
        /// interface carries, continued along its normals over the band.
        area_change: AreaChange [AreaWords, Default("slope")],
        /// Whether the level set is carried, or taken as that of time 0 at the place where the map
        /// Y comes from.
        level_set: bool [LevelSetWords, Default("carried")],
        /// Where its force acts: on the interface itself, cut out of the cells, with the stretch
        /// carried along it; or over a band, whose half-width `numerics.thickness` makes an error
        /// of first order and whose stretch the flow beside the interface winds up.
        force: Force [Forces,
            Derived("\"sharp\"; \"smeared\" with `mass`, `area_change` or `level_set`, and where \
                `numerics` has `surface_tension`, `band`, another `kernel` or `width` than the \
                default, or the semi-implicit coupling", Force::Sharp)],
        /// Mass per area (in the plane: per length and unit depth).
        mass: f64 [NonNegative, "kg/m2", Default(0.0)],
        /// Lines along which the contour is measured.
        chords: Vec<Named<Chord>> [Named<Chord>],
        /// Planes through the membrane in which its form is measured; in space alone.
        rings: Vec<Named<Ring>> [Named<Ring>],
    } before Membrane::before; hide Membrane::hides;
}

words! { Forces: Force { "smeared" = Force::Smeared, "sharp" = Force::Sharp } }
words! {
    AreaWords: AreaChange {
        "slope" = AreaChange::Slope, "map" = AreaChange::Map, "carried" = AreaChange::Carried,
    }
}
words! { LevelSetWords: bool { "carried" = false, "mapped" = true } }
kinds! {
    /// A place at rest.
    Map: Vec<Expression> = Kind::Value("three expressions", Form::EXPRESSIONS), read_map;
}

/// Keys of a smeared membrane alone.
const OF_BAND: [&str; 2] = ["area_change", "level_set"];

/// Source of the stretch of a smeared membrane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaChange {
    /// The slope of the level set.
    Slope,
    /// The backward map.
    Map,
    /// What the interface carries.
    Carried,
}

impl Membrane {
    /// Reads a membrane. The default force is smeared where a key is given that only a band has.
    fn read_for(item: &Item, numerics: &Numerics, context: &Context) -> Result<Membrane> {
        let mut membrane = Membrane::read(item, context)?;
        let table = item.open_table()?;
        let of_band = OF_BAND.into_iter().any(|key| table.get(key).is_some());
        let banded = of_band || membrane.mass > 0.0 || numerics.key_of_band().is_some();
        if banded && table.get("force").is_none() {
            membrane.force = Force::Smeared;
        }
        Ok(membrane)
    }
    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        let force = optional::<Forces>(table, "force", context)?;
        laws::check(table, context)?;
        let area_change = optional::<AreaWords>(table, "area_change", context)?;
        let mapped = table.get("area_change").filter(|_| area_change == Some(AreaChange::Map));
        let of_shear = ["map", "level_set"].into_iter().find_map(|key| table.get(key)).or(mapped);
        let resists_shear = ["shear", "law"].into_iter().any(|key| table.get(key).is_some());
        if let (false, Some(item)) = (resists_shear, of_shear) {
            return Err(item
                .key_error(format!("`{}` is for membranes that resist shear", item.key))
                .remedy(
                    "give shear.linear = { modulus = 1 } beside the law of area, or leave it out",
                ));
        }
        if let (true, Some(AreaChange::Carried), Some(item)) =
            (resists_shear, area_change, table.get("area_change"))
        {
            return Err(item
                .error("a band with shear has no area change that the interface carries")
                .remedy("take force = \"sharp\", which carries area change and shear"));
        }
        let of_band = OF_BAND.into_iter().find_map(|key| table.get(key));
        if let (Some(Force::Sharp), Some(item)) = (force, of_band) {
            return Err(item
                .key_error(format!(
                    "`{}` is for a smeared force: a sharp one carries its strain along the interface",
                    item.key
                ))
                .remedy("leave it out, or take force = \"smeared\""));
        }
        cuts::check(table, context)
    }

    fn hides(&self, key: &str) -> bool {
        OF_BAND.contains(&key) && self.force == Force::Sharp
            || self.surface().is_none() && ["map", "level_set"].contains(&key)
    }

    /// Its area law; for a law of area and shear together, the small-strain limit.
    pub fn area(&self) -> AreaLaw {
        match self.law {
            Some(law) => AreaLaw::Linear { modulus: law.response(1.0, 1.0).second[0] },
            None => self.area.unwrap_or(AreaLaw::Tension { tension: 0.0 }),
        }
    }

    /// The surface law of a membrane that resists shear.
    pub fn surface(&self) -> Option<SurfaceLaw> {
        self.law.or(self.shear.map(|shear| SurfaceLaw::Split { area: self.area(), shear }))
    }

    /// True if its stretch is carried along the interface and not read off a level set or a map.
    fn carries_stretch(&self) -> bool {
        self.force == Force::Sharp || self.area_change == AreaChange::Carried
    }

    fn cuts(&self) -> Cuts<'_> {
        Cuts { chords: &self.chords, rings: &self.rings }
    }

    /// The level set at time 0 from the signed `distance`: scaled by the initial area stretch, so
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
            let derivative =
                |i: usize, j: usize| map[i].eval_with_gradient(coordinates(x), 0.0).1[j];
            let grad_y = SMatrix::<f64, D, D>::from_fn(derivative);
            let area = SurfaceStrain::new(&gradient.normalize(), &grad_y, stretch).z1;
            // The distance has no gradient on the medial axis of a shape.
            distance(x) * if area.is_finite() { area } else { stretch }
        })
    }

    /// Rejects a map to the position at rest that has no finite value at some node, or gives an
    /// area out of the range of [`MOST`] at a node in the band.
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
                    true => {
                        "the map to the place at rest has no area along the membrane, or too much"
                    }
                    false => "the map to the place at rest has no finite value everywhere",
                };
                let (y, x) = (y.as_slice(), x.as_slice());
                let e = Error::scene(what)
                    .value(format!("{y:?} at {x:.4?}, area over that at rest {ratio:.3e}"))
                    .remedy(
                        "write a map that is finite on the whole mesh and keeps points of the \
                         membrane apart",
                    );
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
            .with_area_from(match self.area_change {
                AreaChange::Map => AreaFrom::Map,
                _ => AreaFrom::Slope,
            });
        if self.map.is_empty() { membrane } else { membrane.with_map(rest_map(&self.map)) }
    }

    fn band(&self, numerics: &Numerics) -> Band {
        band_of(numerics, self.traits().constant_tension)
    }
}

/// Bound of the area from a map over that from the stretch, and of its inverse.
const MOST: f64 = 100.0;

fn rest_map<const D: usize>(map: &[Expression]) -> Arc<RestMap<D>> {
    let map = map.to_vec();
    Arc::new(move |x: &Point<D>| Point::<D>::from_fn(|i, _| map[i].eval(coordinates(x), 0.0)))
}

fn read_map(item: &Item, context: &Context) -> Result<Vec<Expression>> {
    let map = item.components(context)?;
    if map.iter().any(Expression::depends_on_time) {
        return Err(item
            .error("the map to the place at rest depends on time")
            .remedy("write it in x, y and z alone"));
    }
    Ok(map)
}

impl<const D: usize> KindIn<D> for Membrane {
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>> {
        let script = of.site.script;
        let numerics = &script.numerics;
        // A sharp force needs no band, but a fluid that changes across the interface does.
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
            mapped: self.level_set,
            ..ImmersedInterface::new(&*self.name, phi, of.thickness)
        };
        Ok(match (self.surface(), self.force) {
            (Some(law), Force::Smeared) => Immersed::boxed(interface, self.sheared(law, of)),
            (Some(law), Force::Sharp) => {
                let membrane = SharpShearMembrane::new(law, of.mean_viscosity());
                let unmapped = self.map.is_empty();
                Immersed::boxed(
                    interface,
                    if unmapped { membrane } else { membrane.with_map(rest_map(&self.map)) },
                )
            }
            (None, Force::Sharp) => {
                Immersed::boxed(interface, SharpMembrane::new(self.area(), of.mean_viscosity()))
            }
            (None, Force::Smeared) => {
                let carried = self.area_change == AreaChange::Carried;
                let how = (numerics, self.band(numerics), carried);
                build::smeared(interface, self.area(), how)
            }
        })
    }
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
        view.measure_interface(k, self.cuts(), row).map(drop)
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
        let not_periodic = match (self.map.is_empty(), self.level_set) {
            (false, _) => Some(("map", "a map to the place at rest")),
            (true, true) => Some(("level_set", "a level set taken from the map")),
            (true, false) => None,
        };
        Traits {
            slope: self.stretch,
            stretches: true,
            has_size_at_rest: self.map.is_empty(),
            constant_tension: self.surface().is_none()
                && matches!(self.area(), AreaLaw::Tension { .. }),
            modulus: self.surface().map_or(self.area().modulus(), SurfaceLaw::modulus),
            pulls: self.area().modulus() > 0.0,
            on_interface: self.force == Force::Sharp,
            carries_stretch: self.carries_stretch(),
            wrinkles: !matches!(self.area(), AreaLaw::OneSided { .. } | AreaLaw::Tension { .. }),
            mass: self.mass,
            resists_shear: self.surface().is_some() && self.force == Force::Smeared,
            carries_strain: self.surface().is_some() && self.force == Force::Sharp,
            not_periodic,
            round_at_rest: self.surface().is_none(),
            ..Traits::default()
        }
    }
    fn words(&self) -> Vec<String> {
        let mass = match self.mass > 0.0 {
            true => format!(", surface mass {} (3.19)", self.mass),
            false => String::new(),
        };
        let (name, stretch) = (&self.name, self.stretch);
        let law = laws::words(self.area(), self.surface());
        if self.surface().is_none() {
            let how = match self.force {
                Force::Smeared => "stress (3.16) over its band",
                Force::Sharp => {
                    "tension E'(r) along the interface, the limit of (3.16) for thin bands,"
                }
            };
            let carried = match self.carries_stretch() {
                true => {
                    "; its length at rest (in space: area) carried along it, Dr/Dt = r P : grad u"
                }
                false => "",
            };
            return vec![format!(
                "membrane `{name}`: {how} with {law}, initial stretch {stretch}{mass}; its level \
                 set by (3.22){carried}"
            )];
        }
        let mut lines = vec![format!(
            "membrane `{name}`: forces F1 + F2 (3.47) with {law}, initial stretch {stretch}{mass}"
        )];
        let level_set = if self.level_set { "phi0(Y) (3.32)" } else { "carried by (3.31)" };
        let from = match self.area_change {
            AreaChange::Map => "the map (3.40)",
            _ => "|grad phi| (3.42)",
        };
        lines.push(match self.force {
            Force::Smeared => format!(
                "its level set {level_set}, Z1 from {from}, Z2 from the backward characteristics \
                 Y by (3.38), (3.41)"
            ),
            Force::Sharp => "Z1 and the surface tensor A (3.38) carried along the interface".into(),
        });
        if !self.map.is_empty() {
            let map: Vec<&str> = self.map.iter().map(Expression::text).collect();
            lines.push(format!("at rest its material is at ({})", map.join(", ")));
        }
        lines
    }
    fn numerics(&self, tables: &Tables) -> Option<String> {
        if self.force == Force::Sharp {
            let pulls = self.surface().is_some() || self.area().modulus() > 0.0;
            let what = if self.surface().is_some() { "strain" } else { "stretch" };
            return pulls.then(|| {
                format!(
                    "force of `{}` on the interface itself, with the {what} carried along it",
                    self.name
                )
            });
        }
        Some(build::band_words(&self.name, &tables.numerics, self.band(&tables.numerics)))
    }
    fn chords(&self) -> Vec<String> {
        self.cuts().names().map(str::to_string).collect()
    }
    fn charts(&self, of: &Columns<'_>) -> Vec<Plot> {
        let cuts = self.cuts();
        let (axes, chords) =
            (of.axes(&self.name, self.surface().is_none()), of.chords(&self.name, cuts.names()));
        axes.into_iter().chain(chords).collect()
    }
    fn write(&self, out: &mut Writer) {
        self.section("[[membrane]]", out);
    }
    fn boxed(&self) -> Box<dyn StructureKind> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
