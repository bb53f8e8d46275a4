//! Boundary conditions of the flow, and the unknowns that they leave.
//!
//! Prescribed components are eliminated, periodic nodes share their unknowns, and at slip nodes the velocity is
//! expressed in a frame whose first axes are the wall normals, so that the matrix stays symmetric.

use super::corner::{Prescribed, Side};
use super::space::Space;
use crate::base::{Error, Result};
use crate::mesh::{Mesh, NONE, Point};
use nalgebra::{SMatrix, SVector};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// A velocity as a function of position and time.
pub type VelocityFunction<const D: usize> = Arc<dyn Fn(&Point<D>, f64) -> SVector<f64, D> + Send + Sync>;

/// What holds on a part of the boundary.
#[derive(Clone)]
pub enum Condition<const D: usize> {
    /// The velocity is given.
    Velocity(VelocityFunction<D>),
    /// The velocity is zero.
    NoSlip,
    /// No flow through the wall and no tangential stress.
    Slip,
    /// No stress: `(2 mu D(u) - p) n = 0`, "do nothing".
    Open,
    /// The same as on the named part, which is a translate of this one.
    Periodic(String),
}

/// Conditions by boundary name, in the order of the scene. Where several names hold a facet, the one with the fewest facets
/// wins, then the later one. An empty list means no slip everywhere. At a node between parts each keeps its normal velocity.
pub type Conditions<const D: usize> = Vec<(String, Condition<D>)>;

/// The unknowns of the coupled system: velocity components, then pressures.
pub struct Numbering<const D: usize> {
    velocity: Vec<[u32; D]>,
    pressure: Vec<u32>,
    first_pressure: usize,
    order: usize,
    frames: HashMap<u32, SMatrix<f64, D, D>>,
    prescribed: Vec<(u32, Prescribed<D>)>,
    open: bool,
    translations: Vec<Translation<D>>,
}

/// A periodic pair of facets: what leaves through `facet` enters at `x + shift` through `partner`.
#[derive(Clone, Debug)]
pub struct Translation<const D: usize> {
    /// Number of the facet in [`Mesh::facets`].
    pub facet: u32,
    /// Number of the facet on the other side.
    pub partner: u32,
    /// Translation from this side to the other.
    pub shift: SVector<f64, D>,
}

