//! The test structure in a scene: `[[spring]]`.

use super::physics::Spring as Pulled;
use crate::base::Result;
use crate::scene::charts::{Columns, Plot};
use crate::scene::cuts::Cuts;
use crate::scene::keys::{Identifier, Nested, Point as Place, Positive, Tabled, Writer, table};
use crate::scene::points::point;
use crate::scene::row::Row;
use crate::scene::schema::Shape;
use crate::scene::structures::{Build, KindIn, Registered, StructureKind, Traits};
use crate::scene::view::View;
use crate::structure::Structure;

pub(in crate::scene) const KIND: Registered = Registered {
    list: "spring",
    keys: Spring::KEYS,
    doc: "Discs of fluid that springs pull to points.",
    example: |d| {
        if d == 2 { "anchor = [1, 1]\nstiffness = 1" } else { "anchor = [1, 1, 1]\nstiffness = 1" }
    },
    read: |item, _, context| Ok(Box::new(Spring::read(item, context)?)),
};

table! {
    /// A disc of fluid that a spring pulls to a point.
    Spring {
        /// Its name in results.
        name: String [Identifier, Default("spring")],
        /// Its form at time 0.
        shape: Shape [Nested<Shape>,
            Required("give one: shape.circle = { centre = [1, 1], radius = 0.5 }")],
        /// The point.
        anchor: Vec<f64> [Place, "m", Required("give a point: anchor = [1, 1]")],
        /// Force over the distance.
        stiffness: f64 [Positive, "N/m", Required("give one: stiffness = 1")],
    }
}

impl<const D: usize> KindIn<D> for Spring {
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>> {
        of.check_band(&self.name, true, 1.0)?;
        let phi = of.placed()?.nodal.clone();
        Ok(Box::new(Pulled::new(
            &self.name,
            phi,
            (point(&self.anchor), self.stiffness, of.thickness),
        )))
    }
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
        view.measure_interface(k, Cuts::default(), row)?;
        let fields = &view.state.fields;
        let path =
            fields.find(&format!("{}.path", self.name)).map_or(f64::NAN, |id| fields.scalar(id)[0]);
        row.put(format!("{}.path", self.name), path);
        Ok(())
    }
}

impl StructureKind for Spring {
    fn name(&self) -> &str {
        &self.name
    }
    fn list(&self) -> &'static str {
        "spring"
    }
    fn shape(&self) -> Option<&Shape> {
        Some(&self.shape)
    }
    fn traits(&self) -> Traits {
        Traits { modulus: self.stiffness, ..Traits::default() }
    }
    fn words(&self) -> Vec<String> {
        vec![format!(
            "spring `{}`: stiffness {}, pulls to {:?}",
            self.name, self.stiffness, self.anchor
        )]
    }
    fn charts(&self, of: &Columns<'_>) -> Vec<Plot> {
        let mut sheet = of.sheet();
        sheet.line("path", of.column_of(&self.name, "path"));
        let title = format!("Path of {}", self.name);
        let drawn =
            sheet.draw(format!("path-{}", self.name), [&title, "length"], "Length of the path.");
        drawn.into_iter().collect()
    }
    fn write(&self, out: &mut Writer) {
        self.section("[[spring]]", out);
    }
    fn boxed(&self) -> Box<dyn StructureKind> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
