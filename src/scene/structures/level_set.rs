//! `[[level_set]]`: passive interfaces.

use super::build::Build;
use super::{KindIn, Registered, StructureKind, Traits};
use crate::base::{Error, Result};
use crate::mesh::Point;
use crate::scene::charts::{Columns, Plot};
use crate::scene::cuts::Cuts;
use crate::scene::keys::{
    Context, Form, Identifier, Kind, Nested, Table, Tabled, Writer, kinds, table,
};
use crate::scene::row::Row;
use crate::scene::schema::Shape;
use crate::scene::view::View;
use crate::structure::{self, Structure};

/// The kind `[[level_set]]`.
pub(super) const KIND: Registered = Registered {
    list: "level_set",
    keys: LevelSet::KEYS,
    doc: "Interfaces that are carried and act on nothing.",
    #[cfg(test)]
    example: |_| "",
    read: |item, _, context| Ok(Box::new(LevelSet::read(item, context)?)),
};

table! {
    /// A closed interface that is carried and acts on nothing.
    LevelSet {
        /// Its name in results; unique in the scene.
        name: String [Identifier, Default("interface")],
        /// Its form at time 0.
        shape: Shape [Nested<Shape>,
            Required("give one: shape.circle = { centre = [0.5, 0.75], radius = 0.15 }")],
        /// Particles on the interface, in columns of their own: the length and the area of their
        /// polygon. In the plane alone.
        markers: usize [Markers, Default(0)],
    } before LevelSet::before;
}

kinds! {
    /// A number of markers: a polygon has three corners.
    Markers: usize = Kind::Value("whole number from 3, or 0 for none", Form::Whole([0, MOST_MARKERS])),
        |i, _| if i.is_zero() { Ok(0) } else { i.count(3, MOST_MARKERS) };
}

/// Columns of the polygon of the markers.
const MARKERS: [&str; 2] = ["markers_length", "markers_area"];

const MOST_MARKERS: usize = 10_000_000;

impl LevelSet {
    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        match table.get("markers").filter(|i| !i.is_zero() && context.dimension == 3) {
            None => Ok(()),
            Some(item) => Err(item
                .key_error(
                    "markers follow a curve, and the interface is a surface: the scene has 3 \
                     dimensions",
                )
                .remedy("leave them out")),
        }
    }
    /// Points on the interface, which must not cross periodic sides.
    fn markers<const D: usize>(&self, of: &Build<'_, '_, D>) -> Result<Vec<Point<D>>> {
        if self.markers == 0 {
            return Ok(Vec::new());
        }
        if !of.site.pairs.is_empty() {
            let e = Error::scene("markers do not pass through periodic sides")
                .value(self.markers)
                .remedy("leave them out, or give walls to the mesh");
            return Err(of.blame("markers", e));
        }
        of.markers(self.markers).map_err(|e| of.blame("markers", e))
    }
}

impl<const D: usize> KindIn<D> for LevelSet {
    fn build(&self, of: &mut Build<'_, '_, D>) -> Result<Box<dyn Structure<D>>> {
        of.check_on_mesh()?;
        let markers = self.markers(of)?;
        let level_set = structure::LevelSet::new(&*self.name, of.placed()?.nodal.clone());
        let level_set = level_set.with_function(of.placed()?.function.clone());
        Ok(Box::new(level_set.with_markers(markers)))
    }
    fn measure(&self, view: &View<'_, D>, k: usize, row: &mut Row) -> Result<()> {
        view.measure_interface(k, Cuts::default(), row)?;
        if self.markers > 0 {
            let polygon = view.marker_polygon(k).unwrap_or([f64::NAN; 2]);
            row.put_all(&format!("{}.", self.name), MARKERS.into_iter().zip(polygon));
        }
        Ok(())
    }
}

impl StructureKind for LevelSet {
    fn name(&self) -> &str {
        &self.name
    }
    fn list(&self) -> &'static str {
        "level_set"
    }
    fn shape(&self) -> Option<&Shape> {
        Some(&self.shape)
    }
    fn traits(&self) -> Traits {
        Traits { acts: false, ..Traits::default() }
    }
    fn words(&self) -> Vec<String> {
        let markers = match self.markers {
            0 => String::new(),
            count => format!("; {count} markers follow it"),
        };
        vec![format!("level set `{}`: carried by (1.2), acts on nothing{markers}", self.name)]
    }
    fn charts(&self, of: &Columns<'_>) -> Vec<Plot> {
        length_chart(of, &self.name).into_iter().collect()
    }
    fn write(&self, out: &mut Writer) {
        self.section("[[level_set]]", out);
    }
    fn boxed(&self) -> Box<dyn StructureKind> {
        Box::new(self.clone())
    }
    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}

/// Length of a passive interface (in space: area), and that of the polygon of its markers.
fn length_chart(of: &Columns<'_>, name: &str) -> Option<Plot> {
    let mut sheet = of.sheet();
    if of.dimension == 3 {
        sheet.line("interface", of.column_of(name, "surface"));
        let title = format!("Surface of {name}");
        let caption = "The area of the interface. It falls where thin parts of the interface are \
            lost to the mesh.";
        return sheet.draw(format!("surface-{name}"), [&title, "area"], caption);
    }
    sheet.line("interface", of.column_of(name, "perimeter"));
    sheet.dashed("markers", of.column_of(name, MARKERS[0]).map(<[f64]>::to_vec));
    let title = format!("Length of {name}");
    let caption = "The length of the interface, and (dashed) that of the closed polygon of \
        markers that are carried with it, if there are any: the truth, as long as neighbours are \
        near each other. Where the interface is shorter, thin parts of it have been lost.";
    sheet.draw(format!("length-{name}"), [&title, "length"], caption)
}
