//! Numbering of the unknowns under the boundary conditions of the flow.
//!
//! Prescribed components are eliminated, periodic nodes share their unknowns, and at slip nodes the
//! velocity is expressed in a frame whose first axes are the wall normals, so that the matrix stays
//! symmetric.

use super::condition::{Condition, Conditions, condition_of_facets};
use super::corner::{Prescribed, Side};
use super::element::Element;
use super::periodic::{Translation, identify, periodic_pairs};
use super::space::Space;
use crate::base::Result;
use crate::mesh::{Mesh, NONE};
use nalgebra::{SMatrix, SVector};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// The unknowns of the coupled system: velocity components, then pressures.
pub struct Numbering<const D: usize> {
    velocity: Vec<[u32; D]>,
    pressure: Vec<u32>,
    /// Number of pressures at points of the mesh; the others are constants of cells.
    points: usize,
    first_pressure: usize,
    order: usize,
    frames: HashMap<u32, SMatrix<f64, D, D>>,
    prescribed: Vec<(u32, Prescribed<D>)>,
    open: bool,
    translations: Vec<Translation<D>>,
}

/// Numbers the components of the velocity at free nodes. Returns the numbers, the frames of nodes
/// on walls that the fluid slips along, and the number of unknowns.
#[allow(clippy::type_complexity, reason = "three results of one loop")]
fn number_velocity<const D: usize>(
    velocity: &Space<D>,
    marks: &Marks<D>,
    masters: &[u32],
) -> (Vec<[u32; D]>, HashMap<u32, SMatrix<f64, D, D>>, u32) {
    let used = velocity.used_nodes();
    let mut order = 0;
    let mut next = || {
        order += 1;
        order - 1
    };
    let mut frames = HashMap::new();
    let mut numbers = vec![[NONE; D]; velocity.len()];
    for n in 0..velocity.len() {
        let (master, node) = (masters[n], n as u32);
        if master != node {
            numbers[n] = numbers[master as usize];
            if let Some(&frame) = frames.get(&master) {
                frames.insert(node, frame);
            }
        } else if used[n] && !marks.fixed.contains_key(&node) {
            let (frame, walls) =
                marks.normals.get(&node).map_or((None, 0), |list| wall_frame(list));
            frame.map(|f| frames.insert(node, f));
            (walls..D).for_each(|i| numbers[n][i] = next());
        }
    }
    (numbers, frames, order)
}

/// Numbers the pressures from `first` on. Where it is `pinned`, the pressure is fixed at one point;
/// its mean is removed after the solve. Returns the numbers, and the number of all unknowns.
fn number_pressure<const D: usize>(
    pressure: &Space<D>,
    translations: &[Translation<D>],
    first: u32,
    pinned: bool,
) -> (Vec<u32>, u32) {
    let mesh = pressure.mesh();
    let points = mesh.points().len();
    let left_out = match pressure.element() {
        Element::P1P0 => constants_left_out(mesh, translations),
        _ => Vec::new(),
    };
    let (used, masters) = (pressure.used_nodes(), identify(pressure, translations));
    let mut numbers = vec![NONE; pressure.len()];
    let (mut fixed, mut free) = (!pinned, first);
    for n in 0..pressure.len() {
        let master = masters[n] as usize;
        if master != n {
            numbers[n] = numbers[master];
        } else if n >= points {
            if !left_out[n - points] {
                numbers[n] = free;
                free += 1;
            }
        } else if used[n] && std::mem::replace(&mut fixed, true) {
            numbers[n] = free;
            free += 1;
        }
    }
    (numbers, free)
}

