//! `[output.picture]`: appearance of pictures.

use super::given::{Given, Motion, Quantity};
use crate::base::Result;
use crate::output::ColourMap;
use crate::scene::keys::{
    Context, Count, Flag, Item, Kind, Nested, Number, Numbers, Opt, Point, Table, Typed, table,
    words,
};

table! {
    /// How pictures look.
    Picture {
        /// The field whose values are the colours. Vorticity is blue where the fluid turns
        /// clockwise and red where counter-clockwise; the strongest hundredth of it, by nodes, has
        /// the colours of the ends. In space it is the length of curl u. Where an image is
        /// segmented the field is that `image` in grey, or the level set. In space, where backward
        /// characteristics are carried, also the area change Z1 and the shear Z2 of the one
        /// interface, or a checkerboard that its material carries.
        field: Quantity [Shown,
            Derived("speed; image where one is segmented; the level set where one is carried by a \
                given velocity", Quantity::Speed)],
        /// Whether the edges of the mesh are drawn; in the plane alone.
        mesh: bool [Flag, Default(false)],
        /// Length of the longer side.
        size: usize [Count<64, 8192>, "pixels", Default(800)],
        /// In space, where the viewer stands: azimuth from x towards y, and elevation.
        view: Option<[f64; 2]> [Opt<Numbers<2>>, "degrees", Default([-60.0, 24.0])],
        /// In space, a plane that is shown in place of the interfaces.
        slice: Option<Cut> [Opt<Nested<Cut>>],
        /// The part of the domain that is shown.
        window: Option<Window> [Opt<Nested<Window>>, Derived("the whole domain")],
        /// The values at the two ends of the colours; values beyond have the colours of the ends.
        /// With it the pictures of several runs can be compared.
        range: Option<[f64; 2]> [Opt<Numbers<2>>, Derived("all values of the run")],
        /// The colours. All but "blue_red" are perceptually uniform: equal differences look equal.
        /// "blue_red" is white at zero.
        colours: Option<ColourMap> [Opt<Maps>,
            Derived("\"viridis\"; \"blue_red\" where values have both signs; \"grey\" for an image")],
    } before Picture::before; check Picture::check;
}

table! {
    /// A box with sides along the axes.
    Window {
        /// The corner with the smallest coordinates.
        min: Vec<f64> [Point, "m",
            Required("give both corners: window = { min = [0, 0], max = [2, 1] }",
                "give both corners: window = { min = [-1, -1, -1], max = [1, 1, 1] }")],
        /// The corner with the largest coordinates.
        max: Vec<f64> [Point, "m",
            Required("give both corners: window = { min = [0, 0], max = [2, 1] }",
                "give both corners: window = { min = [-1, -1, -1], max = [1, 1, 1] }")],
    }
}

table! {
    /// A plane across an axis.
    Cut: Copy {
        /// The axis that is its normal.
        axis: usize [Axes, Required("name the axis: slice = { axis = \"z\" }")],
        /// The coordinate along the axis.
        at: Option<f64> [Opt<Number>, "m", Derived("the middle of the domain")],
    }
}

words! {
    Fields: Quantity {
        "image" = Quantity::Image,
        "pressure" = Quantity::Pressure,
        "speed" = Quantity::Speed,
        "vorticity" = Quantity::Vorticity,
        "level_set" = Quantity::LevelSet,
        "stretch" = Quantity::Stretch,
        "area_change" = Quantity::AreaChange,
        "shear" = Quantity::Shear,
        "checkerboard" = Quantity::Checkerboard,
    }
}
words! {
    Maps: ColourMap {
        "viridis" = ColourMap::Viridis,
        "cividis" = ColourMap::Cividis,
        "magma" = ColourMap::Magma,
        "inferno" = ColourMap::Inferno,
        "plasma" = ColourMap::Plasma,
        "blue_red" = ColourMap::BlueRed,
        "grey" = ColourMap::Grey,
    }
}
words! { Axes: usize { "x" = 0, "y" = 1, "z" = 2 } }