impl<const D: usize> Numbering<D> {
    /// Numbers the unknowns of `velocity` x `pressure` under `conditions`.
    ///
    /// # Errors
    /// A name that the mesh does not have, a facet without a condition, periodic parts that are not translates of each other.
    pub fn new(velocity: &Space<D>, pressure: &Space<D>, conditions: &Conditions<D>) -> Result<Numbering<D>> {
        let mesh = velocity.mesh();
        let on_facet = condition_of_facets(mesh, conditions)?;
        // The facets that fix the velocity at a node, by ascending priority, and those that slip.
        let mut fixed: BTreeMap<u32, Vec<Side<D>>> = BTreeMap::new();
        let mut normals: BTreeMap<u32, Vec<SVector<f64, D>>> = BTreeMap::new();
        let mut open = false;
        for &(f, k) in &on_facet {
            let facet = &mesh.facets()[f as usize];
            let (normal, _) = mesh.facet_normal(facet);
            let side = |velocity| Side { condition: k.unwrap_or(0), normal, velocity };
            match k.map_or(&Condition::NoSlip, |k| &conditions[k].1) {
                Condition::Velocity(g) => {
                    for n in velocity.facet_nodes(facet) {
                        fixed.entry(n).or_default().push(side(Some(Arc::clone(g))));
                    }
                }
                Condition::NoSlip => {
                    for n in velocity.facet_nodes(facet) {
                        fixed.entry(n).or_default().push(side(None));
                    }
                }
                Condition::Slip => {
                    for n in velocity.facet_nodes(facet) {
                        normals.entry(n).or_default().push(normal);
                    }
                }
                Condition::Open => open = true,
                Condition::Periodic(_) => {}
            }
        }
        // Nothing passes through a wall that slips, at its ends either.
        for (n, list) in &normals {
            if let Some(sides) = fixed.get_mut(n) {
                let slip = |&normal| Side { condition: conditions.len(), normal, velocity: None };
                sides.splice(0..0, list.iter().map(slip));
            }
        }
        let translations = periodic_pairs(mesh, conditions)?;
        let same_velocity = identify(velocity, mesh, &translations);
        let same_pressure = identify(pressure, mesh, &translations);

        // What is prescribed at one of several identified nodes holds at all of them.
        for n in 0..velocity.len() as u32 {
            let master = same_velocity[n as usize];
            if master != n {
                if let Some(g) = fixed.get(&n).cloned() {
                    fixed.entry(master).or_insert(g);
                }
                if let Some(v) = normals.get(&n).cloned() {
                    normals.entry(master).or_default().extend(v);
                }
            }
        }
        let mut frames = HashMap::new();
        let mut walls = HashMap::new();
        for (&n, list) in &normals {
            if !fixed.contains_key(&n) && same_velocity[n as usize] == n {
                let (frame, count) = wall_frame(list);
                frames.insert(n, frame);
                walls.insert(n, count);
            }
        }
        let mut used = vec![false; velocity.len()];
        for c in 0..mesh.cell_count() {
            velocity.cell_nodes(c).iter().for_each(|&n| used[n as usize] = true);
        }
        let mut order = 0u32;
        let mut next = || {
            order += 1;
            order - 1
        };
        let mut numbers = vec![[NONE; D]; velocity.len()];
        for n in 0..velocity.len() {
            let free = used[n] && same_velocity[n] == n as u32 && !fixed.contains_key(&(n as u32));
            if free {
                let blocked = walls.get(&(n as u32)).copied().unwrap_or(0);
                (blocked..D).for_each(|i| numbers[n][i] = next());
            }
        }
        for n in 0..velocity.len() {
            let master = same_velocity[n];
            if master != n as u32 {
                numbers[n] = numbers[master as usize];
                if let Some(frame) = frames.get(&master).copied() {
                    frames.insert(n as u32, frame);
                }
            }
        }
        let first_pressure = next() as usize;
        order -= 1;
        let mut next = || {
            order += 1;
            order - 1
        };
        let mut pressures = vec![NONE; pressure.len()];
        // The pressure is fixed at one point when nothing else fixes it; its mean is removed after the solve.
        let mut pinned = open;
        for n in 0..pressure.len() {
            if !used[n] || same_pressure[n] != n as u32 {
                continue;
            }
            if pinned {
                pressures[n] = next();
            }
            pinned = true;
        }
        for n in 0..pressure.len() {
            pressures[n] = pressures[same_pressure[n] as usize];
        }
        let prescribed = (0..velocity.len() as u32)
            .filter_map(|n| Some((n, Prescribed::new(fixed.get(&same_velocity[n as usize])?)?)))
            .collect();
        Ok(Numbering {
            velocity: numbers,
            pressure: pressures,
            first_pressure,
            order: order as usize,
            frames,
            prescribed,
            open,
            translations,
        })
    }

