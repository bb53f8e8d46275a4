//! L2 projection onto a scalar space, optionally with diffusion.

use super::assembly::{At, Basis, Cells, assemble_scalar, assemble_scalar_matrix};
use super::numbering::Numbering;
use super::periodic::Translation;
use crate::base::Result;
use crate::linalg::{Factor, Ordering, SymmetricMatrix};
use crate::mesh::NONE;
use nalgebra::SVector;

/// A factored symmetric form on a scalar space: finds `f` with
/// `(m f, q) + (k grad f, grad q) = (g, q)` for all `q`. It is the mass matrix (`m = 1`, `k = 0`),
/// so that `f` is the L2 projection of `g`, until [`set_form`](Self::set_form) is called.
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
    /// Assembles and factors the mass matrix with the rule of `basis`; periodic nodes share their
    /// unknowns.
    pub fn new(basis: Basis<D>, translations: &[Translation<D>]) -> Result<Projector<D>> {
        let mut projector = Projector::without_form(basis, translations)?;
        projector.set_form(|_| (1.0, 0.0))?;
        Ok(projector)
    }
    /// Analyses the matrix only; [`set_form`](Self::set_form) must be called before anything is
    /// projected.
    pub fn without_form(basis: Basis<D>, translations: &[Translation<D>]) -> Result<Projector<D>> {
        let space = basis.space();
        let (unknowns, order) = Numbering::scalar_unknowns(space, translations);
        let groups = (0..space.mesh().cell_count()).map(|c| {
            let nodes = space.cell_nodes(c).iter();
            nodes.map(|&n| unknowns[n as usize]).collect::<Vec<u32>>()
        });
        let matrix = SymmetricMatrix::from_groups(order, groups)?;
        let factor = Factor::analyse(&matrix, Ordering::plain(&matrix)?)?;
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
    /// Assembles and factors the form with `(m, k) = form(at)`; `m` must be positive and `k` must
    /// not be negative.
    pub fn set_form(&mut self, form: impl Fn(&At<D>) -> (f64, f64) + Sync) -> Result<()> {
        self.matrix.zero();
        assemble_scalar_matrix(&self.basis, &self.unknowns, &mut self.matrix, form)?;
        self.factor.refactor(&self.matrix)
    }
    /// The basis that integrates the right-hand sides.
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
    /// Writes the projection of `g`, or the solution of the form, into `out` (one number per node).
    pub fn project(&mut self, g: impl Fn(&At<D>) -> f64 + Sync, out: &mut [f64]) -> Result<()> {
        self.nodal.fill(0.0);
        assemble_scalar(&self.basis, Cells::All, &mut self.nodal, &mut self.scratch, |at| {
            (g(at), SVector::zeros())
        });
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
