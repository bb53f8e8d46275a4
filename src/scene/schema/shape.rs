//! `[[membrane]] shape`: the initial form of an interface.

use super::polygon::Polygon;
use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::keys::{
    Context, Flag, Form, Item, Kind, Nested, NonNegative, Number, Numbers, Positive, Table, Tabled,
    Typed, Vector, kinds, list, one_of, table, words,
};

/// A closed curve (in space: a closed surface) and its inside.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A circle.
    Circle(Circle),
    /// An ellipse.
    Ellipse(Ellipse),
    /// An oval of a given reduced area.
    Oval(Oval),
    /// A spheroid of a given reduced volume, in space.
    Spheroid(Spheroid),
    /// A rectangle with rounded corners; in space a box with rounded edges.
    RoundedBox(RoundedBox),
    /// A simple polygon, of either orientation.
    Polygon(Polygon),
    /// A sphere, in space.
    Sphere(Sphere),
    /// An ellipsoid, in space.
    Ellipsoid(Ellipsoid),
    /// A torus, in space.
    Torus(Torus),
    /// The union of the shapes.
    Union(Vec<Shape>),
    /// The set where a level function of x, y (and z) is negative.
    Expression(Expression),
}

one_of! {
    /// A closed curve (in space: a closed surface) and its inside: exactly one of these.
    Shape {
        /// A circle, in the plane.
        "circle" [Nested<Circle>] (s) => (Shape::Circle(s));
        /// An ellipse, in the plane.
        "ellipse" [Nested<Ellipse>] (s) => (Shape::Ellipse(s));
        /// An oval of a given area and length, in the plane.
        "oval" [Nested<Oval>] (s) => (Shape::Oval(s));
        /// A spheroid of a given volume and surface, in space.
        "spheroid" [Nested<Spheroid>] (s) => (Shape::Spheroid(s));
        /// A sphere, in space.
        "sphere" [Nested<Sphere>] (s) => (Shape::Sphere(s));
        /// An ellipsoid, in space.
        "ellipsoid" [Nested<Ellipsoid>] (s) => (Shape::Ellipsoid(s));
        /// A torus, in space.
        "torus" [Nested<Torus>] (s) => (Shape::Torus(s));
        /// A rectangle with rounded corners; in space a box.
        "rounded_box" [Nested<RoundedBox>] (s) => (Shape::RoundedBox(s));
        /// A polygon, in the plane.
        "polygon" [Nested<Polygon>] (s) => (Shape::Polygon(s));
        /// All points that lie in one of the shapes.
        "union" [Shapes] (parts) => (Shape::Union(parts));
        /// The points where it is negative; of `x` and `y` (in space of `z` too), not constant, not
        /// of `t`.
        "expression" [LevelFunction] (e) => (Shape::Expression(e));
    } check check_dimension
}

table! {
    /// A circle.
    Circle: Copy {
        /// Centre.
        centre: [f64; 2] [Vector<2>, "m", Required("give the centre: centre = [1, 1]")],
        /// Radius.
        radius: f64 [Positive, "m", Required("give the radius: radius = 0.5")],
    }
}

table! {
    /// An ellipse.
    Ellipse: Copy {
        /// Centre.
        centre: [f64; 2] [Vector<2>, "m", Required("give the centre: centre = [1, 1]")],
        /// The first lies along x when `angle` is 0.
        semi_axes: [f64; 2] [Lengths<2>, "m", Required("give both: semi_axes = [0.75, 0.5]")],
        /// Counter-clockwise rotation.
        angle: f64 [Number, "degrees", Default(0.0)],
    }
}

table! {
    /// An oval by its size.
    Oval: Copy {
        /// Centre.
        centre: [f64; 2] [Vector<2>, "m", Required("give the centre: centre = [1, 1]")],
        /// Radius of the circle of the same area.
        radius: f64 [Positive, "m", Required("give the radius of its area: radius = 0.5")],
        /// The area over that of the circle of the same length, 4 pi A/L^2: at most 1, more than
        /// .05, of Cassini's oval .8.
        reduced_area: f64 [Positive, Required("give the reduced area: reduced_area = 0.8")],
        /// Direction of the longer axis, counter-clockwise from x.
        angle: f64 [Number, "degrees", Default(0.0)],
        /// Its curve.
        curve: OvalCurve [Curves, Default("ellipse")],
    } check Oval::check;
}

table! {
    /// A spheroid by its size.
    Spheroid: Copy {
        /// Centre.
        centre: [f64; 3] [Vector<3>, "m", Required("give the centre: centre = [0, 0, 0]")],
        /// Radius of the sphere of the same volume.
        radius: f64 [Positive, "m", Required("give the radius of its volume: radius = 0.5")],
        /// The volume over that of the sphere of the same surface: at most 1, more than .1.
        reduced_volume: f64 [Positive,
            Required("give the reduced volume: reduced_volume = 0.9")],
        /// Whether it is flat rather than long.
        oblate: bool [Flag, Default(false)],
        /// Its axis is z before it is turned: the axis of the rotation times the angle, by the
        /// right-hand rule.
        rotation: [f64; 3] [Numbers<3>, "degrees", Default([0.0, 0.0, 0.0])],
    } check Spheroid::check;
}

