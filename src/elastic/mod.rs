//! Elastic structures: one constitutive law per file.

mod area_law;
mod band_cells;
mod continuum_force;
mod cut_surface;
mod membrane;
mod predictor;
mod sharp;
mod sharp_shear;
mod shear;
mod slip;
mod surface_law;
mod vesicle;
mod waves;

pub use crate::structure::{
    LagrangianInvariants, RestMap, SurfaceStrain, area_change_by_level_set,
};
pub use area_law::AreaLaw;
pub use band_cells::Band;
pub use continuum_force::ContinuumForce;
pub use membrane::Membrane;
pub use predictor::Predictor;
pub use sharp::{Force, SharpMembrane};
pub use sharp_shear::SharpShearMembrane;
pub use shear::{AreaFrom, ShearMembrane};
pub use surface_law::{Response, ShearLaw, SurfaceLaw, Tangent};
pub use vesicle::{Motion, Vesicle};
pub use waves::{explicit_step_limit, wave_period};
