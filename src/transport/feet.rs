//! Feet of characteristics: departure points of particles.

use super::drift::Drifts;
use super::passage::Passage;
use crate::base::parallel;
use crate::fem::{Basis, Numbering, OnCell, Space, Translation, VelocityFunction};
use crate::mesh::{Location, Locator, NONE, Point};
use nalgebra::SVector;
use std::sync::{Arc, Mutex, OnceLock};

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
    /// The mesh with its periodic sides.
    passage: Passage<D>,
    /// One number per node, equal for nodes that periodic sides identify.
    unknowns: Vec<u32>,
    /// The shortest diameter of a cell.
    finest: f64,
    /// Finds cells where a straight walk is not possible; built at first use.
    locator: OnceLock<Locator<D>>,
    /// Memory for the drifts of all cells, kept from one call to the next.
    drifts: Arc<Mutex<Drifts<D>>>,
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
        let finest = (0..mesh.cell_count()).map(|c| mesh.diameter(c)).fold(f64::INFINITY, f64::min);
        Tracer {
            space: Arc::clone(space),
            node_locations,
            passage: Passage::new(mesh, translations),
            unknowns: Numbering::scalar_unknowns(space, translations).0,
            finest,
            locator: OnceLock::new(),
            drifts: Arc::default(),
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
        self.passage.beyond(cell, k)
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
        let drifts = self.drifts(advecting, -dt, steps);
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
                    AdvectingVelocity::Nodal(_) => {
                        for (q, foot) in feet.iter_mut().enumerate() {
                            *foot = drifts.end(&self.passage, steps, start(q)).0;
                        }
                    }
                    AdvectingVelocity::Given { velocity, arrival, .. } => {
                        for (q, foot) in feet.iter_mut().enumerate() {
                            *foot = self.given_foot(velocity, *arrival, dt, steps, start(q));
                        }
                    }
                }
            }
        });
        self.keep(drifts);
    }
    /// [`from_nodes`](Self::from_nodes) with any velocity.
    pub fn feet_of_nodes(&self, advecting: &AdvectingVelocity<'_, D>, dt: f64, feet: &mut Feet) {
        feet.0.resize(self.space.len(), Location { cell: NONE, barycentric: [0.0; 4] });
        let steps = self.steps(advecting, dt);
        let drifts = self.drifts(advecting, -dt, steps);
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
                    (start, AdvectingVelocity::Nodal(_)) => {
                        drifts.end(&self.passage, steps, start).0
                    }
                    (start, AdvectingVelocity::Given { velocity, arrival, .. }) => {
                        self.given_foot(velocity, *arrival, dt, steps, start)
                    }
                };
            }
        });
        self.keep(drifts);
    }
    /// The drifts in a substep, if there are several, in the memory of those before.
    fn drifts(&self, advecting: &AdvectingVelocity<'_, D>, dt: f64, steps: usize) -> Drifts<D> {
        let mut drifts =
            self.drifts.lock().map(|mut d| std::mem::take(&mut *d)).unwrap_or_default();
        match advecting {
            AdvectingVelocity::Nodal(u) if steps > 1 => {
                drifts.compute(&self.space, u, dt / steps as f64);
            }
            _ => {}
        }
        drifts
    }
    /// Keeps the memory of drifts for the next call.
    fn keep(&self, drifts: Drifts<D>) {
        if let Ok(mut kept) = self.drifts.lock() {
            *kept = drifts;
        }
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
    fn given_foot(
        &self,
        velocity: &VelocityFunction<D>,
        arrival: f64,
        dt: f64,
        steps: usize,
        start: Location,
    ) -> Location {
        let from = self.space.mesh().point_at(&start);
        let x = path(velocity, from, arrival, -dt, steps);
        self.displaced(start, x - from)
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
            None => self.velocity(u, &self.passage.travel(start, -w * (0.5 * dt)).0),
        };
        match map.moved(&start.barycentric, &(w * -dt)) {
            Some(barycentric) => Location { cell: start.cell, barycentric },
            None => self.passage.travel(start, -w * dt).0,
        }
    }
    /// Where the particle at `start` is after one midpoint step, and false if it leaves the domain
    /// there.
    fn end_of_short_step(
        &self,
        u: &[SVector<f64, D>],
        dt: f64,
        start: Location,
    ) -> (Location, bool) {
        let (middle, _) = self.passage.travel(start, self.velocity(u, &start) * (0.5 * dt));
        self.passage.travel(start, self.velocity(u, &middle) * dt)
    }
    /// Where the particle at `start` is after the step, and true if it does not leave the domain.
    pub fn ahead(
        &self,
        advecting: &AdvectingVelocity<'_, D>,
        dt: f64,
        starts: &[Location],
    ) -> Vec<(Location, bool)> {
        let steps = self.steps(advecting, dt);
        let drifts = self.drifts(advecting, dt, steps);
        let mut ends = vec![(Location { cell: NONE, barycentric: [0.0; 4] }, false); starts.len()];
        parallel::fill(&mut ends, 1, |first, part| {
            for (i, end) in part.iter_mut().enumerate() {
                *end = match advecting {
                    AdvectingVelocity::Nodal(u) if steps == 1 => {
                        self.end_of_short_step(u, dt, starts[first + i])
                    }
                    AdvectingVelocity::Nodal(_) => {
                        drifts.end(&self.passage, steps, starts[first + i])
                    }
                    AdvectingVelocity::Given { velocity, arrival, .. } => {
                        let from = self.space.mesh().point_at(&starts[first + i]);
                        let step = path(velocity, from, arrival - dt, dt, steps) - from;
                        self.passage.travel(starts[first + i], step)
                    }
                };
            }
        });
        self.keep(drifts);
        ends
    }
    /// End of a straight step of any length. A target in the domain is found even if the segment
    /// leaves the domain (around an obstacle); a target outside is replaced by the point where the
    /// segment leaves the domain.
    pub fn displaced(&self, from: Location, step: SVector<f64, D>) -> Location {
        let (end, inside) = self.passage.travel(from, step);
        if inside || self.passage.has_periodic_sides() {
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
    pub fn unwrapped(&self, step: SVector<f64, D>) -> SVector<f64, D> {
        self.passage.unwrapped(step)
    }
    #[inline]
    fn velocity(&self, u: &[SVector<f64, D>], at: &Location) -> SVector<f64, D> {
        self.space.value(u, at.cell as usize, &at.barycentric)
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
#[path = "feet_tests.rs"]
mod tests;
