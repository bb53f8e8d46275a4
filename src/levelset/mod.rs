//! Level sets: shapes and their signed distances, the regularised band, the contour or surface
//! `phi = 0` and its measures.
//!
//! `phi < 0` inside. The initial level set is the signed distance of a [`Shape`] times the initial
//! stretch, so that `|grad phi|` on the contour is the stretch of the membrane, (3.11).

mod band;
mod bounds;
mod carried_points;
mod carried_surface;
mod chord;
mod contour;
mod curvature;
mod delta;
mod distance;
mod ellipse;
mod ellipsoid;
mod function;
mod grid;
mod halved;
mod interface;
mod isosurface;
mod level_solid;
mod markers;
mod measures;
mod patch;
mod polygon;
mod quadratic;
mod redistance;
mod reduced;
mod ring;
mod segmentation;
mod shape;
mod sign;
mod skeleton;
mod solid;
mod solid_union;
mod space_curve;
mod surface_vectors;
mod tetrahedron;
mod torus;
mod union;

pub use band::{
    BandEdges, Kernel, Norm, band_edges, check_band, density, heaviside, surface_weight, viscosity,
    zeta,
};
pub use bounds::Bounds;
pub use carried_points::{CarriedPoints, End};
pub use carried_surface::{CarriedSurface, Onto, continue_vectors, cut_cells, origins};
pub use contour::{Contour, Line, Segment};
pub use curvature::{Curvature, normal_gradient, vertices_near};
pub use delta::{Delta, Smeared, Width};
pub use ellipse::Ellipse;
pub use ellipsoid::Ellipsoid;
pub use function::LevelFunction;
pub use halved::Sample;
pub use interface::{Interface, InterfaceMeasures, extents, surface};
pub use isosurface::Isosurface;
pub use level_solid::LevelSolid;
pub use measures::{ContourPoint, Measures};
pub use patch::Triangle;
pub use polygon::Polygon;
pub use redistance::{Redistance, Redistancing};
pub use reduced::{reduced_cassini, reduced_ellipse, reduced_spheroid};
pub use segmentation::{Segmentation, SegmentationFit, SegmentationWeights, parts_inside};
pub use shape::{Circle, RoundedBox, Shape, check_inside, signed_distance};
pub use sign::slopes;
pub use skeleton::Skeleton;
pub use solid::SolidMeasures;
pub use solid_union::SolidUnion;
pub use space_curve::{CurvePoint, Frenet, SpaceCurve};
pub use surface_vectors::{curvature_vector, normal_vector, second_form, surface_divergence};
pub use torus::Torus;
pub use union::Union;