/// The curve of an oval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OvalCurve {
    /// An ellipse.
    Ellipse,
    /// Cassini's oval, which has a waist below a reduced area of .93.
    Cassini,
}

words! { Curves: OvalCurve { "ellipse" = OvalCurve::Ellipse, "cassini" = OvalCurve::Cassini } }

/// Rejects a reduced area or volume beyond its limits.
fn check_reduced(table: &Table<'_>, key: &str, value: f64, least: f64) -> Result<()> {
    if value <= 1.0 && value > least {
        return Ok(());
    }
    let Some(item) = table.get(key) else { return Ok(()) };
    Err(item
        .error(format!("must be at most 1, which a circle or a sphere has, and more than {least}"))
        .value(value.to_string())
        .remedy(format!("give a number between them: {key} = 0.9")))
}

impl Oval {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        let least = if self.curve == OvalCurve::Cassini { 0.8 } else { 0.05 };
        check_reduced(table, "reduced_area", self.reduced_area, least)
    }
}

impl Spheroid {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        check_reduced(table, "reduced_volume", self.reduced_volume, 0.1)
    }
}

table! {
    /// A sphere.
    Sphere: Copy {
        /// Centre.
        centre: [f64; 3] [Vector<3>, "m", Required("give the centre: centre = [0, 0, 0]")],
        /// Radius.
        radius: f64 [Positive, "m", Required("give the radius: radius = 0.5")],
    }
}

table! {
    /// An ellipsoid.
    Ellipsoid: Copy {
        /// Centre.
        centre: [f64; 3] [Vector<3>, "m", Required("give the centre: centre = [0, 0, 0]")],
        /// Along x, y and z before it is turned.
        semi_axes: [f64; 3] [Lengths<3>, "m",
            Required("give all three: semi_axes = [0.6, 0.5, 0.4]")],
        /// In space, the axis of its rotation times the angle, by the right-hand rule.
        rotation: [f64; 3] [Numbers<3>, "degrees", Default([0.0, 0.0, 0.0])],
    }
}

table! {
    /// A torus.
    Torus: Copy {
        /// Centre.
        centre: [f64; 3] [Vector<3>, "m", Required("give the centre: centre = [0, 0, 0]")],
        /// The axis, of any length but 0.
        axis: [f64; 3] [Axis, Default([0.0, 0.0, 1.0])],
        /// Radius of the circle in the middle of the tube.
        major: f64 [Positive, "m", Required("give the radius of the circle: major = 0.5")],
        /// Radius of the tube, at most the major one.
        minor: f64 [Positive, "m", Required("give the radius of the tube: minor = 0.2")],
    } check Torus::check;
}

table! {
    /// A rectangle with rounded corners; in space a box with rounded edges.
    RoundedBox {
        /// Centre.
        centre: Vec<f64> [Coordinates, "m",
            Required("give the centre: centre = [1, 1]", "give the centre: centre = [0, 0, 0]")],
        /// Half of the width, of the height and, in space, of the depth.
        half_size: Vec<f64> [HalfSizes, "m",
            Required("give both: half_size = [0.5, 0.25]",
                "give all three: half_size = [0.5, 0.25, 0.25]")],
        /// Radius of the corners (in space: edges), at most the smallest half size.
        radius: f64 [NonNegative, "m", Required("give the radius of the corners: radius = 0.1")],
        /// Counter-clockwise rotation, in the plane.
        angle: f64 [Number, "degrees", Default(0.0)],
        /// In space, the axis of its rotation times the angle, by the right-hand rule.
        rotation: [f64; 3] [Numbers<3>, "degrees", Default([0.0, 0.0, 0.0])],
    } before RoundedBox::before; check RoundedBox::check; hide RoundedBox::hides;
}

kinds! {
    /// Lengths along the axes of the shape.
    Lengths<const N>: [f64; N] = Kind::Lengths(N), |i, _| lengths(i, N).and_then(|_| i.vector());
    /// A point, in a list that may be of the other number of dimensions.
    Coordinates: Vec<f64> = Kind::Value("point", Form::POINT), |i, c| i.numbers(c.dimension);
    /// Lengths along the axes of a shape of the plane or of space.
    HalfSizes: Vec<f64> =
        Kind::Value(
        "two, in space three, numbers > 0",
        Form::List(&Form::POSITIVE, [2, 3]),
    ), |i, c| lengths(i, c.dimension);
    /// A direction in space.
    Axis: [f64; 3] = Kind::Value("vector of numbers", Form::List(&Form::NUMBER, [3, 3])), axis;
    /// A function that is negative inside.
    LevelFunction: Expression = Kind::Value("expression", Form::Expression), level_function;
}

