//! Density and viscosity.

use crate::fem::At;

/// A Newtonian fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluid {
    /// Mass per volume; zero for all fluids gives a Stokes flow.
    pub density: f64,
    /// Dynamic viscosity.
    pub viscosity: f64,
}

/// A material coefficient: constant, or one number per quadrature point.
#[derive(Clone, Debug, PartialEq)]
pub enum Coefficient {
    /// Constant in space and time.
    Constant(f64),
    /// The value at point `q` of cell `c` is entry `c * points + q`; changes from step to step.
    Pointwise {
        /// Quadrature points per cell.
        points: usize,
        /// The values.
        values: Vec<f64>,
    },
}

impl Coefficient {
    /// The value at a quadrature point.
    #[inline]
    pub fn at<const D: usize>(&self, at: &At<D>) -> f64 {
        self.value(at.cell, at.q)
    }
    /// The value at quadrature point `q` of cell `c`.
    #[inline]
    pub fn value(&self, c: usize, q: usize) -> f64 {
        match self {
            Coefficient::Constant(value) => *value,
            Coefficient::Pointwise { points, values } => values[c * points + q],
        }
    }
    /// True if the value is constant.
    pub fn is_constant(&self) -> bool {
        matches!(self, Coefficient::Constant(_))
    }
}
