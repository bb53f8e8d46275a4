//! L2 projection onto a scalar space.

use super::assembly::{At, Basis, Cells, assemble_mass, assemble_scalar};
use super::numbering::Numbering;
use super::periodic::Translation;
use crate::base::Result;
use crate::linalg::{Factor, Ordering, SymmetricMatrix};
use crate::mesh::NONE;
use nalgebra::SVector;

/// The factored mass matrix of a scalar space: finds `f` with `(f, q) = (g, q)` for all `q`.
pub struct Projector<const D: usize> {
    basis: Basis<D>,
    unknowns: Vec<u32>,
    matrix: SymmetricMatrix,
    factor: Factor,
    nodal: Vec<f64>,
    rhs: Vec<f64>,
    x: Vec<f64>,
    scratch: Vec<f64>,
}

impl<const D: usize> Projector<D> {
    /// Assembles and factors the mass matrix with the rule of `basis`; periodic nodes share their unknowns.
    pub fn new(basis: Basis<D>, translations: &[Translation<D>]) -> Result<Projector<D>> {
        let space = basis.space();
        let (unknowns, order) = Numbering::scalar_unknowns(space, translations);
        let groups = (0..space.mesh().cell_count()).map(|c| {
            let nodes = space.cell_nodes(c).iter();
            nodes.map(|&n| unknowns[n as usize]).collect::<Vec<u32>>()
        });
        let mut matrix = SymmetricMatrix::from_groups(order, groups)?;
        assemble_mass(&basis, &unknowns, &mut matrix, |_| 1.0)?;
        let mut factor = Factor::analyse(&matrix, Ordering::plain(&matrix)?)?;
        factor.refactor(&matrix)?;
        let nodal = vec![0.0; space.len()];
        Ok(Projector {
            unknowns,
            matrix,
            factor,
            nodal,
            rhs: vec![0.0; order],
            x: vec![0.0; order],
            scratch: Vec::new(),
            basis,
        })
    }
    /// The basis that right-hand sides are integrated with.
    pub fn basis(&self) -> &Basis<D> {
        &self.basis
    }
    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.matrix.order()
    }
    /// Bytes held by the factor.
    pub fn bytes(&self) -> usize {
        self.factor.bytes()
    }
    /// Writes the projection of `g` into `out` (one number a node).
    pub fn project(&mut self, g: impl Fn(&At<D>) -> f64 + Sync, out: &mut [f64]) -> Result<()> {
        self.nodal.fill(0.0);
        assemble_scalar(&self.basis, Cells::All, &mut self.nodal, &mut self.scratch, |at| (g(at), SVector::zeros()));
        self.rhs.fill(0.0);
        for (n, v) in self.nodal.iter().enumerate() {
            if self.unknowns[n] != NONE {
                self.rhs[self.unknowns[n] as usize] += v;
            }
        }
        self.factor.solve(&self.matrix, &self.rhs, &mut self.x)?;
        for (n, v) in out.iter_mut().enumerate() {
            if self.unknowns[n] != NONE {
                *v = self.x[self.unknowns[n] as usize];
            }
        }
        Ok(())
    }
}
