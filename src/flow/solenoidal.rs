//! The velocity without divergence that is nearest to a given one.

use super::coefficient::Coefficient;
use super::solver::FlowSolver;
use super::step::{FlowState, History, Step};
use crate::base::Result;
use crate::fem::{Conditions, Element, Rule, Space};
use crate::linalg::SolverOptions;
use nalgebra::SVector;
use std::sync::Arc;

/// Projects a velocity: minimises `|v - u|^2 + h^2 |div v|^2` over the discretely divergence-free
/// `v` with the boundary values of time 0, `h` being the mean size of a cell. The second term keeps
/// the divergence small within the cells, too, and leaves a velocity that has none as it is. A larger
/// weight would change a P2 velocity by more than the error of its interpolation; with this one, a
/// part of first order in `h` stays of a gradient, which a linear pressure follows no further.
///
/// `pressure` is the element that tests the divergence. Costs one factorisation of the flow matrix.
///
/// # Errors
/// Those of [`FlowSolver::new`] and [`FlowSolver::step`].
pub fn solenoidal<const D: usize>(
    space: &Arc<Space<D>>,
    pressure: Element,
    conditions: &Conditions<D>,
    options: SolverOptions,
    u: &[SVector<f64, D>],
) -> Result<Vec<SVector<f64, D>>> {
    let mesh = space.mesh();
    let size = (mesh.volume() / mesh.cell_count() as f64).powf(1.0 / D as f64);
    // Exact for products of two P2 functions.
    let rule = Arc::new(Rule::simplex(D, 4));
    let pressure = Arc::new(Space::new(mesh, pressure));
    let mut flow = FlowSolver::new(space, &pressure, &rule, conditions, size * size)?;
    flow.solve_by(options);
    flow.set_materials(Coefficient::Constant(1.0), Coefficient::Constant(0.0));
    let history = [History { weight: 1.0, u, feet: None }];
    let mut state = FlowState { u: u.to_vec(), ..flow.at_rest() };
    flow.step(&Step::backward_euler(0.0, 1.0, &history), &mut state)?;
    Ok(state.u)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Basis, Cells, Condition, integrate};
    use crate::mesh::{Diagonals, Point, rectangle};

    /// What the projection leaves of a gradient that is zero on the walls, beside the flow of
    /// Poiseuille, over what was given: of velocity (largest), and of divergence (L2).
    fn left(cells: usize) -> [f64; 2] {
        let mesh = rectangle([0.0; 2], [1.0; 2], [cells; 2], Diagonals::UnionJack).unwrap();
        let space = Arc::new(Space::new(&Arc::new(mesh), Element::P2));
        let channel = |x: &Point<2>| Point::<2>::new(x[1] * (1.0 - x[1]), 0.0);
        let walls =
            vec![("walls".to_string(), Condition::Velocity(Arc::new(move |x, _| channel(x))))];
        let project = |u: &[SVector<f64, 2>]| {
            solenoidal(&space, Element::P1, &walls, SolverOptions::default(), u).unwrap()
        };
        let poiseuille = space.interpolate(channel);
        let largest = |u: &[SVector<f64, 2>]| {
            u.iter().zip(&poiseuille).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
        };
        assert!(largest(&project(&poiseuille)) < 1e-12);
        let bump = |t: f64| t * t * (1.0 - t) * (1.0 - t);
        let slope = |t: f64| 2.0 * t * (1.0 - t) * (1.0 - 2.0 * t);
        let both = space.interpolate(|x| {
            let gradient = Point::<2>::new(slope(x[0]) * bump(x[1]), bump(x[0]) * slope(x[1]));
            channel(x) + 20.0 * gradient
        });
        let basis = Basis::new(&space, &Arc::new(Rule::simplex(2, 4)));
        let divergence = |u: &[SVector<f64, 2>]| {
            integrate(&basis, Cells::All, |at| [basis.jacobian(at, u).trace().powi(2)])[0].sqrt()
        };
        let projected = project(&both);
        [largest(&projected) / largest(&both), divergence(&projected) / divergence(&both)]
    }

    #[test]
    fn gradients_are_removed_and_the_rest_stays() {
        let [coarse, fine] = [left(8), left(16)];
        assert!(coarse[0] < 0.05 && coarse[1] < 0.1, "{coarse:?} {fine:?}");
        assert!(fine[0] < coarse[0] / 2.0 && fine[1] < coarse[1], "{coarse:?} {fine:?}");
    }
}
