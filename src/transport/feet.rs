//! Feet of characteristics: departure points of particles.

use crate::base::parallel;
use crate::fem::{Basis, Numbering, OnCell, Space, Translation, VelocityFunction};
use crate::mesh::{Location, Locator, NONE, Point};
use nalgebra::SVector;
use std::sync::{Arc, OnceLock};

/// Largest number of periodic sides that one displacement crosses.
const MOST_CROSSINGS: usize = 64;

/// Feet of a list of characteristics, in the order of their arrival points.
#[derive(Clone, Debug, Default)]
pub struct Feet(Vec<Location>);

impl Feet {
    /// Feet given by their locations.
    pub fn new(feet: Vec<Location>) -> Feet {
        Feet(feet)
    }
    /// Number of feet.
    pub fn len(&self) -> usize {
        self.0.len()
    }
    /// True if there are no feet.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
    /// Foot number `i`.
    #[inline]
    pub fn get(&self, i: usize) -> &Location {
        &self.0[i]
    }
}

/// The velocity of a transport equation.
pub enum AdvectingVelocity<'a, const D: usize> {
    /// A P2 function (one vector per node), constant over the step. Integrated with the midpoint
    /// rule, in as many substeps as keep the Courant number of each below 1, at most 100.
    Nodal(&'a [SVector<f64, D>]),
    /// A function of position and time. Integrated with the classical Runge-Kutta rule of order 4,
    /// in as many substeps as keep the Courant number of each below 2, at most 100.
    Given {
        /// The velocity.
        velocity: &'a VelocityFunction<D>,
        /// The time at which the characteristics arrive.
        arrival: f64,
        /// The largest Courant number of the step.
        courant: f64,
    },
}

/// Traces characteristics back in time.
///
/// A characteristic that leaves the domain ends on the boundary, with the value of the old time
/// there; through a periodic side it continues at the other one.
///
/// Limits: values at an inflow that change in time are of first order in time. On a curved wall
/// that moves along itself the feet of wall vertices lie outside the polygon, so that a field
/// carried to the nodes does not change there.
#[derive(Clone, Debug)]
pub struct Tracer<const D: usize> {
    space: Arc<Space<D>>,
    /// A cell of every node with the barycentric coordinates of the node; `cell` is [`NONE`] for
    /// nodes of no cell.
    node_locations: Vec<Location>,
    /// For every facet (cell, opposite vertex) on a periodic side: the cell on the other side and
    /// the translation. Sorted by facet.
    periodic_links: Vec<(u32, u32, SVector<f64, D>)>,
    /// The different translations.
    shifts: Vec<SVector<f64, D>>,
    /// One number per node, equal for nodes that periodic sides identify.
    unknowns: Vec<u32>,
    /// The shortest diameter of a cell.
    finest: f64,
    /// Finds cells where a straight walk is not possible; built at first use.
    locator: OnceLock<Locator<D>>,
}

