//! An interface that moves with the fluid by its own points, and densities on it.

use crate::base::Result;
use crate::fem::{At, Space, SurfaceMass, SurfacePoint};
use crate::mesh::{Location, NONE};
use crate::transport::{AdvectingVelocity, Tracer};
use nalgebra::SVector;
use std::sync::Arc;

/// Largest number of cells in the search for a cut cell.
const MOST_CELLS: usize = 64;
/// Number of layers of cells around the cut ones to which a correction of the level set is
/// continued.
const LAYERS: usize = 2;

/// Length over which amounts are balanced, in diameters of cells.
const BALANCED: f64 = 4.0;

/// An interface, carried by the fluid over a step along the paths of its quadrature points.
pub struct CarriedSurface<'a, const D: usize> {
    tracer: &'a Tracer<D>,
    /// Velocity at the nodes.
    u: &'a [SVector<f64, D>],
    dt: f64,
    from: Arc<[SurfacePoint<D>]>,
    /// The level set whose zero is `from`.
    phi: &'a [f64],
    /// For every point of `from` its place after the step, and false if it left the domain.
    ends: Vec<(Location, bool)>,
}

impl<'a, const D: usize> CarriedSurface<'a, D> {
    /// The interface `from`, the zero set of `phi`, in a velocity `u` (one vector per node) that is
    /// constant over the step `dt`. What leaves the domain is lost.
    pub fn new(
        tracer: &'a Tracer<D>,
        (u, dt): (&'a [SVector<f64, D>], f64),
        (from, phi): (Arc<[SurfacePoint<D>]>, &'a [f64]),
    ) -> CarriedSurface<'a, D> {
        let starts: Vec<Location> = from.iter().map(location).collect();
        let ends = tracer.ahead(&AdvectingVelocity::Nodal(u), dt, &starts);
        CarriedSurface { tracer, u, dt, from, phi, ends }
    }

    /// Moves the zero set of the level set `phi` after the step, `to`, onto the points: subtracts
    /// the P2 function `c` with `int_S c/|grad phi| v = sum w phi(X)/|grad phi(X)| v(X)` for all
    /// `v`, where the point of weight `w` is at `X` after the step.
    ///
    /// The points are exact up to their path, while a level set carried from node to node has been
    /// interpolated. As `v` may be constant, the distances of the points from the interface add up
    /// to zero, and what the interface encloses is kept to second order in the correction. Without
    /// the slopes it is not: those of a redistanced level set differ from cell to cell, as its
    /// errors do.
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn fit(&self, to: &[SurfacePoint<D>], phi: &mut [f64]) -> Result<()> {
        let space = self.tracer.space();
        let unknowns = self.tracer.unknowns();
        let Some(mut mass) = SurfaceMass::new(space, unknowns, to)? else { return Ok(()) };
        let by_slope = |p: &SurfacePoint<D>| {
            let weight = p.at.weight / steepness(space, phi, &location(p));
            SurfacePoint { at: At { weight, ..p.at }, ..*p }
        };
        let weighted: Vec<SurfacePoint<D>> = to.iter().map(by_slope).collect();
        mass.diffuse(space, (&weighted, phi), |_| 0.0)?;
        let cut = CutCells::new(space, to);
        let value = |_: &_, at: &Location| {
            let phi_there = space.value(phi, at.cell as usize, &at.barycentric);
            phi_there / steepness(space, phi, at)
        };
        let load = self.arrived(&mass, &cut, value);
        let mut correction = vec![f64::NAN; phi.len()];
        mass.solve(&load, &mut correction)?;
        continue_outward(self.tracer, &cut.list, &mut correction);
        for (v, c) in phi.iter_mut().zip(correction).filter(|(_, c)| c.is_finite()) {
            *v -= c;
        }
        Ok(())
    }

    /// The way onto the interface `to` after the step, the zero set of `phi`, on which fields are
    /// carried.
    ///
    /// # Errors
    /// A matrix of too many unknowns.
    pub fn onto<'b>(
        &'b self,
        to: &'b [SurfacePoint<D>],
        phi: &'b [f64],
    ) -> Result<Onto<'b, 'a, D>> {
        let (space, dt) = (self.tracer.space(), self.dt);
        let places: Vec<Location> = to.iter().map(location).collect();
        let feet = self.tracer.ahead(&AdvectingVelocity::Nodal(self.u), -dt, &places);
        let cut = CutCells::new(space, &self.from);
        let rate = |at: &Location, n: &SVector<f64, D>| {
            let g = space.jacobian(self.u, at.cell as usize, &at.barycentric);
            g.trace() - n.dot(&(g * n))
        };
        let start =
            |((p, place), (foot, _)): ((&SurfacePoint<D>, &Location), &(Location, bool))| {
                let slope = space.gradient(self.phi, foot.cell as usize, &foot.barycentric);
                let normal = slope.try_normalize(0.0).unwrap_or(p.normal);
                let growth = 0.5 * dt * (rate(foot, &normal) + rate(place, &p.normal));
                (cut.near(self.tracer, foot).unwrap_or(*foot), growth)
            };
        let starts = to.iter().zip(&places).zip(&feet).map(start).collect();
        let mass = SurfaceMass::new(space, self.tracer.unknowns(), to)?;
        Ok(Onto { carried: self, to, phi, starts, mass, cut: CutCells::new(space, to) })
    }

