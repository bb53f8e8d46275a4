//! `[[vesicle]]`: closed membranes that bend and do not stretch.

use super::build::Build;
use super::motion;
use super::{Finding, KindIn, Registered, StructureKind, Traits};
use crate::base::Result;
use crate::elastic::{Motion, ShearLaw, Vesicle as Force};
use crate::mesh::Point;
use crate::scene::charts::{Columns, Plot};
use crate::scene::cuts::{self, Chord, Cuts, Ring};
use crate::scene::keys::{
    Context, Identifier, Named, Nested, NonNegative, Number, Opt, Positive, Table, Tabled, Writer,
    table,
};
use crate::scene::row::Row;
use crate::scene::schema::{Shape, Tables};
use crate::scene::view::View;
use crate::sim::ConvectionScheme;
use crate::structure::{Immersed, ImmersedInterface, Structure};
use std::f64::consts::PI;
use std::sync::Arc;

/// The kind `[[vesicle]]`.
pub(super) const KIND: Registered = Registered {
    list: "vesicle",
    keys: Vesicle::KEYS,
    doc: "Closed membranes that bend and do not stretch.",
    #[cfg(test)]
    example: |_| "bending = 1",
    read: |item, numerics, context| {
        if numerics.convection == Some(Some(ConvectionScheme::Implicit)) {
            return Err(item
                .key_error("implicit convection has a nonsymmetric matrix, and that of a vesicle is symmetric")
                .value("numerics.convection = \"baker1982\"")
                .remedy("leave numerics.convection out, or take \"pironneau1982\""));
        }
        Ok(Box::new(Vesicle::read(item, context)?))
    },
};

table! {
    /// A vesicle: a fluid in a membrane of lipids, which resists bending and keeps its length (in
    /// space: its area) everywhere, as its contents keep their area (volume).
    Vesicle {
        /// Its name in results; unique in the scene.
        name: String [Identifier, Default("vesicle")],
        /// Its form at time 0.
        shape: Shape [Nested<Shape>,
            Required("give one: shape.ellipse = { centre = [1, 1], semi_axes = [0.6, 0.3] }")],
        /// Bending modulus k of the energy k/2 (H - c)^2 per area, H the sum of the principal
        /// curvatures.
        bending: f64 [Positive, "J", Required("give one: bending = 1")],
        /// Spontaneous curvature c, positive for that of a sphere; without effect in the plane.
        spontaneous_curvature: f64 [Number, "1/m", Default(0.0)],
        /// The law of the energy of its shear, which a skeleton under the lipids resists as in red
        /// blood cells; in space alone. Its resistance to a change of area has no modulus: there is
        /// none.
        shear: Option<ShearLaw> [Opt<Nested<ShearLaw>>, Derived("none")],
        /// Mass per volume of what is inside.
        density: Option<f64> [Opt<NonNegative>, "kg/m3", Derived("that of the fluid")],
        /// Dynamic viscosity of what is inside.
        viscosity: Option<f64> [Opt<Positive>, "Pa s", Derived("that of the fluid")],
        /// Lines along which the contour is measured.
        chords: Vec<Named<Chord>> [Named<Chord>],
        /// Planes through the surface in which its form is measured; in space alone.
        rings: Vec<Named<Ring>> [Named<Ring>],
    } before Vesicle::before;
}

impl Vesicle {
    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        if let (2, Some(item)) = (context.dimension, table.get("shear")) {
            return Err(item
                .key_error("shear is for surfaces in space, and a vesicle of the plane is a curve")
                .remedy("leave it out"));
        }
        cuts::check(table, context)
    }
    fn cuts(&self) -> Cuts<'_> {
        Cuts { chords: &self.chords, rings: &self.rings }
    }
}