impl<const D: usize> Tracer<D> {
    /// A tracer for velocities of `space`.
    pub fn new(space: &Arc<Space<D>>, translations: &[Translation<D>]) -> Tracer<D> {
        let mesh = space.mesh();
        let mut node_locations = vec![Location { cell: NONE, barycentric: [0.0; 4] }; space.len()];
        for c in 0..mesh.cell_count() {
            for (a, &n) in space.cell_nodes(c).iter().enumerate() {
                if node_locations[n as usize].cell == NONE {
                    node_locations[n as usize] =
                        Location { cell: c as u32, barycentric: space.element().node(a, D) };
                }
            }
        }
        let mut periodic_links: Vec<_> = translations
            .iter()
            .map(|t| {
                let (mine, theirs) =
                    (mesh.facets()[t.facet as usize], mesh.facets()[t.partner as usize]);
                (mine.cell * (D as u32 + 1) + mine.opposite, theirs.cell, t.shift)
            })
            .collect();
        periodic_links.sort_by_key(|d| d.0);
        periodic_links.dedup_by_key(|d| d.0);
        let mut shifts: Vec<SVector<f64, D>> = Vec::new();
        for (_, _, shift) in &periodic_links {
            if shifts.iter().all(|s| (s - shift).norm() > 1e-6 * shift.norm()) {
                shifts.push(*shift);
            }
        }
        let finest = (0..mesh.cell_count()).map(|c| mesh.diameter(c)).fold(f64::INFINITY, f64::min);
        Tracer {
            space: Arc::clone(space),
            node_locations,
            periodic_links,
            shifts,
            unknowns: Numbering::scalar_unknowns(space, translations).0,
            finest,
            locator: OnceLock::new(),
        }
    }
    /// The space of the velocities.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }
    /// One number per node, equal for nodes that periodic sides identify; [`NONE`] for nodes of no
    /// cell.
    pub fn unknowns(&self) -> &[u32] {
        &self.unknowns
    }
    /// The cell beyond facet `k` of a cell, also through a periodic side, with the translation to
    /// its points; `None` on other boundaries.
    pub fn beyond(&self, cell: u32, k: usize) -> Option<(u32, SVector<f64, D>)> {
        match self.space.mesh().neighbours(cell as usize)[k] {
            NONE => {
                let facet = cell * (D as u32 + 1) + k as u32;
                let found = self.periodic_links.binary_search_by_key(&facet, |d| d.0).ok()?;
                let (_, partner, shift) = self.periodic_links[found];
                Some((partner, shift))
            }
            next => Some((next, SVector::zeros())),
        }
    }
    /// A cell of node `n` and its barycentric coordinates there; any location for a node of no
    /// cell.
    pub fn node_location(&self, n: usize) -> Location {
        match self.node_locations[n] {
            Location { cell: NONE, .. } => Location { cell: 0, barycentric: [1.0, 0.0, 0.0, 0.0] },
            location => location,
        }
    }
    /// Largest `|u| dt / h` over the nodes of all cells, with `h` the longest edge of the cell.
    pub fn courant(&self, u: &[SVector<f64, D>], dt: f64) -> f64 {
        let mesh = self.space.mesh();
        (0..mesh.cell_count())
            .map(|c| {
                let nodes = self.space.cell_nodes(c).iter();
                nodes.map(|&n| u[n as usize].norm_squared()).fold(0.0, f64::max).sqrt() * dt
                    / mesh.diameter(c)
            })
            .fold(0.0, f64::max)
    }
    /// Feet at `t - dt` of the characteristics through the quadrature points of `basis` at `t`:
    /// point `q` of cell `c` has number `c * points + q`.
    pub fn from_quadrature(
        &self,
        u: &[SVector<f64, D>],
        dt: f64,
        basis: &Basis<D>,
        feet: &mut Feet,
    ) {
        self.feet_of_quadrature(&AdvectingVelocity::Nodal(u), dt, basis, feet);
    }
    /// Feet at `t - dt` of the characteristics through the nodes of the space at `t`.
    pub fn from_nodes(&self, u: &[SVector<f64, D>], dt: f64, feet: &mut Feet) {
        self.feet_of_nodes(&AdvectingVelocity::Nodal(u), dt, feet);
    }
    /// [`from_quadrature`](Self::from_quadrature) with any velocity.
    pub fn feet_of_quadrature(
        &self,
        advecting: &AdvectingVelocity<'_, D>,
        dt: f64,
        basis: &Basis<D>,
        feet: &mut Feet,
    ) {
        let points = basis.rule().len();
        let count = self.space.mesh().cell_count() * points;
        feet.0.resize(count, Location { cell: NONE, barycentric: [0.0; 4] });
        let steps = self.steps(advecting, dt);
        parallel::fill(&mut feet.0, points, |first, part| {
            for (i, feet) in part.chunks_exact_mut(points).enumerate() {
                let c = first + i;
                let start =
                    |q: usize| Location { cell: c as u32, barycentric: basis.rule().points[q] };
                match advecting {
                    AdvectingVelocity::Nodal(u) if steps == 1 => {
                        let own = self.space.on_cell(u, c);
                        for (q, foot) in feet.iter_mut().enumerate() {
                            *foot = self.foot_of_short_step(
                                u,
                                dt,
                                &own,
                                own.combined(basis.values(q)),
                                start(q),
                            );
                        }
                    }
                    _ => feet
                        .iter_mut()
                        .enumerate()
                        .for_each(|(q, foot)| *foot = self.foot(advecting, dt, steps, start(q))),
                }
            }
        });
    }
    /// [`from_nodes`](Self::from_nodes) with any velocity.
    pub fn feet_of_nodes(&self, advecting: &AdvectingVelocity<'_, D>, dt: f64, feet: &mut Feet) {
        feet.0.resize(self.space.len(), Location { cell: NONE, barycentric: [0.0; 4] });
        let steps = self.steps(advecting, dt);
        parallel::fill(&mut feet.0, 1, |first, part| {
            for (i, foot) in part.iter_mut().enumerate() {
                let n = first + i;
                *foot = match (self.node_locations[n], advecting) {
                    // A point of no cell carries nothing; any location will do.
                    (Location { cell: NONE, .. }, _) => self.node_location(n),
                    (start, AdvectingVelocity::Nodal(u)) if steps == 1 => {
                        let own = self.space.on_cell(u, start.cell as usize);
                        self.foot_of_short_step(u, dt, &own, u[n], start)
                    }
                    (start, _) => self.foot(advecting, dt, steps, start),
                };
            }
        });
    }
    /// Number of substeps, at most 100, so that a diverging velocity does not stop the program.
    fn steps(&self, advecting: &AdvectingVelocity<'_, D>, dt: f64) -> usize {
        let courant = match advecting {
            // An inexpensive bound, sufficient in most steps.
            AdvectingVelocity::Nodal(u) => {
                let fastest = u.iter().map(|v| v.norm_squared()).fold(0.0, f64::max).sqrt();
                if fastest * dt <= self.finest { 1.0 } else { self.courant(u, dt) }
            }
            AdvectingVelocity::Given { courant, .. } => 0.5 * courant,
        };
        (courant.ceil() as usize).clamp(1, 100)
    }
    fn foot(
        &self,
        advecting: &AdvectingVelocity<'_, D>,
        dt: f64,
        steps: usize,
        start: Location,
    ) -> Location {
        match advecting {
            AdvectingVelocity::Nodal(u) => self.end(u, dt, steps, start).0,
            AdvectingVelocity::Given { velocity, arrival, .. } => {
                let from = self.space.mesh().point_at(&start);
                let x = path(velocity, from, *arrival, -dt, steps);
                self.displaced(start, x - from)
            }
        }
    }
    /// One midpoint step from `start`, where the velocity is `w`; `own` is the velocity on that
    /// cell, which the characteristic rarely leaves.
    #[inline]
    fn foot_of_short_step(
        &self,
        u: &[SVector<f64, D>],
        dt: f64,
        own: &OnCell<SVector<f64, D>, D>,
        w: SVector<f64, D>,
        start: Location,
    ) -> Location {
        let map = self.space.mesh().map(start.cell as usize);
        let w = match map.moved(&start.barycentric, &(w * (-0.5 * dt))) {
            Some(middle) => own.value(&middle),
            None => self.velocity(u, &self.travel(start, -w * (0.5 * dt)).0),
        };
        match map.moved(&start.barycentric, &(w * -dt)) {
            Some(barycentric) => Location { cell: start.cell, barycentric },
            None => self.travel(start, -w * dt).0,
        }
    }
    /// The place a time `dt` earlier (later if `dt < 0`) of the particle at `start`, and false if
    /// the path leaves the domain, at that place.
    fn end(
        &self,
        u: &[SVector<f64, D>],
        dt: f64,
        steps: usize,
        start: Location,
    ) -> (Location, bool) {
        let tau = dt / steps as f64;
        let mut here = start;
        for _ in 0..steps {
            let w = self.velocity(u, &here);
            let (middle, _) = self.travel(here, -w * (0.5 * tau));
            let w = self.velocity(u, &middle);
            let (next, inside) = self.travel(here, -w * tau);
            here = next;
            if !inside {
                return (here, false);
            }
        }
        (here, true)
    }
    /// Where the particle at `start` is after the step, and true if it does not leave the domain.
    pub fn ahead(
        &self,
        advecting: &AdvectingVelocity<'_, D>,
        dt: f64,
        starts: &[Location],
    ) -> Vec<(Location, bool)> {
        let steps = self.steps(advecting, dt);
        let mut ends = vec![(Location { cell: NONE, barycentric: [0.0; 4] }, false); starts.len()];
        parallel::fill(&mut ends, 1, |first, part| {
            for (i, end) in part.iter_mut().enumerate() {
                *end = match advecting {
                    AdvectingVelocity::Nodal(u) => self.end(u, -dt, steps, starts[first + i]),
                    AdvectingVelocity::Given { velocity, arrival, .. } => {
                        let from = self.space.mesh().point_at(&starts[first + i]);
                        let step = path(velocity, from, arrival - dt, dt, steps) - from;
                        self.travel(starts[first + i], step)
                    }
                };
            }
        });
        ends
    }
    /// End of a straight step of any length. A target in the domain is found even if the segment
    /// leaves the domain (around an obstacle); a target outside is replaced by the point where the
    /// segment leaves the domain.
    pub fn displaced(&self, from: Location, step: SVector<f64, D>) -> Location {
        let (end, inside) = self.travel(from, step);
        if inside || !self.periodic_links.is_empty() {
            return end;
        }
        let target = self.space.mesh().point_at(&from) + step;
        self.locate(&target).unwrap_or(end)
    }
    /// The location of a point, or `None` outside of the mesh.
    pub fn locate(&self, x: &Point<D>) -> Option<Location> {
        let mesh = self.space.mesh();
        self.locator.get_or_init(|| Locator::new(mesh)).locate(mesh, x)
    }
    /// The shortest periodic image of a displacement that is shorter than half a period.
    pub fn unwrapped(&self, mut step: SVector<f64, D>) -> SVector<f64, D> {
        // One pair of sides after the other; a corner needs one of each.
        for _ in 0..D {
            let images = self.shifts.iter().map(|shift| step - shift);
            step = images.fold(
                step,
                |best, s| if s.norm_squared() < best.norm_squared() { s } else { best },
            );
        }
        step
    }
    #[inline]
    fn velocity(&self, u: &[SVector<f64, D>], at: &Location) -> SVector<f64, D> {
        self.space.value(u, at.cell as usize, &at.barycentric)
    }
    /// Moves by `step`, through periodic sides. Returns the end, and false if the step leaves the
    /// domain.
    fn travel(&self, from: Location, step: SVector<f64, D>) -> (Location, bool) {
        let mesh = self.space.mesh();
        let (mut cell, mut x) = (from.cell, mesh.point_at(&from));
        let mut target: Point<D> = x + step;
        // More periodic sides than a particle can cross in a step, or in the time of a submap.
        for _ in 0..MOST_CROSSINGS {
            let (end, inside) = mesh.walk(cell, &x, &target);
            if inside || self.periodic_links.is_empty() {
                return (end, inside);
            }
            let facets = (0..=D as u32)
                .filter(|&k| end.barycentric[k as usize] <= 1e-9)
                .map(|k| end.cell * (D as u32 + 1) + k);
            let link = facets
                .filter_map(|s| self.periodic_links.binary_search_by_key(&s, |d| d.0).ok())
                .map(|i| &self.periodic_links[i])
                .find(|d| d.2.dot(&(target - x)) < 0.0);
            let Some(&(_, partner, shift)) = link else { return (end, false) };
            x = mesh.point_at(&end) + shift;
            target += shift;
            cell = partner;
        }
        mesh.walk(cell, &x, &target)
    }
}