    /// `sum w value(p, X) v(X)` over the points `p` of `from`, for all functions `v` on the new
    /// interface.
    fn arrived(
        &self,
        mass: &SurfaceMass,
        cut: &CutCells,
        value: impl Fn(&SurfacePoint<D>, &Location) -> f64,
    ) -> Vec<f64> {
        let (space, mut load) = (self.tracer.space(), mass.load());
        for (p, (end, _)) in self.inside() {
            if let Some(near) = cut.near(self.tracer, end) {
                let amount = p.at.weight * value(p, end);
                mass.deposit(space, (near.cell as usize, &near.barycentric), amount, &mut load);
            }
        }
        load
    }
    /// The points that do not leave the domain, with their ends.
    fn inside(&self) -> impl Iterator<Item = (&SurfacePoint<D>, &(Location, bool))> {
        self.from.iter().zip(&self.ends).filter(|(_, (_, inside))| *inside)
    }
}

/// Where points of an interface come from after a step `dt` in the velocity `u` (one vector per
/// node): by the coordinates of a cell that the interface `from` at its start cuts, where one is
/// near.
pub fn origins<const D: usize>(
    tracer: &Tracer<D>,
    (u, dt): (&[SVector<f64, D>], f64),
    from: &[SurfacePoint<D>],
    to: &[SurfacePoint<D>],
) -> Vec<Location> {
    let places: Vec<Location> = to.iter().map(location).collect();
    let feet = tracer.ahead(&AdvectingVelocity::Nodal(u), -dt, &places);
    let cut = CutCells::new(tracer.space(), from);
    feet.iter().map(|(foot, _)| cut.near(tracer, foot).unwrap_or(*foot)).collect()
}

/// A carried interface with the one on which it arrives.
pub struct Onto<'b, 'a, const D: usize> {
    carried: &'b CarriedSurface<'a, D>,
    to: &'b [SurfacePoint<D>],
    /// The level set whose zero is `to`.
    phi: &'b [f64],
    /// For every point of `to` where it comes from, by the coordinates of a cell that `from` cuts,
    /// and the logarithm of the area at its end over that at its start, `int P : grad u dt`.
    starts: Vec<(Location, f64)>,
    /// `None` if there is no interface any more.
    mass: Option<SurfaceMass>,
    cut: CutCells,
}

