//! `[output.picture]`: how pictures look.

use super::source::{Motion, Quantity, Source};
use crate::base::Result;
use crate::scene::keys::Item;
use crate::scene::keys::{Absent::*, Keys, Kind::*, row, words};
use crate::scene::keys::{name, number, vector};

/// A plane across an axis, on which fields are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// The axis that is its normal.
    pub axis: usize,
    /// The coordinate along it; the middle of the domain if `None`.
    pub at: Option<f64>,
}
/// How pictures look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// The field whose values are the colours; not the velocity, which is a vector.
    pub field: Quantity,
    /// Whether the edges of the mesh are drawn.
    pub mesh: bool,
    /// Pixels along the longer side.
    pub size: usize,
    /// In space: where the viewer stands, azimuth from x towards y and elevation above the plane of x and y, in degrees.
    pub view: [f64; 2],
    /// In space: the plane that is shown in place of the interfaces.
    pub slice: Option<Cut>,
    /// In space: lower and upper corner of the part of the domain that is shown, if not all of it.
    pub window: Option<[[f64; 3]; 2]>,
}

/// What a picture can show.
const FIELDS: [(&str, Quantity); 9] = [
    ("image", Quantity::Image),
    ("pressure", Quantity::Pressure),
    ("speed", Quantity::Speed),
    ("vorticity", Quantity::Vorticity),
    ("level_set", Quantity::LevelSet),
    ("stretch", Quantity::Stretch),
    ("area_change", Quantity::AreaChange),
    ("shear", Quantity::Shear),
    ("checkerboard", Quantity::Checkerboard),
];
const FIELD_WORDS: [&str; FIELDS.len()] = words(&FIELDS);
const AXES: [(&str, usize); 3] = [("x", 0), ("y", 1), ("z", 2)];
const AXIS_WORDS: [&str; AXES.len()] = words(&AXES);

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "How pictures look.",
    keys: &[
        row(
            "field",
            Choice(&FIELD_WORDS),
            "",
            Derived("speed; image where one is segmented; the level set where one is carried by a given velocity"),
            "The field whose values are the colours. Vorticity is blue where the fluid turns clockwise and red where counter-clockwise; the strongest hundredth of it, by nodes, has the colours of the ends. In space it is the length of curl u. \
            Where an image is segmented the field is that `image` in grey, or the level set. In space, where backward characteristics are carried, also the area change Z1 and the shear \
             Z2 of the one interface, or a checkerboard that its material carries.",
        ),
        row(
            "mesh",
            Value("true or false"),
            "",
            Default("false"),
            "Whether the edges of the mesh are drawn; in the plane alone.",
        ),
        row("size", Value("whole number from 64 to 8192"), "pixels", Default("800"), "Length of the longer side."),
        row(
            "view",
            Value("two numbers"),
            "degrees",
            Default("[-60.0, 24.0]"),
            "In space, where the viewer stands: azimuth from x towards y, and elevation.",
        ),
        row("slice", Table(&CUT), "", Optional, "In space, a plane that is shown in place of the interfaces."),
        row(
            "window",
            Table(&WINDOW),
            "",
            Derived("the whole domain"),
            "In space, the part of the domain that is shown.",
        ),
    ],
};

static WINDOW: Keys = Keys {
    about: "A box with sides along the axes.",
    keys: &[
        row("min", Value("point"), "m", Required, "The corner with the smallest coordinates."),
        row("max", Value("point"), "m", Required, "The corner with the largest coordinates."),
    ],
};

static CUT: Keys = Keys {
    about: "A plane across an axis.",
    keys: &[
        row("axis", Choice(&AXIS_WORDS), "", Required, "The axis that is its normal."),
        row("at", Value("number"), "m", Derived("the middle of the domain"), "The coordinate along the axis."),
    ],
};

impl Picture {
    pub(in crate::scene) const DEFAULT: Picture =
        Picture { field: Quantity::Speed, mesh: false, size: 800, view: [-60.0, 24.0], slice: None, window: None };

    pub(in crate::scene) fn write(&self, dimension: usize) -> String {
        let Picture { field, mesh, size, view, slice, window } = self;
        let field = name(*field, &FIELDS);
        let view = if dimension == 2 { String::new() } else { format!(", view = {}", vector(view)) };
        let slice = slice.map_or(String::new(), |Cut { axis, at }| {
            let at = at.map_or(String::new(), |at| format!(", at = {}", number(at)));
            format!(", slice = {{ axis = {}{at} }}", name(axis, &AXES))
        });
        let window = window.map_or(String::new(), |[min, max]| {
            format!(", window = {{ min = {}, max = {} }}", vector(&min), vector(&max))
        });
        format!("{{ field = {field}, mesh = {mesh}, size = {size}{view}{slice}{window} }}")
    }
}

