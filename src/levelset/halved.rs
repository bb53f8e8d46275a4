//! The interface of a function that the mesh does not resolve: cut on cells that are halved near
//! it.

use super::contour::Contour;
use super::interface::Interface;
use crate::base::{Result, parallel, same};
use crate::fem::{Element, Space};
use crate::mesh::{Location, Mesh, NONE, Point};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Largest number of halvings.
const MOST_LEVELS: u32 = 6;
/// Largest distance of a point of a triangle from the nearest of its six P2 nodes, over its longest
/// edge; with a margin for a larger slope between the nodes.
const REACH: f64 = 0.4;

/// Value and slope of a function at a point.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Its value.
    pub value: f64,
    /// A bound of its slope nearby.
    pub slope: f64,
}

impl<const D: usize> Interface<'static, D> {
    /// The interface of `f`, a function of place whose least value is `-depth` (the depth of the
    /// inside), in the plane: on the cells of `space` and their halves. `None` in space.
    pub fn of_function(
        space: &Arc<Space<D>>,
        depth: f64,
        f: impl Fn(&Location) -> Sample + Sync,
    ) -> Option<Result<Interface<'static, D>>> {
        let space: &dyn std::any::Any = space;
        let halved = Interface::on_halved_cells(space.downcast_ref()?, depth, f);
        Some(halved.and_then(|i| same(i).ok_or_else(super::interface::other_dimension)))
    }
}

/// A point of the lattice of a cell, the same from all cells that share it: numbers of vertices
/// with their weights.
type Key = [(u32, u32); 3];
/// Weights of the three vertices of a cell, in units of the lattice.
type Weights = [u32; 3];

impl Interface<'static, 2> {
    fn of_nodes(space: &Arc<Space<2>>, phi: Vec<f64>) -> Result<Interface<'static, 2>> {
        let contour = Contour::new(space, &phi)?;
        Ok(Interface::of_contour(Arc::clone(space), phi, contour))
    }

    /// The interface of `f`, a function of position whose least value is `-depth` (the depth of the
    /// inside), on the cells of `space` and their halves: the cells that the interface crosses are
    /// halved until their edge times the slope is at most `depth`, at most six times, so that the
    /// thinnest part made by incompressible stretching is resolved.
    ///
    /// Limits: where the inside reaches the boundary of the mesh, cells are not halved.
    ///
    /// # Errors
    /// As for [`Contour::new`].
    fn on_halved_cells(
        space: &Arc<Space<2>>,
        depth: f64,
        f: impl Fn(&Location) -> Sample + Sync,
    ) -> Result<Interface<'static, 2>> {
        let mut lattice = Lattice { mesh: space.mesh(), levels: 0, known: HashMap::new(), f: &f };
        let whole: Vec<Triangle> =
            (0..space.mesh().cell_count() as u32).map(|c| (c, lattice.cell())).collect();
        lattice.evaluate(&whole);
        let steepest = lattice.near(&whole).map(|t| lattice.steepness(t)).fold(0.0, f64::max);
        let levels = (steepest / depth).log2().ceil().clamp(0.0, f64::from(MOST_LEVELS)) as u32;
        let nodal: Vec<f64> = lattice.nodal(space);
        let boundary = space.mesh().facets().iter().flat_map(|f| space.facet_nodes(f));
        let reaches_boundary = boundary.map(|n| nodal[n as usize]).any(|v| v < 0.0 || v.is_nan());
        if levels == 0 || reaches_boundary {
            return Interface::of_nodes(space, nodal);
        }
        let mut lattice = lattice.finer(levels);
        let mut cells: Vec<Triangle> = whole.iter().map(|(c, _)| (*c, lattice.cell())).collect();
        for level in 0..=levels {
            lattice.evaluate(&cells);
            cells = lattice.near(&cells).copied().collect();
            if level < levels {
                cells = cells.iter().flat_map(|(c, t)| halves(t).map(|h| (*c, h))).collect();
            }
        }
        lattice.interface(&cells)
    }
}

/// The cells of a mesh, each with a lattice of `2^(levels + 1)` steps along an edge, and the
/// computed values of a function there.
struct Lattice<'a, F> {
    mesh: &'a Mesh<2>,
    levels: u32,
    known: HashMap<Key, Sample>,
    f: &'a F,
}

/// A triangle of the lattice: its cell and its corners.
type Triangle = (u32, [Weights; 3]);

/// The four halves of a triangle.
fn halves([a, b, c]: &[Weights; 3]) -> [[Weights; 3]; 4] {
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
}

fn middle(a: &Weights, b: &Weights) -> Weights {
    std::array::from_fn(|k| (a[k] + b[k]) / 2)
}

/// The six P2 nodes of a triangle, in the order of the element.
fn nodes([a, b, c]: &[Weights; 3]) -> [Weights; 6] {
    [*a, *b, *c, middle(a, b), middle(b, c), middle(c, a)]
}

