//! `[[membrane]] shape`: the form of an interface at time 0.

use super::polygon;
use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::keys::{Absent::*, Keys, Kind::*, row};
use crate::scene::keys::{Context, Item, Table as ItemTable};
use crate::scene::keys::{expression, list, number, vector};

/// A closed curve (in space: a closed surface) and its inside.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A circle.
    Circle {
        /// Centre.
        centre: [f64; 2],
        /// Radius.
        radius: f64,
    },
    /// An ellipse.
    Ellipse {
        /// Centre.
        centre: [f64; 2],
        /// Semi-axes; the first lies along x when `angle` is 0.
        semi_axes: [f64; 2],
        /// Counter-clockwise rotation, in degrees.
        angle: f64,
    },
    /// A rectangle with rounded corners.
    RoundedBox {
        /// Centre.
        centre: [f64; 2],
        /// Half of the width and of the height.
        half_size: [f64; 2],
        /// Radius of the corners, at most the smaller half size.
        radius: f64,
        /// Counter-clockwise rotation, in degrees.
        angle: f64,
    },
    /// A simple polygon, in either sense of rotation.
    Polygon(Vec<[f64; 2]>),
    /// A sphere, in space.
    Sphere {
        /// Centre.
        centre: [f64; 3],
        /// Radius.
        radius: f64,
    },
    /// An ellipsoid, in space.
    Ellipsoid {
        /// Centre.
        centre: [f64; 3],
        /// Semi-axes along x, y and z before it is turned.
        semi_axes: [f64; 3],
        /// The axis of its rotation times the angle in degrees, by the right-hand rule.
        rotation: [f64; 3],
    },
    /// A box with rounded edges, in space.
    RoundedBlock {
        /// Centre.
        centre: [f64; 3],
        /// Half sizes along x, y and z before it is turned.
        half_size: [f64; 3],
        /// Radius of the edges, at most the smallest half size.
        radius: f64,
        /// The axis of its rotation times the angle in degrees, by the right-hand rule.
        rotation: [f64; 3],
    },
    /// A torus, in space.
    Torus {
        /// Centre.
        centre: [f64; 3],
        /// The axis, of any length but 0.
        axis: [f64; 3],
        /// Radius of the circle in the middle of the tube.
        major: f64,
        /// Radius of the tube, at most the major one.
        minor: f64,
    },
    /// All points that lie in one of the shapes.
    Union(Vec<Shape>),
    /// The points where a level function of x, y (and z) is negative.
    Expression(Expression),
}

pub(in crate::scene) static KEYS: Keys = Keys {
    about: "A closed curve (in space: a closed surface) and its inside: exactly one of these.",
    keys: &[
        row("circle", Table(&CIRCLE), "", OneOf, "A circle, in the plane."),
        row("ellipse", Table(&ELLIPSE), "", OneOf, "An ellipse, in the plane."),
        row("sphere", Table(&SPHERE), "", OneOf, "A sphere, in space."),
        row("ellipsoid", Table(&ELLIPSOID), "", OneOf, "An ellipsoid, in space."),
        row("torus", Table(&TORUS), "", OneOf, "A torus, in space."),
        row("rounded_box", Table(&ROUNDED_BOX), "", OneOf, "A rectangle with rounded corners; in space a box."),
        row("polygon", Table(&polygon::KEYS), "", OneOf, "A polygon, in the plane."),
        row("union", Value("list of shapes"), "", OneOf, "All points that lie in one of the shapes."),
        row(
            "expression",
            Value("expression"),
            "",
            OneOf,
            "The points where it is negative; of `x` and `y` (in space of `z` too), not constant, not of `t`.",
        ),
    ],
};

static CIRCLE: Keys = Keys {
    about: "A circle.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row("radius", Value("number > 0"), "m", Required, "Radius."),
    ],
};

