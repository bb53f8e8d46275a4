//! Towers' delta and Heaviside functions, on the lattice of the P2 nodes.

use super::lattice::parts;
use super::{at_nodes, cut_cells};
use crate::base::Result;
use crate::fem::{At, Space};
use nalgebra::SVector;

/// Data of `phi` and `I = max(phi, 0)` at a node near the interface.
#[derive(Clone, Copy)]
struct Node<const D: usize> {
    /// Lumped mass: sum over the lattice cells at the node of their fractions of the volume.
    mass: f64,
    /// Gradients of `phi` and `I` times the mass.
    gradients: [SVector<f64, D>; 2],
    /// Laplacians of `phi` and `I` times the mass.
    laplacians: [f64; 2],
}

impl<const D: usize> Node<D> {
    /// The Heaviside function `grad I . grad phi/|grad phi|^2`; the sign of `phi` where its
    /// gradient vanishes.
    fn heaviside(&self, phi: f64) -> f64 {
        let [g, i] = self.gradients;
        let square = g.norm_squared();
        if square > 0.0 { i.dot(&g) / square } else { f64::from(phi >= 0.0) }
    }
    /// The delta function of the interface times the mass.
    fn delta(&self) -> f64 {
        let slope = self.gradients[0].norm() / self.mass;
        let [phi, i] = self.laplacians;
        // Without slope there is no interface.
        if slope > 0.0 { (i - self.heaviside(0.0) * phi) / slope } else { 0.0 }
    }
}

/// The points: nodes of the lattice cells that the interface crosses; elsewhere `I` is `phi` or 0.
///
/// `Lap I = |grad phi|^2 delta(phi) + H Lap phi` holds for `delta` of the *values* of `phi`, as in
/// the book's formula. The delta function of the interface (1.23) is `|grad phi| delta(phi)`, so
/// the denominator here has one factor `|grad phi|` less.
///
/// The Laplacian is that of linear finite elements with a lumped mass, the gradient the mean over
/// the lattice cells at a node. At nodes of the boundary the Laplacian lacks the boundary flux, so
/// an interface should not end there.
pub(super) fn points<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<Vec<At<D>>> {
    let (cells, nodes) = nodes(space, phi)?;
    let weights: Vec<f64> = nodes.iter().map(|n| n.as_ref().map_or(0.0, Node::delta)).collect();
    Ok(at_nodes(space, cells.into_iter(), &weights))
}

/// The sum of `1 - H` times the mass.
pub(super) fn inside<const D: usize>(space: &Space<D>, phi: &[f64]) -> Result<f64> {
    let (_, nodes) = nodes(space, phi)?;
    let mut sum = 0.0;
    for c in 0..space.mesh().cell_count() {
        let own = space.cell_nodes(c);
        for part in parts(space, c) {
            let share = part.volume / (D as f64 + 1.0);
            for a in &part.nodes[..=D] {
                let n = own[*a] as usize;
                sum += share
                    * (1.0
                        - nodes[n]
                            .as_ref()
                            .map_or(f64::from(phi[n] >= 0.0), |node| node.heaviside(phi[n])));
            }
        }
    }
    Ok(sum)
}

/// The cells that the interface crosses, and the data at their nodes.
fn nodes<const D: usize>(
    space: &Space<D>,
    phi: &[f64],
) -> Result<(Vec<usize>, Vec<Option<Node<D>>>)> {
    let cells = cut_cells(space, phi)?;
    let empty = Node { mass: 0.0, gradients: [SVector::zeros(); 2], laplacians: [0.0; 2] };
    let mut nodes = vec![None; space.len()];
    cells.iter().flat_map(|&c| space.cell_nodes(c)).for_each(|&n| nodes[n as usize] = Some(empty));
    for c in 0..space.mesh().cell_count() {
        let own = space.cell_nodes(c);
        if own.iter().all(|&n| nodes[n as usize].is_none()) {
            continue;
        }
        let mut values = [[0.0; 10]; 2];
        for (a, &n) in own.iter().enumerate() {
            (values[0][a], values[1][a]) = (phi[n as usize], phi[n as usize].max(0.0));
        }
        for part in parts(space, c) {
            let share = part.volume / (D as f64 + 1.0);
            let gradients = [0, 1].map(|k| part.gradient(&values[k]) * share);
            for i in 0..=D {
                let Some(node) = &mut nodes[own[part.nodes[i]] as usize] else { continue };
                node.mass += share;
                for k in 0..2 {
                    node.gradients[k] += gradients[k];
                    let flux = |j: usize| {
                        part.weight(i, j) * (values[k][part.nodes[j]] - values[k][part.nodes[i]])
                    };
                    node.laplacians[k] += (0..=D).filter(|&j| j != i).map(flux).sum::<f64>();
                }
            }
        }
    }
    Ok((cells, nodes))
}