/// A field that a picture can show: any except the velocity, which is a vector.
pub(in crate::scene) struct Shown;

impl Typed for Shown {
    type Out = Quantity;
    const KIND: Kind = Fields::KIND;
    fn read(item: &Item<'_>, context: &Context) -> Result<Quantity> {
        if item.is_word("velocity") {
            return Err(item
                .error("a picture shows one number at each point")
                .remedy("write field = \"speed\""));
        }
        Fields::read(item, context)
    }
    fn toml(out: &Quantity) -> String {
        Fields::toml(out)
    }
}

impl Picture {
    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        match ["view", "slice"].into_iter().find_map(|key| table.get(key)) {
            Some(item) if context.dimension == 2 => Err(item
                .key_error(format!(
                    "`{}` is for pictures of space, and the mesh is plane",
                    item.key
                ))
                .remedy("leave it out")),
            _ => Ok(()),
        }
    }

    fn check(&mut self, table: &Table<'_>, context: &Context) -> Result<()> {
        self.check_window(table, context)?;
        if let (Some([low, high]), Some(item)) = (self.range, table.get("range"))
            && low >= high
        {
            return Err(item
                .error("the range of the colours is empty")
                .remedy("give the lower value first: range = [0, 1.5]"));
        }
        if context.dimension == 2 {
            self.view = None;
            return Ok(());
        }
        if let (true, Some(item)) = (self.mesh, table.get("mesh")) {
            return Err(item
                .error(
                    "the edges of a mesh are drawn in the plane alone, and the scene has 3 \
                     dimensions",
                )
                .remedy("write mesh = false, or open fields.pvd in ParaView"));
        }
        if let (Quantity::Checkerboard, Some(item)) = (self.field, table.get("slice")) {
            return Err(item
                .key_error(
                    "a checkerboard is on the interface, and `slice` shows a plane in its place",
                )
                .remedy("leave slice out, or show another field"));
        }
        Ok(())
    }

    fn check_window(&self, table: &Table<'_>, context: &Context) -> Result<()> {
        let size = if context.dimension == 2 { "area" } else { "volume" };
        match (&self.window, table.get("window")) {
            (Some(w), Some(item)) if !w.min.iter().zip(&w.max).all(|(a, b)| a < b) => Err(item
                .error(format!("the window has no {size}"))
                .remedy("give `max` larger coordinates than `min`")),
            _ => Ok(()),
        }
    }
}

impl Given<'_> {
    /// The default field of a picture.
    pub(in crate::scene) fn default_field(&self) -> Quantity {
        match (self.motion, self.interfaces.len()) {
            (Motion::Image, _) => Quantity::Image,
            (Motion::Prescribed, 1) => Quantity::LevelSet,
            _ => Quantity::Speed,
        }
    }

    /// Rejects a field that the scene does not have.
    pub(in crate::scene) fn check_field(&self, item: &Item, field: Quantity) -> Result<()> {
        if field == Quantity::Image {
            return match self.motion {
                Motion::Image => Ok(()),
                _ => Err(item
                    .error("the scene has no [image] that a picture could show")
                    .remedy("show the speed")),
            };
        }
        if !matches!(field, Quantity::AreaChange | Quantity::Shear | Quantity::Checkerboard) {
            return self.check_quantity(item, field);
        }
        let word = item.text()?;
        let of_map = field == Quantity::Checkerboard;
        let known = if of_map { self.has_map } else { self.has_strain };
        let what = match (self.context.dimension, known, self.interfaces.len()) {
            (2, _, _) => "shows the strain of a surface, and the mesh is plane",
            (_, false, _) => "needs backward characteristics, which nothing in the scene carries",
            (_, _, 1) => return Ok(()),
            _ => "belongs to one interface",
        };
        let remedy = match of_map && self.has_strain {
            true => "show the shear, or give output.backward_map = true",
            false => {
                "show the speed, or give a scene of space one [[membrane]] with a law of shear, or \
                 output.backward_map = true"
            }
        };
        Err(item.error(format!("`{word}` {what}")).remedy(remedy))
    }
}
