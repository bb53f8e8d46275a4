//! The Hamilton-Jacobi equation of redistancing, solved along its characteristics.

use crate::base::parallel;
use crate::fem::Space;
use crate::mesh::{Location, NONE};
use crate::transport::Tracer;
use nalgebra::SVector;

/// Least slope for full steps; below it, as on the medial axis, where the gradient at a node is a
/// mean of opposite ones, steps are shorter.
const FLAT: f64 = 0.5;

/// Makes `phi / slope` a distance by pseudo-time steps of (1.35),
/// `d_tau phi + s (|grad phi| - 1) = 0`.
///
/// With `n = grad phi/|grad phi|` this is transport with a source, `d_tau phi + s n . grad phi = s`
/// (the book's (1.36), with corrections of the printed form and of the sign of the right-hand
/// side), hence along characteristics `phi(x) <- phi(x - s n dtau) + s dtau`. Here
/// `s = phi_0/sqrt(phi_0^2 + max(|grad phi_0|, 1)^2 dtau^2)` smooths the sign of the initial
/// function, so that no characteristic crosses the interface; `dtau` is the distance of two nodes
/// near the node, and the gradient at a node the volume-weighted mean over its cells. Within the
/// range of the characteristics, counted in layers of cells around those `cut` by the interface,
/// the steps start from `phi_0/|grad phi_0|` (1.38) where that is less: the kink that the steps
/// would produce in a steep function displaces the interface by a cell.
///
/// Limits: values that come from a wall instead of the interface keep the value at the wall.
pub(super) fn straighten<const D: usize>(
    tracer: &Tracer<D>,
    unknowns: &(Vec<u32>, usize),
    slope: f64,
    iterations: usize,
    cut: &[u32],
    phi: &mut Vec<f64>,
) {
    let space = tracer.space();
    phi.iter_mut().for_each(|v| *v /= slope);
    let spacing = spacing(space, unknowns);
    let gradients = Gradients::new(space, unknowns);
    let g = gradients.of(space, phi);
    // Lengths with the signs of s.
    // Where the mean gradient is flat, as in a thin filament, |phi| is still at most the distance.
    let scale = |n: usize, v: f64| v.hypot(g[n].norm().max(1.0) * spacing[n]);
    let length = |(n, v): (usize, &f64)| v / scale(n, *v) * spacing[n];
    let steps: Vec<f64> = phi.iter().enumerate().map(length).collect();
    for (n, _) in
        near(space, cut, iterations.div_ceil(2)).iter().enumerate().filter(|(_, near)| **near)
    {
        phi[n] /= g[n].norm().max(1.0);
    }
    let mut next = phi.clone();
    for _ in 0..iterations {
        let g = gradients.of(space, phi);
        parallel::fill(&mut next, 1, |first, part| {
            for (i, v) in part.iter_mut().enumerate() {
                let n = first + i;
                let normal = g[n] / g[n].norm().max(FLAT);
                let home = tracer.node_location(n);
                let foot = tracer.displaced(home, -normal * steps[n]);
                // The boundary may shorten the step.
                let way = tracer
                    .unwrapped(space.mesh().point_at(&foot) - space.mesh().point_at(&home))
                    .norm();
                *v = limited(space, phi, &foot) + way.copysign(steps[n]);
            }
        });
        std::mem::swap(phi, &mut next);
    }
    phi.iter_mut().for_each(|v| *v *= slope);
}

/// For each node: true if it belongs to a cell of `cut`, or to one of that many layers of cells
/// around them.
fn near<const D: usize>(space: &Space<D>, cut: &[u32], layers: usize) -> Vec<bool> {
    let mut near = vec![false; space.len()];
    cut.iter().flat_map(|&c| space.cell_nodes(c as usize)).for_each(|&n| near[n as usize] = true);
    for _ in 0..layers {
        let before = near.clone();
        let cells = (0..space.mesh().cell_count()).map(|c| space.cell_nodes(c));
        for nodes in cells.filter(|nodes| nodes.iter().any(|&n| before[n as usize])) {
            nodes.iter().for_each(|&n| near[n as usize] = true);
        }
    }
    near
}

/// The value at a point, limited to the range of the nodes of its cell, because overshoots of the
/// quadratic function at kinks would grow.
fn limited<const D: usize>(space: &Space<D>, phi: &[f64], at: &Location) -> f64 {
    let nodes = space.cell_nodes(at.cell as usize).iter().map(|&n| phi[n as usize]);
    let (low, high) =
        nodes.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    space.value(phi, at.cell as usize, &at.barycentric).max(low).min(high)
}

/// Half the shortest edge of the cells about each node.
fn spacing<const D: usize>(space: &Space<D>, (numbers, count): &(Vec<u32>, usize)) -> Vec<f64> {
    let mesh = space.mesh();
    let mut shortest = vec![f64::INFINITY; *count];
    for c in 0..mesh.cell_count() {
        let point = |a: usize| mesh.points()[mesh.cell(c)[a] as usize];
        let pairs = (0..=D).flat_map(|a| (0..a).map(move |b| (a, b)));
        let edge = pairs.map(|(a, b)| (point(a) - point(b)).norm()).fold(f64::INFINITY, f64::min);
        for &n in space.cell_nodes(c) {
            let s = &mut shortest[numbers[n as usize] as usize];
            *s = s.min(0.5 * edge);
        }
    }
    numbers.iter().map(|&u| if u == NONE { 0.0 } else { shortest[u as usize] }).collect()
}

/// Gradients at the nodes.
struct Gradients<'a> {
    numbers: &'a [u32],
    /// The volume of the cells about each unknown.
    volumes: Vec<f64>,
}

impl<'a> Gradients<'a> {
    fn new<const D: usize>(
        space: &Space<D>,
        (numbers, count): &'a (Vec<u32>, usize),
    ) -> Gradients<'a> {
        let mut volumes = vec![0.0; *count];
        for c in 0..space.mesh().cell_count() {
            for &n in space.cell_nodes(c) {
                volumes[numbers[n as usize] as usize] += space.mesh().map(c).volume;
            }
        }
        Gradients { numbers, volumes }
    }
    fn of<const D: usize>(&self, space: &Space<D>, phi: &[f64]) -> Vec<SVector<f64, D>> {
        let mut sums = vec![SVector::<f64, D>::zeros(); self.volumes.len()];
        for c in 0..space.mesh().cell_count() {
            let volume = space.mesh().map(c).volume;
            for (a, &n) in space.cell_nodes(c).iter().enumerate() {
                let g = space.gradient(phi, c, &space.element().node(a, D));
                sums[self.numbers[n as usize] as usize] += g * volume;
            }
        }
        let mean = |&u: &u32| {
            if u == NONE { SVector::zeros() } else { sums[u as usize] / self.volumes[u as usize] }
        };
        self.numbers.iter().map(mean).collect()
    }
}
