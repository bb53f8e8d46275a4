//! `[[drop]]`: a fluid in another one, with surface tension between them.

use super::build::{self, Build, band_of};
use super::membrane::Forces;
use super::{KindIn, Registered, StructureKind, Traits, round};
use crate::base::{Error, Result};
use crate::elastic::{AreaLaw, Band, Force, SharpMembrane};
use crate::levelset::surface;
use crate::mesh::Point;
use crate::scene::charts::{Columns, Plot};
use crate::scene::cuts::{self, Chord, Cuts, Ring};
use crate::scene::expression::Expression;
use crate::scene::keys::{
    Context, Form, Identifier, Item, Kind, Named, Nested, NonNegative, Opt, Positive, Tabled,
    Writer, kinds, table,
};
use crate::scene::points::coordinates;
use crate::scene::row::Row;
use crate::scene::schema::{Numerics, Shape, Tables};
use crate::scene::view::View;
use crate::structure::{Immersed, ImmersedInterface, InitialFunction, Structure};
use std::sync::Arc;

/// The kind `[[drop]]`.
pub(super) const KIND: Registered = Registered {
    list: "drop",
    keys: Drop::KEYS,
    doc: "Fluids in the fluid, with surface tension.",
    #[cfg(test)]
    example: |_| "surfactant.elasticity = 1",
    read: |item, numerics, context| Ok(Box::new(Drop::read_for(item, numerics, context)?)),
};

table! {
    /// A drop or a bubble: a fluid in another one. What lies in several is of the last of them.
    /// Drops of one shape, a union, merge; interfaces of two drops do not see each other.
    Drop {
        /// Its name in results; unique in the scene.
        name: String [Identifier, Default("drop")],
        /// Its form at time 0.
        shape: Shape [Nested<Shape>,
            Required("give one: shape.circle = { centre = [0.5, 0.5], radius = 0.25 }")],
        /// Surface tension; with a surfactant, where there is none of it.
        tension: f64 [NonNegative, "N/m", Default(0.0)],
        /// A surfactant on the interface, insoluble in both fluids.
        surfactant: Option<Surfactant> [Opt<Nested<Surfactant>>, Derived("none")],
        /// Mass per volume of what is inside.
        density: Option<f64> [Opt<NonNegative>, "kg/m3", Derived("that of the fluid")],
        /// Dynamic viscosity of what is inside.
        viscosity: Option<f64> [Opt<Positive>, "Pa s", Derived("that of the fluid")],
        /// Where surface tension acts: on the interface itself, cut out of the cells, or over a
        /// band of half-width `numerics.thickness`.
        force: Force [Forces,
            Derived("\"sharp\"; \"smeared\" where `numerics` has `surface_tension`, `band`, another \
                `kernel` or `width` than the default, or the semi-implicit coupling", Force::Sharp)],
        /// Lines along which the contour is measured.
        chords: Vec<Named<Chord>> [Named<Chord>],
        /// Planes through the surface in which its form is measured; in space alone.
        rings: Vec<Named<Ring>> [Named<Ring>],
    } before cuts::check;
}

table! {
    /// A substance that the interface carries and that lowers its tension, to `tension - elasticity
    /// c` where its concentration is c.
    Surfactant {
        /// Loss of tension at the concentration 1.
        elasticity: f64 [Positive, "N/m", Required("write surfactant = { elasticity = 0.1 }")],
        /// Its concentration at time 0, over one of the scene's choice: a number, or an expression of
        /// x, y, z.
        concentration: Expression [Concentration, Default(1.0)],
        /// Its diffusivity along the interface.
        diffusivity: f64 [NonNegative, "m2/s", Default(0.0)],
    }
}

kinds! {
    /// A concentration at time 0.
    Concentration: Expression = Kind::Value("number or expression", Form::Expression), read_concentration;
}

fn read_concentration(item: &Item, context: &Context) -> Result<Expression> {
    let concentration = item.expression(&context.constants)?;
    if concentration.depends_on_time() {
        return Err(item
            .error("the concentration at time 0 depends on time")
            .remedy("write it in x, y and z alone"));
    }
    Ok(concentration)
}

impl Drop {
    /// Reads a drop. The default force is smeared where a key is given that only a band has.
    fn read_for(item: &Item, numerics: &Numerics, context: &Context) -> Result<Drop> {
        let mut drop = Drop::read(item, context)?;
        let table = item.open_table()?;
        let key = numerics.key_of_band().filter(|_| table.get("force").is_none());
        if key.is_some() {
            drop.force = Force::Smeared;
        }
        match table.get("surfactant").filter(|_| drop.force == Force::Smeared) {
            None => Ok(drop),
            Some(item) => {
                let band = key.map_or("force = \"smeared\"".into(), |k| format!("numerics.{k}"));
                Err(item
                    .key_error("a surfactant is carried by the interface of a sharp force")
                    .value(format!("{band}, which spreads the force over a band"))
                    .remedy(format!("leave out {band}, or the surfactant")))
            }
        }
    }
    fn law(&self) -> AreaLaw {
        let tension = self.tension;
        match &self.surfactant {
            Some(Surfactant { elasticity, .. }) => {
                AreaLaw::Surfactant { tension, elasticity: *elasticity }
            }
            None => AreaLaw::Tension { tension },
        }
    }
    fn cuts(&self) -> Cuts<'_> {
        Cuts { chords: &self.chords, rings: &self.rings }
    }
    fn band(&self, numerics: &Numerics) -> Band {
        band_of(numerics, true)
    }
}

