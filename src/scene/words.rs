//! Vocabulary for interfaces in the plane and in space.

use std::f64::consts::PI;

/// Names of columns, and nouns.
pub struct Words {
    /// Column of the enclosed measure.
    pub enclosed: &'static str,
    /// Column of the measure of the interface itself.
    pub own: &'static str,
    /// Noun for this measure.
    pub size: &'static str,
    /// The form that encloses the largest measure.
    pub round: &'static str,
    /// The form with semi-axes.
    pub oval: &'static str,
    /// Noun for the zero set, which chords intersect.
    pub cut: &'static str,
    /// Columns of the semi-axes, and their names.
    pub axes: &'static [(&'static str, &'static str)],
    /// Columns of the half extents, and their names.
    pub extents: &'static [(&'static str, &'static str)],
    /// Noun for the extents.
    pub widths: &'static str,
    /// Radius of the round form from its enclosed measure.
    pub radius: fn(f64) -> f64,
    /// Measure of the round form from its radius.
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
    extents: &[
        ("extent_x", "half extent in x"),
        ("extent_y", "half extent in y"),
        ("extent_z", "half extent in z"),
    ],
    widths: "Half the extents in x, y and z",
    radius: |volume| (0.75 * volume / PI).cbrt(),
    round_size: |radius| 4.0 * PI * radius * radius,
};

/// The vocabulary of a dimension.
pub(super) fn words(dimension: usize) -> &'static Words {
    if dimension == 2 { &PLANE } else { &SPACE }
}
