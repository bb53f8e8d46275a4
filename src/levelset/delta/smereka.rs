//! Smereka's delta functions, on the lattice of the P2 nodes.

use super::lattice::{Part, between, edge, parts};
use super::{at_nodes, cut_cells};
use crate::base::Result;
use crate::fem::{At, Derivatives, OnCell, Recovered, Recovery, Space};
use crate::levelset::quadratic::Quadratic;
use crate::levelset::{normal_gradient, vertices_near};
use nalgebra::{SMatrix, SVector};

/// The points of the first delta function or, with `second`, the second: nodes on both sides of the
/// interface.
///
/// Let `u` be continuous with `[d_n u] = 1` across the interface and harmonic elsewhere, so that
/// `Lap u` is the delta function. The jump of its gradient is `n`. Tangential derivatives of this
/// give the jump of its Hessian except for the normal part, which follows from `[Lap u] = 0`:
/// `[D^2 u] = grad_S n - H n n^T`; in the plane `H (t t^T - n n^T)`. The linear finite-element
/// Laplacian of the lattice at node `i` is `sum_j w_ij (u_j - u_i)`. If the edge to `j` crosses the
/// interface at distance `d` from `j`, the smooth extension from the side of `i` differs from `u_j`
/// by the Taylor expansion of the jump; its contribution to the Laplacian is
///
/// `w_ij (d |n.e| + s d^2/2 e.[D^2 u] e)`,
///
/// with `e` along the edge and `s = 1` for `i` inside, -1 outside. The weight of node `i` is the
/// sum of these; the first delta function has the first term only. On a square lattice this is the
/// original. Straight interfaces are measured exactly on any mesh, up to the walls.
///
/// The crossing is that of the P2 function on the edge; `n` and `grad_S n` are recovered
/// ([`Recovered`]).
pub(super) fn points<const D: usize>(
    space: &Space<D>,
    phi: &[f64],
    second: bool,
) -> Result<Vec<At<D>>> {
    let cells = cut_cells(space, phi)?;
    let vertices = vertices_near(space, phi, 0.0);
    let recovered = Recovered::new(&Recovery::new(space.mesh()), space, phi, &vertices);
    let mut weights = vec![0.0; space.len()];
    for &c in &cells {
        let (nodes, own) = (space.cell_nodes(c), space.on_cell(phi, c));
        let at = |l: &[f64; 4]| recovered.in_cell(space.mesh(), c, l);
        for part in parts(space, c) {
            for (i, j) in (0..=D).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let (a, b) = (part.nodes[i], part.nodes[j]);
                if let Some([first, last]) = shares(space, &part, (c, i, j), &own, &at, second) {
                    weights[nodes[a] as usize] += first;
                    weights[nodes[b] as usize] += last;
                }
            }
        }
    }
    Ok(at_nodes(space, cells.into_iter(), &weights))
}

/// Contributions of the edge between the vertices `i` and `j` of a part of cell `c` to both; `None`
/// if it does not cross the interface.
fn shares<const D: usize>(
    space: &Space<D>,
    part: &Part<D>,
    (c, i, j): (usize, usize, usize),
    phi: &OnCell<f64, D>,
    derivatives: &dyn Fn(&[f64; 4]) -> Derivatives<D>,
    second: bool,
) -> Option<[f64; 2]> {
    let (a, b) = (part.nodes[i], part.nodes[j]);
    let [start, end] = [a, b].map(|k| phi.nodal()[k]);
    if (start < 0.0) == (end < 0.0) {
        return None;
    }
    let t = Quadratic::through(start, phi.value(&between(D, a, b, 0.5)), end).crossing();
    let (n, gradient) = normal_gradient(&derivatives(&between(D, a, b, t)))?;
    let along = edge(space, c, a, b);
    let (length, weight) = (along.norm(), part.weight(i, j));
    let e = along / length;
    let curved = if second { e.dot(&(jump(&n, &gradient) * e)) } else { 0.0 };
    let share = |inside: bool, d: f64| {
        let sign = if inside { 1.0 } else { -1.0 };
        weight * (d * n.dot(&e).abs() + sign * 0.5 * d * d * curved)
    };
    Some([share(start < 0.0, (1.0 - t) * length), share(end < 0.0, t * length)])
}

/// The jump of the Hessian, `grad_S n - H n n^T`.
fn jump<const D: usize>(n: &SVector<f64, D>, gradient: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    // The rows of the gradient are tangential already.
    gradient - (gradient * n) * n.transpose() - n * n.transpose() * gradient.trace()
}