impl Surfactant {
    /// The concentration as a function; it must be positive on the interface of the drop and leave
    /// some of its `tension`.
    fn concentration<const D: usize>(
        &self,
        of: &Build<'_, '_, D>,
        tension: f64,
    ) -> Result<Arc<InitialFunction<D>>> {
        let expression = self.concentration.clone();
        let value = move |x: &Point<D>| expression.eval(coordinates(x), 0.0);
        for p in surface(&of.site.space, &of.placed()?.nodal)? {
            let c = value(&p.at.x);
            let (what, remedy) = if !(c > 0.0 && c.is_finite()) {
                (
                    "the concentration of the surfactant must be above 0",
                    "write one that is positive on the whole interface",
                )
            } else if c * self.elasticity >= tension {
                (
                    "the surfactant leaves no surface tension",
                    "give a smaller elasticity or concentration, or a larger tension",
                )
            } else {
                continue;
            };
            let place = format!("concentration {c} at {:.4?}", p.at.x.as_slice());
            return Err(of.blame("surfactant", Error::scene(what).value(place).remedy(remedy)));
        }
        Ok(Arc::new(value))
    }
}

impl<const D: usize> KindIn<D> for Drop {
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>> {
        let script = of.site.script;
        let (numerics, band) = (&script.numerics, self.band(&script.numerics));
        let smeared = self.force == Force::Smeared;
        let renormalised = smeared && band == Band::Renormalised;
        let widest = if renormalised { numerics.width.largest(D) } else { 1.0 };
        of.check_band(&self.name, smeared || of.inside.is_some(), widest)?;
        let distance = of.placed()?.function.clone();
        let interface = ImmersedInterface {
            function: Some(Arc::new(move |x: &Point<D>| distance(x))),
            inside: of.inside,
            coupling: numerics.coupling,
            ..ImmersedInterface::new(&*self.name, of.placed()?.nodal.clone(), of.thickness)
        };
        let law = self.law();
        Ok(match self.force {
            Force::Sharp => {
                let mut force = SharpMembrane::new(law, of.mean_viscosity());
                if let Some(surfactant) = &self.surfactant {
                    let concentration = surfactant.concentration(of, self.tension)?;
                    force = force.with_surfactant(concentration, surfactant.diffusivity);
                }
                Immersed::boxed(interface, force)
            }
            Force::Smeared => build::smeared(interface, law, (numerics, band, false)),
        })
    }
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
        let sizes = view.measure_interface(k, self.cuts(), row)?;
        round::measure(view, (&self.name, k), sizes, row)
    }
}

impl StructureKind for Drop {
    fn name(&self) -> &str {
        &self.name
    }
    fn list(&self) -> &'static str {
        "drop"
    }
    fn shape(&self) -> Option<&Shape> {
        Some(&self.shape)
    }
    fn traits(&self) -> Traits {
        Traits {
            constant_tension: self.surfactant.is_none(),
            carries_stretch: self.surfactant.is_some(),
            modulus: self.tension,
            pulls: self.tension > 0.0,
            on_interface: self.force == Force::Sharp,
            own_fluid: [self.density, self.viscosity],
            round_at_rest: true,
            ..Traits::default()
        }
    }
    fn words(&self) -> Vec<String> {
        let own = self.traits().own_fluid_in_words();
        let (name, tension) = (&self.name, self.tension);
        let tension = match &self.surfactant {
            None => format!("surface tension {tension}"),
            Some(Surfactant { elasticity, diffusivity, .. }) => format!(
                "surface tension {tension} - {elasticity} c, c the concentration of a surfactant \
                 of diffusivity {diffusivity}"
            ),
        };
        vec![format!("drop `{name}`: {tension}{own}; its level set by (1.34)")]
    }
    fn numerics(&self, tables: &Tables) -> Option<String> {
        if self.force == Force::Sharp {
            return (self.tension > 0.0)
                .then(|| format!("force of `{}` on the interface itself", self.name));
        }
        Some(build::band_words(&self.name, &tables.numerics, self.band(&tables.numerics)))
    }
    fn chords(&self) -> Vec<String> {
        self.cuts().names().map(str::to_string).collect()
    }
    fn charts(&self, of: &Columns<'_>) -> Vec<Plot> {
        let name = &self.name;
        let charts = [
            of.axes(name, true),
            of.chords(name, self.cuts().names()),
            round::velocity_chart(of, name),
            round::roundness_chart(of, name),
        ];
        charts.into_iter().flatten().collect()
    }
    fn write(&self, out: &mut Writer) {
        self.section("[[drop]]", out);
    }
    fn boxed(&self) -> Box<dyn StructureKind> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
