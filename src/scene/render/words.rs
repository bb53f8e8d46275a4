//! How interfaces are spoken of in the plane and in space.

use super::folder::RunFolder;
use std::f64::consts::PI;

/// Names of columns, and words.
pub(super) struct Words {
    /// The column of what is enclosed.
    pub enclosed: &'static str,
    /// The column of what the interface itself measures.
    pub own: &'static str,
    /// What that is.
    pub size: &'static str,
    /// The form that encloses most.
    pub round: &'static str,
    /// The form that has semi-axes.
    pub oval: &'static str,
    /// The line that a cut makes of it.
    pub cut: &'static str,
    /// Columns of the semi-axes, and what they are called.
    pub axes: &'static [(&'static str, &'static str)],
    /// Columns of the half extents, and what they are called.
    pub extents: &'static [(&'static str, &'static str)],
    /// The extents in words.
    pub widths: &'static str,
    /// Radius of the round form of what is enclosed.
    pub radius: fn(f64) -> f64,
    /// What the round form of a radius measures.
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

impl RunFolder {
    /// The words for the dimension of the scene.
    pub fn words(&self) -> &'static Words {
        if self.scene.dimension() == 2 { &PLANE } else { &SPACE }
    }
}
