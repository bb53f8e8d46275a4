//! What the waves of a structure move in.

/// Fluid and mesh about a structure and the order of the steps: what the largest stable step of
/// its explicit coupling depends on besides its force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Density; 0 without inertia.
    pub density: f64,
    /// Viscosity.
    pub viscosity: f64,
    /// Length of the edges of the mesh.
    pub edge: f64,
    /// Order of the steps in time.
    pub order: usize,
}