impl<const D: usize> Numbering<D> {
    /// Numbers the unknowns of `velocity` x `pressure` under `conditions`.
    ///
    /// # Errors
    /// A name that the mesh does not have, a facet without a condition, periodic parts that are not
    /// translates of each other.
    pub fn new(
        velocity: &Space<D>,
        pressure: &Space<D>,
        conditions: &Conditions<D>,
    ) -> Result<Numbering<D>> {
        let mesh = velocity.mesh();
        let translations = periodic_pairs(mesh, conditions)?;
        let masters = identify(velocity, &translations);
        let mut marks = Marks::new(velocity, conditions)?;
        marks.share(&masters);
        let (numbers, frames, first_pressure) = number_velocity(velocity, &marks, &masters);
        let pinned = !marks.open;
        let (pressures, order) = number_pressure(pressure, &translations, first_pressure, pinned);
        let prescribed = (0..velocity.len() as u32)
            .filter_map(|n| Some((n, Prescribed::new(marks.fixed.get(&masters[n as usize])?)?)))
            .collect();
        Ok(Numbering {
            velocity: numbers,
            pressure: pressures,
            points: mesh.points().len(),
            first_pressure: first_pressure as usize,
            order: order as usize,
            frames,
            prescribed,
            open: marks.open,
            translations,
        })
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.order
    }
    /// The first pressure unknown that is the constant of a cell; the number of unknowns where
    /// there is none.
    pub fn first_constant(&self) -> usize {
        let constants = self.pressure.iter().skip(self.points);
        constants.copied().find(|&p| p != NONE).map_or(self.order, |p| p as usize)
    }
    /// Number of pressures at points of the mesh, which come first; the others are constants of
    /// cells.
    pub fn pressure_points(&self) -> usize {
        self.points
    }
    /// The first pressure unknown; velocity components come before.
    pub fn first_pressure(&self) -> usize {
        self.first_pressure
    }
    /// For every velocity unknown the index of its component in the frame of its node.
    pub fn components(&self) -> Vec<u8> {
        let mut components = vec![0; self.first_pressure];
        for node in &self.velocity {
            for (i, &unknown) in node.iter().enumerate().filter(|(_, u)| **u != NONE) {
                components[unknown as usize] = i as u8;
            }
        }
        components
    }
    /// The pressure unknowns by node, counted from 0; [`NONE`] for nodes without one.
    pub fn pressure_unknowns(&self) -> Vec<u32> {
        let first = self.first_pressure as u32;
        self.pressure.iter().map(|&p| if p == NONE { NONE } else { p - first }).collect()
    }
    /// True if some part of the boundary is open, so that the pressure is determined.
    pub fn is_open(&self) -> bool {
        self.open
    }
    /// The periodic pairs of facets.
    pub fn translations(&self) -> &[Translation<D>] {
        &self.translations
    }
    /// True if no velocity other than zero is prescribed.
    pub fn is_homogeneous(&self) -> bool {
        self.prescribed.is_empty()
    }
    /// Nodes whose prescribed velocity may differ from zero.
    pub fn prescribed_nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.prescribed.iter().map(|(n, _)| *n)
    }
    /// Writes the prescribed velocities at time `t` into `out` (one vector per node), zero
    /// elsewhere.
    pub fn lift(&self, space: &Space<D>, t: f64, out: &mut [SVector<f64, D>]) {
        out.fill(SVector::zeros());
        for (n, g) in &self.prescribed {
            out[*n as usize] = g.at(&space.nodes()[*n as usize], t);
        }
    }
    /// The unknowns of a cell in the order of its local matrix; [`NONE`] where there is none.
    pub fn cell_unknowns(
        &self,
        velocity_nodes: &[u32],
        pressure_nodes: Option<&[u32]>,
        out: &mut Vec<u32>,
    ) {
        out.clear();
        for &n in velocity_nodes {
            out.extend_from_slice(&self.velocity[n as usize]);
        }
        for &n in pressure_nodes.unwrap_or(&[]) {
            out.push(self.pressure[n as usize]);
        }
    }
    /// Rotates the velocity rows and columns of a local matrix (order `m`) into the frames of slip
    /// nodes.
    pub fn rotate_local(&self, nodes: &[u32], m: usize, local: &mut [f64]) {
        if self.frames.is_empty() || !nodes.iter().any(|n| self.frames.contains_key(n)) {
            return;
        }
        for (a, n) in nodes.iter().enumerate() {
            let Some(frame) = self.frames.get(n) else { continue };
            for k in 0..m {
                let row = frame * SVector::<f64, D>::from_fn(|i, _| local[(D * a + i) * m + k]);
                (0..D).for_each(|i| local[(D * a + i) * m + k] = row[i]);
            }
            for k in 0..m {
                let column = frame * SVector::<f64, D>::from_fn(|i, _| local[k * m + D * a + i]);
                (0..D).for_each(|i| local[k * m + D * a + i] = column[i]);
            }
        }
    }
    /// Adds nodal residuals to the right-hand side of the system.
    pub fn gather(&self, velocity: &[SVector<f64, D>], pressure: &[f64], rhs: &mut [f64]) {
        rhs.fill(0.0);
        for (n, r) in velocity.iter().enumerate() {
            let r = self.frames.get(&(n as u32)).map_or(*r, |f| f * r);
            for i in 0..D {
                if self.velocity[n][i] != NONE {
                    rhs[self.velocity[n][i] as usize] += r[i];
                }
            }
        }
        for (n, r) in pressure.iter().enumerate() {
            if self.pressure[n] != NONE {
                rhs[self.pressure[n] as usize] += r;
            }
        }
    }
    /// Nodal values from the solution of the system; prescribed values are added from `lift`.
    pub fn scatter(
        &self,
        x: &[f64],
        lift: &[SVector<f64, D>],
        velocity: &mut [SVector<f64, D>],
        pressure: &mut [f64],
    ) {
        for (n, u) in velocity.iter_mut().enumerate() {
            let mut v = SVector::<f64, D>::zeros();
            for i in 0..D {
                if self.velocity[n][i] != NONE {
                    v[i] = x[self.velocity[n][i] as usize];
                }
            }
            *u = self.frames.get(&(n as u32)).map_or(v, |f| f.tr_mul(&v)) + lift[n];
        }
        for (n, p) in pressure.iter_mut().enumerate() {
            *p = if self.pressure[n] == NONE { 0.0 } else { x[self.pressure[n] as usize] };
        }
    }
    /// The solution vector that [`scatter`](Self::scatter) maps to these nodal values; if one
    /// pressure is fixed, all are shifted by it.
    pub fn restrict(
        &self,
        velocity: &[SVector<f64, D>],
        pressure: &[f64],
        lift: &[SVector<f64, D>],
        x: &mut [f64],
    ) {
        for (n, u) in velocity.iter().enumerate() {
            let v = u - lift[n];
            let v = self.frames.get(&(n as u32)).map_or(v, |f| f * v);
            for i in 0..D {
                if self.velocity[n][i] != NONE {
                    x[self.velocity[n][i] as usize] = v[i];
                }
            }
        }
        let fixed = if self.open { None } else { self.pressure.iter().position(|&p| p == NONE) };
        let shift = fixed.map_or(0.0, |n| pressure[n]);
        for (n, p) in pressure.iter().enumerate() {
            if self.pressure[n] != NONE {
                x[self.pressure[n] as usize] = if n < self.points { p - shift } else { *p };
            }
        }
    }
    /// One unknown for each group of identified nodes of a scalar space: the level set on a
    /// periodic domain.
    pub fn scalar_unknowns(space: &Space<D>, translations: &[Translation<D>]) -> (Vec<u32>, usize) {
        let masters = identify(space, translations);
        let used = space.used_nodes();
        let mut count = 0;
        let mut numbers = vec![NONE; space.len()];
        for n in 0..space.len() {
            let master = masters[n] as usize;
            if master != n {
                numbers[n] = numbers[master];
            } else if used[n] {
                numbers[n] = count;
                count += 1;
            }
        }
        (numbers, count as usize)
    }
}

