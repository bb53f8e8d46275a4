//! Finite elements on simplices: P1 and P2 spaces, quadrature, pointwise weak forms and their
//! assembly.
//!
//! A weak form is a function of the quadrature point. A linear form returns the pair `(f0, f1)` of
//! `f0 . v + f1 : grad v`; a bilinear form is a linear map from `(u, grad u)` to such a pair.

mod assembly;
mod condition;
mod corner;
mod element;
mod mass;
mod means;
mod norms;
mod numbering;
mod periodic;
mod points;
mod projection;
mod quadrature;
mod recovery;
mod space;
mod supermesh;
mod surface;
mod transfer;

pub use assembly::{
    At, Basis, CellLoad, Cells, VectorForm, assemble_flow_matrix, assemble_local, assemble_scalar,
    assemble_scalar_matrix, assemble_source, assemble_vector, integrate,
};
pub use condition::{Condition, Conditions, ScalarFunction, VelocityFunction, condition_of_facets};
pub use element::{EDGES, Element, MAX_LOCAL};
pub use norms::{Errors, scalar_errors, vector_errors};
pub use numbering::Numbering;
pub use periodic::{Translation, image_shifts, periodic_pairs};
pub use points::{add_point_matrix, add_point_vector};
pub use projection::Projector;
pub use quadrature::{Rule, gauss_legendre};
pub use recovery::{Derivatives, Recovered, Recovery, hessians};
pub use space::{OnCell, Space, Value};
pub use surface::{SurfaceMass, SurfacePoint};
pub use transfer::{Interpolation, Projection};
