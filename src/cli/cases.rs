//! The scenes that `immersa new` writes.

/// A commented scene to start from, one for each family of problems.
pub(super) struct Case {
    /// Name of the case and of its file.
    pub name: &'static str,
    /// What it computes.
    pub about: &'static str,
    /// The scene.
    pub scene: &'static str,
    /// Files beside the scene: name and content.
    pub files: &'static [(&'static str, &'static [u8])],
    /// Command to run before the scene; may be empty.
    pub before: &'static str,
}

macro_rules! case {
    ($name:literal, $about:literal $(, $file:literal = $from:literal)* $(; $before:literal)?) => {
        Case {
            name: $name,
            about: $about,
            scene: include_str!(concat!("cases/", $name, ".toml")),
            files: &[$(($file, include_bytes!($from)))*],
            before: concat!($($before)?),
        }
    };
}

/// All cases, those of a flow alone first.
pub(super) const CASES: &[Case] = &[
    case!("cavity", "A square of fluid driven by its lid"),
    case!("channel", "A flow through a channel, from left to right"),
    case!("obstacle", "A vortex street behind a cylinder, on a mesh of gmsh",
        "obstacle.geo" = "cases/obstacle.geo"; "gmsh -2 obstacle.geo"),
    case!("membrane", "An elastic membrane that relaxes in a viscous fluid"),
    case!("cell", "An elastic membrane carried through a periodic channel"),
    case!("capsule", "An elastic membrane in shear, which turns like the tread of a tank"),
    case!("vesicle", "A vesicle in shear, which treads or tumbles"),
    case!("ball", "An elastic membrane in space, fine about a sphere"),
    case!("drop", "A drop in shear, with surface tension"),
    case!("surfactant", "A drop in shear, with a surfactant that lowers its tension"),
    case!("bubble", "A bubble that rises in a heavier liquid"),
    case!("vortex", "A level set in a velocity that is given: no flow is solved"),
    case!(
        "contours",
        "The outlines of objects in an image, by active contours",
        "shapes.png" = "../../examples/active-contours/shapes.png"
    ),
];