    /// Number of unknowns.
    pub fn order(&self) -> usize {
        self.order
    }
    /// The first pressure unknown; velocity components come before.
    pub fn first_pressure(&self) -> usize {
        self.first_pressure
    }
    /// Whether some part of the boundary is open, so that the pressure needs no fixing.
    pub fn is_open(&self) -> bool {
        self.open
    }
    /// The periodic pairs of facets.
    pub fn translations(&self) -> &[Translation<D>] {
        &self.translations
    }
    /// Whether no velocity other than zero is prescribed.
    pub fn is_homogeneous(&self) -> bool {
        self.prescribed.is_empty()
    }
    /// Nodes whose prescribed velocity may differ from zero.
    pub fn prescribed_nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.prescribed.iter().map(|(n, _)| *n)
    }
    /// Writes the prescribed velocities at time `t` into `out` (one vector a node), zero elsewhere.
    pub fn lift(&self, space: &Space<D>, t: f64, out: &mut [SVector<f64, D>]) {
        out.fill(SVector::zeros());
        for (n, g) in &self.prescribed {
            out[*n as usize] = g.at(&space.nodes()[*n as usize], t);
        }
    }
    /// The unknowns of a cell in the order of its local matrix; [`NONE`] where there is none.
    pub fn cell_unknowns(&self, velocity_nodes: &[u32], pressure_nodes: Option<&[u32]>, out: &mut Vec<u32>) {
        out.clear();
        for &n in velocity_nodes {
            out.extend_from_slice(&self.velocity[n as usize]);
        }
        for &n in pressure_nodes.unwrap_or(&[]) {
            out.push(self.pressure[n as usize]);
        }
    }
    /// Turns the velocity rows and columns of a local matrix (order `m`) into the frames of slip nodes.
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
    pub fn scatter(&self, x: &[f64], lift: &[SVector<f64, D>], velocity: &mut [SVector<f64, D>], pressure: &mut [f64]) {
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
    /// One unknown for each group of identified nodes of a scalar space: the level set on a periodic domain.
    pub fn scalar_unknowns(space: &Space<D>, translations: &[Translation<D>]) -> (Vec<u32>, usize) {
        let same = identify(space, space.mesh(), translations);
        let mut used = vec![false; space.len()];
        for c in 0..space.mesh().cell_count() {
            space.cell_nodes(c).iter().for_each(|&n| used[n as usize] = true);
        }
        let mut count = 0;
        let mut numbers = vec![NONE; space.len()];
        for n in 0..space.len() {
            if used[n] && same[n] == n as u32 {
                numbers[n] = count;
                count += 1;
            }
        }
        for n in 0..space.len() {
            numbers[n] = numbers[same[n] as usize];
        }
        (numbers, count as usize)
    }
}

/// For every facet the number of its condition, sorted by ascending priority; `None` means no slip by default.
fn condition_of_facets<const D: usize>(
    mesh: &Mesh<D>,
    conditions: &Conditions<D>,
) -> Result<Vec<(u32, Option<usize>)>> {
    let count = mesh.facets().len() as u32;
    if conditions.is_empty() {
        return Ok((0..count).map(|f| (f, None)).collect());
    }
    let mut ranked: Vec<(usize, usize)> = Vec::new();
    // A periodic condition holds its partner too.
    let names = |k: usize| -> Vec<&String> {
        match &conditions[k] {
            (name, Condition::Periodic(other)) => vec![name, other],
            (name, _) => vec![name],
        }
    };
    for k in 0..conditions.len() {
        ranked.push((mesh.boundary(names(k)[0])?.len(), k));
    }
    ranked.sort_by_key(|&(size, k)| (std::cmp::Reverse(size), k));
    let mut rank = vec![None; count as usize];
    for (r, &(_, k)) in ranked.iter().enumerate() {
        for name in names(k) {
            for &f in mesh.boundary(name)? {
                rank[f as usize] = Some(r);
            }
        }
    }
    if let Some(f) = rank.iter().position(Option::is_none) {
        let facet = &mesh.facets()[f];
        let at: Vec<_> = mesh.facet_points(facet).map(|v| mesh.points()[v as usize].as_slice().to_vec()).collect();
        let names: Vec<_> = mesh
            .boundaries()
            .iter()
            .filter(|(_, list)| list.contains(&(f as u32)))
            .map(|(name, _)| name.clone())
            .collect();
        let remedy = if names.is_empty() {
            "this part has no name in the mesh: give it one (gmsh: Physical Curve or Surface), or add [boundary.walls]"
                .into()
        } else {
            format!("add [boundary.{}] to the scene", names[0])
        };
        return Err(Error::scene("a part of the boundary has no condition")
            .at(format!("boundary facet of cell {} with points {at:?}", facet.cell))
            .value(if names.is_empty() { "unnamed".into() } else { names.join(", ") })
            .remedy(remedy));
    }
    let mut list: Vec<(usize, u32)> = rank.iter().enumerate().map(|(f, r)| (r.unwrap_or(0), f as u32)).collect();
    list.sort_unstable();
    Ok(list.into_iter().map(|(r, f)| (f, Some(ranked[r].1))).collect())
}