impl<F: Fn(&Location) -> Sample + Sync> Lattice<'_, F> {
    fn steps(&self) -> u32 {
        2 << self.levels
    }
    /// The lattice with the halves of its cells, and the computed values.
    fn finer(self, levels: u32) -> Self {
        let scaled = |key: Key| key.map(|(vertex, weight)| (vertex, weight << levels));
        Lattice {
            levels,
            known: self.known.into_iter().map(|(k, v)| (scaled(k), v)).collect(),
            ..self
        }
    }
    /// A whole cell.
    fn cell(&self) -> [Weights; 3] {
        let n = self.steps();
        [[n, 0, 0], [0, n, 0], [0, 0, n]]
    }
    fn key(&self, cell: u32, w: &Weights) -> Key {
        let vertices = self.mesh.cell(cell as usize);
        let mut key: Key =
            std::array::from_fn(|k| if w[k] == 0 { (NONE, 0) } else { (vertices[k], w[k]) });
        key.sort_unstable();
        key
    }
    fn location(&self, cell: u32, w: &Weights) -> Location {
        let n = f64::from(self.steps());
        let l = |k: usize| f64::from(w[k]) / n;
        Location { cell, barycentric: [l(0), l(1), l(2), 0.0] }
    }
    /// Samples the function at the nodes of triangles, once each.
    fn evaluate(&mut self, triangles: &[Triangle]) {
        let mut wanted: Vec<(Key, Location)> = Vec::new();
        let mut seen = HashSet::new();
        for (c, t) in triangles {
            for w in nodes(t) {
                let key = self.key(*c, &w);
                if !self.known.contains_key(&key) && seen.insert(key) {
                    wanted.push((key, self.location(*c, &w)));
                }
            }
        }
        let mut samples = vec![Sample { value: 0.0, slope: 0.0 }; wanted.len()];
        parallel::fill(&mut samples, 1, |first, part| {
            part.iter_mut().enumerate().for_each(|(i, s)| *s = (self.f)(&wanted[first + i].1));
        });
        self.known.extend(wanted.iter().map(|w| w.0).zip(samples));
    }
    fn samples(&self, (c, t): &Triangle) -> [Sample; 6] {
        nodes(t).map(|w| {
            self.known
                .get(&self.key(*c, &w))
                .copied()
                .unwrap_or(Sample { value: f64::NAN, slope: 0.0 })
        })
    }
    fn diameter(&self, (c, t): &Triangle) -> f64 {
        let side = t[0].iter().zip(&t[1]).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        self.mesh.diameter(*c as usize) * f64::from(side) / f64::from(self.steps())
    }
    /// The longest edge times the greatest slope.
    fn steepness(&self, triangle: &Triangle) -> f64 {
        self.diameter(triangle) * self.samples(triangle).iter().map(|s| s.slope).fold(0.0, f64::max)
    }
    /// The triangles that the interface may cross, also those with a value that is not finite.
    fn near<'t>(&self, triangles: &'t [Triangle]) -> impl Iterator<Item = &'t Triangle> {
        triangles.iter().filter(|t| {
            let samples = self.samples(t);
            let reach = REACH * self.steepness(t);
            let negative = samples[0].value < 0.0;
            samples
                .iter()
                .any(|s| (s.value < 0.0) != negative || s.value.abs() <= reach || s.value.is_nan())
        })
    }
    /// The values at the nodes of the mesh's own P2 space.
    fn nodal(&self, space: &Space<2>) -> Vec<f64> {
        let mut phi = vec![0.0; space.len()];
        for c in 0..self.mesh.cell_count() {
            let samples = self.samples(&(c as u32, self.cell()));
            space.cell_nodes(c).iter().zip(samples).for_each(|(&n, s)| phi[n as usize] = s.value);
        }
        phi
    }
    /// The interface on triangles that contain it.
    fn interface(&self, triangles: &[Triangle]) -> Result<Interface<'static, 2>> {
        let mut numbers: HashMap<Key, u32> = HashMap::new();
        let mut points: Vec<Point<2>> = Vec::new();
        let mut cells = Vec::with_capacity(3 * triangles.len());
        for (c, t) in triangles {
            for w in t {
                let number = numbers.entry(self.key(*c, w)).or_insert_with(|| {
                    points.push(self.mesh.point_at(&self.location(*c, w)));
                    points.len() as u32 - 1
                });
                cells.push(*number);
            }
        }
        if cells.is_empty() {
            // No interface is left: a mesh without cells is not valid.
            let space = Arc::new(Space::new(&Arc::new(self.mesh.clone()), Element::P2));
            let phi = vec![1.0; space.len()];
            return Ok(Interface::of_contour(space, phi, Contour::default()));
        }
        let space = Arc::new(Space::new(&Arc::new(Mesh::new(points, cells)?), Element::P2));
        let mut phi = vec![0.0; space.len()];
        for (k, triangle) in triangles.iter().enumerate() {
            let samples = self.samples(triangle);
            space.cell_nodes(k).iter().zip(samples).for_each(|(&n, s)| phi[n as usize] = s.value);
        }
        let contour = Contour::new(&space, &phi)?.without_walls();
        Ok(Interface::of_contour(space, phi, contour))
    }
}