/// Parts of a union.
pub(in crate::scene) struct Shapes;

impl Typed for Shapes {
    type Out = Vec<Shape>;
    const KIND: Kind =
        Kind::Value("list of shapes", Form::List(&Form::Like("membrane.shape"), [1, usize::MAX]));
    fn read(item: &Item<'_>, context: &Context) -> Result<Vec<Shape>> {
        let (parts, depth) =
            (item.list()?, item.key.split('.').filter(|key| *key == "union").count());
        if parts.is_empty() || depth > DEPTH {
            return Err(item
                .error(
                    "a union needs at least one shape, and not too many unions inside one another",
                )
                .remedy("write union = [{ circle = { ... } }, { ellipse = { ... } }]"));
        }
        parts.iter().map(|part| Shape::read(part, context)).collect()
    }
    fn toml(out: &Vec<Shape>) -> String {
        list(out.iter().map(Shape::inline))
    }
}

/// Maximum nesting depth of unions.
const DEPTH: usize = 8;
/// Shapes in the plane only.
const OF_THE_PLANE: [&str; 3] = ["circle", "ellipse", "polygon"];
const OF_SPACE: [&str; 3] = ["sphere", "ellipsoid", "torus"];

impl Torus {
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        match table.get("minor").filter(|_| self.minor > self.major) {
            None => Ok(()),
            Some(item) => Err(item
                .error(format!("the tube is wider than the circle in its middle, {}", self.major))
                .remedy(format!("give minor <= {}", self.major))),
        }
    }
}

impl RoundedBox {
    /// Rejects a rotation that does not fit the dimension.
    fn before(table: &Table<'_>, context: &Context) -> Result<()> {
        let (other, what, remedy) = match context.dimension {
            2 => (
                "rotation",
                "in the plane a shape is turned by one angle",
                "give angle = 30, in degrees",
            ),
            _ => (
                "angle",
                "in space one angle does not say how a shape is turned",
                "give the axis times the angle in degrees: rotation = [0, 0, 30]",
            ),
        };
        table.get(other).map_or(Ok(()), |item| Err(item.key_error(what).remedy(remedy)))
    }

    /// Rejects corners that are too large.
    fn check(&mut self, table: &Table<'_>, _: &Context) -> Result<()> {
        let half_size = &self.half_size;
        match table.get("radius").filter(|_| half_size.iter().any(|h| self.radius > *h)) {
            None => Ok(()),
            Some(item) => Err(item
                .error(format!("the corner radius is larger than a half size of {half_size:?}"))
                .remedy("give a radius from 0 to the smaller half size")),
        }
    }

    fn hides(&self, key: &str) -> bool {
        key == if self.centre.len() == 2 { "rotation" } else { "angle" }
    }
}

fn axis(item: &Item, _: &Context) -> Result<[f64; 3]> {
    match item.vector::<3>()? {
        axis if axis.iter().any(|c| *c != 0.0) => Ok(axis),
        _ => Err(item
            .error("the axis of a torus is zero")
            .remedy("give a direction such as [0, 0, 1]")),
    }
}

/// Rejects a shape of the plane in space, and one of space in the plane.
fn check_dimension(kind: &str, item: &Item, context: &Context) -> Result<()> {
    let (others, place, remedy) = match context.dimension {
        2 => (
            &OF_SPACE[..],
            "of space, but the mesh is plane",
            "take circle, ellipse, rounded_box, polygon, union or expression",
        ),
        _ => (
            &OF_THE_PLANE[..],
            "of the plane, but the scene has 3 dimensions",
            "take sphere, ellipsoid, torus, rounded_box, union or expression",
        ),
    };
    match others.contains(&kind) {
        true => Err(item.key_error(format!("`{kind}` is a shape {place}")).remedy(remedy)),
        false => Ok(()),
    }
}

fn lengths(item: &Item, n: usize) -> Result<Vec<f64>> {
    let v = item.numbers(n)?;
    if v.iter().all(|l| *l > 0.0) {
        return Ok(v);
    }
    let all = if n == 2 { "both" } else { "all" };
    Err(item
        .error(format!("{all} numbers of `{}` must be positive", item.key))
        .remedy("give lengths > 0"))
}

fn level_function(item: &Item, context: &Context) -> Result<Expression> {
    let e = item.expression(&context.constants)?;
    let what = if e.depends_on_time() {
        "the level function of a shape depends on time"
    } else if e.is_constant().is_some() {
        "the level function of a shape is constant"
    } else {
        return Ok(e);
    };
    Err(item
        .error(what)
        .remedy("write one that is negative inside, such as \"hypot(x - 1, y - 1) - 0.5\""))
}