impl<const D: usize> Onto<'_, '_, D> {
    /// Carries a conserved density on the interface, `Dm/Dt + m P : grad u = div_S(k grad_S m)`:
    /// the length (in space: area) at rest per length, which is the inverse of the stretch, or the
    /// concentration of a surfactant. `before` are its nodal values at the start, and `k >= 0` the
    /// diffusivity times the step at a point for a density `m` there.
    ///
    /// The density at a point is that where the point comes from, times `exp(-dt P : grad u)`,
    /// projected ([`SurfaceMass`]): third order, and stable also where the motion along the surface
    /// stands still. With `balance` the amounts that the points at the start carry along their
    /// paths then correct it over distances of some cells, and the total amount is kept to
    /// rounding, but for what ends farther than some cells from the new interface. The amounts alone would do, but a quadrature of functions that have kinks at other
    /// places has errors that do not fall with the mesh size.
    ///
    /// The values count in cut cells, and are continued over two layers of cells; other nodes have
    /// the mean.
    ///
    /// # Errors
    /// A matrix that cannot be factored.
    pub fn density(
        &mut self,
        before: &[f64],
        balance: bool,
        diffusivity: impl Fn(&SurfacePoint<D>, f64) -> f64,
    ) -> Result<Vec<f64>> {
        let (carried, to, end) = (self.carried, self.to, (self.to, self.phi));
        let space = carried.tracer.space();
        let at = |p: &SurfacePoint<D>| space.value(before, p.at.cell, &p.at.barycentric);
        let value = |(start, growth): &(Location, f64)| {
            space.value(before, start.cell as usize, &start.barycentric) * (-growth).exp()
        };
        let values: Vec<f64> = self.starts.iter().map(value).collect();
        let Some(mass) = &mut self.mass else { return Ok(vec![0.0; space.len()]) };
        mass.diffuse(space, end, |p| diffusivity(p, values[p.at.q]))?;
        let mut load = mass.load();
        for (p, value) in to.iter().zip(&values) {
            let at = (p.at.cell, &p.at.barycentric);
            mass.deposit(space, at, p.at.weight * value, &mut load);
        }
        let mut after = vec![f64::NAN; space.len()];
        mass.solve(&load, &mut after)?;
        if balance {
            let arrived = carried.arrived(mass, &self.cut, |p, _| at(p));
            let missing: Vec<f64> = arrived.iter().zip(&load).map(|(a, l)| a - l).collect();
            let over = |p: &SurfacePoint<D>| (BALANCED * space.mesh().diameter(p.at.cell)).powi(2);
            mass.diffuse(space, end, over)?;
            let mut correction = vec![0.0; space.len()];
            mass.solve(&missing, &mut correction)?;
            after.iter_mut().zip(correction).for_each(|(m, c)| *m += c);
        }
        continue_outward(carried.tracer, &self.cut.list, &mut after);
        let amount: f64 = carried.inside().map(|(p, _)| p.at.weight * at(p)).sum();
        let mean = amount / to.iter().map(|p| p.at.weight).sum::<f64>();
        after.iter_mut().filter(|m| m.is_nan()).for_each(|m| *m = mean);
        Ok(after)
    }

    /// Continues nodal values that count in cut cells to all nodes within `reach` of the interface:
    /// the value there is that of the nearest point, along the normal.
    pub fn continue_to(&self, reach: f64, values: &mut [f64]) {
        let (tracer, cut) = (self.carried.tracer, &self.cut);
        let space = tracer.space();
        let slopes = space.means(|c, l| space.gradient(self.phi, c, l));
        let mut counts = vec![true; values.len()];
        for n in cut.list.iter().flat_map(|&c| space.cell_nodes(c as usize)) {
            counts[*n as usize] = false;
        }
        let on_interface = values.to_vec();
        for n in (0..values.len()).filter(|&n| counts[n]) {
            let (phi, slope) = (self.phi[n], slopes[n]);
            let distance = phi / slope.norm();
            if distance.is_nan() || distance.abs() > reach {
                continue;
            }
            let step = slope * (-phi / slope.norm_squared());
            let near = tracer.displaced(tracer.node_location(n), step);
            if let Some(at) = cut.near(tracer, &near) {
                values[n] = space.value(&on_interface, at.cell as usize, &at.barycentric);
            }
        }
    }
}

