//! The system of a step with unknowns of structures: velocity, pressure, then blocks.

use super::{FlowSolver, Work};
use crate::base::{Error, Result};
use crate::fem::{At, MAX_LOCAL, Numbering, Space};
use crate::flow::block::Block;
use crate::flow::step::{FlowState, Step};
use crate::linalg::{Factor, LaggedReport, Multipliers, Ordering, SymmetricMatrix};
use cpu_time::ProcessTime;
use nalgebra::SVector;

/// Matrix and factor of the system with blocks; its pattern follows the cells that blocks couple
/// in.
pub(super) struct BlockSystem {
    matrix: SymmetricMatrix,
    /// Its pattern depends on the values of the matrix, which are assembled first.
    factor: Option<Factor>,
    /// Unknowns of the blocks by cell, from which the pattern was built.
    groups: Vec<(u32, Vec<u32>)>,
    /// Right-hand side and solution.
    rhs: Vec<f64>,
    x: Vec<f64>,
}

/// Forms of a block at one point: `b` by local unknown, with the values of the velocity functions.
struct Local<'a, const D: usize> {
    block: &'a dyn Block<D>,
    space: &'a Space<D>,
}

impl<const D: usize> Local<'_, D> {
    /// `b(l, v)` for local unknown `k` and all velocity functions of the cell.
    fn row(&self, at: &At<D>, k: usize) -> [SVector<f64, D>; MAX_LOCAL] {
        let (f0, f1) = self.block.coupling(at, k);
        let n = self.space.element().values::<D>(&at.barycentric);
        let inverse = &self.space.mesh().map(at.cell).inverse;
        let g = self.space.element().reference_gradients::<D>(&at.barycentric);
        std::array::from_fn(|a| (f0 * n[a] + f1 * inverse.tr_mul(&g[a])) * at.weight)
    }
    /// `b(l, u)` for local unknown `k` and a velocity of the space.
    fn value(&self, at: &At<D>, k: usize, u: &[SVector<f64, D>]) -> f64 {
        let nodes = self.space.cell_nodes(at.cell);
        nodes.iter().zip(self.row(at, k)).map(|(&n, b)| b.dot(&u[n as usize])).sum()
    }
}

/// The unknowns of all blocks by cell, blocks numbered one after the other, in ascending cells.
fn groups_of<const D: usize>(blocks: &[&dyn Block<D>]) -> Vec<(u32, Vec<u32>)> {
    let (mut groups, mut first) = (Vec::new(), 0u32);
    for block in blocks {
        let of_points = block.points().chunk_by(|a, b| a.cell == b.cell);
        let cells = match block.cells() {
            Some(cells) => cells.to_vec(),
            None => of_points.map(|points| points[0].cell as u32).collect(),
        };
        for cell in cells {
            let mut own = Vec::new();
            block.unknowns(cell as usize, &mut own);
            own.iter_mut().for_each(|k| *k += first);
            groups.push((cell, own));
        }
        first += block.len() as u32;
    }
    groups
}

impl BlockSystem {
    /// A system without values for the cells of `flow` and `count` unknowns of blocks.
    fn new<const D: usize>(
        flow: &FlowSolver<D>,
        groups: Vec<(u32, Vec<u32>)>,
        count: usize,
    ) -> Result<BlockSystem> {
        let (numbering, order) = (&flow.numbering, flow.numbering.order());
        let (velocity, pressure) = (flow.velocity.space(), flow.pressure.space());
        let cells = (0..velocity.mesh().cell_count()).map(|c| {
            let mut list = Vec::new();
            let (v, p) = (velocity.cell_nodes(c), pressure.cell_nodes(c));
            numbering.cell_unknowns(v, Some(p), &mut list);
            list
        });
        let own = groups.iter().map(|(c, unknowns)| {
            let mut list = Vec::new();
            numbering.cell_unknowns(velocity.cell_nodes(*c as usize), None, &mut list);
            list.extend(unknowns.iter().map(|k| order as u32 + k));
            list
        });
        let n = order + count;
        let matrix = SymmetricMatrix::from_groups(n, cells.chain(own))?;
        Ok(BlockSystem { matrix, factor: None, groups, rhs: vec![0.0; n], x: vec![0.0; n] })
    }

    /// Adds the forms of a block whose first unknown is `first`.
    fn add<const D: usize>(
        &mut self,
        (space, numbering): (&Space<D>, &Numbering<D>),
        (block, first): (&dyn Block<D>, usize),
        lift: &[SVector<f64, D>],
    ) -> Result<()> {
        let (nb, local_block) = (space.local_count(), Local { block, space });
        let (mut own, mut unknowns) = (Vec::new(), Vec::new());
        for points in block.points().chunk_by(|a, b| a.cell == b.cell) {
            let cell = points[0].cell;
            own.clear();
            block.unknowns(cell, &mut own);
            let m = D * nb + own.len();
            let mut local = vec![0.0; m * m];
            for (at, k) in points.iter().flat_map(|at| (0..own.len()).map(move |k| (at, k))) {
                let column = D * nb + k;
                for (a, b) in local_block.row(at, k).iter().enumerate().take(nb) {
                    for i in 0..D {
                        local[(D * a + i) * m + column] += b[i];
                        local[column * m + D * a + i] += b[i];
                    }
                }
                for j in 0..own.len() {
                    local[(D * nb + j) * m + column] += at.weight * block.own(at, j, k);
                }
                let known = local_block.value(at, k, lift);
                self.rhs[first + own[k] as usize] += at.weight * block.source(at, k) - known;
            }
            let nodes = space.cell_nodes(cell);
            numbering.rotate_local(nodes, m, &mut local);
            numbering.cell_unknowns(nodes, None, &mut unknowns);
            unknowns.extend(own.iter().map(|k| first as u32 + k));
            self.matrix.add_group(&unknowns, &local)?;
        }
        Ok(())
    }
}

