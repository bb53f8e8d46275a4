//! The throw-away structure in a scene: `[[spring]]`.

use super::physics::Spring as Pulled;
use crate::base::Result;
use crate::output::Figure;
use crate::scene::charts::Columns;
use crate::scene::cuts::Cuts;
use crate::scene::keys::{Absent::*, Context, Item, Keys, Kind::*, Writer, identifier, number, row, text, vector};
use crate::scene::points::point;
use crate::scene::row::Row;
use crate::scene::schema::{Shape, shape};
use crate::scene::structures::{Build, KindIn, Registered, StructureKind, Traits};
use crate::scene::view::View;
use crate::structure::Structure;

pub(in crate::scene) const KIND: Registered = Registered {
    list: "spring",
    keys: &KEYS,
    doc: "Discs of fluid that springs pull to points.",
    example: |d| if d == 2 { "anchor = [1, 1]\nstiffness = 1" } else { "anchor = [1, 1, 1]\nstiffness = 1" },
    read: |item, _, context| Ok(Box::new(Spring::read(item, context)?)),
};

#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    pub name: String,
    pub shape: Shape,
    pub anchor: Vec<f64>,
    pub stiffness: f64,
}

static KEYS: Keys = Keys {
    about: "A disc of fluid that a spring pulls to a point.",
    keys: &[
        row("name", Value("text"), "", Default("\"spring\""), "Its name in results."),
        row("shape", Table(&shape::KEYS), "", Required, "Its form at time 0."),
        row("anchor", Value("point"), "m", Required, "The point."),
        row("stiffness", Value("number > 0"), "N/m", Required, "Force over the distance."),
    ],
};

impl Spring {
    fn read(item: &Item, context: &Context) -> Result<Spring> {
        let table = item.table(&KEYS)?;
        let shape = "give one: shape.circle = { centre = [1, 1], radius = 0.5 }";
        Ok(Spring {
            name: table.optional("name", identifier)?.unwrap_or_else(|| "spring".to_string()),
            shape: table.required("shape", shape, |i| Shape::read(i, context))?,
            anchor: table.required("anchor", "give a point: anchor = [1, 1]", |i| i.point(context))?,
            stiffness: table.required("stiffness", "give one: stiffness = 1", Item::positive)?,
        })
    }
}

impl<const D: usize> KindIn<D> for Spring {
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>> {
        of.check_band(&self.name, true, 1.0)?;
        let phi = of.placed()?.nodal.clone();
        Ok(Box::new(Pulled::new(&self.name, phi, (point(&self.anchor), self.stiffness, of.thickness))))
    }
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
        view.measure_interface(k, &Cuts::default(), row)?;
        let fields = &view.state.fields;
        let path = fields.find(&format!("{}.path", self.name)).map_or(f64::NAN, |id| fields.scalar(id)[0]);
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
        vec![format!("spring `{}`: stiffness {}, pulls to {:?}", self.name, self.stiffness, self.anchor)]
    }
    fn charts(&self, of: &Columns<'_>) -> Vec<Figure> {
        let mut sheet = of.sheet();
        sheet.line("path", of.column_of(&self.name, "path"));
        let title = format!("Path of {}", self.name);
        let drawn = sheet.draw(format!("path-{}", self.name), [&title, "length"], "Length of the path.");
        drawn.into_iter().collect()
    }
    fn write(&self, out: &mut Writer) {
        out.header("[[spring]]");
        out.entry("name", text(&self.name));
        out.entry("shape", self.shape.write());
        out.entry("anchor", vector(&self.anchor));
        out.entry("stiffness", number(self.stiffness));
    }
    fn boxed(&self) -> Box<dyn StructureKind> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
