//! Integrals over the boundary: force by the stress, flux, and energy carried out.

use super::step::FlowState;
use crate::base::Result;
use crate::fem::{Rule, Space};
use crate::mesh::{Facet, Location, Mesh, Point};
use nalgebra::{ArrayStorage, SVector};

/// Degree of the rule on facets.
const DEGREE: usize = 5;

/// Calls `f(facet, barycentric, weight * size)` at the quadrature points of facets.
pub(super) fn over_boundary<const D: usize>(
    mesh: &Mesh<D>,
    facets: &[u32],
    mut f: impl FnMut(&Facet, &[f64; 4], f64),
) {
    let rule = Rule::simplex(D - 1, DEGREE);
    for &k in facets {
        let facet = mesh.facets()[k as usize];
        let (_, size) = mesh.facet_normal(&facet);
        for (point, w) in rule.points.iter().zip(&rule.weights) {
            let mut l = [0.0; 4];
            let mut next = point.iter();
            for (i, v) in l.iter_mut().enumerate().take(D + 1) {
                if i as u32 != facet.opposite {
                    *v = *next.next().unwrap_or(&0.0);
                }
            }
            f(&facet, &l, w * size);
        }
    }
}

/// A force, and its moment about a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load<const D: usize> {
    /// The force.
    pub force: SVector<f64, D>,
    /// The moment; in the plane only the last component is not zero, counter-clockwise.
    pub moment: SVector<f64, 3>,
}

impl<const D: usize> Load<D> {
    /// No load.
    pub const ZERO: Load<D> = Load::of(0.0);
    /// An undefined load.
    pub const NAN: Load<D> = Load::of(f64::NAN);

    const fn of(v: f64) -> Load<D> {
        Load {
            force: SVector::<f64, D>::from_array_storage(ArrayStorage([[v; D]; 1])),
            moment: SVector::<f64, 3>::from_array_storage(ArrayStorage([[v; 3]; 1])),
        }
    }
    /// Adds a force that acts at a distance `arm` from the point.
    pub fn add(&mut self, arm: &SVector<f64, D>, force: &SVector<f64, D>) {
        let at =
            |v: &SVector<f64, D>| SVector::<f64, 3>::from_fn(|i, _| if i < D { v[i] } else { 0.0 });
        self.force += force;
        self.moment += at(arm).cross(&at(force));
    }
}

/// Force of the fluid on a boundary, `-int (2 mu D(u) - p) n ds` with `n` outward from the fluid,
/// and its moment about a point. `viscosity` gives `mu` in a cell at barycentric coordinates.
pub fn traction<const D: usize>(
    velocity: &Space<D>,
    pressure: &Space<D>,
    viscosity: impl Fn(usize, &[f64; 4]) -> f64,
    state: &FlowState<D>,
    name: &str,
    about: &Point<D>,
) -> Result<Load<D>> {
    let mesh = velocity.mesh();
    let mut load = Load::ZERO;
    over_boundary(mesh, mesh.boundary(name)?, |facet, l, w| {
        let force = stress_on(velocity, pressure, &viscosity, state, facet, l) * -w;
        let x = mesh.point_at(&Location { cell: facet.cell, barycentric: *l });
        load.add(&(x - about), &force);
    });
    Ok(load)
}

/// Integral of the size of the stress over a boundary, `int |(2 mu D(u) - p) n| ds`: what a force
/// on it is a difference of.
///
/// # Errors
/// A boundary that the mesh does not have.
pub fn stress_size<const D: usize>(
    [velocity, pressure]: [&Space<D>; 2],
    viscosity: impl Fn(usize, &[f64; 4]) -> f64,
    state: &FlowState<D>,
    name: &str,
) -> Result<f64> {
    let (mesh, mut sum) = (velocity.mesh(), 0.0);
    over_boundary(mesh, mesh.boundary(name)?, |facet, l, w| {
        sum += w * stress_on(velocity, pressure, &viscosity, state, facet, l).norm();
    });
    Ok(sum)
}

/// Forces that the fluid exerts on `facets`, `-int (2 mu D(u) - p) n N_a ds`, at those of their
/// nodes for which `at` is true: what a residual at a node that several boundaries share owes to
/// these facets. The list may name a node several times.
pub fn nodal_traction<const D: usize>(
    [velocity, pressure]: [&Space<D>; 2],
    viscosity: impl Fn(usize, &[f64; 4]) -> f64,
    state: &FlowState<D>,
    facets: &[u32],
    at: impl Fn(u32) -> bool,
) -> Vec<(u32, SVector<f64, D>)> {
    let mut loads = Vec::new();
    over_boundary(velocity.mesh(), facets, |facet, l, w| {
        let c = facet.cell as usize;
        let force = stress_on(velocity, pressure, &viscosity, state, facet, l) * -w;
        let shapes = velocity.element().values::<D>(l);
        let shared = velocity.cell_nodes(c).iter().zip(shapes).filter(|(n, _)| at(**n));
        loads.extend(shared.map(|(&n, shape)| (n, force * shape)));
    });
    loads
}

