//! Energy of a membrane that resists change of area (in the plane: of length), as a function of the
//! stretch `r = |grad phi|`.

use nalgebra::{SMatrix, SVector};

/// A constitutive law `r -> E(r)`: energy per unit of area at rest (book, section 3.2.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AreaLaw {
    /// `E = lambda (r - 1)^2 / 2`, so `E' = lambda (r - 1)` (3.13).
    Linear {
        /// `lambda`, force per length.
        modulus: f64,
    },
    /// `E' = lambda max(r - 1, 0)`: no resistance to compression.
    OneSided {
        /// `lambda`, force per length.
        modulus: f64,
    },
    /// `E = lambda r`, so `E' = lambda`: surface tension.
    Tension {
        /// `lambda`, force per length.
        tension: f64,
    },
    /// `E = lambda r - beta ln r`, so `E' = lambda - beta c` with `c = 1/r`: the tension of a surface
    /// that carries a surfactant of the concentration `c`, by the linear equation of state. The
    /// energy per area is `lambda + beta c ln c`, the free energy with that tension.
    Surfactant {
        /// `lambda`, the tension without surfactant, force per length.
        tension: f64,
        /// `beta`, the loss of tension at `c = 1`, force per length.
        elasticity: f64,
    },
}

impl AreaLaw {
    /// The tensor tested with `grad v` in the form implicit in the velocity, with `P = I - n n`:
    /// `a (P : grad u) P + b n n grad u P`, `[a, b]` being `weights`. For constant tension and in
    /// 3-D the last term is `b grad u P`.
    pub(super) fn implicit_form<const D: usize>(
        &self,
        n: &SVector<f64, D>,
        grad_u: &SMatrix<f64, D, D>,
        [a, b]: [f64; 2],
    ) -> SMatrix<f64, D, D> {
        let projection = SMatrix::<f64, D, D>::identity() - n * n.transpose();
        let tangential = grad_u * projection;
        let is_fluid = matches!(self, AreaLaw::Tension { .. } | AreaLaw::Surfactant { .. });
        let bent = if D == 2 && !is_fluid { n * (n.transpose() * tangential) } else { tangential };
        projection * (a * tangential.trace()) + bent * b
    }
    /// `E(r)`.
    pub fn energy(self, r: f64) -> f64 {
        match self {
            AreaLaw::Linear { modulus } => 0.5 * modulus * (r - 1.0).powi(2),
            AreaLaw::OneSided { modulus } => 0.5 * modulus * (r - 1.0).max(0.0).powi(2),
            AreaLaw::Tension { tension } => tension * r,
            AreaLaw::Surfactant { tension, elasticity } => tension * r - elasticity * r.ln(),
        }
    }
    /// `E'(r)`, the tension.
    pub fn tension(self, r: f64) -> f64 {
        match self {
            AreaLaw::Linear { modulus } => modulus * (r - 1.0),
            AreaLaw::OneSided { modulus } => modulus * (r - 1.0).max(0.0),
            AreaLaw::Tension { tension } => tension,
            AreaLaw::Surfactant { tension, elasticity } => tension - elasticity / r,
        }
    }
    /// `E''(r)`.
    pub fn stiffness(self, r: f64) -> f64 {
        match self {
            AreaLaw::Linear { modulus } => modulus,
            AreaLaw::OneSided { modulus } => {
                if r > 1.0 {
                    modulus
                } else {
                    0.0
                }
            }
            AreaLaw::Tension { .. } => 0.0,
            AreaLaw::Surfactant { elasticity, .. } => elasticity / (r * r),
        }
    }
    /// `lambda`: the modulus of the law, force per length.
    pub fn modulus(self) -> f64 {
        match self {
            AreaLaw::Linear { modulus } | AreaLaw::OneSided { modulus } => modulus,
            AreaLaw::Tension { tension } | AreaLaw::Surfactant { tension, .. } => tension,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tension_and_stiffness_are_the_derivatives_of_the_energy() {
        for law in [
            AreaLaw::Linear { modulus: 3.0 },
            AreaLaw::OneSided { modulus: 2.0 },
            AreaLaw::Tension { tension: 0.5 },
            AreaLaw::Surfactant { tension: 0.5, elasticity: 0.2 },
        ] {
            for r in [0.7, 0.95, 1.2, 1.9] {
                let h = 1e-5;
                let slope = (law.energy(r + h) - law.energy(r - h)) / (2.0 * h);
                let curve = (law.tension(r + h) - law.tension(r - h)) / (2.0 * h);
                assert!(
                    (slope - law.tension(r)).abs() < 1e-9
                        && (curve - law.stiffness(r)).abs() < 1e-9
                );
            }
        }
    }
}