impl<const D: usize> FlowSolver<D> {
    /// Solves the step with blocks; `self.matrix` holds the matrix of the flow with its terms, and
    /// `work.rhs` its right-hand side. The factor is computed in every step.
    pub(super) fn solve_with_blocks(
        &mut self,
        step: &Step<'_, D>,
        work: &mut Work<D>,
        state: &mut FlowState<D>,
    ) -> Result<LaggedReport> {
        if self.transport.is_active() {
            return Err(Error::internal("implicit convection beside unknowns of structures"));
        }
        let (order, groups) = (self.numbering.order(), groups_of(step.blocks));
        let count: usize = step.blocks.iter().map(|b| b.len()).sum();
        let kept = self.blocks.take().filter(|s| s.groups == groups && s.x.len() == order + count);
        let start = ProcessTime::now();
        let mut system = match kept {
            Some(system) => system,
            None => BlockSystem::new(self, groups, count)?,
        };
        system.matrix.zero();
        system.rhs[..order].copy_from_slice(&work.rhs);
        system.rhs[order..].fill(0.0);
        system.matrix.values_mut()[..self.matrix.nonzeros()].copy_from_slice(self.matrix.values());
        let mut first = order;
        for block in step.blocks {
            let spaces = (&**self.velocity.space(), &self.numbering);
            system.add(spaces, (*block, first), &work.lift)?;
            first += block.len();
        }
        let factor = match &mut system.factor {
            Some(factor) => factor,
            none => none.insert(self.analyse_blocks(&system.matrix)?),
        };
        factor.refactor(&system.matrix)?;
        let factoring = start.elapsed().as_secs_f64();
        let solve = factor.solve(&system.matrix, &system.rhs, &mut system.x)?;
        self.numbering.scatter(&system.x[..order], &work.lift, &mut state.u, &mut state.p);
        self.keep_block_values(step.blocks, &system.x[order..]);
        self.blocks = Some(system);
        Ok(LaggedReport {
            solve,
            refactored: true,
            given_up: false,
            substitutions: 1 + solve.refinements,
            factoring,
        })
    }

    /// Pattern of the factor of a matrix with blocks, whose unknowns come late in the order.
    fn analyse_blocks(&self, matrix: &SymmetricMatrix) -> Result<Factor> {
        let late = self.numbering.first_constant().min(self.numbering.order());
        let multipliers = Multipliers {
            first: self.numbering.first_pressure(),
            first_late: late,
            // Whose values change from step to step.
            first_unpaired: self.numbering.order(),
        };
        let ordering = Ordering::saddle_point(matrix, multipliers)?;
        match self.options.memory {
            Some(limit) => Factor::analyse_within(matrix, ordering, Some(limit)),
            None => Factor::analyse(matrix, ordering),
        }
    }

    fn keep_block_values(&mut self, blocks: &[&dyn Block<D>], mut x: &[f64]) {
        self.block_values.resize_with(blocks.len(), Vec::new);
        for (values, block) in self.block_values.iter_mut().zip(blocks) {
            let (own, rest) = x.split_at(block.len());
            values.clear();
            values.extend_from_slice(own);
            x = rest;
        }
    }

    /// Values of the unknowns of blocks in the last step, one list per block, in the order of
    /// [`Step::blocks`].
    pub fn block_values(&self) -> &[Vec<f64>] {
        &self.block_values
    }

    /// `b(l, u)` of the last step, the power of the flow on the structures of the blocks, and the
    /// same with that at each point counted positive.
    pub fn block_power(&self, blocks: &[&dyn Block<D>], u: &[SVector<f64, D>]) -> [f64; 2] {
        let space: &Space<D> = self.velocity.space();
        let (mut sums, mut own) = ([0.0; 2], Vec::new());
        for (block, values) in blocks.iter().zip(&self.block_values) {
            let local = Local { block: *block, space };
            for at in block.points() {
                own.clear();
                block.unknowns(at.cell, &mut own);
                let of =
                    |(k, unknown): (usize, &u32)| values[*unknown as usize] * local.value(at, k, u);
                let power: f64 = own.iter().enumerate().map(of).sum();
                sums = [sums[0] + power, sums[1] + power.abs()];
            }
        }
        sums
    }

    /// Adds `b(l, v)` of the last step to `out`, one vector per node.
    pub(super) fn add_block_forces(&self, blocks: &[&dyn Block<D>], out: &mut [SVector<f64, D>]) {
        let space: &Space<D> = self.velocity.space();
        for (block, values) in blocks.iter().zip(&self.block_values) {
            let (local, mut own) = (Local { block: *block, space }, Vec::new());
            for at in block.points() {
                own.clear();
                block.unknowns(at.cell, &mut own);
                for (k, &unknown) in own.iter().enumerate() {
                    let row = local.row(at, k);
                    for (&n, b) in space.cell_nodes(at.cell).iter().zip(row) {
                        out[n as usize] += b * values[unknown as usize];
                    }
                }
            }
        }
    }
}