/// `(2 mu D(u) - p) n` at a point of a facet, with `n` outward from the fluid.
fn stress_on<const D: usize>(
    velocity: &Space<D>,
    pressure: &Space<D>,
    viscosity: &impl Fn(usize, &[f64; 4]) -> f64,
    state: &FlowState<D>,
    facet: &Facet,
    l: &[f64; 4],
) -> SVector<f64, D> {
    let c = facet.cell as usize;
    let (n, _) = velocity.mesh().facet_normal(facet);
    let grad = velocity.jacobian(&state.u, c, l);
    (grad + grad.transpose()) * n * viscosity(c, l) - n * pressure.value(&state.p, c, l)
}

/// Rate of outflow of kinetic energy through the boundary, `int rho |u|^2 / 2 u . n ds`. `density`
/// gives `rho` in a cell at barycentric coordinates.
pub fn kinetic_outflow<const D: usize>(
    velocity: &Space<D>,
    density: impl Fn(usize, &[f64; 4]) -> f64,
    state: &FlowState<D>,
) -> f64 {
    let mesh = velocity.mesh();
    let all: Vec<u32> = (0..mesh.facets().len() as u32).collect();
    let mut sum = 0.0;
    over_boundary(mesh, &all, |facet, l, w| {
        let (n, _) = mesh.facet_normal(facet);
        let u = velocity.value(&state.u, facet.cell as usize, l);
        sum += 0.5 * w * density(facet.cell as usize, l) * u.norm_squared() * u.dot(&n);
    });
    sum
}

/// Volume flux through a boundary, `int u . n ds`, positive outward.
pub fn flux<const D: usize>(velocity: &Space<D>, state: &FlowState<D>, name: &str) -> Result<f64> {
    let mesh = velocity.mesh();
    let mut sum = 0.0;
    over_boundary(mesh, mesh.boundary(name)?, |facet, l, w| {
        let (n, _) = mesh.facet_normal(facet);
        sum += w * velocity.value(&state.u, facet.cell as usize, l).dot(&n);
    });
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::Element;
    use crate::mesh::{Diagonals, rectangle};
    use std::sync::Arc;

    type V = SVector<f64, 2>;

    /// The flow `u = (y, 0)`, `p = x` in `(0, 2) x (0, 1)`.
    fn shear() -> (Space<2>, Space<2>, FlowState<2>) {
        let mesh = Arc::new(rectangle([0.0; 2], [2.0, 1.0], [3, 2], Diagonals::Right).unwrap());
        let [velocity, pressure] = [Element::P2, Element::P1].map(|e| Space::new(&mesh, e));
        let u = velocity.interpolate(|x| V::new(x[1], 0.0));
        let p = pressure.interpolate(|x| x[0]);
        (velocity, pressure, FlowState { u, p })
    }

    #[test]
    fn a_shear_flow_pulls_at_its_walls_along_and_the_pressure_across_them() {
        let (velocity, pressure, state) = shear();
        let viscosity = 0.5;
        let load = |name, about| {
            traction(&velocity, &pressure, |_, _| viscosity, &state, name, &about).unwrap()
        };
        // On the top -(2 mu D(u) - p) n = (-mu, x), with the moment int (x x - y (-mu)) ds.
        let top = load("top", V::zeros());
        assert!((top.force - V::new(-1.0, 2.0)).norm() < 1e-13, "{top:?}");
        assert!((top.moment[2] - (8.0 / 3.0 + 1.0)).abs() < 1e-13 && top.moment[0] == 0.0);
        // About another point the moment changes by the arm times the force.
        let arm = V::new(0.3, -0.2);
        let moved = load("top", arm);
        let change = arm[0] * top.force[1] - arm[1] * top.force[0];
        assert!((top.moment[2] - change - moved.moment[2]).abs() < 1e-13);
        // On the right (p, -mu) with p = 2.
        assert!((load("right", V::zeros()).force - V::new(2.0, -0.5)).norm() < 1e-13);
        assert!(
            traction(&velocity, &pressure, |_, _| 1.0, &state, "lid", &V::zeros()).is_err(),
            "a boundary that the mesh has not"
        );
    }

    #[test]
    fn fluxes_and_the_energy_that_flows_out_are_integrals_over_the_sides() {
        let (velocity, _, state) = shear();
        let through = |name| flux(&velocity, &state, name).unwrap();
        assert!((through("right") - 0.5).abs() < 1e-14 && (through("left") + 0.5).abs() < 1e-14);
        assert!(through("top").abs() < 1e-15);
        // rho = 1 on the left half, 3 on the right: int rho y^3/2 = rho/8, outward less inward.
        let mesh = velocity.mesh();
        let density = |c: usize, l: &[f64; 4]| {
            let x = mesh.point_at(&Location { cell: c as u32, barycentric: *l });
            if x[0] < 1.0 { 1.0 } else { 3.0 }
        };
        assert!((kinetic_outflow(&velocity, density, &state) - 2.0 / 8.0).abs() < 1e-14);
    }
}
