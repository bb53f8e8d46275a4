//! `[[drop]]`: a fluid in another one, with surface tension between them.

use super::build::{self, Build, band_of};
use super::membrane::Forces;
use super::{KindIn, Registered, StructureKind, Traits, round};
use crate::base::Result;
use crate::elastic::{AreaLaw, Band, Force, SharpMembrane};
use crate::mesh::Point;
use crate::output::Figure;
use crate::scene::charts::Columns;
use crate::scene::cuts::{self, Chord, Cuts, Ring};
use crate::scene::keys::{
    Context, Identifier, Item, Named, Nested, NonNegative, Opt, Positive, Tabled, Writer, table,
};
use crate::scene::row::Row;
use crate::scene::schema::{Numerics, Shape, Tables};
use crate::scene::view::View;
use crate::structure::{Immersed, ImmersedInterface, Structure};
use std::sync::Arc;

/// The kind `[[drop]]`.
pub(super) const KIND: Registered = Registered {
    list: "drop",
    keys: Drop::KEYS,
    doc: "Fluids in the fluid, with surface tension.",
    #[cfg(test)]
    example: |_| "",
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
        /// Surface tension.
        tension: f64 [NonNegative, "N/m", Default(0.0)],
        /// Mass per volume of what is inside.
        density: Option<f64> [Opt<NonNegative>, "kg/m3", Derived("that of the fluid")],
        /// Dynamic viscosity of what is inside.
        viscosity: Option<f64> [Opt<Positive>, "Pa s", Derived("that of the fluid")],
        /// Where surface tension acts: on the interface itself, cut out of the cells, or over a
        /// band of half-width `numerics.thickness`.
        force: Force [Forces,
            Derived("\"sharp\"; \"smeared\" where `numerics` has `surface_tension`, `band`, `kernel`, \
                `width` or the semi-implicit coupling", Force::Sharp)],
        /// Lines along which the contour is measured.
        chords: Vec<Named<Chord>> [Named<Chord>],
        /// Planes through the surface in which its form is measured; in space alone.
        rings: Vec<Named<Ring>> [Named<Ring>],
    } before cuts::check;
}

impl Drop {
    /// Reads a drop. The default force is smeared where a key is given that only a band has.
    fn read_for(item: &Item, numerics: &Numerics, context: &Context) -> Result<Drop> {
        let mut drop = Drop::read(item, context)?;
        if numerics.key_of_band().is_some() && item.open_table()?.get("force").is_none() {
            drop.force = Force::Smeared;
        }
        Ok(drop)
    }
    fn cuts(&self) -> Cuts<'_> {
        Cuts { chords: &self.chords, rings: &self.rings }
    }
    fn band(&self, numerics: &Numerics) -> Band {
        band_of(numerics, true)
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
        let law = AreaLaw::Tension { tension: self.tension };
        Ok(match self.force {
            Force::Sharp => {
                Immersed::boxed(interface, SharpMembrane::new(law, of.mean_viscosity()))
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
            constant_tension: true,
            modulus: self.tension,
            pulls: self.tension > 0.0,
            on_interface: self.force == Force::Sharp,
            own_fluid: [self.density, self.viscosity],
            round_at_rest: true,
            ..Traits::default()
        }
    }
    fn words(&self) -> Vec<String> {
        let own = [("density", self.density), ("viscosity", self.viscosity)];
        let own =
            own.iter().filter_map(|(what, value)| Some(format!(", {what} {} inside", (*value)?)));
        let own: String = own.collect();
        let (name, tension) = (&self.name, self.tension);
        vec![format!("drop `{name}`: surface tension {tension}{own}; its level set by (1.34)")]
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
    fn charts(&self, of: &Columns<'_>) -> Vec<Figure> {
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