/// An orthonormal frame (axes are rows) whose first axes span the wall normals at a node, and how many those are.
/// Normals within 30 degrees of each other count as one curved wall and are averaged.
fn wall_frame<const D: usize>(normals: &[SVector<f64, D>]) -> (SMatrix<f64, D, D>, usize) {
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
    (SMatrix::from_fn(|i, j| axes[i][j]), walls)
}

/// The pairs of facets that periodic conditions make, each from both of its sides.
///
/// # Errors
/// A name that the mesh does not have, parts that are not translates of each other.
pub fn periodic_pairs<const D: usize>(mesh: &Mesh<D>, conditions: &Conditions<D>) -> Result<Vec<Translation<D>>> {
    let centre = |f: u32| {
        let facet = &mesh.facets()[f as usize];
        mesh.facet_points(facet).fold(Point::<D>::zeros(), |s, v| s + mesh.points()[v as usize]) / D as f64
    };
    let (lo, hi) = mesh.bounding_box();
    let grid = 1e-7 * (hi - lo).norm();
    let key =
        |x: &Point<D>| -> [i64; 3] { std::array::from_fn(|i| if i < D { (x[i] / grid).round() as i64 } else { 0 }) };
    let mut pairs = Vec::new();
    for (name, condition) in conditions {
        let Condition::Periodic(other) = condition else { continue };
        let mine = mesh.boundary(name)?;
        let theirs = mesh.boundary(other)?;
        let wrong = |what: String| {
            Error::scene("periodic boundaries must be translates of each other, facet by facet")
                .at(format!("boundary.{name}, periodic = \"{other}\""))
                .value(what)
                .remedy("mesh both sides alike (gmsh: Periodic Curve or Surface) or name the right partner")
        };
        if mine.len() != theirs.len() || mine.is_empty() {
            return Err(wrong(format!("{} facets against {}", mine.len(), theirs.len())));
        }
        let mean = |list: &[u32]| list.iter().fold(Point::<D>::zeros(), |s, &f| s + centre(f)) / list.len() as f64;
        let shift = mean(theirs) - mean(mine);
        // A coordinate may fall on either side of a rounding boundary: look in the neighbouring buckets too.
        let mut table: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        for &f in theirs {
            table.entry(key(&centre(f))).or_default().push(f);
        }
        for &f in mine {
            let target = centre(f) + shift;
            let base = key(&target);
            let found = (0..27).find_map(|o: i64| {
                let bucket = [base[0] + o % 3 - 1, base[1] + (o / 3) % 3 - 1, base[2] + o / 9 - 1];
                table.get(&bucket)?.iter().copied().find(|&g| (centre(g) - target).norm() < 2.0 * grid)
            });
            let Some(partner) = found else {
                return Err(wrong(format!("no partner for the facet at {:?}", centre(f).as_slice())));
            };
            pairs.push(Translation { facet: f, partner, shift });
            pairs.push(Translation { facet: partner, partner: f, shift: -shift });
        }
    }
    Ok(pairs)
}

/// For every node the first of the nodes it is identified with.
fn identify<const D: usize>(space: &Space<D>, mesh: &Mesh<D>, translations: &[Translation<D>]) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..space.len() as u32).collect();
    fn root(parent: &mut [u32], mut n: u32) -> u32 {
        while parent[n as usize] != n {
            parent[n as usize] = parent[parent[n as usize] as usize];
            n = parent[n as usize];
        }
        n
    }
    for t in translations {
        let (mine, theirs) = (&mesh.facets()[t.facet as usize], &mesh.facets()[t.partner as usize]);
        for a in space.facet_nodes(mine) {
            let target = space.nodes()[a as usize] + t.shift;
            let distance = |n: &u32| (space.nodes()[*n as usize] - target).norm();
            if let Some(b) = space.facet_nodes(theirs).min_by(|x, y| distance(x).total_cmp(&distance(y))) {
                let (a, b) = (root(&mut parent, a), root(&mut parent, b));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    (0..space.len() as u32).map(|n| root(&mut parent, n)).collect()
}