/// Continues vectors at the nodes of the cells that the interface of `points` cuts over two layers
/// of cells, with zero beyond.
pub fn continue_vectors<const D: usize>(
    tracer: &Tracer<D>,
    points: &[SurfacePoint<D>],
    vectors: &mut [SVector<f64, D>],
) {
    let cut = CutCells::new(tracer.space(), points);
    for i in 0..D {
        let mut component: Vec<f64> = vectors.iter().map(|v| v[i]).collect();
        continue_outward(tracer, &cut.list, &mut component);
        let value = |c: f64| if c.is_nan() { 0.0 } else { c };
        vectors.iter_mut().zip(component).for_each(|(v, c)| v[i] = value(c));
    }
}

/// Slope `|grad phi|` at a place, never zero.
pub(super) fn steepness<const D: usize>(space: &Space<D>, phi: &[f64], at: &Location) -> f64 {
    space.gradient(phi, at.cell as usize, &at.barycentric).norm().max(f64::MIN_POSITIVE)
}

/// The place of a point.
fn location<const D: usize>(p: &SurfacePoint<D>) -> Location {
    Location { cell: p.at.cell as u32, barycentric: p.at.barycentric }
}

/// The cells that an interface cuts, in the order of its points.
pub fn cut_cells<const D: usize>(points: &[SurfacePoint<D>]) -> Vec<u32> {
    points.chunk_by(|a, b| a.at.cell == b.at.cell).map(|g| g[0].at.cell as u32).collect()
}

/// Cells that an interface cuts.
pub(super) struct CutCells {
    pub list: Vec<u32>,
    cuts: Vec<bool>,
}

impl CutCells {
    pub fn new<const D: usize>(space: &Space<D>, points: &[SurfacePoint<D>]) -> CutCells {
        let list = cut_cells(points);
        let mut cuts = vec![false; space.mesh().cell_count()];
        list.iter().for_each(|&c| cuts[c as usize] = true);
        CutCells { list, cuts }
    }
    /// The same point by the coordinates of a cut cell close to it, its own if that is cut.
    pub fn near<const D: usize>(&self, tracer: &Tracer<D>, at: &Location) -> Option<Location> {
        if self.cuts[at.cell as usize] {
            return Some(*at);
        }
        let mesh = tracer.space().mesh();
        let (mut seen, mut next) = (vec![(at.cell, mesh.point_at(at))], 0);
        while next < seen.len().min(MOST_CELLS) {
            let (cell, x) = seen[next];
            if self.cuts[cell as usize] {
                let barycentric = mesh.map(cell as usize).barycentric(&x);
                return Some(Location { cell, barycentric });
            }
            for (beyond, shift) in (0..=D).filter_map(|k| tracer.beyond(cell, k)) {
                if seen.iter().all(|(c, _)| *c != beyond) {
                    seen.push((beyond, x + shift));
                }
            }
            next += 1;
        }
        None
    }
}

