//! Errors of a run against the exact solution of its scene: columns of the series.

use super::points::coordinates;
use super::row::Row;
use super::view::View;
use crate::fem::{Basis, Cells, Rule, integrate, scalar_errors, vector_errors};
use crate::mesh::Point;
use nalgebra::{SMatrix, SVector};
use std::sync::Arc;

/// Degree of the quadrature rule for the mean of the pressure, the same as for the norms.
const DEGREE: usize = 8;

/// Measures the errors over the whole mesh at the current time: of the velocity in L2, of its
/// gradient in L2, and of the pressure in L2, up to a constant if no boundary is open.
pub(super) fn measure<const D: usize>(view: &View<'_, D>, row: &mut Row) {
    let (exact, state, t) = (&view.tables.exact, view.state, view.state.time);
    if let Some(velocity) = &exact.velocity {
        let errors = vector_errors(view.space(), &state.flow.u, |x| {
            let mut value = SVector::<f64, D>::zeros();
            let mut gradient = SMatrix::<f64, D, D>::zeros();
            for (i, e) in velocity.iter().take(D).enumerate() {
                let (v, g) = e.eval_with_gradient(coordinates(x), t);
                value[i] = v;
                (0..D).for_each(|k| gradient[(i, k)] = g[k]);
            }
            (value, gradient)
        });
        row.put("error_velocity_l2", errors.l2);
        row.put("error_velocity_h1", errors.h1);
    }
    let Some(pressure) = &exact.pressure else { return };
    let error = view.flow.map_or(f64::NAN, |flow| {
        let space = flow.pressure().space();
        let at = |x: &Point<D>| pressure.eval(coordinates(x), t);
        let mut shift = 0.0;
        if !flow.numbering().is_open() {
            let basis = Basis::new(space, &Arc::new(Rule::simplex(D, DEGREE)));
            let [sum, area] =
                integrate(&basis, Cells::All, |q| [basis.value(q, &state.flow.p) - at(&q.x), 1.0]);
            shift = sum / area;
        }
        scalar_errors(space, &state.flow.p, |x| (at(x) + shift, SVector::zeros())).l2
    });
    row.put("error_pressure_l2", error);
}
