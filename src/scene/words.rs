//! Words for interfaces in the plane and in space.

use std::f64::consts::PI;

/// Names of columns, and words.
pub struct Words {
    /// Column of what is enclosed.
    pub enclosed: &'static str,
    /// Column of the size of the interface itself.
    pub own: &'static str,
    /// Name of that.
    pub size: &'static str,
    /// The form that encloses most.
    pub round: &'static str,
    /// The form that has semi-axes.
    pub oval: &'static str,
    /// The line that a cut makes of it.
    pub cut: &'static str,
    /// Columns of the semi-axes, and their names.
    pub axes: &'static [(&'static str, &'static str)],
    /// Columns of the half extents, and their names.
    pub extents: &'static [(&'static str, &'static str)],
    /// The extents in words.
    pub widths: &'static str,
    /// Radius of the round form of what is enclosed.
    pub radius: fn(f64) -> f64,
    /// Size of the round form of a radius.
    pub round_size: fn(f64) -> f64,
}

const PLANE: Words = Words {
    enclosed: "area",
    own: "perimeter",
    size: "length",
    round: "circle",
    oval: "ellipse",
    cut: "contour",
    axes: &[("axis_1", "larger"), ("axis_2", "smaller")],
    extents: &[("extent_x", "half width"), ("extent_y", "half height")],
    widths: "Half the width and half the height",
    radius: |area| (area / PI).sqrt(),
    round_size: |radius| 2.0 * PI * radius,
};

const SPACE: Words = Words {
    enclosed: "volume",
    own: "surface",
    size: "area",
    round: "sphere",
    oval: "ellipsoid",
    cut: "surface",
    axes: &[("axis_1", "largest"), ("axis_2", "middle"), ("axis_3", "smallest")],
    extents: &[("extent_x", "half extent in x"), ("extent_y", "half extent in y"), ("extent_z", "half extent in z")],
    widths: "Half the extents in x, y and z",
    radius: |volume| (0.75 * volume / PI).cbrt(),
    round_size: |radius| 4.0 * PI * radius * radius,
};

/// The words of a dimension.
pub(super) fn words(dimension: usize) -> &'static Words {
    if dimension == 2 { &PLANE } else { &SPACE }
}