/// Sets nodes without a value (NaN) in some layers of cells around `cells` to the mean of those with
/// one in their cells, layer by layer.
pub(super) fn continue_outward<const D: usize>(
    tracer: &Tracer<D>,
    cells: &[u32],
    values: &mut [f64],
) {
    let (space, unknowns) = (tracer.space(), tracer.unknowns());
    let mut layer = cells.to_vec();
    let mut new: Vec<f64> = vec![f64::NAN; values.len()];
    for _ in 0..LAYERS {
        let beside = layer.iter().flat_map(|&c| (0..=D).filter_map(move |k| tracer.beyond(c, k)));
        let mut next: Vec<u32> = beside.map(|(c, _)| c).collect();
        next.sort_unstable();
        next.dedup();
        let value = |n: u32, new: &[f64]| match values[n as usize] {
            v if v.is_nan() => new[unknowns[n as usize] as usize],
            v => v,
        };
        let mut found: Vec<(u32, f64, f64)> = Vec::new();
        for &c in &next {
            let nodes = space.cell_nodes(c as usize);
            let known = nodes.iter().map(|&n| value(n, &new)).filter(|v| !v.is_nan());
            let (sum, count) = known.fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
            if count > 0.0 {
                let open = nodes.iter().filter(|&&n| value(n, &new).is_nan());
                found.extend(open.map(|&n| (unknowns[n as usize], sum, count)));
            }
        }
        found.sort_by_key(|f| f.0);
        for group in found.chunk_by(|a, b| a.0 == b.0) {
            let (sum, count) = group.iter().fold((0.0, 0.0), |(s, n), g| (s + g.1, n + g.2));
            new[group[0].0 as usize] = sum / count;
        }
        layer = next;
    }
    for (v, &u) in values.iter_mut().zip(unknowns).filter(|(v, u)| v.is_nan() && **u != NONE) {
        *v = new[u as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::levelset::surface;
    use crate::levelset::surface_divergence;
    use crate::mesh::{Diagonals, Point, box_mesh, rectangle};
    use nalgebra::SVector;

    fn amount<const D: usize>(space: &Space<D>, phi: &[f64], m: &[f64]) -> f64 {
        let at = |p: &SurfacePoint<D>| p.at.weight * space.value(m, p.at.cell, &p.at.barycentric);
        surface(space, phi).unwrap().iter().map(at).sum()
    }
    /// The density after `steps` steps of length `dt`; `phi(t)` is the level set at time `t`.
    fn follow<const D: usize>(
        space: &Arc<Space<D>>,
        u: &[SVector<f64, D>],
        (steps, dt): (usize, f64),
        phi: impl Fn(f64) -> Vec<f64>,
        m: &mut Vec<f64>,
    ) {
        let tracer = Tracer::new(space, &[]);
        let mut old = phi(0.0);
        let mut from: Arc<[_]> = surface(space, &old).unwrap().into();
        for k in 1..=steps {
            let new = phi(k as f64 * dt);
            let to: Arc<[_]> = surface(space, &new).unwrap().into();
            let carried = CarriedSurface::new(&tracer, (u, dt), (from, &old));
            *m = carried.onto(&to, &new).unwrap().density(m, true, |_, _| 0.0).unwrap();
            (from, old) = (to, new);
        }
    }
    fn plane(n: usize) -> Arc<Space<2>> {
        let mesh = rectangle([-1.0; 2], [1.0; 2], [n; 2], Diagonals::UnionJack).unwrap();
        Arc::new(Space::new(&Arc::new(mesh), Element::P2))
    }

    /// A circle of radius a that the flow (x, -y) draws out to an ellipse: the stretch is exact.
    #[test]
    fn the_stretch_of_a_drawn_circle_is_of_third_order() {
        let error = |n: usize| {
            let space = plane(n);
            let u = space.interpolate(|x| Point::<2>::new(x[0], -x[1]));
            let back = |x: &Point<2>, t: f64| Point::<2>::new(x[0] * (-t).exp(), x[1] * t.exp());
            let phi = |t: f64| space.interpolate(|x| back(x, t).norm() - 0.5);
            let mut m = vec![1.0; space.len()];
            let (steps, dt) = (n / 2, 0.6 / n as f64);
            let before = amount(&space, &phi(0.0), &m);
            follow(&space, &u, (steps, dt), phi, &mut m);
            let after = amount(&space, &phi(0.3), &m);
            assert!((after / before - 1.0).abs() < 1e-12, "{before} {after}");
            let points = surface(&space, &phi(0.3)).unwrap();
            let miss = |p: &SurfacePoint<2>| {
                let x = back(&p.at.x, 0.3) / 0.5;
                let stretch = (x[1] * 0.3f64.exp()).hypot(x[0] * (-0.3f64).exp());
                (space.value(&m, p.at.cell, &p.at.barycentric) * stretch - 1.0).abs()
            };
            points.iter().map(miss).fold(0.0, f64::max)
        };
        let errors = [12, 24, 48].map(error);
        assert!(errors[2] < 3e-4 && errors[1] / errors[2] > 6.0, "{errors:?}");
    }

    /// A density on a sphere that turns: no growth at its poles, where values interpolated at the
    /// nodes grow from the third turn on, and the amount stays. The midpoint rule lags behind by
    /// 1e-3 a step.
    #[test]
    fn a_density_on_a_turning_sphere_keeps_its_form_for_five_turns() {
        let mesh = box_mesh([-1.0; 3], [1.0; 3], [8; 3]).unwrap();
        let space = Arc::new(Space::new(&Arc::new(mesh), Element::P2));
        let u = space.interpolate(|x| Point::<3>::new(-x[1], x[0], 0.0));
        let phi = |_: f64| space.interpolate(|x| x.norm() - 0.7);
        let exact =
            |x: &Point<3>, t: f64| 1.0 + 0.5 * (x[0] * t.cos() + x[1] * t.sin()) + x[2] * x[0];
        let mut m = space.interpolate(|x| exact(x, 0.0));
        let before = amount(&space, &phi(0.0), &m);
        follow(&space, &u, (200, std::f64::consts::PI / 20.0), phi, &mut m);
        let after = amount(&space, &phi(0.0), &m);
        assert!((after / before - 1.0).abs() < 1e-12, "{before} {after}");
        let points = surface(&space, &phi(0.0)).unwrap();
        let miss = |p: &SurfacePoint<3>| {
            (space.value(&m, p.at.cell, &p.at.barycentric) - exact(&p.at.x, 0.0)).abs()
        };
        let worst = points.iter().map(miss).fold(0.0, f64::max);
        assert!(worst < 0.12, "{worst}");
    }

    /// The tension `2 + x` on a circle of radius .6: its tangential divergence is that of `x`.
    #[test]
    fn the_divergence_of_a_tension_is_its_gradient_along_the_interface() {
        let error = |n: usize| {
            let space = plane(n);
            let phi = space.interpolate(|x| x.norm() - 0.6);
            let points = surface(&space, &phi).unwrap();
            let own: Vec<u32> = (0..space.len() as u32).collect();
            let tension = |p: &SurfacePoint<2>| p.projection() * (2.0 + p.at.x[0]);
            let found =
                surface_divergence((&space, &own), (&points, &phi), tension, |_| 0.0).unwrap();
            let miss = |p: &SurfacePoint<2>| {
                let found = space.value(&found, p.at.cell, &p.at.barycentric);
                p.at.weight * (found - p.tangential(&Point::<2>::new(1.0, 0.0))).norm_squared()
            };
            points.iter().map(miss).sum::<f64>().sqrt()
        };
        let errors = [12, 24, 48].map(error);
        assert!(errors[2] < 0.02 && errors[0] / errors[2] > 4.0, "{errors:?}");
    }

    /// A level set that was moved off its interface is put back, and what it encloses with it.
    #[test]
    fn a_fit_puts_the_interface_back() {
        let space = plane(16);
        let phi = |shift: f64| space.interpolate(|x| x.norm() - 0.6 + shift * (3.0 * x[0]).sin());
        let tracer = Tracer::new(&space, &[]);
        let (u, old) = (vec![Point::<2>::zeros(); space.len()], phi(0.0));
        let from = surface(&space, &old).unwrap();
        let carried = CarriedSurface::new(&tracer, (&u, 1.0), (from.into(), &old));
        let mut moved = phi(0.004);
        let to = surface(&space, &moved).unwrap();
        carried.fit(&to, &mut moved).unwrap();
        let off = |p: &SurfacePoint<2>| (p.at.x.norm() - 0.6).abs();
        let off = surface(&space, &moved).unwrap().iter().map(off).fold(0.0, f64::max);
        assert!(off < 2e-4, "{off}");
    }
}