/// Position at `t + dt` of the particle at `x` at time `t` (`dt` may be negative), by `steps` steps
/// of the classical Runge-Kutta rule of order 4.
pub fn path<const D: usize>(
    velocity: &VelocityFunction<D>,
    mut x: Point<D>,
    t: f64,
    dt: f64,
    steps: usize,
) -> Point<D> {
    let tau = dt / steps as f64;
    for k in 0..steps {
        let t = t + k as f64 * tau;
        let a = velocity(&x, t);
        let b = velocity(&(x + a * (0.5 * tau)), t + 0.5 * tau);
        let c = velocity(&(x + b * (0.5 * tau)), t + 0.5 * tau);
        let d = velocity(&(x + c * tau), t + tau);
        x += (a + b * 2.0 + c * 2.0 + d) * (tau / 6.0);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::{Element, Rule};
    use crate::mesh::{Diagonals, rectangle};

    /// Solid rotation: the exact foot is a rotation; the midpoint rule is of third order in one
    /// step.
    #[test]
    fn feet_of_a_rotation_converge_with_order_three() {
        let mesh = Arc::new(rectangle([-1.0, -1.0], [1.0, 1.0], [8, 8], Diagonals::Right).unwrap());
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let u = space.interpolate(|x| Point::<2>::new(-x[1], x[0]));
        let basis = Basis::new(&space, &Arc::new(Rule::simplex(2, 5)));
        let tracer = Tracer::new(&space, &[]);
        let error = |dt: f64| {
            let mut feet = Feet::default();
            tracer.from_quadrature(&u, dt, &basis, &mut feet);
            let mut worst: f64 = 0.0;
            for c in 0..mesh.cell_count() {
                for q in 0..7 {
                    let x = basis.at(c, q).x;
                    if x.norm() < 0.9 {
                        let exact = Point::<2>::new(
                            x[0] * dt.cos() + x[1] * dt.sin(),
                            x[1] * dt.cos() - x[0] * dt.sin(),
                        );
                        worst = worst.max((mesh.point_at(feet.get(c * 7 + q)) - exact).norm());
                    }
                }
            }
            worst
        };
        let order = (error(0.04) / error(0.02)).log2();
        assert!((order - 3.0).abs() < 0.1, "order {order}");
        assert!(error(0.04) < 2e-5);
    }

    /// A uniform velocity moves a quadratic function without error, in both methods of transport,
    /// whatever the Courant number; at the inflow the value of the boundary is taken.
    #[test]
    fn a_uniform_velocity_translates_a_quadratic_function_exactly() {
        let mesh =
            Arc::new(rectangle([0.0; 2], [4.0, 1.0], [16, 4], Diagonals::UnionJack).unwrap());
        let space = Arc::new(Space::new(&mesh, Element::P2));
        let (w, dt) = (Point::<2>::new(1.0, 0.0), 0.7);
        let u = vec![w; space.len()];
        let tracer = Tracer::new(&space, &[]);
        assert!(tracer.courant(&u, dt) > 1.9, "{}", tracer.courant(&u, dt));
        let f = |x: &Point<2>| x[0] * x[0] - 3.0 * x[0] * x[1] + 0.5;
        let old = space.interpolate(f);
        let mut feet = Feet::default();
        tracer.from_nodes(&u, dt, &mut feet);
        let mut new = vec![0.0; space.len()];
        crate::transport::carry_nodal(&space, &old, &feet, &mut new);
        for (x, v) in space.nodes().iter().zip(&new) {
            let from = Point::<2>::new((x[0] - dt).max(0.0), x[1]);
            assert!((v - f(&from)).abs() < 1e-12, "{x} {v}");
        }
    }

    /// The classical Runge-Kutta rule along a given velocity: fifth order in one step, in time too.
    #[test]
    fn paths_of_a_given_velocity_are_of_fourth_order() {
        // The solution of x' = (t x, 1) from (1, 0) at t = 0 is (exp(t^2/2), t).
        let velocity: VelocityFunction<2> =
            Arc::new(|x: &Point<2>, t: f64| Point::<2>::new(t * x[0], 1.0));
        let error = |steps| {
            let end = path(&velocity, Point::<2>::new(1.0, 0.0), 0.0, 1.0, steps);
            (end - Point::<2>::new(0.5f64.exp(), 1.0)).norm()
        };
        let order = (error(8) / error(16)).log2();
        assert!((order - 4.0).abs() < 0.15 && error(16) < 1e-6, "{order} {:e}", error(16));
    }
}