impl Source<'_> {
    pub(in crate::scene) fn default_picture(&self) -> Picture {
        let field = match (self.motion, self.interfaces.len()) {
            (Motion::Image, _) => Quantity::Image,
            (Motion::Prescribed, 1) => Quantity::LevelSet,
            _ => Picture::DEFAULT.field,
        };
        Picture { field, ..Picture::DEFAULT }
    }

    pub(in crate::scene) fn picture(&self, item: &Item) -> Result<Picture> {
        let table = item.table(&KEYS)?;
        let of_space = ["view", "slice", "window"].into_iter().find_map(|key| table.get(key));
        if let (2, Some(item)) = (self.context.dimension, of_space) {
            return Err(item
                .key_error(format!("`{}` is for pictures of space, and the mesh is plane", item.key))
                .remedy("leave it out"));
        }
        let mesh = |i: &Item| match (i.boolean()?, self.context.dimension) {
            (true, 3) => Err(i
                .error("the edges of a mesh are drawn in the plane alone, and the scene has 3 dimensions")
                .remedy("write mesh = false, or open fields.pvd in ParaView")),
            (mesh, _) => Ok(mesh),
        };
        let field = table.optional("field", |i| self.field(i))?.unwrap_or(self.default_picture().field);
        Ok(Picture {
            field,
            mesh: table.optional("mesh", mesh)?.unwrap_or(Picture::DEFAULT.mesh),
            size: table.optional("size", |i| i.count(64, 8192))?.unwrap_or(Picture::DEFAULT.size),
            view: table.optional("view", Item::vector)?.unwrap_or(Picture::DEFAULT.view),
            slice: table.optional("slice", |i| match (cut(i)?, field) {
                (_, Quantity::Checkerboard) => Err(i
                    .key_error("a checkerboard is on the interface, and `slice` shows a plane in its place")
                    .remedy("leave slice out, or show another field")),
                (cut, _) => Ok(cut),
            })?,
            window: table.optional("window", window)?,
        })
    }

    /// The field of a picture.
    fn field(&self, item: &Item) -> Result<Quantity> {
        if item.text().is_ok_and(|text| text == "velocity") {
            return Err(item.error("a picture shows one number at each point").remedy("write field = \"speed\""));
        }
        let field = item.choice(&FIELDS)?;
        if field == Quantity::Image {
            return match self.motion {
                Motion::Image => Ok(field),
                _ => Err(item.error("the scene has no [image] that a picture could show").remedy("show the speed")),
            };
        }
        if !matches!(field, Quantity::AreaChange | Quantity::Shear | Quantity::Checkerboard) {
            return self.possible(item, field);
        }
        let word = item.text()?;
        let what = match (self.context.dimension, self.has_map, self.interfaces.len()) {
            (2, _, _) => "shows the strain of a surface, and the mesh is plane",
            (_, false, _) => "needs backward characteristics, which nothing in the scene carries",
            (_, _, 1) => return Ok(field),
            _ => "belongs to one interface",
        };
        Err(item.error(format!("`{word}` {what}")).remedy(
            "show the speed, or give a scene of space one [[membrane]] with a law of shear, or output.backward_map = true",
        ))
    }
}

fn window(item: &Item) -> Result<[[f64; 3]; 2]> {
    let table = item.table(&WINDOW)?;
    let corner = |key: &str| {
        table.required(key, "give both corners: window = { min = [-1, -1, -1], max = [1, 1, 1] }", Item::vector)
    };
    let [min, max]: [[f64; 3]; 2] = [corner("min")?, corner("max")?];
    if (0..3).all(|k| min[k] < max[k]) {
        return Ok([min, max]);
    }
    Err(item.error("the window has no volume").remedy("give `max` larger coordinates than `min`"))
}

fn cut(item: &Item) -> Result<Cut> {
    let table = item.table(&CUT)?;
    Ok(Cut {
        axis: table.required("axis", "name the axis: slice = { axis = \"z\" }", |i| i.choice(&AXES))?,
        at: table.optional("at", Item::number)?,
    })
}