/// Cells whose constant is not an unknown of a P1 + P0 pressure. In a cell with two walls a single
/// edge has a free velocity, which cannot distinguish the constant from the pressure at the corner.
/// Because P1 contains constants, one more cell is excluded.
fn constants_left_out<const D: usize>(
    mesh: &Mesh<D>,
    translations: &[Translation<D>],
) -> Vec<bool> {
    let mut walls = vec![0; mesh.cell_count()];
    mesh.facets().iter().for_each(|f| walls[f.cell as usize] += 1);
    translations.iter().for_each(|t| walls[mesh.facets()[t.facet as usize].cell as usize] -= 1);
    let mut left_out: Vec<bool> = walls.iter().map(|&count| count > 1).collect();
    left_out.iter_mut().find(|out| !**out).into_iter().for_each(|first| *first = true);
    left_out
}

/// Conditions at nodes.
struct Marks<const D: usize> {
    /// Facets that fix the velocity at a node, by ascending priority, slip walls before all others.
    fixed: BTreeMap<u32, Vec<Side<D>>>,
    /// Normals of the slip walls at a node.
    normals: BTreeMap<u32, Vec<SVector<f64, D>>>,
    /// True if some facet is open.
    open: bool,
}

impl<const D: usize> Marks<D> {
    fn new(velocity: &Space<D>, conditions: &Conditions<D>) -> Result<Marks<D>> {
        let mesh = velocity.mesh();
        let mut marks = Marks { fixed: BTreeMap::new(), normals: BTreeMap::new(), open: false };
        for (f, k) in condition_of_facets(mesh, conditions)? {
            let facet = &mesh.facets()[f as usize];
            let (normal, _) = mesh.facet_normal(facet);
            let nodes: Vec<u32> = velocity.facet_nodes(facet).collect();
            let side = |velocity| Side { condition: k, normal, velocity };
            match k.map_or(&Condition::NoSlip, |k| &conditions[k].1) {
                Condition::Velocity(g) => marks.fix(&nodes, &side(Some(Arc::clone(g)))),
                Condition::NoSlip => marks.fix(&nodes, &side(None)),
                Condition::Slip => {
                    nodes.iter().for_each(|&n| marks.normals.entry(n).or_default().push(normal))
                }
                Condition::Periodic(_) => {}
                // Fluid passes under a given stress.
                _ => marks.open = true,
            }
        }
        // No flow through a slip wall, also at its ends.
        for (n, list) in &marks.normals {
            if let Some(sides) = marks.fixed.get_mut(n) {
                sides.splice(
                    0..0,
                    list.iter().map(|&normal| Side { condition: None, normal, velocity: None }),
                );
            }
        }
        Ok(marks)
    }