static ELLIPSE: Keys = Keys {
    about: "An ellipse.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row("semi_axes", Value("two numbers > 0"), "m", Required, "The first lies along x when `angle` is 0."),
        row("angle", Value("number"), "degrees", Default("0.0"), "Counter-clockwise rotation."),
    ],
};

static SPHERE: Keys = Keys {
    about: "A sphere.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row("radius", Value("number > 0"), "m", Required, "Radius."),
    ],
};

static ELLIPSOID: Keys = Keys {
    about: "An ellipsoid.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row("semi_axes", Value("three numbers > 0"), "m", Required, "Along x, y and z before it is turned."),
        row("rotation", Value("three numbers"), "degrees", Default(ROTATION), ROTATED),
    ],
};

static TORUS: Keys = Keys {
    about: "A torus.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row("axis", Value("vector of numbers"), "", Default(AXIS), "The axis, of any length but 0."),
        row("major", Value("number > 0"), "m", Required, "Radius of the circle in the middle of the tube."),
        row("minor", Value("number > 0"), "m", Required, "Radius of the tube, at most the major one."),
    ],
};

static ROUNDED_BOX: Keys = Keys {
    about: "A rectangle with rounded corners; in space a box with rounded edges.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row(
            "half_size",
            Value("two, in space three, numbers > 0"),
            "m",
            Required,
            "Half of the width, of the height and, in space, of the depth.",
        ),
        row(
            "radius",
            Value("number >= 0"),
            "m",
            Required,
            "Radius of the corners (in space: edges), at most the smallest half size.",
        ),
        row("angle", Value("number"), "degrees", Default("0.0"), "Counter-clockwise rotation, in the plane."),
        row("rotation", Value("three numbers"), "degrees", Default(ROTATION), ROTATED),
    ],
};

const ROTATION: &str = "[0.0, 0.0, 0.0]";
const ROTATED: &str = "In space, the axis of its rotation times the angle, by the right-hand rule.";
const AXIS: &str = "[0.0, 0.0, 1.0]";
const DEFAULT_AXIS: [f64; 3] = [0.0, 0.0, 1.0];

/// Unions that may stand inside one another.
const DEPTH: usize = 8;

const CENTRE: &str = "give the centre: centre = [1, 1]";
const CENTRE_IN_SPACE: &str = "give the centre: centre = [0, 0, 0]";
/// Shapes of one number of dimensions alone.
const OF_THE_PLANE: [&str; 3] = ["circle", "ellipse", "polygon"];
const OF_SPACE: [&str; 3] = ["sphere", "ellipsoid", "torus"];

impl Shape {
    pub(in crate::scene) fn read(item: &Item, context: &Context) -> Result<Shape> {
        Shape::read_nested(item, context, 0)
    }

    fn read_nested(item: &Item, context: &Context, depth: usize) -> Result<Shape> {
        let (kind, item) = item.table(&KEYS)?.exactly_one(&KEYS)?;
        check_dimension(kind, &item, context)?;
        match kind {
            "circle" => circle(&item),
            "ellipse" => ellipse(&item),
            "sphere" => sphere(&item),
            "ellipsoid" => ellipsoid(&item),
            "torus" => torus(&item),
            "rounded_box" if context.dimension == 3 => rounded_block(&item),
            "rounded_box" => rounded_box(&item),
            "polygon" => polygon::read(&item).map(Shape::Polygon),
            "union" => {
                let parts = item.list()?;
                if parts.is_empty() || depth == DEPTH {
                    return Err(item
                        .error("a union needs at least one shape, and not too many unions inside one another")
                        .remedy("write union = [{ circle = { ... } }, { ellipse = { ... } }]"));
                }
                let parts = parts.iter().map(|p| Shape::read_nested(p, context, depth + 1));
                parts.collect::<Result<_>>().map(Shape::Union)
            }
            _ => level_function(&item, context),
        }
    }