impl<const D: usize> KindIn<D> for Vesicle {
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>> {
        of.check_band(&self.name, of.inside.is_some(), 1.0)?;
        let distance = of.placed()?.function.clone();
        let interface = ImmersedInterface {
            function: Some(Arc::new(move |x: &Point<D>| distance(x))),
            inside: of.inside,
            ..ImmersedInterface::new(&*self.name, of.placed()?.nodal.clone(), of.thickness)
        };
        let viscosity = of.mean_viscosity();
        let force = Force::new(self.bending, self.spontaneous_curvature, viscosity);
        Ok(Immersed::boxed(
            interface,
            match self.shear {
                Some(shear) => force.with_shear(shear),
                None => force,
            },
        ))
    }
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
        let [enclosed, own] = view.measure_interface(k, self.cuts(), row)?;
        let name = &self.name;
        if D == 3 {
            let volume = 4.0 / 3.0 * PI * (own / (4.0 * PI)).powf(1.5);
            row.put(format!("{name}.reduced_volume"), enclosed / volume);
            return Ok(());
        }
        row.put(format!("{name}.reduced_area"), 4.0 * PI * enclosed / (own * own));
        let lengths = view.lengths_along_axes(k)?;
        let deformation = lengths.map(|[long, short]| (long - short) / (long + short));
        row.put(format!("{name}.deformation"), deformation.unwrap_or(f64::NAN));
        let motion = Motion::of_vesicle(&view.state.fields, name).unwrap_or_default();
        row.put(format!("{name}.turned"), motion.turned);
        row.put(format!("{name}.treaded"), motion.treaded);
        Ok(())
    }
}

impl StructureKind for Vesicle {
    fn name(&self) -> &str {
        &self.name
    }
    fn list(&self) -> &'static str {
        "vesicle"
    }
    fn shape(&self) -> Option<&Shape> {
        Some(&self.shape)
    }
    fn traits(&self) -> Traits {
        Traits {
            pulls: true,
            on_interface: true,
            keeps_size: true,
            carries_strain: self.shear.is_some(),
            own_fluid: [self.density, self.viscosity],
            ..Traits::default()
        }
    }
    fn words(&self) -> Vec<String> {
        let own = self.traits().own_fluid_in_words();
        let (name, bending, curvature) = (&self.name, self.bending, self.spontaneous_curvature);
        vec![format!(
            "vesicle `{name}`: bending energy {bending}/2 (H - {curvature})^2 per area, no change of its \
             area{own}; its level set by (1.34)"
        )]
    }
    fn numerics(&self, _: &Tables) -> Option<String> {
        Some(format!(
            "tension and bending moment of `{}` on the interface itself, implicit, unknowns of the \
             same system as the flow",
            self.name
        ))
    }
    fn chords(&self) -> Vec<String> {
        self.cuts().names().map(str::to_string).collect()
    }
    fn findings(&self, of: &Columns<'_>) -> Vec<Finding> {
        let column = |what: &str| of.column_of(&self.name, what);
        let (Some(time), Some(turned), Some(treaded)) =
            (of.column("time"), column("turned"), column("treaded"))
        else {
            return Vec::new();
        };
        motion::findings([time, turned, treaded])
    }
    fn charts(&self, of: &Columns<'_>) -> Vec<Plot> {
        let name = &self.name;
        let mut angles = of.sheet();
        angles.line("long axis", of.column_of(name, "turned"));
        angles.line("point of the membrane", of.column_of(name, "treaded"));
        let caption = "Direction of the long axis, and of a point of the membrane from the centre, \
            counted on over turns.";
        let title = format!("Motion of {name}");
        let angles = angles.draw(format!("motion-{name}"), [&title, "angle (degrees)"], caption);
        let mut form = of.sheet();
        form.line("deformation", of.column_of(name, "deformation"));
        let caption = "Difference of the lengths along the axes of inertia over their sum.";
        let title = format!("Deformation of {name}");
        let form = form.draw(format!("deformation-{name}"), [&title, "deformation"], caption);
        let charts = [of.axes(name, false), angles, form, of.chords(name, self.cuts().names())];
        charts.into_iter().flatten().collect()
    }
    fn write(&self, out: &mut Writer) {
        self.section("[[vesicle]]", out);
    }
    fn boxed(&self) -> Box<dyn StructureKind> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
