//! `[[membrane]] shape`: the form of an interface at time 0.

use super::keys::{Absent::*, Keys, Kind::*, row};
use super::polygon;
use super::write::{expression, list, number, vector};
use crate::base::Result;
use crate::scene::expression::Expression;
use crate::scene::item::{Context, Item};

/// A closed curve and its inside.
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
    /// All points that lie in one of the shapes.
    Union(Vec<Shape>),
    /// The points where a level function of x, y (and z) is negative.
    Expression(Expression),
}

pub(super) static KEYS: Keys = Keys {
    about: "A closed curve and its inside: exactly one of these.",
    keys: &[
        row("circle", Table(&CIRCLE), "", OneOf, "A circle."),
        row("ellipse", Table(&ELLIPSE), "", OneOf, "An ellipse."),
        row("rounded_box", Table(&ROUNDED_BOX), "", OneOf, "A rectangle with rounded corners."),
        row("polygon", Table(&polygon::KEYS), "", OneOf, "A polygon."),
        row("union", Value("list of shapes"), "", OneOf, "All points that lie in one of the shapes."),
        row(
            "expression",
            Value("expression"),
            "",
            OneOf,
            "The points where it is negative; of `x` and `y`, not constant, not of `t`.",
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

static ROUNDED_BOX: Keys = Keys {
    about: "A rectangle with rounded corners.",
    keys: &[
        row("centre", Value("point"), "m", Required, "Centre."),
        row("half_size", Value("two numbers > 0"), "m", Required, "Half of the width and of the height."),
        row("radius", Value("number >= 0"), "m", Required, "Radius of the corners, at most the smaller half size."),
        row("angle", Value("number"), "degrees", Default("0.0"), "Counter-clockwise rotation."),
    ],
};

/// Unions that may stand inside one another.
const DEPTH: usize = 8;

const CENTRE: &str = "give the centre: centre = [1, 1]";

impl Shape {
    pub(super) fn read(item: &Item, context: &Context) -> Result<Shape> {
        Shape::read_nested(item, context, 0)
    }

    fn read_nested(item: &Item, context: &Context, depth: usize) -> Result<Shape> {
        let (kind, item) = item.table(&KEYS)?.exactly_one(&KEYS)?;
        match kind {
            "circle" => circle(&item),
            "ellipse" => ellipse(&item),
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
    pub(super) fn write(&self) -> String {
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
    let centre = table.required("centre", CENTRE, Item::vector)?;
    let half_size = table.required("half_size", "give both: half_size = [0.5, 0.25]", lengths)?;
    let radius = table.required("radius", "give the radius of the corners: radius = 0.1", |i| {
        let radius = i.non_negative()?;
        if radius <= half_size[0].min(half_size[1]) {
            return Ok(radius);
        }
        Err(i
            .error(format!("the corner radius is larger than a half size of {half_size:?}"))
            .remedy("give a radius from 0 to the smaller half size"))
    })?;
    Ok(Shape::RoundedBox { centre, half_size, radius, angle: table.optional("angle", Item::number)?.unwrap_or(0.0) })
}

fn lengths(item: &Item) -> Result<[f64; 2]> {
    let v = item.vector::<2>()?;
    if v.iter().all(|l| *l > 0.0) {
        return Ok(v);
    }
    Err(item.error(format!("both numbers of `{}` must be positive", item.key)).remedy("give lengths > 0"))
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