    /// The shape as an inline table of TOML.
    pub(in crate::scene) fn write(&self) -> String {
        let body = match self {
            Shape::Circle { centre, radius } => {
                format!("circle = {{ centre = {}, radius = {} }}", vector(centre), number(*radius))
            }
            Shape::Ellipse { centre, semi_axes, angle } => {
                let (centre, axes, angle) = (vector(centre), vector(semi_axes), number(*angle));
                format!("ellipse = {{ centre = {centre}, semi_axes = {axes}, angle = {angle} }}")
            }
            Shape::RoundedBox { centre, half_size, radius, angle } => {
                let (centre, half, radius, angle) =
                    (vector(centre), vector(half_size), number(*radius), number(*angle));
                format!("rounded_box = {{ centre = {centre}, half_size = {half}, radius = {radius}, angle = {angle} }}")
            }
            Shape::Sphere { centre, radius } => {
                format!("sphere = {{ centre = {}, radius = {} }}", vector(centre), number(*radius))
            }
            Shape::Ellipsoid { centre, semi_axes, rotation } => {
                let [centre, axes, rotation] = [centre, semi_axes, rotation].map(|v| vector(v));
                format!("ellipsoid = {{ centre = {centre}, semi_axes = {axes}, rotation = {rotation} }}")
            }
            Shape::Torus { centre, axis, major, minor } => {
                let (centre, axis, major, minor) = (vector(centre), vector(axis), number(*major), number(*minor));
                format!("torus = {{ centre = {centre}, axis = {axis}, major = {major}, minor = {minor} }}")
            }
            Shape::RoundedBlock { centre, half_size, radius, rotation } => {
                let [centre, half, rotation] = [centre, half_size, rotation].map(|v| vector(v));
                let radius = number(*radius);
                format!(
                    "rounded_box = {{ centre = {centre}, half_size = {half}, radius = {radius}, rotation = {rotation} }}"
                )
            }
            Shape::Polygon(points) => {
                format!("polygon = {{ points = {} }}", list(points.iter().map(|p| vector(p))))
            }
            Shape::Union(parts) => format!("union = {}", list(parts.iter().map(Shape::write))),
            Shape::Expression(e) => format!("expression = {}", expression(e)),
        };
        format!("{{ {body} }}")
    }
}

fn circle(item: &Item) -> Result<Shape> {
    let table = item.table(&CIRCLE)?;
    Ok(Shape::Circle {
        centre: table.required("centre", CENTRE, Item::vector)?,
        radius: table.required("radius", "give the radius: radius = 0.5", Item::positive)?,
    })
}

fn ellipse(item: &Item) -> Result<Shape> {
    let table = item.table(&ELLIPSE)?;
    Ok(Shape::Ellipse {
        centre: table.required("centre", CENTRE, Item::vector)?,
        semi_axes: table.required("semi_axes", "give both: semi_axes = [0.75, 0.5]", lengths)?,
        angle: table.optional("angle", Item::number)?.unwrap_or(0.0),
    })
}

fn rounded_box(item: &Item) -> Result<Shape> {
    let table = item.table(&ROUNDED_BOX)?;
    if let Some(item) = table.get("rotation") {
        return Err(item
            .key_error("in the plane a shape is turned by one angle")
            .remedy("give angle = 30, in degrees"));
    }
    let centre = table.required("centre", CENTRE, Item::vector)?;
    let half_size = table.required("half_size", "give both: half_size = [0.5, 0.25]", lengths)?;
    let radius = table.required("radius", RADIUS, |i| corner_radius(i, &half_size))?;
    Ok(Shape::RoundedBox { centre, half_size, radius, angle: table.optional("angle", Item::number)?.unwrap_or(0.0) })
}

const RADIUS: &str = "give the radius of the corners: radius = 0.1";

