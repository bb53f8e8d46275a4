//! Bounds of a quadratic function and its slope on a cell.

use crate::fem::{EDGES, Space};
use nalgebra::SVector;

/// Bounds of a P2 function on a cell: if a band does not meet them, it has no point in the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// A lower bound of the values.
    pub low: f64,
    /// An upper bound of the values.
    pub high: f64,
    /// The largest slope, which is attained at a vertex.
    pub slope: f64,
}

impl Bounds {
    /// The bounds of `phi`, a function of the P2 `space`, on cell `c`: from the Bernstein-Bezier
    /// coefficients `b`, which enclose the values, and from the gradients at the vertices,
    /// `grad phi = 2 sum_j (b_ij - b_ii) grad lambda_j` at vertex `i`.
    pub fn of_cell<const D: usize>(space: &Space<D>, phi: &[f64], c: usize) -> Bounds {
        let (own, map) = (space.on_cell(phi, c), space.mesh().map(c));
        let v = own.nodal();
        let (mut low, mut high) = (v[0], v[0]);
        for i in 1..=D {
            (low, high) = (low.min(v[i]), high.max(v[i]));
        }
        let barycentric: [SVector<f64, D>; 4] =
            std::array::from_fn(|k| if k <= D { map.gradient(k) } else { SVector::zeros() });
        let mut gradients = [SVector::<f64, D>::zeros(); 4];
        for (e, &(i, j)) in EDGES[..D * (D + 1) / 2].iter().enumerate() {
            let b = 2.0 * v[D + 1 + e] - 0.5 * (v[i] + v[j]);
            (low, high) = (low.min(b), high.max(b));
            gradients[i] += barycentric[j] * (b - v[i]);
            gradients[j] += barycentric[i] * (b - v[j]);
        }
        let square = gradients.iter().map(|g| g.norm_squared()).fold(0.0, f64::max);
        Bounds { low, high, slope: 2.0 * square.sqrt() }
    }

    /// True if the band `|phi| < reach` may have a point in the cell.
    pub fn meet(&self, reach: f64) -> bool {
        self.low < reach && self.high > -reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, box_mesh, rectangle};
    use proptest::prelude::*;
    use std::sync::Arc;

    fn check<const D: usize>(
        space: &Space<D>,
        values: &[f64],
        l: [f64; 4],
    ) -> Result<(), TestCaseError> {
        let phi: Vec<f64> = (0..space.len()).map(|n| values[n % values.len()]).collect();
        let sum: f64 = l[..=D].iter().sum();
        let l: [f64; 4] = std::array::from_fn(|k| if k <= D { l[k] / sum } else { 0.0 });
        for c in 0..space.mesh().cell_count() {
            let b = Bounds::of_cell(space, &phi, c);
            let value = space.value(&phi, c, &l);
            prop_assert!(b.low <= value + 1e-14 && value <= b.high + 1e-14);
            let mut steepest: f64 = 0.0;
            for k in 0..=D {
                steepest =
                    steepest.max(space.gradient(&phi, c, &space.element().node(k, D)).norm());
            }
            prop_assert!((b.slope - steepest).abs() <= 1e-12 * steepest);
            prop_assert!(space.gradient(&phi, c, &l).norm() <= b.slope * (1.0 + 1e-12));
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn no_value_and_no_slope_is_beyond(values in prop::collection::vec(-2.0..2.0f64, 40), l in prop::array::uniform4(0.0..1.0f64)) {
            prop_assume!(l.iter().take(3).sum::<f64>() > 0.1);
            let plane = rectangle([0.0, 0.0], [2.0, 1.0], [2, 1], Diagonals::Right).unwrap();
            check(&Space::new(&Arc::new(plane), Element::P2), &values, l)?;
            let solid = box_mesh([0.0; 3], [1.0, 2.0, 1.0], [1, 1, 1]).unwrap();
            check(&Space::new(&Arc::new(solid), Element::P2), &values, l)?;
        }
    }
}