    fn fix(&mut self, nodes: &[u32], side: &Side<D>) {
        nodes.iter().for_each(|&n| self.fixed.entry(n).or_default().push(side.clone()));
    }

    /// Conditions at one of several identified nodes apply to their master, and so to all of them.
    fn share(&mut self, masters: &[u32]) {
        for (n, &master) in masters.iter().enumerate().filter(|&(n, &m)| n as u32 != m) {
            if let Some(g) = self.fixed.get(&(n as u32)).cloned() {
                self.fixed.entry(master).or_insert(g);
            }
            if let Some(list) = self.normals.get(&(n as u32)).cloned() {
                self.normals.entry(master).or_default().extend(list);
            }
        }
    }
}

/// An orthonormal frame (axes are rows) whose first axes span the wall normals at a node, and the
/// number of these axes. Normals within 30 degrees of each other count as one curved wall and are
/// averaged.
fn wall_frame<const D: usize>(normals: &[SVector<f64, D>]) -> (Option<SMatrix<f64, D, D>>, usize) {
    let mut groups: Vec<SVector<f64, D>> = Vec::new();
    for n in normals {
        match groups.iter_mut().find(|g| g.normalize().dot(n) > 30f64.to_radians().cos()) {
            Some(g) => *g += n,
            None => groups.push(*n),
        }
    }
    let mut axes: Vec<SVector<f64, D>> = Vec::new();
    let add = |v: SVector<f64, D>, axes: &mut Vec<SVector<f64, D>>| {
        let rest = axes.iter().fold(v, |r, a| r - *a * a.dot(&r));
        if rest.norm() > 1e-6 && axes.len() < D {
            axes.push(rest.normalize());
        }
    };
    groups.iter().for_each(|g| add(g.normalize(), &mut axes));
    let walls = axes.len();
    for i in 0..D {
        let mut e = SVector::<f64, D>::zeros();
        e[i] = 1.0;
        add(e, &mut axes);
    }
    (Some(SMatrix::from_fn(|i, j| axes[i][j])), walls)
}