fn corner_radius(item: &Item, half_size: &[f64]) -> Result<f64> {
    let radius = item.non_negative()?;
    if half_size.iter().all(|h| radius <= *h) {
        return Ok(radius);
    }
    Err(item
        .error(format!("the corner radius is larger than a half size of {half_size:?}"))
        .remedy("give a radius from 0 to the smaller half size"))
}

fn sphere(item: &Item) -> Result<Shape> {
    let table = item.table(&SPHERE)?;
    Ok(Shape::Sphere {
        centre: table.required("centre", CENTRE_IN_SPACE, Item::vector)?,
        radius: table.required("radius", "give the radius: radius = 0.5", Item::positive)?,
    })
}

fn ellipsoid(item: &Item) -> Result<Shape> {
    let table = item.table(&ELLIPSOID)?;
    Ok(Shape::Ellipsoid {
        centre: table.required("centre", CENTRE_IN_SPACE, Item::vector)?,
        semi_axes: table.required("semi_axes", "give all three: semi_axes = [0.6, 0.5, 0.4]", lengths)?,
        rotation: rotation(&table)?,
    })
}

fn torus(item: &Item) -> Result<Shape> {
    let table = item.table(&TORUS)?;
    let axis = |i: &Item| match i.vector::<3>()? {
        axis if axis.iter().any(|c| *c != 0.0) => Ok(axis),
        _ => Err(i.error("the axis of a torus is zero").remedy("give a direction such as [0, 0, 1]")),
    };
    let major = table.required("major", "give the radius of the circle: major = 0.5", Item::positive)?;
    let minor = |i: &Item| match i.positive()? {
        minor if minor <= major => Ok(minor),
        _ => Err(i
            .error(format!("the tube is wider than the circle in its middle, {major}"))
            .remedy(format!("give minor <= {major}"))),
    };
    Ok(Shape::Torus {
        centre: table.required("centre", CENTRE_IN_SPACE, Item::vector)?,
        axis: table.optional("axis", axis)?.unwrap_or(DEFAULT_AXIS),
        major,
        minor: table.required("minor", "give the radius of the tube: minor = 0.2", minor)?,
    })
}

fn rounded_block(item: &Item) -> Result<Shape> {
    let table = item.table(&ROUNDED_BOX)?;
    if let Some(item) = table.get("angle") {
        return Err(item
            .key_error("in space one angle does not say how a shape is turned")
            .remedy("give the axis times the angle in degrees: rotation = [0, 0, 30]"));
    }
    let centre = table.required("centre", CENTRE_IN_SPACE, Item::vector)?;
    let half_size = table.required("half_size", "give all three: half_size = [0.5, 0.25, 0.25]", lengths)?;
    let radius = table.required("radius", RADIUS, |i| corner_radius(i, &half_size))?;
    Ok(Shape::RoundedBlock { centre, half_size, radius, rotation: rotation(&table)? })
}

fn rotation(table: &ItemTable<'_>) -> Result<[f64; 3]> {
    Ok(table.optional("rotation", Item::vector)?.unwrap_or([0.0; 3]))
}

/// Refuses a shape of the plane in space, and one of space in the plane.
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

fn lengths<const N: usize>(item: &Item) -> Result<[f64; N]> {
    let v = item.vector::<N>()?;
    if v.iter().all(|l| *l > 0.0) {
        return Ok(v);
    }
    let all = if N == 2 { "both" } else { "all" };
    Err(item.error(format!("{all} numbers of `{}` must be positive", item.key)).remedy("give lengths > 0"))
}

fn level_function(item: &Item, context: &Context) -> Result<Shape> {
    let e = item.expression(&context.constants)?;
    let what = if e.depends_on_time() {
        "the level function of a shape depends on time"
    } else if e.is_constant().is_some() {
        "the level function of a shape is constant"
    } else {
        return Ok(Shape::Expression(e));
    };
    Err(item.error(what).remedy("write one that is negative inside, such as \"hypot(x - 1, y - 1) - 0.5\""))
}
